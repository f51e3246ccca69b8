//! What is counted along the way: filament per print, retractions, the order of the prints.

use super::Planned;
use super::report::{FindingPlace, Findings, Rule};

/// Pulled filament that may still be missing, or pushed that may be over, when printing starts, mm: the restart
/// allowances that slicers add on purpose.
pub(super) const RETRACT_SLACK_MM: f64 = 0.3;
/// What all such allowances of a program may add up to, as a part of its filament, and mm that are too few to tell.
pub(super) const MOST_STRAYED: f64 = 0.03;
const FEW_MM: f64 = 3.0;
/// What the sums may differ by, mm: the last digits of both, since the writer carries the remainder of its roundings on
/// from move to move. The shortest line a slicer writes takes about as much, so a line lost or doubled is seen.
pub(super) const FILAMENT_SLACK_MM: f64 = 1e-3;
/// And as a part of the print's filament: of hundreds of metres the numbers of moves have too few digits for sums to the micron.
pub(super) const FILAMENT_SLACK_SHARE: f64 = 1e-7;

/// The part of the profile's retraction that must be there while the table turns.
pub(super) const LEAST_PULLED: f64 = 0.5;

#[derive(Clone, Default)]
struct Laid {
    expected: Option<f64>,
    filament: f64,
    moves: usize,
    last: u32,
}

/// The counts of one program.
pub(super) struct Tally {
    prints: Vec<Laid>,
    /// Filament pushed while not printing, less what was pulled, since printing last went on, mm.
    balance: f64,
    firmware_pulled: bool,
    /// What is pushed beyond what was pulled where a print goes on behind a turn, mm; and whether the table has turned since.
    prime: f64,
    turned: bool,
    /// What was missing where printing went on, and what was too much, mm in all.
    strayed: [f64; 2],
    /// Whether filament moved since printing last went on.
    disturbed: bool,
    /// The print that last laid filament.
    printing: Option<usize>,
    /// All filament laid down.
    pub(super) filament: f64,
    started: bool,
}

impl Tally {
    /// Of that many prints, on a machine that pushes `prime` mm behind a turn.
    pub(super) fn new(prints: usize, prime: f64) -> Self {
        Self {
            prints: vec![Laid::default(); prints],
            balance: 0.0,
            firmware_pulled: false,
            prime,
            turned: false,
            strayed: [0.0; 2],
            disturbed: false,
            printing: None,
            filament: 0.0,
            started: false,
        }
    }

    /// Whether anything has been printed.
    pub(super) fn started(&self) -> bool {
        self.started
    }

    /// What the header says of a print; `false` where it says it twice.
    pub(super) fn expect(&mut self, print: usize, filament: f64) -> bool {
        self.prints[print].expected.replace(filament).is_none()
    }

    /// Filament moved without printing.
    pub(super) fn pull(&mut self, e: f64) {
        self.balance += e;
        self.disturbed = true;
    }

    /// G10 (`pull`) or G11.
    pub(super) fn firmware(&mut self, pull: bool, at: FindingPlace, findings: &mut Findings) {
        if self.firmware_pulled == pull {
            let text = if pull { "a second G10 without a G11 between" } else { "G11 without a G10 before it" };
            findings.add(Rule::Retract, at, [1.0, 0.0], || text.to_owned());
        }
        self.firmware_pulled = pull;
        self.disturbed = true;
    }

    /// Whether as much is pulled back as a turn wants, of `usual` mm.
    pub(super) fn is_pulled(&self, usual: f64) -> bool {
        self.firmware_pulled || -self.balance >= usual * LEAST_PULLED
    }

    /// The table turns: what hangs in the nozzle must have been pulled back, `usual` mm as the profile has it.
    pub(super) fn turn(&mut self, usual: f64, at: FindingPlace, findings: &mut Findings) {
        self.turned = true;
        let least = usual * LEAST_PULLED;
        let pulled = (-self.balance).max(0.0);
        if self.started && !self.firmware_pulled && pulled < least {
            findings.add(Rule::Retract, at, [pulled, least], || {
                format!("only {pulled:.2} mm of filament is retracted before the table turns (minimum {least:.2} mm)")
            });
        }
    }

