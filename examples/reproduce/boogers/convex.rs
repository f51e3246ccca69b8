//! Chapter 3: the support volume of convex shapes, exact and smoothed. Figures 3.2 and 3.5 to 3.9.

use trunnion::geom::Angle;
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{Cost, Facets, Objective, Smoothing, SupportVolumeConvex};

use super::super::chart::{Chart, Curve};
use super::super::item::{Item, Kind, Row, figures};
use super::super::scene::{AMBER, frame, painted, sheet};
use super::super::sources::Run;
use super::shapes::{by_angles, smooth, unit_cube, up};

const ROUND: [f64; 2] = [-180.0, 180.0];
const EXACT: SupportVolumeConvex = SupportVolumeConvex { overhang: Angle::ZERO };
/// As good as no smoothing.
const SHARP: f64 = 1e9;

pub(super) fn items(run: &Run) -> Vec<Item> {
    vec![square(), mask(run), heaviside(), by_k(), by_w(), both()]
}

/// Figure 3.2: a square is a cube of which only the area across X counts.
fn square() -> Item {
    let facets = Facets::of(&unit_cube());
    let area = |theta: f64| EXACT.value(&facets, &up(theta, 0.0));
    let slope =
        |theta: f64| EXACT.gradient(&facets, &up(theta, 0.0)).map_or(f64::NAN, |g| g.dot(&by_angles(theta, 0.0)[0]));
    let (sin, cos) = (|t: f64| t.to_radians().sin(), |t: f64| t.to_radians().cos());
    let specific = move |t: f64| (sin(t) * cos(t)).abs();
    // Equation 3.2.
    let derived = move |t: f64| sin(4.0 * t) / (2.0 * sin(2.0 * t).abs());
    let values = Chart::new(
        "Figure 3.2a: support area",
        ["theta, deg", "area"],
        vec![Curve::of("equation 3.1", ROUND, 361, specific), Curve::of("library, from facets", ROUND, 73, area)],
    );
    let slopes = Chart::new(
        "Figure 3.2b: its derivative",
        ["theta, deg", "per radian"],
        vec![Curve::of("equation 3.2", ROUND, 720, derived), Curve::of("library, from facets", ROUND, 720, slope)],
    );
    let mut item = Item::figure("3.2", "Support area of a unit square by its formula and from its facets")
        .picture("", values.svg())
        .picture("", slopes.svg());
    for theta in [20.0, 45.0, 70.0, 110.0, -30.0] {
        item.rows.push(Row::relative(
            format!("area at {theta} deg (equation 3.1)"),
            specific(theta),
            area(theta),
            1e-9,
        ));
    }
    for theta in [20.0, 70.0, -30.0] {
        item.rows.push(Row::relative(
            format!("derivative at {theta} deg (equation 3.2)"),
            derived(theta),
            slope(theta),
            1e-9,
        ));
    }
    item.note("The square is the section of a cube of side 1, turned about X; its volume is the square's area.")
}

/// Figure 3.5: which facets of the bunny overhang.
fn mask(run: &Run) -> Item {
    let caption = "Binary mask of overhanging facets on a bunny";
    let mesh = match run.mesh("bunny.off") {
        Ok(mesh) => upright(&mesh),
        Err(why) => return Item::left(Kind::Figure, "3.5", caption, why),
    };
    let hangs = |facet: usize| mesh.normal(facet).is_some_and(|n| n.z < 0.0);
    let down = (0..mesh.facets().len()).filter(|facet| hangs(*facet)).count();
    let picture = frame(vec![painted(&mesh, |facet| hangs(facet).then_some(AMBER))], "overhanging facets in amber");
    Item::figure("3.5", caption)
        .stand_in("the bunny of 6,966 facets of de Castro (2020); the thesis decimates its own")
        .picture("", sheet("Figure 3.5", 1, vec![picture], Vec::new()))
        .row(Row::open(
            "overhanging facets",
            "not printed",
            format!("{down} of {}", mesh.facets().len()),
            "the figure has no numbers",
        ))
}

