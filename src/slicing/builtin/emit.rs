//! Paths as G-code text.

use std::collections::VecDeque;
use std::f64::consts::PI;

use super::arcs::{self, Arc, Micrometres, Piece, distance_mm};
use super::plan::{Feature, Path};
use super::region::{GridPoint, UNITS_PER_MM};
use super::{Line, Lines};
use crate::gcode::push_units;
use crate::slicing::SliceSettings;

/// A place of the filament is pulled back and forth at most so often within so many of E's last digits (5 mm): more, and the gear
/// grinds it. Slicers leave that to the user; printing guides say 10 to 15.
const MOST_PULLS: usize = 10;
const GRINDS_E: i64 = 500_000;

/// Writes relative-E G-code; rounding remainders of E are carried from move to move.
pub(super) struct Writer<'a> {
    text: Vec<u8>,
    settings: &'a SliceSettings,
    lines: &'a Lines,
    /// Those of the layer.
    line: &'a Line,
    filament_mm2: f64,
    /// The part fan's share of its full speed, in this layer and now.
    fan: [f64; 2],
    slow: bool,
    /// How much slower than usual a layer is printed, so that it takes its time.
    pace: f64,
    /// What it lacks even so, s.
    missing_s: f64,
    at: Option<Micrometres>,
    feed: i64,
    kind: Option<(Feature, i64)>,
    wanted_e: f64,
    written_e: i64,
    /// Where along the filament it was pulled back last.
    pulled: VecDeque<i64>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(settings: &'a SliceSettings, lines: &'a Lines) -> Self {
        Self {
            text: Vec::new(),
            settings,
            lines,
            line: lines.at(0),
            fan: [f64::NAN; 2],
            filament_mm2: PI / 4.0 * settings.filament_mm.powi(2),
            slow: false,
            pace: 1.0,
            missing_s: 0.0,
            at: None,
            feed: 0,
            kind: None,
            wanted_e: 0.0,
            written_e: 0,
            pulled: VecDeque::new(),
        }
    }

    /// A line of text as it is.
    pub(super) fn raw(&mut self, line: &str) {
        self.text.extend_from_slice(line.as_bytes());
        self.text.push(b'\n');
    }

    /// The part fan from this layer on, as a share of its full speed.
    pub(super) fn layer_fan(&mut self, share: f64) {
        self.fan[0] = share;
        self.turn_fan(share);
    }

    fn turn_fan(&mut self, share: f64) {
        if self.fan[1] != share {
            self.fan[1] = share;
            let speed = (share * 255.0).round() as i64;
            self.raw(&if speed == 0 { "M107".to_owned() } else { format!("M106 S{speed}") });
        }
    }

    /// The fan that a line wants: bridges have their own where it turns at all.
    fn fan_for(&self, feature: Feature) -> f64 {
        let layer = self.fan[0];
        let own = matches!(feature, Feature::Bridge | Feature::Overhang) && layer > 0.0;
        if own { layer.max(self.settings.bridge_fan) } else { layer }
    }

    /// The marks of a layer, and the move up; `slow` prints all of it at the first layer's speed.
    pub(super) fn layer(&mut self, index: usize, slow: bool) {
        let line = self.lines.at(index);
        self.layer_of(line, (index + 1) as f64 * line.height_mm, slow);
    }

    /// The same for a layer of its own lines whose top is at `z_mm`.
    pub(super) fn layer_of(&mut self, line: &'a Line, z_mm: f64, slow: bool) {
        self.line = line;
        let z = (z_mm * 1000.0).round() / 1000.0;
        self.slow = slow;
        self.pace = 1.0;
        self.missing_s = 0.0;
        self.kind = None;
        self.raw(&format!(";LAYER_CHANGE\n;Z:{z}\n;HEIGHT:{}", self.line.height_mm));
        self.text.extend_from_slice(b"G1 Z");
        push_units(&mut self.text, (z * 1000.0).round() as i64, 3);
        self.set_feed(self.settings.travel_mm_per_s);
        self.text.push(b'\n');
    }

    /// Prints the layer so slowly that it takes the least time, or as slowly as may be.
    pub(super) fn take_time(&mut self, paths: &[Path]) {
        let time = LayerTime::of(paths, self);
        let (least, slowest) = (self.settings.min_layer_s, self.settings.slowest_mm_per_s);
        if time.seconds(1.0, slowest) >= least {
            return;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            if time.seconds(middle, slowest) < least { high = middle } else { low = middle }
        }
        self.pace = low;
        self.missing_s = (least - time.seconds(low, slowest)).max(0.0);
    }

    /// Waits until the layer has taken the least time, where that is wanted: whoever puts the prints together says where.
    pub(super) fn wait(&mut self) {
        let milliseconds = (self.missing_s * 1000.0).round();
        if self.settings.wait_beside && milliseconds > 0.0 {
            self.raw(&format!("G4 P{milliseconds}"));
        }
    }

    /// Goes to the path and prints it.
    pub(super) fn path(&mut self, path: &Path) {
        let Some(&first) = path.points.first() else { return };
        self.travel(micrometres(first), path);
        self.turn_fan(self.fan_for(path.feature));
        self.mark(path);
        self.text.extend_from_slice(b"G1");
        self.set_feed(paced(self.speed(path.feature), self.pace, self.settings.slowest_mm_per_s));
        self.text.push(b'\n');
        let e_per_mm = self.line.area_of(self.width(path) as f64 / 1e3) / self.filament_mm2;
        let points: Vec<Micrometres> = path.points.iter().map(|&p| micrometres(p)).collect();
        if self.settings.arcs && matches!(path.feature, Feature::OuterWall | Feature::InnerWall) {
            return arcs::fitted(&points).into_iter().for_each(|piece| match piece {
                Piece::Line(to) => self.extrude(points[to], e_per_mm),
                Piece::Arc(arc) => self.arc(&arc, e_per_mm),
            });
        }
        for &point in &points[1..] {
            self.extrude(point, e_per_mm);
        }
    }

    /// The text, and the filament it uses in mm.
    pub(super) fn finish(self) -> (Vec<u8>, f64) {
        (self.text, self.written_e as f64 / 1e5)
    }

    fn mark(&mut self, path: &Path) {
        let kind = (path.feature, self.width(path));
        if self.kind.map(|k| k.0) != Some(kind.0) {
            self.raw(&format!(";TYPE:{}", name(path.feature)));
        }
        if self.kind.map(|k| k.1) != Some(kind.1) {
            self.raw(&format!(";WIDTH:{}", kind.1 as f64 / 1e3));
        }
        self.kind = Some(kind);
    }

    fn travel(&mut self, to: Micrometres, path: &Path) {
        if self.at == Some(to) {
            return;
        }
        let pull = path.pull && self.may_pull();
        if pull {
            self.pull(-self.settings.retract_mm);
        }
        for stop in path.way.iter().map(|&p| micrometres(p)).chain([to]) {
            self.text.extend_from_slice(b"G1");
            self.coordinates(stop);
            self.set_feed(self.settings.travel_mm_per_s);
            self.text.push(b'\n');
        }
        if pull {
            self.pull(self.settings.retract_mm);
        }
    }

    /// Whether the filament can be pulled back once more where it is: not as often that the gear grinds it.
    fn may_pull(&mut self) -> bool {
        if self.settings.retract_mm <= 0.0 {
            return false;
        }
        let since = self.written_e - GRINDS_E;
        while self.pulled.front().is_some_and(|&at| at < since) {
            self.pulled.pop_front();
        }
        let may = self.pulled.len() < MOST_PULLS;
        if may {
            self.pulled.push_back(self.written_e);
        }
        may
    }

    fn pull(&mut self, by_mm: f64) {
        self.text.extend_from_slice(b"G1 E");
        push_units(&mut self.text, (by_mm * 1e5).round() as i64, 5);
        self.set_feed(self.settings.retract_mm_per_s);
        self.text.push(b'\n');
    }

    fn extrude(&mut self, to: Micrometres, e_per_mm: f64) {
        let Some(at) = self.at.filter(|&at| at != to) else { return };
        let e = self.filament(distance_mm(at, to) * e_per_mm);
        self.text.extend_from_slice(b"G1");
        self.coordinates(to);
        self.text.extend_from_slice(b" E");
        push_units(&mut self.text, e, 5);
        self.text.push(b'\n');
    }

    /// G2 or G3 with the centre from its beginning; the filament is that of the arc's own length.
    fn arc(&mut self, arc: &Arc, e_per_mm: f64) {
        let e = self.filament(arc.length_mm * e_per_mm);
        self.text.extend_from_slice(if arc.clockwise { b"G2" } else { b"G3" });
        self.coordinates(arc.to);
        for (word, offset) in [b" I", b" J"].into_iter().zip(arc.centre) {
            self.text.extend_from_slice(word);
            push_units(&mut self.text, offset, 3);
        }
        self.text.extend_from_slice(b" E");
        push_units(&mut self.text, e, 5);
        self.text.push(b'\n');
    }

    /// What is pushed for so many millimetres more, in E's last digits; the remainder goes on to the next line.
    fn filament(&mut self, mm: f64) -> i64 {
        self.wanted_e += mm;
        let e = (self.wanted_e * 1e5).round() as i64 - self.written_e;
        self.written_e += e;
        e
    }

    fn coordinates(&mut self, to: Micrometres) {
        self.text.extend_from_slice(b" X");
        push_units(&mut self.text, to[0], 3);
        self.text.extend_from_slice(b" Y");
        push_units(&mut self.text, to[1], 3);
        self.at = Some(to);
    }

    fn set_feed(&mut self, mm_per_s: f64) {
        self.feed = (mm_per_s * 60.0).round() as i64;
        self.text.extend_from_slice(b" F");
        push_units(&mut self.text, self.feed, 0);
    }

    /// The path's width as it is stated, micrometres.
    fn width(&self, path: &Path) -> i64 {
        (path.width_mm.unwrap_or(self.line.width_mm) * 1e3).round() as i64
    }

    fn speed(&self, feature: Feature) -> f64 {
        let s = self.settings;
        let speed = match feature {
            Feature::OuterWall | Feature::Gap => s.outer_wall_mm_per_s,
            Feature::Overhang => s.overhang_mm_per_s,
            Feature::Bridge => s.bridge_mm_per_s,
            Feature::InnerWall => s.inner_wall_mm_per_s,
            Feature::Solid | Feature::Top | Feature::Sparse | Feature::Support | Feature::Adhesion => s.infill_mm_per_s,
        };
        if self.slow { s.first_layer_mm_per_s } else { speed }
    }
}

