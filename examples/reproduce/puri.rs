//! S. Puri, 2019: one rotation for a part, by dividing rectangles.

use trunnion::geom::{Bounds, Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{Certified, Direct, Facets, Objective, Search, TanhOverhang, from_angles, to_angles, turned};

use super::chart::{Curve, Plane};
use super::item::{Document, Item, Kind, Row, figures};
use super::scene::{AMBER, frame, sheet, solid};
use super::sources::{Recorded, Run, degrees};

pub(crate) fn document(run: &Run) -> Document {
    Document {
        key: "puri",
        authors: "S. Puri",
        title: "Optimal Part Rotation for Additive Manufacturing with Fused Filament Fabrication",
        year: 2019,
        items: vec![
            Item::left(Kind::Figure, "1a", "Overhang test print, face up", "a photograph of a print"),
            Item::left(Kind::Figure, "1b", "Overhang test print, face down", "a photograph of a print"),
            landscape(run),
            rotated(),
            rectangles(run),
        ],
    }
}

fn cube() -> TriangleMesh<Object> {
    TriangleMesh::cuboid(&Bounds { min: Vec3::zeros(), max: Vec3::repeat(1.0) })
}

const F: TanhOverhang = TanhOverhang { scale: 1.0 };
/// What is printed for the cube at (0, 0).
const PRINTED: f64 = 0.0347;
/// The paper's limit.
const EVALUATIONS: usize = 1000;

fn up(alpha: f64, beta: f64) -> Vec3 {
    from_angles(alpha.to_radians(), beta.to_radians())
}

fn plane<'a>(title: &str, fine: usize, value: &'a (dyn Fn(f64, f64) -> f64 + Sync), curves: Vec<Curve>) -> Plane<'a> {
    let axes = ["X-rotation, deg", "Y-rotation, deg"];
    Plane { title: title.to_owned(), axes, range: [[-180.0, 180.0]; 2], fine, value, curves }
}

fn landscape(run: &Run) -> Item {
    let facets = Facets::of(&cube());
    let value = |a: f64, b: f64| F.value(&facets, &up(a, b));
    // As many places as the paper's grid, both ends among them.
    let least = (0..10_000).map(|i| {
        let at = |k: i32| -180.0 + 360.0 * f64::from(k) / 99.0;
        value(at(i % 100), at(i / 100))
    });
    let least = least.fold(f64::INFINITY, f64::min);
    let (svg, _) =
        plane("Figure 2a: objective of the unit cube", if run.quick { 60 } else { 100 }, &value, Vec::new()).svg();
    Item::figure("2a", "Objective of a unit cube over both rotations")
        .picture("peaks and valleys recur with the cube's symmetry", svg)
        .row(Row::absolute("value at (0, 0)", PRINTED, value(0.0, 0.0), 5e-5, ""))
        .row(Row::absolute("least value on a grid of 100 x 100 places", PRINTED, least, 2e-3, "").because(
            "the printed 0.0347 is that of (0, 0); a grid of 100 places with both ends has no place there, and the program may have drawn another",
        ))
        .note("The text's formula lacks the division by ten that the program has; with it, and lengths in mm, the printed value comes out.")
}

fn rotated() -> Item {
    let facets = Facets::of(&cube());
    let best = Direct { budget: EVALUATIONS }.search(&F, &facets).minima.first().copied();
    let Some(best) = best else {
        return Item::left(Kind::Figure, "2b", "The cube as it is to be printed", "no minimum was found");
    };
    let pose: TriangleMesh<Object> = turned(&cube(), &best.up);
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    let off =
        axes.iter().map(|axis| degrees(&best.up, axis).min(degrees(&best.up, &-axis))).fold(f64::INFINITY, f64::min);
    let [a, b] =
        [to_angles(&best.up).0, to_angles(&best.up).1].map(|v| figures((v.to_degrees() * 10.0).round() / 10.0));
    Item::figure("2b", "The unit cube after the rotation that was found")
        .picture("", sheet("Figure 2b", 1, vec![frame(vec![solid(&pose, AMBER, None)], "lies on a face")], Vec::new()))
        .row(
            Row::apart("rotation", "(0, 0)", format!("({a}, {b})"), off, 0.1)
                .because("six poses of a cube are one; degrees are from the nearest of them"),
        )
        .row(Row::relative("value", PRINTED, best.value, 2e-3).because("printed to four decimals"))
}

fn rectangles(run: &Run) -> Item {
    let facets = Facets::of(&cube());
    let recorded = Recorded::new(&F);
    let found = Direct { budget: 1025 }.search(&recorded, &facets);
    let asked = recorded.taken();
    let places = asked.iter().map(|up| {
        let (a, b) = to_angles(up);
        [a.to_degrees(), b.to_degrees()]
    });
    let curves = vec![Curve::dots("centres of rectangles", places.collect())];
    let value = |a: f64, b: f64| F.value(&facets, &up(a, b));
    let (svg, _) = plane("Figure 2c: centres of rectangles", if run.quick { 60 } else { 100 }, &value, curves).svg();
    let bound = Certified::of(&F).search(&F, &facets).lower_bound.unwrap_or(f64::NEG_INFINITY);
    let best = found.minima.first().map_or(f64::NAN, |m| m.value);
    Item::figure("2c", "Rectangles of the search and their centres after 1,025 evaluations")
        .picture("the search divides the faces of a cube around the sphere, which has no poles", svg)
        .row(
            Row::absolute("evaluations", 1025.0, found.evaluations as f64, 2.0, "")
                .because("each division asks for two values, and the limit is kept"),
        )
        .row(
            Row::relative("least value found, beside the proved lower bound", bound, best, 2e-3)
                .because("\"the implementation found the global minimizer\": the bound proves it for the cube"),
        )
}
