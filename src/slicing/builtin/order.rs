//! In which order, and from where, a layer's lines are printed.
//!
//! Always on to the nearest: of the islands, of an island's walls, of its bridges, of its other infill and what fills gaps between walls.
//! A wall waits for the ones that lie inside it, and one that lies on nothing for the bridges that hold it.

use super::comb::Comb;
use super::nearest::Nearest;
use super::overhang::Ground;
use super::plan::{Feature, Fill, Island, Path, PlannedLayer};
use super::region::{Contour, GridPoint, distance_mm, perimeter_mm};
use super::seam::{Seams, nearest_place};
use super::tour::{Ends, tour};
use super::walls::Bead;
use crate::slicing::SliceSettings;

/// A longer way inside an island is made with the filament pulled back too, mm: what oozes is missing where the next line begins.
const LONGEST_UNPULLED_MM: f64 = 60.0;
/// A way inside an island may be so much longer than the straight one, mm: that takes as long as a pull.
const LONGEST_DETOUR_MM: f64 = 25.0;

/// Puts the lines of layer after layer in order.
pub(super) struct Order<'a> {
    settings: &'a SliceSettings,
    /// Where the last line ended.
    at: Option<GridPoint>,
    /// The layer's lines so far.
    paths: Vec<Path>,
    seams: Seams,
}

impl<'a> Order<'a> {
    pub(super) fn new(settings: &'a SliceSettings) -> Self {
        Self { settings, at: None, paths: Vec::new(), seams: Seams::new(settings.seam) }
    }

    /// The layer's paths in printing order, on the way to the layer `above`. Islands nearest first; in each the walls from the inside
    /// out, then infill, or the other way round.
    pub(super) fn of(&mut self, layer: &PlannedLayer<'_>, above: Option<&PlannedLayer<'_>>) -> Vec<Path> {
        let starts = |layer: &PlannedLayer<'_>| Nearest::all(layer.islands.iter().map(Island::start).collect());
        let (mut islands, nearest_above) = (starts(layer), above.map(starts));
        while let Some(next) = islands.to(self.place()) {
            islands.remove(next);
            let island = &layer.islands[next];
            let mut inside = Ways { island, comb: None };
            let (gaps, walls) = gaps_and_walls(island, layer.ground.as_ref());
            let (afloat, walls) = afloat(island, walls, layer.ground.as_ref());
            let infill_first = self.settings.infill_first;
            if !infill_first {
                self.walls(&mut inside, &walls, layer.ground.as_ref());
            }
            let place = self.place();
            let above = || Some(&above?.islands[nearest_above.as_ref()?.to(place)?]);
            let next = || islands.to(place).map(|next| &layer.islands[next]).or_else(above);
            // Its own walls follow, or what comes behind the island.
            let then = || if infill_first { Some(island) } else { next() };
            for bridges in [true, false] {
                let fills = island.fills.iter().filter(|fill| (fill.feature == Feature::Bridge) == bridges);
                let gaps = gaps.iter().filter(|_| !bridges).map(|bead| Piece::Bead(None, bead));
                let pieces: Vec<Piece<'_>> = fills.flat_map(pieces_of).chain(gaps).collect();
                // Behind bridges the nearest of the other lines follows.
                let then = if bridges || pieces.is_empty() { None } else { then() };
                let to = then.map(|island| self.begins(island)).unwrap_or_default();
                self.pieces(&mut inside, &pieces, layer.ground.as_ref(), &to);
                if bridges {
                    self.walls(&mut inside, &afloat, layer.ground.as_ref());
                }
            }
            if infill_first {
                self.walls(&mut inside, &walls, layer.ground.as_ref());
            }
        }
        self.seams.next_layer();
        std::mem::take(&mut self.paths)
    }

    /// Where the first wall of an island may begin, as far as that is known before the nozzle is there.
    fn begins(&self, island: &Island<'_>) -> Vec<GridPoint> {
        let (_, walls) = gaps_and_walls(island, None);
        let outside = outside_of(&walls);
        let inner = inner_of(&outside);
        let starts = self.starts(&walls, &outside);
        let free = (0..walls.len()).filter(|&wall| inner[wall] == 0);
        let found: Vec<GridPoint> = free.flat_map(|wall| starts[wall]).collect();
        if found.is_empty() { vec![island.start()] } else { found }
    }

