//! What `orient.rs` holds on the documents' meshes, which may not be copied here, on meshes that are made here: the same rows in every clone.
//!
//! The values were worked out by other code: the formulas of `benches/compare/orient_numpy.py`, a grid of 2 degrees and all facet normals, and from the 50
//! best of these a pattern search in the tangent plane down to steps of 1e-10.

use trunnion::geom::{Angle, Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{
    Certified, Direct, Facets, GridSearch, Height, Multistart, NelderMead, Objective, ObjectiveSettings, OverhangAngle,
    Search, TanhOverhang, WeightedNormalZ, objective,
};

use crate::orient::{GAPS, PURI_KINK, near};
use crate::orient_sample::anywhere;
use crate::solids::lump;
use crate::support::Numbers;

/// A lump of so many rings; its facets, and what numpy says of it.
struct Row {
    rings: usize,
    kind: f64,
    facets: usize,
    /// `weighted-normal-z` as it lies, least, and where.
    weighted: [f64; 2],
    up: [f64; 3],
    /// `overhang-angle` as it lies, and least.
    overhang: [f64; 2],
    height: f64,
}

const ROWS: [Row; 4] = [
    Row {
        rings: 9,
        kind: 0.0,
        facets: 288,
        weighted: [48597.51273402947, 41142.707744686966],
        up: [0.4266469970467234, 0.6513980838098414, -0.6274176251269006],
        overhang: [9.43819885367306, 9.435379833413506],
        height: 42.72241221407527,
    },
    Row {
        rings: 10,
        kind: 1.0,
        facets: 360,
        weighted: [39441.32807681785, 33303.49922575393],
        up: [0.019485494334935485, -0.7069725297031425, -0.7069725297037096],
        overhang: [6.23835836735664, 6.0598309329394375],
        height: 33.94457099671763,
    },
    Row {
        rings: 11,
        kind: 2.0,
        facets: 440,
        weighted: [30415.47730941584, 25065.72752737023],
        up: [-0.09834398750730904, -0.6663880844972324, -0.7390909152203616],
        overhang: [6.6725991711435135, 4.761250175795309],
        height: 30.393341112740455,
    },
    Row {
        rings: 12,
        kind: 3.0,
        facets: 528,
        weighted: [35544.78698288255, 27591.178203905172],
        up: [-0.4238615792611246, -0.030459660310292028, 0.9052146544991675],
        overhang: [30.676820883654486, 14.797157163997607],
        height: 35.36571862215776,
    },
];

impl Row {
    fn part(&self) -> Facets {
        Facets::of(&lump(self.rings, self.kind))
    }

    fn name(&self) -> String {
        format!("lump of {} rings", self.rings)
    }
}

#[test]
fn weighted_normal_z_has_numpys_values_and_minima() {
    for row in &ROWS {
        let part = row.part();
        assert_eq!(part.each.len(), row.facets, "{}", row.name());
        near(WeightedNormalZ.value(&part, &Vec3::z()), row.weighted[0], 1e-9, &row.name());
        let found = &Certified::default().search(&WeightedNormalZ, &part).minima[0];
        near(found.value, row.weighted[1], 1e-6, &row.name());
        // Some have two minima of one value.
        near(WeightedNormalZ.value(&part, &Vec3::from(row.up)), row.weighted[1], 1e-9, &row.name());
    }
}

#[test]
fn overhang_angle_has_numpys_values_and_minima() {
    let f = OverhangAngle { theta: Angle::from_deg(45.0) };
    for row in &ROWS {
        let part = row.part();
        near(f.value(&part, &Vec3::z()), row.overhang[0], 1e-9, &row.name());
        near(Certified::default().search(&f, &part).minima[0].value, row.overhang[1], 1e-5, &row.name());
    }
}

/// Lumps of a twentieth of the size, where the objective's `tanh` is far from 1; as they lie, and least.
#[test]
fn tanh_overhang_reaches_numpys_values() {
    let rows = [
        (5, 0.0, 0.9664023410981104, 0.7513855819264901),
        (6, 1.0, 0.9681062962922885, 0.684075917071908),
        (7, 2.0, 0.7751716119443416, 0.6499900034091488),
    ];
    let f = TanhOverhang { scale: 1.0 };
    for (rings, kind, lies, least) in rows {
        let large = lump(rings, kind);
        let small = large.vertices().iter().map(|v| v * 0.05).collect();
        let part = Facets::of(&TriangleMesh::<Object>::new(small, large.facets().to_vec()));
        near(f.value(&part, &Vec3::z()), lies, 1e-9, "as in the file");
        near(NelderMead::default().search(&f, &part).minima[0].value, least, PURI_KINK, "least");
    }
}

#[test]
fn certified_proves_the_minima_and_no_random_direction_is_below() {
    let mut numbers = Numbers::seeded(3);
    for row in &ROWS {
        let part = row.part();
        let found = Certified::default().search(&WeightedNormalZ, &part);
        let (best, lower) = (found.minima[0].value, found.lower_bound.unwrap());
        assert!(lower <= best && best - lower <= 1e-6 * best, "{}: {lower} for {best}", row.name());
        assert!(lower <= row.weighted[1] * (1.0 + 1e-9), "{}: above what numpy has found", row.name());
        for _ in 0..20_000 {
            assert!(WeightedNormalZ.value(&part, &anywhere(&mut numbers)) >= lower, "{}", row.name());
        }
    }
}

#[test]
fn certified_closes_the_gap_for_every_objective_with_bounds() {
    let part = ROWS[1].part();
    for (name, gap) in GAPS {
        let f = objective(name, &ObjectiveSettings::default()).unwrap();
        let found = Certified { gap, ..Certified::default() }.search(f.as_ref(), &part);
        let (best, lower) = (found.minima[0].value, found.lower_bound.unwrap());
        assert!(lower <= best && best - lower <= gap * best, "{name}: {lower} for {best}");
    }
}

#[test]
fn every_search_comes_near_the_least_height_and_none_below() {
    let row = &ROWS[3];
    let part = row.part();
    let searches: [(&dyn Search, f64); 5] = [
        (&Certified::default(), 1e-6),
        (&Multistart::default(), 1e-4),
        (&NelderMead::default(), 1e-6),
        (&Direct::default(), 1e-3),
        (&GridSearch::default(), 0.1),
    ];
    for (search, reach) in searches {
        let best = search.search(&Height, &part).minima[0].value;
        let (least, most) = (row.height * (1.0 - 1e-6), row.height * (1.0 + reach) * (1.0 + 1e-6));
        assert!((least..=most).contains(&best), "{}: {best} for {}", search.name(), row.height);
    }
}
