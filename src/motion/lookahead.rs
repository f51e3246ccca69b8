//! Motion as a firmware's planner makes it: a short queue, speeds looked ahead, trapezoids. The one for estimates and simulated printers.
//!
//! Junction speeds are those of Grbl's junction deviation (Sonny Jeon, *Improving Grbl's cornering algorithm*, 2011): a corner is
//! taken as an arc that deviates by `junction_mm`.
//!
//! Axes: X, Y, Z mm; tilt, rotation as the firmware's words, degrees; E mm. A block's length counts mm where the tip moves,
//! else degrees, else filament.

use std::collections::VecDeque;
use std::time::Duration;

/// Since the start.
type Time = Duration;

/// Positions of X, Y, Z, tilt, rotation, E.
pub type Axes = [f64; 6];

/// What a machine's axes can be accelerated by, and how it goes round corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accelerations {
    /// X, Y, Z, mm/s²; tilt, rotation, degrees/s²; E, mm/s².
    pub axes: Axes,
    /// Junction deviation, mm.
    pub junction_mm: f64,
}

/// Speeds that change at once, for tests that count at constant speed.
#[cfg(test)]
pub(crate) const AT_ONCE: Accelerations = Accelerations { axes: [1e12; 6], junction_mm: 1.0 };

/// Blocks that the planner holds (Marlin's `BLOCK_BUFFER_SIZE`, Grbl has 15 or 16).
pub(crate) const DEPTH: usize = 16;

#[derive(Clone, Debug)]
struct Block {
    from: Axes,
    to: Axes,
    length: f64,
    unit: [f64; 5],
    nominal: f64,
    acceleration: f64,
    max_entry: f64,
    /// The fastest entry from which what is queued behind can still stop.
    stoppable: f64,
    entry: f64,
    /// The speed that it reaches from there at its end.
    reached: f64,
}

impl Block {
    /// The speed at the other end where it is sped up, or slowed down, all along from `speed` at one.
    fn at_other_end(&self, speed: f64) -> f64 {
        (speed * speed + 2.0 * self.acceleration * self.length).sqrt()
    }
}

#[derive(Clone, Debug)]
struct Run {
    block: Block,
    exit: f64,
    start: Time,
    end: Time,
}

/// The queue and the block that runs.
#[derive(Clone, Debug)]
pub(crate) struct LookAhead {
    queue: VecDeque<Block>,
    run: Option<Run>,
    held: Option<Time>,
    at: Axes,
    end: Axes,
    accelerations: Accelerations,
    /// When it last ran dry, unless it was told to.
    dry_since: Option<Time>,
    /// How often a move came after the queue had run dry.
    pub(crate) starved: u32,
}

impl LookAhead {
    pub(crate) fn new(accelerations: Accelerations, at: Axes) -> Self {
        Self { queue: VecDeque::new(), run: None, held: None, at, end: at, accelerations, dry_since: None, starved: 0 }
    }

    pub(crate) fn is_full(&self) -> bool {
        self.queue.len() + usize::from(self.run.is_some()) >= DEPTH
    }

    pub(crate) fn is_idle(&self) -> bool {
        self.queue.is_empty() && self.run.is_none()
    }

    pub(crate) fn free(&self) -> usize {
        DEPTH - 1 - self.queue.len().min(DEPTH - 1)
    }

    /// Where the last queued move ends.
    pub(crate) fn end(&self) -> Axes {
        self.end
    }

    /// Sets the position without moving.
    pub(crate) fn place(&mut self, at: Axes) {
        (self.at, self.end) = (at, at);
    }

    /// A pause that was asked for is no starvation.
    pub(crate) fn expect_pause(&mut self) {
        self.dry_since = None;
    }

    /// Queues a move that takes at least `seconds` at constant speed. `tip` stands for what X and Y may be accelerated by, mm/s²,
    /// where the program has said so.
    pub(crate) fn push(&mut self, now: Time, to: Axes, seconds: f64, tip: Option<f64>) {
        let from = self.end;
        let moved: Axes = std::array::from_fn(|i| to[i] - from[i]);
        let norm = |range: std::ops::Range<usize>| range.map(|i| moved[i] * moved[i]).sum::<f64>().sqrt();
        let length = [norm(0..3), norm(3..5), moved[5].abs()].into_iter().find(|l| *l > 1e-9).unwrap_or(0.0);
        if length == 0.0 {
            return;
        }
        if self.is_idle() && self.dry_since.take().is_some() {
            self.starved += 1;
        }
        let of_axis = |i: usize| tip.filter(|_| i < 2).unwrap_or(self.accelerations.axes[i]);
        let limit = |i: usize| if moved[i] == 0.0 { f64::INFINITY } else { of_axis(i) * length / moved[i].abs() };
        let acceleration = (0..6).map(limit).fold(f64::INFINITY, f64::min);
        let nominal = length / seconds.max(1e-6);
        let whole = norm(0..5).max(1e-12);
        let unit = std::array::from_fn(|i| moved[i] / whole);
        let before = self.queue.back().or(self.run.as_ref().map(|r| &r.block));
        let deviation = self.accelerations.junction_mm;
        let max_entry = before.map_or(0.0, |b| junction(b, &unit, acceleration, deviation).min(nominal).min(b.nominal));
        let (stoppable, entry, reached) = (f64::NAN, f64::NAN, f64::NAN);
        let block = Block { from, to, length, unit, nominal, acceleration, max_entry, stoppable, entry, reached };
        self.queue.push_back(block);
        self.end = to;
        self.look_ahead();
        if self.run.is_none() && self.held.is_none() {
            self.start(now);
        }
    }

