//! `trunnion publish`: a file goes to a server once, the same bytes, and is started only when asked; every bad day is a sentence.

mod answers;
#[cfg(unix)]
mod faults;
mod octoprint;
mod recipes;
mod scissors;
mod server;
mod shown;
mod thumbnails;

use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Output;
use std::sync::{Arc, OnceLock};

use serde_json::{Value, json};
use trunnion::publish::Kind;

use crate::pipeline::{fixture, prepare};
use crate::support::{Command, folder, said, skip, trunnion};
pub(crate) use server::Server;
use server::{Door, Hitch};

/// A key that must be seen nowhere.
pub(crate) const KEY: &str = "OPEN-SESAME-0123456789ABCDEF";

/// A prepared program, its plan and the report of its verification; made once.
pub(super) struct Prepared {
    _folder: tempfile::TempDir,
    pub(super) gcode: PathBuf,
    pub(super) plan: PathBuf,
    pub(super) bytes: Vec<u8>,
    pub(super) report: Value,
}

pub(super) fn prepared() -> &'static Prepared {
    prepared_for(Kind::OctoPrint)
}

/// The same for the firmware behind a server of this kind.
pub(super) fn prepared_for(kind: Kind) -> &'static Prepared {
    static MADE: [OnceLock<Prepared>; 3] = [const { OnceLock::new() }; 3];
    let (index, machine) = match kind {
        Kind::OctoPrint => (0, "generic-ac"),
        Kind::Moonraker => (1, "fractal-5-pro"),
        Kind::Duet => (2, "open5x-voron0"),
    };
    MADE[index].get_or_init(|| {
        let folder = folder();
        let (gcode, plan) = (folder.path().join("tree.gcode"), folder.path().join("plan.json"));
        let document = prepare(&fixture("y-tree"), machine, "builtin", &gcode, &["--plan-out", plan.to_str().unwrap()]);
        let bytes = std::fs::read(&gcode).unwrap();
        Prepared { _folder: folder, gcode, plan, bytes, report: document["verify"].clone() }
    })
}

/// `publish` of the prepared program, with the key.
pub(super) fn publish(to: &str, more: &[&str]) -> Command {
    let kind = KINDS.into_iter().find(|kind| to.starts_with(kind.word())).unwrap_or(Kind::OctoPrint);
    let made = prepared_for(kind);
    let mut command = of(&made.gcode, to, more);
    command.arg("--plan").arg(&made.plan);
    command
}

/// The same of any file, without a plan.
pub(super) fn of(file: &Path, to: &str, more: &[&str]) -> Command {
    let mut command = trunnion();
    command.arg("publish").arg(file).args(["--to", to, "--json"]).args(more);
    command.env("TRUNNION_KEY", KEY).env_remove("SSL_CERT_FILE");
    command
}

/// The document of a call that succeeds.
#[track_caller]
pub(super) fn done(command: &mut Command) -> Value {
    let run = command.output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    keeps_the_key(&run);
    serde_json::from_slice(&run.stdout).unwrap()
}

/// That a call fails with this exit code, and as [`crate::support::fails`] says.
#[track_caller]
pub(super) fn fails(command: &mut Command, exit: i32, wanted: &str) {
    let run = command.output().unwrap();
    assert_eq!(run.status.code(), Some(exit), "{}", said(&run));
    assert!(wanted.is_empty() || crate::support::fails(&said(&run), wanted), "wanted {wanted:?}: {}", said(&run));
    keeps_the_key(&run);
}

#[track_caller]
fn keeps_the_key(run: &Output) {
    assert!(!said(run).contains(KEY) && !said(run).contains("SECRET"), "{}", said(run));
}

const KINDS: [Kind; 3] = [Kind::OctoPrint, Kind::Moonraker, Kind::Duet];

/// A server that wants the key.
fn locked(kind: Kind) -> Server {
    let server = Server::of(kind);
    server.inside().key = Some(KEY.to_owned());
    server
}

