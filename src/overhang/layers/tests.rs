//! Shapes whose bridges, roofs, slopes and fillets are known by hand.

use super::*;
use crate::fixtures::prism;
use crate::geom::{Angle, Object};
use crate::overhang::{BRIDGE_MM, Cause, Relief};

fn rule() -> OverhangRule {
    let (layer_mm, line_mm) = (0.2, 0.45);
    let overhang = OverhangRule::practised(layer_mm, line_mm);
    OverhangRule { overhang, layer_mm, line_mm, bridge_mm: BRIDGE_MM, tolerate_mm2: 1.0, droops: true }
}

/// What an outline in x and z, drawn along y, lays badly; its lowest facets lie on the table.
fn laid(outline: &[[f64; 2]], y: [f64; 2], rule: &OverhangRule) -> Judged {
    let mesh: TriangleMesh<Object> = prism(outline, y);
    let foot = |f: usize| mesh.corners(f).iter().all(|p| p.z.abs() < 1e-9);
    judged(&mesh, &Vec3::z(), &Ground { table: true, ..Ground::default() }, foot, rule, false)
}

fn hanging(outline: &[[f64; 2]], y: [f64; 2], rule: &OverhangRule) -> Vec<Patch> {
    laid(outline, y, rule).hangs
}

/// Fine, droops, or hangs.
fn grade(outline: &[[f64; 2]], y: [f64; 2], rule: &OverhangRule) -> &'static str {
    match laid(outline, y, rule) {
        Judged { hangs, droops, .. } if hangs.is_empty() && droops.is_empty() => "fine",
        Judged { hangs, .. } if hangs.is_empty() => "droops",
        _ => "hangs",
    }
}

/// An arch with a flat ceiling `wide` mm across, 10 mm up.
fn arch(wide: f64) -> Vec<[f64; 2]> {
    let w = wide / 2.0;
    vec![[-w - 5.0, 0.0], [-w, 0.0], [-w, 10.0], [w, 10.0], [w, 0.0], [w + 5.0, 0.0], [w + 5.0, 15.0], [-w - 5.0, 15.0]]
}

#[test]
fn a_flat_ceiling_is_a_bridge_up_to_its_span_and_sags_from_10_mm_on() {
    let graded = [1.0, 9.9, 10.1, 13.9, 14.1, 30.0].map(|wide| grade(&arch(wide), [0.0, 30.0], &rule()));
    assert_eq!(graded, ["fine", "fine", "droops", "droops", "hangs", "hangs"]);
    let found = hanging(&arch(24.0), [0.0, 16.0], &rule());
    let [patch] = found[..] else { panic!("{found:?}") };
    // Two strips of 0.36 mm lie near enough to the posts.
    assert!((patch.area_mm2 - (24.0 - 0.72) * 16.0).abs() < 0.2, "{patch:?}");
    assert!((patch.at - Vec3::new(0.0, 8.0, 10.0)).norm() < 0.2, "{patch:?}");
    let Cause::Ceiling { size_mm: [long, wide], bridge_mm } = patch.cause else { panic!("{patch:?}") };
    assert!((long - 23.28).abs() < 1e-2 && (wide - 16.0).abs() < 1e-3 && bridge_mm == BRIDGE_MM, "{patch:?}");
    assert_eq!(hanging(&arch(24.0), [0.0, 12.0], &OverhangRule { bridge_mm: 24.0, ..rule() }), []);
    // Nothing is to droop.
    let fine = OverhangRule { droops: false, ..rule() };
    assert_eq!([9.9, 10.9].map(|wide| grade(&arch(wide), [0.0, 30.0], &fine)), ["fine", "hangs"]);
}

#[test]
fn a_shelf_that_is_held_at_one_side_droops_as_far_as_lines_hang_free() {
    let shelf =
        |out: f64| vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [10.0 + out, 10.0], [10.0 + out, 14.0], [0.0, 14.0]];
    let graded = |long: f64| [0.35, 0.5, 1.45, 1.95, 2.05].map(|out| grade(&shelf(out), [0.0, long], &rule()));
    assert_eq!(graded(12.0), ["fine", "droops", "droops", "droops", "hangs"]);
    assert_eq!(graded(40.0), ["fine", "droops", "droops", "hangs", "hangs"]);
    // Where it is narrow it may go out farther.
    assert_eq!([2.5, 2.95, 3.1].map(|out| grade(&shelf(out), [0.0, 3.0], &rule())), ["droops", "droops", "hangs"]);
    let found = hanging(&shelf(3.0), [0.0, 12.0], &rule());
    assert!(found.len() == 1 && (found[0].area_mm2 - 2.64 * 12.0).abs() < 0.05, "{found:?}");
    // Nothing is to droop.
    let fine = OverhangRule { droops: false, ..rule() };
    assert_eq!([0.35, 0.5].map(|out| grade(&shelf(out), [0.0, 12.0], &fine)), ["fine", "hangs"]);
}

