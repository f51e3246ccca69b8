//! The instances of Martello, Pisinger and Vigo (2000), from their published generator: its numbers are those of `lrand48`, seeded with the
//! instance's number plus the number of boxes.

use trunnion::pack::{Instance, Item, Turns};

/// POSIX's 48-bit numbers.
pub(super) struct Numbers(u64);

impl Numbers {
    pub(super) fn seeded(seed: u64) -> Self {
        Self((seed << 16) | 0x330e)
    }

    /// Evenly from `low` to `high`, by the remainder, as the generator does.
    pub(super) fn between(&mut self, low: i64, high: i64) -> i64 {
        self.0 = (self.0.wrapping_mul(0x0005_deec_e66d_u64) + 0xb) & ((1 << 48) - 1);
        (self.0 >> 17) as i64 % (high - low + 1) + low
    }
}

/// Boxes `which` (1 to 10) of a class and number.
pub(super) fn instance(class: i64, boxes: usize, which: u64) -> Instance {
    let side = match class {
        6 => 10,
        7 => 40,
        _ => 100,
    };
    let mut numbers = Numbers::seeded(which + boxes as u64);
    let (small, large, half) = ((1, side / 2), (2 * side / 3, side), (side / 2, side));
    let items = (0..boxes).map(|_| {
        let drawn = if class <= 5 { numbers.between(1, 10) } else { class };
        let ranges = match if drawn <= 5 { drawn } else { class } {
            1 => [small, large, large],
            2 => [large, small, large],
            3 => [large, large, small],
            4 => [half; 3],
            5 => [small; 3],
            6 => [(1, 10); 3],
            7 => [(1, 35); 3],
            _ => [(1, 100); 3],
        };
        Item { size: ranges.map(|(low, high)| numbers.between(low, high)), value: 1.0, up: [true; 3] }
    });
    let items = items.collect();
    Instance { space: [side; 3], gap: 0, turns: Turns::None, items }
}
