//! Build directions of the documents' own meshes, against the values in their tables (re-run), and the verb `orient`.

use std::path::PathBuf;

use trunnion::geom::{Angle, Vec3};
use trunnion::mesh::{ReadOptions, Repair, Unit, read_model, read_surface};
use trunnion::orient::{
    Certified, DifferentialEvolution, Direct, Facets, GradientMethod, GridSearch, Height, Multistart, NelderMead,
    Objective, ObjectiveSettings, OverhangAngle, Search, Starts, Stop, TanhOverhang, WeightedNormalZ, from_angles,
    objective,
};

use crate::orient_sample::anywhere;
use crate::pipeline::fixture;
use crate::solids::lump;
use crate::support::{Numbers, fails, folder, note, root, skip, states, trunnion};

/// The documents' meshes: beside the repository, or where TRUNNION_MESHES says.
pub(crate) fn meshes() -> Option<PathBuf> {
    let given = std::env::var_os("TRUNNION_MESHES").map(PathBuf::from);
    let folder = given.unwrap_or_else(|| root().join("../shared/data/meshes"));
    if !folder.is_dir() {
        skip(&format!("no meshes in {} (TRUNNION_MESHES says where)", folder.display()));
        return None;
    }
    Some(folder)
}

/// A document's mesh in its file's own numbers: the tables know no unit.
pub(crate) fn facets(folder: &std::path::Path, name: &str) -> Facets {
    let bytes = std::fs::read(folder.join(name)).unwrap();
    let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
    Facets::of(&read_surface(&bytes, name, &options).unwrap())
}

pub(crate) fn near(got: f64, wanted: f64, relative: f64, what: &str) {
    assert!((got - wanted).abs() <= relative * wanted.abs(), "{what}: {got} for {wanted}");
}

/// A value printed with so many digits is known to half of its last one.
pub(crate) struct Castro {
    pub(crate) file: &'static str,
    facets: usize,
    least: f64,
    angles: (f64, f64),
    unrotated: f64,
    overhang: f64,
    overhang_least: f64,
}

const fn castro(
    file: &'static str,
    facets: usize,
    least: f64,
    angles: (f64, f64),
    [unrotated, overhang, overhang_least]: [f64; 3],
) -> Castro {
    Castro { file, facets, least, angles, unrotated, overhang, overhang_least }
}

/// de Castro (2020), tables 4.2.1 and 3.1.1, re-run with all vertices in the minimum; files' frames.
pub(crate) const CASTRO: [Castro; 7] = [
    castro("arm.obj", 16618, 0.068232214, (-2.7448, 0.0799), [0.147013, 2141.807, 409.5150]),
    castro("horse_quad.obj", 4796, 3.7903823e-4, (-1.4297, 0.2636), [4.94891e-4, 565.5352, 214.8947]),
    castro("decimated-max.obj", 10540, 5441945.9, (-1.8056, 0.0250), [8.78922e6, 1051.674, 431.6156]),
    castro("decimated-knight.off", 1000, 0.040528049, (0.0908, 0.0004), [0.0478671, 120.4443, 43.1768]),
    castro("bunny.off", 6966, 9.5420027e-4, (-0.1698, 0.5424), [1.55388e-3, 812.8062, 346.3305]),
    castro("camel_b.obj", 3576, 46462.528, (2.0943, -1.5180), [64934.5, 235.2923, 148.1600]),
    castro("cow.off", 5520, 0.07390639, (-std::f64::consts::FRAC_PI_2, -0.0924), [0.0922508, 883.0595, 266.8798]),
];

#[test]
fn weighted_normal_z_has_castros_values_and_minima() {
    let Some(folder) = meshes() else { return };
    for mesh in &CASTRO {
        let part = facets(&folder.join("castro"), mesh.file);
        assert_eq!(part.each.len(), mesh.facets, "{}", mesh.file);
        near(WeightedNormalZ.value(&part, &Vec3::z()), mesh.unrotated, 1e-5, mesh.file);
        let start = from_angles(mesh.angles.0, mesh.angles.1);
        let found = NelderMead { start: Some(start), ..NelderMead::default() }.search(&WeightedNormalZ, &part);
        near(found.minima[0].value, mesh.least, 1e-6, mesh.file);
        let off = found.minima[0].up.angle(&start).to_degrees();
        assert!(off < 0.1, "{}: {off} degrees off", mesh.file);
    }
}

