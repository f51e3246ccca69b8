//! What holds a line while it is printed: something below or beside it, or both ends of a bridge; and that the tip does not dip into what
//! is printed. Makes the checks of lines in the air and of scrape.

use super::grid::Grid;
use super::maths::{V, dot, length, scale, steps, sub};
use super::opinion::Check;
use super::reader::NONE;
use super::scene::{Bead, Scene};

/// How far from a point others matter, mm.
const NEAR_MM: f64 = 0.85;

/// A point of a printed line's middle, table frame.
struct Spot {
    p: V,
    bead: usize,
    chain: usize,
    path: f64,
    /// The stretch in the air that it is of; 0 where it is none.
    stretch: usize,
}

/// Everything printed so far.
struct Cloud {
    spots: Grid<Spot, 3>,
    /// Whether each stretch hangs between two ends, so that others may lean on it.
    holds: Vec<bool>,
    longest: f64,
}

/// A stretch of a chain of lines with nothing below or beside it.
#[derive(Default)]
struct Stretch {
    closed: bool,
    from_start: bool,
    /// How long it was at the beginning of a closed chain, mm.
    held: f64,
    held_number: usize,
    number: usize,
    long: f64,
    line: usize,
}

impl Scene<'_> {
    pub fn check_air(&self) -> [Check; 2] {
        let (mut air, mut scrape) = (Check::new("in the air"), Check::new("scrape"));
        let mut cloud = Cloud { spots: Grid::new(), holds: vec![true], longest: 0.0 };
        let mut deepest = 0.0_f64;
        let (mut chain, mut path, mut last, mut stretch) = (0, 0.0, NONE, Stretch::default());
        let mut beads = self.beads.iter().enumerate().peekable();
        for (index, motion) in self.motions.iter().enumerate() {
            let Some((number, bead)) = beads.next_if(|(_, bead)| bead.motion == index) else {
                let deep = self.dip(&cloud, index);
                deepest = deepest.max(deep);
                scrape.line(motion.line, deep <= 0.1, || format!("the tip is {deep:.2} mm deep in what is printed"));
                continue;
            };
            if last == NONE || last + 1 != index || self.beads[number - 1].print != bead.print {
                self.end_chain(&mut air, &mut cloud, stretch);
                chain += 1;
                stretch = Stretch { from_start: true, closed: self.closes(number), ..Stretch::default() };
            }
            last = index;
            let mut spots = Vec::new();
            let (count, pose) = (steps(bead.way(), 0.5), self.pose(bead));
            for (i, p) in bead.places(0.5).enumerate() {
                let walked = path + bead.way() * i as f64 / count as f64;
                let mut spot = Spot { p: pose.table(p), bead: number, chain, path: walked, stretch: 0 };
                if self.is_grounded(&cloud, &spot) {
                    let free = usize::from(stretch.from_start);
                    if stretch.from_start && stretch.closed {
                        (stretch.held, stretch.held_number) = (stretch.long, stretch.number);
                    } else {
                        self.end_stretch(&mut air, &mut cloud, &stretch, free);
                    }
                    (stretch.from_start, stretch.long) = (false, 0.0);
                } else {
                    if stretch.long == 0.0 {
                        stretch.number = cloud.holds.len();
                        cloud.holds.push(false);
                    }
                    spot.stretch = stretch.number;
                    stretch.long += if i > 0 { bead.way() / count as f64 } else { 1e-9 };
                    stretch.line = bead.line;
                }
                spots.push(spot);
            }
            path += bead.way();
            spots.into_iter().for_each(|spot| cloud.spots.cell(spot.p).push(spot));
        }
        self.end_chain(&mut air, &mut cloud, stretch);
        air.figure = format!("longest stretch {:.1} mm", cloud.longest);
        scrape.figure = format!("at most {deepest:.2} mm deep");
        [air, scrape]
    }

    /// Whether a chain of lines ends where it begins.
    fn closes(&self, number: usize) -> bool {
        let first = &self.beads[number];
        let follows = |(i, bead): &(usize, &Bead)| bead.motion == first.motion + i && bead.print == first.print;
        let last = self.beads[number..].iter().enumerate().take_while(follows).last();
        last.is_some_and(|(i, last)| i > 1 && length(sub(last.ends[1], first.ends[0])) < 0.6)
    }

    /// A closed chain holds on to its own beginning.
    fn end_chain(&self, air: &mut Check, cloud: &mut Cloud, mut stretch: Stretch) {
        let free = match (stretch.closed, stretch.from_start) {
            (true, false) => 0,
            (_, from_start) => 1 + usize::from(from_start),
        };
        stretch.long += stretch.held;
        self.end_stretch(air, cloud, &stretch, free);
        cloud.holds[stretch.held_number] = stretch.held == 0.0 || cloud.holds[stretch.number];
    }

    fn end_stretch(&self, air: &mut Check, cloud: &mut Cloud, stretch: &Stretch, free: usize) {
        let long = stretch.long;
        cloud.longest = cloud.longest.max(long);
        let most = [self.plan.bridge.unwrap_or(self.machine.bridge) + 1.0, 3.0, 1.5][free];
        cloud.holds[stretch.number] |= free == 0 && long <= most;
        air.line(stretch.line, long <= most, || {
            format!("{long:.1} mm in the air, {free} of its ends free, at most {most}")
        });
    }

    /// Whether something is below or beside a point, or it is on the table.
    fn is_grounded(&self, cloud: &Cloud, spot: &Spot) -> bool {
        let bead = &self.beads[spot.bead];
        let (height, up) = (bead.height, self.pose(bead).up());
        if self.machine.table.spans(spot.p) && (-0.1..=1.1 * height).contains(&spot.p[2]) {
            return true;
        }
        let gap = self.plan.print(bead.print).and_then(|print| print.gap).unwrap_or(0.0);
        cloud.spots.near(spot.p, NEAR_MM).any(|other| {
            let way = sub(other.p, spot.p);
            let rise = dot(way, up);
            let across = length(sub(way, scale(up, rise)));
            let under = &self.beads[other.bead];
            if under.pose != bead.pose && under.print != bead.print {
                return length(way) <= NEAR_MM && rise < 0.3 * height;
            }
            let beside = rise.abs() <= 0.3 * height
                && cloud.holds[other.stretch]
                && (other.chain != spot.chain || spot.path - other.path > 1.5);
            across <= 0.6 && (beside || (-1.5 * height.max(under.height) - gap..-0.3 * height).contains(&rise))
        })
    }

    /// How deep the tip goes below the top of what is printed, or below the table.
    fn dip(&self, cloud: &Cloud, index: usize) -> f64 {
        let (motion, pose) = (&self.motions[index], &self.poses[self.pose_of[index]]);
        if motion.turns() || !motion.is_known() {
            return 0.0;
        }
        let (count, up, mut deep) = (steps(motion.way(), 0.5), pose.up(), 0.0_f64);
        for i in 0..=count {
            let p = pose.table(motion.tip(i as f64 / count as f64));
            if self.machine.table.spans(p) && p[2] > -self.machine.table.thickness {
                deep = deep.max(-p[2]);
            }
            for other in cloud.spots.near(p, NEAR_MM) {
                let (way, bead) = (sub(other.p, p), &self.beads[other.bead]);
                let rise = dot(way, up);
                if length(sub(way, scale(up, rise))) < 0.2 && dot(self.pose(bead).up(), up) > 0.999 {
                    deep = deep.max(rise + bead.height / 2.0);
                }
            }
        }
        deep
    }
}