/// The bunny's file has Y up.
pub(super) fn upright<F>(mesh: &TriangleMesh<F>) -> TriangleMesh<F> {
    let points = mesh.vertices().iter().map(|p| trunnion::geom::Vec3::new(p.x, -p.z, p.y)).collect();
    TriangleMesh::new(points, mesh.facets().to_vec())
}

/// Figure 3.6: the step by itself.
fn heaviside() -> Item {
    let step =
        |k: f64, overhang: f64| Smoothing { overhang: Angle::from_deg(overhang), carrying: Angle::ZERO, k, w: 40.0 };
    let curve = |name: String, s: Smoothing| Curve::of(name, [-1.0, 1.0], 200, move |z| s.hangs(z)[0]);
    let ks = [2.0, 5.0, 10.0, 20.0, 50.0].map(|k| curve(format!("k = {k}"), step(k, 0.0)));
    let ts = [0.0, 15.0, 30.0, 45.0, 60.0].map(|t| curve(format!("t = {} deg", 90.0 - t), step(20.0, t)));
    let axes = ["z-component of the facet's normal", "H"];
    let mut item = Item::figure("3.6", "Smooth Heaviside step for several k and thresholds")
        .picture("", Chart::new("Figure 3.6a: k", axes, ks.into()).svg())
        .picture("", Chart::new("Figure 3.6b: threshold, k = 20", axes, ts.into()).svg());
    for t in [90.0, 60.0, 45.0] {
        let s = step(20.0, 90.0 - t);
        let at = -f64::cos(f64::to_radians(t));
        item.rows.push(Row::absolute(format!("H at the threshold, t = {t} deg"), 0.5, s.hangs(at)[0], 1e-12, ""));
        // Equation 3.28 by x = n_z.
        let printed = -2.0 * 20.0 * 0.5 * 0.5;
        item.rows.push(Row::relative(
            format!("slope there (equation 3.28), t = {t} deg"),
            printed,
            s.hangs(at)[1],
            1e-12,
        ));
    }
    item.note("The thesis counts the threshold t from the bed; trunnion counts overhangs from the vertical, 90 degrees less t.")
}

/// The largest support volume of the cube when turned about X: a quarter of its height times its width, at 45 degrees.
const LARGEST: f64 = 0.5;

/// Figure 3.7: the step on a cube.
fn by_k() -> Item {
    let facets = Facets::of(&unit_cube());
    let value = |k: f64, theta: f64| smooth(Cost::Convex, 0.0, 0.0, k, SHARP).value(&facets, &up(theta, 0.0));
    let exact = |theta: f64| EXACT.value(&facets, &up(theta, 0.0));
    let ks = [2.0, 5.0, 10.0, 20.0, 50.0];
    let mut curves: Vec<Curve> =
        ks.iter().map(|&k| Curve::of(format!("k = {k}"), ROUND, 361, |t| value(k, t))).collect();
    curves.push(Curve::of("without smoothing", ROUND, 361, exact));
    let errors = ks.iter().map(|&k| Curve::of(format!("k = {k}"), ROUND, 361, |t| value(k, t) - exact(t))).collect();
    let mut item = Item::figure("3.7", "Support volume of a unit cube with the smooth step, and its error")
        .picture("", Chart::new("Figure 3.7a: volume", ["rotation about x, deg", "mm³"], curves).svg())
        .picture("", Chart::new("Figure 3.7b: error", ["rotation about x, deg", "mm³"], errors).svg())
        .row(
            Row::relative("largest volume, without smoothing", LARGEST, exact(45.0), 1e-9)
                .because("computed from equation 3.1"),
        );
    for (k, within) in [(10.0, 1e-5), (20.0, 1e-8), (50.0, 1e-8)] {
        let row = Row::relative(
            format!("volume at the stationary point of 45 deg, k = {k}"),
            LARGEST,
            value(k, 45.0),
            within,
        );
        item.rows.push(row.because("\"at stationary points, the error approaches zero for larger values of k\""));
    }
    item
}

