//! What is known of one run of a job, from what it has said. Pure values.

use serde_json::{Value, json};

use super::WorkbenchError;
use super::choices::line;
use super::runs::JobSaid;
use super::task::Task;

/// Lines of standard error that are kept of a run.
const MOST_NOTES: usize = 300;
/// What `send` writes before it waits for an answer.
const ASKS: &str = "type yes to confirm";

/// One run of a job.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// The job.
    pub(super) task: Task,
    /// The words of its command.
    pub(super) words: Vec<String>,
    /// What its result depends on, when it began: [`super::project::Project::whole`] and `basis`.
    pub(super) made_of: (String, String),
    /// Whether it still runs.
    pub(super) running: bool,
    /// Whether the person has stopped it.
    pub(super) stopped: bool,
    exit: Option<i32>,
    notes: Vec<String>,
    /// A stage, how far it is, and of how many.
    bar: Option<(String, u64, u64)>,
    /// The last event of a print, and the last one that says how far it is.
    event: Option<Value>,
    progress: Option<Value>,
    paused: bool,
    asks: bool,
    out: String,
    document: Option<Value>,
}

impl Run {
    /// One that begins now.
    pub(super) fn new(task: Task, words: Vec<String>, made_of: (String, String)) -> Self {
        let (event, progress, document) = (None, None, None);
        let (exit, notes, bar, out) = (None, Vec::new(), None, String::new());
        let (running, stopped, paused, asks) = (true, false, false, false);
        Self { task, words, made_of, running, stopped, exit, notes, bar, event, progress, paused, asks, out, document }
    }

    /// Takes what the job says; the document of one that has ended and is no print.
    pub(super) fn hear(&mut self, said: JobSaid) -> Option<&Value> {
        match said {
            JobSaid::Result(line) if self.task.has_document() => {
                self.out.push_str(&line);
                self.out.push('\n');
            }
            JobSaid::Result(line) => self.event(serde_json::from_str(&line).unwrap_or(Value::Null)),
            JobSaid::Note(line) => self.note(line),
            JobSaid::Ended(exit) => {
                (self.running, self.exit, self.bar, self.asks) = (false, exit, None, false);
                self.document = self.ended();
                return self.document.as_ref();
            }
        }
        None
    }

    fn event(&mut self, event: Value) {
        match event["event"].as_str() {
            Some("pause") => self.paused = true,
            Some("progress") => self.progress = Some(event.clone()),
            Some(_) => self.paused = false,
            None if event["error"].is_string() => self.out = event.to_string(),
            None => return,
        }
        self.event = Some(event);
    }

    fn note(&mut self, line: String) {
        if let Some(bar) = line.strip_prefix("progress: ").and_then(bar) {
            self.bar = Some(bar);
            return;
        }
        self.asks |= line.contains(ASKS);
        if self.notes.len() == MOST_NOTES {
            self.notes.remove(0);
        }
        self.notes.push(line);
    }

    /// A word was given to it.
    pub(super) fn answered(&mut self, stops: bool) {
        self.asks = false;
        self.stopped |= stops;
    }

    /// The document of a run that has ended: what it printed, or what stands for its failure.
    fn ended(&self) -> Option<Value> {
        if !self.task.has_document() && self.exit == Some(0) {
            return None;
        }
        let printed = serde_json::from_str::<Value>(&self.out).ok().filter(Value::is_object);
        printed.or_else(|| Some(self.failed()))
    }

    /// The last error on standard error, or that it ended without one.
    fn failed(&self) -> Value {
        let error = self.notes.iter().rev().find_map(|line| error_in(line));
        let (code, text) = match (self.stopped, error) {
            (true, _) => ("command/interrupted", "stopped".to_owned()),
            (false, Some((code, text))) => (code, text.to_owned()),
            (false, None) => (WorkbenchError::Crashed.code(), WorkbenchError::Crashed.to_string()),
        };
        json!({"error": text, "code": code, "exit": self.exit})
    }