/// Slicers lay no wall that is narrower than two thirds of a line, or not all of them do.
#[test]
fn a_wall_that_nobody_lays_holds_no_bridge() {
    let arch = |wall: f64| {
        [
            [-9.0, 0.0],
            [-4.0, 0.0],
            [-4.0, 10.0],
            [4.0, 10.0],
            [4.0, 0.0],
            [4.0 + wall, 0.0],
            [4.0 + wall, 15.0],
            [-9.0, 15.0],
        ]
    };
    let graded = [0.05, 0.14, 0.22, 0.29, 0.31, 0.45, 5.0].map(|wall| grade(&arch(wall), [0.0, 30.0], &rule()));
    assert_eq!(graded, ["hangs", "hangs", "hangs", "hangs", "fine", "fine", "fine"]);
}

/// PrusaSlicer 2.9 is silent about 1.4 mm at one side of a post of 12 mm and around a corner of it, and calls it loose around three sides and all four.
#[test]
fn a_ledge_all_around_has_no_end_that_something_holds() {
    let cuboid = |min: [f64; 3], max: [f64; 3]| {
        TriangleMesh::<Object>::cuboid(&crate::geom::Bounds { min: min.into(), max: max.into() })
    };
    let graded = |foot: [f64; 2], ledge: [[f64; 2]; 2]| {
        let [[x0, y0], [x1, y1]] = ledge;
        let mesh = TriangleMesh::joined([
            &cuboid([0.0, 0.0, 0.0], [foot[0], foot[1], 11.0]),
            &cuboid([x0, y0, 10.0], [x1, y1, 13.0]),
        ]);
        let stands = |f: usize| mesh.corners(f).iter().all(|p| p.z.abs() < 1e-9);
        let Judged { hangs, .. } =
            judged(&mesh, &Vec3::z(), &Ground { table: true, ..Ground::default() }, stands, &rule(), false);
        hangs.len()
    };
    // Out at one side, at two that meet, at three, and all around; at 1.9 mm a corner is farther out than lines hang free.
    for (out, found) in [(1.0, [0, 0, 0, 0]), (1.4, [0, 0, 1, 1]), (1.9, [0, 1, 1, 1])] {
        let ledges = [
            [[0.0, 0.0], [12.0 + out, 12.0]],
            [[0.0, 0.0], [12.0 + out; 2]],
            [[-out, 0.0], [12.0 + out; 2]],
            [[-out; 2], [12.0 + out; 2]],
        ];
        assert_eq!(ledges.map(|ledge| graded([12.0; 2], ledge)), found, "out by {out} mm");
    }
    assert_eq!(graded([2.0; 2], [[-1.9; 2], [3.9; 2]]), 1);
}

/// A screw's head sunk from below: the wall around it holds the ring in its roof, which is none around a post.
#[test]
fn a_ledge_into_a_hole_is_held_from_outside() {
    let ring = |r: f64, z: f64| {
        (0..48).map(move |k| {
            let (s, c) = (std::f64::consts::TAU * f64::from(k) / 48.0).sin_cos();
            Vec3::new(r * c, r * s, z)
        })
    };
    // Radii of the head and of the hole above it.
    let hangs = |head: f64, hole: f64| {
        let rings = [(head, 0.0), (20.0, 0.0), (20.0, 10.0), (hole, 10.0), (hole, 4.0), (head, 4.0)];
        let vertices: Vec<Vec3> = rings.iter().flat_map(|&(r, z)| ring(r, z)).collect();
        let side = |i: u32| {
            let [a, b] = [i, (i + 1) % 6].map(|i| 48 * i);
            (0..48).map(move |k| (a, b, k, (k + 1) % 48))
        };
        let facets =
            (0..6).flat_map(side).flat_map(|(a, b, k, next)| [[a + k, b + next, b + k], [a + k, a + next, b + next]]);
        let mesh = TriangleMesh::<Object>::new(vertices, facets.collect());
        assert!(mesh.volume() > 0.0);
        let stands = |f: usize| mesh.corners(f).iter().all(|p| p.z.abs() < 1e-9);
        let table = Ground { table: true, ..Ground::default() };
        !judged(&mesh, &Vec3::z(), &table, stands, &rule(), false).hangs.is_empty()
    };
    let found = [(3.25, 1.7), (4.0, 2.1), (4.5, 2.6), (9.0, 3.0), (12.0, 3.0)].map(|(head, hole)| hangs(head, hole));
    assert_eq!(found, [false, false, false, true, true]);
}

