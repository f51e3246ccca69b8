//! LinuxCNC's own interpreter as a witness: what we write for it must parse there and end where we think it ends.

use std::process::Command;

use trunnion::gcode::{ParsedLine, lines};
use trunnion::motion::replay::{Controller, Step};
use trunnion::profile::{Profile, resolve, shipped};

use crate::support::{folder, python, root, said, skip};

/// The axes of the `xyzac-trt` simulation with the extruder as U.
const AXES: &str = "XYZACU";

/// A move as LinuxCNC's interpreter hands it to the motion controller.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
pub(crate) struct Feed {
    /// `"feed"`, `"traverse"` or `"arc"`.
    pub(crate) kind: String,
    /// Line of the program, from 1.
    pub(crate) line: u32,
    /// End point, X Y Z A B C U V W, mm and degrees, work offsets of G92 undone.
    pub(crate) to: [f64; 9],
    /// F in force, as written.
    #[serde(rename = "feed")]
    pub(crate) rate: f64,
}

/// The program's moves, or the interpreter's refusal; `None`, said aloud, where LinuxCNC is not installed.
pub(crate) fn interpret(program: &[u8]) -> Option<Result<Vec<Feed>, String>> {
    // The module belongs to the system's Python, which need not be the first on the path.
    let Some(python) = python(&["python3", "/usr/bin/python3"], "gcode") else {
        skip("LinuxCNC's interpreter is not installed (apt-get install linuxcnc-uspace)");
        return None;
    };
    let folder = folder();
    let (file, parameters) = (folder.path().join("program.ngc"), folder.path().join("parameters.var"));
    // A remap of the sample configurations, which the interpreter alone does not know.
    let program = String::from_utf8_lossy(program).replace("\nM429\n", "\n(M429)\n");
    std::fs::write(&file, program).unwrap();
    std::fs::write(&parameters, "").unwrap();
    let script = root().join("tests/harness/rs274_canon.py");
    let output = Command::new(python).arg(script).args([&file, &parameters]).arg(AXES).output().unwrap();
    if !output.status.success() {
        return Some(Err(said(&output)));
    }
    let text = String::from_utf8(output.stdout).unwrap();
    Some(Ok(text.lines().map(|line| serde_json::from_str(line).expect(line)).collect()))
}

/// The moves of a program that LinuxCNC must accept; `None`, said aloud, where it is not installed.
pub(crate) fn canon(program: &[u8]) -> Option<Vec<Feed>> {
    interpret(program).map(|moves| moves.unwrap_or_else(|refusal| panic!("LinuxCNC refuses the program: {refusal}")))
}

/// Each move as our own controller reads the program, in LinuxCNC's terms.
pub(crate) fn ours(program: &[u8], profile: &Profile) -> Vec<Feed> {
    let table = profile.kinematics();
    let mut controller = Controller::new(profile.reading());
    let (mut moves, mut parsed, mut filament) = (Vec::new(), ParsedLine::default(), 0.0);
    for line in lines(program) {
        parsed.read(line.bytes).unwrap();
        let Step::Move(step) = controller.step(&parsed).unwrap() else { continue };
        filament += step.e;
        // LinuxCNC begins at zero where ours does not know yet.
        let [x, y, z] = step.to.linear.map(Option::unwrap_or_default);
        let tilt = step.to.tilt.map_or(0.0, |angle| table.tilt.word_of(angle).deg());
        let rotation = step.to.rotation.map_or(0.0, |angle| table.rotation.word_of(angle).deg());
        let kind = if step.arc.is_some() {
            "arc"
        } else if step.rapid {
            "traverse"
        } else {
            "feed"
        };
        let to = [x, y, z, tilt, 0.0, rotation, filament, 0.0, 0.0];
        moves.push(Feed { kind: kind.to_owned(), line: line.number, to, rate: step.feed.unwrap_or_default() });
    }
    moves
}

/// Checks that both made the same moves: kind, line, end point to a nanometre, F.
pub(crate) fn assert_same(theirs: &[Feed], ours: &[Feed]) {
    assert_eq!(theirs.len(), ours.len(), "{theirs:#?}\n{ours:#?}");
    for (theirs, ours) in theirs.iter().zip(ours) {
        let apart = theirs.to.iter().zip(ours.to).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let alike = (&theirs.kind, theirs.line) == (&ours.kind, ours.line);
        assert!(
            alike && apart < 1e-6 && (theirs.rate - ours.rate).abs() < 1e-6,
            "LinuxCNC: {theirs:?}\nours: {ours:?}"
        );
    }
}

