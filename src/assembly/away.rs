//! Volumes that are cut away from the parts that they meet: a project's negative volumes. Lengths mm, volumes mm³.

use super::{FitError, solid};
use crate::mesh::{Away, Model};

/// The model with all of `away` cut off from its parts; what was cut is told in its warnings.
///
/// A part that falls to pieces becomes several, named after it.
///
/// # Errors
///
/// [`FitError::Away`] where that cannot be done, [`FitError::Nothing`] where nothing is left.
pub fn cut_away(model: Model, away: &[Away]) -> Result<Model, FitError> {
    let mut parts: Vec<Vec<_>> = model.parts.iter().map(|part| vec![(part.name.clone(), part.mesh.clone())]).collect();
    let mut told = Vec::new();
    for one in away {
        for &id in &one.parts {
            let failed =
                |why| FitError::Away { part: id, name: model.parts[id].name.clone(), away: one.name.clone(), why };
            let mut left = Vec::new();
            for (name, mesh) in std::mem::take(&mut parts[id]) {
                let (pieces, volume_mm3) = solid::without(&mesh, &one.mesh).map_err(failed)?;
                if volume_mm3 > 0.0 {
                    told.push(format!("{volume_mm3:.2} mm3 of {name} are removed by {}", one.name));
                }
                let named = |(i, piece)| (if i == 0 { name.clone() } else { format!("{name} {}", i + 1) }, piece);
                left.extend(pieces.into_iter().enumerate().map(named));
            }
            parts[id] = left;
        }
    }
    let parts: Vec<_> = parts.into_iter().flatten().collect();
    if parts.is_empty() {
        let away = away.iter().map(|one| one.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(FitError::Nothing { away });
    }
    let mut cut = Model::from_parts(parts);
    cut.unit = model.unit;
    let before = model.warnings_in_any_pose().cloned();
    cut.warnings = before.chain(told).chain(std::mem::take(&mut cut.warnings)).collect();
    Ok(cut)
}
