//! A trace as columns of small numbers: what the page replays.
//!
//! A move keeps where it ends (whole micrometres, machine frame), its filament (hundred-thousandths of a millimetre), and the
//! numbers of its line, its feed, its [`Style`] and its [`DrawnPose`]; all but the flags as differences. Filament is the difference from
//! what the style's mean share would give, which rounding alone makes other than 0. Times follow from way and feed; where they do
//! not (an axis at its fastest, the table's turns), they stand in a list of their own.
//!
//! ```text
//! sections: line, x, y, z, e, feed, style, place, flags, times, layers, runs of the text, its kept lines
//! predicted e = floor(length_um * share + 0.5)      in f64, so that every reader comes to the same number
//! predicted s = length_mm / feed * 60               |e| where the tip stays
//! ```

use std::collections::HashMap;

use super::pack::Column;
use super::text::{Text, Written};
use crate::gcode::marks::Role;
use crate::geom::{Machine, Rigid, Table};
use crate::motion::{Pose, TableKinematics};
use crate::trace::{State, Trace, TraceMove};

/// Units of a coordinate in a millimetre.
pub(super) const XYZ: f64 = 1e3;
/// Units of filament in a millimetre: the last digit that is written.
pub(super) const E: f64 = 1e5;
/// A layer is another one from this difference in height on, micrometres.
const LAYER_UM: i64 = 5;

/// What a move has besides, as bits of its flags.
pub mod flag {
    /// Where the move ends, X, Y or Z is unknown: bits 0 to 2.
    pub const UNKNOWN: u8 = 0;
    /// Where it begins: bits 3 to 5.
    pub const FROM_UNKNOWN: u8 = 3;
    /// It lays filament.
    pub const LAYS: u8 = 1 << 6;
    /// It begins at another pose than it ends.
    pub const TURNS: u8 = 1 << 7;
}

/// What moves that lay filament have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// The print, in the order of the plan.
    pub print: Option<u32>,
    /// What it is for.
    pub role: Role,
    /// Width and height as stated, mm; 0 where they are not.
    pub width_mm: f64,
    /// See `width_mm`.
    pub height_mm: f64,
    /// Units of filament to a micrometre of way, on average.
    pub share: f64,
}

/// What moves at one pose have in common.
#[derive(Clone, Debug)]
pub struct DrawnPose {
    /// The state that it was taken from.
    pub state: State,
    /// From the table's frame to the machine's; `None` while an angle is unknown.
    pub motion: Option<Rigid<Table, Machine>>,
}

/// A program, packed.
#[derive(Clone, Debug)]
pub struct DrawnProgram {
    /// Moves of any axis.
    pub moves: usize,
    /// Layers, at all poses.
    pub layers: usize,
    /// Lines of the file.
    pub lines: u32,
    /// Of these, those that are written anew from their moves, to the letter.
    pub rebuilt: u32,
    /// Time of all moves and waits, s.
    pub seconds: f64,
    /// Millimetres a minute, in the order in which they come up.
    pub feeds: Vec<f64>,
    /// In the order in which they come up.
    pub styles: Vec<Style>,
    /// In the order in which they come up.
    pub places: Vec<DrawnPose>,
    pub(super) columns: Vec<Column>,
    pub(super) text: Text,
}

/// A move in whole numbers.
#[derive(Clone, Copy, Default)]
struct Whole {
    at: [i64; 3],
    e: i64,
    length_um: f64,
    feed: usize,
    style: usize,
    place: usize,
    flags: u8,
}

impl DrawnProgram {
    /// The program in `bytes`, of which `trace` was read; `extruder` is the filament's letter.
    pub fn of(trace: &Trace, bytes: &[u8], kinematics: &TableKinematics, extruder: char) -> Self {
        let mut tables = Tables::default();
        let mut last = Whole::default();
        let wholes: Vec<Whole> = trace
            .moves()
            .map(|one| {
                last = tables.whole(trace, &one, &last);
                last
            })
            .collect();
        let styles = tables.shared(&wholes);
        let (columns, layers) = columns(trace, &wholes, &tables.feeds, &styles);
        let written = |i: usize| {
            let (one, before) = (wholes[i], if i == 0 { Whole::default() } else { wholes[i - 1] });
            let feed = |w: Whole| (tables.feeds[w.feed] * 1000.0).round() as i64;
            let new_feed = (one.feed != before.feed).then(|| feed(one));
            Written { to: one.at, from: before.at, e: one.e, feed: new_feed }
        };
        let text = Text::of(bytes, trace, extruder, written);
        let places = tables
            .places
            .iter()
            .map(|state| DrawnPose { state: *state, motion: state.pose().map(|pose: Pose| kinematics.forward(pose)) });
        Self {
            moves: trace.len(),
            layers,
            lines: trace.lines,
            rebuilt: text.rebuilt,
            seconds: trace.seconds,
            places: places.collect(),
            feeds: tables.feeds,
            styles,
            columns,
            text,
        }
    }
}

/// A style's key: print, role, width and height in micrometres.
type StyleKey = (Option<u32>, Role, i64, i64);

struct Tables {
    feeds: Vec<f64>,
    feed_of: HashMap<u64, usize>,
    styles: Vec<StyleKey>,
    style_of: HashMap<StyleKey, usize>,
    places: Vec<State>,
    /// The state that was looked up last, and its number.
    latest: Option<(State, usize)>,
}

impl Default for Tables {
    /// Feed 0 is "none yet".
    fn default() -> Self {
        let (feeds, feed_of) = (vec![0.0], HashMap::from([(0.0f64.to_bits(), 0)]));
        Self { feeds, feed_of, styles: Vec::new(), style_of: HashMap::new(), places: Vec::new(), latest: None }
    }
}

