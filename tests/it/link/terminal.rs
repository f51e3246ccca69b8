//! A terminal for the tests: what stands on it once a program has written to it. Only the sequences that `send` uses; any other one, and
//! a control character, is a failure.

use std::collections::{BTreeSet, VecDeque};
use std::fs::File;
use std::io::Read;
use std::sync::{Arc, Mutex};

use super::real::{terminal, wait_for};

#[derive(Clone, Default)]
struct Line {
    letters: Vec<char>,
    /// It has reached the last column, and goes on in the next one.
    goes_on: bool,
}

/// A terminal of a fixed size, as VT100s are: a line that reaches the last column goes on in the next one.
pub(super) struct Terminal {
    columns: usize,
    /// Those that have left it at its top.
    gone: Vec<Line>,
    lines: VecDeque<Line>,
    at: [usize; 2],
    saved: [usize; 2],
    /// What is cut in two by the end of a read.
    rest: Vec<u8>,
    /// Every line that has stood on it, numbers as `#`.
    seen: BTreeSet<String>,
    /// How often it was looked at while the cursor's line was a status.
    pub(super) statuses: usize,
    /// What stood at its end at any time, the last two lines, numbers as `#`.
    ends: BTreeSet<[String; 2]>,
    /// Lines that went on in the next one.
    pub(super) wrapped: Vec<String>,
}

impl Terminal {
    fn new(columns: usize, lines: usize) -> Self {
        Self {
            columns,
            gone: Vec::new(),
            lines: vec![Line::default(); lines].into(),
            at: [0; 2],
            saved: [0; 2],
            rest: Vec::new(),
            seen: BTreeSet::new(),
            statuses: 0,
            ends: BTreeSet::new(),
            wrapped: Vec::new(),
        }
    }

    /// What the cursor's line says, with the lines that it goes on from.
    fn look(&mut self) {
        let all: Vec<&Line> = self.gone.iter().chain(self.lines.range(..=self.at[0])).collect();
        let begins = all[..all.len() - 1].iter().rposition(|line| !line.goes_on).map_or(0, |i| i + 1);
        let line = plain(&text(all[begins..].iter().copied()));
        self.statuses += usize::from(line.contains("# %, "));
        self.seen.insert(line);
    }

    fn down(&mut self) {
        self.look();
        if self.at[0] + 1 < self.lines.len() {
            self.at[0] += 1;
            return;
        }
        self.gone.extend(self.lines.pop_front());
        self.lines.push_back(Line::default());
    }

    fn put(&mut self, c: char) {
        assert!(!c.is_control(), "{c:?} on the screen");
        if self.at[1] == self.columns {
            let line = &mut self.lines[self.at[0]];
            line.goes_on = true;
            self.wrapped.push(text([&*line]));
            self.down();
            self.at[1] = 0;
        }
        let [row, column] = self.at;
        let line = &mut self.lines[row].letters;
        line.resize(line.len().max(column + 1), ' ');
        line[column] = c;
        self.at[1] += 1;
    }

    fn sequence(&mut self, count: usize, letter: u8) {
        self.look();
        let [row, column] = self.at;
        match letter {
            b'A' => self.at[0] = row.saturating_sub(count.max(1)),
            b'B' => self.at[0] = (row + count.max(1)).min(self.lines.len() - 1),
            b'K' => {
                self.lines[row].letters.truncate(column);
                self.lines[row].goes_on = false;
            }
            b'L' => {
                self.lines.insert(row, Line::default());
                self.lines.pop_back();
            }
            other => panic!("ESC [ {count} {} is none of ours", char::from(other)),
        }
    }

