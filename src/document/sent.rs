//! What a person is told while something is sent, in sentences, and how several prints ended.

use serde_json::{Value, json};

use crate::job::{At, EndedPrint, Figures, Rehearsal, Sending};
use crate::spelling::counted;

/// How a sentence is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// To whom asks for details.
    Detail,
    /// To everybody who did not ask for quiet.
    Note,
    /// To everybody.
    Warning,
    /// In one place that is written over.
    Status,
}

/// What is said of an event of a print, or of `print` of several, from 0; `None` for what is not.
pub fn said(what: &Sending<'_>, at: At, print: Option<usize>) -> Option<(Tone, String)> {
    let (tone, text) = match what {
        Sending::Printer(name) => (Tone::Note, format!("printer: {}", called(name))),
        Sending::Resend { number, why, .. } => (Tone::Detail, format!("resending N{number} ({why})")),
        Sending::UserWait => (Tone::Note, "the printer is waiting for a person".to_owned()),
        Sending::Note(text) => (Tone::Note, (*text).to_owned()),
        Sending::Progress(figures) => (Tone::Status, status(figures, at)),
        Sending::Pausing { waits_for } => {
            let waits = |what: &str| format!("the printer has finished waiting for {what}");
            let first = waits_for.map_or("moves in progress".to_owned(), waits);
            let stop = print.map_or("Ctrl-C again is an emergency stop".to_owned(), |print| {
                format!("emergency stop: s {} (this print), Ctrl-C twice (all prints)", print + 1)
            });
            (Tone::Note, format!("pausing after {first}; {stop}"))
        }
        Sending::Trouble { file_line, text } => {
            let text = format!("the printer did not execute line {file_line} as written: {text}");
            (Tone::Warning, text)
        }
        Sending::Resumed => (Tone::Note, "the print continues".to_owned()),
        Sending::Done { resends } => (
            Tone::Note,
            format!("the print is complete: {} lines, {}", at.of, counted(*resends as usize, "resend request")),
        ),
        Sending::Short { journal } => {
            (Tone::Warning, format!("{journal}: no disk space left for the journal; pausing"))
        }
        Sending::StillShort => (Tone::Warning, "there is still no disk space for the journal".to_owned()),
        Sending::Full { journal } => (
            Tone::Warning,
            format!("{journal}: the journal cannot be written, so sending waits until it can; check the disk"),
        ),
        Sending::Lost { why, wait } => {
            let wait = wait.as_secs();
            (Tone::Warning, format!("connection lost ({why}); waiting up to {wait} s for the same device"))
        }
        Sending::Aside { journal } => {
            (Tone::Warning, format!("renamed the journal of an interrupted print to {}", journal.display()))
        }
        Sending::UnprovedReentry => {
            (Tone::Warning, "without --plan the re-entry path is not checked for collisions".to_owned())
        }
        _ => return None,
    };
    Some((tone, text))
}

/// What can be done about a print that is paused, by whoever can type; `print` of several, from 0.
pub fn paused(print: Option<usize>) -> String {
    let Some(n) = print.map(|print| print + 1) else {
        return "paused above the part: Enter (continue), c and Enter (cancel), Ctrl-C (emergency stop)".to_owned();
    };
    format!(
        "paused above the part: {n} (continue), c {n} (cancel), s {n} (emergency stop); all prints: Enter (continue), Ctrl-C twice (emergency stop)"
    )
}

/// A printer's machine and firmware, of all that it says of itself; all of that where it does not name its firmware.
fn called(identity: &str) -> String {
    let key = |word: &str| {
        let name = word.split_once(':').map_or("", |(name, _)| name);
        !name.is_empty() && name.bytes().all(|b| b.is_ascii_uppercase() || b == b'_')
    };
    let value = |name: &str| {
        let (_, rest) = identity.split_once(name)?;
        let words: Vec<&str> =
            rest.split(' ').enumerate().take_while(|(i, word)| *i == 0 || !key(word)).map(|(_, w)| w).collect();
        Some(words.join(" ").trim().to_owned()).filter(|value| !value.is_empty())
    };
    let Some(firmware) = value("FIRMWARE_NAME:") else { return identity.to_owned() };
    let version = value("FIRMWARE_VERSION:").map_or(String::new(), |version| format!(" {version}"));
    let machine = value("MACHINE_TYPE:").map_or(String::new(), |machine| format!("{machine}, "));
    format!("{machine}{firmware}{version}")
}

