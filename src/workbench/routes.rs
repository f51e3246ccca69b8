//! Addresses of the workbench: what a request asks for. Nothing is done here.

use super::WorkbenchError;
use super::http::RequestHead;
use super::project::ProjectChange;
use super::task::PrinterTask;

/// What a request asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum WebAsked {
    /// The page or one of its files; needs no secret.
    Static(&'static str),
    /// The cookie for files.
    Session,
    /// The whole state.
    Whole,
    /// The state, each time it changes.
    Events,
    /// All machines.
    Machines,
    /// The machine, to be drawn.
    DrawnMachine,
    /// A model of the project, to be drawn.
    DrawnModel(usize),
    /// A model is sent with the request.
    Upload(String),
    /// The prints are to come in this order.
    Order(String),
    /// The model is to be cut so, first of all.
    Cuts(String),
    /// The project is to be saved.
    Save,
    /// A change of the project.
    ProjectChange(ProjectChange),
    /// A job is to start.
    Run(PrinterTask),
    /// A running job gets a word.
    JobWord(PrinterTask, JobWord),
    /// A file that a job has made.
    File(String),
    /// The workbench is to end.
    Quit,
}

/// A word to a running job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JobWord {
    /// End; for a print this is the emergency stop.
    Stop,
    /// Pause the print above the part.
    Pause,
    /// Continue a paused print.
    Continue,
    /// End a paused print.
    Cancel,
    /// Agree to what the print asks.
    Yes,
}

/// Names and sources of the page's files. The renderer is the preview's own.
pub(super) const FILES: [(&str, &str); 17] = [
    ("/", include_str!("page/index.html")),
    ("/page/style.css", include_str!("page/style.css")),
    ("/page/main.js", include_str!("page/main.js")),
    ("/page/texts.js", include_str!("page/texts.js")),
    ("/page/server.js", include_str!("page/server.js")),
    ("/page/parts.js", include_str!("page/parts.js")),
    ("/page/scene.js", include_str!("page/scene.js")),
    ("/page/model.js", include_str!("page/model.js")),
    ("/page/how.js", include_str!("page/how.js")),
    ("/page/see.js", include_str!("page/see.js")),
    ("/page/print.js", include_str!("page/print.js")),
    ("/page/order.js", include_str!("page/order.js")),
    ("/page/cuts.js", include_str!("page/cuts.js")),
    ("/page/planes.js", include_str!("page/planes.js")),
    ("/page/foot.js", include_str!("page/foot.js")),
    ("/page/icon.svg", include_str!("page/icon.svg")),
    ("/view/renderer.js", crate::view::RENDERER),
];

/// `Content-Type` of one of the page's files.
pub(super) fn kind_of(name: &str) -> &'static str {
    match name.rsplit_once('.') {
        Some((_, "css")) => "text/css; charset=utf-8",
        Some((_, "js")) => "text/javascript; charset=utf-8",
        Some((_, "svg")) => "image/svg+xml",
        _ => "text/html; charset=utf-8",
    }
}

/// What the request asks for.
///
/// # Errors
///
/// [`WorkbenchError::NotFound`], [`WorkbenchError::WrongMethod`], [`WorkbenchError::BadChoice`].
pub(super) fn asked(head: &RequestHead) -> Result<WebAsked, WorkbenchError> {
    let (posts, asked) = found(head)?;
    let method = if posts { "POST" } else { "GET" };
    if head.method == method { Ok(asked) } else { Err(WorkbenchError::WrongMethod) }
}

