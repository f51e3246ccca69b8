//! The certificate of a program: what was proved of it, with all that is needed to replay it elsewhere.

use serde_json::{Value, json};

use crate::job::{CheckedPlan, Verified};
use crate::planning::sha256_hex;
use crate::verify::RULES;

/// What a certificate begins with.
const FORMAT: &str = "trunnion-certificate";
/// A file is known by so many bytes.
const HEAD: usize = 80;

/// Says that a program, kept in `file`, was replayed by `plan` on its machine's model without findings: the hashes of all that went into the
/// proof, the plan, and all values of the machine. It is no signature: whoever doubts it replays the program.
///
/// `None` where nothing was proved of the program, or by another plan.
pub fn certificate(file: &str, program: &Verified<Vec<u8>>, plan: &CheckedPlan) -> Option<Value> {
    let report = program.report_by(plan)?;
    let (bytes, profile) = (program.program(), &plan.machine.profile);
    Some(json!({
        "format": FORMAT,
        "version": 1,
        "made_by": format!("trunnion {}", env!("CARGO_PKG_VERSION")),
        "program": {"file": file, "bytes": bytes.len(), "sha256": sha256_hex(bytes)},
        "model": plan.plan.model,
        "plan": {"sha256": plan.sha256, "document": plan.plan.decided()},
        "machine": {
            "profile": plan.plan.machine.profile, "sha256": sha256_hex(profile.canonical().as_bytes()), "values": profile,
        },
        "rules": RULES,
        "rules_sha256": sha256_hex(json!(RULES).to_string().as_bytes()),
        "figures": {
            "clearance_mm": report.clearance_mm, "clearance_line": report.clearance_line, "moves": report.moves, "slots": report.slots,
            "filament_mm": report.filament_mm, "seconds_print": report.seconds_print,
        },
    }))
}

/// Whether a file is a certificate, by its first key.
pub fn is_certificate(bytes: &[u8]) -> bool {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD)]);
    head.trim_start().starts_with('{') && head.contains(FORMAT)
}