/// Halvings after which a pace is exact to the last digit of F.
const HALVINGS: usize = 24;

/// A speed in a layer that is printed at `pace` of the usual ones.
fn paced(speed: f64, pace: f64, slowest: f64) -> f64 {
    (speed * pace).max(slowest.min(speed))
}

/// What takes the time of a layer.
struct LayerTime {
    /// Speeds, mm/s, with the length printed at each, mm.
    printed: Vec<[f64; 2]>,
    travel_s: f64,
}

impl LayerTime {
    fn of(paths: &[Path], writer: &Writer<'_>) -> Self {
        let s = writer.settings;
        let mut time = Self { printed: Vec::new(), travel_s: 0.0 };
        let mut at = writer.at;
        for path in paths {
            let points: Vec<Micrometres> = path.points.iter().map(|&p| micrometres(p)).collect();
            let stops = path.way.iter().map(|&p| micrometres(p)).chain(points.first().copied());
            let mut way = 0.0;
            for stop in stops {
                way += at.map_or(0.0, |at| distance_mm(at, stop));
                at = Some(stop);
            }
            let pulls = if path.pull { 2.0 * s.retract_mm / s.retract_mm_per_s } else { 0.0 };
            time.travel_s += way / s.travel_mm_per_s + pulls;
            let length: f64 = points.windows(2).map(|leg| distance_mm(leg[0], leg[1])).sum();
            let speed = writer.speed(path.feature);
            match time.printed.iter_mut().find(|known| known[0] == speed) {
                Some(known) => known[1] += length,
                None => time.printed.push([speed, length]),
            }
            at = points.last().copied().or(at);
        }
        time
    }

    fn seconds(&self, pace: f64, slowest: f64) -> f64 {
        self.travel_s + self.printed.iter().map(|&[speed, length]| length / paced(speed, pace, slowest)).sum::<f64>()
    }
}

/// PrusaSlicer's names, which every viewer knows.
fn name(feature: Feature) -> &'static str {
    match feature {
        Feature::OuterWall => "External perimeter",
        Feature::InnerWall => "Perimeter",
        Feature::Overhang => "Overhang perimeter",
        Feature::Gap => "Gap fill",
        Feature::Bridge => "Bridge infill",
        Feature::Solid => "Solid infill",
        Feature::Top => "Top solid infill",
        Feature::Sparse => "Internal infill",
        Feature::Support => "Support material",
        Feature::Adhesion => "Skirt/Brim",
    }
}

fn micrometres(p: GridPoint) -> Micrometres {
    const UNITS: i64 = UNITS_PER_MM as i64 / 1000;
    [p.x, p.y].map(i64::from).map(|c| (c + c.signum() * (UNITS / 2)) / UNITS)
}
