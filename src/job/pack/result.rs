//! What a packing comes to: plates with their pieces, as values, text, files and a picture.

use std::path::Path;

use super::{Asked, Coarsened};
use crate::geom::{Bounds, Slot, Vec3};
use crate::input::LoadedModel;
use crate::mesh::{TriangleMesh, threemf};
use crate::pack::{BoxPacking, Ended, Instance, Lift, PackGoal, PackSolid, Packed, Put, Room, axis_and_angle, volume};
use crate::pictures::{self, KINDS, coloured};
use crate::spelling::counted;
use crate::view::Drawing;

/// Units of a length in a millimetre: micrometres.
pub(super) const UNITS: f64 = 1000.0;

/// A packing that passed the independent test.
#[derive(Clone, Debug)]
pub struct PackResult {
    /// The runs.
    pub plates: Vec<Plate>,
    /// What was looked for.
    pub goal: PackGoal,
    /// [`PackGoal::Runs`]: no packing has fewer runs. [`PackGoal::Filling`]: none has more value. [`PackGoal::Height`]: none is lower, mm.
    pub bound: f64,
    /// What one run holds ([`PackGoal::Filling`]).
    pub value: f64,
    /// Why the search ended.
    pub ended: Ended,
    /// The method.
    pub method: &'static str,
    /// The space of a run, mm; with [`PackGoal::Height`] as high as the highest piece reaches.
    pub space_mm: [f64; 3],
    /// The gap that was kept, mm.
    pub gap_mm: f64,
    /// The least distance between two pieces, mm, where it is less than twice the gap.
    pub clearance_mm: Option<f64>,
    /// Models or lines with how many of each are in no run.
    pub left_out: Vec<(String, usize)>,
    /// How much coarser the meshes were that were packed for the models, where that was asked for.
    pub inflated: Option<Coarsened>,
    /// What it took.
    pub seconds: f64,
    /// What it was to take at most, s.
    pub limit_s: Option<f64>,
    /// What reading the models took of it, s.
    pub reading_s: f64,
    /// What the exact test of the models took, s.
    pub testing_s: f64,
}

/// One run.
#[derive(Clone, Debug)]
pub struct Plate {
    /// What of its space is filled; where parts overlap, twice.
    pub fill: f64,
    /// Its pieces.
    pub pieces: Vec<Piece>,
    /// In which order they lift out straight up, by their places.
    pub lift_order: Vec<usize>,
    /// Pieces that are not shown to come out so.
    pub locked: Vec<usize>,
}

/// A model or a box in its place.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The model's file, or the line.
    pub name: String,
    /// The model or line, from 0.
    pub model: usize,
    /// Which of its copies, from 0.
    pub copy: usize,
    /// Where the file's origin comes, mm; a box's low corner.
    pub origin_mm: Vec3,
    /// The axis about which it is turned.
    pub axis: Vec3,
    /// By how much, degrees.
    pub turn_deg: f64,
    /// The box around it, mm.
    pub bounds: Bounds,
    /// Its parts by name, as they stand.
    parts: Vec<(String, TriangleMesh<Slot>)>,
}

pub(super) fn of_models(
    models: &[(LoadedModel, usize)],
    solids: &[PackSolid],
    room: &Room,
    packed: &Packed,
    lifts: Vec<Lift>,
    clearance_mm: Option<f64>,
    asked: &Asked<'_>,
) -> PackResult {
    let mut space_mm = room.space_mm;
    if asked.goal == PackGoal::Height {
        let tops = packed.put.iter().map(|p| solids[p.model].bounds(&p.turn).max.z + p.shift.z);
        space_mm[2] = tops.fold(0.0, f64::max);
    }
    let space: f64 = space_mm.iter().product();
    let plates = (0..packed.runs).zip(lifts).map(|(run, lift)| {
        let own: Vec<usize> = (0..packed.put.len()).filter(|&i| packed.put[i].run == run).collect();
        let place = |all: Vec<usize>| all.iter().filter_map(|i| own.iter().position(|o| o == i)).collect();
        let pieces: Vec<Piece> = own.iter().map(|&i| piece(&models[packed.put[i].model].0, &packed.put[i])).collect();
        let parts = pieces.iter().flat_map(|piece| &piece.parts);
        Plate {
            fill: parts.map(|(_, mesh)| mesh.volume()).sum::<f64>() / space,
            pieces,
            lift_order: place(lift.order),
            locked: place(lift.locked),
        }
    });
    let names: Vec<(String, usize)> = models.iter().map(|(model, count)| (model.file.clone(), *count)).collect();
    let plates: Vec<Plate> = plates.collect();
    PackResult {
        goal: asked.goal,
        bound: packed.bound,
        value: packed.put.iter().map(|p| solids[p.model].value).sum(),
        ended: packed.ended,
        method: asked.name,
        space_mm,
        gap_mm: room.gap_mm,
        clearance_mm,
        left_out: left_out(&names, &plates),
        plates,
        inflated: None,
        seconds: 0.0,
        limit_s: None,
        reading_s: 0.0,
        testing_s: 0.0,
    }
}