#[test]
fn overhang_angle_has_castros_values_and_minima() {
    let Some(folder) = meshes() else { return };
    let f = OverhangAngle { theta: Angle::from_deg(45.0) };
    for mesh in &CASTRO {
        let part = facets(&folder.join("castro"), mesh.file);
        near(f.value(&part, &Vec3::z()), mesh.overhang, 1e-6, mesh.file);
        let found = NelderMead::default().search(&f, &part);
        near(found.minima[0].value, mesh.overhang_least, 1e-6, mesh.file);
    }
}

/// Puri's (2019) table re-run: the best of DIRECT's 1000 evaluations.
const PURI: [(&str, f64); 8] = [
    ("cube", 0.0347253),
    ("cut cylinder", 0.12232),
    ("conic frustum", 0.158118),
    ("frustum", 0.479474),
    ("bullet", 16.401),
    ("battery mount", 0.766178),
    ("death star", 158.706),
    ("reuleaux tetrahedron", 0.0734115),
];

/// Simplex searches end on a kink here and there, at most this much above the best known (cut cylinder: 3.0e-4).
pub(crate) const PURI_KINK: f64 = 5e-4;

#[test]
fn tanh_overhang_reaches_puris_values() {
    let Some(folder) = meshes() else { return };
    let f = TanhOverhang { scale: 1.0 };
    for (name, value) in PURI {
        let part = facets(&folder.join("puri"), &format!("{name}.stl"));
        near(NelderMead::default().search(&f, &part).minima[0].value, value, PURI_KINK, name);
    }
    let cube = facets(&folder.join("puri"), "cube.stl");
    near(f.value(&cube, &Vec3::z()), 0.0347253, 1e-6, "the cube as in the file");
    // Puri (2019) turns the other way about both axes: its (-2.618, 0) is our (2.618, 0). The cut lies flat 0.00006 degrees beside
    // 150 degrees, as the corners were rounded; the paper's own formula in numpy has the same values at both angles.
    let cylinder = facets(&folder.join("puri"), "cut cylinder.stl");
    let at = |degrees: f64| f.value(&cylinder, &from_angles(degrees.to_radians(), 0.0));
    near(at(150.0), 0.12323195753807824, 1e-9, "the cylinder at 150 degrees");
    near(at(149.9999426482676), 0.12235677620446601, 1e-9, "the cylinder on its cut");
    near(at(149.9999426482676), 0.12232, 4e-4, "the paper's figure");
}

#[test]
fn certified_proves_castros_minima_and_no_random_direction_is_below() {
    let Some(folder) = meshes() else { return };
    let mut numbers = Numbers::seeded(3);
    for mesh in &CASTRO {
        let part = facets(&folder.join("castro"), mesh.file);
        let found = Certified::default().search(&WeightedNormalZ, &part);
        let (best, lower) = (found.minima[0].value, found.lower_bound.unwrap());
        near(best, mesh.least, 1e-6, mesh.file);
        assert!(lower <= best && best - lower <= 1e-6 * best, "{}: {lower} for {best}", mesh.file);
        for _ in 0..100_000 {
            assert!(WeightedNormalZ.value(&part, &anywhere(&mut numbers)) >= lower, "{}", mesh.file);
        }
    }
}

/// The gaps that are promised, relative, with their objectives.
pub(crate) const GAPS: [(&str, f64); 9] = [
    ("staircase", 1e-6),
    ("support-area", 1e-6),
    ("height", 1e-6),
    ("overhang-angle", 1e-6),
    ("normal-z", 1e-6),
    ("weighted-normal-z", 1e-6),
    ("support-volume-convex", 1e-3),
    ("tanh-overhang", 1e-3),
    ("0.7*staircase+0.3*height", 1e-6),
];

#[test]
fn certified_closes_the_gap_for_every_objective_with_bounds() {
    let Some(folder) = meshes() else { return };
    // The smallest, the open one and one more: the rest takes a minute here. All closed when this was written.
    for file in ["decimated-knight.off", "camel_b.obj", "cow.off"] {
        let part = facets(&folder.join("castro"), file);
        for (name, gap) in GAPS.into_iter().filter(|(name, _)| file != "camel_b.obj" || *name != "tanh-overhang") {
            let f = objective(name, &ObjectiveSettings::default()).unwrap();
            let found = Certified { gap, ..Certified::default() }.search(f.as_ref(), &part);
            let (best, lower) = (found.minima[0].value, found.lower_bound.unwrap());
            assert!(lower <= best && best - lower <= gap * best, "{file} {name}: {lower} for {best}");
            assert_eq!(found.stop, Stop::Converged, "{file} {name}");
        }
    }
}

