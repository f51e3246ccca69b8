//! A calibration tower's sheet: how it looks, its numbered dimensions from above and from the side, and lines to write the readings on.
//!
//! From above, `across` ([`Tower::axes`]) is to the right; from the side the same, with Z up. Paper in units, the tower in mm.

use super::{BEFORE, KINDS};
use crate::calibrate::{Block, DimensionKind, Tower};
use crate::geom::{Vec3, convex_outline};
use crate::view::{Anchor, Colour, Drawing, Frame, INK, Sheet, Side, Surface};

/// Units a mm, and the width of the sheet.
const SCALE: f64 = 7.0;
const WIDTH: f64 = 1010.0;
/// Side of the picture in space.
const PICTURE: f64 = 330.0;
/// Where the view from above and that from the side have their middle and their table.
const ABOVE: [f64; 2] = [650.0, 215.0];
const BESIDE: [f64; 2] = [ABOVE[0], 660.0];
/// Where the list begins, and the height of a line.
const LIST: f64 = 730.0;
const LINE: f64 = 30.0;
const LETTERS: f64 = 13.0;
const SMALL: f64 = 11.0;
const GAUGE: Colour = [0, 90, 160];
const FAINT: Colour = [150, 175, 200];
/// What a block is printed with, by its step.
const STEPS: [(Colour, &str); 4] = [
    (BEFORE, "printed first"),
    (KINDS[0], "printed after half a turn"),
    (KINDS[2], "printed on the tilted table"),
    (KINDS[5], "printed on the tilted table, after half a turn"),
];

/// The sheet of a tower for a machine of that name.
pub(crate) fn tower_sheet(tower: &Tower, machine: &str) -> Drawing {
    let height = LIST + LINE * (tower.dimensions.len() as f64 + 1.0) + 20.0;
    let title = format!("Calibration tower for {machine}");
    let mut page = Page { drawing: Drawing::new([WIDTH, height], title.clone()), tower };
    page.picture(machine);
    page.view_above();
    page.view_beside();
    page.list();
    page.drawing
}

struct Page<'a> {
    drawing: Drawing,
    tower: &'a Tower,
}

