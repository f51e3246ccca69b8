//! The machine of Koala's simulator. The witness is that program's own published arithmetic, typed out here on plain numbers in its own
//! frame (x, y up, z to the front): where it draws each piece, and where it says that a path lies on the part.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use trunnion::geom::{Angle, Point, Vec3};
use trunnion::motion::Pose;
use trunnion::profile::Profile;

use super::{import, lay, request, with_rest};
use crate::support::{Numbers, fails, folder, states};

/// A machine as the program writes it, without the tree that later versions add.
pub(crate) fn machine() -> Value {
    json!({
        "_version": 1,
        "buildplate": {"w": 90, "d": 80, "t": 3, "color": "#1e3a5f", "visible": false},
        "nozzle": {"tip": 0.8, "base": 8, "angle": 45, "length": 10, "color": "#94a3b8", "visible": false},
        "limits": {
            "x": {"min": -50, "max": 55}, "y": {"min": -45, "max": 50}, "z": {"min": 0, "max": 90},
            "b": {"min": -32, "max": 120}, "c": {"min": -99999, "max": 99999}
        },
        "machineOffset": {"x": 0, "y": 0, "z": 0},
        "nozzleDiameter": 0.5,
        "collisionProxies": [
            {"part": "Y", "type": "box", "sx": 200, "sy": 20, "sz": 30, "ox": 0, "oy": 52, "oz": -35},
            {"part": "C", "type": "box", "sx": 90, "sy": 20, "sz": 80, "ox": 0, "oy": -10, "oz": 0},
            {"part": "X", "type": "cylinder", "sx": 5, "sy": 6, "sz": 30, "ox": 0, "oy": 7, "oz": 0},
            {"part": "X", "type": "box", "sx": 35, "sy": 50, "sz": 60, "ox": 0, "oy": 64, "oz": -20, "label": "carriage"}
        ],
        "collisionEnabled": true
    })
}

fn lengthened(mut machine: Value, pieces: Vec<Value>) -> Value {
    machine["collisionProxies"] = Value::Array(pieces);
    machine
}

/// The tree as a later version writes it; the senses of the last two lists as given.
fn tree(tilt: bool, beds: [([i32; 3], bool); 2]) -> Value {
    let part = |name: &str,
                parent: Option<&str>,
                kind: &str,
                word: Option<&str>,
                axis: [i32; 3],
                invert: bool,
                bed: bool| {
        json!({"name": name, "parent": parent, "type": kind, "gcode": word, "threeAxis": axis, "invert": invert, "bedSide": bed})
    };
    json!({
        "parts": [
            part("Frame", None, "static", None, [0, 1, 0], false, true),
            part("Z", Some("Frame"), "linear", Some("mz"), [0, 1, 0], true, true),
            part("B", Some("Z"), "rotary", Some("mb"), [0, 0, -1], tilt, true),
            part("C", Some("B"), "rotary", Some("mc"), [0, 1, 0], false, true),
            part("Y", Some("Frame"), "linear", Some("my"), [0, 0, -1], false, false),
            part("X", Some("Y"), "linear", Some("mx"), [1, 0, 0], false, false)
        ],
        "bedPart": "C", "toolPart": "X",
        "bedRotAxes": [
            {"gcode": "mb", "axis": beds[0].0, "invert": beds[0].1},
            {"gcode": "mc", "axis": beds[1].0, "invert": beds[1].1}
        ]
    })
}

fn told(machine: &Value) -> Result<trunnion::job::ImportedProfile, String> {
    let folder = folder();
    lay(folder.path(), &vec![("machine.json", serde_json::to_string_pretty(machine).unwrap())]);
    let plain = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
    with_rest(folder.path(), &["machine.json"], &[]).map_err(plain)
}

fn stated<'a>(done: &'a trunnion::job::ImportedProfile, key: &str) -> Option<&'a toml::Value> {
    done.facts.iter().find(|fact| fact.key == key).map(|fact| &fact.value)
}

