//! Where a printer can have stopped, and which of these places it says it is at.
//!
//! A printer that was not reset knows where it is. What it says is compared with the end of every block that can have been its last;
//! one that fits settles which blocks were executed, without homing and without a counter.
//!
//! Units: mm and degrees, as the words of the axes; E is the extruder's count, mm.

use std::ops::RangeInclusive;

use super::journal::JournalSummary;
use super::program::Program;
use super::retreat::Retreat;
use super::settings::SenderSettings;
use super::state::MachineState;
use crate::motion::replay::ReplayError;
use crate::trace::Action;

/// Lines among which the one is looked for that a machine without proofs has executed last: more than it is sent between two words
/// in its journal.
const UNTOLD: u32 = 2000;

/// Printers state two or three decimals.
const SAME_MM: f64 = 0.011;

/// A place at which a printer can stand.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The first block that is not executed there.
    pub block: u32,
    /// The words of the axes, and E.
    pub words: Vec<(u8, f64)>,
    /// Whether filament is moved on the way here from the place before: pushed, or pulled back.
    pub feeds: bool,
}

/// Where the machine is before each of `blocks`.
fn places(program: &Program, retreat: &Retreat, blocks: RangeInclusive<u32>) -> Result<Vec<Place>, ReplayError> {
    let mut replay = program.replay();
    let (mut found, mut feeds) = (Vec::new(), false);
    loop {
        let block = replay.at();
        if blocks.contains(&block) {
            let controller = replay.machine().controller();
            let mut words = retreat.words_at(&controller.at);
            words.push((b'E', controller.extruder_count()));
            found.push(Place { block, words, feeds: std::mem::take(&mut feeds) });
        }
        if block >= *blocks.end() {
            return Ok(found);
        }
        let Some((_, _, action)) = replay.step() else { return Ok(found) };
        if let Action::Move(timed) = action? {
            feeds |= timed.made.e != 0.0;
        }
    }
}

impl JournalSummary {
    /// Where the printer stands if it was not reset; `None` where that is not known, as on the way off the part.
    pub fn stands_at(&self, program: &Program, settings: &SenderSettings, same_boot: bool) -> Option<Vec<Place>> {
        if let Some(block) = self.paused {
            let state = MachineState::before(program, block).ok()?;
            return Some(vec![Place::above(&state, &settings.retreat, block)]);
        }
        if self.away {
            return None;
        }
        // What was answered it has executed by now.
        let first = self.answered.min(program.len());
        let last = if self.has_end(settings) { self.unsent(program, settings, same_boot) } else { first + UNTOLD };
        places(program, &settings.retreat, first..=last.max(first).min(program.len())).ok()
    }
}

impl Place {
    /// The place of a pause that was reached before `block`: above the part.
    pub fn above(state: &MachineState, retreat: &Retreat, block: u32) -> Self {
        let mut words = retreat.words(state);
        for (letter, value) in
            retreat.lifted(&state.at).into_iter().flat_map(|lifted| [b'X', b'Y', b'Z'].into_iter().zip(lifted))
        {
            let stated = words.iter_mut().find(|(known, _)| *known == letter);
            if let (Some((_, word)), Some(value)) = (stated, value) {
                *word = value;
            }
        }
        Self { block, words, feeds: false }
    }

    fn fits(&self, said: &[(u8, f64)], with_extruder: bool) -> bool {
        let stated = |letter: u8| said.iter().find(|(l, _)| *l == letter).map(|(_, value)| *value);
        let tip = [b'X', b'Y', b'Z'];
        tip.iter().all(|l| stated(*l).is_some() && self.words.iter().any(|(letter, _)| letter == l))
            && self.words.iter().filter(|(letter, _)| *letter != b'E' || with_extruder).all(|(letter, value)| {
                // What a printer does not say of the table it cannot contradict.
                stated(*letter).map_or(*letter != b'E', |said| (said - value).abs() < SAME_MM)
            })
    }