#[test]
fn every_search_comes_near_the_proved_minimum_and_none_below() {
    let Some(folder) = meshes() else { return };
    let part = facets(&folder.join("castro"), "decimated-knight.off");
    let lower = Certified::default().search(&Height, &part).lower_bound.unwrap();
    let searches: [(&dyn Search, f64); 4] = [
        (&Multistart::default(), 1e-4),
        (&NelderMead::default(), 1e-6),
        (&Direct::default(), 1e-3),
        // Four degrees beside a kink.
        (&GridSearch::default(), 0.1),
    ];
    for (search, reach) in searches {
        let best = search.search(&Height, &part).minima[0].value;
        assert!(best >= lower && best <= lower * (1.0 + reach), "{}: {best} for {lower}", search.name());
    }
}

fn run(args: &[&str]) -> (i32, String, String) {
    let out = trunnion().arg("orient").args(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (out.status.code().unwrap(), text(&out.stdout), text(&out.stderr))
}

#[test]
fn the_document_has_the_keys_that_scripts_read() {
    let cube = fixture("cube");
    let (code, out, said) =
        run(&[&cube, "--json", "--objective", "height", "--objective", "1*staircase+2*support-area"]);
    assert_eq!(code, 0, "{said}");
    let document: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(document["model"], cube.as_str());
    let part = &document["parts"][0];
    assert_eq!((part["id"].as_u64(), part["facets"].as_u64()), (Some(0), Some(12)));
    let height = &part["results"][0];
    assert_eq!((height["objective"].as_str(), height["method"].as_str()), (Some("height"), Some("certified")));
    let (best, bound) = (&height["minima"][0], height["lower_bound"].as_f64().unwrap());
    let value = best["value"].as_f64().unwrap();
    assert!(bound <= value && value - bound <= 1e-6 * value, "{bound} for {value}");
    assert_eq!(best["kind"], "global");
    let angle = |key: &str| best[key].as_f64().unwrap().to_radians();
    let up = from_angles(angle("alpha_deg"), angle("beta_deg"));
    let written: Vec<f64> = best["up"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert!((up - Vec3::from_column_slice(&written)).norm() < 1e-12);
    assert!(height["evaluations"].as_u64() > Some(0) && height["seconds"].is_number());
    assert_eq!(part["results"][1]["minima"][0]["value"].as_f64(), Some(0.0), "a cube on a face");
}

#[test]
fn the_written_part_stands_with_its_best_direction_up() {
    let folder = folder();
    let out = folder.path().join("turned.stl");
    let stem = fixture("y-tree");
    let (code, text, said) =
        run(&[&stem, "--part", "1", "--objective", "height", "--method", "nelder-mead", "-o", out.to_str().unwrap()]);
    assert_eq!(code, 0, "{said}");
    assert!(states(&text, "height | nelder-mead | not proved"), "{text}");
    let options = ReadOptions { unit: Some(Unit::Millimetre), repair: Repair::Off, ..ReadOptions::default() };
    let mesh = read_surface(&std::fs::read(&out).unwrap(), "turned.stl", &options).unwrap();
    let model = read_model(&std::fs::read(&stem).unwrap(), "y-tree.stl", &options).unwrap();
    let least = NelderMead::default().search(&Height, &Facets::of(&model.parts[1].mesh)).minima[0].value;
    assert!(mesh.bounds().min.z.abs() < 1e-4);
    assert!((mesh.bounds().max.z - least).abs() < 1e-4, "{} for {least}", mesh.bounds().max.z);
}

#[test]
fn bad_words_are_refused_with_a_remedy() {
    let (cube, tree) = (fixture("cube"), fixture("y-tree"));
    let cases: [(&[&str], &str); 14] = [
        (&[&cube, "--objective", "staircas"], "setting/objective: `staircas` | staircase"),
        (&[&cube, "--objective", "1*height+-1*staircase"], "setting/objective: `1*height+-1*staircase` | 0"),
        (&[&cube, "--objective", ""], "setting/objective: ``"),
        (&[&cube, "--method", "certain"], "setting/method: certain | certified"),
        (&[&cube, "--part", "9"], "setting/no-such-part: 9 | 0..0"),
        (&[&cube, "--part", ""], "command/usage: --part \"\""),
        (&[&cube, "--part", "2-1"], "command/usage: --part \"2-1\""),
        (&[&cube, "--part", "all"], "command/usage: --part \"all\" | 0,3,5-7"),
        (&[&cube, "--resolution", "0"], "setting/out-of-range: --resolution | 0.01 and 100 | got 0 mm"),
        (&[&cube, "--contact-area-min", "500"], "setting/no-contact: --contact-area-min 500 mm2 | 400.000 mm2"),
        (&[&cube, "--view", &cube], "file/twice: cube.stl"),
        (&[&tree, "--landscape", "never-written.png"], "setting/several-parts: --whole"),
        (&[&cube, "--budget", "3"], "setting/too-few: --budget 3 | 100"),
        (&[&cube, "--overhang", "90"], "setting/out-of-range: --overhang | 0 and 89.9 | got 90 deg"),
    ];
    for (args, wanted) in cases {
        let (code, out, said) = run(args);
        assert_eq!((code, out.as_str()), (2, ""), "{args:?}");
        assert!(fails(&said, wanted), "{args:?}: {said}");
    }
}

#[test]
fn an_open_mesh_is_taken_for_normals_and_refused_for_volumes() {
    let folder = folder();
    let file = folder.path().join("square.off");
    std::fs::write(&file, "OFF\n4 2 0\n0 0 0\n20 0 0\n0 20 0\n20 20 0\n3 0 1 2\n3 1 3 2\n").unwrap();
    let file = file.to_str().unwrap();
    let (code, out, said) = run(&[file, "--objective", "normal-z"]);
    assert_eq!(code, 0, "{said}");
    assert!(states(&said, "open edges | one surface"), "{said}");
    assert!(states(&out, "normal-z | certified"), "{out}");
    let (code, _, said) = run(&[file, "--objective", "support-volume-convex"]);
    assert_eq!(code, 2);
    assert!(fails(&said, "job/needs-closed: square.off | support-volume-convex"), "{said}");
}

/// Values of 80,000 facets, which are summed in parallel, and the sets of facets that see each other.
#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let (large, small) = (Facets::of(&lump(141, 2.0)), lump(9, 3.0));
    assert!(large.each.len() > 1 << 16);
    let up = Vec3::new(0.3, -0.5, 0.81).normalize();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let of = |name: &str, facets: &Facets| {
                objective(name, &ObjectiveSettings::default()).unwrap().value(facets, &up).to_bits()
            };
            let names = ["staircase", "support-area", "tanh-overhang", "weighted-normal-z", "normal-z"];
            let mut bits: Vec<u64> = names.map(|name| of(name, &large)).to_vec();
            bits.push(of("support-volume", &Facets::of(&small)));
            let f = objective("weighted-normal-z", &ObjectiveSettings::default()).unwrap();
            bits.push(Certified::default().search(f.as_ref(), &large).lower_bound.unwrap().to_bits());
            bits
        })
    };
    let alone = on(1);
    assert_eq!(alone, on(2));
    assert_eq!(alone, on(5));
}