#[test]
fn all_that_the_file_says_is_in_the_profile_and_what_it_does_not_say_is_asked() {
    let done = told(&machine()).unwrap();
    let Profile { kinematics, limits, table, head, fixed, process, .. } = &done.profile;
    assert_eq!((limits.x_mm, limits.y_mm, limits.z_mm), ([-50.0, 55.0], [-45.0, 50.0], [0.0, 90.0]));
    assert_eq!((kinematics.tilt.letter, kinematics.tilt.min_deg, kinematics.tilt.max_deg), ('B', -32.0, 120.0));
    assert_eq!((kinematics.rotation.letter, kinematics.rotation.min_deg), ('C', None));
    assert_eq!((kinematics.pivot_mm, kinematics.offset_mm), ([0.0; 3], [0.0; 3]));
    assert_eq!((table.radius_mm, table.size_mm, table.thickness_mm), (0.0, Some([90.0, 80.0]), 20.0));
    assert_eq!((process.nozzle_mm, done.firmware(), done.like.name.as_str()), (0.5, "koala", "generic-bc"));
    let names: Vec<(&str, &str)> = head.body.iter().map(|b| (b.name.as_str(), b.moves.as_str())).collect();
    let wanted =
        [("nozzle", "XYZ"), ("nozzle's shaft", "XYZ"), ("Y box 1", "YZ"), ("X cylinder 3", "XYZ"), ("carriage", "XYZ")];
    assert_eq!(names, wanted);
    // Half angle 45: as high as it grows wider.
    assert_eq!((head.body[0].z_mm, head.body[0].r_mm), (Some([0.0, 3.6]), Some([0.4, 4.0])));
    assert_eq!((head.body[1].z_mm, head.body[1].r_mm), (Some([3.6, 13.6]), Some([4.0, 4.0])));
    assert_eq!((head.body[2].min_mm, head.body[2].max_mm), (Some([-100.0, 20.0, 42.0]), Some([100.0, 50.0, 62.0])));
    assert_eq!((head.body[3].z_mm, head.body[3].r_mm), (Some([4.0, 10.0]), Some([5.0, 5.0])));
    assert_eq!((head.body[4].min_mm, head.body[4].max_mm), (Some([-17.5, -10.0, 39.0]), Some([17.5, 50.0, 89.0])));
    assert!(fixed.body.is_empty() && done.notes.is_empty(), "{:?}", done.notes);
    assert_eq!(done.unanswered, ["dialect.firmware"]);
    assert_eq!(done.refusals, Vec::<String>::new());
    // The head is measured: nothing says any more that it is another's.
    let text = done.text(None, &trunnion::job::World::here(&trunnion::job::Silent));
    assert!(
        !states(&text, "# | [[head.body]]") && text.contains("dialect.start, dialect.end and link.rehome"),
        "{text}"
    );
    assert!(!text.contains("table.thickness_mm, dialect") && text.contains("\n    { kind = \"box\", max_mm"), "{text}");
    // A line of the file for each.
    let line = |key: &str| done.facts.iter().find(|fact| fact.key == key).unwrap().from[0].line;
    let written = serde_json::to_string_pretty(&machine()).unwrap();
    let of = |words: &str| written.lines().position(|l| l.contains(words)).unwrap() + 1;
    assert_eq!(line("process.nozzle_mm"), of("nozzleDiameter"));
    assert_eq!(line("table.size_mm"), of("\"w\": 90"));
    let folder = folder();
    lay(folder.path(), &vec![("machine.json", written)]);
    let untold = import(&request(folder.path(), &["machine.json"])).unwrap_err();
    assert!(fails(&untold, "job/untold: dialect.firmware"), "{untold}");
}

/// `toPart` of the program.
fn to_part([x, y, z]: [f64; 3], b: f64, c: f64) -> [f64; 3] {
    let (b, c) = (b.to_radians(), c.to_radians());
    let (xb, yb, zb) = (x * (-b).cos() + z * (-b).sin(), y, -x * (-b).sin() + z * (-b).cos());
    [xb * (-c).cos() - yb * (-c).sin(), xb * (-c).sin() + yb * (-c).cos(), zb]
}