impl Page<'_> {
    fn picture(&mut self, machine: &str) {
        let solid = |block: &Block| {
            let name = letter(block);
            Surface { name, wanted: block.step > 0, ..Surface::of(&block.mesh(), STEPS[block.step].0) }
        };
        let frame = Frame {
            surfaces: self.tower.blocks.iter().map(solid).collect(),
            scope: self.tower.blocks.iter().flat_map(|block| block.mesh().vertices().to_vec()).collect(),
            side: Side::Above,
            ..Frame::default()
        };
        let sheet = Sheet {
            title: String::new(),
            side: PICTURE,
            columns: 1,
            frames: vec![frame],
            legend: vec![],
            story: vec![],
        };
        self.drawing.marks.extend(sheet.drawing().marks);
        let mut y = PICTURE + 34.0;
        self.drawing.text([14.0, y], 16.0, Anchor::Start, format!("Calibration tower for {machine}"));
        for (colour, words) in STEPS {
            y += 24.0;
            self.drawing.rectangle([14.0, y - 11.0], [28.0, y + 2.0], colour);
            self.drawing.text([36.0, y], LETTERS, Anchor::Start, words);
        }
        y += 14.0;
        for words in [
            "1 to 4: outside widths, with the jaws' tips on the roof,",
            "over the flat faces of both posts.",
            "5: over the outermost edges of both blocks.",
            "6 to 10: from the flat underside to the top of a post,",
            "or to the highest edge of a block.",
            "A is the long post; the block next to it is E.",
        ] {
            y += 19.0;
            self.drawing.text([14.0, y], SMALL, Anchor::Start, words);
        }
    }

    fn above(&self, p: &Vec3) -> [f64; 2] {
        let [along, across] = self.tower.axes;
        [ABOVE[0] + SCALE * p.dot(&across), ABOVE[1] + SCALE * p.dot(&along)]
    }

    fn beside(&self, p: &Vec3) -> [f64; 2] {
        [BESIDE[0] + SCALE * p.dot(&self.tower.axes[1]), BESIDE[1] - SCALE * p.z]
    }

    fn solids(&mut self, seen: fn(&Self, &Vec3) -> [f64; 2], named: &[&str]) {
        for block in &self.tower.blocks {
            let points: Vec<[f64; 2]> = block.mesh().vertices().iter().map(|p| seen(self, p)).collect();
            let mut ring = convex_outline(points, 0.0);
            self.drawing.area(vec![ring.clone()], STEPS[block.step].0, if block.step == 0 { 0.55 } else { 0.85 });
            ring.extend(ring.first().copied());
            self.drawing.line(ring, 1.0, INK);
            if let Some(letter) = letter(block).filter(|letter| named.contains(&&**letter)) {
                let [x, y] = seen(self, &middle(block));
                self.drawing.text([x, y + 5.0], LETTERS, Anchor::Middle, letter);
            }
        }
    }

    fn view_above(&mut self) {
        self.drawing.text([ABOVE[0], 22.0], LETTERS, Anchor::Middle, "from above");
        self.solids(Self::above, &["A", "B", "C", "D", "E", "F"]);
        let low = self.lowest(Self::above);
        let high = self.highest(Self::above);
        let [left, right] = [low[0] - 26.0, high[0] + 26.0];
        let [top, bottom] = [low[1] - 28.0, high[1] + 28.0];
        let places = [[right, 0.0], [left, 0.0], [0.0, top], [0.0, bottom], [0.0, bottom + 34.0]];
        for (index, place) in places.into_iter().enumerate() {
            let DimensionKind::Across(both, towards) = self.tower.dimensions[index].kind else { continue };
            let end = |sign: f64| {
                let corners = both.iter().flat_map(|&block| &self.tower.blocks[block].corners);
                let outer =
                    corners.map(|c| c.at).max_by(|a, b| (sign * a.dot(&towards)).total_cmp(&(sign * b.dot(&towards))));
                self.above(&outer.unwrap_or_default())
            };
            let upright = place[1] == 0.0;
            self.dimension(index + 1, [end(-1.0), end(1.0)], place, upright);
        }
    }

    fn view_beside(&mut self) {
        let high = self.highest(Self::beside);
        let low = self.lowest(Self::beside);
        self.drawing.text([BESIDE[0], low[1] - 16.0], LETTERS, Anchor::Middle, "from the side");
        self.solids(Self::beside, &["B", "C", "D", "E", "F"]);
        let [left, right] = [low[0], high[0]];
        let columns = [right + 62.0, right + 96.0, left - 62.0, right + 28.0, left - 28.0];
        for (index, x) in columns.into_iter().enumerate() {
            let one = &self.tower.dimensions[5 + index];
            let DimensionKind::Height(block) = one.kind else { continue };
            let corners = self.tower.blocks[block].corners.iter().map(|c| c.at);
            let top = self.beside(&corners.max_by(|a, b| a.z.total_cmp(&b.z)).unwrap_or_default());
            self.dimension(6 + index, [[top[0], BESIDE[1]], top], [x, 0.0], true);
        }
    }

    /// A number between two places, beside or below the drawing.
    fn dimension(&mut self, number: usize, ends: [[f64; 2]; 2], place: [f64; 2], upright: bool) {
        let foot = |[x, y]: [f64; 2]| if upright { [place[0], y] } else { [x, place[1]] };
        let feet = ends.map(foot);
        for (end, foot) in ends.into_iter().zip(feet) {
            self.drawing.line(vec![end, foot], 0.7, FAINT);
        }
        self.drawing.line(feet.to_vec(), 1.4, GAUGE);
        let tick = 4.0;
        for [x, y] in feet {
            self.drawing.line(vec![[x - tick, y + tick], [x + tick, y - tick]], 1.4, GAUGE);
        }
        let [x, y] = [0, 1].map(|i| (feet[0][i] + feet[1][i]) / 2.0);
        self.numbered([x, y], number);
    }

    fn numbered(&mut self, [x, y]: [f64; 2], number: usize) {
        let at = |i: usize| (std::f64::consts::TAU * i as f64 / 32.0).sin_cos();
        let ring = (0..32).map(at).map(|(s, c)| [x + 11.0 * c, y + 11.0 * s]).collect();
        self.drawing.area(vec![ring], [255; 3], 1.0);
        self.drawing.circle([x, y], 11.0, 1.4, GAUGE);
        self.drawing.text([x, y + 4.5], LETTERS, Anchor::Middle, number.to_string());
    }

    fn list(&mut self) {
        let columns = [30.0, 62.0, 400.0, 560.0, 740.0];
        let head = ["", "between", "drawn, mm", "first reading, mm", "second reading, mm"];
        for (x, words) in columns.into_iter().zip(head) {
            self.drawing.text([x, LIST], SMALL, Anchor::Start, words);
        }
        for (row, one) in self.tower.dimensions.iter().enumerate() {
            let y = LIST + LINE * (row as f64 + 1.0);
            self.numbered([columns[0], y - 4.5], one.number);
            self.drawing.text([columns[1], y], LETTERS, Anchor::Start, one.name.clone());
            self.drawing.text([columns[2], y], LETTERS, Anchor::Start, format!("{:.2}", one.drawn_mm));
            for x in &columns[3..] {
                self.drawing.line(vec![[*x, y + 4.0], [x + 140.0, y + 4.0]], 0.8, INK);
            }
        }
    }

    fn lowest(&self, seen: fn(&Self, &Vec3) -> [f64; 2]) -> [f64; 2] {
        self.ends(seen, f64::min, f64::MAX)
    }

    fn highest(&self, seen: fn(&Self, &Vec3) -> [f64; 2]) -> [f64; 2] {
        self.ends(seen, f64::max, f64::MIN)
    }

    fn ends(&self, seen: fn(&Self, &Vec3) -> [f64; 2], best: fn(f64, f64) -> f64, from: f64) -> [f64; 2] {
        let meshes: Vec<_> = self.tower.blocks.iter().map(Block::mesh).collect();
        let points = meshes.iter().flat_map(|mesh| mesh.vertices()).map(|p| seen(self, p));
        points.fold([from; 2], |[x, y], p| [best(x, p[0]), best(y, p[1])])
    }
}

/// What a block is called on the sheet; the base has no letter.
fn letter(block: &Block) -> Option<String> {
    Some(block.name.split_once('-')?.1.to_uppercase())
}

fn middle(block: &Block) -> Vec3 {
    let mesh = block.mesh();
    mesh.vertices().iter().sum::<Vec3>() / mesh.vertices().len() as f64
}
