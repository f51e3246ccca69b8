//! Tables 3.1.1, 4.1.1 and 4.2.1: values of the objectives and their minima.

use trunnion::geom::{Angle, Vec3};
use trunnion::orient::{
    Certified, Facets, GradientMethod, Multistart, Objective, OverhangAngle, Search, Starts, WeightedNormalZ,
    from_angles, to_angles,
};

use super::super::item::{Item, Kind, Row, figures};
use super::super::sources::{Run, degrees};
use super::meshes::SURFACES;

const OVERHANG: OverhangAngle = OverhangAngle { theta: Angle::from_rad(std::f64::consts::FRAC_PI_4) };

pub(super) fn items(run: &Run) -> Vec<Item> {
    vec![angles(run), facets(run), minima(run)]
}

/// The same table with rows for the meshes that are given; left where none is.
fn table(
    number: &'static str,
    caption: &'static str,
    run: &Run,
    others: &str,
    row: impl Fn(usize, &Facets) -> Vec<Row>,
) -> Item {
    let mut item = Item::table(number, caption);
    let mut missing = Vec::new();
    for (i, surface) in SURFACES.iter().enumerate() {
        match surface.read(run) {
            Ok((_, facets)) => item.rows.extend(row(i, &facets)),
            Err(_) => missing.push(surface.file),
        }
    }
    if item.rows.is_empty() {
        return Item::left(Kind::Table, number, caption, format!("meshes not given: {}", missing.join(", ")));
    }
    item.note(format!(
        "Mesh not given: {}{others}.",
        missing.iter().map(|file| format!("{file}, ")).collect::<String>()
    ))
}

const OTHERS: &str = "Human skull and Human heart (SketchFab)";

fn angles(run: &Run) -> Item {
    table("3.1.1", "Sum of overhanging angles (equation 3.1.2): as drawn, and least", run, OTHERS, |i, facets| {
        let surface = &SURFACES[i];
        let name = surface.name;
        let mut rows =
            vec![Row::relative(format!("{name}: initial"), surface.initial, OVERHANG.value(facets, &Vec3::z()), 1e-4)];
        // The sign of beta is reversed in this table.
        let [a, b] = surface.angles.map(f64::to_radians);
        let there = OVERHANG.value(facets, &from_angles(a, -b));
        let found = Certified::of(&OVERHANG).search(&OVERHANG, facets);
        let best = found.minima.first().map_or(f64::NAN, |m| m.value);
        match surface.least {
            Some(least) => {
                rows.push(
                    Row::relative(format!("{name}: at the printed angles"), least, there, 2e-3)
                        .because("the sign of beta is reversed in this table"),
                );
                rows.push(
                    Row::relative(format!("{name}: least, proved"), least, best, 0.015)
                        .because("the thesis takes the least of a grid, which is a little above"),
                );
            }
            None => rows.push(Row::open(
                format!("{name}: least"),
                "not legible in our copy",
                figures(best),
                "the cell is damaged in the copy that we have",
            )),
        }
        rows
    })
}

fn facets(run: &Run) -> Item {
    table(
        "4.1.1",
        "Number of facets; the printed seconds for 65,341 evaluations are another machine's and left out",
        run,
        OTHERS,
        |i, facets| {
            let surface = &SURFACES[i];
            let found = Certified::default().search(&WeightedNormalZ, facets);
            let gap = found.lower_bound.map_or(f64::NAN, |bound| found.minima[0].value / bound - 1.0);
            vec![
                Row::absolute(
                    format!("{}: facets", surface.name),
                    surface.facets as f64,
                    facets.each.len() as f64,
                    0.0,
                    "facets",
                ),
                Row::absolute(format!("{}: gap to the proved bound, relative", surface.name), 0.0, gap, 1e-6, "")
                    .because(format!(
                        "{} evaluations and bounds in place of 65,341; the thesis proves nothing",
                        found.evaluations
                    )),
            ]
        },
    )
}

fn minima(run: &Run) -> Item {
    table(
        "4.2.1",
        "Angles of the least weighted sum (equation 4.0.3); random starts and the printed times are left out",
        run,
        OTHERS,
        |i, facets| {
            let surface = &SURFACES[i];
            let found = Certified::default().search(&WeightedNormalZ, facets);
            let Some(best) = found.minima.first() else { return Vec::new() };
            let printed = surface.direction(surface.x_min);
            let above = 100.0 * (WeightedNormalZ.value(facets, &printed) / best.value - 1.0);
            // In the printed frame, so that the two pairs can be read beside each other.
            let own = Vec3::from_fn(|axis, _| surface.direction_axis(axis).dot(&best.up));
            let (a, b) = to_angles(&own);
            let words = |a: f64, b: f64| format!("({a:.4}, {b:.4})");
            let mut rows = vec![
                Row::apart(
                    format!("{}: angles, rad", surface.name),
                    words(surface.x_min[0], surface.x_min[1]),
                    words(a, b),
                    degrees(&printed, &best.up),
                    6.0,
                )
                .because(surface.why),
                Row::absolute(
                    format!("{}: value at the printed angles above the proved least, %", surface.name),
                    0.0,
                    above,
                    3.0,
                    "points",
                )
                .because(surface.why),
            ];
            let centres = Multistart {
                starts: 32,
                from: Starts::GridCentres,
                descent: Some(GradientMethod::Bfgs),
                ..Multistart::default()
            }
            .search(&WeightedNormalZ, facets);
            let reached = centres.minima.first().map_or(f64::NAN, |m| m.value);
            rows.push(
                Row::absolute(
                    format!("{}: best of 32 starts above the least, %", surface.name),
                    0.0,
                    100.0 * (reached / best.value - 1.0),
                    0.1,
                    "points",
                )
                .because("from true centres; the thesis's program computes (i + h) / 2 for i + h / 2"),
            );
            rows
        },
    )
}