/// A ridge is cut a hair above its edge: what no slicer lays there holds nothing in the layer above.
#[test]
fn a_keel_holds_nothing_wherever_layers_are_cut() {
    let foot: TriangleMesh<Object> = prism(&[[0.0, 0.0], [10.0, 0.0], [10.0, 20.0], [0.0, 20.0]], [-5.0, 5.0]);
    for low in [10.0, 10.095, 10.0999, 10.1, 10.12, 10.19] {
        let outline = [[0.0, low], [1.0, low + 0.2], [1.0, low + 3.0], [-1.0, low + 3.0], [-1.0, low + 0.2]];
        let along: TriangleMesh<Object> = prism(&outline, [-30.0, -5.0]);
        let bar = TriangleMesh::new(
            along.vertices().iter().map(|v| Vec3::new(-v.y, v.x, v.z)).collect(),
            along.facets().to_vec(),
        );
        let mesh = TriangleMesh::joined([&foot, &bar]);
        let stands = |f: usize| mesh.corners(f).iter().all(|p| p.z.abs() < 1e-9);
        let relief = Relief::of(mesh.vertices().to_vec(), mesh.facets().to_vec());
        let begins_mm = relief.in_the_air(&Vec3::z(), stands, &rule().hang());
        assert!(!begins_mm.is_empty());
        let ground = Ground { table: true, begins_mm, ..Ground::default() };
        let found = judged(&mesh, &Vec3::z(), &ground, stands, &rule(), false).hangs;
        assert!(found.len() == 1 && found[0].area_mm2 > 15.0, "a ridge at {low} mm: {found:?}");
    }
}

#[test]
fn a_slope_passes_up_to_four_fifths_of_a_line_a_layer_and_beyond_that_for_a_few_layers() {
    // So high, leaning out by so many degrees from the vertical.
    let lean = |deg: f64, high: f64| {
        let out = high * f64::to_radians(deg).tan();
        [[0.0, 0.0], [60.0, 0.0], [60.0 + out, high], [0.0, high]]
    };
    let graded = |deg: f64, high: f64| grade(&lean(deg, high), [0.0, 12.0], &rule());
    // 0.36 mm in 0.2 mm are 60.9 degrees.
    assert_eq!([30.0, 45.0, 60.0, 60.9].map(|deg| graded(deg, 20.0)), ["fine"; 4]);
    assert_eq!(
        [0.6, 1.0, 2.0, 4.0, 20.0].map(|high| graded(66.0, high)),
        ["droops", "droops", "droops", "hangs", "hangs"]
    );
    // Too short to fall, but for the droop.
    assert_eq!(graded(62.0, 20.0), "droops");
    let found = hanging(&lean(66.0, 20.0), [0.0, 12.0], &rule());
    assert!(found.len() == 1 && matches!(found[0].cause, Cause::Slope { high_mm, .. } if high_mm > 16.0), "{found:?}");
    // An angle that is given takes the place of what lines carry.
    let given = |deg: f64| OverhangRule { overhang: Angle::from_deg(deg), ..rule() };
    assert_eq!(grade(&lean(50.0, 20.0), [0.0, 40.0], &given(45.0)), "hangs");
    assert_eq!(grade(&lean(66.0, 20.0), [0.0, 40.0], &given(67.0)), "fine");
    // Everything may overhang.
    assert_eq!(hanging(&arch(30.0), [0.0, 30.0], &given(90.0)), []);
}