    /// Where each bead may begin: an open one at its ends, an outer wall at its seam, a wall inside it nearest to there.
    fn starts(&self, beads: &[&Bead], outside: &[Option<usize>]) -> Vec<[GridPoint; 2]> {
        let mut order: Vec<usize> = (0..beads.len()).collect();
        order.sort_by_key(|&bead| beads[bead].depth);
        let mut found = vec![[GridPoint::default(); 2]; beads.len()];
        for index in order {
            let points = &beads[index].points;
            found[index] = match (beads[index].closed, outside[index]) {
                (false, _) => [points[0], points[points.len() - 1]],
                (true, Some(of)) => [points[nearest_place(points, found[of][0])]; 2],
                (true, None) => [points[self.seams.place(points, self.place())]; 2],
            };
        }
        found
    }

    /// Lines on the table around everything, before all others.
    pub(super) fn around(&mut self, rings: Vec<Contour>) {
        for ring in rings.iter().filter(|ring| !ring.is_empty()) {
            let points = opened_at(ring, nearest_place(ring, self.place()), 0.0);
            let (first, last) = (points[0], points[points.len() - 1]);
            let pull = self.at.is_some_and(|at| distance_mm(at, first) > self.settings.retract_from_mm);
            self.at = Some(last);
            self.paths.push(Path { feature: Feature::Adhesion, points, width_mm: None, way: Vec::new(), pull });
        }
    }

    fn place(&self) -> GridPoint {
        self.at.unwrap_or_default()
    }

    fn walls(&mut self, inside: &mut Ways<'_>, beads: &[&Bead], ground: Option<&Ground>) {
        let outside = outside_of(beads);
        let starts = self.starts(beads, &outside);
        let mut inner = inner_of(&outside);
        // Both ends of an open line, the start of a closed one twice.
        let mut nearest = Nearest::of(starts.iter().flatten().copied().collect());
        let free = |nearest: &mut Nearest, bead: usize| {
            nearest.add(2 * bead);
            nearest.add(2 * bead + 1);
        };
        (0..beads.len()).filter(|&bead| inner[bead] == 0).for_each(|bead| free(&mut nearest, bead));
        while let Some(end) = nearest.to(self.place()) {
            let next = end / 2;
            nearest.remove(2 * next);
            nearest.remove(2 * next + 1);
            let bead = beads[next];
            // PrusaSlicer's seam gap: 15 % of the nozzle's bore.
            if bead.closed && outside[next].is_none() {
                self.seams.begun(starts[next][0]);
            }
            let (points, widths) = laid_from(bead, starts[next][end % 2], 0.15 * self.settings.nozzle_mm);
            self.add_stretches(inside, wall_feature(bead), &points, &widths, ground);
            if let Some(of) = outside[next] {
                inner[of] -= 1;
                if inner[of] == 0 {
                    free(&mut nearest, of);
                }
            }
        }
    }

    /// The bead cut where its width changes and where what carries it does.
    fn add_stretches(
        &mut self,
        inside: &mut Ways<'_>,
        feature: Feature,
        points: &[GridPoint],
        widths: &[f64],
        ground: Option<&Ground>,
    ) {
        let mut add = |points: &[GridPoint], width_mm: Option<f64>| {
            let stretches = ground.map_or_else(|| vec![(true, points.to_vec())], |ground| ground.split(points));
            for (supported, points) in stretches {
                self.add(inside, if supported { feature } else { Feature::Overhang }, points, width_mm);
            }
        };
        if widths.is_empty() {
            add(points, None);
            return;
        }
        let mut from = 0;
        for alike in widths.chunk_by(|a, b| (a - b).abs() < 0.5e-3) {
            add(&points[from..=from + alike.len()], Some(alike[0]));
            from += alike.len();
        }
    }

