//! A line of RepRapFirmware's own words: a command, then letters with numbers, lists (`1:2`), texts (`"a"`) or expressions (`{..}`).

use super::super::stated::{ImportError, StatedAt, number};
use super::worked_out;

pub(super) struct Command {
    /// `M584`.
    pub(super) code: String,
    /// Letters with what stands behind them, texts with their quotes.
    pub(super) words: Vec<(char, String)>,
    /// Numbers that stand behind no letter; the firmware passes over them.
    pub(super) stray: Vec<String>,
}

/// The command of a line; `None` where it is none.
pub(super) fn command(line: &str, place: &StatedAt) -> Result<Option<Command>, ImportError> {
    let (words, stray) = split(line);
    let mut words = words.into_iter();
    let mut first = words.next();
    if first.as_ref().is_some_and(|(letter, _)| *letter == 'N') {
        first = words.next();
    }
    let Some((letter @ ('G' | 'M'), number)) = first else { return Ok(None) };
    let code = format!("{letter}{number}");
    let words: Vec<(char, String)> = words.collect();
    let expression = words.iter().find(|(_, text)| text.starts_with('{'));
    match expression.filter(|_| super::READ.contains(&&*code)) {
        Some((letter, text)) => Err(worked_out(&format!("{code} {letter}"), text, place)),
        None => Ok(Some(Command { code, words, stray })),
    }
}

/// Letters, and what stands behind each; and what stands behind none.
fn split(line: &str) -> (Vec<(char, String)>, Vec<String>) {
    let mut words: Vec<(char, String)> = Vec::new();
    let mut stray: Vec<String> = Vec::new();
    // Whether a number has ended, and whether another one has begun behind it.
    let (mut ended, mut strays) = (false, false);
    let (mut quoted, mut braces) = (false, 0_usize);
    for c in line.chars() {
        if !quoted && braces == 0 {
            if c == ';' {
                break;
            }
            if c.is_ascii_alphabetic() {
                words.push((c.to_ascii_uppercase(), String::new()));
                (ended, strays) = (false, false);
                continue;
            }
            let text = words.last().map_or("", |(_, text)| text);
            if c.is_whitespace() {
                ended = text.ends_with(|c: char| c.is_ascii_digit() || c == '.');
                strays = false;
            } else if ended && (c.is_ascii_digit() || "+-.".contains(c)) {
                stray.push(String::new());
                (ended, strays) = (false, true);
            }
            if let Some(number) = stray.last_mut().filter(|_| strays) {
                number.push(c);
                continue;
            }
        }
        match c {
            '"' => quoted = !quoted,
            '{' if !quoted => braces += 1,
            '}' if !quoted => braces = braces.saturating_sub(1),
            _ => {}
        }
        if let Some((_, text)) = words.last_mut()
            && (quoted || braces > 0 || !c.is_whitespace())
        {
            text.push(c);
        }
    }
    (words, stray)
}

impl Command {
    fn get(&self, letter: char) -> Option<&str> {
        self.words.iter().find(|(of, _)| *of == letter).map(|(_, text)| &**text)
    }

    /// The number behind a letter.
    pub(super) fn number(&self, letter: char, place: &StatedAt) -> Result<Option<f64>, ImportError> {
        let what = || format!("{} {letter}", self.code);
        self.get(letter).map(|text| number(&what(), text, place)).transpose()
    }

    /// The text behind a letter, without its quotes.
    pub(super) fn text(&self, letter: char) -> Option<String> {
        let text = self.get(letter)?.strip_prefix('"')?.strip_suffix('"')?;
        Some(text.replace("\"\"", "\""))
    }
}