#[test]
fn a_round_underside_droops_up_to_9_mm_of_radius() {
    // A bar whose lower edges are quarters of a circle, 40 mm long: the greatest step is 0.73 of the root of r h.
    let bar = |r: f64| {
        let arc = |turn: f64, k: i32| {
            let (s, c) = (f64::from(k) / 32.0 * std::f64::consts::FRAC_PI_2).sin_cos();
            [turn * (30.0 - r + r * s), r - r * c]
        };
        let right = (0..=32).map(|k| arc(1.0, k));
        let left = (0..=32).rev().map(|k| arc(-1.0, k));
        right.chain([[30.0, 25.0], [-30.0, 25.0]]).chain(left).collect::<Vec<_>>()
    };
    let graded = [1.0, 2.0, 3.0, 5.0, 9.0, 15.0].map(|r| grade(&bar(r), [0.0, 40.0], &rule()));
    assert_eq!(graded, ["fine", "droops", "droops", "droops", "droops", "hangs"]);
}

#[test]
fn what_lies_a_layer_of_air_above_something_droops_whatever_its_size() {
    // A wide groove below a plate, so many layers high.
    let groove = |high: f64| {
        [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 3.0],
            [5.0, 3.0 + high],
            [35.0, 3.0 + high],
            [35.0, 3.0],
            [40.0, 3.0],
            [40.0, 8.0],
            [0.0, 8.0],
        ]
    };
    let shelf = |high: f64| {
        [
            [0.0, 0.0],
            [30.0, 0.0],
            [30.0, 2.0],
            [0.4, 2.0],
            [0.4, 2.0 + high],
            [30.0, 2.0 + high],
            [30.0, 6.0],
            [0.0, 6.0],
        ]
    };
    assert_eq!([0.2, 0.4, 2.0].map(|high| grade(&shelf(high), [0.0, 30.0], &rule())), ["droops", "hangs", "hangs"]);
    // A foot of 0.2 mm below a block that is much wider.
    let foot = |high: f64| {
        [[10.0, 0.0], [20.0, 0.0], [20.0, high], [30.0, high], [30.0, 6.0], [0.0, 6.0], [0.0, high], [10.0, high]]
    };
    assert_eq!([0.2, 0.6].map(|high| grade(&foot(high), [0.0, 30.0], &rule())), ["droops", "hangs"]);
    assert_eq!(grade(&groove(0.0), [0.0, 30.0], &rule()), "hangs");
}