/// A look at what a server has.
fn with<T>(server: &Server, look: impl FnOnce(&server::Inside) -> T) -> T {
    look(&server.inside())
}

/// The document of one file that goes to a server of this kind.
pub(crate) fn once(kind: Kind) -> Value {
    done(&mut publish(&locked(kind).to(), &[]))
}

#[test]
fn a_file_goes_once_and_is_the_same_there() {
    for kind in KINDS {
        let (made, server) = (prepared_for(kind), locked(kind));
        let first = done(&mut publish(&server.to(), &[]));
        let wanted = json!([kind.word(), server.url(), "tree.gcode", made.bytes.len(), true, 1, false]);
        let keys = ["server", "url", "file", "bytes", "verified", "uploads", "started"];
        assert_eq!(json!(keys.map(|key| &first[key])), wanted);
        assert!(server.inside().files["tree.gcode"] == made.bytes, "{kind}");
        // The key goes as the server's documentation says, and nowhere else.
        let asked = std::mem::take(&mut server.inside().asked);
        assert!(asked.iter().all(|line| line.ends_with(" with key") != (kind == Kind::Duet)), "{asked:?}");
        // Once more: it is there, and is not sent again.
        assert_eq!(done(&mut publish(&server.to(), &[]))["uploads"], 0);
        assert!(!server.inside().asked.iter().any(|line| line.contains("upload") || line.starts_with("POST")));
        assert_eq!(server.inside().started, 0, "nothing starts that nobody asked for");
    }
}

#[test]
fn servers_show_the_time_the_filament_and_the_layers_that_verification_counts() {
    for kind in [Kind::Moonraker, Kind::Duet] {
        let made = prepared_for(kind);
        let text = String::from_utf8(made.bytes.clone()).unwrap();
        let layers = text.lines().filter(|line| *line == ";LAYER_CHANGE").count();
        let shown = done(&mut publish(&locked(kind).to(), &[]));
        let (stated, shown) = (shown["stated"].clone(), shown["shown"].clone());
        let near = |key: &str, share: f64| {
            let (here, there) = (stated[key].as_f64().unwrap(), shown[key].as_f64().unwrap());
            assert!((here - there).abs() <= share, "{kind} {key}: {here} here, {there} there");
        };
        near("seconds_print", 0.51);
        near("filament_mm", 0.01 * made.report["filament_mm"].as_f64().unwrap());
        assert_eq!(stated["seconds_print"], made.report["seconds_print"]);
        assert_eq!((&shown["layers"], &stated["layers"]), (&json!(layers), &json!(layers)), "{kind}");
    }
    // OctoPrint shows its own analysis, and keeps ours beside it.
    let server = locked(Kind::OctoPrint);
    done(&mut publish(&server.to(), &[]));
    let kept: Value = serde_json::from_str(server.inside().userdata.as_ref().unwrap()).unwrap();
    assert_eq!(kept["trunnion"]["seconds_print"], prepared().report["seconds_print"]);
    assert_eq!(kept["trunnion"]["verified"], true);
}

#[test]
fn what_a_connection_loses_is_looked_for_before_it_is_sent_again() {
    for kind in KINDS {
        let made = prepared_for(kind);
        for (hitches, uploads) in [
            (vec![Hitch::Cut(50_000)], 2),
            (vec![Hitch::Cut(0), Hitch::HalfKept(70_000)], 3),
            (vec![Hitch::AnswerLost], 1),
            (vec![Hitch::HalfKept(60_000), Hitch::AnswerLost], 2),
        ] {
            let server = locked(kind);
            server.inside().hitches = hitches.clone().into();
            assert_eq!(done(&mut publish(&server.to(), &[]))["uploads"], uploads, "{kind} {hitches:?}");
            let inside = server.inside();
            assert!(inside.files.len() == 1 && inside.files["tree.gcode"] == made.bytes, "{kind} {hitches:?}");
        }
    }
}

