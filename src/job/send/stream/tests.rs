//! What must leave whatever else hangs: last words and the emergency stop.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::Arc;

use super::*;
use crate::job;
use crate::job::printer;
use crate::job::send::operator::Unattended;
use crate::link::{Header, Program};
use crate::world::{Outputs, Silent, World};

/// When no answer to anybody else comes any more.
const LATER: Time = Duration::from_secs(1);

/// A print that has begun, over a wire whose other end is in our hands; its journal is in `folder`.
fn begun<'a>(folder: &Path, world: &'a World<'a>) -> (Stream<'a>, TcpStream) {
    let profile = job::load_profile(&"generic-ac".into(), world).unwrap().profile;
    let program = Program::read(b"G28\nG1 X1 F600\n", &printer::rules(&profile).unwrap()).unwrap();
    let mut sender = Sender::new(Arc::new(program), printer::settings(&profile).unwrap());
    sender.poll(Time::ZERO);
    sender.poll(LATER);
    sender.receive(LATER, b"ok\n");
    sender.took(sender.pending().len());
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = Address::Tcp(listener.local_addr().unwrap().to_string());
    let port = Port::open(&address, 115_200).unwrap();
    let (far, _) = listener.accept().unwrap();
    far.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let place = Connection {
        timing: Timing::default(),
        address,
        baud: 115_200,
        identity: None,
        devices: PathBuf::new(),
        wait: Duration::ZERO,
    };
    let journal =
        JournalFile::create(&Outputs::new(None).claim(&folder.join("journal")).unwrap(), &Header::default()).unwrap();
    (Stream::new(sender, port, place, journal, world, &Unattended), far)
}

/// What has arrived, up to the first that ends with `end`.
fn heard(far: &mut TcpStream, end: &str) -> String {
    let mut text = String::new();
    let mut byte = [0];
    while !text.ends_with(end) && far.read(&mut byte).is_ok_and(|n| n > 0) {
        text.push(char::from(byte[0]));
    }
    text
}

#[test]
fn heaters_go_off_though_the_journal_takes_nothing() {
    let (folder, world) = (tempfile::tempdir().unwrap(), World::here(&Silent));
    let (mut stream, mut far) = begun(folder.path(), &world);
    stream.journal.takes_nothing();
    assert!(!stream.journal.record(&Record::Away));
    stream.sender.receive(Time::ZERO, b"Error:something new\nok\n");
    assert!(
        matches!(stream.sender.outcome(), Some(Outcome::Stopped(StopReason::Error { .. }))),
        "{:?}",
        stream.sender.outcome()
    );
    assert!(stream.write(), "the last words wait for the journal");
    assert_eq!(heard(&mut far, "M140S0\n").trim_start(), "M104S0\nM140S0\n");
}

#[test]
fn an_emergency_stop_is_on_the_wire_before_anything_else_is_done() {
    let (folder, world) = (tempfile::tempdir().unwrap(), World::here(&Silent));
    let (mut stream, mut far) = begun(folder.path(), &world);
    stream.interrupts = 1;
    stream.interrupted(2).unwrap();
    assert!(heard(&mut far, "M112\n").ends_with("M112\n"));
    // In a pause that came from a full disk the first interrupt is one, as its words say.
    let (mut stream, mut far) = begun(folder.path(), &world);
    (stream.interrupts, stream.paused) = (0, true);
    for _ in 0..4 {
        stream.sender.poll(LATER);
        stream.sender.receive(LATER, b"ok\nok T:20.0 /0.0 B:20.0 /0.0\n");
    }
    assert!(stream.sender.progress().sent > 0 && stream.sender.outcome().is_none());
    stream.interrupted(1).unwrap();
    assert_eq!(stream.sender.outcome(), Some(&Outcome::EmergencyStopped));
    assert!(heard(&mut far, "M112\n").ends_with("M112\n"));
}

#[test]
fn behind_an_emergency_stop_the_host_stays_and_says_whether_the_printer_has_stopped() {
    let (folder, world) = (tempfile::tempdir().unwrap(), World::here(&Silent));
    for (words, said) in [
        ("Error:Printer halted. kill() called!\n", None),
        ("", Some("but the printer has not answered since")),
        (
            " T:180.0 /210.0 B:60.0 /60.0 @:127\n",
            Some(
                "emergency stop sent, but the printer has NOT stopped (it reports \" T:180.0 /210.0 B:60.0 /60.0 @:127\")",
            ),
        ),
    ] {
        let (mut stream, mut far) = begun(folder.path(), &world);
        stream.sender.emergency_stop();
        let printer = std::thread::spawn(move || {
            // As often as a printer that heats says so, until the host has gone.
            while far.write_all(words.as_bytes()).is_ok() && !heard(&mut far, "M112\n").is_empty() {}
        });
        let ended = stream.close(Outcome::EmergencyStopped);
        match said {
            None => assert_eq!(ended.unwrap(), Outcome::EmergencyStopped),
            Some(said) => {
                let text = ended.unwrap_err().to_string();
                assert!(text.contains(said), "{text}");
            }
        }
        drop(stream);
        printer.join().unwrap();
    }
}

#[cfg(unix)]
#[test]
fn last_words_that_the_port_does_not_take_are_said_to_be_unsaid() {
    let (folder, world) = (tempfile::tempdir().unwrap(), World::here(&Silent));
    let (mut stream, _far) = begun(folder.path(), &world);
    // A terminal that nobody reads holds some kilobytes and no more.
    let link = folder.path().join("tty");
    let _unread = crate::link::serial::Server::open(&link.display().to_string()).unwrap();
    let mut port = Port::open(&Address::Device(link), 115_200).unwrap();
    let mut refused = 0;
    while refused < 20 {
        refused = if port.write(b"\n") == 0 { refused + 1 } else { 0 };
        if refused > 0 {
            std::thread::sleep(Duration::from_millis(10));
        }
    }
    stream.port = Some(port);
    stream.sender.emergency_stop();
    let said = stream.close(Outcome::EmergencyStopped).unwrap_err().to_string();
    assert!(
        said.contains("the port does not even accept the stop command") && said.contains("switch the printer off"),
        "{said}"
    );
}
