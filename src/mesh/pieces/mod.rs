//! Nearly convex pieces of a surface, and the hull of each (mm, the mesh's own frame).
//!
//! Facets are gathered, two neighbouring groups at a time, by the cost `E = C / D + alpha E_shape` of the group that comes of it:
//! `C` its concavity, `D` the diagonal of the mesh's box, `E_shape = perimeter^2 / (4 pi area)` (1 for a disc) and
//! `alpha = eps / (10 D)`, so that shape matters only as long as all is as good as convex. A group that would be more concave than
//! `eps` is not made. The least cost comes first, ties by the groups' numbers: the same mesh gives the same bytes.
//!
//! The concavity is how far one comes from a place on the surface along its facet's normal before one leaves the group's hull, at
//! most: asked at the corners of each facet and at its centre. On a facet that way is a concave function (the hull is convex, the
//! direction fixed), so nowhere is it more than three times what it is at the centre.
//!
//! **Promised:** each facet lies in the hull of its own piece, since its three corners do; so all hulls together hold the surface.
//! **Not promised:** that they hold what is inside. Hulls of a thick body's sides may leave its middle empty. For the distance of two
//! closed solids that do not overlap that is enough: the nearest points lie on their surfaces, and the hulls' distance is never more
//! than theirs (less by at most what the hulls add). Where a body may lie wholly inside another one, that has to be asked apart, as
//! by a winding number.
//!
//! Groups grow across edges only: shells are never joined, and of a thin wall's two sides each may get pieces of its own.
//!
//! `trunnion split --convex` writes the hulls. Neither packing nor planning asks them: `benches/pieces.rs` holds them against their trees of boxes.
//!
//! Source: K. Mamou and F. Ghorbel, "A simple and efficient approach for 3D mesh approximate convex decomposition", ICIP 2009, 3501;
//! Leitereg (2020), section 2.5 (which takes `D` of each group; the paper normalises once, and so is it here).

mod cluster;
mod merge;
#[cfg(test)]
mod tests;

use super::TriangleMesh;
use crate::geom::{Hull, Vec3};

/// Facets that are nearly convex together.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexPiece {
    /// Their numbers in the mesh, ascending.
    pub facets: Vec<u32>,
    /// Their hull, mm; flat, without faces, where all of them lie in one plane.
    pub hull: Hull,
    /// How far they are from being convex, mm: at most what was asked for.
    pub concavity_mm: f64,
}

/// The nearly convex pieces of a mesh, each at most `concavity_mm` from convex, in the order of their first facets.
///
/// Every facet is in one piece, also those without an area. A mesh that is not closed is taken as it is: across an open edge nothing is
/// joined. With a `concavity_mm` of 0 only what is convex to rounding (a millionth of the mesh's size) is joined.
///
/// Time: some `n log n` for what is round or flat; at worst the square of the facets, in a single piece that is neither.
pub fn pieces<F>(mesh: &TriangleMesh<F>, concavity_mm: f64) -> Vec<ConvexPiece> {
    let groups = merge::groups(mesh, concavity_mm.max(0.0));
    groups
        .into_iter()
        .map(|(facets, concavity_mm)| ConvexPiece { hull: hull_of(mesh, &facets), facets, concavity_mm })
        .collect()
}

/// The hull of some facets' corners, each corner once.
fn hull_of<F>(mesh: &TriangleMesh<F>, facets: &[u32]) -> Hull {
    let mut corners: Vec<u32> = facets.iter().flat_map(|&f| mesh.facets()[f as usize]).collect();
    corners.sort_unstable();
    corners.dedup();
    let points: Vec<Vec3> = corners.into_iter().map(|i| mesh.vertices()[i as usize]).collect();
    Hull::of(&points).pruned()
}
