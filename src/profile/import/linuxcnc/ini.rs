//! The ini: sections, `KEY = VALUE`, `#INCLUDE FILE`; a line ends with a backslash where it goes on in the next.

use super::super::stated::{Contradiction, File, ImportError, Open, Shelf, StatedAt};
use super::lines_of;

pub(super) struct Entry {
    pub(super) section: String,
    pub(super) key: String,
    pub(super) value: String,
    pub(super) place: StatedAt,
}

impl Entry {
    /// The value without a comment behind it.
    pub(super) fn bare(&self) -> &str {
        self.value.split(['#', ';']).next().unwrap_or_default().trim()
    }
}

pub(super) struct Ini {
    entries: Vec<Entry>,
    file: String,
}

impl Ini {
    pub(super) fn read(file: &File, shelf: &dyn Shelf) -> Result<Self, ImportError> {
        let mut open = Open::new(shelf);
        open.enter(file);
        let named = |of: &File, line: &str| {
            let name = line.strip_prefix("#INCLUDE").filter(|rest| rest.starts_with(char::is_whitespace))?;
            Some((of.beside(name.trim()), "put it beside the ini".to_owned()))
        };
        let (mut entries, mut section) = (Vec::new(), String::new());
        lines_of(file, &mut open, &named, &mut |place, line| {
            if line.starts_with(['#', ';']) {
                return Ok(());
            }
            if let Some((name, _)) = line.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
                name.trim().clone_into(&mut section);
            } else if let Some((key, value)) = line.split_once('=') {
                let (key, value) = (key.trim().to_owned(), value.trim().to_owned());
                entries.push(Entry { section: section.clone(), key, value, place });
            }
            Ok(())
        })?;
        Ok(Self { entries, file: file.name.clone() })
    }

    /// Every value under that key, in order.
    pub(super) fn every(&self, section: &str, key: &str) -> Vec<&Entry> {
        self.entries.iter().filter(|entry| entry.section == section && entry.key == key).collect()
    }

    /// The one value under that key.
    pub(super) fn one(&self, section: &str, key: &str) -> Result<Option<&Entry>, ImportError> {
        let mut all = self.every(section, key).into_iter();
        let first = all.next();
        match (first, all.find(|other| first.is_some_and(|first| first.bare() != other.bare()))) {
            (Some(first), Some(other)) => Err(Contradiction {
                what: format!("[{section}] {key}"),
                first: first.place.clone(),
                one: first.bare().to_owned(),
                second: other.place.clone(),
                other: other.bare().to_owned(),
            }
            .into()),
            _ => Ok(first),
        }
    }

    pub(super) fn wanted(&self, section: &str, key: &str) -> Result<&Entry, ImportError> {
        self.one(section, key)?.ok_or_else(|| {
            let why = format!("[{section}] has no {key}, without which the machine's axes are unknown");
            ImportError::File { file: self.file.clone(), why }
        })
    }

    /// Where a section begins to say something.
    pub(super) fn first(&self, section: &str) -> Option<StatedAt> {
        self.entries.iter().find(|entry| entry.section == section).map(|entry| entry.place.clone())
    }
}