    /// The first block that is not executed by a printer that says it is at `said`; `None` where none fits, or several that have
    /// filament moved between them, which would be moved once more.
    pub fn fitting(places: &[Self], said: &[(u8, f64)]) -> Option<u32> {
        [false, true].into_iter().find_map(|with_extruder| {
            let fits: Vec<usize> = (0..places.len()).filter(|&i| places[i].fits(said, with_extruder)).collect();
            let (first, last) = (*fits.first()?, *fits.last()?);
            let same = !places[first + 1..=last].iter().any(|place| place.feeds);
            same.then(|| places[first].block)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::Protocol;
    use crate::link::testing::{retreat, rules};

    const PART: &str = "G28\nG90\nM83\nG1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z1 F600\nG1 X10 E1\nG1 Y10 E1\nM106 S255\nG1 X0 E1\nG1 Y0 E1\nG1 X5 Y5 E.5\n";

    fn found(said: &[(u8, f64)]) -> Option<u32> {
        let program = Program::read(PART.as_bytes(), &rules(Protocol::Klipper)).unwrap();
        Place::fitting(&places(&program, &retreat(), 6..=12).unwrap(), said)
    }

    fn at(x: f64, y: f64) -> Vec<(u8, f64)> {
        vec![(b'X', x), (b'Y', y), (b'Z', 1.0)]
    }

    #[test]
    fn the_place_that_a_printer_is_at_says_what_it_has_executed() {
        assert_eq!(found(&at(10.0, 0.0)), Some(7));
        // The fan between is set once more.
        assert_eq!(found(&at(10.004, 9.996)), Some(8));
        assert_eq!(found(&at(5.0, 5.0)), Some(12));
        assert_eq!(found(&at(5.0, 5.02)), None);
        assert_eq!(found(&[(b'X', 10.0), (b'Y', 0.0)]), None, "a place needs three words");
    }

    #[test]
    fn a_closed_line_has_one_place_and_two_states_which_only_the_extruder_tells() {
        assert_eq!(found(&at(0.0, 0.0)), None);
        let with = |e: f64| [at(0.0, 0.0), vec![(b'E', e)]].concat();
        assert_eq!([with(0.0), with(4.0), with(2.0)].map(|said| found(&said)), [Some(6), Some(11), None]);
    }

    /// A line that is pulled back or primed where the head stands is not carried out a second time.
    #[test]
    fn filament_that_is_moved_on_the_spot_is_told_by_the_extruder_alone() {
        let text =
            "G28\nG90\nM83\nG1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z1 F600\nG1 X10 E1\nG1 E-2\nM106 S9\nG1 E2\nG1 X0 E1\n";
        let program = Program::read(text.as_bytes(), &rules(Protocol::Klipper)).unwrap();
        let found = |blocks, e: Option<f64>| {
            let said = [at(10.0, 0.0), e.map(|e| (b'E', e)).into_iter().collect()].concat();
            Place::fitting(&places(&program, &retreat(), blocks).unwrap(), &said)
        };
        // Before the pull or behind it, and behind the prime as well.
        assert_eq!([found(7..=8, None), found(7..=10, None), found(8..=9, None)], [None, None, Some(8)]);
        assert_eq!([found(7..=9, Some(1.0)), found(7..=9, Some(-1.0))], [Some(7), Some(8)]);
        // The count alone does not tell the two sides of pull and prime.
        assert_eq!(found(7..=10, Some(1.0)), None);
    }

    #[test]
    fn a_printer_says_two_or_three_decimals_and_may_be_one_of_them_off() {
        let near = |d: f64| found(&[(b'X', 10.0 + d), (b'Y', 0.0), (b'Z', 1.0)]);
        assert_eq!([near(0.0105), near(-0.0105), near(0.0115), near(-0.0115)], [Some(7), Some(7), None, None]);
    }

    #[test]
    fn without_an_end_so_many_lines_are_looked_at_and_no_more() {
        let moves: String = (1..=2200).map(|i| format!("G1 X{}\n", f64::from(i) * 0.1)).collect();
        let text = format!("G28\nG90\nG1 A0 F600\nG1 C0 F600\nG1 X0 Y0 Z1 F600\n{moves}");
        let program = Program::read(text.as_bytes(), &rules(Protocol::Grbl)).unwrap();
        let journal = crate::link::Header::default().to_text() + "run 1 0\nack 9 9\n";
        let standing = JournalSummary::parse(&journal).unwrap();
        let settings = SenderSettings::new(Protocol::Grbl, retreat());
        let places = standing.stands_at(&program, &settings, true).unwrap();
        assert_eq!((places[0].block, places[places.len() - 1].block), (9, 9 + UNTOLD));
    }

    #[test]
    fn the_tables_axes_count_where_they_are_said() {
        let turned = |a: f64| found(&[at(10.0, 0.0), vec![(b'A', a), (b'C', 0.0)]].concat());
        assert_eq!([turned(0.0), turned(45.0)], [Some(7), None]);
    }
}
