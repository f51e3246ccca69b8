//! Printers' lines as firmwares write them.

use super::*;

fn marlin(text: &str) -> Reply {
    Reply::read(Wording::Printer, text.as_bytes())
}

const BARE: Reply = Reply::Ok { number: None, report: None, room: None };

#[test]
fn ok_is_a_word_of_its_own() {
    assert_eq!(marlin("ok"), BARE);
    let room = |planner, commands| Some(BufferRoom { planner, commands });
    assert_eq!(marlin("ok N3 P15 B3"), Reply::Ok { number: Some(3), report: None, room: room(15, 3) });
    assert_eq!(marlin("ok P15 B31"), Reply::Ok { number: None, report: None, room: room(15, 31) });
    assert_eq!(marlin("ok N3 P15"), Reply::Ok { number: Some(3), report: None, room: None });
    assert_eq!(marlin("ok N3 P15 B-1"), Reply::Ok { number: Some(3), report: None, room: None });
    for no in ["okay", "oecho:ok", "o k", "k", "o", "xok", "echo:ok", "Ok", "ok\u{fffd}"] {
        assert!(!matches!(marlin(no), Reply::Ok { .. }), "{no}");
    }
    assert!(!matches!(Reply::read(Wording::Printer, b"\xffok"), Reply::Ok { .. }));
}

#[test]
fn only_the_answer_to_m105_carries_temperatures() {
    let Reply::Ok { report: Some(t), .. } = marlin("ok T:19.38 /0.00 B:20.50 /60.00 @:0 B@:0") else { panic!() };
    assert_eq!((t.nozzle, t.bed), (Some([19.38, 0.0]), Some([20.5, 60.0])));
    let auto = marlin(" T:30.36 /200.00 B:20.00 /0.00 @:0 W:?");
    assert!(matches!(auto, Reply::Temperatures(t) if t.nozzle == Some([30.36, 200.0])));
    for text in ["T:21.30 /205.00", "T:21.30/205.00", "T:21.30/ 205.00", "T:21.30 / 205.00"] {
        let both = format!("ok {text} {} @:64", text.replace('T', "B"));
        let Reply::Ok { report: Some(t), .. } = marlin(&both) else { panic!("{both}") };
        assert_eq!((t.nozzle, t.bed), (Some([21.3, 205.0]), Some([21.3, 205.0])), "{both}");
    }
    let Reply::Ok { report: Some(t), .. } = marlin("ok T:21.30 B:20.00") else { panic!() };
    assert_eq!((t.nozzle, t.bed), (Some([21.3, 0.0]), Some([20.0, 0.0])));
}

#[test]
fn wire_errors_survive_a_wrong_byte_and_fatal_ones_are_known() {
    assert_eq!(marlin("Error:checksum mismatch, Last Line: 41"), Reply::LineError(Some(41)));
    assert_eq!(marlin("Error:chec?sum mismatch, Last Line: 41"), Reply::LineError(Some(41)));
    assert_eq!(marlin("Error:No Checksum with line number, Last Line: 3"), Reply::LineError(Some(3)));
    assert_eq!(marlin("Error:expected line 302 got 303"), Reply::LineError(Some(301)));
    assert_eq!(marlin("Error:Wrong checksum"), Reply::LineError(None));
    assert_eq!(marlin("Error:expected line of sight"), Reply::Error("expected line of sight".to_owned()));
    assert_eq!(marlin("Resend:302"), Reply::Resend(Some(302)));
    assert_eq!(marlin("Resend: 42"), Reply::Resend(Some(42)));
    assert_eq!(marlin("rs N42"), Reply::Resend(Some(42)));
    assert_eq!(marlin("Resend: 4z"), Reply::Resend(None));
    for text in [
        "Error:Printer halted. kill() called!",
        "Error:Printer stopped due to errors. Fix the error and use M999 to restart. (Temperature is reset. Set it after \
         restarting)",
        "Error:Thermal Runaway, system stopped! Heater_ID: 0",
        "Error:Heating failed, system stopped! Heater_ID: bed",
        "Error:MAXTEMP triggered, system stopped! Heater_ID: 0",
        "Error:MINTEMP triggered, system stopped! Heater_ID: 0",
        "Error:!! KILL caused by KILL button/pin",
    ] {
        assert!(matches!(marlin(text), Reply::Fatal(_)), "{text}");
    }
    assert!(matches!(marlin("Error:Probing Failed"), Reply::Error(_)));
}