/// A block with a round hole through it along y.
fn drilled(radius: f64) -> Vec<[f64; 2]> {
    // One outline: in from the right side, around the hole, and back along the same cut.
    let ring = (0..=64).map(|k| (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos());
    let mut outline = vec![[-15.0, 0.0], [15.0, 0.0], [15.0, 14.999]];
    outline.extend(ring.map(|(s, c)| [radius * c, 15.0 - radius * s]));
    outline.extend([[15.0, 15.001], [15.0, 30.0], [-15.0, 30.0]]);
    outline
}

#[test]
fn roofs_of_round_holes_are_bridged_though_a_sliver_is_open() {
    for radius in [0.5, 1.0, 1.6, 2.5, 3.9] {
        for shift in 0..5 {
            let up = 0.04 * f64::from(shift);
            let outline: Vec<[f64; 2]> =
                drilled(radius).into_iter().map(|[x, z]| [x, if z > 0.0 { z + up } else { z }]).collect();
            assert_eq!(hanging(&outline, [0.0, 30.0], &rule()), [], "radius {radius}, {up} mm higher");
        }
    }
    // The roof of this one is wider than a bridge where its layers begin to fall.
    assert!(!hanging(&drilled(14.0), [0.0, 30.0], &rule()).is_empty());
}

#[test]
fn what_lies_on_something_is_carried_there_only() {
    // A beam on a post that is narrower.
    let mesh: TriangleMesh<Object> = prism(&[[0.0, 5.0], [30.0, 5.0], [30.0, 10.0], [0.0, 10.0]], [0.0, 10.0]);
    let own = (0..mesh.facets().len()).map(|f| mesh.corners(f)).filter(|c| c.iter().all(|p| p.z == 5.0)).collect();
    let post = |x: f64| {
        let [a, b, c, d] = [[0.0, 0.0], [x, 0.0], [x, 10.0], [0.0, 10.0]].map(|[x, y]| Vec3::new(x, y, 5.0));
        vec![[a, b, c], [a, c, d]]
    };
    let found = |below: Vec<[Vec3; 3]>| {
        let ground = Ground { footings: vec![Footing { own: Vec::clone(&own), below }], ..Ground::default() };
        unsupported(&mesh, &Vec3::z(), &ground, |_| false, &rule(), false)
    };
    assert_eq!(found(Vec::new()), []);
    let half = found(post(10.0));
    assert!(half.len() == 1 && (half[0].area_mm2 - (20.0 - 0.36) * 10.0).abs() < 0.1, "{half:?}");
    let none = unsupported(&mesh, &Vec3::z(), &Ground::default(), |_| false, &rule(), false);
    assert!(none.len() == 1 && none[0].cause == Cause::Island && (none[0].area_mm2 - 300.0).abs() < 1e-3, "{none:?}");
}

/// A cone with its point down, `high` mm up, in a gate whose beam it hangs from.
fn stalactite(high: f64, half_deg: f64) -> TriangleMesh<Object> {
    let gate: TriangleMesh<Object> = prism(&arch(8.0), [0.0, 12.0]);
    let base = 12.0;
    let radius = (base - high) * half_deg.to_radians().tan();
    let ring = (0..24).map(|k| {
        let (s, c) = (std::f64::consts::TAU * f64::from(k) / 24.0).sin_cos();
        Vec3::new(radius * c, 6.0 + radius * s, base)
    });
    let first = gate.vertices().len() as u32;
    let cone = [Vec3::new(0.0, 6.0, high), Vec3::new(0.0, 6.0, base)];
    let vertices = gate.vertices().iter().copied().chain(cone).chain(ring).collect();
    let side = (0..24).flat_map(|k| {
        let (a, b) = (first + 2 + k, first + 2 + (k + 1) % 24);
        [[first, b, a], [first + 1, a, b]]
    });
    TriangleMesh::new(vertices, gate.facets().iter().copied().chain(side).collect())
}

#[test]
fn what_begins_in_the_air_hangs_however_thin_it_is_and_wherever_layers_are_cut() {
    let found = |mesh: &TriangleMesh<Object>| {
        let foot = |f: usize| mesh.corners(f).iter().all(|p| p.z.abs() < 1e-9);
        let relief = Relief::of(mesh.vertices().to_vec(), mesh.facets().to_vec());
        let begins_mm = relief.in_the_air(&Vec3::z(), foot, &rule().hang());
        let ground = Ground { table: true, begins_mm, ..Ground::default() };
        unsupported(mesh, &Vec3::z(), &ground, foot, &rule(), true)
    };
    for half_deg in [0.3, 1.0, 3.0, 10.0, 30.0, 45.0] {
        for shift in [0.0, 1e-4, 0.05, 0.0999, 0.1, 0.1001, 0.15, 0.1999] {
            let hangs = found(&stalactite(6.0 + shift, half_deg));
            assert!(hangs.iter().any(|patch| patch.cause == Cause::Island), "{half_deg} deg, {shift} mm: {hangs:?}");
        }
        // A shell that begins within another one begins on nothing else.
        assert_eq!(found(&stalactite(10.5, half_deg)), [], "{half_deg} deg within the beam");
    }
}

/// One judge for many supports: what it has seen of one says nothing of the next.
#[test]
fn supports_are_judged_one_after_the_other_as_each_by_itself() {
    let (rule, mesh) = (rule(), prism(&arch(30.0), [0.0, 20.0]));
    let foot = |f: usize| mesh.corners(f).iter().all(|p| p.z.abs() < 1e-9);
    let ground = |held: SupportLines| Ground { table: true, held, ..Ground::default() };
    // Lines along y that end a layer of air below the ceiling.
    let lines = |at: &[f64]| SupportLines {
        layers: vec![(9.8, at.iter().map(|&x| [[x, 0.0], [x, 20.0]]).collect())],
        line_mm: rule.line_mm,
        gap_mm: 0.2,
        beside_mm: 1.7,
    };
    let judge = LayerJudge::of(&mesh, &Vec3::z(), &ground(SupportLines::default()), foot, &rule);
    let all = [vec![], vec![0.0], vec![-12.0], vec![-7.0, 7.0], vec![], vec![-10.0, 0.0, 10.0], vec![0.0]];
    let mut held = Vec::new();
    for at in &all {
        let alone = judged(&mesh, &Vec3::z(), &ground(lines(at)), foot, &rule, false);
        let strict = OverhangRule { droops: false, ..rule };
        let alone_strictly = judged(&mesh, &Vec3::z(), &ground(lines(at)), foot, &strict, false);
        assert_eq!(format!("{:?}", judge.judged(&lines(at))), format!("{alone:?}"), "{at:?}");
        assert_eq!(format!("{:?}", judge.judged_strictly(&lines(at))), format!("{alone_strictly:?}"), "{at:?}");
        held.push(alone.hangs.is_empty());
    }
    // From line to line: 14.8 mm are no bridge, 13.6 are.
    assert_eq!(held, [false, false, false, true, false, true, false]);
}

/// A bar of so many mm along x, 10 mm up, on sheets across it at each 5 mm of its first 20.
fn on_sheets(long: f64, wide: f64) -> Judged {
    let bar: TriangleMesh<Object> =
        prism(&[[0.0, 10.0], [long, 10.0], [long, 14.0], [0.0, 14.0]], [-wide / 2.0, wide / 2.0]);
    let ground = Ground { begins_mm: vec![10.0], ..Ground::default() };
    let judge = LayerJudge::of(&bar, &Vec3::z(), &ground, |_| false, &rule());
    let across = (0..5).map(|k| 5.0 * f64::from(k)).map(|x| [[x, -3.0], [x, 3.0]]).collect();
    judge.judged(&SupportLines { layers: vec![(9.8, across)], line_mm: 0.45, gap_mm: 0.2, beside_mm: 1.775 })
}

#[test]
fn a_narrow_end_beyond_supports_hangs_from_where_it_is_longer_than_a_line_hangs() {
    // From the last sheet's edge on, at 20.225 mm.
    let hangs = |out: f64| on_sheets(20.225 + out, 0.5).hangs.len();
    assert_eq!([1.5, 2.5, 2.95, 3.2, 4.0, 4.8, 8.0].map(hangs), [0, 0, 0, 1, 1, 1, 1]);
}

#[test]
fn what_was_asked_before_is_answered_as_if_it_were_asked_first() {
    // A shelf of 6 mm over air, and a slope that collapses, which layers below it remember.
    let outline = [[0.0, 0.0], [20.0, 0.0], [50.0, 12.0], [50.0, 30.0], [-6.0, 30.0], [-6.0, 26.0], [0.0, 26.0]];
    let mesh: TriangleMesh<Object> = prism(&outline, [0.0, 12.0]);
    let stands = |f: usize| mesh.corners(f).iter().all(|p| p.z.abs() < 1e-9);
    let ground = Ground { table: true, ..Ground::default() };
    let judge = || LayerJudge::of(&mesh, &Vec3::z(), &ground, stands, &rule());
    // Lines across below each layer that begins at one of these heights, from so far out, so far apart.
    let held = |tops: &[f64], from: f64, beside_mm: f64| {
        let lines: Vec<_> = (0..8).map(|k| from + 2.0 * f64::from(k)).map(|x| [[x, 0.0], [x, 12.0]]).collect();
        let layers = tops.iter().map(|top| (*top, lines.clone())).collect();
        SupportLines { layers, line_mm: 0.45, gap_mm: 0.2, beside_mm }
    };
    let every: Vec<f64> = (0..130).map(|k| 0.2 * f64::from(k)).collect();
    let kinds = [
        SupportLines::default(),
        held(&every, -6.0, 1.775),
        held(&every, -6.0, 0.5),
        held(&every[..40], 21.0, 1.775),
        held(&every[20..], 28.0, 1.775),
    ];
    let shared = judge();
    let mut different = std::collections::BTreeSet::new();
    for round in 0..3 {
        for (k, held) in kinds.iter().enumerate() {
            let (usual, strict) = (shared.judged(held), shared.judged_strictly(held));
            assert_eq!(usual, judge().judged(held), "{round}, {k}");
            assert_eq!(strict, judge().judged_strictly(held), "{round}, {k}");
            different.insert(format!("{usual:?}"));
            different.insert(format!("{strict:?}"));
        }
    }
    assert!(different.len() > kinds.len(), "{}", different.len());
}