/// Whether it must be a POST, and what it is.
fn found(head: &RequestHead) -> Result<(bool, WebAsked), WorkbenchError> {
    if let Some((name, _)) = FILES.iter().find(|(name, _)| *name == head.path) {
        return Ok((false, WebAsked::Static(name)));
    }
    if let Some(name) = head.path.strip_prefix("/files/") {
        return Ok((false, WebAsked::File(name.to_owned())));
    }
    Ok(match head.path.strip_prefix("/api/").ok_or(WorkbenchError::NotFound)? {
        "state" => (false, WebAsked::Whole),
        "events" => (false, WebAsked::Events),
        "machines" => (false, WebAsked::Machines),
        "machine" => (false, WebAsked::DrawnMachine),
        "model" => (false, WebAsked::DrawnModel(index(head)?)),
        "session" => (true, WebAsked::Session),
        "models" => (true, WebAsked::Upload(head.value("name").to_owned())),
        "remove" => (true, WebAsked::ProjectChange(ProjectChange::Remove(index(head)?))),
        "add-printer" => (true, WebAsked::ProjectChange(ProjectChange::AddPrinter)),
        "remove-printer" => (true, WebAsked::ProjectChange(ProjectChange::RemovePrinter(index(head)?))),
        "undo" => (true, WebAsked::ProjectChange(ProjectChange::Undo)),
        "redo" => (true, WebAsked::ProjectChange(ProjectChange::Redo)),
        "copies" => {
            (true, WebAsked::ProjectChange(ProjectChange::Copies(index(head)?, head.value("value").to_owned())))
        }
        "set" => (
            true,
            WebAsked::ProjectChange(ProjectChange::Set(head.value("name").to_owned(), head.value("value").to_owned())),
        ),
        "order" => (true, WebAsked::Order(head.value("value").to_owned())),
        "cuts" => (true, WebAsked::Cuts(head.value("value").to_owned())),
        "save" => (true, WebAsked::Save),
        "run" => (true, WebAsked::Run(task(head)?)),
        "word" => (true, WebAsked::JobWord(task(head)?, word(head)?)),
        "quit" => (true, WebAsked::Quit),
        _ => return Err(WorkbenchError::NotFound),
    })
}

fn index<T: std::str::FromStr>(head: &RequestHead) -> Result<T, WorkbenchError> {
    let value = head.value("index");
    value.parse().map_err(|_| WorkbenchError::BadChoice { name: "index", value: value.to_owned() })
}

fn task(head: &RequestHead) -> Result<PrinterTask, WorkbenchError> {
    let value = head.value("task");
    PrinterTask::of(value).ok_or_else(|| WorkbenchError::BadChoice { name: "task", value: value.to_owned() })
}

fn word(head: &RequestHead) -> Result<JobWord, WorkbenchError> {
    Ok(match head.value("word") {
        "stop" => JobWord::Stop,
        "pause" => JobWord::Pause,
        "continue" => JobWord::Continue,
        "cancel" => JobWord::Cancel,
        "yes" => JobWord::Yes,
        other => return Err(WorkbenchError::BadChoice { name: "word", value: other.to_owned() }),
    })
}

#[cfg(test)]
mod tests {
    use super::super::task::Task;
    use super::*;

    fn of(method: &str, path: &str, query: &[(&str, &str)]) -> Result<WebAsked, &'static str> {
        let query = query.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect();
        let head = RequestHead { method: method.to_owned(), path: path.to_owned(), query, ..RequestHead::default() };
        asked(&head).map_err(|error| error.code())
    }

    #[test]
    fn addresses_and_methods_go_together() {
        assert_eq!(of("GET", "/", &[]), Ok(WebAsked::Static("/")));
        assert_eq!(of("GET", "/api/state", &[]), Ok(WebAsked::Whole));
        assert_eq!(of("POST", "/api/run", &[("task", "prepare")]), Ok(WebAsked::Run(Task::Prepare.into())));
        assert_eq!(
            of("POST", "/api/word", &[("task", "print"), ("word", "pause")]),
            Ok(WebAsked::JobWord(Task::Print.into(), JobWord::Pause))
        );
        assert_eq!(of("GET", "/files/a.gcode", &[]), Ok(WebAsked::File("a.gcode".to_owned())));
        for (method, path) in [
            ("POST", "/api/state"),
            ("GET", "/api/quit"),
            ("OPTIONS", "/api/run"),
            ("HEAD", "/"),
            ("DELETE", "/files/a"),
        ] {
            let query = [("task", "prepare")];
            assert_eq!(of(method, path, &query), Err("workbench/wrong-method"), "{method} {path}");
        }
        for path in ["", "/x", "/page/", "/page/../main.js", "/api", "/api/", "/api/nothing", "//", "/index.html"] {
            assert_eq!(of("GET", path, &[]), Err("workbench/not-found"), "{path}");
        }
        assert_eq!(of("POST", "/api/run", &[("task", "rm")]), Err("workbench/bad-choice"));
        assert_eq!(of("POST", "/api/remove", &[("index", "-1")]), Err("workbench/bad-choice"));
    }
}
