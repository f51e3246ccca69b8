//! The few words of JSON Schema 2020-12 that our schemas are written in. A word that is not known here is refused, so that none is
//! written down and checked by nobody; `mutated.rs` holds the verdicts against another program's.

use std::collections::BTreeMap;

use regex_lite::Regex;
use serde_json::{Map, Value};

use crate::support::root;

/// Words that say something to people only, or are looked at where they are referred to.
const SAID: [&str; 5] = ["$schema", "$id", "$defs", "title", "description"];
/// What an object's own check looks at beside the word that calls for it.
const BESIDE: [&str; 2] = ["required", "additionalProperties"];

/// All files of `docs/schemas`, by name.
pub(crate) struct Schemas {
    files: BTreeMap<String, Value>,
}

impl Schemas {
    pub(crate) fn read() -> Self {
        let folder = std::fs::read_dir(root().join("docs/schemas")).unwrap().map(|entry| entry.unwrap().path());
        let schemas = folder.filter(|path| path.extension().is_some_and(|end| end == "json"));
        let read = |path: std::path::PathBuf| {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            let value: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
            assert_eq!(value["$id"], name.as_str(), "a file is called by its own $id");
            (name, value)
        };
        Self { files: schemas.map(read).collect() }
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.files.keys().map(String::as_str)
    }

    pub(crate) fn of(&self, file: &str) -> &Value {
        self.files.get(file).unwrap_or_else(|| panic!("docs/schemas/{file} is missing"))
    }

    /// What is wrong with `document`; nothing where it is as `file` says.
    pub(crate) fn faults(&self, file: &str, document: &Value) -> Vec<String> {
        Check { schemas: self, file }.faults(self.of(file), "", document)
    }

    /// Which of the documents that `file` lists this one is, by the name after the last `/` of its reference.
    pub(crate) fn kind(&self, file: &str, document: &Value) -> Option<String> {
        let kinds = self.of(file)["oneOf"].as_array()?;
        let is = |kind: &&Value| Check { schemas: self, file }.faults(kind, "", document).is_empty();
        kinds.iter().find(is).map(name_of)
    }
}

/// What an alternative is called.
pub(crate) fn name_of(kind: &Value) -> String {
    kind["$ref"].as_str().map_or("list", |to| to.rsplit('/').next().unwrap()).to_owned()
}

struct Check<'a> {
    schemas: &'a Schemas,
    file: &'a str,
}

