//! The floors of the house: a room imports only from floors below its own, and only a few places touch the world.
//!
//! The checker is a function over paths and texts, so that the tests below can hand it made-up houses with one fault
//! each: a rule that was never seen to fire proves nothing.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::rust_source::{line_of, masked, names_after, without_tests, words};
use crate::support::root;

/// The rooms by floor, and which rooms each module of tests/it is about; `scripts/changed.py` reads it, too.
const ROOMS: &str = include_str!("rooms.txt");

/// The lines of [`ROOMS`] that begin with this word, without it.
fn table(first: &str) -> Vec<Vec<&'static str>> {
    let words = ROOMS.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    words.filter(|words| words.first() == Some(&first)).map(|words| words[1..].to_vec()).collect()
}

/// What a room may not import although it lies below, and why.
const NEVER: [(&str, &[&str], &str); 6] = [
    ("motion", &["profile"], "profiles build its types"),
    ("verify", &["toolpath", "slicing"], "it must not share the code it checks"),
    ("view", &["profile", "planning", "slicing", "toolpath"], "it is handed what it draws"),
    ("slicing", &["motion", "planning"], "it knows no machine, pose or plan"),
    ("fixtures", &["motion", "gcode"], "models only"),
    ("mesh", &["gcode"], "it knows no G-code"),
];

/// Made-up models are for tests, benches and examples.
const FIXTURES_ONLY_IN: [&str; 1] = ["cli"];

/// The only places that touch files, processes, ports, clock, threads, environment and standard streams.
const WORLD_ONLY_IN: [&str; 12] = [
    "src/cli/",
    "src/world/",
    "src/job/batch/runs.rs",
    "src/job/send/together.rs",
    "src/slicing/process.rs",
    "src/slicing/process/",
    "src/link/serial/",
    "src/workbench/folder.rs",
    "src/workbench/folder/",
    "src/workbench/runs.rs",
    "src/workbench/server.rs",
    "src/main.rs",
];
const WORLD: [&str; 14] = [
    "std::fs",
    "std::process",
    "std::net",
    "std::env",
    "std::thread",
    "std::os",
    "thread::spawn",
    "SystemTime",
    "Instant",
    "io::stdin",
    "io::stdout",
    "io::stderr",
    "tobj::load_obj",
    "crossbeam_channel",
];
/// The same as members of `use std::{..}`.
const WORLD_MODULES: [&str; 6] = ["fs", "process", "net", "env", "thread", "os"];

const SPEAKING_ONLY_IN: [&str; 2] = ["src/cli/", "src/main.rs"];
const SPEAKING: [&str; 5] = ["println!", "eprintln!", "print!", "eprint!", "dbg!"];

const TERMINAL_ONLY_IN: [&str; 1] = ["src/cli/"];
const TERMINAL: [&str; 2] = ["clap", "indicatif"];

/// Documents are read and written where their format is decided.
const DOCUMENTS_ONLY_IN: [&str; 8] = [
    "src/profile/",
    "src/calibrate/",
    "src/publish/",
    "src/planning/",
    "src/verify/",
    "src/document/",
    "src/workbench/",
    "src/cli/",
];
const DOCUMENTS: [&str; 4] = ["Serialize", "Deserialize", "serde", "serde_json"];

/// A file: its path from the repository's folder, with `/`, and its text.
type Source = (String, String);

/// Everything in `sources` that breaks a rule, as `path:line: what`.
fn findings(sources: &[Source]) -> Vec<String> {
    sources.iter().flat_map(|source| findings_in(source, sources)).collect()
}

