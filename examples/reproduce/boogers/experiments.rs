//! Chapter 5: parameters, mesh size, and searches compared. Figures 5.2 to 5.7, tables 5.1 and 5.2.

use std::time::Instant;

use trunnion::geom::{Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{
    Cost, Descent, DifferentialEvolution, Facets, Found, GradientMethod, Multistart, NelderMead, Objective, Search,
    Starts, Supported, to_angles,
};

use super::super::chart::{Chart, Curve, Plane};
use super::super::item::{Item, Kind, Row, figures};
use super::super::scene::{frame, painted, sheet, tint};
use super::super::sources::{Recorded, Run, Toy};
use super::shapes::{CUT, cut_out, smooth, up};

/// The part of the experiments, and what is said of it.
pub(super) struct Part {
    pub(super) mesh: TriangleMesh<Object>,
    pub(super) facets: Facets,
    instead: &'static str,
    given: bool,
}

const ARMADILLO: &str = "Armadillo_10000.stl";

impl Part {
    /// The armadillo where it is given, else the cube with a cut-out.
    pub(super) fn of(run: &Run) -> Self {
        match run.mesh(ARMADILLO) {
            Ok(mesh) => {
                // The thesis's program scales it by 0.05.
                let mesh =
                    TriangleMesh::new(mesh.vertices().iter().map(|p| p * 0.05).collect(), mesh.facets().to_vec());
                let facets = Facets::of(&mesh);
                let instead = "the armadillo of 10,000 facets of the thesis's repository; the thesis uses one of 400";
                Self { mesh, facets, instead, given: true }
            }
            Err(_) => {
                let mesh = cut_out(3);
                let instead = "the cube with a cut-out; the armadillo is not the project's to pass on (Armadillo_10000.stl in --meshes)";
                Self { facets: Facets::of(&mesh), mesh, instead, given: false }
            }
        }
    }
}

/// As the thesis's program sets them for the armadillo.
pub(super) fn objective() -> Supported {
    smooth(Cost::Volume, 0.0, 0.0, 10.0, 40.0)
}

/// Where the searches of table 5.1 start, degrees.
const START: [f64; 2] = [-90.0, -70.0];

pub(super) fn items(run: &Run) -> Vec<Item> {
    let part = Part::of(run);
    let (contour, table) = methods(run, &part);
    let (paths, strategies) = strategies(run, &part);
    vec![
        thresholds(run, &part),
        carried(&part),
        scaling(run),
        converged(run),
        contour,
        table,
        paths,
        strategies,
        armadillo(&part),
    ]
}

fn armadillo(part: &Part) -> Item {
    let caption = "Two views of the decimated armadillo";
    if !part.given {
        return Item::left(Kind::Figure, "5.1", caption, format!("mesh not given: {ARMADILLO}"));
    }
    let picture = frame(vec![painted(&part.mesh, |_| None)], "10,000 facets");
    Item::figure("5.1", caption).stand_in(part.instead).picture("", sheet("Figure 5.1", 1, vec![picture], Vec::new()))
}

fn thresholds(run: &Run, part: &Part) -> Item {
    let fine = if run.quick || part.given { 61 } else { 181 };
    let curve =
        |name: String, f: Supported| Curve::of(name, [-180.0, 180.0], fine, |a| f.value(&part.facets, &up(a, 0.0)));
    let set = [0.0, 15.0, 30.0, 45.0];
    let hangs = set.map(|t| curve(format!("overhang {t} deg"), smooth(Cost::Volume, t, 0.0, 10.0, 40.0)));
    let carries = set.map(|t| curve(format!("self-supported {t} deg"), smooth(Cost::Volume, 0.0, t, 10.0, 40.0)));
    let sums: Vec<f64> = hangs.iter().map(|c| c.points.iter().map(|p| p[1]).sum()).collect();
    let falls = sums.windows(2).all(|pair| pair[1] < pair[0]);
    let most = |all: &[Curve]| {
        let change =
            all[1..].iter().flat_map(|c| c.points.iter().zip(&all[0].points).map(|(a, b)| (a[1] - b[1]).abs()));
        change.fold(0.0, f64::max)
    };
    let [by_hanging, by_carrying] = [most(&hangs), most(&carries)];
    let axes = ["rotation about x, deg", "mm³"];
    Item::figure("5.2", "Support volume for several overhang and self-supported thresholds")
        .stand_in(part.instead)
        .picture("", Chart::new("Figure 5.2a: overhang thresholds", axes, hangs.into()).svg())
        .picture("", Chart::new("Figure 5.2b: self-supported thresholds", axes, carries.into()).svg())
        .row(Row::same("the volume falls with the overhang threshold", "yes", if falls { "yes" } else { "no" }))
        .row(
            Row::same(
                "the self-supported threshold changes the volume less than the other",
                "less",
                if by_carrying < by_hanging { "less" } else { "more" },
            )
            .because(format!(
                "at most by {} and {} mm³; \"does not significantly affect\"",
                two(by_carrying),
                two(by_hanging)
            )),
        )
}

/// To a hundredth.
fn two(value: f64) -> String {
    figures((value * 100.0).round() / 100.0)
}

fn carried(part: &Part) -> Item {
    let at = up(10.0, 0.0);
    let picture = |t: f64| {
        let f = smooth(Cost::Volume, 0.0, t, 10.0, 40.0);
        let costs = f.by_facet(&part.facets, &at).unwrap_or_default();
        let per: Vec<f64> = costs.iter().zip(&part.facets.each).map(|(cost, facet)| cost / facet.area.norm()).collect();
        let most = per.iter().fold(0.0_f64, |most, cost| most.max(cost.abs()));
        let turned = trunnion::orient::turned::<_, Object>(&part.mesh, &at);
        let sum: f64 = costs.iter().sum();
        (frame(vec![painted(&turned, |facet| Some(tint(per[facet] / most)))], &format!("self-supported {t} deg")), sum)
    };
    let ((left, low), (right, high)) = (picture(0.0), picture(45.0));
    Item::figure("5.3", "Facets that add to the support volume and that carry, for two self-supported thresholds")
        .stand_in(part.instead)
        .picture(
            "turned by 10 degrees about X; blue adds, red carries",
            sheet("Figure 5.3", 2, vec![left, right], Vec::new()),
        )
        .row(
            Row::same("volume at 45 deg above that at 0 deg", "above", if high > low { "above" } else { "below" })
                .because(format!(
                    "{} and {} mm³",
                    figures((high * 1e4).round() / 1e4),
                    figures((low * 1e4).round() / 1e4)
                )),
        )
}

/// The slope of the logarithms of values by those of places.
fn slope(points: &[[f64; 2]]) -> f64 {
    let logs: Vec<[f64; 2]> = points.iter().map(|p| p.map(f64::ln)).collect();
    let n = logs.len() as f64;
    let mean = [0, 1].map(|k| logs.iter().map(|p| p[k]).sum::<f64>() / n);
    let (above, below) = logs
        .iter()
        .fold((0.0, 0.0), |(a, b), p| (a + (p[0] - mean[0]) * (p[1] - mean[1]), b + (p[0] - mean[0]).powi(2)));
    above / below
}

/// What it takes.
fn seconds(of: impl Fn() -> f64) -> f64 {
    let begun = Instant::now();
    std::hint::black_box(of());
    begun.elapsed().as_secs_f64()
}

fn scaling(run: &Run) -> Item {
    let caption = "Seconds for connectivity sets and for one evaluation, by number of facets";
    if run.quick {
        return Item::left(Kind::Figure, "5.4", caption, "seconds of this machine are not measured in a quick run");
    }
    let f = smooth(Cost::Volume, 0.0, 0.0, 10.0, 140.0);
    let (mut sets, mut once) = (Vec::new(), Vec::new());
    for cut in [3, 5, 7, 9, 11] {
        let mesh = cut_out(cut);
        // The best of three, since others may use the processor.
        let (mut first, mut again) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..3 {
            let facets = Facets::of(&mesh);
            // The first evaluation works out who sees whom.
            first = first.min(seconds(|| f.value(&facets, &up(0.0, 0.0))));
            again = again.min(seconds(|| f.value(&facets, &up(5.0, 0.0))));
        }
        let count = mesh.facets().len() as f64;
        sets.push([count, first]);
        once.push([count, again]);
    }
    let curves = vec![Curve::line("connectivity sets", sets.clone()), Curve::line("one evaluation", once.clone())];
    let why = "another machine and another program; ours finds who sees whom by a tree of facets";
    Item::figure("5.4", caption)
        .picture("", Chart::new("Figure 5.4", ["facets", "seconds"], curves).logarithmic().svg())
        .row(Row::open("slope for connectivity sets", "2.2", figures((100.0 * slope(&sets)).round() / 100.0), why))
        .row(Row::open("slope for an evaluation", "not printed", figures((100.0 * slope(&once)).round() / 100.0), why))
        .note(CUT)
}

fn converged(run: &Run) -> Item {
    let f = smooth(Cost::Volume, 0.0, 0.0, 10.0, 140.0);
    let cuts: &[usize] = if run.quick { &[1, 2, 3, 4, 5] } else { &[1, 2, 3, 4, 6, 8, 11] };
    let value = |&cut: &usize| {
        let facets = Facets::of(&cut_out(cut));
        [facets.each.len() as f64, f.value(&facets, &up(0.0, 0.0))]
    };
    let points: Vec<[f64; 2]> = cuts.iter().map(value).collect();
    let steps: Vec<f64> =
        points.windows(2).map(|pair| (pair[1][1] - pair[0][1]).abs() / (pair[1][0] - pair[0][0])).collect();
    let settles = steps.last() < steps.first();
    Item::figure("5.5", "Support volume by number of facets")
        .stand_in("figure 5.5a alone, on our cube with a cut-out; 5.5b is of the armadillo")
        .picture(
            "at 0 degrees",
            Chart::new("Figure 5.5a", ["facets", "mm³"], vec![Curve::line("connectivity sets", points)]).svg(),
        )
        .row(Row::same("\"a decrease in slope\" with finer meshes", "yes", if settles { "yes" } else { "no" }))
        .note(CUT)
}

/// Angles in degrees of a direction.
fn angles(up: &Vec3) -> [f64; 2] {
    let (a, b) = to_angles(up);
    [a.to_degrees(), b.to_degrees()]
}

/// A search from its start, with the places that it asked for.
fn traced(search: &dyn Search, f: &dyn Objective, facets: &Facets) -> (Found, Vec<[f64; 2]>) {
    let recorded = Recorded::new(f);
    let found = search.search(&recorded, facets);
    (found, recorded.taken().iter().map(angles).collect())
}

/// A search of table 5.1: name, search, function, printed value, place and evaluations.
type Tried<'a> = (&'a str, &'a dyn Search, &'a dyn Objective, f64, [f64; 2], f64);

