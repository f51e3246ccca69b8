//! OctoPrint's REST API: `/api/files/local`, `/api/printer`.
//!
//! An upload is put together beside the folder of files and moved there when it is whole. What the server shows of a file is its own
//! analysis, which begins when nothing prints, and which no request can give it; our figures go along as `userdata`.

use serde_json::{Value, json};

use super::UploadFigures;
use super::api::{Api, Delivery, Kept, State};
use super::fault::ServerFault;
use super::form::Form;
use super::line::{Line, Question, plain};
use super::web::HttpMethod;

pub(super) struct OctoPrint<'a>(pub(super) Line<'a>, pub(super) &'a Delivery<'a>);

impl OctoPrint<'_> {
    fn file(&self) -> String {
        format!("/api/files/local/{}", self.1.name)
    }

    /// Our own figures, kept with the file.
    fn userdata(&self) -> String {
        let (job, stated) = (self.1, self.1.stated);
        let own = json!({
            "sha256": job.sha256, "verified": job.verified, "seconds_print": stated.seconds, "filament_mm": stated.filament_mm,
            "layers": stated.layers,
        });
        json!({"trunnion": own}).to_string()
    }
}

impl Api for OctoPrint<'_> {
    fn enter(&mut self) -> Result<(), ServerFault> {
        let version = self.0.read("/api/version", "/api/version")?;
        let named = version["text"].as_str().is_some_and(|text| text.starts_with("OctoPrint"));
        if named { Ok(()) } else { Err(ServerFault::Page { what: "/api/version", kind: self.0.to.address.kind }) }
    }

    /// As its connection's M115 has it; only a key with the right to see the system is told.
    fn firmware(&self) -> Option<String> {
        let info = self.0.look("the request for the system", "/api/system/info").ok()??;
        info["systeminfo"]["printer.firmware"].as_str().map(str::to_owned)
    }

    fn free(&self) -> Result<Option<u64>, ServerFault> {
        Ok(self.0.read("the request for the list of files", "/api/files/local?recursive=false")?["free"].as_u64())
    }

    fn kept(&self) -> Result<Option<Kept>, ServerFault> {
        let Some(file) = self.0.look("the request for the file", &self.file())? else { return Ok(None) };
        let bytes = file["size"].as_u64().unwrap_or_default();
        Ok(Some(Kept { bytes, sha1: file["hash"].as_str().map(str::to_ascii_lowercase) }))
    }

    fn upload(&self, sent: &dyn Fn(usize)) -> Result<(), ServerFault> {
        let (job, userdata) = (self.1, self.userdata());
        let once = if job.replace { "false" } else { "true" };
        let form = Form::of(&[("noOverwrite", once), ("userdata", &userdata)], &job.name, &job.sha256);
        let what = "the upload";
        let question = Question::post("/api/files/local".to_owned(), &form.kind(), form.body(job.file));
        let answer = self.0.good(what, self.0.once(question, sent)?)?;
        let path = self.0.value(what, &answer)?["files"]["local"]["path"].clone();
        match path.as_str() {
            Some(path) if path == job.name => Ok(()),
            other => Err(ServerFault::Renamed { stored: other.map(plain), name: job.name.clone() }),
        }
    }

    fn fetch(&self) -> Result<Vec<u8>, ServerFault> {
        self.0.fetch(&format!("/downloads/files/local/{}", self.1.name))
    }

    fn remove(&self) -> Result<(), ServerFault> {
        let question = Question { method: HttpMethod::Delete, ..Question::get(self.file()) };
        self.0.good("the request to delete the file", self.0.once(question, &|_| {})?).map(drop)
    }

    fn state(&self) -> Result<State, ServerFault> {
        let what = "the request for the printer";
        let answer = self.0.once(Question::get("/api/printer?exclude=temperature,sd".to_owned()), &|_| {})?;
        if answer.status == 409 {
            return Ok(State::NotReady("it is not connected to OctoPrint".to_owned()));
        }
        let answer = self.0.good(what, answer)?;
        let state = self.0.value(what, &answer)?["state"].clone();
        let is = |flag: &str| state["flags"][flag].as_bool().unwrap_or_default();
        if ["printing", "paused", "pausing", "resuming", "cancelling", "finishing"].into_iter().any(is) {
            let job = self.0.read("the request for the job", "/api/job")?;
            return Ok(State::Printing(job["job"]["file"]["path"].as_str().map(str::to_owned)));
        }
        if is("ready") && is("operational") {
            return Ok(State::Ready);
        }
        Ok(State::NotReady(state["text"].as_str().unwrap_or("no reason given").to_owned()))
    }

    fn start(&self) -> Result<(), ServerFault> {
        let (what, command) =
            ("the request to start the print", json!({"command": "select", "print": true}).to_string());
        let question = Question::post(self.file(), "application/json", vec![command.as_bytes()]);
        self.0.good(what, self.0.once(question, &|_| {})?).map(drop)
    }

    fn shown(&self) -> Result<UploadFigures, ServerFault> {
        let file = self.0.look("the request for the file", &self.file())?.unwrap_or(Value::Null);
        let analysis = &file["gcodeAnalysis"];
        let tools = analysis["filament"].as_object();
        let lengths = tools.map(|tools| tools.values().filter_map(|tool| tool["length"].as_f64()).sum());
        Ok(UploadFigures { seconds: analysis["estimatedPrintTime"].as_f64(), filament_mm: lengths, layers: None })
    }
}