impl Tables {
    fn whole(&mut self, trace: &Trace, one: &TraceMove, last: &Whole) -> Whole {
        let mut flags = 0;
        for axis in 0..3 {
            flags |= u8::from(one.to[axis].is_none()) << (flag::UNKNOWN + axis as u8);
            flags |= u8::from(one.from[axis].is_none()) << (flag::FROM_UNKNOWN + axis as u8);
        }
        if one.prints() {
            flags |= flag::LAYS;
        }
        if trace.has_new_pose(one) {
            flags |= flag::TURNS;
        }
        // What is not known stays where it was: the flag says so.
        let at = [0, 1, 2].map(|i: usize| one.to[i].map_or(last.at[i], |mm| (mm * XYZ).round() as i64));
        let way = [0, 1, 2].map(|i: usize| (at[i] - last.at[i]) as f64);
        let length_um = (way[0] * way[0] + way[1] * way[1] + way[2] * way[2]).sqrt();
        let style = if one.prints() { self.style(trace, one) } else { last.style };
        let feed = one.feed.map_or(0, |feed| self.feed(feed));
        Whole { at, e: (one.e * E).round() as i64, length_um, feed, style, place: self.place(trace.state(one)), flags }
    }

    fn feed(&mut self, feed: f64) -> usize {
        let next = self.feeds.len();
        let at = *self.feed_of.entry(feed.to_bits()).or_insert(next);
        if at == next {
            self.feeds.push(feed);
        }
        at
    }

    fn style(&mut self, trace: &Trace, one: &TraceMove) -> usize {
        let um = |mm: Option<f64>| mm.map_or(0, |mm| (mm * 1000.0).round() as i64);
        let key = (trace.state(one).print, one.role, um(one.width), um(one.height));
        let next = self.styles.len();
        let at = *self.style_of.entry(key).or_insert(next);
        if at == next {
            self.styles.push(key);
        }
        at
    }

    /// A state's number; states that differ in the print alone are one.
    fn place(&mut self, state: &State) -> usize {
        let state = State { print: None, ..*state };
        if let Some((_, at)) = self.latest.filter(|(latest, _)| *latest == state) {
            return at;
        }
        let known = self.places.iter().position(|place| *place == state);
        let at = known.unwrap_or(self.places.len());
        if known.is_none() {
            self.places.push(state);
        }
        self.latest = Some((state, at));
        at
    }

    /// The styles with their shares.
    fn shared(&self, wholes: &[Whole]) -> Vec<Style> {
        let mut sums = vec![[0.0, 0.0]; self.styles.len()];
        for one in wholes.iter().filter(|one| one.flags & flag::LAYS != 0) {
            sums[one.style][0] += one.e as f64;
            sums[one.style][1] += one.length_um;
        }
        let mm = |um: i64| um as f64 / 1000.0;
        let style = |(&(print, role, width, height), [e, um]): (&StyleKey, [f64; 2])| Style {
            print,
            role,
            width_mm: mm(width),
            height_mm: mm(height),
            share: if um > 0.0 { e / um } else { 0.0 },
        };
        self.styles.iter().zip(sums).map(style).collect()
    }
}

/// The filament that a move of a style is expected to take.
fn expected_e(one: &Whole, styles: &[Style]) -> i64 {
    if one.flags & flag::LAYS == 0 { 0 } else { (one.length_um * styles[one.style].share + 0.5).floor() as i64 }
}

/// The time that a move is expected to take, s.
fn expected_s(one: &Whole, feeds: &[f64]) -> f64 {
    let way = if one.length_um > 0.0 { one.length_um / XYZ } else { one.e.abs() as f64 / E };
    if feeds[one.feed] > 0.0 { way / feeds[one.feed] * 60.0 } else { 0.0 }
}

fn columns(trace: &Trace, wholes: &[Whole], feeds: &[f64], styles: &[Style]) -> (Vec<Column>, usize) {
    let mut all = vec![Column::default(); 11];
    let [line, x, y, z, e, feed, style, place, flags, times, layers] = &mut all[..] else { return (all, 0) };
    let (mut last, mut last_line, mut last_time, mut last_layer) = (Whole::default(), 0, 0, 0);
    let (mut top, mut count) = (None, 0);
    for (i, (one, of)) in wholes.iter().zip(trace.moves()).enumerate() {
        line.unsigned(u64::from(of.line - last_line));
        for (axis, column) in [&mut *x, &mut *y, &mut *z].into_iter().enumerate() {
            column.signed(one.at[axis] - last.at[axis]);
        }
        e.signed(one.e - expected_e(one, styles));
        feed.signed(one.feed as i64 - last.feed as i64);
        style.signed(one.style as i64 - last.style as i64);
        place.signed(one.place as i64 - last.place as i64);
        flags.0.push(one.flags);
        let wanted = expected_s(one, feeds);
        if (of.seconds - wanted).abs() > 1e-4 + 1e-3 * wanted {
            times.unsigned((i - last_time) as u64);
            times.0.extend((of.seconds as f32).to_le_bytes());
            last_time = i;
        }
        let here = (one.at[2], one.place);
        let new = |(z, place): (i64, usize)| place != here.1 || (z - here.0).abs() > LAYER_UM;
        if one.flags & flag::LAYS != 0 && top.is_none_or(new) {
            layers.unsigned((i - last_layer) as u64);
            (top, last_layer, count) = (Some(here), i, count + 1);
        }
        (last, last_line) = (*one, of.line);
    }
    (all, count)
}
