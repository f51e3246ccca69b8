//! The certificate: values by their path, the plan, and the claims that need no reading of the program: sizes and hashes.

use super::maths::{V, unit};
use super::opinion::Check;
use serde_json::Value;
use sha2::{Digest, Sha256};

fn read<'a, T>(value: &'a Value, path: &str, what: &str, of: impl Fn(&'a Value) -> Option<T>) -> Result<T, String> {
    let missing = || format!("the certificate has no {}", path.trim_start_matches('/').replace('/', "."));
    of(value.pointer(path).ok_or_else(missing)?).ok_or_else(|| format!("{path} is not {what}"))
}

pub fn at<'a>(value: &'a Value, path: &str) -> Result<&'a Value, String> {
    read(value, path, "there", Some)
}

pub fn number(value: &Value, path: &str) -> Result<f64, String> {
    read(value, path, "a number", Value::as_f64)
}

pub fn whole(value: &Value, path: &str) -> Result<usize, String> {
    read(value, path, "a whole number", |n| Some(n.as_u64()? as usize))
}

pub fn text<'a>(value: &'a Value, path: &str) -> Result<&'a str, String> {
    read(value, path, "a text", Value::as_str)
}

pub fn list<'a>(value: &'a Value, path: &str) -> Result<&'a Vec<Value>, String> {
    read(value, path, "a list", Value::as_array)
}

pub fn numbers<const N: usize>(value: &Value, path: &str) -> Result<[f64; N], String> {
    let found: Option<Vec<f64>> = list(value, path)?.iter().map(Value::as_f64).collect();
    found.and_then(|found| found.try_into().ok()).ok_or_else(|| format!("{path} must be {N} numbers"))
}

pub fn optional(value: &Value, path: &str) -> Option<f64> {
    value.pointer(path)?.as_f64()
}

pub fn optional_text<'a>(value: &'a Value, path: &str) -> Option<&'a str> {
    value.pointer(path)?.as_str()
}

/// One print of the plan.
pub struct Print {
    pub part: usize,
    pub slot: usize,
    pub up: V,
    pub words: [f64; 2],
    /// Air between supports and what lies on them, mm; none where there are no supports.
    pub gap: Option<f64>,
}

/// The plan: prints in their order, and where the model is.
pub struct Plan {
    pub prints: Vec<Print>,
    pub parts: usize,
    pub origin: V,
    pub turn: f64,
    pub unit: f64,
    pub bridge: Option<f64>,
}

impl Plan {
    pub fn read(document: &Value) -> Result<Self, String> {
        let mut prints = Vec::new();
        for slot in list(document, "/slots")? {
            for print in list(slot, "/prints")? {
                prints.push(Print {
                    part: whole(print, "/part")?,
                    slot: whole(slot, "/id")?,
                    up: unit(numbers(print, "/up")?),
                    words: [number(print, "/tilt_deg")?, number(print, "/rotation_deg")?],
                    gap: optional(print, "/supports/gap_mm"),
                });
            }
        }
        let named = text(document, "/model/unit")?;
        let units = [("um", 1e-3), ("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("ft", 304.8), ("m", 1000.0)];
        let unknown = || format!("the plan's unit {named} is unknown");
        let (_, unit) = units.into_iter().find(|(name, _)| *name == named).ok_or_else(unknown)?;
        Ok(Self {
            prints,
            parts: list(document, "/parts")?.len(),
            origin: numbers(document, "/placement/origin_mm")?,
            turn: number(document, "/placement/turn_deg")?,
            unit,
            bridge: optional(document, "/bridge_mm"),
        })
    }

    /// The plan's print of a number in the file; what is numbered beyond them are supports.
    pub fn print(&self, number: usize) -> Option<&Print> {
        self.prints.get(number)
    }
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The claims that need no reading of the program.
pub fn check_claims(program: &[u8], certificate: &Value, model: Option<&[u8]>) -> Result<Vec<Check>, String> {
    let (mut hashes, mut claims) = (Check::new("hashes"), Check::new("claims"));
    if text(certificate, "/format")? != "trunnion-certificate" || whole(certificate, "/version")? != 1 {
        return Err("this is not a trunnion-certificate of version 1".to_owned());
    }
    let bytes = whole(certificate, "/program/bytes")?;
    hashes.require(bytes == program.len(), || format!("{} bytes, certified {bytes}", program.len()));
    hashes.require(text(certificate, "/program/sha256")? == sha256(program), || "the program's differs");
    let certified = text(certificate, "/model/sha256")?;
    hashes.require(model.is_none_or(|model| sha256(model) == certified), || "the model's differs");
    hashes.figure = format!("{bytes} bytes{}", if model.is_some() { ", and the model" } else { "" });
    let planned = text(certificate, "/plan/document/model/sha256")?;
    claims.require(planned == certified, || "the plan is of another model");
    let machine = text(certificate, "/plan/document/machine/sha256")?;
    claims.require(text(certificate, "/machine/sha256")? == machine, || "the plan is of another machine");
    let [plan, values, rules] = ["/plan/document", "/machine/values", "/rules"].map(|path| at(certificate, path));
    for (path, document, name) in [
        ("/plan/sha256", format!("{:#}\n", plan?), "the plan's"),
        ("/machine/sha256", values?.to_string(), "machine/sha256"),
        ("/rules_sha256", rules?.to_string(), "rules_sha256"),
    ] {
        claims.require(text(certificate, path)? == sha256(document.as_bytes()), || format!("{name} differs"));
    }
    claims.figure = format!("{} rules", list(certificate, "/rules")?.len());
    Ok(vec![hashes, claims])
}