fn piece(model: &LoadedModel, put: &Put) -> Piece {
    let moved = |mesh: &TriangleMesh| {
        let vertices = mesh.vertices().iter().map(|v| put.turn * v + put.shift).collect();
        TriangleMesh::new(vertices, mesh.facets().to_vec())
    };
    let parts: Vec<(String, TriangleMesh<Slot>)> =
        model.model.parts.iter().map(|part| (part.name.clone(), moved(&part.mesh))).collect();
    let (axis, turn_deg) = axis_and_angle(&put.turn);
    Piece {
        name: model.file.clone(),
        model: put.model,
        copy: put.copy,
        origin_mm: put.shift,
        axis,
        turn_deg,
        bounds: parts.iter().fold(Bounds::EMPTY, |all, (_, mesh)| all.union(&mesh.bounds())),
        parts,
    }
}

pub(super) fn of_boxes(
    instance: &Instance,
    lines: &[(String, usize)],
    of: &[usize],
    answer: &BoxPacking,
    asked: &Asked<'_>,
) -> PackResult {
    let mm = |units: [i64; 3]| Vec3::from(units.map(|u| u as f64 / UNITS));
    let mut plates: Vec<Plate> = Vec::new();
    for run in 0..answer.runs {
        let mut own: Vec<_> = answer.placed.iter().filter(|p| p.run == run).collect();
        own.sort_by_key(|p| p.item);
        let pieces = own.iter().map(|p| {
            let line = of[p.item];
            let (axis, turn_deg) = turn_of(instance.items[p.item].size, p.size);
            let bounds = Bounds { min: mm(p.at), max: mm(p.at) + mm(p.size) };
            let copy = p.item - of.partition_point(|&l| l < line);
            let name = format!("box-{}", line + 1);
            let parts = vec![(name, TriangleMesh::cuboid(&bounds))];
            let name = lines[line].0.clone();
            Piece { name, model: line, copy, origin_mm: bounds.min, axis: axis.into(), turn_deg, bounds, parts }
        });
        let pieces: Vec<Piece> = pieces.collect();
        // A box comes out once nothing stands above it: the highest tops first do.
        let mut lift_order: Vec<usize> = (0..own.len()).collect();
        lift_order.sort_by_key(|&i| (-(own[i].at[2] + own[i].size[2]), i));
        let fill = own.iter().map(|p| volume(&p.size)).sum::<f64>() / volume(&instance.space);
        plates.push(Plate { fill, pieces, lift_order, locked: Vec::new() });
    }
    PackResult {
        goal: asked.goal,
        bound: if asked.goal == PackGoal::Height { answer.bound / UNITS } else { answer.bound },
        value: instance.value(&answer.placed),
        ended: answer.ended,
        method: asked.name,
        space_mm: instance.space.map(|units| units as f64 / UNITS),
        gap_mm: instance.gap as f64 / UNITS,
        clearance_mm: None,
        left_out: left_out(lines, &plates),
        plates,
        inflated: None,
        seconds: 0.0,
        limit_s: None,
        reading_s: 0.0,
        testing_s: 0.0,
    }
}

fn left_out(asked: &[(String, usize)], plates: &[Plate]) -> Vec<(String, usize)> {
    let placed = |model: usize| plates.iter().flat_map(|p| &p.pieces).filter(|p| p.model == model).count();
    let left = asked.iter().enumerate().map(|(model, (name, count))| (name.clone(), count - placed(model)));
    left.filter(|(_, count)| *count > 0).collect()
}

