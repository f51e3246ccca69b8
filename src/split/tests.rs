//! The sweep's figures against cuts that are really made and measured, and shapes whose faults are known by hand.

use super::clip::{Taken, cut};
use super::measure::{MeasureRules, Measured, share_above};
use super::surface::{Plane, Surface};
use super::sweep::{Sweep, Upright};
use crate::fixtures::{caged, candelabrum, hook, prism, two_boxes, y_tree};
use crate::geom::{Object, Vec3};
use crate::mesh::TriangleMesh;
use crate::overhang::OverhangRule;

fn rules() -> MeasureRules {
    let sine = std::f64::consts::FRAC_1_SQRT_2;
    let overhang = crate::geom::Angle::from_deg(45.0);
    let layers =
        OverhangRule { overhang, layer_mm: 0.2, line_mm: 0.45, bridge_mm: 8.0, tolerate_mm2: 0.0, droops: true };
    MeasureRules { sine, layer_mm: 0.2, span_mm: 2.0, bridge_mm: 8.0, table_mm: 0.0, layers, faults: true }
}

struct Numbers(u64);

impl Numbers {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 33) as f64 / (1_u64 << 31) as f64)
    }

    fn direction(&mut self) -> Vec3 {
        Vec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(0.0, 1.0)).normalize()
    }
}

fn meshes() -> Vec<TriangleMesh<Object>> {
    let all = [hook(), caged(), two_boxes(), y_tree(), candelabrum()];
    all.into_iter().flat_map(|fixture| fixture.parts.into_iter().take(4)).map(|(_, mesh)| mesh).collect()
}

#[test]
fn a_facet_is_parted_as_its_corners_say() {
    let h = [0.0, 2.0, 1.0];
    for (c, wanted) in [(-1.0, 1.0), (0.0, 1.0), (0.5, 0.875), (1.0, 0.5), (1.5, 0.125), (2.0, 0.0), (3.0, 0.0)] {
        assert!((share_above(h, c) - wanted).abs() < 1e-15, "{c}");
    }
    // Corners at one height: no division by nothing.
    assert_eq!([share_above([1.0, 1.0, 4.0], 1.0), share_above([1.0, 4.0, 4.0], 2.5)], [1.0, 0.75]);
}

#[test]
fn the_sweep_says_what_real_cuts_measure() {
    let (mut numbers, rules) = (Numbers(3), rules());
    let mut compared = 0;
    for mesh in meshes() {
        let part = Measured::of(Surface::of(&mesh), &rules);
        let upright = Upright::of(&part, &rules);
        for _ in 0..12 {
            let up = numbers.direction();
            let mut sweep = Sweep::new(&part, &upright, &up, &rules);
            let range = sweep.heights.iter().fold([f64::MAX, f64::MIN], |r, h| [r[0].min(*h), r[1].max(*h)]);
            let mut offsets: Vec<f64> = (0..6).map(|_| numbers.between(range[0], range[1])).collect();
            offsets.sort_by(|a, b| b.total_cmp(a));
            let mut told = Vec::new();
            sweep.run(&offsets, |c, beyond| told.push((c, beyond.to_vec())));
            for (offset_mm, beyond) in told {
                let plane = Plane { normal: up, offset_mm };
                let Ok(made) = cut(&part.surface, &plane, &Taken::All, 1) else { panic!("{plane:?}") };
                let rest = Measured::of(made.rest, &rules);
                let after: f64 = made
                    .pieces
                    .into_iter()
                    .map(|piece| Measured::of(piece, &rules).needs(&up, Some(1), &rules).area_mm2)
                    .sum();
                // The cap faces up or sideways, so that what is left needs less by just what went.
                let before =
                    part.needs(&Vec3::z(), None, &rules).area_mm2 - rest.needs(&Vec3::z(), None, &rules).area_mm2;
                let sum = |of: &dyn Fn(&super::sweep::Beyond) -> f64| beyond.iter().map(of).sum::<f64>();
                let (b, a) = (sum(&|s| s.before.area_mm2), sum(&|s| s.after.area_mm2));
                assert!((b - before).abs() < 1e-6 * (1.0 + before), "before: {b} for {before} at {plane:?}");
                assert!((a - after).abs() < 1e-6 * (1.0 + after), "after: {a} for {after} at {plane:?}");
                compared += 1;
            }
        }
    }
    assert!(compared > 500, "{compared}");
}

