//! What HAL gives to the pins of the kinematics: `setp`, `sets`, `net`, in the ini's HALCMD lines and in HAL files beside it.

use std::path::PathBuf;

use super::super::stated::{File, ImportError, Open, Shelf, Stated, StatedAt, number, same, shown};
use super::ini::Ini;
use super::lines_of;

#[derive(Default)]
pub(super) struct Hal {
    /// Pins and what they are set to.
    pins: Vec<(String, String, StatedAt)>,
    /// Signals and the pins on them.
    nets: Vec<(String, String)>,
    /// Signals and what they are set to.
    signals: Vec<(String, String, StatedAt)>,
    /// Files that were not read, in sentences.
    pub(super) unread: Vec<String>,
}

impl Hal {
    /// The ini's own lines, the files that it names, and `more`.
    pub(super) fn read(file: &File, more: &[&File], ini: &Ini, shelf: &dyn Shelf) -> Result<Self, ImportError> {
        let mut hal = Self::default();
        let mut open = Open::new(shelf);
        open.enter(file);
        let beside = |name: &str| file.beside(name);
        let keys = ["HALFILE", "HALCMD", "POSTGUI_HALFILE"];
        for (key, entry) in
            keys.iter().flat_map(|key| ini.every("HAL", key).into_iter().map(move |entry| (*key, entry)))
        {
            let name = entry.value.split_ascii_whitespace().next().unwrap_or_default();
            if key == "HALCMD" {
                hal.command(&entry.value, entry.place.clone(), ini)?;
            } else if name.starts_with("LIB:") || name.ends_with(".tcl") {
                let what = if name.ends_with(".tcl") { "a Tcl script" } else { "part of LinuxCNC" };
                hal.unread
                    .push(format!("{}: {name} is {what} and is not read, so its settings are unknown", entry.place));
            } else {
                let missing = "put it beside the ini, or write LIB: before it if it is LinuxCNC's own";
                let inner = open.named(beside(name), &entry.place, missing)?;
                hal.file(&inner, &mut open, ini, &beside)?;
                open.leave();
            }
        }
        for file in more {
            open.enter(file);
            hal.file(file, &mut open, ini, &beside)?;
            open.leave();
        }
        Ok(hal)
    }

    fn file(
        &mut self,
        file: &File,
        open: &mut Open<'_>,
        ini: &Ini,
        beside: &dyn Fn(&str) -> PathBuf,
    ) -> Result<(), ImportError> {
        // HAL files name others from the ini's folder, where halcmd runs.
        let named = |_: &File, line: &str| {
            let name = line.strip_prefix("source").filter(|rest| rest.starts_with(char::is_whitespace))?;
            Some((beside(name.trim()), "put it beside the ini".to_owned()))
        };
        lines_of(file, open, &named, &mut |place, line| self.command(line, place, ini))
    }

    fn command(&mut self, line: &str, place: StatedAt, ini: &Ini) -> Result<(), ImportError> {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_ascii_whitespace().filter(|word| !matches!(*word, "=>" | "<=" | "<=>"));
        match (words.next(), words.next(), words.next()) {
            (Some("setp"), Some(pin), Some(value)) => {
                self.pins.push((pin.to_owned(), told(value, &place, ini)?, place))
            }
            (Some("sets"), Some(signal), Some(value)) => {
                self.signals.push((signal.to_owned(), told(value, &place, ini)?, place));
            }
            (Some("net"), Some(signal), Some(pin)) => {
                let all = std::iter::once(pin).chain(words);
                self.nets.extend(all.map(|pin| (signal.to_owned(), pin.to_owned())));
            }
            (Some("linkps"), Some(pin), Some(signal)) | (Some("linksp"), Some(signal), Some(pin)) => {
                self.nets.push((signal.to_owned(), pin.to_owned()));
            }
            _ => {}
        }
        Ok(())
    }

    /// What a pin is set to, directly or by its signal; `None` where no line says.
    pub(super) fn pin(&self, name: &str) -> Result<Option<Stated>, ImportError> {
        let of_pin = self.pins.iter().filter(|(pin, _, _)| pin == name);
        let on = |signal: &str| self.nets.iter().any(|(net, pin)| net == signal && pin == name);
        let of_signal = self.signals.iter().filter(|(signal, _, _)| on(signal));
        let mut found: Option<Stated> = None;
        for (_, text, place) in of_pin.chain(of_signal) {
            let value = match &*text.to_ascii_uppercase() {
                "TRUE" => 1.0,
                "FALSE" => 0.0,
                _ => number(name, text, place)?,
            };
            let stated = Stated { value, from: vec![place.clone()] };
            if let Some(first) = &found {
                same(name, first, &stated)?;
            }
            found.get_or_insert(stated);
        }
        Ok(found)
    }
}

/// The value that a word stands for: `[SECTION]KEY` and `[SECTION](KEY)` are the ini's.
fn told(word: &str, place: &StatedAt, ini: &Ini) -> Result<String, ImportError> {
    let Some((section, key)) = word.strip_prefix('[').and_then(|rest| rest.split_once(']')) else {
        return Ok(word.to_owned());
    };
    let key = key.trim_matches(['(', ')']);
    let entry = ini.one(section, key)?;
    entry.map(|entry| entry.bare().to_owned()).ok_or_else(|| {
        let why = format!("{} is not in the ini: [{section}] has no {key}", shown(word));
        ImportError::At { place: place.clone(), why }
    })
}