fn findings_in((path, text): &Source, sources: &[Source]) -> Vec<String> {
    let mut found = Vec::new();
    if !text.starts_with("//!") && !text.starts_with("#![doc") {
        found.push(format!("{path}:1: no //! header that says what the file is for"));
    }
    let Some(room) = room_of(path) else { return found };
    if floor_of(room).is_none() && room != "lib" {
        found.push(format!("{path}:1: unknown room {room:?}; give it a floor in tests/it/rooms.txt"));
        return found;
    }
    if let Some(parent_says) = test_file(path, sources) {
        found.extend((!parent_says).then(|| format!("{path}:1: named as tests, but not declared under #[cfg(test)]")));
        return found;
    }
    let code = without_tests(&masked(text));
    let at = |place: usize| format!("{path}:{}", line_of(&code, place));
    found.extend(
        words(&code, "path")
            .into_iter()
            .filter(|&i| code[..i].ends_with("#["))
            .map(|i| format!("{}: #[path] hides where a file belongs", at(i))),
    );
    for (target, place) in imports(path, &code) {
        found.extend(forbidden(room, &target).map(|why| format!("{}: {why}", at(place))));
    }
    let mut confine = |patterns: &[&str], places: &[&str]| {
        if places.iter().any(|place| path.starts_with(place)) {
            return;
        }
        for pattern in patterns {
            for place in words(&code, pattern) {
                found.push(format!("{}: {pattern} belongs in {}", at(place), places.join(", ")));
            }
        }
    };
    confine(&WORLD, &WORLD_ONLY_IN);
    confine(&SPEAKING, &SPEAKING_ONLY_IN);
    confine(&TERMINAL, &TERMINAL_ONLY_IN);
    confine(&DOCUMENTS, &DOCUMENTS_ONLY_IN);
    if !WORLD_ONLY_IN.iter().any(|place| path.starts_with(place)) {
        let grouped = names_after(&code, "std").into_iter().filter(|(_, place)| is_group(&code[*place..]));
        let worldly = grouped.filter(|(name, _)| WORLD_MODULES.contains(&name.as_str()));
        found.extend(
            worldly.map(|(name, place)| format!("{}: std::{name} belongs in {}", at(place), WORLD_ONLY_IN.join(", "))),
        );
    }
    found
}

fn is_group(from_std: &str) -> bool {
    from_std.trim_start_matches("std").trim_start().trim_start_matches("::").trim_start().starts_with('{')
}

/// The room a file of `src/` lies in: its folder, or its own name.
fn room_of(path: &str) -> Option<&str> {
    let inside = path.strip_prefix("src/")?;
    inside.split('/').next().map(|first| first.trim_end_matches(".rs"))
}

fn floor_of(room: &str) -> Option<usize> {
    table("floor").iter().position(|rooms| rooms.contains(&room))
}

/// Every room that `code` names, through `crate::`, `trunnion::` or enough `super::`.
fn imports(path: &str, code: &str) -> Vec<(String, usize)> {
    let modules = path.trim_start_matches("src/").trim_end_matches(".rs").trim_end_matches("/mod");
    let up = vec!["super"; modules.split('/').count()].join("::");
    // `lib.rs` is the root itself, and declares the rooms rather than imports them.
    let roots: &[&str] = if modules == "lib" { &[] } else { &["crate", "trunnion", &up] };
    roots.iter().flat_map(|prefix| names_after(code, prefix)).filter(|(name, _)| !name.is_empty()).collect()
}

/// The module of `room` that a file belongs to; `None` for the room's own `mod.rs`, its tests, and files elsewhere.
fn module_of<'a>(room: &str, path: &'a str) -> Option<&'a str> {
    let inside = path.strip_prefix("src/")?.strip_prefix(room)?.strip_prefix('/')?;
    let mut parts = inside.trim_end_matches(".rs").split('/');
    let first = parts.next()?;
    let tests = inside.trim_end_matches(".rs").split('/').any(|part| matches!(part, "tests" | "testing"));
    (first != "mod" && !tests).then_some(first)
}

/// The folders of `src` that a file lies in, the room first.
fn folders_in(path: &str) -> Vec<&str> {
    let Some(inside) = path.strip_prefix("src/") else { return Vec::new() };
    inside.match_indices('/').map(|(end, _)| &inside[..end]).filter(|folder| !folder.contains("tests")).collect()
}

