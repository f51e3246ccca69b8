//! RepRapFirmware's own server on a Duet without a single-board computer: the `rr_` requests.
//!
//! A session is known by its place on the network; the password is sent once, when it begins. The file's CRC-32 goes along, and the
//! board keeps nothing whose checksum is another. `err` is 0 where a request was done.

use serde_json::Value;

use super::UploadFigures;
use super::address::Key;
use super::api::{Api, Delivery, Kept, State};
use super::fault::ServerFault;
use super::line::{Line, Question, escaped};

pub(super) struct Duet<'a>(pub(super) Line<'a>, pub(super) &'a Delivery<'a>);

/// Begins a session.
pub(super) fn enter(line: &Line<'_>) -> Result<(), ServerFault> {
    let key = line.to.key;
    let password = key.map_or(NO_PASSWORD, Key::secret);
    let answer = line.read("/rr_connect", &format!("/rr_connect?password={}", escaped(password)))?;
    match answer["err"].as_i64() {
        Some(0) => Ok(()),
        Some(1) if key.is_none() => Err(ServerFault::NoKey),
        Some(1) => Err(ServerFault::WrongKey { kind: line.to.address.kind, start: line.to.start }),
        Some(2) => Err(ServerFault::Busy),
        _ => Err(ServerFault::Page { what: "/rr_connect", kind: line.to.address.kind }),
    }
}

/// The password of a board that has none.
const NO_PASSWORD: &str = "reprap";

impl Duet<'_> {
    /// The file on its card.
    fn file(&self) -> String {
        format!("0:/gcodes/{}", self.1.name)
    }

    fn path(&self, request: &str) -> String {
        format!("/{request}?name={}", escaped(&self.file()))
    }

    /// A part of the board's own description.
    fn model(&self, key: &str) -> Result<Value, ServerFault> {
        Ok(self.0.read("the request for the board", &format!("/rr_model?key={key}&flags=d3"))?["result"].clone())
    }

    fn info(&self) -> Result<Option<Value>, ServerFault> {
        let info = self.0.look("the request for the file", &self.path("rr_fileinfo"))?;
        Ok(info.filter(|info| info["err"].as_i64() == Some(0)))
    }
}

impl Api for Duet<'_> {
    fn enter(&mut self) -> Result<(), ServerFault> {
        enter(&self.0)
    }

    fn free(&self) -> Result<Option<u64>, ServerFault> {
        Ok(self.model("volumes")?[0]["freeSpace"].as_u64())
    }

    fn kept(&self) -> Result<Option<Kept>, ServerFault> {
        Ok(self.info()?.map(|info| Kept { bytes: info["size"].as_u64().unwrap_or_default(), sha1: None }))
    }

    fn upload(&self, sent: &dyn Fn(usize)) -> Result<(), ServerFault> {
        let (what, job) = ("the upload", self.1);
        let path = format!("{}&crc32={:08x}", self.path("rr_upload"), crc32fast::hash(job.file));
        let question = Question::post(path, "application/octet-stream", vec![job.file]);
        let answer = self.0.good(what, self.0.once(question, sent)?)?;
        // Another checksum, or a card that takes no more.
        if self.0.value(what, &answer)?["err"].as_i64() == Some(0) { Ok(()) } else { Err(ServerFault::Closed) }
    }

    fn fetch(&self) -> Result<Vec<u8>, ServerFault> {
        self.0.fetch(&self.path("rr_download"))
    }

    fn remove(&self) -> Result<(), ServerFault> {
        match self.0.read("the request to delete the file", &self.path("rr_delete"))?["err"].as_i64() {
            Some(0) => Ok(()),
            _ => Err(ServerFault::NotDeleted { name: self.1.name.clone() }),
        }
    }

    fn state(&self) -> Result<State, ServerFault> {
        let state = self.model("state")?;
        match state["status"].as_str() {
            Some("idle") => Ok(State::Ready),
            Some("processing" | "simulating" | "pausing" | "paused" | "resuming" | "cancelling" | "changingTool") => {
                let job = self.model("job")?["file"]["fileName"].as_str().map(str::to_owned);
                Ok(State::Printing(job.map(|file| file.rsplit('/').next().unwrap_or_default().to_owned())))
            }
            other => Ok(State::NotReady(format!("its state is {}", other.unwrap_or("unknown")))),
        }
    }

    fn start(&self) -> Result<(), ServerFault> {
        let (what, code) = ("the request to start the print", format!("M32 \"{}\"", self.file()));
        let path = format!("/rr_gcode?gcode={}", escaped(&code));
        self.0.good(what, self.0.once(Question::get(path), &|_| {})?).map(drop)
    }

    fn shown(&self) -> Result<UploadFigures, ServerFault> {
        let info = self.info()?.unwrap_or(Value::Null);
        let filament = info["filament"].as_array().map(|all| all.iter().filter_map(Value::as_f64).sum());
        Ok(UploadFigures {
            seconds: info["printTime"].as_f64(),
            filament_mm: filament,
            layers: info["numLayers"].as_u64(),
        })
    }

    fn leave(&self) {
        // A session that is not closed ends by itself after some seconds.
        let _ = self.0.once(Question::get("/rr_disconnect".to_owned()), &|_| {});
    }
}
