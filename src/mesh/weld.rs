//! Equal vertices get one number.
//!
//! The table holds numbers alone, 5 bytes an entry with its mark, and looks the coordinates up where they are kept: a table with
//! coordinates for keys takes eight times as much, and a million facets then more than all that is done with them later.

use std::hash::BuildHasher;

use hashbrown::{DefaultHashBuilder, HashTable};

use crate::geom::Vec3;

/// Vertices by their coordinates, numbered in the order in which they come.
#[derive(Default)]
pub(super) struct Welder {
    /// The vertices of all bodies.
    vertices: Vec<Vec3>,
    /// The numbers of those of the current body.
    numbers: HashTable<u32>,
    hasher: DefaultHashBuilder,
}

impl Welder {
    /// One without vertices.
    pub(super) fn new() -> Self {
        Self::default()
    }

    /// What comes from here on is never one with what came before.
    pub(super) fn begin_body(&mut self) {
        // Not cleared: that costs the size of the largest body for each of thousands.
        self.numbers = HashTable::new();
    }

    /// The number of the vertex at `at`, which is new or was there before.
    pub(super) fn number(&mut self, at: Vec3) -> u32 {
        let (vertices, hasher) = (&mut self.vertices, &self.hasher);
        let hash = |v: &Vec3| hasher.hash_one(bits(v));
        let same = |&number: &u32| bits(&vertices[number as usize]) == bits(&at);
        if let Some(&number) = self.numbers.find(hash(&at), same) {
            return number;
        }
        let number = vertices.len() as u32;
        vertices.push(at);
        self.numbers.insert_unique(hash(&at), number, |&number| hash(&vertices[number as usize]));
        number
    }

    /// The vertices, by their numbers.
    pub(super) fn into_vertices(self) -> Vec<Vec3> {
        self.vertices
    }
}

/// For every vertex the first one with the same coordinates, which may be itself.
pub(crate) fn first_of_equals(vertices: &[Vec3]) -> Vec<u32> {
    let hasher = DefaultHashBuilder::default();
    let hash = |index: u32| hasher.hash_one(bits(&vertices[index as usize]));
    let mut firsts = HashTable::with_capacity(vertices.len());
    let first = |index: u32| {
        let same = |&other: &u32| bits(&vertices[other as usize]) == bits(&vertices[index as usize]);
        *firsts.entry(hash(index), same, |&other| hash(other)).or_insert(index).get()
    };
    (0..vertices.len() as u32).map(first).collect()
}

/// Equal for equal coordinates, whatever the sign of a zero.
fn bits(v: &Vec3) -> [u64; 3] {
    [v.x, v.y, v.z].map(|c| (c + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::{Welder, first_of_equals};
    use crate::geom::Vec3;

    #[test]
    fn every_bit_counts_and_bodies_stand_apart() {
        let mut welder = Welder::new();
        let next = Vec3::new(1.0, 2.0, 3.0_f64.next_up());
        assert_eq!([welder.number(Vec3::new(1.0, 2.0, 3.0)), welder.number(next)], [0, 1]);
        assert_eq!([welder.number(next), welder.number(Vec3::new(1.0, 2.0, 3.0))], [1, 0]);
        welder.begin_body();
        assert_eq!([welder.number(next), welder.number(next)], [2, 2]);
        assert_eq!(welder.into_vertices(), [Vec3::new(1.0, 2.0, 3.0), next, next]);
    }

    #[test]
    fn a_table_that_grows_forgets_nothing() {
        let mut welder = Welder::new();
        let at = |i: u32| Vec3::new(f64::from(i % 97), f64::from(i / 97), f64::from(i));
        let first: Vec<u32> = (0..10_000).map(|i| welder.number(at(i))).collect();
        let again: Vec<u32> = (0..10_000).map(|i| welder.number(at(i))).collect();
        assert_eq!(first, again);
        assert_eq!(first, (0..10_000).collect::<Vec<_>>());
    }

    #[test]
    fn the_first_of_equals_speaks_for_all() {
        let at = [0.0, 1.0, -0.0, 1.0, 2.0, 1.0].map(Vec3::repeat);
        assert_eq!(first_of_equals(&at), [0, 1, 0, 1, 4, 1]);
        assert!(first_of_equals(&[]).is_empty());
    }
}
