//! A foot that ends in the middle of a layer, with a post on it: the layer may be the foot's or the post's, and nothing else.

use super::{LAYER, ReplayJob, Rule, layer, plan, profile, verify};
use crate::fixtures::solid_box;
use crate::geom::Vec3;
use crate::mesh::{Model, TriangleMesh};
use crate::planning::{Plan, Workpiece};
use crate::verify::Report;

const FOOT_MM: f64 = 10.0;
const POST_MM: f64 = 5.0;
const LAYERS: usize = 20;
/// The layer in whose middle the foot ends.
const THE_LAYER: usize = 10;

/// A foot `high` mm high and a post on it, as high as 20 layers together; the layers `wide` mm wide, from the first one on.
fn run(high: f64, wide: impl Fn(usize) -> f64) -> Report {
    leaning(high, 0.0, wide)
}

/// The same with the foot's top so much higher at one side than in its middle, and lower at the other.
fn leaning(high: f64, lean: f64, wide: impl Fn(usize) -> f64) -> Report {
    let half = |size: f64| size / 2.0;
    let block = |size: f64, from: f64, to: f64| {
        solid_box(Vec3::new(-half(size), -half(size), from), Vec3::new(half(size), half(size), to))
    };
    let (foot, post) = (block(FOOT_MM, 0.0, high), block(POST_MM, high, LAYERS as f64 * LAYER));
    let count = foot.vertices().len() as u32;
    let lifted = |v: &Vec3| if v.z > 0.0 { v + Vec3::z() * (lean * v.x.signum()) } else { *v };
    let vertices = foot.vertices().iter().map(lifted).chain(post.vertices().iter().copied()).collect();
    let above = post.facets().iter().map(|f| f.map(|v| v + count));
    let mesh = TriangleMesh::new(vertices, foot.facets().iter().copied().chain(above).collect());
    let model = Model::from_parts(vec![("stepped".to_owned(), mesh)]);
    let mut plan: Plan = plan();
    plan.parts.truncate(1);
    plan.slots.truncate(1);
    let mut body = String::new();
    let filament: f64 =
        (1..=LAYERS).map(|i| layer(&mut body, [-half(wide(i)), -half(wide(i)), i as f64 * LAYER], wide(i))).sum();
    let text = format!(
        ";TRUNNION version=0 plan=0 profile=generic-ac
;TRUNNION expect print=0 part=0 filament_mm={filament:.5}
G21\nG90\nG28\nM190 S60\nM109 S200\nM83
G1 Z120 F900
;TRUNNION slot=0 part=0 A=0 C=0
G1 C0 F1800
G1 A0 F1200
G1 X-4.6 Y-4.6 F6000
;TRUNNION print=0 part=0
G1 Z0.4 F900
G1 E2 F2100
{body}G1 E-2 F2100
G1 Z130 F900
;TRUNNION end
M104 S0\nM140 S0\nM107\nM84
"
    );
    let workpiece = Workpiece::place(&model, &plan.placement);
    verify(text.as_bytes(), &ReplayJob { profile: &profile(), plan: &plan, workpiece: &workpiece })
}

/// Feet whose top lies this far above the layer's middle, mm, and how wide that layer may be.
#[test]
fn a_layer_in_whose_middle_a_level_face_lies_is_what_ends_there_or_what_begins() {
    let middle = (THE_LAYER as f64 - 0.5) * LAYER;
    for (above, foot, post) in [
        (0.0, true, true),
        (1e-7, true, true),
        (-1e-7, true, true),
        (1e-3, true, true),
        (-1e-3, true, true),
        (0.01, true, false),
        (-0.01, false, true),
        (0.1, true, false),
        (-0.1, false, true),
    ] {
        for (wide, clean) in [(FOOT_MM, foot), (POST_MM, post), (FOOT_MM - 1.0, false), (POST_MM + 1.0, false)] {
            let report = run(middle + above, |i| match i {
                i if i < THE_LAYER => FOOT_MM,
                THE_LAYER => wide,
                _ => POST_MM,
            });
            assert_eq!(report.is_clean(), clean, "foot {above} above, layer {wide} wide: {:?}", report.findings);
        }
    }
}

/// Of the layers beside it nothing of that is true.
#[test]
fn its_neighbours_are_the_foot_s_and_the_post_s() {
    let middle = (THE_LAYER as f64 - 0.5) * LAYER;
    for above in [0.0, 1e-7, -1e-7] {
        for last in [THE_LAYER - 2, THE_LAYER + 1] {
            let report = run(middle + above, |i| if i <= last { FOOT_MM } else { POST_MM });
            let shape = [Rule::OutsidePart, Rule::Complete].iter().any(|rule| report.counts.contains_key(rule));
            assert!(shape, "the foot {last} layers high: {:?}", report.findings);
        }
    }
}

/// Turned solids come with level faces whose corners differ by micrometres: a slicer cuts such a face to a piece of it, whose edge runs across it.
/// So any layer between the foot's and the post's is right; one that is wider than the foot or narrower than the post is not, nor its neighbours.
#[test]
fn a_face_that_leans_by_micrometres_is_cut_to_a_piece_of_it() {
    let middle = (THE_LAYER as f64 - 0.5) * LAYER;
    let of_layer = |lean: f64, which: usize, wide: f64| {
        leaning(middle, lean, |i| match i {
            i if i == which => wide,
            i if i < THE_LAYER => FOOT_MM,
            _ => POST_MM,
        })
    };
    for lean in [1e-4, 7.5e-4, 2e-3] {
        for (wide, clean) in [
            (FOOT_MM, true),
            (FOOT_MM - 2.0, true),
            (POST_MM + 2.0, true),
            (POST_MM, true),
            (FOOT_MM + 1.0, false),
            (POST_MM - 1.5, false),
        ] {
            let report = of_layer(lean, THE_LAYER, wide);
            assert_eq!(report.is_clean(), clean, "{lean}, {wide} wide: {:#?}", report.findings);
        }
        // Level to a rounding it is one or the other, and beside it there is no such face.
        assert!(!of_layer(1e-6, THE_LAYER, FOOT_MM - 2.0).is_clean());
        assert!(!of_layer(lean, THE_LAYER - 2, FOOT_MM - 2.0).is_clean());
        assert!(!of_layer(lean, THE_LAYER + 2, POST_MM + 2.0).is_clean());
    }
}