#[test]
fn reads_grbl_status_and_greeting() {
    let read = |text: &str| Reply::read(Wording::Grbl, text.as_bytes());
    let Reply::Status(s) = read("<Idle|MPos:1.000,-2.000,0.000|Bf:15,128|FS:0,0>") else { panic!() };
    assert_eq!((s.state.as_str(), s.free, s.position), ("Idle", Some([15, 128]), vec![1.0, -2.0, 0.0]));
    // grblHAL, five axes.
    let hal = "<Idle|MPos:0.000,0.000,0.000,0.000,0.000|Bf:100,1023|FS:0,0|Ov:100,100,100|A:|H:0|TLR:0>";
    assert!(matches!(read(hal), Reply::Status(s) if s.free == Some([100, 1023]) && s.position.len() == 5));
    assert!(matches!(read("GrblHAL 1.1f ['$' or '$HELP' for help]"), Reply::Greeting(_)));
    assert_eq!(read("error:20"), Reply::Refused(20));
    assert_eq!(read("ALARM:2"), Reply::Alarm(2));
    assert!(matches!(read("Grbl 1.1h ['$' for help]"), Reply::Greeting(_)));
}

#[test]
fn what_a_printer_leaves_undone_is_no_chatter() {
    for text in [
        "echo: cold extrusion prevented",
        " cold extrusion prevented",
        "echo: too long extrusion prevented",
        "echo:Home XYZ First",
        "echo:endstops hit:  X:3.50",
    ] {
        assert!(matches!(marlin(text), Reply::Undone(_)), "{text}");
    }
    // Marlin, Repetier and Sprinter, Prusa, Klipper.
    for text in
        ["echo:Unknown command: \"G93\"", "Unknown command:G93", "Unknown G code: G93", "// Unknown command:\"G93\""]
    {
        assert_eq!(marlin(text), Reply::Unknown("G93".to_owned()), "{text}");
    }
    assert_eq!(marlin("Serial Error: Line Number is not Last Line Number+1, Last Line:3"), Reply::LineError(Some(3)));
    assert!(matches!(marlin("fatal:Heater/sensor defect"), Reply::Fatal(_)) && matches!(marlin("!!"), Reply::Fatal(_)));
}

#[test]
fn a_printers_words_cannot_move_a_cursor() {
    let Reply::Error(text) = Reply::read(Wording::Printer, b"Error:\x1b[2J\x07red\xc2\x9b31m\xe2\x80\xae caf\xc3\xa9")
    else {
        panic!()
    };
    assert_eq!(text, "?[2J?red?31m? caf\u{e9}");
    let Reply::Identity(text) = Reply::read(Wording::Printer, &[b"FIRMWARE_NAME:".as_slice(), &[b'x'; 9000]].concat())
    else {
        panic!()
    };
    assert_eq!(text.len(), LONGEST_TEXT);
}

#[test]
fn reads_the_position_up_to_the_steps() {
    let read = marlin("X:10.00 Y:0.00 Z:-3.50 A:999.00 C:0.00 E:7.00 Count X:-15200 Y:1");
    let words = vec![(b'X', 10.0), (b'Y', 0.0), (b'Z', -3.5), (b'A', 999.0), (b'C', 0.0), (b'E', 7.0)];
    assert_eq!(read, Reply::Position(words));
}

#[test]
fn a_word_that_comes_back_is_known_in_every_firmwares_words_and_an_echo_is_none() {
    let word = Reply::Repeated("5f.1".to_owned());
    for text in [
        "echo:Unknown command: \"hello trunnion 5f.1\"",
        "echo:Unknown command: \"hello trunnion 5f.1\"(2)",
        "Unknown command:hello trunnion 5f.1",
    ] {
        assert_eq!(marlin(text), word, "{text}");
    }
    assert_eq!(marlin("hello trunnion 5f.1"), Reply::Chatter, "a terminal's echo comes before anything is executed");
    assert_eq!(marlin("echo:Unknown command: \"hello\""), Reply::Unknown("hello".to_owned()));
}