    /// Entry speeds: backward from a stop at the end, forward from what the running block ends with. What has not changed is not worked out
    /// again.
    fn look_ahead(&mut self) {
        let mut exit = 0.0_f64;
        for block in self.queue.iter_mut().rev() {
            let stoppable = block.max_entry.min(block.at_other_end(exit));
            if stoppable == block.stoppable {
                break;
            }
            (block.stoppable, exit) = (stoppable, stoppable);
        }
        let mut before = self.run.as_ref().map_or(0.0, |r| r.exit);
        for (index, block) in self.queue.iter_mut().enumerate() {
            let entry = if index == 0 { before } else { block.stoppable.min(before) };
            if entry != block.entry {
                (block.entry, block.reached) = (entry, block.at_other_end(entry));
            }
            before = block.reached;
        }
    }

    fn start(&mut self, at: Time) {
        let Some(block) = self.queue.pop_front() else { return };
        let exit = self.queue.front().map_or(0.0, |next| next.entry.min(block.at_other_end(block.entry)));
        let took = trapezoid(&block, exit).total();
        self.run = Some(Run { exit, start: at, end: at + Duration::from_secs_f64(took.min(1e6)), block });
    }

    /// Lets time pass; ends of moves go to `ended`.
    pub(crate) fn advance(&mut self, now: Time, mut ended: impl FnMut(Time, &Axes)) {
        if self.held.is_some() {
            return;
        }
        while let Some(run) = &self.run {
            if run.end > now {
                return;
            }
            let (end, to) = (run.end, run.block.to);
            self.at = to;
            ended(end, &to);
            self.run = None;
            self.start(end);
            if self.run.is_none() {
                self.dry_since = Some(end);
            }
        }
    }

    /// When the running block ends.
    pub(crate) fn wake(&self) -> Option<Time> {
        if self.held.is_some() { None } else { self.run.as_ref().map(|r| r.end) }
    }

    /// Where the axes are now.
    pub(crate) fn position(&self, now: Time) -> Axes {
        let Some(run) = &self.run else { return self.at };
        let now = self.held.unwrap_or(now);
        let share =
            trapezoid(&run.block, run.exit).distance(now.saturating_sub(run.start).as_secs_f64()) / run.block.length;
        let share = share.clamp(0.0, 1.0);
        std::array::from_fn(|i| run.block.from[i] + (run.block.to[i] - run.block.from[i]) * share)
    }

    /// Feed hold.
    pub(crate) fn hold(&mut self, now: Time) {
        self.held.get_or_insert(now);
    }

    pub(crate) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Goes on after a hold.
    pub(crate) fn release(&mut self, now: Time) {
        let Some(since) = self.held.take() else { return };
        let pause = now.saturating_sub(since);
        match &mut self.run {
            Some(run) => {
                run.start += pause;
                run.end += pause;
            }
            None => self.start(now),
        }
    }

    /// Drops everything where it stands.
    pub(crate) fn abort(&mut self, now: Time) {
        let at = self.position(now);
        self.queue.clear();
        self.run = None;
        self.held = None;
        self.dry_since = None;
        self.place(at);
    }
}

fn junction(before: &Block, unit: &[f64; 5], acceleration: f64, deviation: f64) -> f64 {
    let cos: f64 = -(0..5).map(|i| before.unit[i] * unit[i]).sum::<f64>();
    if cos > 0.999_999 {
        return 0.0;
    }
    if cos < -0.999_999 {
        return f64::INFINITY;
    }
    let sin_half = ((1.0 - cos) / 2.0).sqrt();
    (acceleration.min(before.acceleration) * deviation * sin_half / (1.0 - sin_half)).sqrt()
}

/// Speeds and times of one block.
struct Trapezoid {
    entry: f64,
    peak: f64,
    acceleration: f64,
    times: [f64; 3],
}

fn trapezoid(block: &Block, exit: f64) -> Trapezoid {
    let (a, entry) = (block.acceleration, block.entry);
    let top = ((2.0 * a * block.length + entry * entry + exit * exit) / 2.0).sqrt();
    let peak = block.nominal.max(entry).max(exit).min(top.max(entry).max(exit));
    let (up, down) = ((peak * peak - entry * entry) / (2.0 * a), (peak * peak - exit * exit) / (2.0 * a));
    let cruise = (block.length - up - down).max(0.0);
    let times = [(peak - entry) / a, if peak > 0.0 { cruise / peak } else { 0.0 }, (peak - exit) / a];
    Trapezoid { entry, peak, acceleration: a, times }
}

