//! Many models: a line each, and one at the end.

use serde_json::{Value, json};

use crate::job::{BatchResult, Batched, Fate};

/// A model of many: where its document is below the folder of results, or why there is none. `exit` is `null` where its process was
/// ended; `before` says that it failed in an earlier run and was left alone.
pub fn batched(one: &Batched) -> Value {
    let mut line = json!({"event": "model", "model": one.model, "key": one.key, "seconds": one.seconds});
    let file = |key: &String| format!("{}/{key}.json", &key[..2]);
    match &one.fate {
        Fate::Done => (line["status"], line["document"]) = ("done".into(), one.key.as_ref().map(file).into()),
        Fate::Skipped => (line["status"], line["document"]) = ("skipped".into(), one.key.as_ref().map(file).into()),
        Fate::Failed { code, why, exit, before } => {
            (line["status"], line["code"]) = ("failed".into(), code.as_deref().into());
            (line["error"], line["exit"], line["before"]) = (why.as_str().into(), (*exit).into(), (*before).into());
        }
    }
    line
}

/// The end of many models.
pub fn batch(done: &BatchResult) -> Value {
    json!({
        "event": "done", "done": done.done, "skipped": done.skipped, "failed": done.failed.len(), "seconds": done.seconds,
    })
}