/// Modules of `room` (or of a folder in one, as `job/pack`) that import each other round in a circle, in that order; empty where there is none.
fn circle(room: &str, sources: &[Source]) -> Vec<String> {
    let mut imports: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for (path, text) in sources {
        let Some(module) = module_of(room, path) else { continue };
        let code = without_tests(&masked(text));
        let own = path.trim_start_matches("src/").trim_end_matches(".rs").trim_end_matches("/mod");
        let up = vec!["super"; own.split('/').count() - room.split('/').count()].join("::");
        for prefix in [up, format!("crate::{}", room.replace('/', "::"))] {
            let names = names_after(&code, &prefix).into_iter().map(|(name, _)| name).filter(|name| name != module);
            imports.entry(module).or_default().extend(names);
        }
    }
    // Taking away, over and over, what imports nothing that is left, leaves the circles and what leads to them.
    loop {
        let left: BTreeSet<String> = imports.keys().map(|module| (*module).to_owned()).collect();
        let before = imports.len();
        imports.retain(|_, names| names.iter().any(|name| left.contains(name)));
        if imports.len() == before {
            break;
        }
    }
    let mut way: Vec<String> = imports.keys().next().map(|first| (*first).to_owned()).into_iter().collect();
    while let Some(names) = way.last().and_then(|last| imports.get(last.as_str())) {
        let Some(next) = names.iter().find(|name| imports.contains_key(name.as_str())) else { break };
        let known = way.iter().position(|module| module == next);
        way.push(next.clone());
        if let Some(start) = known {
            return way.split_off(start);
        }
    }
    Vec::new()
}

/// Why `room` may not import `target`.
fn forbidden(room: &str, target: &str) -> Option<String> {
    if room == target || target == "self" {
        return None;
    }
    let own = floor_of(room)?;
    let Some(theirs) = floor_of(target) else {
        return Some(format!("imports {target:?}, which is no room; rooms are imported by name"));
    };
    if let Some((_, _, why)) = NEVER.iter().find(|(from, to, _)| *from == room && to.contains(&target)) {
        return Some(format!("{room} never imports {target}: {why}"));
    }
    if target == "fixtures" && !FIXTURES_ONLY_IN.contains(&room) {
        return Some(format!("{room} imports fixtures, which are for tests"));
    }
    (theirs >= own).then(|| format!("{room} (floor {}) imports {target} (floor {})", own + 1, theirs + 1))
}

/// For a file that is named as tests (or lies in such a folder): whether its parent declares it under `#[cfg(test)]`.
fn test_file(path: &str, sources: &[Source]) -> Option<bool> {
    let parts: Vec<&str> = path.trim_end_matches(".rs").split('/').collect();
    let named = parts.iter().position(|part| matches!(*part, "tests" | "testing"))?;
    let folder = parts[..named].join("/");
    let parents = [format!("{folder}/mod.rs"), format!("{folder}.rs"), format!("{folder}/lib.rs")];
    let parent = sources.iter().find(|(path, _)| parents.contains(path));
    let declared = |text: &str| {
        let code = masked(text);
        let plain: String = code.split_whitespace().collect::<Vec<_>>().join(" ");
        let name = parts[named];
        ["mod", "pub(super) mod"].iter().any(|m| plain.contains(&format!("#[cfg(test)] {m} {name};")))
    };
    Some(parent.is_some_and(|(_, text)| declared(text)))
}

/// Folders that exist only on somebody's own machine. Put together here so that this file does not name them.
fn machine_paths(path: &str, text: &str) -> Vec<String> {
    let folders = ["work", "home", "root", "Users", "workspace"].map(|name| format!("/{name}/"));
    let names =
        |line: &str| folders.iter().any(|folder| line.contains(folder)) || line.contains(&["C:", "\\"].concat());
    let lines = text.lines().enumerate().filter(|(_, line)| names(line));
    lines.map(|(i, line)| format!("{path}:{}: names a folder of one machine: {}", i + 1, line.trim())).collect()
}