#[test]
fn one_of_several_solids_is_taken_alone() {
    // A U: beyond half its height are two posts.
    let mesh = prism(&[[-20.0, 0.0], [20.0, 0.0], [20.0, 10.0], [-20.0, 10.0]], [-5.0, 5.0]);
    let posts = [-20.0, 10.0].map(|x| prism(&[[x, 10.0], [x + 10.0, 10.0], [x + 10.0, 40.0], [x, 40.0]], [-5.0, 5.0]));
    let mut all = Surface::of(&mesh);
    for post in &posts {
        let first = all.vertices.len() as u32;
        all.vertices.extend_from_slice(post.vertices());
        all.facets.extend(post.facets().iter().map(|f| f.map(|v| v + first)));
        all.source.extend(vec![0; post.facets().len()]);
    }
    let plane = Plane { normal: Vec3::z(), offset_mm: 25.0 };
    let top = all.vertices.iter().position(|v| v.x > 10.0 && v.z > 39.0).unwrap() as u32;
    let made = cut(&all, &plane, &Taken::With(vec![top]), 1).unwrap();
    assert_eq!(made.pieces.len(), 1);
    assert!((made.pieces[0].volume() - 1500.0).abs() < 1e-9 && (made.patches_mm2[0] - 100.0).abs() < 1e-9);
    assert!(made.rest.is_closed() && (made.rest.volume() + 1500.0 - all.volume()).abs() < 1e-9);
    assert_eq!(cut(&all, &plane, &Taken::All, 1).unwrap().pieces.len(), 2);
}

#[test]
fn corners_and_flat_ridges_count_and_nicks_and_arches_do_not() {
    let rules = rules();
    let needs = |outline: &[[f64; 2]], depth: f64| {
        let mesh = prism(outline, [0.0, depth]);
        Measured::of(Surface::of(&mesh), &rules).needs(&Vec3::z(), None, &rules)
    };
    // On its edge over the table: steep sides that begin in a line of 20 mm at z = 5.
    let keel = needs(&[[0.0, 5.0], [10.0, 16.0], [0.0, 27.0], [-10.0, 16.0]], 20.0);
    assert!(keel.beginnings == 1 && keel.area_mm2 == 0.0, "{keel:?}");
    // The same standing on the table begins nowhere else.
    assert_eq!(needs(&[[-2.0, 0.0], [2.0, 0.0], [10.0, 16.0], [-10.0, 16.0]], 20.0).faults(), 0);
    // Turned so that the edge rises by 3 degrees it has one lowest corner, and advances 3.8 mm a layer.
    let mesh = prism(&[[0.0, 5.0], [10.0, 16.0], [0.0, 27.0], [-10.0, 16.0]], [0.0, 20.0]);
    let up = Vec3::new(0.0, 3_f64.to_radians().sin(), 3_f64.to_radians().cos());
    let found = Measured::of(Surface::of(&mesh), &rules).needs(&up, None, &rules);
    assert!(found.beginnings == 1 && found.ridges == 1, "{found:?}");
    // At 10 degrees it advances 1.2 mm: that hangs.
    let up = Vec3::new(0.0, 10_f64.to_radians().sin(), 10_f64.to_radians().cos());
    assert_eq!(Measured::of(Surface::of(&mesh), &rules).needs(&up, None, &rules).ridges, 0);
}

