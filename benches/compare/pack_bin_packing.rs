//! Boxes packed by the crate `bin-packing`: what `trunnion pack --boxes` stands beside.
//!
//! In a package of its own: `cargo add bin-packing@0.4.0`, this file as `src/main.rs`, `cargo run --release -- [all]`. Packs the published
//! instances of Martello, Pisinger and Vigo (classes 1 and 4 to 8, ten each, of 50 and of 100 boxes) as they are drawn, or turned in every
//! way, and prints for each size the runs in all and the seconds; method `Auto`, seed 1.

use std::time::Instant;

use bin_packing::three_d::{Bin3D, BoxDemand3D, RotationMask3D, ThreeDOptions, ThreeDProblem, solve_3d};

/// POSIX's `lrand48`.
struct Numbers(u64);

impl Numbers {
    fn between(&mut self, [low, high]: [i64; 2]) -> u32 {
        self.0 = (self.0.wrapping_mul(0x0005_deec_e66d) + 0xb) & ((1 << 48) - 1);
        ((self.0 >> 17) as i64 % (high - low + 1) + low) as u32
    }
}

fn instance(class: i64, boxes: u64, which: u64) -> (u32, Vec<[u32; 3]>) {
    let side = [100, 10, 40][[6, 7].iter().position(|c| *c == class).map_or(0, |i| i + 1)];
    let mut numbers = Numbers(((which + boxes) << 16) | 0x330e);
    let (small, large, half) = ([1, side / 2], [2 * side / 3, side], [side / 2, side]);
    let sizes = (0..boxes).map(|_| {
        let drawn = if class <= 5 { numbers.between([1, 10]).into() } else { class };
        let ranges = match if drawn <= 5 { drawn } else { class } {
            1 => [small, large, large],
            2 => [large, small, large],
            3 => [large, large, small],
            4 => [half; 3],
            5 => [small; 3],
            6 => [[1, 10]; 3],
            7 => [[1, 35]; 3],
            _ => [[1, 100]; 3],
        };
        ranges.map(|range| numbers.between(range))
    });
    let sizes = sizes.collect();
    (side as u32, sizes)
}

fn main() {
    let turned = std::env::args().nth(1).is_some_and(|word| word == "all");
    let allowed_rotations = if turned { RotationMask3D::ALL } else { RotationMask3D::XYZ };
    for boxes in [50, 100] {
        let (mut runs, began) = (0, Instant::now());
        for class in [1, 4, 5, 6, 7, 8] {
            for which in 1..=10 {
                let (side, sizes) = instance(class, boxes, which);
                let bin =
                    Bin3D { name: "run".into(), width: side, height: side, depth: side, cost: 1.0, quantity: None };
                let demand = |(i, [width, height, depth]): (usize, &[u32; 3])| BoxDemand3D {
                    name: i.to_string(),
                    width: *width,
                    height: *height,
                    depth: *depth,
                    quantity: 1,
                    allowed_rotations,
                };
                let demands = sizes.iter().enumerate().map(demand).collect();
                let options = ThreeDOptions { seed: Some(1), ..ThreeDOptions::default() };
                let solved = solve_3d(ThreeDProblem { bins: vec![bin], demands }, options).expect("a packing");
                assert!(solved.unplaced.is_empty());
                runs += solved.bin_count;
            }
        }
        println!("{boxes} boxes: {runs} runs in {:.1} s", began.elapsed().as_secs_f64());
    }
}
