//! `send` to several printers: each file to its own port, each with its own journal, and one line of text and of exit code for all.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread;

use trunnion::job::{
    At, Operator, OutputFile, Outputs, SendOptions, SendRequest, Sending, SentPrint, Silent, Verified, Wire, World,
    load_profile, send_several,
};
use trunnion::link::serial::Address;

use super::real::{gcode, killed, output, profile, simulate, wait_for, wanted};
use super::two_printers::{Ends, machine, printer};
use crate::support::{Command, folder, said, trunnion};

/// Two files of different lengths, each in a folder of its own.
fn files(dir: &Path) -> [PathBuf; 2] {
    [("one", 300), ("two", 420)].map(|(name, moves)| {
        let folder = dir.join(name);
        std::fs::create_dir(&folder).unwrap();
        gcode(&folder, moves)
    })
}

fn send(pairs: &[(&Path, &Path)], machine: &Path) -> Command {
    let mut command = trunnion();
    command.arg("send").args(["--unverified", "-m"]).arg(machine);
    for (port, file) in pairs {
        command.arg("--port").arg(port).arg(file);
    }
    command
}

fn journal(file: &Path) -> String {
    let name = format!("{}.journal", file.file_name().unwrap().to_str().unwrap());
    std::fs::read_to_string(file.with_file_name(name)).unwrap_or_default()
}

/// What a printer's log says it has done of a file.
fn done(log: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(log).unwrap();
    let lines = text.lines().filter_map(|l| l.split_once(" line ").map(|(_, block)| super::real::plain(block)));
    let own = ["M105", "M110", "M115", "M400", "M114"];
    lines.filter(|l| !own.iter().any(|word| l.starts_with(word))).collect()
}

#[test]
fn each_file_goes_to_its_own_printer_and_one_that_fails_is_named() {
    let dir = folder();
    let (machine, files) = (profile(dir.path()), files(dir.path()));
    let at = |name: &str| dir.path().join(name);
    let ports = [at("tty1"), at("tty2")];
    for fails in [false, true] {
        let logs = [at("1.log"), at("2.log")];
        let fault: &[&str] = if fails { &["--fault", "fatal@200"] } else { &[] };
        let log = |i: usize| ["--speed", "max", "--log", logs[i].to_str().unwrap()];
        let _printers =
            [simulate(&ports[0], &machine, &[&log(0)[..], fault].concat()), simulate(&ports[1], &machine, &log(1))];
        let pairs = [(&*ports[0], &*files[0]), (&*ports[1], &*files[1])];
        let out = output(send(&pairs, &machine).arg("--json"));
        assert_eq!(out.status.code(), Some(if fails { 4 } else { 0 }), "{}", said(&out));
        let text = String::from_utf8(out.stdout.clone()).unwrap();
        let events: Vec<serde_json::Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
        let (last, events) = events.split_last().unwrap();
        let named = |event: &serde_json::Value| {
            event["port"].as_str().is_some_and(|p| p.ends_with("tty1") || p.ends_with("tty2"))
        };
        assert!(events.iter().all(named), "{text}");
        let prints = last["prints"].as_array().unwrap();
        assert_eq!((&last["event"], prints.len()), (&"ended".into(), 2));
        assert_eq!([&prints[0]["ok"], &prints[1]["ok"]], [&serde_json::json!(!fails), &serde_json::json!(true)]);
        assert_eq!(prints[1]["file"], files[1].to_str().unwrap());
        if fails {
            let stderr = String::from_utf8(out.stderr.clone()).unwrap();
            let why = format!("1 of 2 prints failed; {}: {}: ", ports[0].display(), files[0].display());
            assert!(stderr.contains(&why) && stderr.contains("Thermal Runaway"), "{stderr}");
            assert!(prints[0]["error"].as_str().unwrap().contains("Thermal Runaway"));
        } else {
            assert_eq!(done(&logs[0]), wanted(&files[0]));
        }
        assert_eq!(done(&logs[1]), wanted(&files[1]));
        assert_eq!(journal(&files[0]).contains("\ndone"), !fails);
        assert!(journal(&files[1]).contains("\ndone"));
    }
}

