//! The way that nearly all lines of sliced input go: a straight move between known places, counted absolutely.

use super::{Controller, is_sane_feed};
use crate::gcode::PlainMove;
use crate::geom::Vec3;

/// What any coordinate may be, of either sign; between this and what the general way takes only that can tell.
const SANE_EITHER_WAY_MM: f64 = 1e6;

/// What a plain line did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlainStep {
    /// A straight move whose ends are known.
    Move(PlainMoved),
    /// F alone: nothing moves.
    Feed,
}

/// A straight move whose ends are known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlainMoved {
    /// The tip before, mm.
    pub from: Vec3,
    /// The tip after, mm.
    pub to: Vec3,
    /// Filament pushed (negative: pulled), mm as the file counts.
    pub e: f64,
    /// F as written, as in [`Move::feed`](super::Move::feed).
    pub feed: Option<f64>,
}

impl Controller {
    /// Carries out `line` as [`Controller::step`] does.
    ///
    /// `None`, and nothing has changed, where that has more to say than a move between known places: G91, an unknown
    /// position, an extruder of another letter, a number beyond any machine.
    #[inline]
    pub fn step_plain(&mut self, line: &PlainMove) -> Option<PlainStep> {
        let [Some(x), Some(y), Some(z)] = self.at.linear else { return None };
        // F is only said, not gone to; what is not written is 0.
        let sane = line.values[..4].iter().fold(0.0, |most: f64, value| most.max(value.abs())) <= SANE_EITHER_WAY_MM;
        if !(sane && is_sane_feed(line.values[4]) && self.absolute && self.reading.extruder == b'E') {
            return None;
        }
        if line.written & PlainMove::F != 0 {
            self.feed = Some(line.values[4]);
        }
        self.motion = Some(u32::from(!line.rapid));
        if line.written == PlainMove::F {
            return Some(PlainStep::Feed);
        }
        let from = Vec3::new(x, y, z);
        let pick = |axis: usize| if line.written & 1 << axis == 0 { from[axis] } else { line.values[axis] };
        let to = Vec3::new(pick(0), pick(1), pick(2));
        let e = if line.written & PlainMove::E == 0 { 0.0 } else { self.extrude(line.values[3]) };
        self.at.linear = [Some(to.x), Some(to.y), Some(to.z)];
        Some(PlainStep::Move(PlainMoved { from, to, e, feed: self.feed }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gcode::ParsedLine;
    use crate::geom::SplitMix64;
    use crate::motion::replay::{Reading, Step};

    const START: [&str; 5] = ["G1 X1 Y2 Z.2 F1200", "M83", "G92 E3", "G90", "G1 X5 E1"];
    const THEN: [&str; 20] = [
        "G1 X5 Y6 E.04211",
        "G0 X1",
        "G1 Z.4 F600",
        "G1 E-2",
        "G1 F900",
        "M82",
        "M83",
        "G91",
        "G90",
        "G28",
        "G1 X1 Y2 Z3",
        "G92 E0",
        "G1 X99999999",
        "G1 X1 A3",
        "G1 X-3 E-.5",
        "G0 F100 X7 Y8",
        "G1 Y1e5",
        "G1 X2 F99999999999",
        "G1 F.0000001",
        "G1 X3 F-600",
    ];

    #[test]
    fn a_plain_move_is_carried_out_as_any_other() {
        let (mut fast, mut taken, mut line) = (Controller::new(Reading::sliced()), 0, ParsedLine::default());
        let mut whole = fast.clone();
        let mut numbers = SplitMix64::seeded(3);
        let mut any = || THEN[numbers.below(THEN.len())];
        for text in START.into_iter().chain((0..20_000).map(|_| any())) {
            line.read(text.as_bytes()).unwrap();
            let before = format!("{fast:?}");
            let plain = PlainMove::read(text.as_bytes()).and_then(|plain| fast.step_plain(&plain));
            let wanted = whole.step(&line);
            taken += u32::from(plain.is_some());
            match (plain, wanted) {
                (Some(PlainStep::Move(step)), Ok(Step::Move(m))) => {
                    let ends = (m.from.tip().unwrap(), m.to.tip().unwrap());
                    assert_eq!((step.from, step.to, step.e, step.feed), (ends.0, ends.1, m.e, m.feed), "{text}");
                }
                (Some(PlainStep::Feed), Ok(Step::Nothing)) => {}
                (None, _) => {
                    assert_eq!(format!("{fast:?}"), before, "{text} left something behind");
                    let _ = fast.step(&line);
                }
                other => panic!("{text}: {other:?}"),
            }
            assert_eq!(format!("{fast:?}"), format!("{whole:?}"), "{text}");
        }
        assert!(taken > 2000, "{taken}");
    }
}
