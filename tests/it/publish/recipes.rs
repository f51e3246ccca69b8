//! The recipes of `docs/how-to/publish.md`, run as they are printed, with a small server at each address.

use std::path::Path;
use std::process::Command;

use trunnion::publish::Kind;

use super::server::Server;
use crate::support::{folder, root, said};

#[test]
fn of_publishing() {
    let text = std::fs::read_to_string(root().join("docs/how-to/publish.md")).unwrap();
    let blocks: Vec<&str> = text.split("```sh\n").skip(1).map(|piece| piece.split("```").next().unwrap()).collect();
    assert!(blocks.len() >= 3, "{} blocks", blocks.len());
    let own = Path::new(env!("CARGO_BIN_EXE_trunnion")).parent().unwrap();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(own.to_owned()).chain(std::env::split_paths(&path))).unwrap();
    for block in blocks {
        let servers = [
            ("http://octopi.local", Server::of(Kind::OctoPrint)),
            ("http://mainsail.local", Server::of(Kind::Moonraker)),
            ("http://duet.local", Server::of(Kind::Duet)),
        ];
        let mut here = block.to_owned();
        for (printed, server) in &servers {
            server.inside().key = Some("0123456789".to_owned());
            here = here.replace(printed, &server.url());
        }
        let folder = folder();
        std::os::unix::fs::symlink(root().join("fixtures"), folder.path().join("fixtures")).unwrap();
        std::fs::write(folder.path().join("printer.key"), "0123456789\n").unwrap();
        let mut shell = Command::new("sh");
        let run = shell.args(["-e", "-c", &here]).current_dir(folder.path()).env("PATH", &path).output().unwrap();
        assert!(run.status.success(), "{block}{}", said(&run));
        for (printed, server) in &servers {
            let inside = server.inside();
            assert_eq!(inside.files.contains_key("tree.gcode"), block.contains(printed), "{block}");
            assert_eq!(inside.started > 0, block.contains(printed) && block.contains("--start"), "{block}");
        }
    }
}