/// Text files under `folder`, in the order of their names.
fn files(folder: &Path, wanted: &[&str]) -> Vec<Source> {
    let mut found = Vec::new();
    let Ok(entries) = std::fs::read_dir(folder) else { return found };
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    paths.sort();
    for path in paths {
        let name = path.to_string_lossy().replace('\\', "/");
        if path.is_dir() {
            found.extend(files(&path, wanted));
        } else if wanted.iter().any(|ending| name.ends_with(ending)) {
            let from_root = path.strip_prefix(root()).expect("below the root").to_string_lossy().replace('\\', "/");
            found.push((from_root, std::fs::read_to_string(&path).expect("text")));
        }
    }
    found
}

fn none(findings: &[String]) {
    assert!(findings.is_empty(), "\n{}", findings.join("\n"));
}

#[test]
fn every_room_imports_only_from_floors_below() {
    let sources = files(&root().join("src"), &[".rs"]);
    assert!(sources.len() > 50, "only {} files were read", sources.len());
    none(&findings(&sources));
    // A quote misread would blank what follows it, and with it the offence: the braces would no longer match.
    for (path, text) in &sources {
        let code = masked(text);
        assert_eq!(code.matches('{').count(), code.matches('}').count(), "{path} is misread");
        assert!(text.len() < 200 || code.contains([';', '{']) || path == "src/lib.rs", "{path} is blanked");
    }
}

