//! Which sums lengths have, by bits: whole numbers of the cells into which the search for full runs rounds lengths ([`super::loading`]).

/// Which whole numbers up to some are sums.
pub(super) struct Sums(Vec<u64>);

impl Sums {
    /// Only 0.
    pub(super) fn none(most: i64) -> Self {
        let mut words = vec![0; most as usize / 64 + 1];
        words[0] = 1;
        Self(words)
    }

    /// With `count` more numbers of that length.
    pub(super) fn with(&mut self, length: i64, mut count: u32) {
        let mut many = 1;
        while count > 0 {
            // So many at once that each number of them comes to be a sum.
            let taken = many.min(count);
            let by = length as usize * taken as usize;
            if by >= self.0.len() * 64 {
                return;
            }
            let (words, bits) = (by / 64, by % 64);
            for i in (words..self.0.len()).rev() {
                let low = if bits > 0 && i > words { self.0[i - words - 1] >> (64 - bits) } else { 0 };
                self.0[i] |= self.0[i - words] << bits | low;
            }
            (count, many) = (count - taken, many * 2);
        }
    }

    /// The greatest that is no greater than `most`.
    pub(super) fn below(&self, most: i64) -> i64 {
        let mut word = most as usize / 64;
        let mut bits = self.0[word] & (u64::MAX >> (63 - most as usize % 64));
        while bits == 0 {
            // 0 is always one.
            word -= 1;
            bits = self.0[word];
        }
        (word * 64 + 63 - bits.leading_zeros() as usize) as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::SplitMix64;

    /// Against all choices of how many of each.
    #[test]
    fn sums_are_those_of_all_choices() {
        let mut numbers = SplitMix64::seeded(8);
        for _ in 0..200 {
            let most = 1 + numbers.below(200) as i64;
            let given: Vec<(i64, u32)> =
                (0..3).map(|_| (1 + numbers.below(40) as i64, numbers.below(7) as u32)).collect();
            let mut sums = Sums::none(most);
            given.iter().for_each(|&(length, count)| sums.with(length, count));
            let mut all = vec![0];
            for &(length, count) in &given {
                all = (0..=i64::from(count)).flat_map(|n| all.iter().map(move |sum| sum + n * length)).collect();
            }
            for limit in 0..=most {
                assert_eq!(Some(sums.below(limit)), all.iter().copied().filter(|&sum| sum <= limit).max(), "{given:?}");
            }
        }
    }
}
