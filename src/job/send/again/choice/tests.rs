//! Which line is taken, held against all that could have been, on a thin tower and on two boxes.

use std::cell::RefCell;
use std::path::Path;

use super::super::testing::{Prepared, boxes, tower};
use super::*;
use crate::job::send::operator::At;
use crate::job::send::{SendError, SendOptions};
use crate::link::Header;

/// What is told, in order.
#[derive(Default)]
struct Heard(RefCell<Vec<String>>);

impl Operator for Heard {
    fn told(&self, what: &Sending<'_>, _: At) {
        let text = match what {
            Sending::Note(text) => (*text).to_owned(),
            other => format!("{other:?}"),
        };
        self.0.borrow_mut().push(text);
    }
}

/// How a print was broken off.
#[derive(Clone, Copy, Debug)]
struct Broken {
    print: &'static Prepared,
    /// Blocks that the planner may hold.
    planner: u32,
    answered: u32,
    sent: u32,
    proved: bool,
    from: Option<u32>,
}

impl std::fmt::Debug for Prepared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} blocks", self.program.len())
    }
}

impl Broken {
    fn settings(&self) -> SenderSettings {
        SenderSettings { planner_blocks: self.planner, ..self.print.homed_by("G28") }
    }

    fn standing(&self) -> JournalSummary {
        let Self { answered, sent, .. } = self;
        let records = format!("run 1 0\nack {answered} {answered}\nsent {sent}\n");
        JournalSummary::parse(&(Header::default().to_text() + &records)).unwrap()
    }

