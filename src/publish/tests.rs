//! Addresses, keys and names that cannot be, and sentences that hold no key.

use std::time::Duration;

use super::address::{BadInput, Key, Kind, ServerAddress, file_name};
use super::form::Form;
use super::line::escaped;
use super::web::{Ask, ServerAnswer, Trouble, Web};
use super::{PublishError, ServerFault};

#[test]
fn addresses_are_read_and_repeated_nowhere_when_they_hold_a_secret() {
    let good = ServerAddress::parse("octoprint:http://printer.local:5000/").unwrap();
    assert_eq!((good.kind, good.url()), (Kind::OctoPrint, "http://printer.local:5000"));
    let behind = ServerAddress::parse("moonraker:https://[fe80::1]:7125/printer/2").unwrap();
    assert_eq!((behind.kind, behind.url()), (Kind::Moonraker, "https://[fe80::1]:7125/printer/2"));
    for (text, wanted) in [
        ("http://printer.local", BadInput::Server),
        ("prusalink:http://printer.local", BadInput::Server),
        ("duet:printer.local", BadInput::Url { kind: "duet" }),
        ("duet:http://", BadInput::Url { kind: "duet" }),
        ("duet:http://:80", BadInput::Url { kind: "duet" }),
        ("duet:http://a b", BadInput::Url { kind: "duet" }),
        ("duet:http://me:SECRET@printer.local", BadInput::Secret),
        ("octoprint:http://printer.local/?apikey=SECRET", BadInput::Secret),
    ] {
        let error = ServerAddress::parse(text).unwrap_err();
        assert_eq!(error, wanted, "{text}");
        assert!(!error.to_string().contains("SECRET"), "{error}");
    }
}

/// A world without sockets, with or without TLS.
struct NoSockets {
    tls: bool,
}

impl Web for NoSockets {
    fn ask(&self, _: &Ask<'_>, _: &dyn Fn(usize)) -> Result<ServerAnswer, Trouble> {
        Err(Trouble::Closed)
    }

    fn wait(&self, _: Duration) {}

    fn speaks_tls(&self) -> bool {
        self.tls
    }
}

#[test]
fn https_is_refused_before_anything_is_sent_where_there_is_no_tls() {
    let reached = |url: &str, tls| ServerAddress::parse(url).unwrap().reached_by(&NoSockets { tls });
    assert_eq!(reached("duet:https://d", false), Err(BadInput::NoTls));
    assert!(BadInput::NoTls.to_string().contains("http://") && BadInput::NoTls.to_string().contains("--features tls"));
    for (url, tls) in [("duet:https://d", true), ("duet:http://d", false), ("duet:http://d", true)] {
        assert!(reached(url, tls).is_ok(), "{url} {tls}");
    }
}

#[test]
fn keys_are_one_line_and_are_never_printed() {
    let key = Key::new(" SECRET\n", "a.key").unwrap();
    assert_eq!((key.secret(), format!("{key:?}").as_str()), ("SECRET", "Key(..)"));
    for text in ["", " \n", "SECRET\nSECRET", "SECR\u{c9}T", &"SECRET".repeat(100)] {
        let error = Key::new(text, "a.key").unwrap_err().to_string();
        assert!(error.contains("a.key") && !error.contains("SECR"), "{error}");
    }
}

#[test]
fn names_that_a_server_would_change_are_refused() {
    for name in ["a.gcode", "Part-2_v1.5.g", "x.gco"] {
        assert_eq!(file_name(name), Ok(name));
    }
    let long = format!("{}.gcode", "a".repeat(80));
    for name in ["", "a b.gcode", "\u{e4}.gcode", "../a.gcode", ".a.gcode", "-a.gcode", "a.stl", "a.GCODE", &long] {
        assert!(matches!(file_name(name), Err(BadInput::Name { .. })), "{name}");
    }
}

#[test]
fn a_form_is_fields_then_the_file() {
    let form = Form::of(&[("root", "gcodes")], "a.gcode", "5e");
    let body = form.body(b"G28\n").concat();
    let wanted = "--trunnion-5e\r\nContent-Disposition: form-data; name=\"root\"\r\n\r\ngcodes\r\n--trunnion-5e\r\n\
         Content-Disposition: form-data; name=\"file\"; filename=\"a.gcode\"\r\nContent-Type: application/octet-stream\r\n\r\n\
         G28\n\r\n--trunnion-5e--\r\n";
    assert_eq!(String::from_utf8(body).unwrap(), wanted);
    assert_eq!(form.kind(), "multipart/form-data; boundary=trunnion-5e");
}

#[test]
fn what_goes_into_an_address_is_escaped() {
    assert_eq!(escaped("M32 \"0:/gcodes/a.g\"&x"), "M32%20%220%3A%2Fgcodes%2Fa.g%22%26x");
}

#[test]
fn what_may_pass_is_tried_again_and_nothing_else() {
    assert!(ServerFault::Closed.may_pass() && ServerFault::Silent { seconds: 1 }.may_pass());
    let refused = |status| ServerFault::Refused { what: "the upload", status, words: String::new() };
    assert!(refused(503).may_pass() && !refused(500).may_pass() && !ServerFault::NoKey.may_pass());
    let address = ServerAddress::parse("duet:http://d").unwrap();
    let told = PublishError::new(&address, ServerFault::Full { free: Some(5), needs: 9 }, true).to_string();
    let wanted = "Duet at http://d: its disk is full: 5 bytes are free, the file needs 9 bytes; delete old files there; part of the file may be left there";
    assert_eq!(told, wanted);
}