/// One line, what matters most first: a narrow terminal leaves out its end.
fn status(f: &Figures, at: At) -> String {
    let mut words = vec![format!("{:.0} %", (f.share * 100.0).clamp(0.0, 100.0))];
    words.extend(f.waits_for.map(|what| format!("waits for {what}")));
    let awaited = |heater: &str| f.waits_for.is_some_and(|what| what.contains(heater));
    let mut heats = [
        (awaited("bed"), f.bed_c.map(|[now, wanted]| format!("bed {now:.0}/{wanted:.0}"))),
        (awaited("nozzle"), f.nozzle_c.map(|[now, wanted]| format!("{now:.0}/{wanted:.0} C"))),
    ];
    words.extend(heats.iter_mut().filter(|(awaited, _)| *awaited).filter_map(|(_, heat)| heat.take()));
    words.push(format!("{:.0} min left", f.seconds_left / 60.0));
    if f.layers > 0 {
        words.push(format!("layer {} of {}", f.layer, f.layers));
    } else {
        words.push(format!("line {} of {}", at.line, at.of));
    }
    words.extend(f.slot.map(|slot| format!("slot {slot} of {}", f.slots)));
    words.extend(heats.into_iter().rev().filter_map(|(_, heat)| heat));
    words.join(", ")
}

/// What a rehearsal came to.
pub fn rehearsal(done: &Rehearsal) -> String {
    format!(
        "rehearsal: {} lines in {:.0} min with homing and heating ({:.0} min without); {} beyond an axis limit",
        done.lines,
        done.seconds / 60.0,
        done.seconds_print / 60.0,
        counted(done.clamped as usize, "target")
    )
}

/// What a rehearsed printer would not have done; `None` where it did all.
pub fn undone(done: &Rehearsal) -> Option<String> {
    if done.clamped > 0 {
        return Some(format!(
            "the file has {} beyond an axis limit of the profile",
            counted(done.clamped as usize, "target")
        ));
    }
    let first = done.troubles.first()?;
    let more = done.troubles.len() - 1;
    let more = if more > 0 { format!(", and {more} more") } else { String::new() };
    Some(format!("the simulated printer did not execute {first}{more}; the real one would pause there"))
}

/// `trunnion send` to several printers: the last line, with port, file and, where it failed, the reason of each print.
pub fn ended(prints: &[EndedPrint]) -> Value {
    let each = |print: &EndedPrint| {
        let (file, error) = (print.file.to_string_lossy(), print.error.as_ref().map(ToString::to_string));
        json!({"port": print.port, "file": file, "ok": error.is_none(), "error": error})
    };
    json!({"event": "ended", "prints": prints.iter().map(each).collect::<Vec<_>>()})
}

/// Which of several prints have failed, and why; `None` where none has.
pub fn failures(prints: &[EndedPrint]) -> Option<String> {
    let each = |p: &EndedPrint| Some(format!("{}: {}: {}", p.port, p.file.display(), p.error.as_ref()?));
    let failed: Vec<String> = prints.iter().filter_map(each).collect();
    let text = || format!("{} of {} prints failed; {}", failed.len(), prints.len(), failed.join("; "));
    (!failed.is_empty()).then(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_printer_is_called_by_its_machine_and_firmware() {
        for (said, name) in [
            (
                "FIRMWARE_NAME:Marlin 2.1.2 (Apr  1 2024 12:00:00) SOURCE_CODE_URL:github.com/x PROTOCOL_VERSION:1.0 MACHINE_TYPE:Ender 3 \
                 EXTRUDER_COUNT:1",
                "Ender 3, Marlin 2.1.2 (Apr  1 2024 12:00:00)",
            ),
            ("ok FIRMWARE_NAME:Klipper FIRMWARE_VERSION:v0.13.0-1", "Klipper v0.13.0-1"),
            ("[VER:1.1h.20190825:]", "[VER:1.1h.20190825:]"),
            ("FIRMWARE_NAME: MACHINE_TYPE:x", "FIRMWARE_NAME: MACHINE_TYPE:x"),
        ] {
            assert_eq!(called(said), name);
        }
    }

    fn shown(waits_for: Option<&'static str>) -> String {
        let figures = Figures {
            share: 0.424,
            layer: 12,
            layers: 80,
            slot: Some(2),
            slots: 4,
            seconds_left: 2220.0,
            nozzle_c: Some([24.0, 210.0]),
            bed_c: Some([44.6, 60.0]),
            waits_for,
            resends: 0,
        };
        status(&figures, At { line: 7, of: 9 })
    }

    #[test]
    fn what_is_waited_for_and_its_figures_come_first() {
        let [bed, nozzle, none] = [Some("bed heating"), Some("nozzle heating"), None].map(shown);
        let (rest, layer) = ("37 min left, layer 12 of 80, slot 2 of 4", "24/210 C");
        assert_eq!(bed, format!("42 %, waits for bed heating, bed 45/60, {rest}, {layer}"));
        assert_eq!(nozzle, format!("42 %, waits for nozzle heating, {layer}, {rest}, bed 45/60"));
        assert_eq!(none, format!("42 %, {rest}, {layer}, bed 45/60"));
    }
}
