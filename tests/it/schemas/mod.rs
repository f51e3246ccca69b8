//! The schemas under `docs/schemas`: every document that a test of this binary makes the command print is held against its own, at once
//! ([`crate::support::Command`]); here is decided which that is, and that the schemas let nothing else pass.

pub(crate) mod checker;
mod every;
mod mutated;

use std::process::Output;
use std::sync::OnceLock;

use serde_json::{Deserializer, Value};
use sha2::{Digest, Sha256};

use checker::Schemas;

pub(crate) fn schemas() -> &'static Schemas {
    static READ: OnceLock<Schemas> = OnceLock::new();
    READ.get_or_init(Schemas::read)
}

/// The verbs of many models.
const OF_MANY: [&str; 3] = ["orient", "plan", "prepare"];

/// The documents of a call, each with the file of its schema. Its words are enough: the first that is no flag is the verb.
fn documents(words: &[String], output: &Output) -> Vec<(String, Value)> {
    let mut plain = words.iter().filter(|word| !word.starts_with('-'));
    let verb = match plain.next().map(String::as_str) {
        Some(verb @ ("profile" | "machine")) => format!("{verb}-{}", plain.next().map_or("", String::as_str)),
        Some(verb) => verb.to_owned(),
        None => String::new(),
    };
    let text = String::from_utf8_lossy(&output.stdout);
    let all: Result<Vec<Value>, _> = Deserializer::from_str(&text).into_iter().collect();
    let all = all.unwrap_or_else(|why| panic!("{words:?}: {why} in what is no JSON: {text:.400}"));
    let schema = |document: &Value| match document.get("event") {
        Some(_) if OF_MANY.contains(&verb.as_str()) => "batch.json".to_owned(),
        // What is no verb has no file of its own.
        None if document.get("error").is_some() && !schemas().names().any(|name| name == format!("{verb}.json")) => {
            "simulate.json".to_owned()
        }
        _ => format!("{verb}.json"),
    };
    all.into_iter().map(|document| (schema(&document), document)).collect()
}

/// Holds what a call with `--json` printed against its schema: one document, or one a line where the verb tells events.
#[track_caller]
pub(crate) fn heard(words: &[String], output: &Output) {
    let documents = documents(words, output);
    for (file, document) in &documents {
        holds(file, document, &format!("{words:?}"));
    }
    let Some(code) = output.status.code() else { return };
    let simulates = words.iter().any(|word| word == "simulate");
    assert!(!documents.is_empty() || code == 0 && simulates, "{words:?}: exit code {code} and no document");
    let events = documents.iter().filter(|(_, document)| document.get("event").is_some()).count();
    assert!(documents.len() - events <= 1, "{words:?}: {} documents", documents.len() - events);
    // A broken line of a batch or a print that has begun has its code in its own lines.
    if let (0, [(_, document)]) = (events, &documents[..]) {
        let said = document.get("exit").map_or(Value::from(code), Value::clone);
        assert_eq!(said, code, "{words:?}: another exit code than the document's");
        assert!(code != 0 || document.get("error").is_none(), "{words:?}: exit code 0 with {document}");
    }
}

/// So much of a document as a person reads.
fn short(document: &Value) -> String {
    document.to_string().chars().take(400).collect()
}

/// That `document` is as `file` says; kept for other programs' eyes where `TRUNNION_DOCUMENTS` names a folder.
#[track_caller]
pub(crate) fn holds(file: &str, document: &Value, what: &str) {
    let faults = schemas().faults(file, document);
    assert!(faults.is_empty(), "{what}: not as docs/schemas/{file} says: {}\n{}", faults.join("; "), short(document));
    let Some(folder) = std::env::var_os("TRUNNION_DOCUMENTS") else { return };
    let text = document.to_string();
    let hash: String = Sha256::digest(&text).iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let kind = schemas().kind(file, document).unwrap_or_default();
    let name = format!("{}.{kind}.{hash}.json", file.trim_end_matches(".json"));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(std::path::Path::new(&folder).join(name), text).unwrap();
}