#[test]
fn a_cap_does_not_follow_facets_without_area_out_over_nothing() {
    // Below the arms of a T lies a line of facets without area, in the plane of a cut that only the post crosses.
    let outline =
        [[0.0, 0.0], [10.0, 0.0], [10.0, 25.0], [25.0, 25.0], [25.0, 33.0], [-15.0, 33.0], [-15.0, 25.0], [0.0, 25.0]];
    let at = |y: f64| outline.map(|[x, z]| Vec3::new(x, y, z));
    let front = [[0, 1, 2], [0, 2, 7], [7, 2, 3], [7, 3, 6], [6, 3, 5], [3, 4, 5]];
    let mut facets: Vec<[u32; 3]> = front.to_vec();
    facets.extend(front.iter().map(|&[a, b, c]| [a + 8, c + 8, b + 8]));
    for k in 0..8 {
        let next = (k + 1) % 8;
        facets.extend([[k, next + 8, next], [k, k + 8, next + 8]]);
    }
    let tee = TriangleMesh::<Object>::new([at(0.0), at(12.0)].concat(), facets);
    let all = Surface::of(&tee);
    assert!(all.is_closed() && all.volume() > 0.0);
    let normal = Vec3::new(0.0, 1.0, 1.0).normalize();
    let made = cut(&all, &Plane { normal, offset_mm: normal.z * 25.0 }, &Taken::All, 1).unwrap();
    assert!((made.patches_mm2.iter().sum::<f64>() - 120.0 * 2_f64.sqrt()).abs() < 1e-9, "{:?}", made.patches_mm2);
    let [arms] = &made.pieces[..] else { panic!("{} pieces", made.pieces.len()) };
    assert!(arms.is_closed() && made.rest.is_closed());
    assert!((arms.volume() + made.rest.volume() - all.volume()).abs() < 1e-9);
    // The post has no corner beyond its own width, and every facet of the caps looks straight up or down along the plane.
    assert!(made.rest.vertices.iter().all(|v| (0.0..=10.0).contains(&v.x)), "{:?}", made.rest.vertices);
    for (surface, sense) in [(arms, -1.0), (&made.rest, 1.0)] {
        for facet in (0..surface.facets.len()).filter(|&f| surface.source[f] == 1) {
            let up = surface.area_vector(facet).normalize().dot(&normal);
            assert!((up - sense).abs() < 1e-9, "{up}: {:?}", surface.corners(facet));
        }
    }
    // Along that plane the arms begin in two lines in the air, 15 mm each.
    let rules = rules();
    assert_eq!(Measured::of(arms.clone(), &rules).needs(&normal, Some(1), &rules).ridges, 2);
}

#[test]
fn cuts_that_cost_more_than_another_way_are_not_searched() {
    // An arm out of a post: one cut, one more direction.
    let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 30.0], [40.0, 30.0], [40.0, 40.0], [0.0, 40.0]];
    let arm = prism(&outline, [0.0, 10.0]);
    let within = |most_min: Option<f64>| {
        let budget = most_min.map(|most_min| super::CutBudget { setup_min: 2.0, seam_min_per_mm2: 0.01, most_min });
        super::split(
            &arm,
            &super::NoHead { most_tilt: std::f64::consts::FRAC_PI_2 },
            &super::CutOptions { budget, ..super::CutOptions::default() },
            &mut |_| true,
        )
    };
    let free = within(None);
    assert!(free.printable && free.cuts.len() == 1, "{:?}", free.cuts);
    let cost = 2.0 * (free.setups() - 1) as f64 + 0.01 * free.seam_mm2();
    // What it costs and a little more is enough; what it costs and a little less is not.
    let just = within(Some(cost + 0.01));
    assert!(just.printable && just.cuts.len() == 1);
    let dear = within(Some(cost - 0.01));
    assert!(!dear.printable && dear.refused.iter().any(|(against, _)| *against == super::Against::Budget), "{dear:?}");
    assert!(!within(Some(0.0)).printable);
}

#[test]
fn a_search_that_is_stopped_ends_with_the_best_so_far() {
    let outline =
        [[0.0, 0.0], [10.0, 0.0], [10.0, 30.0], [40.0, 30.0], [40.0, 40.0], [-30.0, 40.0], [-30.0, 30.0], [0.0, 30.0]];
    let tee = prism(&outline, [0.0, 10.0]);
    let within = |tries: u64, watch: &mut super::CutWatch<'_>| {
        let machine = super::NoHead { most_tilt: std::f64::consts::FRAC_PI_2 };
        super::split(&tee, &machine, &super::CutOptions { tries, ..super::CutOptions::default() }, watch)
    };
    let mut asked = 0;
    let whole = within(u64::MAX, &mut |_| {
        asked += 1;
        true
    });
    assert!(whole.printable && whole.stopped.is_none() && whole.cuts.len() == 2, "{:?}", whole.cuts);
    // By itself after so many cuts, and when it is told to: never without a cut that it had, and in the end with all.
    let mut before = whole.before.area_mm2;
    for tries in [0, 8, 16, 32, 64, 10_000] {
        let some = within(tries, &mut |_| true);
        assert!(some.printable || some.stopped.is_some_and(|tried| tried >= tries), "{tries}: {some:?}");
        assert!(some.after.area_mm2 <= before + 1e-9, "{tries}: {} after {before}", some.after.area_mm2);
        before = some.after.area_mm2;
    }
    for enough in 0..asked {
        let mut count = 0;
        let some = within(u64::MAX, &mut |_| {
            count += 1;
            count <= enough
        });
        assert_eq!((count, some.stopped.is_some()), (enough + 1, true));
        assert!(some.parts.iter().map(|part| part.mesh.volume()).sum::<f64>() > 0.999 * tee.volume());
    }
}