fn profile() -> Profile {
    let (file, text) = shipped("linuxcnc-xyzac-trt").unwrap();
    resolve(file, text).unwrap().0
}

/// The profile's start and end code around moves of every kind that we write or pass on.
fn program() -> String {
    let dialect = profile().dialect;
    let moves = "\
G92 U0
G1 X10 Y-5.25 Z12 F600
G1 X20.5 Y3 U1.25 ; extrude
G0 Z40
G1 A-30.5 C90 F400
X1 Y2 Z3 U2.125
g1x.5u2.5
G2 X10.5 Y2 I5 J0 U3.75 F300
G91
G1 X-2.5 U0.125
G1 C-45
G90
G0 Z50
G1 C-405.0625 A-100
G92 U0
G1 X30 U0.5 F120
G4 P0.1
G1 U-0.5 F60
N70 (up) G0 Z100
";
    format!("{}\n{moves}{}\n", dialect.start, dialect.end)
}

#[test]
fn linuxcnc_ends_every_move_where_our_controller_does() {
    let program = program();
    let Some(theirs) = canon(program.as_bytes()) else { return };
    assert_eq!(theirs.len(), 14, "{theirs:#?}");
    assert_same(&theirs, &ours(program.as_bytes(), &profile()));
}

#[test]
fn linuxcnc_refuses_an_extruder_called_e() {
    let Some(result) = interpret(program().replace("U1.25", "E1.25").as_bytes()) else { return };
    let refusal = result.unwrap_err();
    assert!(refusal.contains("E word with no G70, G76, M66, M67 or M68 to use it"), "{refusal}");
}

#[test]
fn linuxcnc_refuses_an_axis_that_the_machine_lacks() {
    let Some(result) = interpret(program().replace("A-30.5", "B-30.5").as_bytes()) else { return };
    let refusal = result.unwrap_err();
    assert!(refusal.contains("Bad character 'b' used"), "{refusal}");
}

/// A prepared file for LinuxCNC's own table: it must parse there, every move must end where we think it ends, and its
/// published forward formula must put the filament into the part.
#[test]
fn linuxcnc_runs_a_prepared_file_and_its_formula_puts_the_filament_into_the_parts() {
    let folder = folder();
    let file = folder.path().join("two-boxes.ngc");
    crate::pipeline::prepare(&crate::pipeline::fixture("two-boxes"), "linuxcnc-xyzac-trt", "builtin", &file, &[]);
    let program = std::fs::read(&file).unwrap();
    let begin = String::from_utf8_lossy(&program);
    let identity = begin.find("\nM429\n").expect("the identity kinematics is chosen");
    assert!(begin.find("\nG1 ").is_some_and(|first| identity < first), "before the first move");
    let Some(theirs) = canon(&program) else { return };
    assert_same(&theirs, &ours(&program, &profile()));
    // xyzac-trt forward, s = -1, rotation point 0, d = (0, y-offset 20, z-offset 10): p = Rz(-c) [d + Rx(-a) (J - d)].
    let table_point = |to: &[f64; 9]| {
        let (sa, ca) = to[3].to_radians().sin_cos();
        let (sc, cc) = to[5].to_radians().sin_cos();
        let (y, z) = (to[1] - 20.0, to[2] - 10.0);
        let (y, z) = (20.0 + ca * y + sa * z, 10.0 - sa * y + ca * z);
        [cc * to[0] + sc * y, -sc * to[0] + cc * y, z]
    };
    // By hand: the model, 50 mm wide in x, stands centred, so the post has x -25..-5 and the arm x -5..25, z 40..60.
    let inside =
        |p: [f64; 3], min: [f64; 3], max: [f64; 3]| (0..3).all(|i| p[i] > min[i] - 0.01 && p[i] < max[i] + 0.21);
    let (mut post, mut arm) = (0, 0);
    for pair in theirs.windows(2) {
        let [before, after] = pair else { continue };
        let moved = (0..3).any(|i| before.to[i] != after.to[i]);
        if after.to[6] > before.to[6] && moved {
            let p = table_point(&after.to);
            if after.to[3] == 0.0 {
                assert!(inside(p, [-25.0, -10.0, 0.0], [-5.0, 10.0, 60.0]), "line {}: {p:?}", after.line);
                post += 1;
            } else {
                assert!(inside(p, [-5.0, -10.0, 40.0], [25.0, 10.0, 60.0]), "line {}: {p:?}", after.line);
                arm += 1;
            }
        }
    }
    assert!(post > 3000 && arm > 2000, "{post} {arm}");
}
