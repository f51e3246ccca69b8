//! Nearly convex pieces of a model: their hulls as bodies of their own, for simulators and other programs that know convex bodies only.

use crate::geom::{Object, Vec3};
use crate::input::{BadSetting, InputError, ModelSource, load_aloud};
use crate::mesh::{TriangleMesh, pieces, threemf};
use crate::pictures::{self, KINDS, coloured};
use crate::spelling::counted;
use crate::view::Drawing;
use crate::world::World;

/// A model, and how far its pieces may be from convex.
#[derive(Clone, Debug)]
pub struct ConvexRequest {
    /// The model: one or several closed parts.
    pub model: ModelSource,
    /// How far a piece may be from convex, mm; `None`: a hundredth of each part's box's diagonal.
    pub concavity_mm: Option<f64>,
}

/// How far a piece may be from convex where nothing is said, of the diagonal of the part's box.
const SHARE: f64 = 0.01;
/// The most that may be asked for, mm.
const MOST_MM: f64 = 1e4;

/// A hull around a piece, the file's frame, mm.
#[derive(Clone, Debug)]
pub struct HullOfPiece {
    /// The part's name and the piece's number.
    pub name: String,
    /// The part, from 0.
    pub part: usize,
    /// How many of the part's facets lie in it.
    pub facets: usize,
    /// How far those are from convex, mm.
    pub concavity_mm: f64,
    /// What it encloses, mm³; 0 where all of it lies in one plane.
    pub volume_mm3: f64,
    /// The hull; without facets where all of it lies in one plane.
    mesh: TriangleMesh<Object>,
}

/// The pieces of a model.
#[derive(Clone, Debug)]
pub struct ConvexResult {
    /// The pieces, part by part.
    pub pieces: Vec<HullOfPiece>,
    /// The largest of what was allowed for each part, mm.
    pub concavity_mm: f64,
    /// What the model encloses, mm³.
    pub volume_mm3: f64,
    /// What it took.
    pub seconds: f64,
}

/// Takes a model apart into nearly convex pieces. All hulls together hold the surface; the inside of a thick body may lie in none.
///
/// # Errors
///
/// [`InputError::Setting`] for a concavity that is not from 0 to 10,000 mm; what reading the model may say.
pub fn convex(request: &ConvexRequest, world: &World<'_>) -> Result<ConvexResult, InputError> {
    if let Some(mm) = request.concavity_mm {
        BadSetting::within("concavity", mm, " mm", [0.0, MOST_MM])?;
    }
    let start = world.clock.now();
    let loaded = load_aloud(&request.model, world)?;
    let (mut all, mut most, mut volume_mm3) = (Vec::new(), 0.0_f64, 0.0);
    for (part, own) in loaded.model.parts.iter().enumerate() {
        let allowed = request.concavity_mm.unwrap_or_else(|| SHARE * own.mesh.bounds().size().norm());
        most = most.max(allowed);
        volume_mm3 += own.mesh.volume();
        all.extend(pieces(&own.mesh, allowed).into_iter().enumerate().map(|(index, piece)| HullOfPiece {
            name: format!("{}-{:03}", own.name, index + 1),
            part,
            facets: piece.facets.len(),
            concavity_mm: piece.concavity_mm,
            // Of a flat one it is 0, never -0.
            volume_mm3: piece.hull.volume() + 0.0,
            mesh: TriangleMesh::new(piece.hull.points, piece.hull.faces),
        }));
    }
    let seconds = (world.clock.now() - start).as_secs_f64();
    Ok(ConvexResult { pieces: all, concavity_mm: most, volume_mm3, seconds })
}

impl HullOfPiece {
    /// Whether all of it lies in one plane: then it is no body, and in no file.
    pub fn is_flat(&self) -> bool {
        self.mesh.facets().is_empty()
    }

    /// The low and the high corner of the box around it, mm.
    pub fn box_mm(&self) -> [Vec3; 2] {
        let bounds = self.mesh.bounds();
        [bounds.min, bounds.max]
    }
}

impl ConvexResult {
    fn bodies(&self) -> impl Iterator<Item = &HullOfPiece> {
        self.pieces.iter().filter(|piece| !piece.is_flat())
    }

    /// The hulls as 3MF, mm: those that are bodies, in the file's own frame.
    pub fn threemf(&self) -> Vec<u8> {
        threemf(&self.bodies().map(|piece| (piece.name.clone(), &piece.mesh)).collect::<Vec<_>>())
    }

    /// The hulls in a few colours.
    pub fn view(&self) -> Drawing {
        let solids = self.bodies().enumerate().map(|(i, piece)| coloured(&piece.mesh, KINDS[i % KINDS.len()], None));
        let story =
            format!("{}, each at most {:.3} mm from convex", counted(self.pieces.len(), "piece"), self.concavity_mm);
        pictures::solids("Convex pieces", solids.collect(), vec![], vec![story], false).drawing()
    }

    /// The result for people.
    pub fn text(&self) -> String {
        let hulls: f64 = self.pieces.iter().map(|piece| piece.volume_mm3).sum();
        let flat = self.pieces.iter().filter(|piece| piece.is_flat()).count();
        let flat = if flat > 0 { format!(", {flat} of them flat and not written") } else { String::new() };
        format!(
            "{}{flat}, each at most {:.3} mm from convex; hulls of {hulls:.1} mm3, the model has {:.1} mm3; {:.2} s",
            counted(self.pieces.len(), "piece"),
            self.concavity_mm,
            self.volume_mm3,
            self.seconds
        )
    }
}