#[test]
fn nothing_half_is_left_where_it_cannot_be_finished() {
    for kind in KINDS {
        for hitch in [Hitch::Cut(10_000), Hitch::HalfKept(80_000)] {
            let server = locked(kind);
            server.inside().hitches = vec![hitch; 9].into();
            fails(&mut publish(&server.to(), &[]), 4, "server/closed");
            assert!(server.inside().files.is_empty(), "{kind} {hitch:?}");
            assert_eq!(server.inside().hitches.len(), 6, "three times, and no more");
        }
        for (hitch, words) in [
            (Hitch::Full, "server/full"),
            (Hitch::FullInItsWay, "server/full: 10 bytes"),
            (Hitch::Forbidden, "server/wrong-key"),
        ] {
            let server = locked(kind);
            server.inside().hitches = vec![hitch].into();
            // A Duet's card says no more than that it did not work, which is tried again.
            server.inside().hitches.resize(if kind == Kind::Duet { 3 } else { 1 }, hitch);
            fails(&mut publish(&server.to(), &[]), 4, words);
            assert!(server.inside().files.is_empty(), "{kind} {hitch:?}");
        }
        let server = locked(kind);
        server.inside().free = 1000;
        fails(&mut publish(&server.to(), &[]), 4, "server/full: 1000 bytes | bytes");
        assert!(!server.inside().asked.iter().any(|line| line.starts_with("POST")), "nothing is sent to a full disk");
    }
    // The others compare checksums themselves, and are sent it again.
    let server = locked(Kind::OctoPrint);
    server.inside().hitches = vec![Hitch::Spoilt].into();
    fails(&mut publish(&server.to(), &[]), 4, "server/differs: bytes");
    assert!(server.inside().files.is_empty());
    for kind in [Kind::Moonraker, Kind::Duet] {
        let server = locked(kind);
        server.inside().hitches = vec![Hitch::Spoilt].into();
        assert_eq!(done(&mut publish(&server.to(), &[]))["uploads"], 2, "{kind}");
    }
}

#[test]
fn another_file_of_the_name_stays_unless_it_is_to_be_replaced() {
    for kind in KINDS {
        let (made, server) = (prepared_for(kind), locked(kind));
        // As large as ours: only its bytes tell.
        let mut other = made.bytes.clone();
        other[9] ^= 1;
        server.inside().files.insert("tree.gcode".to_owned(), other.clone());
        fails(&mut publish(&server.to(), &[]), 4, "server/another: tree.gcode | --replace | --name");
        assert!(server.inside().files["tree.gcode"] == other, "{kind}");
        assert_eq!(done(&mut publish(&server.to(), &["--name", "tree-2.gcode"]))["file"], "tree-2.gcode");
        // A replacement that gets lost takes nothing away.
        server.inside().hitches = vec![Hitch::Cut(10_000); 3].into();
        fails(&mut publish(&server.to(), &["--replace"]), 4, "server/closed");
        assert!(server.inside().files["tree.gcode"] == other, "{kind}");
        assert_eq!(done(&mut publish(&server.to(), &["--replace"]))["uploads"], 1);
        assert!(server.inside().files["tree.gcode"] == made.bytes, "{kind}");
    }
}

#[test]
fn a_file_that_octoprint_stores_under_another_name_is_named() {
    for (told, wanted) in
        [(true, "server/renamed: tree_1.gcode | tree.gcode | --name"), (false, "server/renamed: tree.gcode | --name")]
    {
        let server = locked(Kind::OctoPrint);
        server.inside().hitches = vec![Hitch::Renamed(told)].into();
        fails(&mut publish(&server.to(), &[]), 4, wanted);
        assert!(server.inside().files.keys().eq(["tree_1.gcode"]), "what has another name is not ours to delete");
    }
}

