//! The kinematic chain against witnesses that share no code with it: published expanded formulas, typed out by hand on
//! plain numbers, and poses worked out on paper.
//!
//! Notation: `r` = LinuxCNC's rot-point, `e` and `d` = its y-offset (x-offset for B/C) and z-offset, `s` = its sense, -1
//! as shipped and +1 with `conventional-directions`; `a`, `b`, `c` = words in degrees; `p` = tip in the program's
//! coordinates; `j` = linear joints. With the chain's names: pivot = r + (0, e, d), offset = -(0, e, d), table = p - r.

use trunnion::geom::{Angle, Dir, Machine, Point, Rigid, Table, Vec3};
use trunnion::motion::{AxisRange, Pose, TableKinematics, TiltAbout};
use trunnion::profile::{resolve, shipped};

use crate::support::Numbers;

/// Rounding of some twenty operations on hundreds of millimetres, with room.
const CLOSE: f64 = 1e-9;

fn axis(letter: u8, direction: f64, zero_deg: f64) -> AxisRange {
    AxisRange { letter, direction, zero: Angle::from_deg(zero_deg), range: None, max_rate: 1.0, absent: false }
}

/// The chain with pivot and offset of LinuxCNC's numbers, and one direction for each axis.
fn chain(about: TiltAbout, r: [f64; 3], d: [f64; 3], directions: [f64; 2]) -> TableKinematics {
    TableKinematics {
        about,
        pivot: Vec3::from(r) + Vec3::from(d),
        offset: -Vec3::from(d),
        tilt: axis(if about == TiltAbout::X { b'A' } else { b'B' }, directions[0], 0.0),
        rotation: axis(b'C', directions[1], 0.0),
        misaligned: None,
        head: None,
    }
}

/// The table's motion at the firmware's words.
fn at_words(table: &TableKinematics, tilt: f64, rotation: f64) -> Rigid<Table, Machine> {
    table.forward(Pose {
        tilt: table.tilt.angle_of(Angle::from_deg(tilt)),
        rotation: table.rotation.angle_of(Angle::from_deg(rotation)),
    })
}