    fn pieces(&mut self, inside: &mut Ways<'_>, pieces: &[Piece<'_>], ground: Option<&Ground>, to: &[GridPoint]) {
        let ends: Vec<Ends> = pieces.iter().map(Piece::ends).collect();
        for (next, end) in tour(self.at, &ends, to) {
            match pieces[next] {
                Piece::Line(fill, line) => {
                    let mut points = line.clone();
                    if end == 1 {
                        points.reverse();
                    }
                    self.add(inside, fill.feature, points, fill.width_mm);
                }
                Piece::Bead(infill, bead) => {
                    let nearest = || bead.points[nearest_place(&bead.points, self.place())];
                    let start = if bead.closed { nearest() } else { ends[next][end] };
                    let (points, widths) = laid_from(bead, start, 0.0);
                    // What hangs of infill is a bridge's, and no line along its border.
                    let ground = ground.filter(|_| infill.is_none());
                    self.add_stretches(inside, infill.unwrap_or(wall_feature(bead)), &points, &widths, ground);
                }
            }
        }
    }

    fn add(&mut self, inside: &mut Ways<'_>, feature: Feature, points: Contour, width_mm: Option<f64>) {
        let [Some(&first), Some(&last)] = [points.first(), points.last()] else { return };
        let (way, pull) = match self.at {
            Some(at) => self.way(inside, at, first),
            None => (Vec::new(), false),
        };
        self.at = Some(last);
        self.paths.push(Path { feature, points, width_mm, way, pull });
    }

    /// The corners of the way to the next line, and whether the filament is pulled back on it.
    fn way(&self, inside: &mut Ways<'_>, from: GridPoint, to: GridPoint) -> (Vec<GridPoint>, bool) {
        let straight = distance_mm(from, to);
        if straight <= self.settings.retract_from_mm {
            return (Vec::new(), false);
        }
        let Some(way) = inside.way(from, to) else { return (Vec::new(), true) };
        let whole: Vec<GridPoint> = [from].into_iter().chain(way.iter().copied()).chain([to]).collect();
        let length: f64 = whole.windows(2).map(|leg| distance_mm(leg[0], leg[1])).sum();
        if length > straight + LONGEST_DETOUR_MM {
            return (Vec::new(), true);
        }
        (way, length > LONGEST_UNPULLED_MM)
    }
}

/// Loops of which nothing is carried, as around a screw's hole in the roof of its head, where bridges can hold them: these are laid first. And all
/// other walls.
fn afloat<'b>(island: &Island<'_>, walls: Vec<&'b Bead>, ground: Option<&Ground>) -> (Vec<&'b Bead>, Vec<&'b Bead>) {
    let bridged = island.fills.iter().any(|fill| fill.feature == Feature::Bridge);
    let Some(ground) = ground.filter(|_| bridged) else { return (Vec::new(), walls) };
    walls.into_iter().partition(|bead| bead.closed && !ground.carries_any_of(&bead.points))
}

/// What fills gaps between walls, and the walls. Where an outer wall hangs, what lies inside it holds it, whole or in pieces: then that is all walls.
fn gaps_and_walls<'a>(island: &Island<'a>, ground: Option<&Ground>) -> (Vec<&'a Bead>, Vec<&'a Bead>) {
    let is_open = |bead: &&Bead| bead.depth > 0 && !bead.closed;
    let hangs = |ground: &Ground| {
        let mut outer = island.beads.iter().filter(|bead| bead.depth == 0 && bead.closed);
        outer.any(|bead| !ground.carries_all_of(&bead.points))
    };
    let has_gaps = island.beads.iter().any(|bead| is_open(&bead));
    let is_held = has_gaps && ground.is_some_and(hangs);
    island.beads.iter().partition(|bead| is_open(bead) && !is_held)
}

/// How many walls each one waits for.
fn inner_of(outside: &[Option<usize>]) -> Vec<usize> {
    let mut inner = vec![0; outside.len()];
    outside.iter().flatten().for_each(|&of| inner[of] += 1);
    inner
}