#[test]
fn a_print_starts_when_asked_and_never_beside_another() {
    for kind in KINDS {
        let server = locked(kind);
        server.inside().connected = false;
        fails(&mut publish(&server.to(), &["--start"]), 4, "server/not-ready");
        server.inside().connected = true;
        server.inside().printing = Some("vase.gcode".to_owned());
        fails(&mut publish(&server.to(), &["--start"]), 4, "server/printing: vase.gcode");
        // One look at a time: a second waits for the first.
        let (files, started) = with(&server, |inside| (inside.files.len(), inside.started));
        assert_eq!((files, started), (0, 0), "{kind}");
        // Uploading alone is no harm to a print.
        assert_eq!(done(&mut publish(&server.to(), &[]))["started"], false);
        server.inside().printing = None;
        assert_eq!(done(&mut publish(&server.to(), &["--start"]))["started"], true);
        let (started, printing) = with(&server, |inside| (inside.started, inside.printing.clone()));
        assert_eq!((started, printing.as_deref()), (1, Some("tree.gcode")), "{kind}");
        fails(&mut publish(&server.to(), &["--start"]), 4, "server/printing: tree.gcode");
        // An answer that is lost is not asked for again: it prints.
        server.inside().printing = None;
        server.inside().start_lost = true;
        assert_eq!(done(&mut publish(&server.to(), &["--start"]))["started"], true);
        assert_eq!(server.inside().started, 2, "{kind}");
    }
}

#[test]
fn doors_that_are_shut_are_sentences() {
    for kind in KINDS {
        let server = locked(kind);
        fails(publish(&server.to(), &[]).env("TRUNNION_KEY", "SECRET"), 4, "server/wrong-key");
        fails(
            publish(&server.to(), &[]).env_remove("TRUNNION_KEY"),
            4,
            "server/no-key: --key-file FILE | TRUNNION_KEY",
        );
        for (door, words) in [
            (Door::Page, "server/page"),
            (Door::Login, "server/login: Basic realm=\"workshop\""),
            (Door::Moved, "server/moved: http://elsewhere.local/login | --to"),
            (Door::Mute, "server/silent: 1 s | --timeout SECONDS"),
            (Door::Garbled, "server/garbled: HTTP"),
        ] {
            server.inside().door = door;
            // Only where nothing comes is it waited for: whoever answers, however late, is not held to a second.
            let more: &[&str] = if door == Door::Mute { &["--timeout", "1"] } else { &[] };
            fails(&mut publish(&server.to(), more), 4, words);
        }
        // Another server's answers.
        let other = Server::of(if kind == Kind::Duet { Kind::Moonraker } else { Kind::Duet });
        fails(&mut publish(&format!("{}:{}", kind.word(), other.url()), &[]), 4, &format!("server/page: {kind}"));
    }
    let gone = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    fails(&mut publish(&format!("octoprint:http://{gone}"), &[]), 4, "server/away: connection refused");
}

#[test]
fn a_key_comes_from_a_file_or_the_environment() {
    let server = locked(Kind::Moonraker);
    let folder = folder();
    let file = folder.path().join("octo.key");
    std::fs::write(&file, format!("{KEY}\n")).unwrap();
    let key_file = ["--key-file", file.to_str().unwrap()];
    done(publish(&server.to(), &key_file).env("TRUNNION_KEY", "not this one"));
    std::fs::write(&file, "SECRET\nSECRET\n").unwrap();
    fails(&mut publish(&server.to(), &key_file), 2, "publish/key: octo.key | several lines");
    std::fs::write(&file, "").unwrap();
    fails(&mut publish(&server.to(), &key_file), 2, "publish/key: octo.key | empty");
    fails(&mut publish(&server.to(), &["--key-file", "no/such.key"]), 2, "file/read: no/such.key");
    fails(
        &mut publish("octoprint:http://me:SECRET@printer.local", &[]),
        2,
        "publish/secret: --key-file or TRUNNION_KEY",
    );
    fails(&mut publish("http://printer.local", &[]), 2, "publish/server: --to: | octoprint:");
    fails(&mut publish(&server.to(), &["--name", "my part.gcode"]), 2, "publish/name: \"my part.gcode\"");
}

