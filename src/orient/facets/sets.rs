//! Which facets see each other: the connectivity sets of Boogers (2024), section 4.1.

use rayon::prelude::*;

use super::{Facets, Tree};

/// For every facet `i` the facets `j` with `(c_j - c_i).n_i > 0` and a free line of sight from centre to centre.
///
/// A line that leaves the material at `i` and is free must enter it at `j`, so on a closed mesh the set is mutual and each
/// pair is looked at once.
#[derive(Clone, Debug)]
pub(crate) struct Sets {
    /// Where each facet's set begins in `others`, and the end.
    starts: Vec<u32>,
    others: Vec<u32>,
    /// One by the distance to each of them, 1/mm.
    inverse: Vec<f64>,
}

impl Sets {
    pub(crate) fn of(facets: &Facets) -> Self {
        let tree = Tree::of(facets);
        let count = facets.each.len();
        let later: Vec<Vec<u32>> = (0..count).into_par_iter().map(|i| seen_after(facets, &tree, i)).collect();
        let mut sizes: Vec<u32> = later.iter().map(|set| set.len() as u32).collect();
        later.iter().flatten().for_each(|&j| sizes[j as usize] += 1);
        let mut starts = vec![0; count + 1];
        (0..count).for_each(|i| starts[i + 1] = starts[i] + sizes[i]);
        let (mut others, mut inverse) = (vec![0; starts[count] as usize], vec![0.0; starts[count] as usize]);
        let mut next = starts.clone();
        let mut put = |i: usize, j: u32| {
            let place = next[i] as usize;
            let between = facets.each[j as usize].barycentre - facets.each[i].barycentre;
            (others[place], inverse[place]) = (j, 1.0 / between.norm());
            next[i] += 1;
        };
        for (i, set) in later.iter().enumerate() {
            for &j in set {
                put(i, j);
                put(j as usize, i as u32);
            }
        }
        Self { starts, others, inverse }
    }

    /// The set of facet `i`.
    pub(crate) fn of_facet(&self, i: usize) -> &[u32] {
        &self.others[self.range(i)]
    }

    /// The set of facet `i`, each with one by its distance.
    pub(crate) fn with_inverse(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let others = self.others[self.range(i)].iter().map(|j| *j as usize);
        others.zip(self.inverse[self.range(i)].iter().copied())
    }

    fn range(&self, i: usize) -> std::ops::Range<usize> {
        self.starts[i] as usize..self.starts[i + 1] as usize
    }
}

/// Of the facets after `i` those that it sees.
fn seen_after(facets: &Facets, tree: &Tree, i: usize) -> Vec<u32> {
    let one = &facets.each[i];
    let sees = |j: &usize| {
        let other = &facets.each[*j];
        let between = other.barycentre - one.barycentre;
        between.dot(&one.area) > 0.0
            && between.dot(&other.area) < 0.0
            && !tree.blocks(&one.barycentre, &other.barycentre, [i as u32, *j as u32])
    };
    (i + 1..facets.each.len()).filter(sees).map(|j| j as u32).collect()
}
