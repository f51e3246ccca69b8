//! A JSON file whose values know their lines.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::profile::import::ImportError;
use crate::profile::import::stated::{File, Stated, StatedAt, shown};

/// A file, its values, and the line of each by its path (`limits.x.min`, `proxies.3.part`).
pub(super) struct Document<'a> {
    file: &'a File,
    value: Value,
    lines: BTreeMap<String, usize>,
}

impl<'a> Document<'a> {
    /// # Errors
    ///
    /// [`ImportError`] for what is no JSON, with the line, and for a key that stands twice.
    pub(super) fn read(file: &'a File) -> Result<Self, ImportError> {
        let value: Value = serde_json::from_str(&file.text).map_err(|error| {
            let why = format!("not JSON (column {}); it may be cut off or edited by hand", error.column());
            ImportError::At { place: file.place(error.line()), why }
        })?;
        let mut scan = Scan { text: file.text.as_bytes(), at: 0, line: 1, lines: BTreeMap::new(), twice: None };
        scan.value("");
        if let Some((path, line)) = scan.twice {
            let why = format!("{path} is given twice; the first is in line {}", scan.lines[&path]);
            return Err(ImportError::At { place: file.place(line), why });
        }
        Ok(Self { file, value, lines: scan.lines })
    }

    pub(super) fn name(&self) -> &str {
        &self.file.name
    }

    /// The line of a value; of one that is not there, of what it would stand in.
    pub(super) fn place(&self, path: &str) -> StatedAt {
        let mut path = path;
        loop {
            if let Some(line) = self.lines.get(path) {
                return self.file.place(*line);
            }
            let Some((outer, _)) = path.rsplit_once('.') else { return self.file.place(1) };
            path = outer;
        }
    }

    pub(super) fn at(&self, path: &str) -> Option<&Value> {
        path.split('.').try_fold(&self.value, |value, name| match value {
            Value::Array(all) => all.get(name.parse::<usize>().ok()?),
            other => other.get(name),
        })
    }

    pub(super) fn has(&self, path: &str) -> bool {
        self.at(path).is_some()
    }

    /// How many values a list has; 0 where there is none.
    pub(super) fn count(&self, path: &str) -> usize {
        self.at(path).and_then(Value::as_array).map_or(0, Vec::len)
    }

    fn wrong<T>(&self, path: &str, wanted: &str) -> Result<T, ImportError> {
        let found = self.at(path).map_or_else(|| "missing".to_owned(), |value| shown(&value.to_string()));
        let empty =
            if self.at(path) == Some(&Value::Null) { " (which the simulator writes for an empty field)" } else { "" };
        Err(ImportError::At { place: self.place(path), why: format!("{path} is {found}{empty}; {wanted}") })
    }

    /// A number, `None` where there is none.
    pub(super) fn number(&self, path: &str) -> Result<Option<Stated>, ImportError> {
        match self.at(path) {
            None => Ok(None),
            Some(value) => match value.as_f64().filter(|v| v.is_finite()) {
                Some(value) => Ok(Some(Stated { value, from: vec![self.place(path)] })),
                None => self.wrong(path, "expected a number"),
            },
        }
    }

    /// A number that must be there.
    pub(super) fn needed(&self, path: &str) -> Result<Stated, ImportError> {
        self.number(path)?.map_or_else(|| self.wrong(path, "expected a number"), Ok)
    }

    pub(super) fn text(&self, path: &str) -> Result<String, ImportError> {
        match self.at(path).and_then(Value::as_str) {
            Some(text) => Ok(text.to_owned()),
            None => self.wrong(path, "expected a string"),
        }
    }

    /// Whether a switch is on; off where there is none.
    pub(super) fn is_on(&self, path: &str) -> Result<bool, ImportError> {
        match self.at(path) {
            None => Ok(false),
            Some(Value::Bool(on)) => Ok(*on),
            Some(_) => self.wrong(path, "expected true or false"),
        }
    }

    /// Three numbers.
    pub(super) fn triple(&self, path: &str) -> Result<[f64; 3], ImportError> {
        if self.count(path) != 3 {
            return self.wrong(path, "expected three numbers");
        }
        let of = |i: usize| self.needed(&format!("{path}.{i}")).map(|stated| stated.value);
        Ok([of(0)?, of(1)?, of(2)?])
    }

    /// The corners of a hull, four at least.
    pub(super) fn points(&self, path: &str, each: impl Fn([f64; 3]) -> [f64; 3]) -> Result<Vec<[f64; 3]>, ImportError> {
        let count = self.count(path);
        if count < 4 {
            return self.wrong(path, "expected at least four corners");
        }
        (0..count).map(|i| Ok(each(self.triple(&format!("{path}.{i}"))?))).collect()
    }
}

/// Goes through JSON that is known to be right, and keeps where values begin.
struct Scan<'a> {
    text: &'a [u8],
    at: usize,
    line: usize,
    lines: BTreeMap<String, usize>,
    twice: Option<(String, usize)>,
}

impl Scan<'_> {
    fn blank(&mut self) -> u8 {
        while let Some(byte) = self.text.get(self.at).filter(|b| b.is_ascii_whitespace() || matches!(b, b',' | b':')) {
            self.line += usize::from(*byte == b'\n');
            self.at += 1;
        }
        self.text.get(self.at).copied().unwrap_or(b'}')
    }

    fn string(&mut self) -> String {
        let start = self.at + 1;
        self.at = start;
        while self.text.get(self.at).is_some_and(|b| *b != b'"') {
            self.at += if self.text[self.at] == b'\\' { 2 } else { 1 };
        }
        let text = String::from_utf8_lossy(&self.text[start..self.at.min(self.text.len())]).into_owned();
        self.at += 1;
        text
    }

    fn value(&mut self, path: &str) {
        let first = self.blank();
        if self.lines.contains_key(path) {
            self.twice.get_or_insert((path.to_owned(), self.line));
        } else {
            self.lines.insert(path.to_owned(), self.line);
        }
        let inner = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
        match first {
            b'{' => {
                self.at += 1;
                while self.blank() == b'"' {
                    let key = self.string();
                    self.value(&inner(&key));
                }
                self.at += 1;
            }
            b'[' => {
                self.at += 1;
                let mut index = 0;
                while self.blank() != b']' && self.at < self.text.len() {
                    self.value(&inner(&index.to_string()));
                    index += 1;
                }
                self.at += 1;
            }
            b'"' => {
                self.string();
            }
            _ => {
                while self
                    .text
                    .get(self.at)
                    .is_some_and(|b| !b.is_ascii_whitespace() && !matches!(b, b',' | b']' | b'}'))
                {
                    self.at += 1;
                }
            }
        }
    }
}
