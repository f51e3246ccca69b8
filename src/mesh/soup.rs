//! What a reader hands over: facets in file order, not yet welded.

use super::Unit;
use super::weld::Welder;
use crate::geom::Vec3;

/// The most facets of one model; above it only a hostile file's repeated components go.
pub(super) const MAX_FACETS: usize = 50_000_000;

/// A name in the file for a stretch of facets.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Label {
    /// The name as written; `None` where the format has none.
    pub(super) name: Option<String>,
    /// Facets of different bodies never belong to one part, even where they touch (3MF objects).
    pub(super) body: u32,
    /// The placed object that it is of.
    pub(super) object: u32,
    /// Whether it is to be cut away from the parts of its object.
    pub(super) away: bool,
}

/// A volume of a file that is not printed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OtherVolume {
    /// The file's name for it; empty where it has none.
    pub name: String,
    /// What it is for: `negative`, `modifier`, `blocker`, `enforcer`, `support`, `other`, `unprinted`, `off-plate`.
    pub role: &'static str,
}

/// Facets in file order with their labels; vertices may repeat.
#[derive(Clone, Debug, Default)]
pub(super) struct Soup {
    /// Vertices in file units, all finite, no -0.0.
    pub(super) vertices: Vec<Vec3>,
    /// Vertex indices, all in range.
    pub(super) facets: Vec<[u32; 3]>,
    /// For every facet an index into `names`.
    pub(super) labels: Vec<u32>,
    /// The labels; bodies do not decrease.
    pub(super) names: Vec<Label>,
    /// The unit the file states.
    pub(super) unit: Option<Unit>,
    /// What was passed over while reading.
    pub(super) warnings: Vec<String>,
    /// Volumes that are not printed.
    pub(super) others: Vec<OtherVolume>,
    /// Whether it is a slicer's project: what is of one object is one solid where it overlaps.
    pub(super) is_project: bool,
}

impl Label {
    /// What a volume is called that is to be cut away.
    pub(super) fn away_called(&self) -> String {
        self.name.clone().unwrap_or_else(|| "a negative volume".to_owned())
    }
}

impl Soup {
    /// A soup with one nameless label, for formats without names.
    pub(super) fn nameless() -> Self {
        Self { names: vec![Label::default()], ..Self::default() }
    }

    /// Appends a facet under the newest label.
    pub(super) fn push(&mut self, facet: [u32; 3]) {
        self.facets.push(facet);
        self.labels.push(self.names.len().saturating_sub(1) as u32);
    }

    /// Appends a polygon as a fan from its first corner.
    pub(super) fn push_fan(&mut self, corners: &[u32]) {
        for pair in corners.windows(2).skip(1) {
            self.push([corners[0], pair[0], pair[1]]);
        }
    }

    /// Merges vertices of one body that agree in every bit and drops facets that then name one vertex twice.
    /// Vertices are numbered in the order of their first use. Returns the number of facets dropped.
    pub(super) fn weld(&mut self) -> usize {
        let given = self.facets.len();
        let mut welder = Welder::new();
        let (mut kept, mut current) = (0, None);
        for index in 0..given {
            let body = self.names[self.labels[index] as usize].body;
            if current.replace(body) != Some(body) {
                welder.begin_body();
            }
            let facet = self.facets[index].map(|i| welder.number(self.vertices[i as usize]));
            if facet[0] != facet[1] && facet[1] != facet[2] && facet[2] != facet[0] {
                self.facets[kept] = facet;
                self.labels[kept] = self.labels[index];
                kept += 1;
            }
        }
        self.facets.truncate(kept);
        self.labels.truncate(kept);
        self.vertices = welder.into_vertices();
        given - kept
    }
}

#[cfg(test)]
mod tests {
    use super::{Label, Soup};
    use crate::geom::Vec3;

    #[test]
    fn welds_equal_bits_and_drops_facets_that_collapse() {
        let mut soup = Soup::nameless();
        let at = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
        soup.vertices = at.map(Vec3::from).to_vec();
        soup.push([0, 1, 2]);
        soup.push([1, 3, 2]);
        soup.push([3, 4, 2]);
        assert_eq!(soup.weld(), 1);
        assert_eq!(soup.facets, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(soup.vertices.len(), 4);
        assert_eq!(soup.labels, [0, 0]);
    }

    #[test]
    fn bodies_keep_their_vertices_apart() {
        let mut soup = Soup::nameless();
        soup.vertices = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
        soup.push([0, 1, 2]);
        soup.names.push(Label { body: 1, ..Label::default() });
        soup.push([0, 1, 2]);
        assert_eq!(soup.weld(), 0);
        assert_eq!(soup.facets, [[0, 1, 2], [3, 4, 5]]);
    }

    #[test]
    fn a_polygon_fans_from_its_first_corner() {
        let mut soup = Soup::nameless();
        soup.push_fan(&[4, 5, 6, 7, 8]);
        assert_eq!(soup.facets, [[4, 5, 6], [4, 6, 7], [4, 7, 8]]);
    }
}