/// Klipper drops words that it does not know, and prints on: tilted parts on a level table.
#[test]
fn a_file_for_another_firmware_goes_to_no_server_that_drives_one() {
    for (kind, words) in [
        (Kind::Moonraker, "publish/firmware: Moonraker | klipper | marlin | profile generic-ac"),
        (Kind::Duet, "publish/firmware: Duet | reprapfirmware | marlin | profile generic-ac"),
    ] {
        let (made, server) = (prepared(), locked(kind));
        let plan = ["--plan", made.plan.to_str().unwrap()];
        fails(&mut of(&made.gcode, &server.to(), &plan), 2, words);
        assert!(server.inside().asked.is_empty(), "nobody is asked for a file that cannot go there");
        // The other way round, and another firmware of the two.
        let other = prepared_for(if kind == Kind::Duet { Kind::Moonraker } else { Kind::Duet });
        let plan = ["--plan", other.plan.to_str().unwrap()];
        fails(&mut of(&other.gcode, &server.to(), &plan), 2, "publish/firmware: [dialect] firmware");
    }
}

#[test]
fn only_what_is_proved_is_published() {
    let (made, server) = (prepared(), locked(Kind::OctoPrint));
    fails(&mut of(&made.gcode, &server.to(), &[]), 2, "command/usage: --plan");
    let folder = folder();
    let changed = folder.path().join("changed.gcode");
    let text = String::from_utf8(made.bytes.clone()).unwrap().replacen("\nG1 A", "\nG1 A1", 1);
    std::fs::write(&changed, text).unwrap();
    let plan = ["--plan", made.plan.to_str().unwrap()];
    fails(&mut of(&changed, &server.to(), &plan), 1, "command/no: changed.gcode | sent");
    assert!(server.inside().asked.is_empty(), "nobody is asked for a file that is not proved");
    let sent = done(&mut of(&changed, &server.to(), &["--unverified"]));
    assert_eq!((&sent["verified"], &sent["stated"]["seconds_print"]), (&json!(false), &Value::Null));
}

/// Where OctoPrint says what its printer runs, that is no other firmware than the file's.
#[test]
fn what_an_octoprint_says_of_its_printer_is_held_against_the_file() {
    let made = prepared();
    let plan = ["--plan", made.plan.to_str().unwrap()];
    for (says, goes) in [
        (None, true),
        (Some("Marlin 2.1.2.5 (Sep 24 2026)"), true),
        (Some("Prusa-Firmware 3.14.1"), true),
        (Some("Some new firmware"), true),
        (Some("Klipper"), false),
        (Some("Kalico"), false),
        (Some("RepRapFirmware for Duet 2 WiFi/Ethernet"), false),
        (Some("grblHAL 1.1f"), false),
    ] {
        let server = Server::of(Kind::OctoPrint);
        server.inside().firmware = says.map(str::to_owned);
        let mut host = of(&made.gcode, &server.to(), &plan);
        if goes {
            done(&mut host);
        } else {
            fails(&mut host, 4, &format!("server/other-firmware: {} | marlin", says.unwrap()));
        }
        assert_eq!(server.inside().files.len(), usize::from(goes), "{says:?}");
        // Of a file that nobody has proved nobody knows the firmware, and it is said so.
        let server = Server::of(Kind::OctoPrint);
        server.inside().firmware = says.map(str::to_owned);
        done(&mut of(&made.gcode, &server.to(), &["--unverified"]));
    }
}

