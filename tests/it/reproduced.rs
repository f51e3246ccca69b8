//! `examples/reproduce/`: what the five documents print, remade from generated inputs; each value as near as the page says, every table and
//! figure on it. The whole, with meshes and inputs of millions of nodes, is in `scripts/soak.sh`.

use std::collections::BTreeSet;

use serde_json::Value;
use trunnion::geom::{Angle, Bounds, Object, Slot, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{Facets, Objective, Staircase, SupportVolumeConvex, TanhOverhang, WeightedNormalZ, from_angles};
use trunnion::support::{FlowLimits, Graph, Grid, min_cost};

use crate::support::{every, folder, note};

#[allow(dead_code, reason = "the program's own main")]
#[path = "../../examples/reproduce/main.rs"]
mod example;

use example::{item, sources};

/// Tables and figures that each document has, and how many of them are remade from generated inputs in a quick run.
///
/// Counted in the documents: captions, and what has none (tables of chapter 4 and of g in Leitereg, pictures a and b where they are by
/// themselves).
const COUNTS: [(&str, [usize; 2], [usize; 2]); 5] = [
    ("castro", [6, 37], [0, 1]),
    ("puri", [0, 5], [0, 3]),
    ("boogers", [4, 35], [3, 15]),
    ("leitereg", [5, 5], [5, 4]),
    ("ramos", [1, 17], [1, 15]),
];

/// The numbers of figures by document, as captions count them.
const FIGURES: [(&str, &str); 5] = [
    (
        "castro",
        "1.1.1 1.1.2 2.1.1 2.1.2 2.1.3 2.2.1 2.3.1 2.3.2 2.3.3 2.3.4 2.3.5 2.3.6 3.0.1 3.1.1 3.1.2 3.1.3 3.1.4 3.1.5 3.1.6 3.1.7 3.1.8 3.1.9 \
         3.2.1 3.2.2 3.2.3 3.3.1 3.3.2 3.4.1 3.4.2 3.4.3 3.4.4 3.4.5 4.2.1 4.2.2 4.2.3 4.2.4 4.2.5",
    ),
    ("puri", "1a 1b 2a 2b 2c"),
    (
        "boogers",
        "1.1 1.2 2.1 2.2 2.3 2.4 2.5 2.6 3.1 3.2 3.3 3.4 3.5 3.6 3.7 3.8 3.9 4.1 4.2 4.3 4.4 4.5 4.6 4.7 5.1 5.2 5.3 5.4 5.5 5.6 5.7 5.8 5.9 6.1 6.2",
    ),
    ("leitereg", "3.1 1 2 4.1"),
    ("ramos", "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17"),
];

/// The run, and its two files.
fn made() -> (Vec<item::Document>, String, Value) {
    let run = sources::Run { quick: true, meshes: None };
    let documents = example::remade(&run, &[]);
    let folder = folder();
    example::write(folder.path(), &documents).unwrap();
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let data = serde_json::from_str(&read("reproduce.json")).unwrap();
    (documents, read("reproduce.html"), data)
}

#[test]
fn each_value_is_as_near_as_the_page_says_and_the_page_has_every_table_and_figure() {
    let (documents, page, data) = made();
    let (mut judged, mut open) = (0, 0);
    for document in &documents {
        for item in &document.items {
            let place = format!("{} {}", document.key, item.name());
            for row in &item.rows {
                assert!(row.holds() != Some(false), "{place}: {}: {} for {}", row.what, row.ours, row.printed);
                assert!(row.within.is_finite() && row.within >= 0.0, "{place}: {}", row.what);
                // What may be far off, and what cannot be compared, has its reason.
                let far = row.unit == "%" && row.within > 1.0;
                assert!(!(far || row.holds().is_none()) || !row.reason.is_empty(), "{place}: {}", row.what);
                if row.holds().is_some() { judged += 1 } else { open += 1 }
            }
            assert!(item.is_left() || !item.rows.is_empty() || !item.pictures.is_empty(), "{place}");
            assert!(item.pictures.iter().all(|(_, svg)| svg.starts_with("<svg") && svg.len() > 500), "{place}");
        }
    }
    note(&format!("{judged} values are compared, {open} cannot be"));
    assert!(judged > 150 && judged > 2 * open, "{judged} and {open}");
    for (document, (key, all, remade)) in documents.iter().zip(COUNTS) {
        let [tables, figures] = [item::Kind::Table, item::Kind::Figure].map(|kind| document.count(kind));
        assert_eq!((document.key, [tables[0], figures[0]], [tables[1], figures[1]]), (key, all, remade));
        let names: BTreeSet<String> = document.items.iter().map(item::Item::name).collect();
        assert_eq!(names.len(), document.items.len(), "{key}: a name twice");
        let numbers = FIGURES.iter().find(|one| one.0 == key).map_or("", |one| one.1);
        for number in numbers.split_whitespace() {
            let name = format!("Figure {number}");
            assert!(names.contains(&name), "{key}: {name}");
        }
        for name in &names {
            assert!(page.contains(&format!(">{name}<")), "{key}: {name} is not on the page");
        }
    }
    let listed = data.as_array().unwrap();
    assert_eq!(listed.len(), 5);
    for (document, listed) in documents.iter().zip(listed) {
        assert_eq!(listed["items"].as_array().map(Vec::len), Some(document.items.len()));
    }
    // One file that asks for nothing from elsewhere, and is the same each time.
    assert!(!page.contains("<script") && !page.contains("src=") && !page.contains("@import"));
    let links = page.matches("http").count();
    assert_eq!(links, page.matches("xmlns=\"http").count());
    // Two that draw numbers and stop by steps; in the suite one of them.
    let run = sources::Run { quick: true, meshes: None };
    let drawn: Vec<String> = ["leitereg", "boogers"].into_iter().step_by(every(2)).map(str::to_owned).collect();
    for again in example::remade(&run, &drawn) {
        assert!(listed.contains(&again.json()), "{} differs from one run to the next", again.key);
    }
}

#[test]
fn a_value_that_is_off_a_word_that_differs_and_what_is_not_comparable_are_told_apart() {
    let off = item::Row::relative("x", 100.0, 101.1, 0.01);
    assert_eq!((off.holds(), off.deviation.map(|d| (d * 10.0).round())), (Some(false), Some(11.0)));
    assert_eq!(item::Row::relative("x", 100.0, 100.9, 0.01).holds(), Some(true));
    assert_eq!(item::Row::absolute("x", 0.0, -0.2, 0.1, "mm").holds(), Some(false));
    assert_eq!(item::Row::absolute("x", 0.0, f64::NAN, 0.1, "mm").holds(), Some(false));
    assert_eq!(item::Row::same("x", "a", "b").holds(), Some(false));
    assert_eq!(item::Row::same("x", "a", "a").holds(), Some(true));
    assert_eq!(item::Row::apart("x", "a", "b", 0.2, 0.1).holds(), Some(false));
    assert_eq!(item::Row::open("x", "a", "b", "another part").holds(), None);
}

#[test]
fn numbers_have_six_figures() {
    let cases = [
        (0.0, "0"),
        (0.034_725_3, "0.0347253"),
        (15_190.0, "15190"),
        (-1.5, "-1.5"),
        (1e-9, "1.0000e-9"),
        (2.5e9, "2.5000e9"),
    ];
    for (value, text) in cases {
        assert_eq!(item::figures(value), text);
    }
}

/// Five values worked out with pencil and paper, one of each document; the arithmetic is in docs/explanation/measurements.md.
#[test]
fn five_values_are_those_worked_out_by_hand() {
    let near =
        |ours: f64, hand: f64, name: &str| assert!((ours - hand).abs() <= 5e-6 * hand, "{name}: {ours} for {hand}");
    let tilted = from_angles(45f64.to_radians(), 0.0);
    let facets = |min: [f64; 3], max: [f64; 3]| {
        let bounds = Bounds { min: min.into(), max: max.into() };
        Facets::of(&TriangleMesh::<Object>::cuboid(&bounds))
    };
    // De Castro, equation 3.2.4.
    near(WeightedNormalZ.value(&facets([0.0; 3], [20.0; 3]), &tilted), 11_313.708, "a cube of 20 mm on its edge");
    // Puri, section 2, with the program's tenth.
    near(TanhOverhang { scale: 1.0 }.value(&facets([0.0; 3], [1.0; 3]), &Vec3::z()), 0.034_725_3, "the unit cube");
    // Boogers, equation 3.23.
    let exact = SupportVolumeConvex { overhang: Angle::ZERO };
    near(
        exact.value(&facets([0.0; 3], [1.0; 3]), &from_angles(20f64.to_radians(), 0.0)),
        0.321_393_8,
        "a cube turned by 20 degrees",
    );
    // Ramos et al., section 4.
    let post = facets([-10.0, -10.0, 0.0], [10.0, 10.0, 60.0]);
    near(Staircase { layer_mm: 0.2 }.value(&post, &tilted), 45.254_834, "a post on its edge");
    // Leitereg, chapter 3: a small roof 12 mm above the ground, in a grid of 2 mm.
    let low = Vec3::new(4.1, 4.1, 12.1);
    let roof: TriangleMesh<Slot> = TriangleMesh::cuboid(&Bounds { min: low, max: low + Vec3::new(1.8, 1.8, 2.9) });
    let graph = Graph::of(Grid::over(Vec3::zeros(), [10.0, 10.0, 16.0], 2.0), &[&roof], Angle::from_deg(45.0));
    let (flow, _) = min_cost(&graph, FlowLimits::new(4, None), &mut |_| {});
    assert_eq!(flow.tally(&graph, 4, None).cost, 6);
}