#[test]
fn modules_form_no_circle_at_any_depth() {
    let sources = files(&root().join("src"), &[".rs"]);
    let folders: BTreeSet<&str> = sources.iter().flat_map(|(path, _)| folders_in(path)).collect();
    assert!(folders.contains("job") && folders.contains("job/pack"), "{folders:?}");
    let found: Vec<String> = folders
        .into_iter()
        .map(|folder| (folder, circle(folder, &sources)))
        .filter(|(_, way)| !way.is_empty())
        .map(|(folder, way)| format!("{folder}: {}", way.join(" -> ")))
        .collect();
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn a_circle_of_modules_is_found() {
    let made = |files: &[(&str, &str)]| -> Vec<Source> {
        files.iter().map(|&(path, text)| (path.to_owned(), text.to_owned())).collect()
    };
    let house = made(&[
        ("src/mesh/mod.rs", "mod a; mod b; mod c; pub use a::A;"),
        ("src/mesh/d.rs", "use super::a::A;"),
        ("src/mesh/a.rs", "use super::b::{B, Other};"),
        ("src/mesh/b/inner.rs", "use super::super::c::C;"),
        ("src/mesh/c.rs", "use crate::mesh::a;"),
    ]);
    assert_eq!(circle("mesh", &house), ["a", "b", "c", "a"]);
    let tests_may = made(&[
        ("src/mesh/a.rs", "use super::b::B;\n#[cfg(test)]\nmod tests { use super::super::c::C; }"),
        ("src/mesh/b.rs", "// use super::a::A;\nuse super::b::c;"),
        ("src/mesh/c/tests.rs", "use super::super::a::A;"),
    ]);
    assert_eq!(circle("mesh", &tests_may), Vec::<String>::new());
}

/// What files of `room`'s folders import from the room's top instead of from where it is made.
fn from_the_top(room: &str, sources: &[Source]) -> Vec<String> {
    let inside: BTreeSet<&str> = sources.iter().filter_map(|(path, _)| module_of(room, path)).collect();
    let mut found = Vec::new();
    for (path, text) in sources {
        if module_of(room, path).is_none() || test_file(path, sources) == Some(true) {
            continue;
        }
        let code = without_tests(&masked(text));
        let own = path.trim_start_matches("src/").trim_end_matches(".rs").trim_end_matches("/mod");
        let up = vec!["super"; own.split('/').count() - 1].join("::");
        let names = [up, format!("crate::{room}")].into_iter().flat_map(|prefix| names_after(&code, &prefix));
        let above = names.filter(|(name, _)| !name.is_empty() && !inside.contains(name.as_str()) && name != "super");
        found.extend(above.map(|(name, place)| format!("{path}:{}: {name}", line_of(&code, place))));
    }
    found
}

#[test]
fn no_job_imports_from_the_hall() {
    let sources = files(&root().join("src"), &[".rs"]);
    none(&from_the_top("job", &sources));
    let made = [
        ("src/job/mod.rs", "mod print; mod send; pub use print::Verified;"),
        ("src/job/print/mod.rs", "pub struct Verified;"),
        (
            "src/job/send/mod.rs",
            "use super::print::Verified;\nuse super::{Verified as V};\nuse crate::job::{print, Verified};",
        ),
        ("src/job/send/again.rs", "use super::Stream;\nuse super::super::Verified;"),
    ];
    let made = made.map(|(path, text)| (path.to_owned(), text.to_owned()));
    let found =
        ["src/job/send/mod.rs:2: Verified", "src/job/send/mod.rs:3: Verified", "src/job/send/again.rs:2: Verified"];
    assert_eq!(from_the_top("job", &made), found);
}

/// The public types that several files define.
fn twice(sources: &[Source]) -> BTreeSet<String> {
    let mut seen = BTreeSet::new();
    let mut again = BTreeSet::new();
    for (path, text) in sources {
        if test_file(path, sources) == Some(true) {
            continue;
        }
        for line in without_tests(&masked(text)).lines() {
            let name = ["struct", "enum", "trait", "type"].iter().find_map(|kind| {
                let rest = line.strip_prefix("pub ")?.strip_prefix(kind)?.strip_prefix(' ')?;
                Some(rest.chars().take_while(|c| c.is_alphanumeric()).collect::<String>())
            });
            again.extend(name.filter(|name| !seen.insert(name.clone())));
        }
    }
    again
}

#[test]
fn a_public_type_has_a_name_of_its_own() {
    assert_eq!(twice(&files(&root().join("src"), &["rs"])), BTreeSet::new());
    let made_up = |second: &str| {
        let house = [("src/a/mod.rs", "pub struct Nut;\nstruct Bolt;\n"), ("src/b/mod.rs", second)];
        twice(&house.map(|(path, text)| (path.to_owned(), text.to_owned())))
    };
    assert_eq!(made_up("pub enum Nut<'a> {}\n"), ["Nut".to_owned()].into());
    assert_eq!(made_up("pub(crate) struct Nut;\npub struct Bolt;\n// pub struct Nut;\n"), BTreeSet::new());
}

/// The rooms that a user of the library sees: the public modules of `src/lib.rs` that its documentation does not hide.
fn shown(lib: &str) -> Vec<String> {
    let (mut rooms, mut hidden) = (Vec::new(), false);
    for line in masked(lib).lines().map(str::trim) {
        if line.starts_with("#[") {
            hidden |= line.starts_with("#[doc(hidden)]");
            continue;
        }
        let name = line.strip_prefix("pub mod ").and_then(|rest| rest.strip_suffix(';'));
        rooms.extend(name.filter(|_| !hidden).map(str::to_owned));
        hidden &= line.is_empty();
    }
    rooms
}

/// Whether the `//!` header of `text` has a code block that rustdoc runs, with an assertion in it.
fn has_example(text: &str) -> bool {
    let runs = |words: &str| {
        let mut words = words.split([',', ' ']).filter(|word| !word.is_empty());
        words.all(|word| ["rust", "should_panic", "standalone_crate"].contains(&word) || word.starts_with("edition"))
    };
    let mut block = None;
    text.lines().map_while(|line| line.strip_prefix("//!")).map(str::trim).any(|line| {
        match line.strip_prefix("```") {
            Some(words) => block = if block.is_none() { Some(runs(words)) } else { None },
            None => return block == Some(true) && line.contains("assert"),
        }
        false
    })
}

/// Rooms that a user sees whose header shows nothing that runs.
fn without_example(sources: &[Source]) -> Vec<String> {
    let lib = sources.iter().find(|(path, _)| path == "src/lib.rs").map(|(_, text)| shown(text));
    let bare = |room: String| {
        let paths = [format!("src/{room}/mod.rs"), format!("src/{room}.rs")];
        let source = sources.iter().find(|(path, _)| paths.contains(path));
        let why = "no example in its //! header that runs and asserts something";
        (!source.is_some_and(|(_, text)| has_example(text))).then(|| format!("{room}: {why}"))
    };
    lib.into_iter().flatten().filter_map(bare).collect()
}

#[test]
fn every_public_room_begins_with_an_example_that_runs() {
    let sources = files(&root().join("src"), &[".rs"]);
    let lib = sources.iter().find(|(path, _)| path == "src/lib.rs").expect("a library");
    assert!(shown(&lib.1).len() > 20, "{:?}", shown(&lib.1));
    none(&without_example(&sources));
}

#[test]
fn a_room_without_an_example_is_found() {
    let found = |header: &str| {
        let lib =
            "//! ```\n//! assert!(true);\n//! ```\n#[doc(hidden)]\npub mod cli;\npub mod nut;\npub(crate) mod bolt;\n";
        let house = [("src/lib.rs", lib), ("src/nut/mod.rs", header), ("src/cli/mod.rs", ""), ("src/bolt.rs", "")];
        without_example(&house.map(|(path, text)| (path.to_owned(), text.to_owned())))
    };
    let bare = ["nut: no example in its //! header that runs and asserts something"];
    assert_eq!(found("//! Nuts.\n"), bare);
    // A diagram is none, nor what is not run, nor what asserts nothing, nor the example of an item.
    assert_eq!(found("//! ```text\n//! nut --assert--> bolt\n//! ```\n//! assert\n"), bare);
    for words in ["ignore", "no_run", "rust,no_run", "compile_fail", "toml"] {
        assert_eq!(found(&format!("//! ```{words}\n//! assert!(true);\n//! ```\n")), bare, "{words}");
    }
    assert_eq!(found("//! ```\n//! println!();\n//! ```\n"), bare);
    assert_eq!(found("//! Nuts.\n\n/// ```\n/// assert!(true);\n/// ```\npub fn nut() {}\n"), bare);
    for words in ["", "rust", "rust, edition2024"] {
        let header = format!("//! ```text\n//! diagram\n//! ```\n//!\n//! ```{words}\n//! assert!(true);\n//! ```\n");
        none(&found(&header));
    }
}

/// The command is arguments and text: what it does, and how a result is written as a document, others need too.
///
/// The flags themselves (`cli/args`) are a list that grows with what can be asked, and do nothing.
#[test]
fn the_command_stays_thin() {
    let sources = files(&root().join("src/cli"), &[".rs"]);
    let doing = || sources.iter().filter(|(name, _)| !name.contains("args/"));
    let lines: usize = doing().map(|(_, text)| text.lines().count()).sum();
    assert!(doing().count() > 10 && lines < 2_350, "{lines} lines in {} files of src/cli", doing().count());
}

/// What `scripts/test.sh --changed` goes by.
#[test]
fn every_module_of_tests_is_about_rooms_that_there_are_and_every_room_has_one() {
    let declared = include_str!("main.rs").lines().filter_map(|line| line.strip_prefix("mod ")?.strip_suffix(';'));
    // They have no tests of their own.
    let declared: BTreeSet<&str> = declared.filter(|module| !["support", "solids"].contains(module)).collect();
    let about = table("test");
    assert_eq!(about.iter().map(|words| words[0]).collect::<BTreeSet<_>>(), declared);
    let rooms: BTreeSet<&str> = table("floor").concat().into_iter().collect();
    let proved: BTreeSet<&str> =
        about.iter().filter(|words| words[0] != "architecture").flat_map(|words| words[1..].to_vec()).collect();
    assert!(proved.is_subset(&rooms), "{:?}", proved.difference(&rooms));
    let mut bare: Vec<&&str> = rooms.difference(&proved).collect();
    bare.retain(|room| **room != "fixtures");
    assert!(bare.is_empty(), "no module of tests is about {bare:?}");
}

#[test]
fn no_file_names_a_folder_of_one_machine() {
    let kinds = [".rs", ".md", ".toml", ".py", ".sh", ".yml", ".html", ".js"];
    let mut sources = Vec::new();
    let ours = [
        "src",
        "tests",
        "scripts",
        "integrations",
        "firmware-profiles",
        "fixtures",
        "benches",
        ".ci",
        "examples",
        "fuzz/src",
        "fuzz/fuzz_targets",
    ];
    // Not all of python/, where somebody may have built.
    let pythons = ["python/src", "python/trunnion", "python/tests", "python/examples"];
    for folder in ours.into_iter().chain(pythons) {
        sources.extend(files(&root().join(folder), &kinds));
    }
    for file in ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "Cargo.toml", ".ci/run"] {
        sources.extend(std::fs::read_to_string(root().join(file)).ok().map(|text| (file.to_owned(), text)));
    }
    none(&sources.iter().flat_map(|(path, text)| machine_paths(path, text)).collect::<Vec<_>>());
}

