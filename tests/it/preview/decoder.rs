//! Reads a page's block back, by the format's description alone: what is here shares no code with what wrote it but the inflating.

use std::io::Read;

use serde_json::Value;

/// A page, taken apart.
pub(super) struct Page {
    pub(super) html: String,
    pub(super) facts: Value,
    sections: Vec<Vec<u8>>,
}

/// One move.
pub(super) struct Move {
    pub(super) line: u64,
    pub(super) mm: [f64; 3],
    pub(super) e: f64,
    pub(super) feed: f64,
    pub(super) seconds: f64,
    pub(super) style: usize,
    pub(super) place: usize,
    pub(super) flags: u8,
}

/// A part's corners and facets.
pub(super) type Surface = (Vec<[f64; 3]>, Vec<[i64; 3]>);

/// What lies between two texts.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    let start = text.find(from).unwrap_or_else(|| panic!("no {from}")) + from.len();
    &text[start..start + text[start..].find(to).unwrap()]
}

pub(crate) fn from_base64(text: &str) -> Vec<u8> {
    let value = |b: u8| match b {
        b'A'..=b'Z' => b - b'A',
        b'a'..=b'z' => b - b'a' + 26,
        b'0'..=b'9' => b - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        other => panic!("{other} is no letter of base64"),
    };
    let (mut out, mut bits, mut count) = (Vec::new(), 0u32, 0);
    for byte in text.bytes().filter(|b| *b != b'=') {
        bits = bits << 6 | u32::from(value(byte));
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    out
}

struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().expect("a section ends too early");
        self.0 = rest;
        *first
    }

    fn plain(&mut self) -> i64 {
        let (mut value, mut shift) = (0, 0);
        loop {
            let byte = self.byte();
            value |= i64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte & 0x80 == 0 {
                return value;
            }
        }
    }

    fn folded(&mut self) -> i64 {
        let value = self.plain();
        if value & 1 == 1 { -(value >> 1) - 1 } else { value >> 1 }
    }
}

impl Page {
    pub(super) fn read(html: String) -> Self {
        let facts = between(&html, "id=\"facts\">", "</script>");
        let facts = serde_json::from_str(facts).expect("a JSON document");
        let packed = from_base64(between(&html, "id=\"packed\">", "</script>").trim());
        let mut plain = Vec::new();
        flate2::read::DeflateDecoder::new(&packed[..]).read_to_end(&mut plain).expect("a deflate stream");
        let mut sections = Vec::new();
        let mut rest = &plain[..];
        while !rest.is_empty() {
            let length = u32::from_le_bytes(rest[..4].try_into().unwrap()) as usize;
            sections.push(rest[4..4 + length].to_vec());
            rest = &rest[4 + length..];
        }
        Self { html, facts, sections }
    }

    fn section(&self, index: usize) -> Numbers<'_> {
        Numbers(&self.sections[index])
    }

    /// The corners of each part, mm, and its facets.
    pub(super) fn parts(&self) -> Vec<Surface> {
        let (mut corners, mut facets) = (self.section(0), self.section(1));
        let mut part = |part: &Value| {
            let (mut at, mut index) = ([0i64; 3], 0);
            let count = |key: &str| part[key].as_u64().unwrap();
            let points = (0..count("vertices")).map(|_| {
                at = at.map(|v| v + corners.folded());
                at.map(|um| um as f64 / 1000.0)
            });
            let points = points.collect();
            let mut next = || {
                index += facets.folded();
                index
            };
            (points, (0..count("facets")).map(|_| [next(), next(), next()]).collect())
        };
        self.facts["parts"].as_array().unwrap().iter().map(&mut part).collect()
    }

    pub(super) fn moves(&self) -> Vec<Move> {
        let program = &self.facts["program"];
        let number = |table: &str, i: usize| program[table][i].as_f64().unwrap();
        let mut columns: Vec<Numbers<'_>> = (2..12).map(|i| self.section(i)).collect();
        let mut listed = None;
        let mut since = 0;
        let (mut line, mut um, mut feed, mut style, mut place) = (0, [0i64; 3], 0, 0, 0);
        let one = |i: usize| {
            line += columns[0].plain();
            let before = um;
            for axis in 0..3 {
                um[axis] += columns[1 + axis].folded();
            }
            let way = [0, 1, 2].map(|k: usize| (um[k] - before[k]) as f64);
            let length = way.iter().map(|v| v * v).sum::<f64>().sqrt();
            let rest = columns[4].folded();
            feed += columns[5].folded();
            style += columns[6].folded();
            place += columns[7].folded();
            let flags = columns[8].byte();
            let share = || program["styles"][style as usize][4].as_f64().unwrap();
            let expected = if flags & 64 != 0 { (length * share() + 0.5).floor() as i64 } else { 0 };
            let e = (expected + rest) as f64 / 1e5;
            if listed.is_none() && !columns[9].0.is_empty() {
                listed = Some(since + columns[9].plain() as usize);
            }
            let feed = number("feeds", feed as usize);
            let seconds = if listed == Some(i) {
                (listed, since) = (None, i);
                f64::from(f32::from_le_bytes([(); 4].map(|()| columns[9].byte())))
            } else if feed > 0.0 {
                (if length > 0.0 { length / 1000.0 } else { e.abs() }) / feed * 60.0
            } else {
                0.0
            };
            let (style, place) = (style as usize, place as usize);
            Move { line: line as u64, mm: um.map(|v| v as f64 / 1000.0), e, feed, seconds, style, place, flags }
        };
        (0..program["moves"].as_u64().unwrap() as usize).map(one).collect()
    }

    /// The first move of each layer.
    pub(super) fn layers(&self) -> Vec<usize> {
        let (mut numbers, mut at) = (self.section(12), 0);
        let mut all = Vec::new();
        while !numbers.0.is_empty() {
            at += numbers.plain() as usize;
            all.push(at);
        }
        all
    }

    /// The file's lines, written anew or as kept.
    pub(super) fn lines(&self, moves: &[Move]) -> Vec<String> {
        let extruder = self.facts["program"]["extruder"].as_str().unwrap();
        let mut runs = self.section(13);
        let kept = String::from_utf8(self.sections[14].clone()).unwrap();
        let mut kept = kept.split('\n');
        let mut out: Vec<String> = Vec::new();
        let mut anew = true;
        while !runs.0.is_empty() {
            for _ in 0..runs.plain() {
                let number = out.len() as u64 + 1;
                let line = if anew {
                    let at = moves.partition_point(|m| m.line < number);
                    spelt(&moves[at], at.checked_sub(1).map(|before| &moves[before]), extruder)
                } else {
                    kept.next().unwrap().to_owned()
                };
                out.push(line);
            }
            anew = !anew;
        }
        out
    }
}

fn spelt(one: &Move, before: Option<&Move>, extruder: &str) -> String {
    let word = |letter: &str, value: f64, digits: usize| {
        let text = format!("{value:.digits$}");
        format!(" {letter}{}", text.trim_end_matches('0').trim_end_matches('.'))
    };
    let mut line = "G1".to_owned();
    for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
        let from = before.map_or(0.0, |m| m.mm[axis]);
        if one.mm[axis] != from {
            line += &word(letter, one.mm[axis] + 0.0, 3);
        }
    }
    if one.e != 0.0 {
        line += &word(extruder, one.e, 5);
    }
    if one.feed != before.map_or(0.0, |m| m.feed) {
        line += &word("F", one.feed, 3);
    }
    line
}
