//! A file on the server of a printer.

use serde_json::{Value, json};

use crate::job::PublishResult;
use crate::publish::UploadFigures;

/// `trunnion publish`: what is there, what we say of it and what the server shows by now. No key is in it.
pub fn published(done: &PublishResult) -> Value {
    json!({
        "server": done.to.kind.word(), "url": done.to.url(), "file": done.name, "bytes": done.bytes, "sha256": done.sha256,
        "verified": done.verified, "uploads": done.delivered.uploads, "started": done.delivered.started,
        "stated": figures(&done.stated), "shown": figures(&done.delivered.shown), "seconds": done.seconds,
    })
}

fn figures(of: &UploadFigures) -> Value {
    json!({"seconds_print": of.seconds, "filament_mm": of.filament_mm, "layers": of.layers})
}
