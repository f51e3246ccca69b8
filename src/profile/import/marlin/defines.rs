//! `#define`s, as far as the files tell which of them hold: comments, `#if` blocks, names that stand for others, sums.
//!
//! A condition is yes, no, or not told: names that Marlin derives elsewhere (HAS_.., IS_..) are not in these files.

use std::collections::BTreeMap;

use super::super::stated::{Contradiction, File, ImportError, Open, Shelf, StatedAt, shown};

/// Names within names, and brackets within brackets, as far as they are followed.
const DEEPEST: usize = 40;
/// What names begin with that Marlin derives itself.
const DERIVED: [&str; 5] = ["HAS_", "IS_", "NEED", "USE_", "_"];

/// A name and what stands behind it.
#[derive(Clone)]
pub(super) struct Defined {
    pub(super) name: String,
    pub(super) text: String,
    pub(super) place: StatedAt,
    /// Whether it holds for certain; else it may.
    pub(super) certain: bool,
}

#[derive(Default)]
pub(super) struct Defines(BTreeMap<String, Defined>);

/// A block: whether its present branch holds, and whether one before did.
struct Block {
    now: Option<bool>,
    taken: Option<bool>,
    place: StatedAt,
}

fn and(a: Option<bool>, b: Option<bool>) -> Option<bool> {
    if a == Some(false) || b == Some(false) { Some(false) } else { a.zip(b).map(|(a, b)| a && b) }
}

fn not(a: Option<bool>) -> Option<bool> {
    a.map(|a| !a)
}

/// Whether all hold; one that does not settles it, whatever the others are.
fn every(all: impl Iterator<Item = Option<bool>>) -> Option<bool> {
    let mut result = Some(true);
    for one in all {
        result = and(result, one);
    }
    result
}

impl Defines {
    pub(super) fn read(files: &[File], shelf: &dyn Shelf) -> Result<Self, ImportError> {
        let mut defines = Self::default();
        Open::each(files, shelf, |file, open| defines.file(file, open))?;
        Ok(defines)
    }