fn minus(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

fn assert_close(got: &Vec3, wanted: [f64; 3], what: &str) {
    assert!((got - Vec3::from(wanted)).norm() < CLOSE, "{what}: {got:?}, wanted {wanted:?}");
}

/// `xyzac-trt-kins`, world to joints.
pub(crate) fn xyzac_inverse(p: [f64; 3], a: f64, c: f64, r: [f64; 3], e: f64, d: f64, s: f64) -> [f64; 3] {
    let (sa, ca) = a.to_radians().sin_cos();
    let (sc, cc) = c.to_radians().sin_cos();
    let [x, y, z] = minus(p, r);
    [
        cc * x + s * sc * y + r[0],
        -s * sc * ca * x + cc * ca * y + s * sa * z - ca * e - s * sa * d + e + r[1],
        sc * sa * x - s * cc * sa * y + ca * z + s * sa * e - ca * d + d + r[2],
    ]
}

/// `xyzac-trt-kins`, joints to world.
fn xyzac_forward(j: [f64; 3], a: f64, c: f64, r: [f64; 3], e: f64, d: f64, s: f64) -> [f64; 3] {
    let (sa, ca) = a.to_radians().sin_cos();
    let (sc, cc) = c.to_radians().sin_cos();
    let [x, y, z] = minus(j, [r[0], r[1] + e, r[2] + d]);
    [
        cc * x - s * sc * ca * y + sc * sa * z - s * sc * e + r[0],
        s * sc * x + cc * ca * y - s * cc * sa * z + cc * e + r[1],
        s * sa * y + ca * z + d + r[2],
    ]
}

/// The same for a table that tilts about Y (`xyzbc-trt-kins`, with the signs that invert its forward), world to joints.
/// `s` is the tilt's sense, `t` the rotation's.
pub(crate) fn xyzbc_inverse(p: [f64; 3], b: f64, c: f64, r: [f64; 3], [e, d]: [f64; 2], [s, t]: [f64; 2]) -> [f64; 3] {
    let (sb, cb) = b.to_radians().sin_cos();
    let (sc, cc) = c.to_radians().sin_cos();
    let [x, y, z] = minus(p, r);
    [
        cb * cc * x + cb * t * sc * y - s * sb * z - cb * e + s * sb * d + e + r[0],
        -t * sc * x + cc * y + r[1],
        s * sb * cc * x + s * t * sb * sc * y + cb * z - s * sb * e - cb * d + d + r[2],
    ]
}

/// `Marlin2ForPipetBot`'s `PENTA_AXIS_TRT` for A and C: `m` = machine rotary zero point, `ry`, `rz` = rotational joint
/// offsets, `p` counted from `m`.
fn marlin_trt(p: [f64; 3], a: f64, c: f64, m: [f64; 3], ry: f64, rz: f64) -> [f64; 3] {
    let (sa, ca) = a.to_radians().sin_cos();
    let (s, c) = c.to_radians().sin_cos();
    let [px, py, pz] = p;
    [
        c * px + s * py + m[0],
        -s * ca * px + c * ca * py + sa * pz - ca * ry - sa * rz + ry + m[1],
        s * sa * px - c * sa * py + ca * pz + sa * ry - ca * rz + rz + m[2],
    ]
}

/// The same for B and C: `rx`, `rz` = rotational joint offsets, M665's I and K.
fn marlin_trt_about_y(p: [f64; 3], b: f64, c: f64, m: [f64; 3], rx: f64, rz: f64) -> [f64; 3] {
    let (sb, cb) = b.to_radians().sin_cos();
    let (s, c) = c.to_radians().sin_cos();
    let [px, py, pz] = p;
    [
        c * cb * px - s * cb * py - sb * pz - cb * rx + sb * rz + rx + m[0],
        s * px + c * py + m[1],
        c * sb * px - s * sb * py + cb * pz - sb * rx - cb * rz + rz + m[2],
    ]
}

#[test]
fn an_a_c_table_agrees_with_linuxcnc_in_both_senses_and_both_ways() {
    let mut numbers = Numbers::seeded(1);
    for round in 0..4000 {
        let s = if round % 2 == 0 { -1.0 } else { 1.0 };
        let (r, p) = (numbers.triple(50.0), numbers.triple(200.0));
        let (e, d) = (numbers.between(-60.0, 60.0), numbers.between(-60.0, 60.0));
        let (a, c) = (numbers.between(-180.0, 180.0), numbers.between(-720.0, 720.0));
        let table = chain(TiltAbout::X, r, [0.0, e, d], [-s, -s]);
        let motion = at_words(&table, a, c);
        let what = format!("s={s} p={p:?} A{a} C{c} r={r:?} e={e} d={d}");
        let joints = xyzac_inverse(p, a, c, r, e, d, s);
        assert_close(&motion.point(Point::from(Vec3::from(minus(p, r)))).at, joints, &what);
        let back = motion.inverse().point(Point::from(Vec3::from(joints))).at + Vec3::from(r);
        assert_close(&back, xyzac_forward(joints, a, c, r, e, d, s), &what);
        assert_close(&back, p, &what);
    }
}

#[test]
fn an_a_c_table_of_both_directions_reversed_agrees_with_the_marlin_fork() {
    let mut numbers = Numbers::seeded(2);
    for _ in 0..2000 {
        let (m, p) = (numbers.triple(200.0), numbers.triple(200.0));
        let (ry, rz) = (numbers.between(-40.0, 40.0), numbers.between(-40.0, 40.0));
        let (a, c) = (numbers.between(-120.0, 120.0), numbers.between(-720.0, 720.0));
        let table = chain(TiltAbout::X, m, [0.0, ry, rz], [-1.0, -1.0]);
        let got = at_words(&table, a, c).point(Point::from(Vec3::from(p)));
        assert_close(&got.at, marlin_trt(p, a, c, m, ry, rz), &format!("p={p:?} A{a} C{c} m={m:?} r=({ry}, {rz})"));
    }
}

#[test]
fn a_b_c_table_agrees_with_the_expanded_formula_in_every_pair_of_senses() {
    let mut numbers = Numbers::seeded(3);
    for round in 0..4000 {
        // (1, -1) is the Marlin fork's B table, whose C turns the other way than its B.
        let (s, t) = [(-1.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0)][round % 4];
        let (r, p) = (numbers.triple(50.0), numbers.triple(200.0));
        let (e, d) = (numbers.between(-60.0, 60.0), numbers.between(-60.0, 60.0));
        let (b, c) = (numbers.between(-180.0, 180.0), numbers.between(-720.0, 720.0));
        let table = chain(TiltAbout::Y, r, [e, 0.0, d], [-s, -t]);
        let got = at_words(&table, b, c).point(Point::from(Vec3::from(minus(p, r))));
        let what = format!("s={s} t={t} p={p:?} B{b} C{c} r={r:?} e={e} d={d}");
        assert_close(&got.at, xyzbc_inverse(p, b, c, r, [e, d], [s, t]), &what);
    }
}

#[test]
fn a_b_c_table_agrees_with_the_marlin_fork() {
    let mut numbers = Numbers::seeded(9);
    for _ in 0..2000 {
        let (m, p) = (numbers.triple(200.0), numbers.triple(200.0));
        let (rx, rz) = (numbers.between(-40.0, 40.0), numbers.between(-40.0, 40.0));
        let (b, c) = (numbers.between(-120.0, 120.0), numbers.between(-720.0, 720.0));
        let table = chain(TiltAbout::Y, m, [rx, 0.0, rz], [-1.0, 1.0]);
        let got = at_words(&table, b, c).point(Point::from(Vec3::from(p)));
        let what = format!("p={p:?} B{b} C{c} m={m:?} r=({rx}, {rz})");
        assert_close(&got.at, marlin_trt_about_y(p, b, c, m, rx, rz), &what);
    }
}

/// The numbers of the two configurations, and beside them others that a user would measure: M665's words as its profile has them.
#[test]
fn the_shipped_profiles_of_the_marlin_fork_are_its_formula() {
    let mut numbers = Numbers::seeded(10);
    for round in 0..1000 {
        let about_y = round % 2 == 1;
        let name = if about_y { "penta-trt-bc" } else { "hendrikjan-5d" };
        let (mut m, mut offsets) = ([0.0, 0.0, if about_y { -220.0 } else { 0.0 }], [0.0, 0.0]);
        let mut text = format!("extends = \"{name}\"\n");
        if round % 4 > 1 {
            (m, offsets) = (numbers.triple(100.0), [numbers.between(-40.0, 40.0), numbers.between(-40.0, 40.0)]);
            let [beside, up] = offsets;
            let d = if about_y { [beside, 0.0, up] } else { [0.0, beside, up] };
            let pivot = [m[0] + d[0], m[1] + d[1], m[2] + d[2]];
            text += &format!("[kinematics]\npivot_mm = {pivot:?}\noffset_mm = {:?}\n", d.map(|v| 0.0 - v));
        }
        let table = resolve("mine.toml", &text).unwrap().0.kinematics();
        let (p, c) = (numbers.triple(100.0), numbers.between(-360.0, 360.0));
        let tilt = if about_y { numbers.between(-45.0, 45.0) } else { numbers.between(-90.0, 0.0) };
        let [beside, up] = offsets;
        let formula = if about_y { marlin_trt_about_y } else { marlin_trt };
        let got = at_words(&table, tilt, c).point(Point::from(Vec3::from(p)));
        assert_close(&got.at, formula(p, tilt, c, m, beside, up), &format!("{text} p={p:?} {tilt} {c}"));
    }
}

#[test]
fn the_shipped_generic_table_about_y_is_the_expanded_formula() {
    let (file, text) = shipped("generic-bc").unwrap();
    let table = resolve(file, text).unwrap().0.kinematics();
    let mut numbers = Numbers::seeded(11);
    for _ in 0..1000 {
        let (p, b, c) = (numbers.triple(100.0), numbers.between(-15.0, 90.0), numbers.between(-3600.0, 3600.0));
        let got = at_words(&table, b, c).point(Point::from(Vec3::from(p)));
        // Right-handed both; the tilt axis 20 mm below the middle of the table's surface, which is the machine's zero.
        let wanted = xyzbc_inverse(p, b, c, [0.0; 3], [0.0, -20.0], [-1.0, -1.0]);
        assert_close(&got.at, wanted, &format!("p={p:?} B{b} C{c}"));
    }
}

#[test]
fn the_shipped_linuxcnc_profile_is_its_sample_configuration() {
    let (file, text) = shipped("linuxcnc-xyzac-trt").unwrap();
    let table = resolve(file, text).unwrap().0.kinematics();
    let mut numbers = Numbers::seeded(4);
    for _ in 0..1000 {
        let (p, a, c) = (numbers.triple(100.0), numbers.between(-100.0, 50.0), numbers.between(-3600.0, 3600.0));
        let got = at_words(&table, a, c).point(Point::from(Vec3::from(p)));
        // xyzac-trt.ini: rot-points 0, y-offset 20, z-offset 10; conventional-directions is not set.
        assert_close(&got.at, xyzac_inverse(p, a, c, [0.0; 3], 20.0, 10.0, -1.0), &format!("p={p:?} A{a} C{c}"));
    }
}

#[test]
fn the_shipped_linuxcnc_profile_about_y_is_its_sample_configuration() {
    let (file, text) = shipped("linuxcnc-xyzbc-trt").unwrap();
    let table = resolve(file, text).unwrap().0.kinematics();
    let mut numbers = Numbers::seeded(6);
    for _ in 0..1000 {
        let (p, b, c) = (numbers.triple(100.0), numbers.between(-100.0, 50.0), numbers.between(-3600.0, 3600.0));
        let got = at_words(&table, b, c).point(Point::from(Vec3::from(p)));
        // xyzbc-trt.ini: rot-points 0, x-offset -20, z-offset -15; conventional-directions is not set.
        assert_close(
            &got.at,
            xyzbc_inverse(p, b, c, [0.0; 3], [-20.0, -15.0], [-1.0, -1.0]),
            &format!("{p:?} B{b} C{c}"),
        );
    }
}

#[test]
fn directions_and_zeros_of_a_profile_reach_the_chain() {
    let text = "extends = \"linuxcnc-xyzac-trt\"\n\
                [kinematics.tilt]\ndirection = -1\nzero_deg = 5.0\n\
                [kinematics.rotation]\ndirection = -1\nzero_deg = -30.0\n";
    let table = resolve("turned.toml", text).unwrap().0.kinematics();
    let mut numbers = Numbers::seeded(5);
    for _ in 0..1000 {
        let (p, a, c) = (numbers.triple(100.0), numbers.between(-100.0, 50.0), numbers.between(-720.0, 720.0));
        let got = at_words(&table, a + 5.0, c - 30.0).point(Point::from(Vec3::from(p)));
        assert_close(&got.at, xyzac_inverse(p, a, c, [0.0; 3], 20.0, 10.0, 1.0), &format!("p={p:?} A{a} C{c}"));
    }
    // +Y is upright at tilt +90 and rotation 0, or at -90 and 180. As words, counted backward from 5 and -30: A-85 C-30,
    // or A95 beyond the stop at 50.
    let pose = table.upright(Dir::new(Vec3::y()).unwrap(), Pose::LEVEL).unwrap();
    let words = (table.tilt.word_of(pose.tilt).deg(), table.rotation.word_of(pose.rotation).deg());
    assert!((words.0 + 85.0).abs() < CLOSE && (words.1 + 30.0).abs() < CLOSE, "{words:?}");
}

/// A pose on paper.
struct Worked {
    about: TiltAbout,
    pivot: [f64; 3],
    offset: [f64; 3],
    tilt: f64,
    rotation: f64,
    table: [f64; 3],
    machine: [f64; 3],
}

#[test]
fn poses_worked_out_on_paper_agree() {
    use TiltAbout::{X, Y};
    let worked = |about, pivot, offset, (tilt, rotation), table, machine| Worked {
        about,
        pivot,
        offset,
        tilt,
        rotation,
        table,
        machine,
    };
    let root3 = 3.0_f64.sqrt();
    let poses = [
        // Level: offset + p = (10, 20, 50), + pivot.
        worked(X, [0.0, 0.0, -20.0], [0.0, 0.0, 20.0], (0.0, 0.0), [10.0, 20.0, 30.0], [10.0, 20.0, 30.0]),
        // Rx(90) takes (x, y, z) to (x, -z, y): (10, 20, 50) to (10, -50, 20), + pivot.
        worked(X, [0.0, 0.0, -20.0], [0.0, 0.0, 20.0], (90.0, 0.0), [10.0, 20.0, 30.0], [10.0, -50.0, 0.0]),
        // Rz(90) takes (x, y) to (-y, x): (-20, 10, 30); + offset (-20, 10, 50); Rx(90): (-20, -50, 10); + pivot.
        worked(X, [0.0, 0.0, -20.0], [0.0, 0.0, 20.0], (90.0, 90.0), [10.0, 20.0, 30.0], [-20.0, -50.0, -10.0]),
        // Rz(180): (-10, -20, 30); + offset (-10, -40, 20); Rx(-90) takes (x, y, z) to (x, z, -y): (-10, 20, 40);
        // + pivot.
        worked(X, [1.0, 2.0, 3.0], [0.0, -20.0, -10.0], (-90.0, 180.0), [10.0, 20.0, 30.0], [-9.0, 22.0, 43.0]),
        // Rz(-90) takes (x, y) to (y, -x): (0, -4, 2); + offset (0, -24, -8).
        // Rx(30): y = -24 cos30 + 8 sin30 = 4 - 12 root3, z = -24 sin30 - 8 cos30 = -12 - 4 root3; + pivot.
        worked(
            X,
            [0.0, 20.0, 10.0],
            [0.0, -20.0, -10.0],
            (30.0, -90.0),
            [4.0, 0.0, 2.0],
            [0.0, 24.0 - 12.0 * root3, -2.0 - 4.0 * root3],
        ),
        // Ry(90) takes (x, y, z) to (z, y, -x): offset + p = (5, 6, 74.98) to (74.98, 6, -5), + pivot.
        worked(Y, [150.4, -17.0, -67.98], [0.0, 0.0, 67.98], (90.0, 0.0), [5.0, 6.0, 7.0], [225.38, -11.0, -72.98]),
        // Rz(90): (-2, 1, 5); + offset (1, 1, 9); Ry(-90) takes (x, y, z) to (-z, y, x): (-9, 1, 1).
        worked(Y, [0.0; 3], [3.0, 0.0, 4.0], (-90.0, 90.0), [1.0, 2.0, 5.0], [-9.0, 1.0, 1.0]),
        // Rz(180): (-1, -2, 4); + offset (1, -2, 4).
        // Ry(60): x = cos60 + 4 sin60 = 0.5 + 2 root3, z = -sin60 + 4 cos60 = 2 - root3 / 2; + pivot.
        worked(
            Y,
            [1.0, 1.0, 1.0],
            [2.0, 0.0, 0.0],
            (60.0, 180.0),
            [1.0, 2.0, 4.0],
            [1.5 + 2.0 * root3, -1.0, 3.0 - root3 / 2.0],
        ),
    ];
    for (row, pose) in poses.iter().enumerate() {
        let table = TableKinematics {
            about: pose.about,
            pivot: Vec3::from(pose.pivot),
            offset: Vec3::from(pose.offset),
            tilt: axis(b'A', 1.0, 0.0),
            rotation: axis(b'C', 1.0, 0.0),
            misaligned: None,
            head: None,
        };
        let got = table.forward(Pose::from_deg(pose.tilt, pose.rotation)).point(Point::from(Vec3::from(pose.table)));
        assert_close(&got.at, pose.machine, &format!("row {row}"));
    }
}

/// Degrees between two angles, whatever the turn.
fn apart(a: Angle, b: Angle) -> f64 {
    (a - b).wrapped().abs().deg()
}

#[test]
fn solutions_are_the_tool_axis_formulas_angles() {
    let mut numbers = Numbers::seeded(6);
    for round in 0..4000 {
        let s = if round % 2 == 0 { -1.0 } else { 1.0 };
        // Away from upright, where the rotation is free.
        let (tilt, c) = (numbers.between(0.5, 179.5), numbers.between(-180.0, 180.0));
        let (st, ct) = tilt.to_radians().sin_cos();
        let (sc, cc) = c.to_radians().sin_cos();
        for (about, n) in [
            // xyzac: n = Rz(s c) Rx(s a) z
            (TiltAbout::X, [sc * st, -s * cc * st, ct]),
            // xyzbc: n = Rz(s c) Ry(s b) z
            (TiltAbout::Y, [s * cc * st, sc * st, ct]),
        ] {
            let table = chain(about, [0.0; 3], [0.0; 3], [-s, -s]);
            let up = Dir::new(Vec3::from(n)).unwrap();
            let words: Vec<(Angle, Angle)> = table
                .solutions(up, Pose::LEVEL)
                .iter()
                .map(|pose| (table.tilt.word_of(pose.tilt), table.rotation.word_of(pose.rotation)))
                .collect();
            assert_eq!(words.len(), 2, "{about:?} {n:?}");
            for (tilt, c) in [(tilt, c), (-tilt, c + 180.0)] {
                let (tilt, c) = (Angle::from_deg(tilt), Angle::from_deg(c));
                let found = words.iter().any(|w| apart(w.0, tilt) < 1e-7 && apart(w.1, c) < 1e-7);
                assert!(found, "{about:?} s={s} n={n:?}: wanted {tilt:?} {c:?} among {words:?}");
            }
        }
    }
}

#[test]
fn shipped_tables_take_a_side_branch_where_their_stops_allow() {
    let side = |profile: &str, d: [f64; 3]| {
        let (file, text) = shipped(profile).unwrap();
        let table = resolve(file, text).unwrap().0.kinematics();
        let pose = table.upright(Dir::new(Vec3::from(d)).unwrap(), Pose::LEVEL).unwrap();
        let deg = |angle: Angle| (angle.deg() * 1e6).round() / 1e6;
        (deg(pose.tilt), deg(pose.rotation).abs())
    };
    // B: Ry(B) takes -X up at +90 and +X up at -90; B stops at -45, so +X turns half round first.
    assert_eq!(side("fibr3d", [1.0, 0.0, 0.0]), (90.0, 180.0));
    assert_eq!(side("fibr3d", [-1.0, 0.0, 0.0]), (90.0, 0.0));
    // A: Rx(A) takes +Y up at +90 and -Y up at -90; this A stops at +50, so +Y turns half round first.
    assert_eq!(side("linuxcnc-xyzac-trt", [0.0, 1.0, 0.0]), (-90.0, 180.0));
    assert_eq!(side("linuxcnc-xyzac-trt", [0.0, -1.0, 0.0]), (-90.0, 0.0));
    // This one stops at -15 and 90.
    assert_eq!(side("generic-ac", [0.0, -1.0, 0.0]), (90.0, 180.0));
    assert_eq!(side("generic-bc", [-1.0, 0.0, 0.0]), (90.0, 0.0));
    assert_eq!(side("generic-bc", [1.0, 0.0, 0.0]), (90.0, 180.0));
    // Its A goes from -90 to 0, counted left-handed: only +Y comes up without a turn.
    assert_eq!(side("hendrikjan-5d", [0.0, 1.0, 0.0]), (90.0, 0.0));
    assert_eq!(side("hendrikjan-5d", [0.0, -1.0, 0.0]), (90.0, 180.0));
    assert_eq!(side("generic-ac", [0.0, 1.0, 1.0]), (45.0, 0.0));
}