impl Trapezoid {
    fn total(&self) -> f64 {
        self.times.iter().sum()
    }

    fn distance(&self, t: f64) -> f64 {
        let [up, cruise, down] = self.times;
        let rise = t.min(up);
        let flat = (t - up).clamp(0.0, cruise);
        let fall = (t - up - cruise).clamp(0.0, down);
        self.entry * rise + 0.5 * self.acceleration * rise * rise + self.peak * flat + self.peak * fall
            - 0.5 * self.acceleration * fall * fall
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planner() -> LookAhead {
        let axes = [1000.0, 1000.0, 1000.0, 100.0, 100.0, 1000.0];
        LookAhead::new(Accelerations { axes, junction_mm: 0.02 }, [0.0; 6])
    }

    fn x(value: f64) -> Axes {
        [value, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    #[test]
    fn one_move_is_a_trapezoid_worked_by_hand() {
        // 100 mm at 50 mm/s with 1000 mm/s^2: 0.05 s up over 1.25 mm, 97.5 mm in 1.95 s, 0.05 s down.
        let mut p = planner();
        p.push(Time::ZERO, x(100.0), 2.0, None);
        assert!((p.wake().unwrap().as_secs_f64() - 2.05).abs() < 1e-9);
        assert!((p.position(Duration::from_millis(50))[0] - 1.25).abs() < 1e-9);
        assert!((p.position(Duration::from_millis(1050))[0] - 51.25).abs() < 1e-9);
        let mut ends = 0;
        p.advance(Duration::from_secs(3), |_, at| {
            ends += 1;
            assert_eq!(*at, x(100.0));
        });
        assert!(ends == 1 && p.is_idle());
    }

    #[test]
    fn a_straight_line_in_pieces_takes_hardly_longer_than_in_one() {
        let mut p = planner();
        p.push(Time::ZERO, x(10.0), 0.2, None);
        for i in 2..=10 {
            p.push(Time::ZERO, x(f64::from(i) * 10.0), 0.2, None);
        }
        let mut last = Time::ZERO;
        p.advance(Duration::from_secs(9), |t, _| last = t);
        assert!(last.as_secs_f64() < 2.16, "{last:?}"); // the first piece started before it saw the others
        let mut stops = planner();
        let mut t = Time::ZERO;
        for i in 1..=10 {
            stops.push(t, x(f64::from(i) * 10.0), 0.2, None);
            t += Duration::from_secs(1);
            stops.advance(t, |_, _| {});
        }
        assert_eq!(stops.starved, 9);
    }

    #[test]
    fn a_hold_stands_still_and_loses_nothing() {
        let mut p = planner();
        p.push(Time::ZERO, x(100.0), 2.0, None);
        p.hold(Duration::from_secs(1));
        let there = p.position(Duration::from_secs(50));
        assert_eq!(p.wake(), None);
        p.release(Duration::from_secs(60));
        assert!((p.position(Duration::from_secs(60))[0] - there[0]).abs() < 1e-9);
        assert!((p.wake().unwrap().as_secs_f64() - 61.05).abs() < 1e-9);
    }

    /// All entry speeds anew, as they are defined.
    fn worked_out(p: &LookAhead) -> Vec<f64> {
        let mut exit = 0.0;
        let mut speeds: Vec<f64> = p
            .queue
            .iter()
            .rev()
            .map(|block| {
                exit = block.max_entry.min(block.at_other_end(exit));
                exit
            })
            .collect();
        speeds.reverse();
        let mut before = p.run.as_ref().map_or(0.0, |run| run.exit);
        for (index, (speed, block)) in speeds.iter_mut().zip(&p.queue).enumerate() {
            *speed = if index == 0 { before } else { speed.min(before) };
            before = block.at_other_end(*speed);
        }
        speeds
    }

    #[test]
    fn speeds_that_are_kept_are_those_that_would_be_worked_out_again() {
        let mut random = crate::geom::SplitMix64::seeded(3);
        let (mut p, mut now, mut at) = (planner(), Time::ZERO, [0.0; 6]);
        for round in 0..4000 {
            let far = [0.05, 0.5, 20.0][random.below(3)];
            (0..3).for_each(|i| at[i] += (random.unit() - 0.5) * far);
            at[5] += random.unit();
            while p.is_full() {
                now = p.wake().unwrap();
                p.advance(now, |_, _| {});
            }
            // A move that comes to an idle machine begins at once, and leaves the queue.
            let begins = p.is_idle();
            p.push(now, at, far / (1.0 + 200.0 * random.unit()), None);
            let kept: Vec<f64> = p.queue.iter().map(|block| block.entry).collect();
            if !begins {
                assert_eq!(kept, worked_out(&p), "round {round}");
            }
            if random.below(40) == 0 {
                now += Duration::from_millis(random.below(3000) as u64);
                p.advance(now, |_, _| {});
            }
        }
    }
}