/// Boogers (2024), table 5.2: four Latin hypercube starts by BFGS took 181 evaluations, differential evolution 708.
#[test]
fn evaluations_are_of_the_order_of_the_published_comparison() {
    let part = Facets::of(&lump(6, 1.0));
    let f = objective(
        "support-volume-convex-smooth",
        &ObjectiveSettings { k: 5.0, w: 1.0, ..ObjectiveSettings::default() },
    )
    .unwrap();
    let starts = Multistart {
        starts: 4,
        from: Starts::LatinHypercube,
        descent: Some(GradientMethod::Bfgs),
        ..Multistart::default()
    };
    let walked = starts.search(f.as_ref(), &part);
    let evolved = DifferentialEvolution::default().search(f.as_ref(), &part);
    note(&format!("4 x BFGS {} evaluations, evolution {}", walked.evaluations, evolved.evaluations));
    assert!(walked.evaluations < 4 * 181, "{}", walked.evaluations);
    assert!((708 / 4..708 * 4).contains(&evolved.evaluations), "{}", evolved.evaluations);
}

/// A file of one mesh in OFF, and what `orient` says of it.
fn of_off(text: &str, args: &[&str]) -> (i32, String, String) {
    let folder = folder();
    let file = folder.path().join("mesh.off");
    std::fs::write(&file, text).unwrap();
    run(&[&[file.to_str().unwrap(), "--unit", "mm"], args].concat())
}