impl PackResult {
    /// Moves everything from a space that begins at the origin to one about it.
    pub(super) fn about_middle(&mut self, half: f64) {
        let by = Vec3::new(-half, -half, 0.0);
        for piece in self.plates.iter_mut().flat_map(|plate| &mut plate.pieces) {
            piece.origin_mm += by;
            piece.bounds = Bounds { min: piece.bounds.min + by, max: piece.bounds.max + by };
            for (_, mesh) in &mut piece.parts {
                let vertices = mesh.vertices().iter().map(|v| v + by).collect();
                *mesh = TriangleMesh::new(vertices, mesh.facets().to_vec());
            }
        }
    }

    /// A run as 3MF, mm: the parts of its pieces by their own names, as they lie in the space.
    pub fn threemf(&self, plate: usize) -> Vec<u8> {
        let parts = self.plates[plate].pieces.iter().flat_map(|piece| &piece.parts);
        threemf(&parts.map(|(name, mesh)| (name.clone(), mesh)).collect::<Vec<_>>())
    }

    /// Whether somebody asked for an end before the search was through.
    pub fn interrupted(&self) -> bool {
        self.ended == Ended::Interrupted
    }

    /// The name of a run's file.
    pub fn file(plate: usize) -> String {
        format!("plate-{:02}.3mf", plate + 1)
    }

    /// All runs beside each other along X, pieces named and in a few colours.
    pub fn view(&self) -> Drawing {
        let apart = 1.15 * self.space_mm[0];
        let mut solids = Vec::new();
        for (run, plate) in self.plates.iter().enumerate() {
            for (index, piece) in plate.pieces.iter().enumerate() {
                for (_, mesh) in &piece.parts {
                    let name = Path::new(&piece.name).file_stem().and_then(|stem| stem.to_str());
                    let mut surface = coloured(mesh, KINDS[index % KINDS.len()], name.or(Some(&piece.name)));
                    surface.points.iter_mut().for_each(|p| p.x += run as f64 * apart);
                    solids.push(surface);
                }
            }
        }
        let [x, y, z] = self.space_mm;
        let story = format!("{} of {x} x {y} x {z} mm", counted(self.plates.len(), "run"));
        pictures::solids("Models in their runs", solids, vec![], vec![story], false).drawing()
    }

    /// Why the search ended, in words.
    pub fn end(&self) -> &'static str {
        match self.ended {
            Ended::Proved => "proved best",
            Ended::Steps => "the best found within the step limit",
            Ended::Time => "the best found within the time limit",
            Ended::Interrupted => "interrupted: the best so far",
        }
    }
}

/// The turn that gives a box of `size` the lengths `turned`, as the one about an axis by so many degrees.
fn turn_of(size: [i64; 3], turned: [i64; 3]) -> ([f64; 3], f64) {
    let [w, d, h] = size;
    let third = 1.0 / 3.0_f64.sqrt();
    let turns: [([i64; 3], [f64; 3], f64); 6] = [
        (size, [0.0, 0.0, 1.0], 0.0),
        ([d, w, h], [0.0, 0.0, 1.0], 90.0),
        ([w, h, d], [1.0, 0.0, 0.0], 90.0),
        ([h, d, w], [0.0, 1.0, 0.0], 90.0),
        ([h, w, d], [third; 3], 120.0),
        ([d, h, w], [third; 3], -120.0),
    ];
    let found = turns.iter().find(|(lengths, ..)| *lengths == turned);
    found.map_or(([0.0, 0.0, 1.0], 0.0), |(_, axis, degrees)| (*axis, *degrees))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pack::Turns;

    #[test]
    fn a_turn_gives_the_lengths_that_it_says() {
        let size = [2, 3, 5];
        for turned in Turns::Any.sizes(size) {
            let (axis, degrees) = turn_of(size, turned);
            let turn = nalgebra::Rotation3::new(Vec3::from(axis) * f64::to_radians(degrees));
            let got = (turn * Vec3::new(2.0, 3.0, 5.0)).map(|v| v.abs().round() as i64);
            assert_eq!(<[i64; 3]>::from(got), turned);
        }
    }
}
