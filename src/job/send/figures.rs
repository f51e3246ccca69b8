//! What is shown of a print under way.

use super::operator::Figures;
use crate::link::{Boundary, BoundaryKind, Program, Sender, Temperatures};

/// The time that a program still takes, kept up to date as blocks are answered.
pub(super) struct TimeLeft {
    seconds: f64,
    block: u32,
}

impl TimeLeft {
    pub(super) fn of(program: &Program) -> Self {
        Self { seconds: program.seconds_print(), block: 0 }
    }

    /// Behind the blocks before `acked`, which never steps back.
    fn behind(&mut self, program: &Program, acked: u32) -> f64 {
        self.seconds -= (self.block..acked).map(|block| program.seconds(block)).sum::<f64>();
        self.block = self.block.max(acked);
        self.seconds.max(0.0)
    }

    /// What is shown of a print that `sender` has in hand.
    pub(super) fn figures(&mut self, sender: &Sender, heat: Temperatures) -> Figures {
        let (progress, program) = (sender.progress(), sender.program());
        let behind = program.boundaries.partition_point(|b| b.block < progress.acked.max(1));
        let begun = &program.boundaries[..behind];
        let slot = |b: &Boundary| if let BoundaryKind::Slot(n) = b.kind { Some(n) } else { None };
        let celsius = |t: Option<[f64; 2]>| t.map(|[now, _]| now);
        Figures {
            layer: begun.iter().filter(|b| b.kind == BoundaryKind::Layer).count(),
            slot: begun.iter().rev().find_map(slot),
            seconds_left: self.behind(program, progress.acked),
            nozzle_c: celsius(heat.nozzle),
            bed_c: celsius(heat.bed),
            resends: progress.resends,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{self, Silent, World, printer};

    #[test]
    fn the_time_that_is_left_begins_with_all_of_it_and_ends_with_nothing() {
        let world = World::here(&Silent);
        let profile = job::load_profile(&"generic-ac".into(), &world).unwrap().profile;
        let rules = printer::rules(&profile).unwrap();
        let text = b"G28\nG90\nG1 X0 Y0 F600\nG1 X100\nG4 S7\nG1 X50\n";
        let program = Program::read(text, &rules).unwrap();
        let traced = crate::trace::read(text, &profile.trace_setting()).seconds();
        let mut left = TimeLeft::of(&program);
        let seconds: Vec<f64> = [0, 0, 4, 5, 6].map(|acked| left.behind(&program, acked)).into();
        let by_hand = [22.0, 22.0, 12.0, 5.0, 0.0];
        assert!(seconds.iter().zip(by_hand).all(|(s, h)| (s - h).abs() < 1e-6), "{seconds:?}");
        assert!((traced - 22.0).abs() < 1e-6, "{traced}");
    }
}
