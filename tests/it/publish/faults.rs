//! An upload of which any call fails: the server has the whole file or nothing, starts it once at most, and what is said is so.

use std::path::Path;

use trunnion::publish::Kind;

use super::KINDS;
use super::server::Server;
use crate::faults::calls::{Fault, faults, harmed, unharmed};
use crate::link::gcode;
use crate::support::{folder, installed, note, skip};

fn survives(kind: Kind, folder: &Path, step: usize) -> [usize; 3] {
    let bytes = std::fs::read(gcode(folder, 30)).unwrap();
    // One server for each run: what an upload has left on it is none of the next one's.
    let words = |server: &Server| {
        let start: &[&str] = if kind == Kind::Moonraker { &["--start"] } else { &[] };
        let to = server.to();
        let words = [&["publish", "part.gcode", "--to", &to, "--unverified", "--json"], start].concat();
        words.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    fn short(words: &[String]) -> Vec<&str> {
        words.iter().map(String::as_str).collect()
    }
    let starts = usize::from(kind == Kind::Moonraker);
    let first = Server::of(kind);
    let injected = faults(folder, &short(&words(&first)), 0, step);
    assert!(first.inside().files.len() == 1 && first.inside().started == starts);
    let (mut refused, mut killed) = (0, 0);
    for one in &injected {
        let server = Server::of(kind);
        let words = words(&server);
        let done = harmed(folder, &short(&words), one);
        // What was killed may have asked for something that the server has not done yet.
        server.settle();
        let what = format!("{kind} {one:?}: {done:?}");
        let (files, started) = {
            let inside = server.inside();
            (inside.files.clone(), inside.started)
        };
        assert!(files.iter().all(|(name, kept)| name == "part.gcode" && *kept == bytes), "{:?}: {what}", files.keys());
        assert!(started <= files.len().min(starts), "{what}");
        match (one.fault, done.code) {
            // Also where the call did not come again: in how many pieces an answer is read depends on time.
            (_, Some(0)) => assert_eq!((files.len(), started), (1, starts), "{what}"),
            (Fault::Error(_), Some(2 | 4)) => {
                assert!(done.says_why(), "{what}");
                refused += 1;
            }
            (Fault::Kill, None) => killed += 1,
            _ => panic!("{what}"),
        }
        // Once more, when nobody prints: it goes, or is there.
        server.inside().printing = None;
        let next = unharmed(folder, &short(&words));
        assert_eq!(next.code, Some(0), "{what}, next {next:?}");
        assert!(server.inside().files.get("part.gcode") == Some(&bytes) && server.inside().files.len() == 1, "{what}");
        assert_eq!(std::fs::read_dir(folder.join("tmp")).unwrap().count(), 0, "{what}");
    }
    [injected.len(), refused, killed]
}

#[test]
fn no_fault_of_an_upload_leaves_half_a_file_or_starts_twice() {
    if !cfg!(target_os = "linux") || !installed("strace") {
        return skip("no strace to make calls fail with");
    }
    let mut all = [0; 3];
    for kind in KINDS {
        let folder = folder();
        std::fs::create_dir(folder.path().join("tmp")).unwrap();
        let counts = survives(kind, folder.path(), 3);
        (0..3).for_each(|i| all[i] += counts[i]);
        note(&format!("publish to {kind}: faults, refused, kills: {counts:?}"));
    }
    assert!(all[1] > 2 && all[2] > 9, "{all:?}");
}
