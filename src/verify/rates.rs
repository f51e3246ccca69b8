//! How long a move takes, and whether an axis must go faster than it can.

use crate::motion::replay::Move;
use crate::motion::{AxisRange, TableKinematics};
use crate::profile::{Commands, FeedReference, Profile};

/// What the rounding of F to whole numbers may add to a speed, relative.
const RATE_SLACK: f64 = 1e-3;

/// The machine's speeds.
pub(super) struct Rates {
    feed: FeedReference,
    max_feed: f64,
    /// G0 goes at the axes' own rates, whatever F says.
    rapid_is_free: bool,
    axes: [(char, f64); 2],
}

/// An axis that would have to go too fast.
pub(super) struct TooFast {
    pub(super) measured: f64,
    pub(super) allowed: f64,
    pub(super) text: String,
}

/// How far a move goes.
pub(super) struct Extent {
    /// Of the tip, mm.
    pub(super) length: f64,
    /// Of tilt and rotation, degrees; `None` where the start is unknown.
    pub(super) turns: [Option<f64>; 2],
}

impl Rates {
    pub(super) fn new(profile: &Profile, table: &TableKinematics) -> Self {
        let axis = |a: &AxisRange| (char::from(a.letter), a.max_rate.to_degrees());
        Self {
            feed: profile.dialect.feed,
            max_feed: profile.limits.max_feed_mm_per_min,
            rapid_is_free: profile.dialect.commands == Commands::Rs274,
            axes: [axis(&table.tilt), axis(&table.rotation)],
        }
    }

    /// Seconds that F asks for, `None` without F; and what is too fast.
    ///
    /// F counts what the dialect says: mm of the tip where it moves, degrees or their norm where only the table does.
    pub(super) fn check(&self, m: &Move, extent: &Extent) -> (f64, Option<TooFast>) {
        let fastest = self.fastest(extent);
        if m.rapid && self.rapid_is_free {
            return (fastest, None);
        }
        let rotary = m.rotary_written && extent.turns != [Some(0.0); 2];
        let Some(feed) = m.feed.filter(|&f| f > 0.0) else {
            let text = "the table turns at a speed that no F has set".to_owned();
            return (fastest, rotary.then_some(TooFast { measured: 0.0, allowed: 0.0, text }));
        };
        let seconds = 60.0 * self.counted(m, extent) / feed;
        let seconds = if m.inverse_time { 60.0 / feed } else { seconds };
        let fast = self.linear(m, feed, extent, seconds).or_else(|| self.rotary(m, feed, extent, seconds));
        (seconds.max(fastest), fast)
    }

    /// What F is a speed of, for this move.
    fn counted(&self, m: &Move, extent: &Extent) -> f64 {
        let [tilt, rotation] = extent.turns.map(|t| t.unwrap_or(0.0));
        let (length, turned) = (extent.length, tilt.hypot(rotation));
        let all = match self.feed {
            FeedReference::AllAxes => length.hypot(turned),
            FeedReference::LargestAxis if length == 0.0 => tilt.max(rotation),
            _ if length == 0.0 => turned,
            _ => length,
        };
        if all == 0.0 { m.e.abs() } else { all }
    }

    fn linear(&self, m: &Move, feed: f64, extent: &Extent, seconds: f64) -> Option<TooFast> {
        // From an unknown place the tip may take the whole of F.
        let unknown = extent.length == 0.0 && m.from.linear != m.to.linear;
        if extent.length == 0.0 && !unknown {
            return None;
        }
        let shared = m.inverse_time || self.feed == FeedReference::AllAxes;
        let speed = if shared && !unknown { extent.length / seconds * 60.0 } else { feed };
        let text = || format!("F asks for {speed:.0} mm/min; this machine goes up to {:.0}", self.max_feed);
        let allowed = self.max_feed;
        (speed > allowed * (1.0 + RATE_SLACK)).then(|| TooFast { measured: speed, allowed, text: text() })
    }

    fn rotary(&self, m: &Move, feed: f64, extent: &Extent, seconds: f64) -> Option<TooFast> {
        let written = [m.from.tilt != m.to.tilt, m.from.rotation != m.to.rotation];
        (0..2).filter(|&i| written[i]).find_map(|i| {
            let (letter, allowed) = self.axes[i];
            // From an unknown angle the axis may take the whole of F.
            let speed = match extent.turns[i] {
                Some(turned) => turned / seconds,
                None => feed / 60.0,
            };
            let text = || format!("{letter} would turn at {speed:.1} deg/s; this axis turns at up to {allowed:.1}");
            (speed > allowed * (1.0 + RATE_SLACK)).then(|| TooFast { measured: speed, allowed, text: text() })
        })
    }

    /// Seconds at the axes' fastest.
    fn fastest(&self, extent: &Extent) -> f64 {
        let turning = (0..2).map(|i| extent.turns[i].unwrap_or(0.0) / self.axes[i].1);
        turning.fold(extent.length / self.max_feed * 60.0, f64::max)
    }
}