#[test]
fn the_chain_is_the_programs_own_way_to_the_part() {
    let kinematics = told(&machine()).unwrap().profile.kinematics();
    let mut with_tree = machine();
    with_tree["kinematics"] = tree(false, [([0, 0, -1], false), ([0, 1, 0], false)]);
    let same = told(&with_tree).unwrap();
    assert_eq!(same.profile.kinematics(), kinematics);
    assert!(stated(&same, "kinematics.tilt.direction").is_some() && same.notes.is_empty(), "{:?}", same.notes);
    let mut numbers = Numbers::seeded(7);
    for _ in 0..2000 {
        let (at, b, c) = (numbers.triple(90.0), numbers.between(-32.0, 120.0), numbers.between(-2000.0, 2000.0));
        let pose = Pose {
            tilt: kinematics.tilt.angle_of(Angle::from_deg(b)),
            rotation: kinematics.rotation.angle_of(Angle::from_deg(c)),
        };
        let got = kinematics.forward(pose).inverse().point(Point::from(Vec3::from(at))).at;
        let wanted = Vec3::from(to_part(at, b, c));
        assert!((got - wanted).norm() < 1e-9, "{at:?} B{b} C{c}: {got:?}, wanted {wanted:?}");
    }
}

/// Where the program draws the group of a part, in its own frame.
fn drawn(part: &str, [x, y, z]: [f64; 3], [mx, my, mz]: [f64; 3]) -> [f64; 3] {
    match part {
        "Frame" => [x, y, z],
        "Z" => [x, y - mz, z],
        "Y" => [x, y, z - my],
        "X" => [x + mx, y, z - my],
        other => panic!("{other}"),
    }
}

/// The corners that the program takes a piece for (`getProxyWorldPts`), with the machine's axes at `words`.
fn corners(piece: &Value, words: [f64; 3]) -> Vec<[f64; 3]> {
    let n = |key: &str| piece[key].as_f64().unwrap_or(0.0);
    let (c, half) = ([n("ox"), n("oy"), n("oz")], [n("sx") / 2.0, n("sy") / 2.0, n("sz") / 2.0]);
    let local: Vec<[f64; 3]> = match piece["type"].as_str().unwrap() {
        "box" => {
            let sign = |i: usize, bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            (0..8).map(|i| [0, 1, 2].map(|k| c[k] + sign(i, k) * half[k])).collect()
        }
        "cylinder" => (0..10)
            .flat_map(|i| {
                let t = f64::from(i) / 10.0 * TAU;
                [1.0, -1.0].map(|up| [c[0] + n("sx") * t.cos(), c[1] + up * n("sy") / 2.0, c[2] + n("sx") * t.sin()])
            })
            .collect(),
        "sphere" => (0..8)
            .flat_map(|i| (0..6).map(move |j| (f64::from(i) / 8.0 * TAU, f64::from(j) / 6.0 * TAU / 2.0 - TAU / 4.0)))
            .map(|(t, p)| {
                let r = n("sx");
                [c[0] + r * p.cos() * t.cos(), c[1] + r * p.sin(), c[2] + r * p.cos() * t.sin()]
            })
            .collect(),
        _ => {
            let points = piece["hullPoints"].as_array().unwrap();
            points.iter().map(|p| [0, 1, 2].map(|k| p[k].as_f64().unwrap())).collect()
        }
    };
    local.into_iter().map(|p| drawn(piece["part"].as_str().unwrap(), p, words)).collect()
}

