//! What does not fit on a table at once, on as many plates as it takes.
//!
//! What stands apart on the table goes where there is room; what touches, overlaps or lies below something else stays together. Plates are
//! filled one after the other, the largest first, as near to each other as models are ever set: most solids are printed upright together,
//! and need no room for the head. Those of a plate that has no plan so are laid out again with the head's own room.

use std::collections::VecDeque;

use super::arrange::{
    Arrangement, Models, NEAREST_MM, ReadModels, SetUp, arranged_aloud, head_reach_mm, laid_out, room_for,
};
use super::error::StrategyError;
use super::loose::Cluster;
use crate::geom::{Bounds, Object, Rigid, Vec3};
use crate::input::{LoadedProfile, ModelSource};
use crate::mesh::{Model, Part, ProjectPlates, TriangleMesh, threemf};
use crate::planning::{Infeasible, MOST_PARTS};
use crate::world::World;

/// Bodies whose sizes differ by less stand in for each other, mm.
const ALIKE_MM: f64 = 1e-6;

/// What is printed in one go.
#[derive(Clone, Debug, PartialEq)]
pub struct PlateModel {
    /// Its model, as 3MF.
    pub bytes: Vec<u8>,
    /// What is on it: models, by the names of their files, each with how many bodies of it.
    pub holds: Vec<(String, usize)>,
    /// How often it is to be printed.
    pub times: usize,
    bodies: Vec<usize>,
    wide: bool,
}

/// Plates that are still to be made.
#[derive(Debug)]
pub struct PlateQueue {
    shapes: Vec<Shape>,
    left: VecDeque<Shared>,
    machine: LoadedProfile,
    gap_mm: Option<f64>,
}

/// What stays together, as it stands, and how often it is wanted.
#[derive(Debug)]
struct Shape {
    file: String,
    parts: Vec<Part>,
    size: Vec3,
    copies: usize,
}

/// Shapes of one plate, each as often as it is on it, ascending; and how often the plate is wanted.
#[derive(Clone, Debug, PartialEq)]
struct Shared {
    bodies: Vec<usize>,
    times: usize,
    wide: bool,
}

impl PlateQueue {
    /// All models on as few plates as are found.
    ///
    /// # Errors
    ///
    /// What reading and setting up each of them may say.
    pub(crate) fn of(
        first: &ModelSource,
        how: &Arrangement,
        machine: LoadedProfile,
        world: &World<'_>,
    ) -> Result<Self, StrategyError> {
        how.check()?;
        let beside = how.beside.iter().map(|(from, copies)| (from, *copies));
        let each = Arrangement { copies: 1, beside: Vec::new(), ..how.clone() };
        let mut shapes = Vec::new();
        for (first, copies) in std::iter::once((first, how.copies)).chain(beside) {
            // What lies on several plates of a project goes onto ours.
            let plates = if first.plates == ProjectPlates::Only { ProjectPlates::All } else { first.plates };
            let first = &ModelSource { plates, ..first.clone() };
            let read = &ReadModels::read(first, &each, world)?;
            let set = |how: &Arrangement| arranged_aloud(&Models { read, how, machine: &machine }, world);
            let SetUp { model, .. } = match set(&each) {
                // On several plates they may be as many.
                Err(StrategyError::Infeasible(Infeasible::TooManyParts { .. })) => {
                    set(&Arrangement { snap_mm: 0.0, ..each.clone() })?
                }
                done => done?,
            };
            let file = first.source.name().rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
            shapes.extend(bodies(&model.model).into_iter().map(|parts| Shape::of(file.clone(), parts, copies)));
        }
        let mut queue = Self { shapes, left: VecDeque::new(), machine, gap_mm: how.gap_mm };
        let wanted = (0..queue.shapes.len()).flat_map(|shape| std::iter::repeat_n(shape, queue.shapes[shape].copies));
        queue.left = queue.shared(wanted.collect(), false).into();
        Ok(queue)
    }

