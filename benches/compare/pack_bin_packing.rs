//! Boxes packed by the crate `bin-packing`: what `trunnion pack --boxes` stands beside.
//!
//! In a package of its own, beside a checkout: `cargo init`, `cargo add bin-packing@0.4.0`, `cargo add trunnion --path CHECKOUT`, and in its
//! Cargo.toml `[[bin]]` with `name = "pack"` and `path = "CHECKOUT/benches/compare/pack_bin_packing.rs"`; then `cargo run --release --bin pack
//! -- [all]`. Packs the published instances of Martello, Pisinger and Vigo (classes 1 and 4 to 8, ten each, of 50 and of 100 boxes) as they are
//! drawn, or turned in every way, and prints for each size the runs in all and the seconds; method `Auto`, seed 1.

use std::time::Instant;

use bin_packing::three_d::{Bin3D, BoxDemand3D, RotationMask3D, ThreeDOptions, ThreeDProblem, solve_3d};

#[path = "../../tests/it/packing/generator.rs"]
mod generator;

fn main() {
    let turned = std::env::args().nth(1).is_some_and(|word| word == "all");
    let allowed_rotations = if turned { RotationMask3D::ALL } else { RotationMask3D::XYZ };
    for boxes in [50, 100] {
        let (mut runs, began) = (0, Instant::now());
        for class in [1, 4, 5, 6, 7, 8] {
            for which in 1..=10 {
                let instance = generator::instance(class, boxes, which);
                let [side, ..] = instance.space.map(|side| side as u32);
                let bin =
                    Bin3D { name: "run".into(), width: side, height: side, depth: side, cost: 1.0, quantity: None };
                let demand = |(i, [width, height, depth]): (usize, [u32; 3])| BoxDemand3D {
                    name: i.to_string(),
                    width,
                    height,
                    depth,
                    quantity: 1,
                    allowed_rotations,
                };
                let sizes = instance.items.iter().map(|item| item.size.map(|side| side as u32));
                let demands = sizes.enumerate().map(demand).collect();
                let options = ThreeDOptions { seed: Some(1), ..ThreeDOptions::default() };
                let solved = solve_3d(ThreeDProblem { bins: vec![bin], demands }, options).expect("a packing");
                assert!(solved.unplaced.is_empty());
                runs += solved.bin_count;
            }
        }
        println!("{boxes} boxes: {runs} runs in {:.1} s", began.elapsed().as_secs_f64());
    }
}