    /// The run as the page shows it.
    pub(super) fn document(&self) -> Value {
        let failed = self.document.as_ref().filter(|document| document["error"].is_string());
        json!({
            "command": line(&self.words), "running": self.running, "stopped": self.stopped, "exit": self.exit, "notes": self.notes,
            "bar": self.bar.as_ref().map(|(what, at, of)| json!({"what": what, "at": at, "of": of})),
            "event": self.event, "progress": self.progress, "paused": self.paused, "asks": self.asks, "failed": failed,
            "published": self.document.as_ref().filter(|_| self.task.publishes() && failed.is_none()),
        })
    }
}

/// `slicing 3/7`
fn bar(text: &str) -> Option<(String, u64, u64)> {
    let (what, counts) = text.rsplit_once(' ')?;
    let (at, of) = counts.split_once('/')?;
    Some((what.to_owned(), at.parse().ok()?, of.parse().ok()?))
}

/// Code and sentence of `error[CODE]: SENTENCE`.
fn error_in(line: &str) -> Option<(&str, &str)> {
    let rest = line.strip_prefix("error")?;
    let coded = rest.strip_prefix('[').and_then(|rest| rest.split_once("]: "));
    coded.or_else(|| Some(("command/usage", rest.strip_prefix(": ")?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(task: Task) -> Run {
        Run::new(task, vec!["x".to_owned()], (String::new(), String::new()))
    }

    fn note(run: &mut Run, text: &str) {
        run.hear(JobSaid::Note(text.to_owned()));
    }

    #[test]
    fn a_job_shows_its_stage_and_ends_with_its_document() {
        let mut run = run(Task::Prepare);
        note(&mut run, "progress: slicing 3/7");
        note(&mut run, "2 prints sliced");
        assert_eq!(run.document()["bar"], json!({"what": "slicing", "at": 3, "of": 7}));
        for line in ["{", "\"output\": \"a\"", "}"] {
            assert!(run.hear(JobSaid::Result(line.to_owned())).is_none());
        }
        assert_eq!(run.hear(JobSaid::Ended(Some(0))), Some(&json!({"output": "a"})));
        let document = run.document();
        assert_eq!(
            (&document["running"], &document["bar"], &document["failed"]),
            (&json!(false), &Value::Null, &Value::Null)
        );
    }

    #[test]
    fn a_failure_has_the_words_of_the_command() {
        let mut said = run(Task::Prepare);
        said.hear(JobSaid::Result(r#"{"error": "no", "code": "mesh/open"}"#.to_owned()));
        assert_eq!(said.hear(JobSaid::Ended(Some(2))).unwrap()["code"], "mesh/open");
        let mut silent = run(Task::Print);
        note(&mut silent, "error[send/x]: it is off");
        let failed = silent.hear(JobSaid::Ended(Some(4))).unwrap();
        assert_eq!((failed["code"].as_str(), failed["error"].as_str()), (Some("send/x"), Some("it is off")));
        let mut killed = run(Task::Prepare);
        assert_eq!(killed.hear(JobSaid::Ended(None)).unwrap()["code"], "workbench/crashed");
        let mut stopped = run(Task::Prepare);
        stopped.answered(true);
        assert_eq!(stopped.hear(JobSaid::Ended(Some(130))).unwrap()["code"], "command/interrupted");
    }

    #[test]
    fn a_print_pauses_asks_and_goes_on() {
        let mut run = run(Task::Print);
        let event = |run: &mut Run, text: &str| _ = run.hear(JobSaid::Result(text.to_owned()));
        event(&mut run, r#"{"event": "progress", "line": 3, "of": 9, "share": 0.2}"#);
        event(&mut run, r#"{"event": "pause", "line": 4, "of": 9}"#);
        let document = run.document();
        assert_eq!((&document["paused"], &document["progress"]["share"]), (&json!(true), &json!(0.2)));
        event(&mut run, r#"{"event": "resumed", "line": 4, "of": 9}"#);
        assert_eq!(run.document()["paused"], false);
        note(&mut run, "type yes to confirm:");
        assert_eq!(run.document()["asks"], true);
        run.answered(false);
        assert_eq!(run.document()["asks"], false);
        assert_eq!(run.hear(JobSaid::Ended(Some(0))), None);
    }
}
