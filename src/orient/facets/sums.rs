//! Long sums, in parallel and the same to the last bit on any number of threads.

use std::iter::Sum;
use std::ops::Range;

use rayon::prelude::*;

/// Terms added one after the other; the partial sums are then added in their order.
const CHUNK: usize = 4096;
/// Below so many terms a second thread costs more than it gives.
const PARALLEL: usize = 1 << 16;

/// The sum over `0..count`, of which `part` sums a range.
///
/// The ranges do not depend on the number of threads, so neither does the rounding.
pub(in crate::orient) fn chunked<T: Sum<T> + Send>(count: usize, part: impl Fn(Range<usize>) -> T + Sync) -> T {
    let range = |i: usize| i * CHUNK..((i + 1) * CHUNK).min(count);
    let chunks = count.div_ceil(CHUNK);
    if count < PARALLEL {
        return (0..chunks).map(|i| part(range(i))).sum();
    }
    let parts: Vec<T> = (0..chunks).into_par_iter().map(|i| part(range(i))).collect();
    parts.into_iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_the_same_on_one_thread_and_on_five() {
        let term = |i: usize| (i as f64 * 0.37).sin() * 1e3 / (1.0 + i as f64);
        for count in [0, 1, CHUNK, CHUNK + 1, 300_001] {
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| chunked(count, |range| range.map(term).sum::<f64>()))
            };
            assert_eq!(on(1).to_bits(), on(5).to_bits());
            let plain: f64 = (0..count).map(term).sum();
            assert!((on(2) - plain).abs() < 1e-9, "{count}");
        }
    }
}