/// Figure 3.8: the lowest point on a cube.
fn by_w() -> Item {
    let facets = Facets::of(&unit_cube());
    let value = |w: f64, theta: f64| smooth(Cost::Convex, 0.0, 0.0, SHARP, w).value(&facets, &up(theta, 0.0));
    let exact = |theta: f64| EXACT.value(&facets, &up(theta, 0.0));
    let ws = [10.0, 20.0, 40.0, 100.0, 400.0];
    let mut curves: Vec<Curve> =
        ws.iter().map(|&w| Curve::of(format!("w = {w}"), ROUND, 361, |t| value(w, t))).collect();
    curves.push(Curve::of("without smoothing", ROUND, 361, exact));
    let errors = ws.iter().map(|&w| Curve::of(format!("w = {w}"), ROUND, 361, |t| value(w, t) - exact(t))).collect();
    let mut item = Item::figure("3.8", "Support volume of a unit cube with the smooth lowest point, and its error")
        .picture("", Chart::new("Figure 3.8a: volume", ["rotation about x, deg", "mm³"], curves).svg())
        .picture("", Chart::new("Figure 3.8b: error", ["rotation about x, deg", "mm³"], errors).svg());
    let count = facets.points.len() as f64;
    for w in [40.0, 100.0, 400.0] {
        let s = smooth(Cost::Convex, 0.0, 0.0, SHARP, w).smoothing;
        let low = s.bed(&facets, &up(30.0, 0.0)).0;
        let mellow = low + count.ln() / w;
        let printed = mellowmin(&facets, &up(30.0, 0.0), w);
        let row = Row::absolute(
            format!("lowest point at 30 deg, w = {w} (equation 3.29)"),
            printed,
            low,
            count.ln() / w + 1e-9,
            "mm",
        );
        item.rows.push(row.because(format!(
            "ours lacks the 1/n of the equation, which lifts the bed by ln(n)/w = {} mm",
            figures(count.ln() / w)
        )));
        item.rows.push(Row::absolute(format!("the same with ln(n)/w added, w = {w}"), printed, mellow, 1e-9, "mm"));
    }
    let off = |w: f64| (value(w, 45.0) - exact(45.0)).abs();
    item.row(Row::same(
        "the error falls as w grows",
        "yes",
        if off(40.0) > off(100.0) && off(100.0) > off(400.0) { "yes" } else { "no" },
    ))
}

/// Equation 3.29 as it is printed, of heights along a direction.
fn mellowmin(facets: &Facets, up: &trunnion::geom::Vec3, w: f64) -> f64 {
    let mean = facets.points.iter().map(|p| (-w * p.dot(up)).exp()).sum::<f64>() / facets.points.len() as f64;
    -mean.ln() / w
}

/// Figure 3.9: both at once, and the derivative.
fn both() -> Item {
    let facets = Facets::of(&unit_cube());
    let soft = smooth(Cost::Convex, 0.0, 0.0, 5.0, 20.0);
    let value = |f: &dyn Objective, t: f64| f.value(&facets, &up(t, 0.0));
    let slope =
        |f: &dyn Objective, t: f64| f.gradient(&facets, &up(t, 0.0)).map_or(f64::NAN, |g| g.dot(&by_angles(t, 0.0)[0]));
    let curves = |of: &dyn Fn(&dyn Objective, f64) -> f64| {
        vec![
            Curve::of("without smoothing", ROUND, 720, |t| of(&EXACT, t)),
            Curve::of("k = 5, w = 20", ROUND, 720, |t| of(&soft, t)),
        ]
    };
    let mut item = Item::figure("3.9", "Support volume and its derivative, with both smoothings and without")
        .picture("", Chart::new("Figure 3.9a: volume", ["rotation about x, deg", "mm³"], curves(&value)).svg())
        .picture(
            "",
            Chart::new("Figure 3.9b: derivative", ["rotation about x, deg", "per radian"], curves(&slope)).svg(),
        );
    for theta in [0.0, 45.0, 90.0, 135.0] {
        let row = Row::absolute(
            format!("derivative of the smooth volume at {theta} deg"),
            0.0,
            slope(&soft, theta),
            1e-9,
            "per rad",
        );
        item.rows.push(row.because("\"the locations of stationary points remain equal\""));
    }
    item
}