/// The best value of each objective of a file of one mesh, all of them with a bound that is not above it.
fn best_of_off(text: &str, names: &[&str]) -> Vec<f64> {
    let args: Vec<&str> = names.iter().flat_map(|name| ["--objective", name]).chain(["--json"]).collect();
    let (code, out, said) = of_off(text, &args);
    assert_eq!(code, 0, "{said}");
    let document: serde_json::Value = serde_json::from_str(&out).unwrap();
    let best = |result: &serde_json::Value| {
        let (value, bound) = (result["minima"][0]["value"].as_f64().unwrap(), result["lower_bound"].as_f64().unwrap());
        assert!(value.is_finite() && bound <= value && !value.to_string().starts_with("-0"), "{result}");
        value
    };
    document["parts"][0]["results"].as_array().unwrap().iter().map(best).collect()
}

const TETRAHEDRON: &str = "OFF\n4 4 0\n0 0 0\n9 0 0\n0 8 0\n0 0 7\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
/// For meshes with hardly anything in them.
const NAMES: [&str; 6] = ["height", "normal-z", "weighted-normal-z", "staircase", "overhang-angle", "contact-area"];

#[test]
fn one_facet_and_a_flat_mesh_have_values_known_by_hand() {
    // Flat down: no height, no stairs; on an edge: no normal points up or down; all of it may lie on the bed.
    let one = "OFF\n3 1 0\n0 0 0\n20 0 0\n0 20 0\n3 0 1 2\n";
    let flat = "OFF\n4 2 0\n0 0 0\n20 0 0\n0 20 0\n20 20 0\n3 0 1 2\n3 1 3 2\n";
    for (text, area) in [(one, 200.0), (flat, 400.0)] {
        let values = best_of_off(text, &NAMES);
        assert!(values[..5].iter().all(|v| v.abs() < 1e-9), "{values:?}");
        assert!((values[5] + area).abs() < 1e-9, "{values:?}");
    }
}

#[test]
fn facets_without_area_and_facets_named_twice_change_nothing() {
    let sliver =
        "OFF\n5 6 0\n0 0 0\n9 0 0\n0 8 0\n0 0 7\n4 0 0\n3 0 2 1\n3 0 4 3\n3 4 1 3\n3 0 3 2\n3 1 2 3\n3 0 1 4\n";
    let repeated = TETRAHEDRON.replace("4 4 0", "4 5 0") + "3 1 1 3\n";
    // The y = 0 face is in two pieces in `sliver`: `normal-z` and `overhang-angle` count facets, so they are left out there.
    let by_area = ["height", "weighted-normal-z", "staircase", "contact-area"];
    let wanted = best_of_off(TETRAHEDRON, &by_area);
    // By hand: the height over the largest face, whose area is half of |(56, 63, 72)|.
    let largest = Vec3::new(56.0, 63.0, 72.0).norm() / 2.0;
    near(wanted[0], 252.0 / largest, 2e-6, "three times the volume over the largest face");
    near(wanted[3], -largest, 1e-9, "contact");
    for text in [sliver, &repeated] {
        best_of_off(text, &by_area).iter().zip(&wanted).for_each(|(got, wanted)| near(*got, *wanted, 2e-6, text));
    }
    best_of_off(&repeated, &NAMES)
        .iter()
        .zip(best_of_off(TETRAHEDRON, &NAMES))
        .for_each(|(a, b)| near(*a, b, 2e-6, "all"));
    let twice = "OFF\n4 8 0\n0 0 0\n9 0 0\n0 8 0\n0 0 7\n3 0 2 1\n3 0 2 1\n3 0 1 3\n3 0 1 3\n3 0 3 2\n3 0 3 2\n3 1 2 3\n3 1 2 3\n";
    let (code, out, said) = of_off(twice, &["--json", "--objective", "height"]);
    assert_eq!(code, 0, "{said}");
    assert!(states(&said, "repair | 4"), "one copy is removed, and said: {said}");
    let document: serde_json::Value = serde_json::from_str(&out).unwrap();
    near(document["parts"][0]["results"][0]["minima"][0]["value"].as_f64().unwrap(), wanted[0], 2e-6, "twice");
}