    fn take(&mut self, bytes: &[u8]) {
        let all = [std::mem::take(&mut self.rest).as_slice(), bytes].concat();
        let mut rest = all.as_slice();
        while let Some((&first, behind)) = rest.split_first() {
            if first != 0x1b {
                match first {
                    b'\n' => self.down(),
                    b'\r' => {
                        self.look();
                        self.at[1] = 0;
                    }
                    0x80.. => panic!("{first:#x} on the screen"),
                    c => self.put(char::from(c)),
                }
                rest = behind;
                continue;
            }
            let digits = behind.iter().skip(1).take_while(|b| b.is_ascii_digit()).count();
            let Some(&end) = behind.get(if behind.first() == Some(&b'[') { digits + 1 } else { 0 }) else {
                self.rest = rest.to_vec();
                return;
            };
            match end {
                b'D' => self.down(),
                b'7' => self.saved = self.at,
                b'8' => {
                    self.look();
                    self.at = self.saved;
                }
                letter => {
                    let count = std::str::from_utf8(&behind[1..=digits]).unwrap().parse().unwrap_or(0);
                    self.sequence(count, letter);
                    rest = &behind[digits + 2..];
                    continue;
                }
            }
            rest = &behind[1..];
        }
        self.look();
        let whole = self.whole();
        self.ends.extend(whole.last_chunk().cloned());
    }

    /// All that was ever written and still stands, from the first line on, numbers as `#`; a line that goes on in the next one is one.
    pub(super) fn whole(&self) -> Vec<String> {
        let all: Vec<&Line> = self.gone.iter().chain(&self.lines).collect();
        let lines = all.split_inclusive(|line| !line.goes_on);
        let mut whole: Vec<String> = lines.map(|line| plain(&text(line.iter().copied()))).collect();
        while whole.last().is_some_and(String::is_empty) {
            whole.pop();
        }
        whole
    }

    /// The same; what is indented belongs to the line before it.
    pub(super) fn sentences(&self) -> Vec<String> {
        let mut all: Vec<String> = Vec::new();
        for line in self.whole() {
            match (line.strip_prefix("  "), all.last_mut()) {
                (Some(rest), Some(last)) => *last = format!("{last} {rest}"),
                _ => all.push(line),
            }
        }
        all
    }

    /// Whether this line, numbers as `#`, has ever stood on it.
    pub(super) fn has_shown(&self, golden: &str) -> bool {
        self.seen.contains(golden)
    }
}

/// Waits until these two lines have stood at the screen's end at one time.
#[track_caller]
pub(super) fn ended_with(screen: &Mutex<Terminal>, golden: &[String; 2]) {
    wait_for(&golden.join(" and "), || screen.lock().unwrap().ends.contains(golden));
}

fn text<'a>(lines: impl IntoIterator<Item = &'a Line>) -> String {
    let letters: String = lines.into_iter().flat_map(|line| &line.letters).collect();
    letters.trim_end().to_owned()
}

/// Numbers as `#`.
fn plain(line: &str) -> String {
    let mut out = String::new();
    for c in line.chars() {
        match c {
            '0'..='9' if out.ends_with('#') => {}
            '0'..='9' => out.push('#'),
            c => out.push(c),
        }
    }
    out
}

/// The keyboard of a terminal of this size, what is connected to it as a program's screen, and what stands on that.
pub(super) fn opened(columns: u16, lines: u16) -> (File, File, Arc<Mutex<Terminal>>) {
    let (keys, program) = terminal();
    let size = rustix::termios::Winsize { ws_row: lines, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    rustix::termios::tcsetwinsize(&program, size).unwrap();
    let screen = Arc::new(Mutex::new(Terminal::new(columns.into(), lines.into())));
    let (mut reader, shown) = (keys.try_clone().unwrap(), Arc::clone(&screen));
    std::thread::spawn(move || {
        let mut bytes = [0; 4096];
        while let Ok(n) = reader.read(&mut bytes)
            && n > 0
        {
            shown.lock().unwrap().take(&bytes[..n]);
        }
    });
    (keys, program, screen)
}

/// Waits until this line has stood on the screen.
#[track_caller]
pub(super) fn shows(screen: &Mutex<Terminal>, golden: &str) {
    wait_for(golden, || screen.lock().unwrap().has_shown(golden));
}

/// Waits until this sentence stands on the screen.
#[track_caller]
pub(super) fn says(screen: &Mutex<Terminal>, golden: &str) {
    wait_for(golden, || screen.lock().unwrap().sentences().iter().any(|line| line == golden));
}
