//! What is shown of a print under way.

use std::sync::Arc;
use std::time::Duration;

use super::operator::Figures;
use super::rehearsal::through;
use crate::link::{BoundaryKind, Outcome, Program, Sender, Temperatures};
use crate::profile::Profile;

/// The rehearsal is looked at so often, simulated seconds.
const EVERY: Duration = Duration::from_secs(10);

/// The time that a program still takes once so many of its blocks are answered: by its rehearsal, with homing, heat and accelerations.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Timing {
    /// Blocks answered, and the seconds that are left then; both in order.
    marks: Vec<(u32, f64)>,
}

impl Timing {
    /// By the simulated printer; where that does not come to the end, by the moves alone, as `verify` states them.
    pub(super) fn of(program: &Arc<Program>, profile: &Profile) -> Self {
        let (mut marks, mut seen) = (vec![(0, Duration::ZERO)], (0, Duration::ZERO));
        let end = through(program, profile, EVERY, |link| {
            let acked = link.sender.progress().acked;
            if acked > seen.0 {
                // What stood in the way until then, heat perhaps, was one line's.
                marks.extend((acked > seen.0 + 1).then_some((seen.0 + 1, seen.1)));
                marks.push((acked, link.now()));
            }
            seen = (acked, link.now());
        });
        match end {
            Ok((link, Some(Outcome::Done))) => {
                let whole = link.now();
                marks.push((program.len(), whole));
                let left = |(block, at): &(u32, Duration)| (*block, whole.saturating_sub(*at).as_secs_f64());
                Self { marks: marks.iter().map(left).collect() }
            }
            _ => Self::of_moves(program),
        }
    }

    fn of_moves(program: &Program) -> Self {
        let mut left = program.seconds_print();
        let mut marks = vec![(0, left)];
        let at_speed: f64 = (0..program.len()).map(|block| program.seconds(block)).sum();
        let times = if at_speed > 0.0 { left / at_speed } else { 1.0 };
        for block in 0..program.len() {
            left -= program.seconds(block) * times;
            if block % 32 == 31 || block + 1 == program.len() {
                marks.push((block + 1, left.max(0.0)));
            }
        }
        Self { marks }
    }

    /// Behind the blocks before `acked`; between two marks in proportion.
    fn left(&self, acked: u32) -> f64 {
        let next = self.marks.partition_point(|(block, _)| *block <= acked);
        match (next.checked_sub(1).map(|i| self.marks[i]), self.marks.get(next)) {
            (Some((from, more)), Some((to, less))) => {
                more + (less - more) * f64::from(acked - from) / f64::from(to - from)
            }
            (Some((_, left)), None) => left,
            (None, _) => 0.0,
        }
    }

    /// What is shown of a print that `sender` has in hand.
    pub(super) fn figures(&self, sender: &Sender, heat: Temperatures) -> Figures {
        let (progress, program) = (sender.progress(), sender.program());
        let behind = program.boundaries.partition_point(|b| b.block < progress.acked.max(1));
        let (begun, all) = (&program.boundaries[..behind], &program.boundaries);
        let layers = |of: &[crate::link::Boundary]| of.iter().filter(|b| b.kind == BoundaryKind::Layer).count();
        let slots = |of: &[crate::link::Boundary]| {
            let slot = |b: &crate::link::Boundary| if let BoundaryKind::Slot(n) = b.kind { Some(n) } else { None };
            of.iter().filter_map(slot).collect::<Vec<u32>>()
        };
        let (left, whole) = (self.left(progress.acked), self.left(0));
        Figures {
            share: if whole > 0.0 { 1.0 - left / whole } else { 0.0 },
            layer: layers(begun),
            layers: layers(all),
            slot: slots(begun).last().copied(),
            slots: slots(all).into_iter().max().unwrap_or(0),
            seconds_left: left,
            nozzle_c: heat.nozzle,
            bed_c: heat.bed,
            waits_for: sender.waits_for(),
            resends: progress.resends,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{self, Silent, World, printer};

    const TEXT: &[u8] = b"G28\nG90\nG1 X0 Y0 F600\nG1 X100\nG4 S7\nG1 X50\n";

    #[test]
    fn the_moves_alone_begin_with_all_of_them_and_end_with_nothing() {
        let world = World::here(&Silent);
        let profile = job::load_profile(&"generic-ac".into(), &world).unwrap().profile;
        let program = Program::read(TEXT, &printer::rules(&profile).unwrap()).unwrap();
        let traced = crate::trace::read(TEXT, &profile.trace_setting()).seconds;
        let timing = Timing::of_moves(&program);
        // 10 s, 7 s, 5 s, and twice a hundredth of a second to be as fast as 10 mm/s.
        assert!((traced - 22.02).abs() < 1e-6 && (timing.left(0) - traced).abs() < 1e-6, "{timing:?}");
        assert!(timing.left(6).abs() < 1e-6 && (timing.left(3) - 11.01).abs() < 1e-6, "{timing:?}");
    }

    /// What is left at the start is what the rehearsal says of the whole.
    #[test]
    fn the_time_left_agrees_with_the_rehearsal() {
        let world = World::here(&Silent);
        let profile = job::load_profile(&"generic-ac".into(), &world).unwrap().profile;
        let moves: String = (0..3000).map(|i| format!("G1 X{} Y{}\n", i % 7 * 5, i % 11 * 3)).collect();
        let text = format!("G28\nM190 S60\nG90\nG1 X0 Y0 F6000\n{moves}");
        let program = Arc::new(Program::read(text.as_bytes(), &printer::rules(&profile).unwrap()).unwrap());
        let (link, end) = through(&program, &profile, Duration::from_secs(1_000_000), |_| {}).unwrap();
        assert_eq!(end, Some(Outcome::Done));
        let (timing, whole) = (Timing::of(&program, &profile), link.now().as_secs_f64());
        assert!((timing.left(0) - whole).abs() < 1e-6 * whole && whole > program.seconds_print() + 60.0, "{whole}");
        assert!(timing.left(program.len()) < 1e-6);
        // Half of the moves take about half of the time behind the heat.
        let (middle, start) = (timing.left(4 + 1500), timing.left(4));
        assert!((middle / start - 0.5).abs() < 0.03, "{middle} of {start}");
    }

    /// What is rehearsed and what is stated are slowed down alike by M204.
    #[test]
    fn a_rehearsal_accelerates_as_the_program_says() {
        let world = World::here(&Silent);
        let profile = job::load_profile(&"generic-ac".into(), &world).unwrap().profile;
        let moves: String = (0..600).map(|i| format!("G1 X{} Y{}\n", i % 7 * 5, i % 11 * 3)).collect();
        let times = |said: &str| {
            let text = format!("G28\nG90\nG1 X0 Y0 F6000\n{said}{moves}");
            let program = Arc::new(Program::read(text.as_bytes(), &printer::rules(&profile).unwrap()).unwrap());
            let (link, end) = through(&program, &profile, Duration::from_secs(1_000_000), |_| {}).unwrap();
            assert_eq!(end, Some(Outcome::Done));
            [link.now().as_secs_f64(), program.seconds_print()]
        };
        let [usual, slow] = [times(""), times("M204 S100\n")];
        let [rehearsed, stated] = [0, 1].map(|i| slow[i] - usual[i]);
        assert!(stated > 60.0 && (rehearsed / stated - 1.0).abs() < 0.03, "{rehearsed} s more, stated {stated} s");
    }
}
