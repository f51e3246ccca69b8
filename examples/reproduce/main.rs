//! Remakes the tables and figures of the five documents that trunnion comes from, as one page and one JSON file.
//!
//! ```sh
//! cargo run --release --all-features --example reproduce -- --out target/reproduce
//! ```
//!
//! Options: `--out DIR` (where `reproduce.html` and `reproduce.json` go), `--only KEY` (castro, puri, boogers, leitereg or ramos; may be
//! repeated), `--quick` (what takes long is left out), `--meshes DIR` (a folder with meshes of the documents, which are not the project's to
//! pass on; they are read and never copied).
//!
//! The exit code is 1 where a value is farther off than the page says it should be. What is printed, or expected by a definition or another
//! method, is data of this program, with its table or equation; what is ours is computed by the library's public functions in the run. With
//! `--quick` the same input gives the same files; the whole run tells seconds as well. Searches end by steps, not by the clock.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program that says what it wrote")]

mod boogers;
mod castro;
mod chart;
pub(crate) mod item;
mod leitereg;
mod page;
mod puri;
mod ramos;
mod scene;
pub(crate) mod sources;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use item::{Document, Kind};
use sources::Run;

/// Makes a document.
type Remade = fn(&Run) -> Document;

/// The documents by their words, in the order of the page.
const ALL: [(&str, Remade); 5] = [
    ("castro", castro::document),
    ("puri", puri::document),
    ("boogers", boogers::document),
    ("leitereg", leitereg::document),
    ("ramos", ramos::document),
];

fn main() -> ExitCode {
    let asked = match Asked::of(std::env::args().skip(1)) {
        Ok(asked) => asked,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::from(2);
        }
    };
    let documents = remade(&asked.run, &asked.only);
    for document in &documents {
        let [tables, figures] = [Kind::Table, Kind::Figure].map(|kind| document.count(kind));
        println!("{}: {} of {} tables, {} of {} figures", document.key, tables[1], tables[0], figures[1], figures[0]);
    }
    match write(&asked.out, &documents) {
        Ok(()) => {
            println!("the page is {}", asked.out.join("reproduce.html").display());
            let off = off(&documents);
            off.iter().for_each(|line| eprintln!("error: {line}"));
            ExitCode::from(u8::from(!off.is_empty()))
        }
        Err(error) => {
            eprintln!("error: {}: {error}", asked.out.display());
            ExitCode::from(2)
        }
    }
}

/// The documents with these words; all for none.
pub(crate) fn remade(run: &Run, only: &[String]) -> Vec<Document> {
    let wanted = |key: &str| only.is_empty() || only.iter().any(|one| one == key);
    ALL.iter().filter(|(key, _)| wanted(key)).map(|(_, made)| made(run)).collect()
}

/// What is farther off than the page says it should be, a line each.
fn off(documents: &[Document]) -> Vec<String> {
    let items = documents.iter().flat_map(|document| document.items.iter().map(|item| (document.key, item)));
    let rows = items.flat_map(|(key, item)| item.rows.iter().map(move |row| (key, item, row)));
    let off = rows.filter(|(_, _, row)| row.holds() == Some(false));
    off.map(|(key, item, row)| format!("{key}, {}: {}: {} for {}", item.name(), row.what, row.ours, row.printed))
        .collect()
}

/// Writes the page and its data into `folder`.
pub(crate) fn write(folder: &Path, documents: &[Document]) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    std::fs::write(folder.join("reproduce.html"), page::page(documents))?;
    let data: Vec<serde_json::Value> = documents.iter().map(Document::json).collect();
    std::fs::write(folder.join("reproduce.json"), serde_json::to_string_pretty(&data)? + "\n")
}

/// What the command line asks for.
struct Asked {
    out: PathBuf,
    only: Vec<String>,
    run: Run,
}

impl Asked {
    fn of(mut words: impl Iterator<Item = String>) -> Result<Self, String> {
        let (mut out, mut only, mut run) = (None, Vec::new(), Run::default());
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
            match word.as_str() {
                "--out" => out = Some(PathBuf::from(value()?)),
                "--quick" => run.quick = true,
                "--meshes" => run.meshes = Some(PathBuf::from(value()?)),
                "--only" => {
                    let key = value()?;
                    if ALL.iter().all(|(known, _)| *known != key) {
                        return Err(format!("--only {key}: must be one of {}", ALL.map(|(known, _)| known).join(", ")));
                    }
                    only.push(key);
                }
                _ => return Err(format!("unknown word {word}; give --out DIR, --only KEY, --quick or --meshes DIR")),
            }
        }
        if let Some(folder) = run.meshes.as_ref().filter(|folder| !folder.is_dir()) {
            return Err(format!("--meshes {}: is not a folder", folder.display()));
        }
        let out = out.ok_or("give the folder for the page, for example --out target/reproduce")?;
        Ok(Self { out, only, run })
    }
}
