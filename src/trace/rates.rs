//! How long a move takes, and whether an axis must go faster than it can.

/// What F is a speed of when several kinds of axis move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedCount {
    /// mm of the tip where it moves, else degrees.
    #[default]
    Linear,
    /// The Euclidean length over mm and degrees.
    AllAxes,
    /// mm of the tip where it moves, else the largest angle.
    LargestAxis,
}

/// The machine's speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates {
    /// What F counts.
    pub feed: FeedCount,
    /// Of the tip, mm/min.
    pub max_feed: f64,
    /// Whether G0 goes at the axes' own rates, whatever F says.
    pub rapid_is_free: bool,
    /// Tilt and rotation: the word's letter, deg/s.
    pub axes: [(char, f64); 2],
}

/// An axis that would have to go too fast.
#[derive(Clone, Debug, PartialEq)]
pub struct TooFast {
    /// What it would have to do.
    pub measured: f64,
    /// What it can.
    pub allowed: f64,
    /// One sentence.
    pub text: String,
}

/// How far a move goes.
#[derive(Clone, Copy, Debug)]
pub(super) struct RateExtent {
    /// Of the tip, mm, as far as is known.
    pub(super) length: f64,
    /// Whether the tip moves at all.
    pub(super) linear: bool,
    /// Of tilt and rotation, degrees; `None` where the start is unknown.
    pub(super) turns: [Option<f64>; 2],
    /// Filament, mm.
    pub(super) e: f64,
}

/// F, and how it counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Feed {
    pub(super) value: Option<f64>,
    pub(super) inverse_time: bool,
    pub(super) rapid: bool,
    /// Whether a rotary word is written.
    pub(super) rotary: bool,
}

/// What the rounding of F to whole numbers may add to a speed, relative.
const RATE_SLACK: f64 = 1e-3;

impl Rates {
    /// Seconds that the move takes, and what is too fast in it.
    pub(super) fn check(&self, feed: &Feed, extent: &RateExtent) -> (f64, Option<TooFast>) {
        let fastest = self.fastest(extent);
        if feed.rapid && self.rapid_is_free {
            return (fastest, None);
        }
        let turning = feed.rotary && extent.turns != [Some(0.0); 2];
        let Some(value) = feed.value.filter(|&f| f > 0.0) else {
            let text = "the table turns, but no F sets its speed".to_owned();
            return (fastest, turning.then_some(TooFast { measured: 0.0, allowed: 0.0, text }));
        };
        let seconds = if feed.inverse_time { 60.0 / value } else { 60.0 * self.counted(extent) / value };
        let shared = feed.inverse_time || self.feed == FeedCount::AllAxes;
        let fast = self.linear(value, shared, extent, seconds).or_else(|| self.rotary(value, extent, seconds));
        (seconds.max(fastest), fast)
    }

    /// What F is a speed of, for this move.
    fn counted(&self, extent: &RateExtent) -> f64 {
        let [tilt, rotation] = extent.turns.map(|t| t.unwrap_or(0.0));
        if tilt == 0.0 && rotation == 0.0 && extent.length > 0.0 {
            return extent.length;
        }
        let (length, turned) = (extent.length, tilt.hypot(rotation));
        let all = match self.feed {
            FeedCount::AllAxes => length.hypot(turned),
            FeedCount::LargestAxis if length == 0.0 => tilt.max(rotation),
            _ if length == 0.0 => turned,
            _ => length,
        };
        if all == 0.0 { extent.e.abs() } else { all }
    }

    fn linear(&self, value: f64, shared: bool, extent: &RateExtent, seconds: f64) -> Option<TooFast> {
        if !extent.linear {
            return None;
        }
        // From an unknown place the tip may take the whole of F.
        let speed = if shared && extent.length > 0.0 { extent.length / seconds * 60.0 } else { value };
        let allowed = self.max_feed;
        let text = || format!("F asks for {speed:.0} mm/min; this machine allows {allowed:.0}");
        (speed > allowed * (1.0 + RATE_SLACK)).then(|| TooFast { measured: speed, allowed, text: text() })
    }

    fn rotary(&self, value: f64, extent: &RateExtent, seconds: f64) -> Option<TooFast> {
        (0..2).filter(|&i| extent.turns[i] != Some(0.0)).find_map(|i| {
            let (letter, allowed) = self.axes[i];
            // From an unknown angle the axis may take the whole of F.
            let speed = extent.turns[i].map_or(value / 60.0, |turned| turned / seconds);
            let text = || format!("{letter} would turn at {speed:.1} deg/s; this axis allows {allowed:.1}");
            (speed > allowed * (1.0 + RATE_SLACK)).then(|| TooFast { measured: speed, allowed, text: text() })
        })
    }

    /// Seconds at the axes' fastest.
    fn fastest(&self, extent: &RateExtent) -> f64 {
        let turning = (0..2).map(|i| extent.turns[i].unwrap_or(0.0) / self.axes[i].1);
        turning.fold(extent.length / self.max_feed * 60.0, f64::max)
    }
}
