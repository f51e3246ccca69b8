//! Surfaces before and after, and landscapes of objectives.

use std::f64::consts::{FRAC_PI_3, FRAC_PI_4};

use trunnion::fixtures::cube;
use trunnion::geom::{Angle, Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{
    Alexander, Certified, Facets, Multistart, NelderMead, Objective, OverhangAngle, Search, Starts, WeightedNormalZ,
    from_angles, overhang_area, to_angles, turned,
};
use trunnion::view::Frame;

use super::super::chart::{Chart, Curve, Plane};
use super::super::item::{Item, Kind, Row, figures};
use super::super::scene::{RED, frame, painted, sheet};
use super::super::sources::{Recorded, Run};
use super::meshes::{Surface, named};

const OVERHANG: OverhangAngle = OverhangAngle { theta: Angle::from_rad(FRAC_PI_4) };
const QUARTER: f64 = 45.0;

/// Figure 4.2.3: the 32 centres of a grid of 45 degrees.
pub(super) fn centres() -> Item {
    let recorded = Recorded::new(&WeightedNormalZ);
    let search = Multistart { starts: 32, from: Starts::GridCentres, budget: 1, ..Multistart::default() };
    let _ = search.search(&recorded, &Facets::of(&cube().parts[0].1));
    let mut places: Vec<[f64; 2]> = recorded.taken().iter().map(angles).collect();
    places.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0])));
    places.dedup_by(|a, b| (a[0] - b[0]).abs() < 1e-6 && (a[1] - b[1]).abs() < 1e-6);
    let wanted = |i: usize| [-180.0 + QUARTER * ((i % 8) as f64 + 0.5), -90.0 + QUARTER * ((i / 8) as f64 + 0.5)];
    let off = places
        .iter()
        .enumerate()
        .map(|(i, at)| (0..2).map(|k| (at[k] - wanted(i)[k]).abs()).fold(0.0, f64::max))
        .fold(0.0, f64::max);
    let chart = Chart::new(
        "Figure 4.2.3: starting points",
        ["theta 1, deg", "theta 2, deg"],
        vec![Curve::dots("centres of intervals of 45 deg", places.clone())],
    );
    Item::figure("4.2.3", "Starting points in the centres of intervals of pi/4")
        .picture("", chart.svg())
        .row(Row::absolute("starting points", 32.0, places.len() as f64, 0.0, "points"))
        .row(
            Row::absolute("largest distance from the centres", 0.0, off, 1e-6, "deg")
                .because("the thesis's program, unlike its text, computes (i + h) / 2 for i + h / 2"),
        )
}

fn angles(up: &Vec3) -> [f64; 2] {
    let (a, b) = to_angles(up);
    [a.to_degrees(), b.to_degrees()]
}

pub(super) fn items(run: &Run) -> Vec<Item> {
    vec![
        about_z(run),
        gallery(run),
        before_and_after(
            run,
            "3.1.5",
            "Horse and knight before and after minimizing overhanging angles",
            &["Horse", "Knight"],
            &OVERHANG,
        ),
        landscape(
            run,
            "3.1.6",
            "Sum of overhanging angles of the horse over both rotations",
            "Horse",
            &OVERHANG,
            Vec::new(),
        ),
        before_and_after(
            run,
            "3.1.7",
            "Horse before and after; the slicing program's pictures are not remade",
            &["Horse"],
            &OVERHANG,
        ),
        before_and_after(run, "3.1.8", "Max before and after; photographs are not remade", &["Max"], &OVERHANG),
        before_and_after(run, "3.1.9", "Bunny before and after: more overhangs than before", &["Bunny"], &OVERHANG),
        before_and_after(run, "3.2.3", "Cow before and after minimizing overhanging angles", &["Cow"], &OVERHANG),
        landscape(
            run,
            "3.4.1",
            "Weighted sum (equation 3.2.4) of the bunny over both rotations",
            "Bunny",
            &WeightedNormalZ,
            Vec::new(),
        ),
        before_and_after(
            run,
            "3.4.2",
            "Camel, cow and Max before and after minimizing equation 3.2.4",
            &["Camel", "Cow", "Max"],
            &WeightedNormalZ,
        ),
        before_and_after(
            run,
            "3.4.3",
            "Bunny before and after; the slicing program's pictures are not remade",
            &["Bunny"],
            &WeightedNormalZ,
        ),
        beside_alexander(run, "3.4.4", "Cow by equation 3.2.4 and by Alexander's method", "Cow"),
        beside_alexander(run, "3.4.5", "Knight by equation 3.2.4 and by Alexander's method", "Knight"),
        landscape(
            run,
            "4.2.1",
            "Objective 4.0.3 of the knight over both rotations",
            "Knight",
            &WeightedNormalZ,
            Vec::new(),
        ),
        local(run),
        before_and_after(
            run,
            "4.2.4",
            "Knight, horse, bunny and arm before and after the optimal rotation",
            &["Knight", "Horse", "Bunny", "Arm"],
            &WeightedNormalZ,
        ),
        random(run),
    ]
}