#[test]
fn meshes_without_area_facets_or_measure_are_refused() {
    let line = "OFF\n3 1 0\n0 0 0\n10 0 0\n20 0 0\n3 0 1 2\n";
    let far = "OFF\n4 4 0\n0 0 0\n1e9 0 0\n0 1e9 0\n0 0 1e9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    let cases = [
        (line, "job/no-area: part 0 | 1 facets"),
        (far, "mesh/too-large: 1000000000"),
        ("OFF\n0 0 0\n", "mesh/no-facets"),
        ("OFF\n3 1 0\n0 0 0\nnan 0 0\n0 20 0\n3 0 1 2\n", "mesh/not-finite: NaN"),
    ];
    for (text, wanted) in cases {
        let (code, out, said) = of_off(text, &["--objective", "normal-z"]);
        assert_eq!((code, out.as_str()), (2, ""), "{text}: {said}");
        assert!(fails(&said, wanted), "{text}: {said}");
    }
}

/// A bound far below the best value is none that helps anybody: it is not told, and that is said.
#[test]
fn a_loose_bound_is_not_shown() {
    let hook = fixture("hook");
    let (mut shown, mut none) = (0, 0);
    for name in ["height", "staircase", "alexander", "support-volume", "support-volume-convex-smooth", "interface-area"]
    {
        let (code, out, said) = run(&[&hook, "--objective", name, "--budget", "400", "--json"]);
        assert_eq!(code, 0, "{said}");
        let document: serde_json::Value = serde_json::from_str(&out).unwrap();
        for result in document["parts"].as_array().unwrap().iter().map(|part| &part["results"][0]) {
            let best = result["minima"][0]["value"].as_f64().unwrap();
            match result["lower_bound"].as_f64() {
                Some(bound) => {
                    assert!(bound <= best + 1e-9 && best - bound <= 0.25 * best.abs() + 1e-6, "{name}: {result}")
                }
                None => assert!(!result["unproved"].as_str().unwrap().is_empty(), "{name}"),
            }
            (shown, none) = match result["lower_bound"].is_null() {
                true => (shown, none + 1),
                false => (shown + 1, none),
            };
        }
    }
    assert!(shown > 0 && none > 0, "{shown} shown, {none} not");
}

#[test]
fn a_result_without_a_proof_says_why() {
    let cube = fixture("cube");
    let why = |args: &[&str]| {
        let (code, out, said) = run(&[&[cube.as_str(), "--json"], args].concat());
        assert_eq!(code, 0, "{said}");
        let document: serde_json::Value = serde_json::from_str(&out).unwrap();
        let result = &document["parts"][0]["results"][0];
        assert!(result["lower_bound"].is_null(), "{result}");
        result["unproved"].as_str().unwrap().to_owned()
    };
    let sum = why(&["--objective", "height+-0.01*alexander", "--budget", "200"]);
    assert!(states(&sum, "alexander | bound"), "{sum}");
    let direct = why(&["--objective", "height", "--method", "direct"]);
    assert!(states(&direct, "direct | --method certified"), "{direct}");
    let (_, out, _) = run(&[&cube, "--objective", "height+-0.01*alexander", "--budget", "200"]);
    assert!(states(&out, "not proved (alexander"), "{out}");
    // The longest way through a cube of 20 mm is its diagonal, 34.641 mm.
    let (_, out, _) = run(&[&cube, "--objective", "-1*height"]);
    assert!(out.contains("proved lower bound -3.4641"), "{out}");
}