/// Every piece of the profile stands, against what carries the tilt, where the program draws it, whatever the axes do; one that is round
/// or a ball holds it.
#[test]
fn pieces_stand_where_the_program_draws_them() {
    let mut numbers = Numbers::seeded(8);
    let kinds = ["box", "cylinder", "sphere", "hull"];
    for round in 0..200 {
        let mut pieces =
            vec![json!({"part": "X", "type": "box", "sx": 4, "sy": 4, "sz": 4, "ox": 0, "oy": 30, "oz": 0})];
        for _ in 0..6 {
            let (part, kind) = (
                ["Frame", "Z", "Y", "X"][numbers.between(0.0, 4.0) as usize],
                kinds[numbers.between(0.0, 4.0) as usize],
            );
            let [sx, sy, sz] = [(); 3].map(|()| numbers.between(1.0, 30.0));
            let [ox, oz] =
                [(); 2].map(|()| if numbers.between(0.0, 1.0) < 0.3 { 0.0 } else { numbers.between(-90.0, 90.0) });
            let oy = numbers.between(40.0, 90.0);
            let mut piece =
                json!({"part": part, "type": kind, "sx": sx, "sy": sy, "sz": sz, "ox": ox, "oy": oy, "oz": oz});
            if kind == "hull" {
                let points: Vec<[f64; 3]> =
                    (0..7).map(|_| numbers.triple(40.0)).map(|[x, y, z]| [x, y + 50.0, z]).collect();
                piece = json!({"part": part, "type": kind, "sx": 0, "sy": 0, "sz": 0, "ox": 0, "oy": 0, "oz": 0, "hullPoints": points});
            }
            pieces.push(piece);
        }
        let mut machine = lengthened(machine(), pieces.clone());
        if round % 2 == 1 {
            machine["kinematics"] = tree(false, [([0, 0, -1], false), ([0, 1, 0], false)]);
        }
        let done = told(&machine).unwrap_or_else(|e| panic!("{e}: {machine}"));
        let ours: Vec<_> = done.profile.head_bodies().into_iter().chain(done.profile.fixed_bodies()).collect();
        for (i, piece) in pieces.iter().enumerate() {
            let (part, kind) = (piece["part"].as_str().unwrap(), piece["type"].as_str().unwrap());
            let name = format!("{part} {kind} {}", i + 1);
            let body = ours.iter().find(|b| b.name == name).unwrap_or_else(|| panic!("no {name}"));
            let words = [numbers.between(-50.0, 50.0), numbers.between(-50.0, 50.0), numbers.between(0.0, 90.0)];
            // Against the carriage of the bed, which the program moves down by Z; then x, -z, y.
            let theirs: Vec<Vec3> =
                corners(piece, words).into_iter().map(|[x, y, z]| Vec3::new(x, -z, y + words[2])).collect();
            let moved = |p: &Vec3| Vec3::from([0, 1, 2].map(|k| p[k] + if body.follows[k] { words[k] } else { 0.0 }));
            let own: Vec<Vec3> = body.points.iter().map(moved).collect();
            for _ in 0..40 {
                let d = Vec3::from(numbers.triple(1.0)).normalize();
                let far = |points: &[Vec3]| points.iter().map(|p| p.dot(&d)).fold(f64::NEG_INFINITY, f64::max);
                let more = far(&own) - far(&theirs);
                let most = match kind {
                    "box" | "hull" => 1e-5,
                    // The program takes a tenth of the circle at a time.
                    "cylinder" => piece["sx"].as_f64().unwrap() * 0.1,
                    _ => piece["sx"].as_f64().unwrap(),
                };
                assert!((-1e-5..=most).contains(&more), "{round}, {name} at {words:?}: {more} mm: {piece}");
            }
        }
    }
}