    /// With the choice that is made.
    fn with<T>(&self, look: impl FnOnce(&Choice<'_>) -> T) -> (T, Vec<String>) {
        let (heard, settings) = (Heard::default(), self.settings());
        let options = SendOptions { from: self.from, ..SendOptions::default() };
        let plan = self.print.plan();
        let request = SendRequest {
            path: Path::new("out.gcode"),
            program: &self.print.done.gcode,
            machine: &plan.machine,
            plan: self.proved.then_some(plan),
            options: &options,
        };
        let choice = Choice { request: &request, program: &self.print.program, settings: &settings, operator: &heard };
        let looked = look(&choice);
        (looked, heard.0.take())
    }

    fn entry(&self) -> (Result<Reentry, SendError>, Vec<String>) {
        self.with(|choice| choice.entry(&self.standing(), true))
    }

    fn choices(&self) -> (Range<u32>, Vec<u32>) {
        let (program, settings) = (&self.print.program, self.settings());
        let doubtful = Reentry::doubt(program, &settings, &self.standing(), true, self.from).unwrap();
        let choices = Reentry::choices(program, &doubtful).unwrap();
        (doubtful, choices)
    }

    /// Whether something lies in the air where the print ended earliest and goes on at `block`, to the end of the file.
    fn hangs(&self, doubtful: &Range<u32>, block: u32) -> bool {
        let (program, print) = (&self.print.program, self.print);
        let entry = Reentry::at(program, &self.settings(), doubtful, block).unwrap();
        let printed = program.file_line(doubtful.start - 1);
        let path = ReentryPath::of(print.text(), printed, &entry, program.file_line(program.len()), print.profile());
        path.hanging(print.plan(), print.profile()).is_some()
    }

    /// Whether something is struck where it ended latest.
    fn strikes(&self, doubtful: &Range<u32>, block: u32) -> bool {
        let (program, print) = (&self.print.program, self.print);
        let entry = Reentry::at(program, &self.settings(), doubtful, block).unwrap();
        let printed = program.file_line(doubtful.end - 1);
        let path = ReentryPath::of(print.text(), printed, &entry, program.file_line(program.len()), print.profile());
        path.struck(print.plan(), print.profile()).is_some()
    }
}

fn layers(print: &Prepared) -> Vec<u32> {
    print.program.boundaries.iter().filter(|b| b.kind == BoundaryKind::Layer).map(|b| b.block).collect()
}

/// The tower, broken off with `planner` blocks in doubt of which the last is `into` its `layer`.
fn tower_at(layer: usize, into: u32, planner: u32) -> Broken {
    let sent = layers(tower())[layer] + into;
    Broken { print: tower(), planner, answered: sent, sent, proved: true, from: None }
}

/// The place that is taken carries all that follows, no later one does, and the way to it strikes nothing; else there is none.
#[test]
fn the_latest_place_that_is_carried_is_taken_and_its_way_strikes_nothing() {
    let mut taken = [0; 4];
    for (layer, into, planner) in
        [(5, 12, 6), (5, 3, 12), (6, 2, 40), (7, 20, 60), (4, 15, 25), (8, 1, 90), (9, 5, 140)]
    {
        let broken = tower_at(layer, into, planner);
        let (doubtful, choices) = broken.choices();
        let carried =
            choices.iter().take_while(|block| **block == choices[0] || !broken.hangs(&doubtful, **block)).count();
        let (best, clear) = (choices[carried - 1], !broken.strikes(&doubtful, choices[carried - 1]));
        let (entry, _) = broken.entry();
        let found = entry.as_ref().map(|entry| entry.block).ok();
        assert_eq!(found, clear.then_some(best), "{broken:?}: {choices:?} {:?}", entry.map(|e| e.words));
        let kind = match carried {
            _ if !clear => 3,
            n if n == choices.len() => 2,
            1 => 0,
            _ => 1,
        };
        taken[kind] += 1;
    }
    assert!(taken.iter().skip(1).all(|count| *count > 0), "first, between, last, none: {taken:?}");
}

#[test]
fn behind_a_place_four_layers_are_looked_at() {
    let (print, layers) = (tower(), layers(tower()));
    let looked = |block| tower_at(1, 0, 1).with(|choice| choice.looked_at(block)).0;
    assert_eq!([looked(layers[0] - 1), looked(layers[0]), looked(layers[2] + 1)], [layers[3], layers[4], layers[6]]);
    assert_eq!(looked(layers[layers.len() - 4]), print.program.len());
    assert_eq!(looked(layers[layers.len() - 5]), layers[layers.len() - 1]);
}

/// What is printed ends with the last of its blocks, to the line, and what is looked at with the layers behind.
#[test]
fn what_is_proved_begins_and_ends_where_it_should() {
    let (broken, program) = (tower_at(5, 12, 6), &tower().program);
    let (doubtful, choices) = broken.choices();
    let file = String::from_utf8(tower().text().to_vec()).unwrap();
    let line = |block: u32| file.lines().nth(program.file_line(block) as usize - 1).unwrap();
    let block = choices[choices.len() - 1];
    for printed in [doubtful.start, doubtful.end, 0] {
        let path = broken.with(|choice| choice.path(&doubtful, block, printed)).0.unwrap();
        let text = String::from_utf8(path.text).unwrap();
        let said: Vec<&str> = text.lines().collect();
        let moves = |line: &&&str| !line.is_empty() && !line.starts_with(';');
        let lost = said.iter().position(|line| *line == "M84").unwrap();
        let before: Vec<&&str> = said[..lost].iter().filter(moves).collect();
        assert_eq!(before.len(), printed as usize);
        assert!(printed == 0 || **before[before.len() - 1] == *line(printed - 1));
        // From the fourth layer behind it on nothing is looked at.
        assert_eq!(said.last(), Some(&line(layers(tower())[9])));
    }
    // To the end of the doubt at least.
    let broken = Broken { planner: 10_000, ..tower_at(9, 5, 0) };
    let (doubtful, choices) = broken.choices();
    let fourth = layers(tower()).into_iter().filter(|layer| *layer > choices[0]).nth(3).unwrap();
    assert!(doubtful.end > fourth);
    let path = broken.with(|choice| choice.path(&doubtful, choices[0], doubtful.start)).0.unwrap();
    assert_eq!(String::from_utf8(path.text).unwrap().lines().last(), Some(line(doubtful.end)));
}

#[test]
fn without_a_way_the_lines_in_doubt_and_their_layers_are_named() {
    let broken = tower_at(9, 5, 140);
    let (entry, told) = broken.entry();
    let why = entry.unwrap_err().to_string();
    let (doubtful, choices) = broken.choices();
    let line = |block| broken.print.program.file_line(block);
    let begun: Vec<u32> = layers(broken.print).into_iter().filter(|b| doubtful.contains(b)).map(line).collect();
    assert!(begun.len() > 2);
    let words = begun.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
    let facts =
        format!("lines {} to {} | --from LINE | (layers begin at {words})", line(doubtful.start), line(doubtful.end));
    assert!(facts.split(" | ").all(|fact| why.contains(fact)), "{why}");
    // What would be done is told nevertheless, at the latest place.
    let last = format!("  continue at line {}, ", line(*choices.last().unwrap()));
    assert!(told[4].starts_with(&last), "{told:?}");
}

#[test]
fn a_line_that_somebody_has_given_is_taken_alone_and_proved_all_the_same() {
    let mut broken = tower_at(9, 5, 140);
    let (doubtful, _) = broken.choices();
    // The part was looked at, and nothing of the last layer is there.
    let first = layers(tower())[9];
    broken.from = Some(tower().program.file_line(first));
    let (entry, _) = broken.entry();
    let entry = entry.unwrap();
    assert_eq!((entry.block, entry.doubtful, entry.missing_mm, entry.twice_mm), (first, first..first, 0.0, 0.0));
    // With a machine that homes low over the table the way to it is none.
    broken.from = Some(tower().program.file_line(doubtful.start));
    let low = SenderSettings {
        retreat: crate::link::Retreat { z_max_mm: 0.1, ..broken.settings().retreat },
        ..broken.settings()
    };
    let (entry, _) = broken.with(|choice| Choice { settings: &low, ..*choice }.entry(&broken.standing(), true));
    let why = entry.unwrap_err().to_string();
    assert!(why.contains("is blocked: ") && !why.contains("if lines"), "{why}");
}

#[test]
fn without_a_plan_the_last_layer_in_doubt_is_taken_and_nothing_is_said_to_be_proved() {
    let broken = Broken { proved: false, ..tower_at(7, 20, 60) };
    let (entry, told) = broken.entry();
    assert_eq!(entry.unwrap().block, layers(tower())[7]);
    assert_eq!(told.last().map(String::as_str), Some("UnprovedReentry"));
    let (_, told) = tower_at(5, 12, 6).entry();
    assert!(told.iter().all(|line| !line.contains("Unproved")) && told.len() == 7, "{told:?}");
    assert!(told.iter().any(|line| line.contains("a bed that has cooled may release the part")), "{told:?}");
}

#[test]
fn a_beam_that_is_printed_tilted_goes_on_where_the_doubt_ends() {
    let (program, layers) = (&boxes().program, layers(boxes()));
    let sent = layers[layers.len() - 20] + 60;
    let broken = Broken { print: boxes(), planner: 32, answered: sent - 4, sent, proved: true, from: None };
    let entry = broken.entry().0.unwrap();
    assert_eq!((entry.block, entry.twice_mm, &entry.doubtful), (sent, 0.0, &(sent - 36..sent)));
    assert!(entry.missing_mm > 1.0 && program.len() > sent, "{}", entry.missing_mm);
}