/// What may begin at either end.
#[derive(Clone, Copy)]
enum Piece<'a> {
    Line(&'a Fill, &'a Contour),
    /// A line along a border: infill's, or between walls.
    Bead(Option<Feature>, &'a Bead),
}

/// The rows of infill, and its lines along the border.
fn pieces_of(fill: &Fill) -> impl Iterator<Item = Piece<'_>> {
    let rows = fill.lines.iter().map(move |line| Piece::Line(fill, line));
    rows.chain(fill.beads.iter().map(|bead| Piece::Bead(Some(fill.feature), bead)))
}

/// What a bead of a wall is printed as.
fn wall_feature(bead: &Bead) -> Feature {
    match (bead.depth, bead.widths.is_empty()) {
        (0, _) => Feature::OuterWall,
        (_, false) => Feature::Gap,
        (_, true) => Feature::InnerWall,
    }
}

impl Piece<'_> {
    fn ends(&self) -> Ends {
        let points = match self {
            Self::Line(_, line) => line,
            // A ring ends where it begins.
            Self::Bead(_, bead) if bead.closed => return [bead.points[0]; 2],
            Self::Bead(_, bead) => &bead.points,
        };
        [points[0], points[points.len() - 1]]
    }
}

/// The ways inside an island, prepared when the first is asked for.
struct Ways<'a> {
    island: &'a Island<'a>,
    comb: Option<Comb>,
}

impl Ways<'_> {
    fn way(&mut self, from: GridPoint, to: GridPoint) -> Option<Vec<GridPoint>> {
        let island = self.island;
        self.comb.get_or_insert_with(|| Comb::new(island.shape, island.centre)).way(from, to)
    }
}

/// For each wall the one next to it outside, of those that are one less deep.
fn outside_of(beads: &[&Bead]) -> Vec<Option<usize>> {
    let mut found = vec![None; beads.len()];
    let deepest = beads.iter().map(|bead| bead.depth).max().unwrap_or(0);
    for depth in 1..=deepest {
        let outer: Vec<(usize, GridPoint)> = beads
            .iter()
            .enumerate()
            .filter(|(_, bead)| bead.depth + 1 == depth)
            .flat_map(|(index, bead)| bead.points.iter().map(move |&p| (index, p)))
            .collect();
        let nearest = Nearest::all(outer.iter().map(|(_, p)| *p).collect());
        for (index, bead) in beads.iter().enumerate().filter(|(_, bead)| bead.depth == depth) {
            found[index] = nearest.to(bead.points[0]).map(|place| outer[place].0);
        }
    }
    found
}

/// The bead's points in the order in which they are printed from `start`, and the width of each leg.
fn laid_from(bead: &Bead, start: GridPoint, clip_mm: f64) -> (Contour, Vec<f64>) {
    let mut widths = bead.widths.clone();
    let start = bead.points.iter().position(|&p| p == start).unwrap_or(0);
    if bead.closed {
        let points = opened_at(&bead.points, start, clip_mm);
        if !widths.is_empty() {
            widths.rotate_left(start);
            widths.truncate(points.len() - 1);
        }
        return (points, widths);
    }
    let mut points = bead.points.clone();
    if start > 0 {
        points.reverse();
        widths.reverse();
    }
    (points, widths)
}

/// The ring as a line from `start` round, ending `clip_mm` before it.
fn opened_at(ring: &[GridPoint], start: usize, clip_mm: f64) -> Contour {
    let mut line: Contour = (0..=ring.len()).map(|i| ring[(start + i) % ring.len()]).collect();
    if perimeter_mm(ring) < 4.0 * clip_mm {
        return line;
    }
    let mut left = clip_mm;
    while let [.., before, last] = line[..] {
        let length = distance_mm(before, last);
        line.pop();
        if length > left {
            let share = 1.0 - left / length;
            let along = |a: i32, b: i32| a + (share * f64::from(b - a)).round() as i32;
            line.push(GridPoint::new(along(before.x, last.x), along(before.y, last.y)));
            break;
        }
        left -= length;
    }
    line
}