/// The findings of a house of one or more made-up files, their headers given.
fn house(files: &[(&str, &str)]) -> Vec<String> {
    findings(&files.iter().map(|&(path, text)| (path.to_owned(), format!("//! x\n{text}"))).collect::<Vec<_>>())
}

#[test]
fn an_upward_import_is_found() {
    assert_eq!(
        house(&[("src/mesh/read.rs", "use crate::planning::Plan;")]),
        ["src/mesh/read.rs:2: mesh (floor 2) imports planning (floor 6)"]
    );
    assert_eq!(
        house(&[("src/geom/mod.rs", "pub use super::gcode::lines;")]),
        ["src/geom/mod.rs:2: geom (floor 1) imports gcode (floor 1)"]
    );
    assert_eq!(
        house(&[("src/orient/a/b.rs", "\nuse crate::{\n    geom::Vec3,\n    toolpath::{Layer, Item},\n};")]),
        ["src/orient/a/b.rs:3: orient (floor 5) imports toolpath (floor 7)"]
    );
    assert_eq!(
        house(&[("src/cli/mod.rs", "fn f() { trunnion::main::x() }")]),
        ["src/cli/mod.rs:2: cli (floor 14) imports main (floor 15)"]
    );
    assert_eq!(
        house(&[("src/orient/a/b.rs", "use super::super::super::verify::Finding;")]),
        ["src/orient/a/b.rs:2: orient (floor 5) imports verify (floor 8)"]
    );
}