/// Figure 5.6 and table 5.1.
fn methods(run: &Run, part: &Part) -> (Item, Item) {
    let f = objective();
    let start = Some(up(START[0], START[1]));
    // The same function without its gradient.
    let plain = Toy(|up: &Vec3| f.value(&part.facets, up));
    let by = |method| Descent { start, ..Descent::by(method) };
    let [bfgs, cg, newton] =
        [GradientMethod::Bfgs, GradientMethod::ConjugateGradient, GradientMethod::NewtonCg].map(by);
    let simplex = NelderMead { start, ..NelderMead::default() };
    let all: [Tried<'_>; 6] = [
        ("BFGS, gradients", &bfgs, &f, 15.050, [-83.582, -130.82], 13.0),
        ("BFGS, differences", &bfgs, &plain, 15.052, [-83.584, -130.96], 224.0),
        ("CG, gradients", &cg, &f, 15.050, [-83.582, -130.82], 25.0),
        ("CG, differences", &cg, &plain, 15.055, [-83.688, -131.08], 247.0),
        ("Newton-CG, gradients", &newton, &f, 15.050, [-83.592, -130.84], 12.0),
        ("Nelder-Mead", &simplex, &plain, 15.050, [-83.557, -130.81], 67.0),
    ];
    let mut table =
        Item::table("5.1", "Gradient-based searches from one start: value, place, evaluations").stand_in(part.instead);
    let why = "another part";
    let (mut curves, mut ends) = (Vec::new(), Vec::new());
    for (name, search, objective, value, place, evaluations) in all {
        let (found, path) = traced(search, objective, &part.facets);
        let Some(best) = found.minima.first().copied() else { continue };
        let [a, b] = angles(&best.up);
        let words = format!(
            "{} mm³ at [{a:.3}, {b:.3}], {} evaluations",
            figures((best.value * 1e4).round() / 1e4),
            found.evaluations
        );
        table.rows.push(Row::open(
            name,
            format!("{value} mm³ at [{}, {}], {evaluations} evaluations", place[0], place[1]),
            words,
            why,
        ));
        ends.push((found.evaluations, best.value));
        if !matches!(name, "BFGS, differences" | "CG, differences") {
            curves.push(Curve::line(name, path));
        }
    }
    let least = ends.iter().fold(f64::INFINITY, |least, end| least.min(end.1));
    let most = ends.iter().fold(f64::NEG_INFINITY, |most, end| most.max(end.1));
    table.rows.push(Row::absolute(
        "spread of the six values, % of the least",
        100.0 * (15.055 - 15.050) / 15.050,
        100.0 * (most - least) / least,
        0.5,
        "points",
    ));
    for (name, with, without) in [("BFGS", 0, 1), ("CG", 2, 3)] {
        let fewer = ends.get(with).zip(ends.get(without)).is_some_and(|(a, b)| a.0 < b.0);
        table.rows.push(Row::same(
            format!("{name}: fewer evaluations with gradients"),
            "fewer",
            if fewer { "fewer" } else { "more" },
        ));
    }
    let value = |a: f64, b: f64| f.value(&part.facets, &up(a, b));
    let plane = Plane {
        title: "Figure 5.6: support volume, mm³".to_owned(),
        axes: ["alpha, deg", "beta, deg"],
        range: [[-180.0, 180.0], [-90.0, 90.0]],
        fine: if run.quick || part.given { 40 } else { 90 },
        value: &value,
        curves,
    };
    let figure = Item::figure("5.6", "Contours of the support volume, and the ways of several searches")
        .stand_in(part.instead)
        .picture("beta from -90 to 90 covers the sphere once; the thesis draws it twice", plane.svg().0);
    (figure, table)
}