/// A surface in a pose, with what overhangs by more than 45 degrees in red.
fn posed(mesh: &TriangleMesh<Object>, up: &Vec3, words: &str) -> Frame {
    let pose: TriangleMesh<Object> = turned(mesh, up);
    let steep = -FRAC_PI_4.sin();
    let red = |facet: usize| pose.normal(facet).is_some_and(|n| n.z < steep).then_some(RED);
    frame(vec![painted(&pose, red)], words)
}

fn best(f: &dyn Objective, facets: &Facets) -> Vec3 {
    Certified::of(f).search(f, facets).minima.first().map_or(Vec3::z(), |m| m.up)
}

fn left(number: &'static str, caption: &'static str, why: String) -> Item {
    Item::left(Kind::Figure, number, caption, why)
}

/// Figure 3.0.1: a turn about the vertical changes nothing.
fn about_z(run: &Run) -> Item {
    let (number, caption) = ("3.0.1", "Camel before and after a turn about the z-axis: the same overhangs");
    let mesh = match named("Camel").read(run) {
        Ok((mesh, _)) => mesh,
        Err(why) => return left(number, caption, why),
    };
    let (s, c) = FRAC_PI_3.sin_cos();
    let turn = |p: &Vec3| Vec3::new(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
    let turned = TriangleMesh::new(mesh.vertices().iter().map(turn).collect(), mesh.facets().to_vec());
    let area = |mesh: &TriangleMesh<Object>| overhang_area(&Facets::of(mesh), &Vec3::z(), Angle::from_deg(45.0));
    let frames = vec![posed(&mesh, &Vec3::z(), "as drawn"), posed(&turned, &Vec3::z(), "turned by 60 degrees")];
    Item::figure(number, caption)
        .picture("overhanging by more than 45 degrees in red", sheet("Figure 3.0.1", 2, frames, Vec::new()))
        .row(Row::relative("overhanging area after the turn, beside before", area(&mesh), area(&turned), 1e-6))
}

fn gallery(run: &Run) -> Item {
    let (number, caption) = ("3.1.4", "The surfaces of the tests");
    let all: Vec<(&Surface, TriangleMesh<Object>)> =
        super::meshes::SURFACES.iter().filter_map(|surface| Some((surface, surface.read(run).ok()?.0))).collect();
    if all.is_empty() {
        return left(number, caption, "meshes not given".to_owned());
    }
    // Each 10 mm long, so that all are seen on one scale.
    let frames = all.iter().map(|(surface, mesh)| {
        let scale = 10.0 / mesh.bounds().size().max();
        let small = TriangleMesh::new(mesh.vertices().iter().map(|p| p * scale).collect(), mesh.facets().to_vec());
        frame(vec![painted::<Object>(&small, |_| None)], surface.name)
    });
    Item::figure(number, caption)
        .picture("", sheet("Figure 3.1.4", 4, frames.collect(), Vec::new()))
        .row(Row::absolute("surfaces, skull and heart not among them", 7.0, all.len() as f64, 0.0, "surfaces"))
}

fn before_and_after(run: &Run, number: &'static str, caption: &'static str, names: &[&str], f: &dyn Objective) -> Item {
    let mut item = Item::figure(number, caption);
    for name in names {
        let (mesh, facets) = match named(name).read(run) {
            Ok(read) => read,
            Err(why) => return left(number, caption, why),
        };
        let up = best(f, &facets);
        let frames =
            vec![posed(&mesh, &Vec3::z(), &format!("{name} as drawn")), posed(&mesh, &up, &format!("{name} rotated"))];
        item.pictures.push((String::new(), sheet(caption, 2, frames, Vec::new())));
        let [before, after] = [Vec3::z(), up].map(|up| f.value(&facets, &up));
        item.rows.push(
            Row::same(
                format!("{name}: the objective after the rotation"),
                "less",
                if after < before { "less" } else { "not less" },
            )
            .because(format!("{} before, {} after", figures(before), figures(after))),
        );
    }
    item
}

fn landscape(
    run: &Run,
    number: &'static str,
    caption: &'static str,
    name: &str,
    f: &dyn Objective,
    curves: Vec<Curve>,
) -> Item {
    let facets = match named(name).read(run) {
        Ok((_, facets)) => facets,
        Err(why) => return left(number, caption, why),
    };
    let value = |a: f64, b: f64| f.value(&facets, &from_angles(a.to_radians(), b.to_radians()));
    let least = best(f, &facets);
    let mut curves = curves;
    curves.push(Curve::dots("least, proved", vec![angles(&least)]));
    let plane = Plane {
        title: format!("Figure {number}: {name}"),
        axes: ["rotation about x, deg", "rotation about y, deg"],
        range: [[-180.0, 180.0], [-90.0, 90.0]],
        fine: 90,
        value: &value,
        curves,
    };
    let (svg, [low, high]) = plane.svg();
    let proved = f.value(&facets, &least);
    Item::figure(number, caption).picture("", svg).row(Row::open(
        "least and largest value of the picture",
        "not printed",
        format!("{} and {}; least proved {}", figures(low), figures(high), figures(proved)),
        "the figure has colours alone",
    ))
}

fn alexander(mesh: &TriangleMesh<Object>) -> (Vec3, f64) {
    // 60 mm long, in the thesis's numbers: layers and sides of 1 mm, penalty 10 cm.
    let scale = 60.0 / mesh.bounds().size().max();
    let facets = Facets::of(&TriangleMesh::<Object>::new(
        mesh.vertices().iter().map(|p| p * scale).collect(),
        mesh.facets().to_vec(),
    ));
    let f = Alexander { layer_mm: 1.0, sides_mm: [1.0; 2], penalty_mm: 100.0, overhang: Angle::from_deg(45.0) };
    let search = Multistart { starts: 12, budget: 60, ..Multistart::default() };
    (search.search(&f, &facets).minima.first().map_or(Vec3::z(), |m| m.up), scale)
}

fn beside_alexander(run: &Run, number: &'static str, caption: &'static str, name: &str) -> Item {
    let (mesh, facets) = match named(name).read(run) {
        Ok(read) => read,
        Err(why) => return left(number, caption, why),
    };
    let ours = best(&WeightedNormalZ, &facets);
    let (theirs, _) = alexander(&mesh);
    let area = |up: &Vec3| overhang_area(&facets, up, Angle::from_deg(45.0)) / facets.mass().area_mm2 * 100.0;
    let frames = vec![posed(&mesh, &ours, "by equation 3.2.4"), posed(&mesh, &theirs, "by Alexander's method")];
    Item::figure(number, caption)
        .picture("overhanging by more than 45 degrees in red", sheet(caption, 2, frames, Vec::new()))
        .row(Row::open(
            "overhanging share of the surface, %",
            "not printed",
            format!(
                "{} and {}",
                figures((area(&ours) * 10.0).round() / 10.0),
                figures((area(&theirs) * 10.0).round() / 10.0)
            ),
            "the figure shows colours alone",
        ))
}

/// Figure 4.2.2: a local minimum beside the global one.
fn local(run: &Run) -> Item {
    let (number, caption) = ("4.2.2", "Knight at the global minimum and at a local one");
    let (mesh, facets) = match named("Knight").read(run) {
        Ok(read) => read,
        Err(why) => return left(number, caption, why),
    };
    let global = best(&WeightedNormalZ, &facets);
    let all = NelderMead::default().search(&WeightedNormalZ, &facets);
    let value = |up: &Vec3| WeightedNormalZ.value(&facets, up);
    let Some(other) = all.minima.iter().find(|m| m.value > 1.02 * value(&global)) else {
        return left(number, caption, "no local minimum was found".to_owned());
    };
    let frames = vec![posed(&mesh, &global, "global minimum"), posed(&mesh, &other.up, "a local minimum")];
    Item::figure(number, caption)
        .picture("overhanging by more than 45 degrees in red", sheet(caption, 2, frames, Vec::new()))
        .row(
            Row::same(
                "the local one is higher",
                "higher",
                if other.value > value(&global) { "higher" } else { "lower" },
            )
            .because(format!(
                "{} and {}; the starting point is not printed",
                figures(value(&global)),
                figures(other.value)
            )),
        )
}

/// Figure 4.2.5: random starting points.
fn random(run: &Run) -> Item {
    let recorded = Recorded::new(&WeightedNormalZ);
    let search = Multistart { starts: 100, from: Starts::Random, budget: 1, ..Multistart::default() };
    let _ = search.search(&recorded, &Facets::of(&cube().parts[0].1));
    let places: Vec<[f64; 2]> = recorded.taken().iter().map(angles).collect();
    let count = places.len();
    let curves = vec![Curve::dots("random starting points", places)];
    let item = landscape(
        run,
        "4.2.5",
        "Random starting points over the objective of the knight",
        "Knight",
        &WeightedNormalZ,
        curves,
    );
    if item.is_left() {
        return item;
    }
    item.row(Row::absolute("starting points", 100.0, count as f64, 0.0, "points"))
}
