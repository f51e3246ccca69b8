//! The workbench: one page on which a person sees a model, chooses a way to print it, and prints. A server on this computer alone.
//!
//! Whatever the page does is a command line, which is shown below it, and the server runs exactly that: long jobs as processes of this same
//! program (`runs.rs`), so that a crash of one leaves the page and the project as they are, and the bytes are the command's own. Nothing
//! is decided here that `job` decides.
//!
//! `doors.rs` says who comes in, `routes.rs` what is asked, `choices.rs` what is chosen, `history.rs` what was chosen before, `project.rs` what is out of date, `run.rs` what a job has
//! said: pure values. `server.rs` has the sockets, `folder.rs` the files, `answers.rs` puts them together. `page/` is the page itself, as
//! it is served.

mod answers;
mod archive;
mod choices;
mod cuts;
mod doors;
mod error;
mod folder;
mod history;
mod http;
mod printers;
mod project;
mod routes;
mod run;
mod runs;
mod scene;
mod server;
mod shared;
mod state;
mod task;
mod timeline;

use std::path::{Path, PathBuf};

pub use error::WorkbenchError;
pub use runs::PROGRESS_VARIABLE;

use history::History;
use project::Project;
use server::HttpServer;
use state::State;

/// What the workbench begins with.
#[derive(Clone, Debug, Default)]
pub struct OpenRequest {
    /// Models.
    pub models: Vec<PathBuf>,
    /// A profile's name or file.
    pub machine: Option<String>,
    /// The project's folder; the working folder without one.
    pub folder: Option<PathBuf>,
    /// Port of the server; 0 for any free one.
    pub port: u16,
    /// Whether a browser is to be started.
    pub browser: bool,
}

/// Whether `path` is that of a project file, by its name.
pub fn is_project(path: &Path) -> bool {
    path.file_name().is_some_and(|name| doors::is_project(&name.to_string_lossy()))
}

/// The words of a project's command, and flags that name what it writes, each with its file.
pub type ProjectWords = (Vec<String>, Vec<[String; 2]>);

/// Unpacks the project file at `path` into the working folder, where it replaces no other file: the words of the command that its page shows,
/// and behind them those that name what is written, each a flag and its file.
///
/// # Errors
///
/// [`WorkbenchError::NotYet`] and those of a bad project file.
pub fn unpacked_words(path: &Path) -> Result<ProjectWords, WorkbenchError> {
    let choices = folder::unpack(path, Path::new("."))?;
    Ok((choices.prepare()?, choices.written()))
}

/// The same words by the names in the file; nothing is unpacked.
///
/// # Errors
///
/// As [`unpacked_words`].
pub fn project_words(path: &Path) -> Result<ProjectWords, WorkbenchError> {
    let choices = folder::chosen(path)?;
    Ok((choices.prepare()?, choices.written()))
}

/// Serves the workbench until it is ended; `told` gets its address when it listens, and the file that leads a
/// browser there: the secret is no word of a command line, which every user of this computer could read. The processes of prints that go on.
///
/// # Errors
///
/// [`WorkbenchError::Folder`], [`WorkbenchError::Port`] and [`WorkbenchError::NotStarted`].
pub fn open(request: &OpenRequest, told: impl FnOnce(&str, Option<&Path>)) -> Result<Vec<u32>, WorkbenchError> {
    let here = folder::working()?;
    let folder = folder::opened(request.folder.as_deref().unwrap_or(&here))?;
    let named = |machine: &String| match here.join(machine).is_file() {
        true => folder::named(machine.as_ref(), &here, &folder),
        false => machine.clone(),
    };
    let machine = request.machine.as_ref().map(named);
    let mut state = State {
        names: machine.iter().cloned().collect(),
        project: Project::new(machine),
        folder: folder.display().to_string(),
        ..State::default()
    };
    let (projects, models): (Vec<&PathBuf>, Vec<&PathBuf>) = request.models.iter().partition(|path| is_project(path));
    if projects.len() > 1 {
        return Err(WorkbenchError::SecondProject);
    }
    for path in projects {
        let path = here.join(path);
        let (name, choices) = (path.file_name().unwrap_or_default().to_string_lossy(), folder::unpack(&path, &folder)?);
        let own = folder::named(&path, &here, &folder);
        state.opened(choices, &name, (own == name).then_some(own));
    }
    for model in models {
        state.project.add(&folder::named(model, &here, &folder));
    }
    // What the command named is where the history begins.
    state.project.history = History::default();
    folder::work_in(&folder)?;
    let server = HttpServer::listen(request.port, folder, state)?;
    let shared = server.shared.clone();
    crate::world::interrupts::on_interrupt(move || shared.quit());
    let address = server.shared.doors.address();
    let leads = request.browser.then(|| folder::leading_to(&address, &server.shared.folder)).transpose()?;
    told(&address, leads.as_ref().map(|file| file.path()));
    answers::begin(&server.shared);
    let prints = server.serve();
    server.shared.kept().clear();
    Ok(prints)
}