#[test]
fn a_way_round_the_names_is_found() {
    assert_eq!(
        house(&[("src/mesh/x.rs", "use crate::*;")]),
        ["src/mesh/x.rs:2: imports \"*\", which is no room; rooms are imported by name"]
    );
    assert_eq!(
        house(&[("src/mesh/x.rs", "#[path = \"../cli/x.rs\"]\nmod y;")]),
        ["src/mesh/x.rs:2: #[path] hides where a file belongs"]
    );
    let sly = [("src/mesh/mod.rs", "mod testing;"), ("src/mesh/testing.rs", "use std::fs;")];
    assert_eq!(house(&sly), ["src/mesh/testing.rs:1: named as tests, but not declared under #[cfg(test)]"]);
}

#[test]
fn what_verify_and_motion_must_not_know_is_found() {
    assert_eq!(
        house(&[("src/verify/mod.rs", "use crate::toolpath::Layer;")]),
        ["src/verify/mod.rs:2: verify never imports toolpath: it must not share the code it checks"]
    );
    assert_eq!(
        house(&[("src/verify/mod.rs", "fn f() { crate::slicing::find() }")]),
        ["src/verify/mod.rs:2: verify never imports slicing: it must not share the code it checks"]
    );
    assert_eq!(
        house(&[("src/motion/limits.rs", "use crate::profile::Profile;")]),
        ["src/motion/limits.rs:2: motion never imports profile: profiles build its types"]
    );
    assert_eq!(
        house(&[("src/planning/plan.rs", "use crate::fixtures::cube;")]),
        ["src/planning/plan.rs:2: planning imports fixtures, which are for tests"]
    );
}