/// A server with the certificate of the tests' own authority.
/// A port of 127.0.0.2 from which one connection is led on to the server at `to`.
fn led_on_to(to: &str) -> u16 {
    let port: u16 = to.rsplit(':').next().and_then(|port| port.parse().ok()).expect("a port");
    let door = TcpListener::bind("127.0.0.2:0").expect("a second address of the loopback");
    let own = door.local_addr().expect("bound").port();
    std::thread::spawn(move || {
        let (caller, _) = door.accept().expect("a caller");
        let server = TcpStream::connect(("127.0.0.1", port)).expect("the server");
        let [mut from, mut to] = [&caller, &server].map(|stream| stream.try_clone().expect("a second handle"));
        std::thread::spawn(move || std::io::copy(&mut from, &mut to));
        let _ = std::io::copy(&mut &server, &mut &caller);
    });
    own
}

fn with_tls() -> Server {
    with_certificate("server.pem", "server.key.pem")
}

fn with_certificate(chain: &str, key: &str) -> Server {
    use rustls::pki_types::pem::PemObject;
    use rustls::pki_types::{CertificateDer, PrivateKeyDer};
    let chain: Vec<_> = CertificateDer::pem_file_iter(certificate(chain)).unwrap().map(Result::unwrap).collect();
    let key = PrivateKeyDer::from_pem_file(certificate(key)).unwrap();
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = rustls::ServerConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    Server::spoken(Kind::Moonraker, Some(Arc::new(config.with_no_client_auth().with_single_cert(chain, key).unwrap())))
}

fn certificate(name: &str) -> PathBuf {
    crate::support::root().join("tests/it/publish/certificates").join(name)
}

/// As `openssl req -x509` makes one: its own authority's, for no name of the server's.
#[test]
fn a_certificate_of_ones_own_is_taken_by_its_fingerprint_and_no_other_is() {
    if cfg!(not(feature = "tls")) {
        return skip("TLS is not built in (--features tls)");
    }
    let print = |name: &str| {
        use rustls::pki_types::CertificateDer;
        use rustls::pki_types::pem::PemObject;
        trunnion::publish::Fingerprint::of(&CertificateDer::from_pem_file(certificate(name)).unwrap()).to_string()
    };
    let (own, other) = (print("own.pem"), print("server.pem"));
    let server = with_certificate("own.pem", "own.key.pem");
    fails(&mut publish(&server.to(), &[]), 4, "server/tls: --fingerprint");
    fails(&mut publish(&server.to(), &["--fingerprint", &other]), 4, &format!("server/tls: {own}"));
    fails(&mut publish(&server.to(), &["--fingerprint", "AB:CD"]), 2, "command/usage: 'AB:CD' | 64");
    assert!(server.inside().asked.is_empty(), "the key is not shown to a stranger");
    done(&mut publish(&server.to(), &["--fingerprint", &own.replace(':', "").to_lowercase()]));
    assert_eq!(server.inside().files.len(), 1);
    // What an authority vouches for is taken by its fingerprint, too, and by nothing else then.
    let known = with_tls();
    fails(
        publish(&known.to(), &["--fingerprint", &own]).env("SSL_CERT_FILE", certificate("authority.pem")),
        4,
        &format!("server/tls: {other}"),
    );
    done(&mut publish(&known.to(), &["--fingerprint", &other]));
}

#[test]
fn tls_holds_certificates_against_this_computers_authorities() {
    if cfg!(not(feature = "tls")) {
        return skip("TLS is not built in (--features tls)");
    }
    let server = with_tls();
    assert!(server.to().starts_with("moonraker:https://localhost:"));
    fails(&mut publish(&server.to(), &[]), 4, "server/tls");
    done(publish(&server.to(), &[]).env("SSL_CERT_FILE", certificate("authority.pem")));
    assert_eq!(server.inside().files.len(), 1);
    // Not the name in the certificate.
    let other = format!("moonraker:https://127.0.0.2:{}", led_on_to(&server.to()));
    fails(publish(&other, &[]).env("SSL_CERT_FILE", certificate("authority.pem")), 4, "server/tls: 127.0.0.2");
    let plain = server.to().replace("https", "http");
    fails(&mut publish(&plain, &[]), 4, "");
}