impl Check<'_> {
    fn faults(&self, schema: &Value, at: &str, document: &Value) -> Vec<String> {
        let Some(words) = schema.as_object() else {
            let said = schema.as_bool().unwrap_or_else(|| panic!("{}: {schema} is no schema", self.file));
            return if said { Vec::new() } else { vec![format!("{at}: is not allowed")] };
        };
        words.iter().flat_map(|(word, value)| self.word(words, word, value, at, document)).collect()
    }

    fn word(&self, words: &Map<String, Value>, word: &str, value: &Value, at: &str, document: &Value) -> Vec<String> {
        let wrong =
            |wrong: bool, why: &str| if wrong { vec![format!("{at}: {document} {why} {value}")] } else { vec![] };
        let number = |is: fn(f64, f64) -> bool, why| {
            let limit = value.as_f64().unwrap();
            wrong(document.as_f64().is_some_and(|number| !is(number, limit)), why)
        };
        let long = |is: fn(u64, u64) -> bool, length: Option<usize>, why| {
            wrong(length.is_some_and(|length| !is(length as u64, value.as_u64().unwrap())), why)
        };
        let (list, text) = (document.as_array(), document.as_str());
        match word {
            _ if SAID.contains(&word) || BESIDE.contains(&word) && words.contains_key("properties") => Vec::new(),
            "$ref" => self.referred(value.as_str().unwrap(), at, document),
            "type" => wrong(!of_type(value, document), "is not of type"),
            "const" => wrong(document != value, "is not"),
            "enum" => wrong(!value.as_array().unwrap().contains(document), "is not a table that tilts and turns"),
            "minimum" => number(|a, b| a >= b, "is below"),
            "maximum" => number(|a, b| a <= b, "is above"),
            "exclusiveMinimum" => number(|a, b| a > b, "is not above"),
            "minItems" => long(|a, b| a >= b, list.map(Vec::len), "has fewer than"),
            "maxItems" => long(|a, b| a <= b, list.map(Vec::len), "has more than"),
            "minLength" => long(|a, b| a >= b, text.map(|t| t.chars().count()), "is shorter than"),
            "pattern" => {
                let pattern = Regex::new(value.as_str().unwrap()).unwrap();
                wrong(text.is_some_and(|text| !pattern.is_match(text)), "is not like")
            }
            "items" => {
                let of = |(i, one)| self.faults(value, &format!("{at}/{i}"), one);
                list.into_iter().flatten().enumerate().flat_map(of).collect()
            }
            "properties" | "additionalProperties" => self.object(words, at, document),
            "propertyNames" => {
                let of = |name: &String| self.faults(value, &format!("{at}/{name}"), &name.as_str().into());
                document.as_object().into_iter().flat_map(Map::keys).flat_map(of).collect()
            }
            "anyOf" => self.alternatives(value, at, document, false),
            "oneOf" => self.alternatives(value, at, document, true),
            other => panic!("{}: nobody checks {other:?}", self.file),
        }
    }

    fn referred(&self, to: &str, at: &str, document: &Value) -> Vec<String> {
        let (file, place) = to.split_once('#').unwrap_or((to, ""));
        let file = if file.is_empty() { self.file } else { file };
        let schema =
            self.schemas.of(file).pointer(place).unwrap_or_else(|| panic!("{}: {to} leads nowhere", self.file));
        Check { schemas: self.schemas, file }.faults(schema, at, document)
    }

    fn object(&self, words: &Map<String, Value>, at: &str, document: &Value) -> Vec<String> {
        let Some(document) = document.as_object() else { return Vec::new() };
        let empty = Map::new();
        let known = words.get("properties").map_or(&empty, |known| known.as_object().unwrap());
        let required = words.get("required").into_iter().flat_map(|all| all.as_array().unwrap());
        let missing = required.filter(|key| !document.contains_key(key.as_str().unwrap()));
        let mut faults: Vec<String> = missing.map(|key| format!("{at}: {key} is missing")).collect();
        for (key, value) in document {
            let at = format!("{at}/{key}");
            match known.get(key).or_else(|| words.get("additionalProperties")) {
                Some(schema) => faults.extend(self.faults(schema, &at, value)),
                None => faults.push(format!("{at}: our schemas leave nothing open")),
            }
        }
        faults
    }

    /// Where none fits, what is wrong with the one that fits best.
    fn alternatives(&self, all: &Value, at: &str, document: &Value, only: bool) -> Vec<String> {
        let all = all.as_array().unwrap().iter().map(|one| self.faults(one, at, document));
        let mut all: Vec<Vec<String>> = all.collect();
        all.sort_by_key(Vec::len);
        let fit = all.iter().filter(|faults| faults.is_empty()).count();
        match fit {
            0 => all.into_iter().next().unwrap_or_else(|| vec![format!("{at}: no alternatives")]),
            2.. if only => vec![format!("{at}: {fit} alternatives fit, and only one may")],
            _ => Vec::new(),
        }
    }
}

fn of_type(wanted: &Value, document: &Value) -> bool {
    let is = |name: &Value| match name.as_str().unwrap() {
        "null" => document.is_null(),
        "boolean" => document.is_boolean(),
        "string" => document.is_string(),
        "array" => document.is_array(),
        "object" => document.is_object(),
        "number" => document.is_number(),
        // A whole number, however it is written.
        "integer" => document.as_f64().is_some_and(|number| number.fract() == 0.0),
        other => panic!("no type is called {other}"),
    };
    wanted.as_array().map_or_else(|| is(wanted), |all| all.iter().any(is))
}
