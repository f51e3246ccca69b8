//! Maps by edges: thousands of times a second a cut asks for pairs of small numbers, which a hash against strangers' input takes ten
//! times as long for.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// By the two vertices of an edge.
pub(crate) type EdgeMap<T> = HashMap<[u32; 2], T, BuildHasherDefault<EdgeHasher>>;

/// Multiplication by an odd number spreads low bits up, a shift brings them down again.
#[derive(Default)]
pub(crate) struct EdgeHasher(u64);

impl Hasher for EdgeHasher {
    fn write(&mut self, bytes: &[u8]) {
        for word in bytes.chunks(8) {
            let word = word.iter().rev().fold(0_u64, |word, byte| word << 8 | u64::from(*byte));
            self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
    }

    // The length before the pair says nothing.
    fn write_usize(&mut self, _: usize) {}

    fn finish(&self) -> u64 {
        self.0 ^ (self.0 >> 32)
    }
}
