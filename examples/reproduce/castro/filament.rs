//! Tables 3.1.2, 3.1.3 and 3.4.1: filament and time in the usual pose and in the new one, which the thesis reads from a slicing program.

use trunnion::geom::{Angle, Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{
    Alexander, Certified, Facets, Multistart, Objective, OverhangAngle, Priced, Process, Search, WeightedNormalZ,
    recommend,
};

use super::super::item::{Item, Kind, Row};
use super::super::sources::Run;
use super::meshes::named;

/// Length of filament in metres, time in minutes: usual pose, new pose.
struct Printed {
    name: &'static str,
    metres: [f64; 2],
    minutes: [f64; 2],
}

const fn printed(name: &'static str, metres: [f64; 2], minutes: [f64; 2]) -> Printed {
    Printed { name, metres, minutes }
}

const LESS: [Printed; 3] = [
    printed("Horse", [6.09, 5.41], [126.0, 124.0]),
    printed("Max", [10.05, 7.47], [188.0, 156.0]),
    printed("Knight", [5.79, 5.62], [137.0, 131.0]),
];
const MORE: [Printed; 4] = [
    printed("Arm", [1.86, 1.23], [39.0, 54.0]),
    printed("Bunny", [7.85, 8.78], [161.0, 181.0]),
    printed("Camel", [6.04, 6.65], [130.0, 144.0]),
    printed("Cow", [7.16, 8.35], [151.0, 170.0]),
];
const OURS: [Printed; 7] = [
    printed("Arm", [4.82, 3.32], [100.0, 76.0]),
    printed("Horse", [5.80, 3.51], [123.0, 93.0]),
    printed("Max", [9.47, 6.43], [183.0, 135.0]),
    printed("Knight", [5.57, 4.09], [134.0, 102.0]),
    printed("Bunny", [7.52, 7.10], [158.0, 150.0]),
    printed("Camel", [5.81, 3.88], [128.0, 94.0]),
    printed("Cow", [6.86, 4.65], [148.0, 124.0]),
];
/// Metres in Alexander's pose, in the order of [`OURS`].
const ALEXANDER: [f64; 7] = [4.14, 6.39, 6.46, 5.65, 8.63, 5.79, 6.73];

const WHY: &str = "Printed are values of a slicing program of 2019 with settings and a scale that are not given; ours is the library's \
                   estimate, scaled so that the usual pose needs the printed filament. Weights in grams and Alexander's times are left out";

pub(super) fn items(run: &Run) -> Vec<Item> {
    let angle = OverhangAngle { theta: Angle::from_deg(45.0) };
    vec![
        table(
            run,
            "3.1.2",
            "Filament and time after minimizing overhanging angles: less than before",
            &LESS,
            &angle,
            None,
        ),
        table(
            run,
            "3.1.3",
            "Filament and time after minimizing overhanging angles: more than before",
            &MORE,
            &angle,
            None,
        ),
        table(
            run,
            "3.4.1",
            "Filament and time after minimizing equation 3.2.4, beside Alexander's method",
            &OURS,
            &WeightedNormalZ,
            Some(&ALEXANDER),
        ),
    ]
}

fn table(
    run: &Run,
    number: &'static str,
    caption: &'static str,
    rows: &[Printed],
    f: &dyn Objective,
    alexander: Option<&[f64]>,
) -> Item {
    let mut item = Item::table(number, caption)
        .stand_in("filament and time by the library's estimate in place of the slicing program");
    let mut missing = vec!["Human skull and Human heart".to_owned()];
    for (i, row) in rows.iter().enumerate() {
        let Ok((mesh, facets)) = named(row.name).read(run) else {
            missing.push(named(row.name).file.to_owned());
            continue;
        };
        let best = Certified::of(f).search(f, &facets).minima.first().map(|m| m.up);
        let Some((scale, usual, new)) = best.and_then(|best| scaled(&mesh, row.metres[0], best)) else {
            missing.push(format!("{} (no estimate)", row.name));
            continue;
        };
        item.rows.push(length(row, "length in the new pose", row.metres[1], metres(&new)));
        let share = |pair: [f64; 2]| 100.0 * pair[1] / pair[0];
        let percent = |pair: [f64; 2]| format!("{:.1}", share(pair));
        item.rows.push(Row::open(
            format!("{}: time in the new pose, % of the usual", row.name),
            percent(row.minutes),
            percent([minutes(&usual), minutes(&new)]),
            ESTIMATE,
        ));
        if let Some(lengths) = alexander
            && let Some((.., priced)) = scaled(&mesh, row.metres[0], by_alexander(&mesh, scale))
        {
            item.rows.push(length(row, "length in Alexander's pose", lengths[i], metres(&priced)));
        }
    }
    if item.rows.is_empty() {
        return Item::left(Kind::Table, number, caption, format!("meshes not given: {}", missing.join(", ")));
    }
    item.note(format!("Mesh not given: {}. The usual pose is the file's own. {WHY}.", missing.join(", ")))
}

/// Estimates are told and not judged: they may be half of the printed value off, and on the other side of the usual pose.
const ESTIMATE: &str = "an estimate: see below";

fn length(row: &Printed, what: &str, printed: f64, ours: f64) -> Row {
    let side = |metres: f64| if metres < row.metres[0] { "less" } else { "more" };
    let told = |metres: f64| format!("{metres:.2}, {} than in the usual pose", side(metres));
    Row::open(format!("{}: {what}, m", row.name), told(printed), told(ours), ESTIMATE)
}

/// Square of a filament of 1.75 mm, mm².
const FILAMENT_MM2: f64 = std::f64::consts::PI * 1.75 * 1.75 / 4.0;
/// PLA, g/mm³, as the library's estimate has it.
const GRAMS_PER_MM3: f64 = 1.24e-3;

fn metres(pose: &Priced) -> f64 {
    (pose.part.grams + pose.supports.grams) / GRAMS_PER_MM3 / FILAMENT_MM2 / 1000.0
}

fn minutes(pose: &Priced) -> f64 {
    pose.part.minutes + pose.supports.minutes
}

/// Scales that are tried.
const MOST_SCALES: usize = 50;

/// The scale at which the part as it lies needs so many metres, and both poses there; `None` for what is no part.
fn scaled(mesh: &TriangleMesh<Object>, wanted: f64, up: Vec3) -> Option<(f64, Priced, Priced)> {
    let mut scale = 60.0 / mesh.bounds().size().max();
    let process = Process::default();
    for _ in 0..MOST_SCALES {
        let facets = Facets::of(&grown(mesh, scale));
        let made = recommend(&facets, &process, Some(up), Some(100));
        let length = metres(&made.as_it_lies);
        if (length / wanted - 1.0).abs() < 2e-3 {
            let own = made.own.unwrap_or(made.as_it_lies);
            return Some((scale, made.as_it_lies, own));
        }
        if !(length.is_finite() && length > 0.0) {
            return None;
        }
        // Filament grows with a power between that of surfaces and that of volumes.
        scale *= (wanted / length).powf(1.0 / 2.5);
    }
    None
}

fn grown(mesh: &TriangleMesh<Object>, scale: f64) -> TriangleMesh<Object> {
    TriangleMesh::new(mesh.vertices().iter().map(|p| p * scale).collect(), mesh.facets().to_vec())
}

/// The pose by Alexander's method with the thesis's numbers: layers and sides of 1 mm, penalty 10 (in cm, as all of them).
fn by_alexander(mesh: &TriangleMesh<Object>, scale: f64) -> Vec3 {
    let f = Alexander { layer_mm: 1.0, sides_mm: [1.0; 2], penalty_mm: 100.0, overhang: Angle::from_deg(45.0) };
    let facets = Facets::of(&grown(mesh, scale));
    let search = Multistart { starts: 12, budget: 60, ..Multistart::default() };
    search.search(&f, &facets).minima.first().map_or(Vec3::z(), |m| m.up)
}
