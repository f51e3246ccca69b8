//! Moonraker's file manager and the print of Klipper behind it.
//!
//! An upload is compared by the server with its SHA-256 before it takes its place. What the server shows it reads from comments in the
//! file, of slicers that it knows: `gcode::marks::Totals` writes them.

use super::UploadFigures;
use super::api::{Api, Delivery, Kept, State};
use super::fault::ServerFault;
use super::form::Form;
use super::line::{Line, Question};
use super::web::HttpMethod;

pub(super) struct Moonraker<'a>(pub(super) Line<'a>, pub(super) &'a Delivery<'a>);

impl Moonraker<'_> {
    fn file(&self) -> String {
        format!("/server/files/gcodes/{}", self.1.name)
    }

    fn folder(&self) -> Result<serde_json::Value, ServerFault> {
        self.0.read("the request for the list of files", "/server/files/directory?path=gcodes")
    }
}

/// What the printer does.
pub(super) fn state(line: &Line<'_>) -> Result<State, ServerFault> {
    let what = "the request for the printer";
    let answer = line.once(Question::get("/printer/info".to_owned()), &|_| {})?;
    if answer.status == 503 {
        return Ok(State::NotReady(
            "Klipper is not running or not connected (start its service on the server)".to_owned(),
        ));
    }
    let info = line.value(what, &line.good(what, answer)?)?;
    if info["state"].as_str() != Some("ready") {
        let why = info["state_message"].as_str().or_else(|| info["state"].as_str());
        return Ok(State::NotReady(why.unwrap_or("no reason given").lines().next().unwrap_or_default().to_owned()));
    }
    let stats = line.read(what, "/printer/objects/query?print_stats")?["status"]["print_stats"].clone();
    match stats["state"].as_str() {
        Some("printing" | "paused") => Ok(State::Printing(stats["filename"].as_str().map(str::to_owned))),
        Some("standby" | "complete" | "cancelled" | "error") => Ok(State::Ready),
        other => Ok(State::NotReady(format!("its state is {}", other.unwrap_or("unknown")))),
    }
}

impl Api for Moonraker<'_> {
    fn enter(&mut self) -> Result<(), ServerFault> {
        let info = self.0.read("/server/info", "/server/info")?;
        let named = info.get("klippy_state").is_some() || info.get("moonraker_version").is_some();
        if named { Ok(()) } else { Err(ServerFault::Page { what: "/server/info", kind: self.0.to.address.kind }) }
    }

    fn free(&self) -> Result<Option<u64>, ServerFault> {
        Ok(self.folder()?["disk_usage"]["free"].as_u64())
    }

    fn kept(&self) -> Result<Option<Kept>, ServerFault> {
        let folder = self.folder()?;
        let named = |file: &&serde_json::Value| file["filename"].as_str() == Some(&self.1.name);
        let file = folder["files"].as_array().into_iter().flatten().find(named);
        Ok(file.map(|file| Kept { bytes: file["size"].as_u64().unwrap_or_default(), sha1: None }))
    }

    fn upload(&self, sent: &dyn Fn(usize)) -> Result<(), ServerFault> {
        let (what, job) = ("the upload", self.1);
        let form = Form::of(&[("root", "gcodes"), ("checksum", &job.sha256)], &job.name, &job.sha256);
        let question = Question::post("/server/files/upload".to_owned(), &form.kind(), form.body(job.file));
        let answer = self.0.once(question, sent)?;
        if answer.status == 422 {
            // Its own checksum was another; it keeps nothing then.
            return Err(ServerFault::Closed);
        }
        self.0.good(what, answer).map(drop)
    }

    fn fetch(&self) -> Result<Vec<u8>, ServerFault> {
        self.0.fetch(&self.file())
    }

    fn remove(&self) -> Result<(), ServerFault> {
        let question = Question { method: HttpMethod::Delete, ..Question::get(self.file()) };
        self.0.good("the request to delete the file", self.0.once(question, &|_| {})?).map(drop)
    }

    fn state(&self) -> Result<State, ServerFault> {
        state(&self.0)
    }

    fn start(&self) -> Result<(), ServerFault> {
        let what = "the request to start the print";
        let path = format!("/printer/print/start?filename={}", self.1.name);
        self.0.good(what, self.0.once(Question::post(path, "application/json", Vec::new()), &|_| {})?).map(drop)
    }

    fn shown(&self) -> Result<UploadFigures, ServerFault> {
        let path = format!("/server/files/metadata?filename={}", self.1.name);
        let Some(file) = self.0.look("the request for the file's metadata", &path)? else {
            return Ok(UploadFigures::default());
        };
        Ok(UploadFigures {
            seconds: file["estimated_time"].as_f64(),
            filament_mm: file["filament_total"].as_f64(),
            layers: file["layer_count"].as_u64(),
        })
    }
}