#[test]
fn what_does_not_belong_together_begins_nothing() {
    let dir = folder();
    let (machine, files) = (profile(dir.path()), files(dir.path()));
    let at = |name: &str| dir.path().join(name);
    let (port, other, log) = (at("tty1"), at("by-id"), at("1.log"));
    let _printer = simulate(&port, &machine, &["--log", log.to_str().unwrap()]);
    std::os::unix::fs::symlink(&port, &other).unwrap();
    let (gone, nowhere) = (at("gone.gcode"), at("nowhere"));
    let refused = |command: &mut Command, code: i32, words: &str| {
        let out = output(command);
        assert!(out.status.code() == Some(code) && said(&out).contains(words), "{words}: {}", said(&out));
        assert!(files.iter().all(|f| journal(f).is_empty()), "a journal was begun");
    };
    let [one, two] = [&*files[0], &*files[1]];
    refused(&mut send(&[(&port, one), (&port, two)], &machine), 2, "two prints cannot use one port");
    refused(&mut send(&[(&port, one), (&other, two)], &machine), 2, "two prints cannot use one port");
    refused(&mut send(&[(&port, one), (&nowhere, &gone)], &machine), 2, "gone.gcode");
    refused(&mut send(&[(&port, one), (&nowhere, two)], &machine), 4, "no such port");
    refused(&mut send(&[(&port, one), (&nowhere, one)], &machine), 2, "is also another output");
    refused(send(&[(&port, one)], &machine).arg(two), 2, "2 files have 1 --port; give one for each file");
    refused(send(&[(&port, one)], &machine).arg("--port").arg(&nowhere), 2, "1 file has 2 --ports");
    refused(
        send(&[(&port, one), (&nowhere, two)], &machine).arg("--journal").arg(at("j")),
        2,
        "--journal applies to one print",
    );
    refused(send(&[(&port, one), (&nowhere, two)], &machine).arg("--dry-run"), 2, "--dry-run takes one file");
    let mut plans = trunnion();
    plans
        .arg("send")
        .arg(one)
        .arg(two)
        .arg("--port")
        .arg(&port)
        .arg("--port")
        .arg(&nowhere)
        .arg("--plan")
        .arg(at("p.json"));
    refused(&mut plans, 2, "2 files have 1 --plan");
    // Not even a question has reached the printer.
    assert_eq!(std::fs::read_to_string(&log).unwrap().lines().filter(|l| l.contains(" line ")).count(), 0);
}

/// One printer hangs in the middle of its print, and its host's words with it; Ctrl-C twice stops the other.
#[test]
fn a_printer_that_hangs_does_not_delay_the_emergency_stop_of_another() {
    let dir = folder();
    let (machine, files) = (profile(dir.path()), files(dir.path()));
    let at = |name: &str| dir.path().join(name);
    let (ports, logs) = ([at("tty1"), at("tty2")], [at("1.log"), at("2.log")]);
    let start = |i: usize| simulate(&ports[i], &machine, &["--log", logs[i].to_str().unwrap()]);
    let printers = [start(0), start(1)];
    let mut host = send(&[(&ports[0], &files[0]), (&ports[1], &files[1])], &machine);
    let host = super::real::Running(host.arg("-q").stderr(std::process::Stdio::null()).spawn().unwrap());
    let moves = |log: &Path| std::fs::read_to_string(log).unwrap_or_default().matches(" line G1X").count();
    wait_for("the prints", || logs.iter().all(|log| moves(log) > 3));
    let stopped = Command::new("kill").args(["-STOP", &printers[0].running.0.id().to_string()]).status().unwrap();
    assert!(stopped.success());
    for _ in 0..2 {
        super::real::interrupt(&host.0);
        thread::sleep(std::time::Duration::from_millis(20));
    }
    wait_for("the emergency stop of the other", || killed(&logs[1]));
    let mut host = host;
    wait_for("the host's end", || host.0.try_wait().unwrap().is_some());
    assert_eq!(host.0.wait().unwrap().code(), Some(4));
    assert!(!journal(&files[0]).contains("\ndone") && !journal(&files[1]).contains("\ndone"));
}