#[test]
fn what_no_profile_can_say_is_a_note_and_the_rest_is_conservative() {
    let piece = |part: &str, oy: f64, sx: f64| json!({"part": part, "type": "box", "sx": sx, "sy": 4, "sz": 4, "ox": 0, "oy": oy, "oz": 0});
    let head = piece("X", 30.0, 4.0);
    let of = |more: Vec<Value>| told(&lengthened(machine(), [vec![head.clone()], more].concat())).unwrap();
    let note = |done: &trunnion::job::ImportedProfile, words: &str| {
        assert!(done.notes.len() == 1 && states(&done.notes[0], words), "{words}: {:?}", done.notes);
    };
    // What turns with the plate: the table grows, and what is printed on does not.
    let wide = of(vec![piece("C", -5.0, 96.0)]);
    let table = &wide.profile.table;
    assert_eq!((table.size_mm, table.keep_out_mm, table.thickness_mm), (Some([96.0, 80.0]), 5.0, 7.0));
    assert_eq!(of(Vec::new()).profile.table.keep_out_mm, 2.0);
    note(&of(vec![piece("C", 3.0, 4.0)]), "C box 2 | 5.00 mm");
    note(&of(vec![piece("B", -30.0, 4.0)]), "B box 2 | tilts");
    let bare = told(&lengthened(machine(), vec![piece("Y", 52.0, 200.0)])).unwrap();
    note(&bare, "part X");
    assert!(stated(&bare, "head.body").is_none());
    // Both versions of the file that comes with the program are like this; they do not agree on the tilt.
    for (tilt, beds, wanted) in [
        (false, [([0, 0, -1], false), ([0, 1, 0], false)], None),
        (true, [([0, 0, 1], false), ([0, 1, 0], true)], Some("part B | bedRotAxes | direction")),
        (true, [([0, 0, -1], false), ([0, 1, 0], false)], Some("(part B) | direction")),
        (false, [([0, 0, -1], false), ([0, -1, 0], false)], Some("(bedRotAxes) | direction")),
    ] {
        let mut machine = machine();
        machine["kinematics"] = tree(tilt, beds);
        let done = told(&machine).unwrap();
        assert_eq!(stated(&done, "kinematics.tilt.direction").is_some(), wanted.is_none(), "{tilt} {beds:?}");
        assert_eq!(stated(&done, "kinematics.rotation.direction").is_none(), wanted.is_some());
        assert!(wanted.is_none_or(|words| states(&done.notes[0], words)), "{:?}", done.notes);
    }
    let mut moved = machine();
    moved["machineOffset"]["y"] = json!(4.0);
    let moved = told(&moved).unwrap();
    note(&moved, "machineOffset | tilt axis");
    assert!(stated(&moved, "kinematics.pivot_mm").is_none());
    assert_eq!(moved.profile.head.body[2].min_mm, Some([-100.0, 24.0, 42.0]));
    let mut stops = machine();
    stops["limits"]["c"] = json!({"min": -180, "max": 180});
    assert_eq!(told(&stops).unwrap().profile.kinematics.rotation.max_deg, Some(180.0));
}

#[test]
fn the_pieces_of_collision_json_go_over_those_of_the_machine() {
    let folder = folder();
    let pieces = json!({"proxies": [{"id": 1, "part": "X", "type": "box", "sx": 10, "sy": 10, "sz": 10, "ox": 0, "oy": 20, "oz": 0}]});
    lay(folder.path(), &vec![("machine.json", machine().to_string()), ("collision.json", pieces.to_string())]);
    let done = with_rest(folder.path(), &["collision.json", "machine.json"], &[]).unwrap();
    assert_eq!(done.profile.head.body.len(), 3);
    assert!(done.notes.len() == 1 && states(&done.notes[0], "collision.json"), "{:?}", done.notes);
    let alone = with_rest(folder.path(), &["collision.json"], &[]).unwrap_err();
    assert!(fails(&alone, "import/file: collision.json | machine.json"), "{alone}");
    let twice = with_rest(folder.path(), &["machine.json", "machine.json"], &[]).unwrap_err();
    assert!(fails(&twice, "import/file: machine.json"), "{twice}");
}