#[test]
fn touching_the_world_is_found() {
    let places = WORLD_ONLY_IN.join(", ");
    for (text, what) in [
        ("use std::fs;", "std::fs"),
        ("fn f() { std::process::exit(1) }", "std::process"),
        ("use std::net::TcpStream;", "std::net"),
        ("fn f() { std::env::var(\"A\"); }", "std::env"),
        ("use std::time::Instant;", "Instant"),
        ("use std::time::SystemTime;", "SystemTime"),
        ("use std::{collections::BTreeMap, fs::File};", "std::fs"),
        ("fn f() { std::io::stdout(); }", "io::stdout"),
    ] {
        assert_eq!(house(&[("src/mesh/x.rs", text)]), [format!("src/mesh/x.rs:2: {what} belongs in {places}")]);
    }
    let spawned = house(&[("src/planning/x.rs", "fn f() { std::thread::spawn(g); }")]);
    assert!(spawned.iter().any(|f| f.contains("thread::spawn belongs in")), "{spawned:?}");
    for place in
        ["src/cli/io.rs", "src/world/disk.rs", "src/slicing/process.rs", "src/link/serial/line.rs", "src/main.rs"]
    {
        none(&house(&[(place, "use std::{env, fs}; use std::time::Instant; fn f() { std::thread::spawn(g); }")]));
    }
}

#[test]
fn speaking_parsing_flags_and_documents_out_of_place_are_found() {
    assert_eq!(
        house(&[("src/geom/x.rs", "fn f() {\n    println!(\"x\");\n}")]),
        ["src/geom/x.rs:3: println! belongs in src/cli/, src/main.rs"]
    );
    assert_eq!(house(&[("src/verify/x.rs", "use clap::Parser;")]), ["src/verify/x.rs:2: clap belongs in src/cli/"]);
    assert_eq!(
        house(&[("src/mesh/x.rs", "#[derive(Clone, Serialize)]\nstruct A;")]),
        [
            "src/mesh/x.rs:2: Serialize belongs in src/profile/, src/calibrate/, src/publish/, src/planning/, src/verify/, src/document/, src/workbench/, src/cli/"
        ]
    );
}

#[test]
fn an_unknown_room_is_found_so_that_nobody_forgets_its_floor() {
    assert_eq!(
        house(&[("src/helpers/mod.rs", "")]),
        ["src/helpers/mod.rs:1: unknown room \"helpers\"; give it a floor in tests/it/rooms.txt"]
    );
    assert_eq!(
        house(&[("src/utils.rs", "")])[0],
        "src/utils.rs:1: unknown room \"utils\"; give it a floor in tests/it/rooms.txt"
    );
}

#[test]
fn a_file_without_a_header_is_found() {
    let bare = [("src/geom/x.rs".to_owned(), "use std::fmt;\n".to_owned())];
    assert_eq!(findings(&bare), ["src/geom/x.rs:1: no //! header that says what the file is for"]);
}

#[test]
fn a_folder_of_one_machine_is_found() {
    let line = format!("let x = 1;\nlet path = \"/{}/me/model.stl\";", "home");
    assert_eq!(machine_paths("src/x.rs", &line).len(), 1);
    assert!(machine_paths("src/x.rs", &line)[0].starts_with("src/x.rs:2: names a folder of one machine"));
    assert!(machine_paths("src/x.rs", "see homework/x, at work / home").is_empty());
}

#[test]
fn tests_comments_and_strings_may_say_what_they_like() {
    none(&house(&[
        ("src/mesh/mod.rs", "#[cfg(test)]\nmod tests;\n#[cfg(test)]\nmod testing;\n// std::fs and crate::cli\n"),
        ("src/mesh/tests/mod.rs", "use std::fs; use crate::planning::Plan;"),
        ("src/mesh/testing.rs", "fn f() { println!(\"x\") }"),
        (
            "src/mesh/y.rs",
            "const A: &str = \"use std::fs; println!\";\n#[cfg(test)]\nmod tests { use std::fs; use crate::cli; }",
        ),
        ("src/motion/kinematics.rs", "use crate::geom::Vec3; use super::limits; pub(in crate::motion) fn f() {}"),
    ]));
}
