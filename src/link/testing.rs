//! A small machine for the unit tests of this room: A from -15 to 90 degrees, C without end.

use super::program::ProgramRules;
use super::protocol::Protocol;
use super::retreat::{Heaters, Retreat};
use crate::geom::Angle;
use crate::motion::AxisRange;
use crate::motion::lookahead::AT_ONCE;
use crate::motion::replay::Reading;
use crate::trace::{FeedCount, Rates, TraceSetting};

pub(super) fn axes() -> [AxisRange; 2] {
    let axis = |letter, range: Option<(f64, f64)>| AxisRange {
        letter,
        direction: 1.0,
        zero: Angle::ZERO,
        range: range.map(|(low, high)| (Angle::from_deg(low), Angle::from_deg(high))),
        max_rate: 1.0,
        absent: false,
    };
    [axis(b'A', Some((-15.0, 90.0))), axis(b'C', None)]
}

pub(super) fn setting() -> TraceSetting {
    let [tilt, rotation] = axes();
    let axes = [('A', 20.0), ('C', 30.0)];
    let rates = Rates { feed: FeedCount::Linear, max_feed: 12_000.0, rapid_is_free: false, axes };
    TraceSetting {
        swivel: None,
        reading: Reading { rotary: Some((tilt, rotation)), ..Reading::sliced() },
        rates,
        accelerations: AT_ONCE,
    }
}

pub(super) fn retreat() -> Retreat {
    Retreat {
        axes: axes(),
        z_max_mm: 300.0,
        head: None,
        lift_mm: 20.0,
        retract_mm: 2.0,
        retract_feed: 2100.0,
        travel_feed: 6000.0,
        z_feed: 900.0,
        extruder: b'E',
        heaters: Heaters::Off,
        turning: Default::default(),
        home: vec!["G28".to_owned()],
    }
}

pub(super) fn rules(protocol: Protocol) -> ProgramRules {
    ProgramRules { protocol, longest_line: 96, setting: setting() }
}