/// Whoever stands by one of two: what `told` does with its thread, and how often it asks to end.
struct Watcher<'a> {
    told: &'a (dyn Fn(&Sending<'_>) + Sync),
    interrupts: &'a (dyn Fn() -> u32 + Sync),
}

impl Operator for Watcher<'_> {
    fn told(&self, what: &Sending<'_>, _: At) {
        (self.told)(what);
    }

    fn interrupts(&self) -> u32 {
        (self.interrupts)()
    }
}

/// The thread of one print is held up for good by its screen; the other one's emergency stop comes all the same, before it goes on.
#[test]
fn a_print_whose_thread_is_held_up_holds_up_no_other() {
    let dir = folder();
    let files = files(dir.path());
    let world = World::here(&Silent);
    let (ended, held, free) = (AtomicBool::new(false), AtomicBool::new(false), AtomicBool::new(false));
    let asked = AtomicU32::new(0);
    let places = [OnceLock::new(), OnceLock::new()];
    thread::scope(|scope| {
        let _end = Ends(&ended);
        let printers = [0, 1].map(|i| {
            let (place, ended) = (&places[i], &ended);
            scope.spawn(move || printer("marlin", &[], place, ended))
        });
        wait_for("the printers", || places.iter().all(|p| p.get().is_some()));
        let machine = load_profile(&machine("marlin"), &world).unwrap();
        let programs = files.each_ref().map(|f| Verified::unverified(std::fs::read(f).unwrap()));
        let mut outputs = Outputs::new([]);
        let journals: [OutputFile; 2] = files.each_ref().map(|f| outputs.claim(&f.with_extension("journal")).unwrap());
        let addresses = places.each_ref().map(|p| Address::parse(p.get().unwrap()));
        let options = SendOptions::default();
        let prints = [0, 1].map(|i| SentPrint {
            request: SendRequest {
                path: &files[i],
                program: &programs[i],
                machine: &machine,
                plan: None,
                options: &options,
            },
            wire: Wire { address: &addresses[i], journal: &journals[i] },
        });
        let hold = |what: &Sending<'_>| {
            if matches!(what, Sending::Printer(_)) {
                held.store(true, Ordering::SeqCst);
                wait_for("the other's stop", || free.load(Ordering::SeqCst));
            }
        };
        // The second one is asked to end twice while the first hangs, and lets it go once it has said that it is stopped.
        let let_go = |what: &Sending<'_>| {
            if matches!(what, Sending::Stopped { .. }) {
                free.store(true, Ordering::SeqCst);
            }
        };
        let stop = || {
            wait_for("the first to hang", || held.load(Ordering::SeqCst));
            u32::from(asked.fetch_add(1, Ordering::SeqCst) > 40) * 2
        };
        let watcher = |index: usize| -> Box<dyn Operator + '_> {
            match index {
                0 => Box::new(Watcher { told: &hold, interrupts: &|| 0 }),
                _ => Box::new(Watcher { told: &let_go, interrupts: &stop }),
            }
        };
        let ended_as = send_several(&prints, false, &world, &watcher).unwrap();
        ended.store(true, Ordering::SeqCst);
        let logs = printers.map(|printer| printer.join().unwrap());
        let why: Vec<Option<String>> = ended_as.iter().map(|e| e.error.as_ref().map(ToString::to_string)).collect();
        assert!(why[0].is_none() && why[1].as_ref().is_some_and(|w| w.contains("emergency stop")), "{why:?}");
        assert!(!logs[0].iter().any(|l| l == "killed") && logs[1].iter().any(|l| l == "killed"));
    });
}
