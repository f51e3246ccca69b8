//! What a server tells of the machine behind it, as one text: Klipper's settings in the form of its own file, a Duet's object model line by line.
//!
//! Nothing is changed there. Sources: Klipper's "Status reference" (`configfile`), RepRapFirmware's object model.

use std::fmt::Write;
use std::time::Duration;

use serde_json::Value;

use super::address::{Key, Kind, ServerAddress};
use super::duet::enter;
use super::fault::{PublishError, ServerFault};
use super::fingerprint::Fingerprint;
use super::line::{Line, Question, Reached, escaped};
use super::web::Web;

/// More axes than any board drives.
pub const MOST_AXES: usize = 20;
/// What a board's object model says of the whole machine.
pub const MACHINE_KEYS: [&str; 2] = ["move.kinematics", "network"];

/// A server that is asked about its machine.
#[derive(Clone, Copy)]
pub struct Inquiry<'a> {
    /// Where it is.
    pub address: &'a ServerAddress,
    /// What opens it.
    pub key: Option<&'a Key>,
    /// How long it may say nothing.
    pub silence: Duration,
    /// The only certificate that is taken; `None`: what this computer's authorities vouch for.
    pub fingerprint: Option<Fingerprint>,
}

impl<'a> Inquiry<'a> {
    pub(super) fn reached(&self) -> Reached<'a> {
        let Self { address, key, silence, fingerprint } = *self;
        Reached { address, key, silence, fingerprint, bytes: 0, start: false }
    }
}

/// What the server tells of the machine behind it, in the form that `profile import` reads.
///
/// # Errors
///
/// [`PublishError`]; [`ServerFault::NoConfiguration`] for OctoPrint, which knows none.
pub fn configuration(asked: &Inquiry<'_>, web: &dyn Web) -> Result<String, PublishError> {
    let line = Line { to: asked.reached(), web };
    let told = match asked.address.kind {
        Kind::OctoPrint => Err(ServerFault::NoConfiguration),
        Kind::Moonraker => of_klipper(&line),
        Kind::Duet => of_a_duet(&line),
    };
    told.map_err(|fault| PublishError::new(asked.address, fault, false))
}

fn of_klipper(line: &Line<'_>) -> Result<String, ServerFault> {
    let what = "the request for Klipper's configuration";
    let path = "/printer/objects/query?configfile=config";
    let answer = line.read(what, path)?["status"]["configfile"]["config"].clone();
    let page = || ServerFault::Page { what, kind: line.to.address.kind };
    let sections = answer.as_object().filter(|all| !all.is_empty()).ok_or_else(page)?;
    let mut out = String::from("# As Klipper has read it (configfile), without comments and includes.\n");
    let mut names: Vec<&String> = sections.keys().collect();
    names.sort();
    for name in names {
        let _ = writeln!(out, "\n[{name}]");
        for (key, value) in sections[name].as_object().ok_or_else(page)? {
            // Lines of a macro stand farther in, as in the file.
            let text = value.as_str().map_or_else(|| value.to_string(), |text| text.replace('\n', "\n  "));
            let _ = writeln!(out, "{key}: {text}");
        }
    }
    Ok(out)
}

fn of_a_duet(line: &Line<'_>) -> Result<String, ServerFault> {
    enter(line)?;
    let told = model(line);
    // A session that is not closed ends by itself after some seconds.
    let _ = line.once(Question::get("/rr_disconnect".to_owned()), &|_| {});
    told
}

fn model(line: &Line<'_>) -> Result<String, ServerFault> {
    let what = "the request for the board's object model";
    let ask = |key: &str| -> Result<Value, ServerFault> {
        let answer = line.read(what, &format!("/rr_model?key={}&flags=v", escaped(key)))?;
        Ok(answer["result"].clone())
    };
    let board = ask("boards[0]")?;
    let text = |key: &str| board[key].as_str().unwrap_or("?").to_owned();
    let mut out = format!(
        "FIRMWARE_NAME: {} FIRMWARE_VERSION: {} ELECTRONICS: {}\n",
        text("firmwareName"),
        text("firmwareVersion"),
        text("name")
    );
    let mut say = |key: &str| -> Result<bool, ServerFault> {
        let result = ask(key)?;
        let there = !result.is_null();
        let _ = writeln!(out, "{}", serde_json::json!({"key": key, "flags": "v", "result": result}));
        Ok(there)
    };
    for i in 0..MOST_AXES {
        if !say(&format!("move.axes[{i}]"))? {
            break;
        }
    }
    for key in MACHINE_KEYS {
        say(key)?;
    }
    Ok(out)
}
