//! The printers that a project is printed on: how a file gets to each. Pure values.

use serde_json::{Value, json};

use super::WorkbenchError;
use super::doors::{is_below, is_word};
use crate::publish::Fingerprint;

/// Most printers of one project.
pub(super) const MOST_PRINTERS: u8 = 16;
/// The longest name of one, characters.
const MOST_NAME: usize = 40;

/// A printer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct ChosenPrinter {
    /// The same for as long as it is there, from 1.
    pub(super) number: u8,
    /// What it is called; empty where nobody has said.
    name: String,
    /// Its port; empty without one.
    pub(super) port: String,
    /// Its print server, as `--to` has it; empty without one.
    pub(super) server: String,
    /// The file with that server's key, in the project's folder; empty where it needs none, or the environment has it.
    key_file: String,
    /// What that server's certificate is known by; empty where an authority vouches for it.
    fingerprint: String,
}

/// All of them, the first always there, by ascending numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ChosenPrinters(Vec<ChosenPrinter>);

impl Default for ChosenPrinters {
    fn default() -> Self {
        Self(vec![ChosenPrinter { number: 1, ..ChosenPrinter::default() }])
    }
}

impl ChosenPrinters {
    /// The printer of this number.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::BadChoice`].
    pub(super) fn get(&self, number: u8) -> Result<&ChosenPrinter, WorkbenchError> {
        self.0.iter().find(|printer| printer.number == number).ok_or_else(|| unknown(number))
    }

    /// The same, to be changed.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::BadChoice`].
    pub(super) fn get_mut(&mut self, number: u8) -> Result<&mut ChosenPrinter, WorkbenchError> {
        self.0.iter_mut().find(|printer| printer.number == number).ok_or_else(|| unknown(number))
    }

    /// Their numbers.
    pub(super) fn numbers(&self) -> impl Iterator<Item = u8> {
        self.0.iter().map(|printer| printer.number)
    }

    /// One more, with the first number that is free.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::BadChoice`] where there are as many as there may be.
    pub(super) fn add(&mut self) -> Result<(), WorkbenchError> {
        let number = (1..=MOST_PRINTERS).find(|number| self.get(*number).is_err());
        let number = number.ok_or_else(|| unknown(MOST_PRINTERS + 1))?;
        self.0.push(ChosenPrinter { number, ..ChosenPrinter::default() });
        self.0.sort_by_key(|printer| printer.number);
        Ok(())
    }

    /// One less; the first stays.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::BadChoice`].
    pub(super) fn remove(&mut self, number: u8) -> Result<(), WorkbenchError> {
        self.get(number).and_then(|printer| if printer.number == 1 { Err(unknown(1)) } else { Ok(()) })?;
        self.0.retain(|printer| printer.number != number);
        Ok(())
    }

    /// The printers as the page shows them.
    pub(super) fn document(&self) -> Value {
        let row = |ChosenPrinter { number, name, port, server, key_file, fingerprint }: &ChosenPrinter| json!({"number": number, "name": name, "port": port, "server": server, "key_file": key_file, "fingerprint": fingerprint});
        self.0.iter().map(row).collect()
    }
}

fn unknown(number: u8) -> WorkbenchError {
    WorkbenchError::BadChoice { name: "printer", value: number.to_string() }
}

impl ChosenPrinter {
    /// What a choice of this name may be changed to `value`, with its name and whether it may have that; `None` for one that is no printer's.
    pub(super) fn place(&mut self, name: &str, value: &str) -> Option<(&mut String, &'static str, bool)> {
        Some(match name {
            "printer_name" => {
                let good = value.chars().count() <= MOST_NAME && !value.chars().any(char::is_control);
                (&mut self.name, "printer_name", good)
            }
            "port" => (&mut self.port, "port", is_word(value)),
            "server" => (&mut self.server, "server", is_word(value)),
            "key_file" => (&mut self.key_file, "key_file", value.is_empty() || is_below(value)),
            "fingerprint" => {
                let good = value.is_empty() || value.parse::<Fingerprint>().is_ok();
                (&mut self.fingerprint, "fingerprint", good)
            }
            _ => return None,
        })
    }

    /// The words that follow `--to`.
    pub(super) fn server_words(&self) -> Vec<String> {
        let mut words = vec![self.server.clone()];
        if !self.key_file.is_empty() {
            words.extend(["--key-file".to_owned(), self.key_file.clone()]);
        }
        if let Ok(fingerprint) = self.fingerprint.parse::<Fingerprint>() {
            words.extend(["--fingerprint".to_owned(), fingerprint.to_string()]);
        }
        words
    }

    /// The journal of a print of `gcode`, as flag and file: two printers have the same file, and each its own journal.
    pub(super) fn journal_words(&self, gcode: &str) -> Vec<String> {
        match self.number {
            1 => Vec::new(),
            number => vec!["--journal".to_owned(), format!("{gcode}.{number}.journal")],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_and_free_ones_come_back() {
        let mut printers = ChosenPrinters::default();
        assert!(printers.remove(1).is_err() && printers.remove(2).is_err());
        (2..=MOST_PRINTERS).for_each(|_| printers.add().unwrap());
        assert!(printers.add().is_err());
        printers.remove(3).unwrap();
        assert!(printers.get(3).is_err() && printers.get(4).is_ok());
        printers.add().unwrap();
        assert_eq!(printers.numbers().collect::<Vec<_>>(), (1..=MOST_PRINTERS).collect::<Vec<_>>());
    }

    #[test]
    fn what_is_none_of_a_printers_is_left_to_others() {
        let mut printer = ChosenPrinter::default();
        let mut good = |name: &str, value: &str| printer.place(name, value).map(|(_, _, good)| good);
        assert_eq!((good("printer_name", "left one"), good("printer_name", "a\nb")), (Some(true), Some(false)));
        assert_eq!(
            (good("port", "-p"), good("server", ""), good("key_file", "../k")),
            (Some(false), Some(true), Some(false))
        );
        assert_eq!((good("printer_name", &"x".repeat(41)), good("way", "cut")), (Some(false), None));
    }
}