#[test]
fn what_makes_no_machine_is_refused_with_its_line() {
    let text = serde_json::to_string_pretty(&machine()).unwrap();
    let line = |words: &str| text.lines().position(|l| l.contains(words)).unwrap() + 1;
    let says = |text: &str| {
        let folder = folder();
        lay(folder.path(), &vec![("m.json", text.to_owned())]);
        with_rest(folder.path(), &["m.json"], &[]).expect_err(text)
    };
    for (from, to, wanted) in [
        ("\"_version\": 1", "\"_version\": 2", "_version | 2 | 1"),
        ("\"nozzleDiameter\": 0.5", "\"nozzleDiameter\": null", "nozzleDiameter | \"null\""),
        ("\"nozzleDiameter\": 0.5", "\"nozzleDiameter\": \"fine\"", "number"),
        ("\"min\": -45", "\"min\": 60", "Y | 60"),
        ("\"angle\": 45", "\"angle\": 90", "nozzle.angle | above 0 and below 90 deg | got 90"),
        ("\"base\": 8", "\"base\": 0.5", "base | tip"),
        ("\"length\": 10", "\"length\": -1", "nozzle.length | got -1"),
        ("\"type\": \"cylinder\"", "\"type\": \"cone\"", "\"cone\" | box, cylinder, sphere or hull"),
        ("\"part\": \"Y\"", "\"part\": \"Q\"", "part \"Q\" | Frame, Z, B, C, Y, X"),
        ("\"sx\": 35", "\"sx\": 0", "sx | 0"),
        ("\"oy\": 7,", "\"oy\": 2,", "X cylinder 3 | 1.00 mm"),
        ("\"type\": \"cylinder\"", "\"type\": \"hull\"", "hull | ox, oy and oz | hullPoints"),
        ("\"d\": 80", "\"w\": 80", "buildplate.w | line 4"),
    ] {
        assert!(text.contains(from), "{from} is not in {text}");
        let said = says(&text.replacen(from, to, 1));
        assert!(fails(&said, &format!("import/at: {wanted}")) && said.contains("m.json:"), "{from} -> {to}: {said}");
    }
    let said = says(&text.replacen("\"nozzleDiameter\": 0.5", "\"nozzleDiameter\": null", 1));
    assert!(fails(&said, &format!("import/at: m.json:{}", line("nozzleDiameter"))), "{said}");
    assert!(fails(&says(&text[..text.len() / 2]), "import/at: m.json | JSON"));
    assert!(fails(&says("{\"a\": 1}"), "import/file: m.json | [KINS]"));
    let deep = says(&format!("{{\"limits\": {}{}}}", "[".repeat(5000), "]".repeat(5000)));
    assert!(fails(&deep, "import/at: m.json | JSON"), "{deep}");
    // Trees that are none of such a table.
    let fine = [([0, 0, -1], false), ([0, 1, 0], false)];
    for (part, key, value, wanted) in [
        (1, "parent", json!("C"), "part Z"),
        (1, "invert", json!(false), "part Z | lower Z"),
        (4, "invert", json!(true), "part Y | lower Y"),
        (2, "threeAxis", json!([1, 0, 0]), "threeAxis | Y | [0, 0, -1] | got [1.0, 0.0, 0.0]"),
        (2, "gcode", json!("ma"), "\"ma\" | mx, my or mz | mb or mc"),
        (3, "parent", json!("Z"), "part C | mc | mb"),
        (5, "parent", json!("B"), "part X | nozzle"),
        (5, "parent", json!("Frame"), "Y | bed | nozzle"),
        (5, "parent", json!("W"), "part \"W\""),
        (5, "name", json!("Y"), "part \"Y\""),
        (4, "threeAxis", json!([0, 0]), "threeAxis | three numbers"),
        (4, "invert", json!("no"), "invert | true | false"),
    ] {
        let mut machine = machine();
        machine["kinematics"] = tree(false, fine);
        machine["kinematics"]["parts"][part][key] = value.clone();
        let said = told(&machine).expect_err(wanted);
        assert!(
            fails(&said, &format!("import/at: {wanted}")) && said.contains("machine.json:"),
            "{part} {key} {value}: {said}"
        );
    }
}