    /// The next.
    pub fn next_plate(&mut self) -> Option<PlateModel> {
        let Shared { bodies, times, wide } = self.left.pop_front()?;
        let stays = Rigid::<Object, Object>::shift(Vec3::zeros());
        let each: Vec<(&[Part], &Rigid<Object, Object>)> =
            bodies.iter().map(|&shape| (&self.shapes[shape].parts[..], &stays)).collect();
        let moved = laid_out(&each, self.gap_mm, &self.machine).moved;
        let numbered = |index: usize, part: &Part| match bodies.len() {
            1 => part.name.clone(),
            _ => format!("{}-{}", index + 1, part.name),
        };
        let parts: Vec<(String, &TriangleMesh<Object>)> = (0..each.len())
            .flat_map(|index| each[index].0.iter().map(move |part| (index, part)).zip(&moved[index]))
            .map(|((index, part), mesh)| (numbered(index, part), mesh))
            .collect();
        let mut holds: Vec<(String, usize)> = Vec::new();
        for &shape in &bodies {
            let file = &self.shapes[shape].file;
            match holds.iter_mut().find(|(name, _)| name == file) {
                Some((_, count)) => *count += 1,
                None => holds.push((file.clone(), 1)),
            }
        }
        Some(PlateModel { bytes: threemf(&parts), holds, times, bodies, wide })
    }

    /// Takes back a plate that has no plan, to lay it out with the head's own room; whether that is another layout.
    pub fn with_more_room(&mut self, plate: &PlateModel) -> bool {
        if plate.wide || plate.bodies.len() < 2 || self.gap_mm.is_some() {
            return false;
        }
        for shared in self.shared(plate.bodies.clone(), true).into_iter().rev() {
            let times = shared.times * plate.times;
            self.left.push_front(Shared { times, ..shared });
        }
        true
    }

    /// Bodies over plates; equal ones are one.
    fn shared(&self, mut bodies: Vec<usize>, wide: bool) -> Vec<Shared> {
        let area = |shape: usize| self.shapes[shape].size.x * self.shapes[shape].size.y;
        bodies.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));
        let mut plates: Vec<Shared> = Vec::new();
        while !bodies.is_empty() {
            let (mut here, mut over): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
            for alike in bodies.chunk_by(|&a, &b| self.is_as_large(a, b)) {
                // What fits by itself nowhere is asked by itself.
                let least = usize::from(here.is_empty());
                let fits = |count: usize| {
                    count <= least || self.fits(&here.iter().chain(&alike[..count]).copied().collect::<Vec<_>>(), wide)
                };
                let count = most(alike.len(), fits);
                here.extend(&alike[..count]);
                over.extend(&alike[count..]);
            }
            here.sort_unstable();
            bodies = over;
            match plates.iter_mut().find(|plate| plate.bodies == here) {
                Some(same) => same.times += 1,
                None => plates.push(Shared { bodies: here, times: 1, wide }),
            }
        }
        plates
    }

    fn is_as_large(&self, a: usize, b: usize) -> bool {
        (self.shapes[a].size - self.shapes[b].size).amax() < ALIKE_MM
    }

    fn fits(&self, bodies: &[usize], wide: bool) -> bool {
        if bodies.iter().map(|&shape| self.shapes[shape].parts.len()).sum::<usize>() > MOST_PARTS {
            return false;
        }
        let sizes = || bodies.iter().map(|&shape| self.shapes[shape].size);
        let gap_mm = self.gap_mm.unwrap_or_else(|| match wide {
            true => head_reach_mm(&self.machine, sizes().map(|size| size.z).fold(0.0, f64::max)).max(NEAREST_MM),
            false => NEAREST_MM,
        });
        let footprints: Vec<[f64; 2]> = sizes().map(|size| [size.x, size.y]).collect();
        room_for(&footprints, gap_mm, &self.machine).is_some()
    }
}

/// The most of `all` for which `fits` holds, which does for fewer as well; asked a few times.
fn most(all: usize, fits: impl Fn(usize) -> bool) -> usize {
    let (mut some, mut step) = (0, 1);
    while step > 0 {
        if some + step <= all && fits(some + step) {
            some += step;
            step *= 2;
        } else {
            // From here on down: a step that was too long is too long for good.
            let mut half = step / 2;
            while half > 0 {
                if some + half <= all && fits(some + half) {
                    some += half;
                }
                half /= 2;
            }
            step = 0;
        }
    }
    some
}