    /// A printing move of `e` mm.
    pub(super) fn lay(
        &mut self,
        print: Option<usize>,
        e: f64,
        planned: &[Planned],
        at: FindingPlace,
        findings: &mut Findings,
    ) {
        if self.disturbed {
            self.settle(at, findings);
        }
        self.started = true;
        self.filament += e;
        let Some(print) = print else { return };
        if self.printing != Some(print) {
            self.follow(print, planned, at, findings);
        }
        let laid = &mut self.prints[print];
        laid.filament += e;
        laid.moves += 1;
        laid.last = at.line;
    }

    /// Printing starts: what was pulled must be back.
    fn settle(&mut self, at: FindingPlace, findings: &mut Findings) {
        // Before the first print, filament may be purged.
        let purge = !self.started && self.balance > 0.0;
        // The first print begins with a nozzle that has not waited for any other.
        let turned = std::mem::take(&mut self.turned) && self.printing.is_some();
        let prime = if turned { self.prime } else { 0.0 };
        let off = self.balance - prime;
        if off.abs() > RETRACT_SLACK_MM && !purge {
            let (balance, word) = (off, if off < 0.0 { "missing" } else { "too much" });
            findings.add(Rule::Retract, at, [balance.abs(), RETRACT_SLACK_MM], || {
                format!(
                    "printing starts with {:.3} mm of filament {word} (maximum {RETRACT_SLACK_MM} mm)",
                    balance.abs()
                )
            });
        }
        if !purge {
            self.strayed[usize::from(off > 0.0)] += off.abs();
        }
        if self.firmware_pulled {
            findings.add(Rule::Retract, at, [1.0, 0.0], || "printing starts between G10 and G11".to_owned());
        }
        (self.balance, self.disturbed) = (0.0, false);
    }

    /// Another print goes on: its setup must be the same or a later one.
    fn follow(&mut self, print: usize, planned: &[Planned], at: FindingPlace, findings: &mut Findings) {
        if let Some(before) = self.printing.filter(|&p| planned[p].setup > planned[print].setup) {
            findings.add(Rule::Sequence, at, [planned[print].setup as f64, planned[before].setup as f64], || {
                format!("print {print} continues after print {before}, which the plan puts in a later setup")
            });
        }
        self.printing = Some(print);
    }

    /// How many slots had something printed in them.
    pub(super) fn slots(&self, planned: &[Planned]) -> usize {
        let used = self.prints.iter().zip(planned).filter(|(laid, _)| laid.moves > 0);
        used.map(|(_, p)| p.slot).collect::<std::collections::BTreeSet<_>>().len()
    }

    /// What was missing or too much each time printing went on must be little in all.
    fn check_strayed(&self, line: u32, findings: &mut Findings) {
        let most = FEW_MM.max(MOST_STRAYED * self.filament);
        for (mm, word) in self.strayed.iter().zip(["missing", "in excess"]) {
            if *mm > most {
                let at = FindingPlace { line, slot: None, part: None };
                findings.add(Rule::Retract, at, [*mm, most], || {
                    format!("in total, {mm:.1} mm of filament is {word} where printing resumes (maximum {most:.1} mm)")
                });
            }
        }
    }

    /// The file ends: each print must have been made, with the filament that was sliced.
    pub(super) fn finish(&self, planned: &[Planned], last: u32, findings: &mut Findings) {
        self.check_strayed(last, findings);
        for (index, (laid, print)) in self.prints.iter().zip(planned).enumerate() {
            let line = if laid.moves > 0 { laid.last } else { last };
            let at = FindingPlace { line, slot: Some(print.slot), part: Some(print.part) };
            if laid.moves == 0 {
                findings
                    .add(Rule::Sequence, at, [0.0, 1.0], || format!("print {index} of the plan is not in the file"));
                continue;
            }
            let Some(expected) = laid.expected else {
                findings.add(Rule::Sequence, at, [0.0, 1.0], || {
                    format!("the header does not state the filament of print {index}")
                });
                continue;
            };
            let slack_mm = FILAMENT_SLACK_MM + FILAMENT_SLACK_SHARE * expected;
            if (laid.filament - expected).abs() > slack_mm {
                findings.add(Rule::Filament, at, [laid.filament, expected], || {
                    let filament = laid.filament;
                    format!("print {index} extrudes {filament:.3} mm of filament, but the header states {expected:.3} mm (tolerance {slack_mm:.3} mm)")
                });
            }
        }
    }
}