    fn file(&mut self, file: &File, open: &mut Open<'_>) -> Result<(), ImportError> {
        let mut blocks: Vec<Block> = Vec::new();
        for (place, line) in plain_lines(file) {
            let Some(rest) = line.trim().strip_prefix('#') else { continue };
            let rest = rest.trim_start();
            let end = rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len());
            let (directive, rest) = (&rest[..end], rest[end..].trim());
            let wrong = |why: &str| ImportError::At { place: place.clone(), why: why.to_owned() };
            match directive {
                "if" | "ifdef" | "ifndef" => {
                    let now = match directive {
                        "if" => self.holds(rest),
                        "ifdef" => self.is_defined(rest),
                        _ => not(self.is_defined(rest)),
                    };
                    blocks.push(Block { now, taken: now, place });
                }
                "elif" | "else" => {
                    let now = if directive == "elif" { self.holds(rest) } else { Some(true) };
                    let block = blocks.last_mut().ok_or_else(|| wrong("there is no #if before it"))?;
                    block.now = and(not(block.taken), now);
                    block.taken = not(and(not(block.taken), not(now)));
                }
                "endif" => {
                    blocks.pop().ok_or_else(|| wrong("there is no #if before it"))?;
                }
                _ => {
                    let holds = every(blocks.iter().map(|block| block.now));
                    match directive {
                        "define" => self.define(rest, place, holds)?,
                        "undef" if holds == Some(true) => drop(self.0.remove(rest)),
                        "include" if holds == Some(true) => self.include(rest, &place, file, open)?,
                        _ => {}
                    }
                }
            }
        }
        match blocks.pop() {
            Some(block) => Err(ImportError::At { place: block.place, why: "this #if has no #endif".to_owned() }),
            None => Ok(()),
        }
    }

    fn include(&mut self, named: &str, place: &StatedAt, file: &File, open: &mut Open<'_>) -> Result<(), ImportError> {
        // What stands in angle brackets is the compiler's.
        let Some(name) = named.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')) else { return Ok(()) };
        let inner = open.named(file.beside(name), place, "put it where the line says")?;
        self.file(&inner, open)?;
        open.leave();
        Ok(())
    }

    fn define(&mut self, rest: &str, place: StatedAt, holds: Option<bool>) -> Result<(), ImportError> {
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
        // What takes arguments is code.
        if holds == Some(false) || rest[end..].starts_with('(') {
            return Ok(());
        }
        let (name, text) = (rest[..end].to_owned(), rest[end..].trim().to_owned());
        let certain = holds == Some(true);
        match self.0.get_mut(&name) {
            Some(first) if first.text != text && certain && first.certain => Err(Contradiction {
                what: name,
                first: first.place.clone(),
                one: first.text.clone(),
                second: place,
                other: text,
            }
            .into()),
            Some(first) if !certain => {
                first.certain &= first.text == text;
                Ok(())
            }
            _ => {
                self.0.insert(name.clone(), Defined { name, text, place, certain });
                Ok(())
            }
        }
    }

    pub(super) fn get(&self, name: &str) -> Option<&Defined> {
        self.0.get(name)
    }

    /// Whether a name is defined; `None` where these files do not tell.
    fn is_defined(&self, name: &str) -> Option<bool> {
        match self.0.get(name.trim()) {
            Some(defined) => defined.certain.then_some(true),
            None if DERIVED.iter().any(|start| name.starts_with(start)) => None,
            None => Some(false),
        }
    }

    fn is_enabled(&self, name: &str) -> Option<bool> {
        let on = self.0.get(name.trim()).map(|defined| matches!(&*defined.text, "" | "1" | "true"));
        and(self.is_defined(name), Some(on.unwrap_or(false))).filter(|_| self.is_defined(name).is_some())
    }

    fn holds(&self, condition: &str) -> Option<bool> {
        let value = Expression { defines: self, rest: condition, deep: 0 }.whole()?;
        Some(value != 0.0)
    }

    fn value(&self, text: &str) -> Option<f64> {
        Expression { defines: self, rest: text, deep: 0 }.whole()
    }

    fn no_number(defined: &Defined, text: &str) -> ImportError {
        let why = format!("{} is {}, which does not evaluate to a number in these files", defined.name, shown(text));
        ImportError::At { place: defined.place.clone(), why }
    }

    pub(super) fn number(&self, defined: &Defined) -> Result<f64, ImportError> {
        self.value(&defined.text).filter(|v| v.is_finite()).ok_or_else(|| Self::no_number(defined, &defined.text))
    }

    pub(super) fn list(&self, defined: &Defined) -> Result<Vec<f64>, ImportError> {
        let inner = defined.text.strip_prefix('{').and_then(|rest| rest.strip_suffix('}'));
        let why = || format!("{} must be a list in braces, got {}", defined.name, shown(&defined.text));
        let inner = inner.ok_or_else(|| ImportError::At { place: defined.place.clone(), why: why() })?;
        let all = inner.trim().trim_end_matches(',').split(',');
        all.map(|one| self.value(one).filter(|v| v.is_finite()).ok_or_else(|| Self::no_number(defined, one))).collect()
    }

    pub(super) fn letter(&self, defined: &Defined) -> Result<char, ImportError> {
        let letter = defined.text.strip_prefix('\'').and_then(|rest| rest.strip_suffix('\''));
        let mut letters = letter.unwrap_or_default().chars();
        match (letters.next(), letters.next()) {
            (Some(letter), None) if letter.is_ascii_uppercase() => Ok(letter),
            _ => {
                let why =
                    format!("{} must be a capital letter in single quotes, got {}", defined.name, shown(&defined.text));
                Err(ImportError::At { place: defined.place.clone(), why })
            }
        }
    }
}

/// Lines without comments, those that end with a backslash joined with the next.
fn plain_lines(file: &File) -> Vec<(StatedAt, String)> {
    let (mut out, mut comment): (Vec<(StatedAt, String)>, bool) = (Vec::new(), false);
    let mut goes_on = false;
    for (place, line) in file.lines() {
        let mut plain = String::new();
        let (mut chars, mut quote) = (line.chars().peekable(), None);
        while let Some(c) = chars.next() {
            let next = chars.peek().copied();
            if comment {
                if c == '*' && next == Some('/') {
                    chars.next();
                    comment = false;
                    plain.push(' ');
                }
            } else if let Some(end) = quote {
                plain.push(c);
                if c == '\\' {
                    plain.extend(chars.next());
                } else if c == end {
                    quote = None;
                }
            } else if c == '/' && next == Some('*') {
                chars.next();
                comment = true;
            } else if c == '/' && next == Some('/') {
                break;
            } else {
                // Only what opens at once closes: an apostrophe in a text of #error does not.
                quote = (c == '"' || (c == '\'' && plain.trim_start().starts_with("#define"))).then_some(c);
                plain.push(c);
            }
        }
        let text = plain.trim_end();
        let (text, more) = text.strip_suffix('\\').map_or((text, false), |text| (text, true));
        match out.last_mut().filter(|_| goes_on) {
            Some((_, before)) => before.push_str(text),
            None => out.push((place, text.to_owned())),
        }
        goes_on = more;
    }
    out
}

type Comparison = fn(f64, f64) -> bool;

/// A sum or a condition; every step gives `None` where it is not told.
struct Expression<'a> {
    defines: &'a Defines,
    rest: &'a str,
    deep: usize,
}