impl Shape {
    fn of(file: String, parts: Vec<Part>, copies: usize) -> Self {
        let size = Bounds::of(parts.iter().flat_map(|part| part.mesh.vertices()).copied()).size();
        Self { file, parts, size, copies }
    }
}

/// How many bodies a model is, and the plates that they take; `None` where it is one body, or where one does not fit by itself.
pub(super) fn plates_of(model: &Model, machine: &LoadedProfile) -> Option<(usize, usize)> {
    let shapes: Vec<Shape> = bodies(model).into_iter().map(|parts| Shape::of(String::new(), parts, 1)).collect();
    let queue = PlateQueue { shapes, left: VecDeque::new(), machine: machine.clone(), gap_mm: None };
    let count = queue.shapes.len();
    let each_fits = (0..count).all(|shape| queue.fits(&[shape], false));
    (count > 1 && each_fits).then(|| (count, queue.shared((0..count).collect(), false).len()))
}

/// The parts that stay together; all of them where one hangs in the air, since what is missing below it nobody knows.
fn bodies(model: &Model) -> Vec<Vec<Part>> {
    let clusters = Cluster::standing(model);
    if clusters.is_empty() {
        return vec![model.parts.clone()];
    }
    clusters.iter().map(|cluster| cluster.parts.iter().map(|&part| model.parts[part].clone()).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::{MachineSource, load_profile};
    use crate::world::Silent;

    /// Boxes of so much, each so often, for a table of 70 mm.
    fn queue(boxes: &[([f64; 3], usize)]) -> PlateQueue {
        let world = World::here(&Silent);
        let machine = load_profile(&MachineSource::Shipped("open5x-prusa".to_owned()), &world).unwrap();
        let shape = |(size, copies): &([f64; 3], usize)| {
            let mesh = crate::fixtures::solid_box(Vec3::zeros(), (*size).into());
            Shape::of("box.stl".to_owned(), Model::from_parts(vec![("box".to_owned(), mesh)]).parts, *copies)
        };
        let mut queue =
            PlateQueue { shapes: boxes.iter().map(shape).collect(), left: VecDeque::new(), machine, gap_mm: None };
        let wanted = (0..boxes.len()).flat_map(|shape| std::iter::repeat_n(shape, boxes[shape].1)).collect();
        queue.left = queue.shared(wanted, false).into();
        queue
    }

    fn all(mut queue: PlateQueue) -> Vec<(usize, usize)> {
        std::iter::from_fn(|| queue.next_plate()).map(|plate| (plate.bodies.len(), plate.times)).collect()
    }

    #[test]
    fn the_most_that_fit_are_found() {
        for limit in 0..40 {
            for all in 0..40 {
                assert_eq!(most(all, |count| count <= limit), all.min(limit), "{all} {limit}");
            }
        }
    }

    #[test]
    fn every_body_is_on_a_plate_and_equal_plates_are_one() {
        assert_eq!(all(queue(&[([20.0, 20.0, 20.0], 40)])), [(4, 10)]);
        assert_eq!(all(queue(&[([20.0, 20.0, 20.0], 9)])), [(4, 2), (1, 1)]);
        let mixed = queue(&[([8.0, 8.0, 5.0], 3), ([40.0, 40.0, 5.0], 2)]);
        let printed: usize = all(mixed).iter().map(|(bodies, times)| bodies * times).sum();
        assert_eq!(printed, 5);
    }

    #[test]
    fn what_fits_on_no_table_is_on_a_plate_by_itself() {
        assert_eq!(all(queue(&[([200.0, 200.0, 5.0], 2)])), [(1, 2)]);
    }

    #[test]
    fn a_plate_without_a_plan_is_laid_out_again_once() {
        let mut queue = queue(&[([20.0, 20.0, 20.0], 8)]);
        let first = queue.next_plate().unwrap();
        assert_eq!((first.bodies.len(), first.times, queue.left.len()), (4, 2, 0));
        assert!(queue.with_more_room(&first));
        let again = queue.next_plate().unwrap();
        assert!(again.bodies.len() < 4 && again.wide && !queue.with_more_room(&again), "{again:?}");
        let rest: usize = std::iter::from_fn(|| queue.next_plate()).map(|plate| plate.bodies.len() * plate.times).sum();
        assert_eq!(again.bodies.len() * again.times + rest, 8);
    }
}
