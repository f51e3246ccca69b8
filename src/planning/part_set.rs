//! Sets of parts as bits: the search asks for them millions of times.

/// A set of part ids.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct PartSet(Vec<u64>);

impl PartSet {
    /// The empty set with room for `count` parts.
    pub fn new(count: usize) -> Self {
        Self(vec![0; count.div_ceil(64)])
    }

    /// Adds `part`.
    pub fn insert(&mut self, part: usize) {
        self.0[part / 64] |= 1 << (part % 64);
    }

    /// Takes `part` out.
    pub fn remove(&mut self, part: usize) {
        self.0[part / 64] &= !(1 << (part % 64));
    }

    /// Whether `part` is in it.
    pub fn has(&self, part: usize) -> bool {
        self.0[part / 64] >> (part % 64) & 1 == 1
    }

    /// Whether the two share a part.
    pub fn meets(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).any(|(a, b)| a & b != 0)
    }

    /// Whether all its parts are in `other`.
    pub fn within(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|(a, b)| a & !b == 0)
    }

    /// The parts, ascending.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().enumerate().flat_map(|(word, &bits)| bits_of(bits).map(move |bit| word * 64 + bit))
    }

    /// The parts of both, ascending.
    pub fn shared<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = usize> + 'a {
        let words = self.0.iter().zip(&other.0).enumerate();
        words.flat_map(|(word, (a, b))| bits_of(a & b).map(move |bit| word * 64 + bit))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.iter().map(|w| w.count_ones() as usize).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(|&w| w == 0)
    }

    /// Both together.
    pub fn union(&self, other: &Self) -> Self {
        Self(self.0.iter().zip(&other.0).map(|(a, b)| a | b).collect())
    }
}

/// The places of the bits that are set, ascending.
fn bits_of(bits: u64) -> impl Iterator<Item = usize> {
    let left = |bits: &u64| Some(*bits).filter(|bits| *bits != 0);
    std::iter::successors(left(&bits), move |bits| left(&(bits & (bits - 1))))
        .map(|bits| bits.trailing_zeros() as usize)
}

#[cfg(test)]
mod tests {
    use super::PartSet;

    #[test]
    fn holds_parts_across_words() {
        let mut set = PartSet::new(130);
        for part in [0, 63, 64, 129] {
            set.insert(part);
        }
        assert_eq!(set.iter().collect::<Vec<_>>(), vec![0, 63, 64, 129]);
        let mut other = PartSet::new(130);
        [1, 63, 100, 129].into_iter().for_each(|part| other.insert(part));
        assert_eq!(set.shared(&other).collect::<Vec<_>>(), vec![63, 129]);
        set.remove(64);
        assert!(!set.has(64) && set.has(129) && set.len() == 3);
    }
}