impl<'a> Expression<'a> {
    fn whole(mut self) -> Option<f64> {
        let value = self.either()?;
        self.rest.trim().is_empty().then_some(value).and_then(|value| value)
    }

    fn takes(&mut self, sign: &str) -> bool {
        let rest = self.rest.trim_start();
        let found = rest.strip_prefix(sign);
        self.rest = found.unwrap_or(rest);
        found.is_some()
    }

    /// `a || b`; each level gives the value as far as it is told, and reads on in any case.
    fn either(&mut self) -> Option<Option<f64>> {
        let mut value = self.both()?;
        while self.takes("||") {
            let (a, b) = (value.map(|v| v != 0.0), self.both()?.map(|v| v != 0.0));
            value = not(and(not(a), not(b))).map(f64::from);
        }
        Some(value)
    }

    fn both(&mut self) -> Option<Option<f64>> {
        let mut value = self.compared()?;
        while self.takes("&&") {
            let (a, b) = (value.map(|v| v != 0.0), self.compared()?.map(|v| v != 0.0));
            value = and(a, b).map(f64::from);
        }
        Some(value)
    }

    fn compared(&mut self) -> Option<Option<f64>> {
        let a = self.sum()?;
        let signs: [(&str, Comparison); 6] = [
            ("==", |a, b| a == b),
            ("!=", |a, b| a != b),
            ("<=", |a, b| a <= b),
            (">=", |a, b| a >= b),
            ("<", |a, b| a < b),
            (">", |a, b| a > b),
        ];
        for (sign, holds) in signs {
            if self.takes(sign) {
                let b = self.sum()?;
                return Some(a.zip(b).map(|(a, b)| f64::from(holds(a, b))));
            }
        }
        Some(a)
    }

    fn sum(&mut self) -> Option<Option<f64>> {
        let mut value = self.product()?;
        loop {
            let sign = if self.takes("+") {
                1.0
            } else if self.takes("-") {
                -1.0
            } else {
                return Some(value);
            };
            value = value.zip(self.product()?).map(|(a, b)| a + sign * b);
        }
    }

    fn product(&mut self) -> Option<Option<f64>> {
        let mut value = self.one()?;
        loop {
            if self.takes("*") {
                value = value.zip(self.one()?).map(|(a, b)| a * b);
            } else if self.takes("/") {
                value = value.zip(self.one()?).map(|(a, b)| a / b);
            } else {
                return Some(value);
            }
        }
    }

    fn one(&mut self) -> Option<Option<f64>> {
        self.deep += 1;
        if self.deep > DEEPEST {
            return None;
        }
        let value = if self.takes("!") {
            self.one()?.map(|v| f64::from(v == 0.0))
        } else if self.takes("-") {
            self.one()?.map(|v| 0.0 - v)
        } else if self.takes("(") {
            let inner = self.either()?;
            if !self.takes(")") {
                return None;
            }
            inner
        } else {
            self.word()?
        };
        self.deep -= 1;
        Some(value)
    }

    /// A number, a name, or a question about names.
    fn word(&mut self) -> Option<Option<f64>> {
        let rest = self.rest.trim_start();
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '.').unwrap_or(rest.len());
        let word = &rest[..end];
        self.rest = &rest[end..];
        let first = word.chars().next()?;
        if first.is_ascii_digit() || first == '.' {
            let number = word.trim_end_matches(['f', 'F', 'u', 'U', 'l', 'L']);
            return Some(Some(number.parse().ok()?));
        }
        if word == "defined" && !self.rest.trim_start().starts_with('(') {
            let rest = self.rest.trim_start();
            let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
            self.rest = &rest[end..];
            return Some(self.defines.is_defined(&rest[..end]).map(f64::from));
        }
        if self.takes("(") {
            let (names, after) = self.rest.split_once(')')?;
            self.rest = after;
            return Some(self.asked(word, names).map(f64::from));
        }
        match word {
            "true" => return Some(Some(1.0)),
            "false" => return Some(Some(0.0)),
            _ => {}
        }
        let Some(defined) = self.defines.get(word).filter(|defined| defined.certain) else { return Some(None) };
        let inner = Expression { defines: self.defines, rest: &defined.text, deep: self.deep };
        Some(inner.whole())
    }

    fn asked(&self, question: &str, names: &str) -> Option<bool> {
        let on = |name: &str| self.defines.is_enabled(name.trim());
        let all = || every(names.split(',').map(on));
        let none = || every(names.split(',').map(|name| not(on(name))));
        match question {
            "defined" => self.defines.is_defined(names),
            "ENABLED" | "ALL" | "BOTH" => all(),
            "DISABLED" | "NONE" => none(),
            "ANY" | "EITHER" => not(none()),
            _ => None,
        }
    }
}