#[test]
fn pictures_comparison_and_contact_are_written() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (land, seen, out) = (path("land.png"), path("seen.png"), path("turned.3mf"));
    let boxes = fixture("two-boxes");
    let (code, text, said) = run(&[
        &boxes,
        "--whole",
        "--objective",
        "support-volume-column",
        "--objective",
        "height",
        "--budget",
        "300",
        "--landscape",
        &land,
        "--view",
        &seen,
        "-o",
        &out,
        "--compare",
        "--json",
        "--resolution",
        "1",
    ]);
    assert_eq!(code, 0, "{said}");
    for file in [&land, &seen] {
        assert_eq!(&std::fs::read(file).unwrap()[..8], b"\x89PNG\r\n\x1a\n");
    }
    assert!(std::fs::metadata(&out).unwrap().len() > 500);
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let rows = document["parts"][0]["compare"].as_array().unwrap();
    assert_eq!(rows.len(), 3);
    // As it lies: the beam of 30 x 20 mm hangs 40 mm above the bed; the post stands on 20 x 20 mm.
    let lies = |key: &str| rows[0][key].as_f64().unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-6 * b, "{a} for {b}");
    near(lies("support_volume_mm3"), 30.0 * 20.0 * 40.0);
    near(lies("overhang_area_mm2"), 600.0);
    near(lies("height_mm"), 60.0);
    near(lies("contact_area_mm2"), 400.0);
    assert!(rows[1]["support_volume_mm3"].as_f64().unwrap() < 1.0, "on its side it needs none: {}", rows[1]);
    let (code, text, said) = run(&[&boxes, "--whole", "--objective", "height", "--contact-area-min", "1000", "--json"]);
    assert_eq!(code, 0, "{said}");
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let result = &document["parts"][0]["results"][0];
    // The least height lays the L flat (1800 mm2 of it, 20 mm high).
    near(result["minima"][0]["value"].as_f64().unwrap(), 20.0);
    assert!(result["lower_bound"].as_f64().unwrap() <= 20.0);
}

/// The smoothing of Boogers (2024) reaches the objective from the command line: the value is the library's with the same numbers.
#[test]
fn smoothing_is_as_it_is_asked_for() {
    let folder = folder();
    let (_, mesh) = &trunnion::fixtures::hook().parts[0];
    let path = folder.path().join("hook.stl");
    std::fs::write(&path, trunnion::mesh::stl_binary(mesh)).unwrap();
    let asked = |more: &[&str]| {
        let words = ["--objective", "support-volume", "--method", "bfgs", "--unit", "mm", "--json"];
        trunnion().arg("orient").arg(&path).args(words).args(more).output().unwrap()
    };
    // All minima, so that supports on the part are among them.
    let values = |more: &[&str]| -> Vec<(Vec3, f64)> {
        let document: serde_json::Value = serde_json::from_slice(&asked(more).stdout).unwrap();
        let minima = document["parts"][0]["results"][0]["minima"].as_array().unwrap().clone();
        let number = |v: &serde_json::Value| v.as_f64().unwrap();
        minima.iter().map(|m| (Vec3::from_fn(|k, _| number(&m["up"][k])), number(&m["value"]))).collect()
    };
    let facets = Facets::of(mesh);
    for (k, w, carrying) in [(20.0, 40.0, 0.0), (6.0, 40.0, 0.0), (20.0, 3.0, 0.0), (20.0, 40.0, 50.0)] {
        let [ks, ws, cs] = [k, w, carrying].map(|v: f64| v.to_string());
        let settings = ObjectiveSettings { k, w, carrying: Angle::from_deg(carrying), ..ObjectiveSettings::default() };
        let of =
            |settings: &ObjectiveSettings, up: &Vec3| objective("support-volume", settings).unwrap().value(&facets, up);
        let found = values(&["--smooth-k", &ks, "--smooth-w", &ws, "--carrying", &cs]);
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * b.abs().max(1.0);
        assert!(found.iter().all(|(up, value)| near(of(&settings, up), *value)), "{k} {w} {carrying}: {found:?}");
        let usual = found.iter().all(|(up, value)| near(of(&ObjectiveSettings::default(), up), *value));
        assert_eq!(usual, (k, w, carrying) == (20.0, 40.0, 0.0), "{k} {w} {carrying}: {found:?}");
    }
    for (flag, value, low) in [("--smooth-k", "0", "0.1"), ("--smooth-w", "0", "0.001"), ("--carrying", "90", "0")] {
        let run = asked(&[flag, value]);
        let said = String::from_utf8_lossy(&run.stderr).into_owned();
        assert_eq!(run.status.code(), Some(2), "{flag}");
        assert!(fails(&said, &format!("setting/out-of-range: {flag} | {low}")), "{said}");
    }
}
