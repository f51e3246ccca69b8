//! A project's model as its slicer prints it: volumes of one object that overlap are one solid, and what is negative is cut away. Lengths mm, volumes mm³.

use std::collections::BTreeSet;

use super::{FitError, overlap, solid};
use crate::geom::{Bounds, Object, Sets};
use crate::mesh::{Away, BoxTree, DrawnModel, Model, TriangleMesh};

/// Pieces of a part, each with its name.
type Pieces = Vec<(String, TriangleMesh<Object>)>;

/// The model with overlapping volumes of an object made one, and all that is negative cut off from its parts; what was done is told in its
/// warnings.
///
/// A part that falls to pieces becomes several, named after it.
///
/// # Errors
///
/// [`FitError::Failed`] and [`FitError::Away`] where that cannot be done, [`FitError::Nothing`] where nothing is left.
pub fn as_printed(drawn: DrawnModel) -> Result<Model, FitError> {
    let DrawnModel { model, away, objects } = drawn;
    let mut told = Vec::new();
    let mut parts: Vec<Pieces> = model.parts.iter().map(|part| vec![(part.name.clone(), part.mesh.clone())]).collect();
    for object in &objects {
        unite(&model, object, &mut parts, &mut told)?;
    }
    if away.is_empty() && told.is_empty() {
        return Ok(model);
    }
    for one in &away {
        cut(one, &model, &mut parts, &mut told)?;
    }
    let mut once = BTreeSet::new();
    told.retain(|text| once.insert(text.clone()));
    let parts: Pieces = parts.into_iter().flatten().collect();
    if parts.is_empty() {
        let away = away.iter().map(|one| one.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(FitError::Nothing { away });
    }
    let mut cut = Model::from_parts(parts);
    cut.unit = model.unit;
    cut.others.clone_from(&model.others);
    // What overlapped is one by now.
    let united = |text: &&String| objects.is_empty() || !crate::mesh::is_overlap(text);
    let before = model.warnings_in_any_pose().filter(united).cloned();
    cut.warnings = before.chain(told).chain(std::mem::take(&mut cut.warnings)).collect();
    Ok(cut)
}

/// Makes one of the volumes of an object that overlap: the first of them. What only touches stays apart, as any assembly.
fn unite(model: &Model, object: &[usize], parts: &mut [Pieces], told: &mut Vec<String>) -> Result<(), FitError> {
    let mut sets = Sets::new(model.parts.len());
    let bounds: Vec<Bounds> = object.iter().map(|&part| model.parts[part].mesh.bounds()).collect();
    let trees: Vec<BoxTree> = object.iter().map(|&part| BoxTree::new(&model.parts[part].mesh)).collect();
    for (index, &b) in object.iter().enumerate() {
        for &a in object[..index].iter().zip(&bounds).filter(|(_, one)| one.meets(&bounds[index])).map(|(a, _)| a) {
            let (into, from) = (sets.root(a as u32) as usize, sets.root(b as u32) as usize);
            if into == from || !overlap(&model.parts[a], &model.parts[b], &trees[index]) {
                continue;
            }
            let (into, from) = (into.min(from), into.max(from));
            let [(name_a, one)] = &parts[into][..] else { continue };
            let [(name_b, two)] = &parts[from][..] else { continue };
            let failed =
                |why| FitError::Failed { a: into, name_a: name_a.clone(), b: from, name_b: name_b.clone(), why };
            let mesh = solid::joined_with(one, two).map_err(failed)?;
            told.push(format!("{name_a} and {name_b} overlap, and are printed as one solid"));
            parts[into][0].1 = mesh;
            parts[from].clear();
            // The lower number stands for both.
            sets.join(into as u32, from as u32);
        }
    }
    Ok(())
}

fn cut(one: &Away, model: &Model, parts: &mut [Pieces], told: &mut Vec<String>) -> Result<(), FitError> {
    let mut meets = false;
    for &id in &one.parts {
        let failed = |why| FitError::Away { part: id, name: model.parts[id].name.clone(), away: one.name.clone(), why };
        let mut left = Vec::new();
        for (name, mesh) in std::mem::take(&mut parts[id]) {
            let (pieces, volume_mm3) = solid::without(&mesh, &one.mesh).map_err(failed)?;
            meets |= volume_mm3 > 0.0;
            if pieces.is_empty() {
                told.push(format!("nothing is left of {name}: all of it is removed by {}", one.name));
            } else if volume_mm3 > 0.0 {
                told.push(format!("{volume_mm3:.2} mm3 of {name} are removed by {}", one.name));
            }
            let named = |(i, piece)| (if i == 0 { name.clone() } else { format!("{name} {}", i + 1) }, piece);
            left.extend(pieces.into_iter().enumerate().map(named));
        }
        parts[id] = left;
    }
    if !meets {
        told.push(format!("{} removes nothing: it overlaps no part of its object", one.name));
    }
    Ok(())
}