/// Figure 5.7 and table 5.2.
fn strategies(run: &Run, part: &Part) -> (Item, Item) {
    let f = objective();
    let four = Multistart {
        starts: 4,
        seed: 3,
        from: Starts::LatinHypercube,
        descent: Some(GradientMethod::Bfgs),
        ..Multistart::default()
    };
    let (found, path) = traced(&four, &f, &part.facets);
    let evolution = DifferentialEvolution::default();
    let (other, _) = traced(&evolution, &f, &part.facets);
    let best = |found: &Found| found.minima.first().map_or(f64::NAN, |m| m.value);
    let value = |a: f64, b: f64| f.value(&part.facets, &up(a, b));
    let plane = Plane {
        title: "Figure 5.7: support volume, mm³".to_owned(),
        axes: ["alpha, deg", "beta, deg"],
        range: [[-180.0, 180.0], [-90.0, 90.0]],
        fine: if run.quick || part.given { 40 } else { 90 },
        value: &value,
        curves: vec![
            Curve::dots("places asked for", path),
            Curve::dots("minima", found.minima.iter().map(|m| angles(&m.up)).collect()),
        ],
    };
    let figure = Item::figure("5.7", "Descents from four starts of a Latin hypercube")
        .stand_in(part.instead)
        .picture(format!("{} evaluations in all", found.evaluations), plane.svg().0);
    let why = "another part, other draws";
    let words = |found: &Found| {
        format!("{} mm³, {} evaluations", figures((best(found) * 1e4).round() / 1e4), found.evaluations)
    };
    let table = Item::table("5.2", "Gradient descent from four starts beside differential evolution")
        .stand_in(part.instead)
        .row(Row::open("gradient descent, four starts", "15.050 mm³, 181 evaluations", words(&found), why))
        .row(Row::open("differential evolution", "15.068 mm³, 708 evaluations", words(&other), why))
        .row(Row::same(
            "evaluations of differential evolution",
            "more",
            if other.evaluations > found.evaluations { "more" } else { "fewer" },
        ))
        .row(Row::open(
            "its value above that of the descents, % of the value as drawn",
            figures((1e5_f64 * (15.068 - 15.050) / 77.0).round() / 1e3),
            figures((1e5 * (best(&other) - best(&found)) / f.value(&part.facets, &Vec3::z())).round() / 1e3),
            "another part; both are heuristics, and here they end in different basins where the thesis's end in one",
        ));
    (figure, table)
}
