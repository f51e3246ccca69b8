//! LinuxCNC's own sample configurations, and its published kinematics, as witnesses.

use std::path::{Path, PathBuf};

use trunnion::geom::{Angle, Point, Vec3};
use trunnion::motion::Pose;
use trunnion::profile::{Profile, resolve, shipped};

use super::{import, lay, request, small_ini, with_rest};
use crate::kinematics::{xyzac_inverse, xyzbc_inverse};
use crate::support::{Numbers, fails, folder, skip};

const SAMPLES: &str = "/usr/share/doc/linuxcnc/examples/sample-configs/sim/axis/vismach/5axis";

/// The folder of a sample; `None`, said aloud, where it is not installed.
fn sample(name: &str) -> Option<PathBuf> {
    let path = Path::new(SAMPLES).join(name);
    if !path.is_file() {
        skip(&format!("LinuxCNC's sample {name} is not installed (apt-get install linuxcnc-uspace)"));
        return None;
    }
    path.parent().map(Path::to_owned)
}

fn shipped_profile(name: &str) -> Profile {
    let (file, text) = shipped(name).unwrap();
    resolve(file, text).unwrap().0
}

#[test]
fn linuxcncs_own_tables_are_the_shipped_profiles() {
    for (ini, name) in [("xyzac-trt.ini", "linuxcnc-xyzac-trt"), ("xyzbc-trt.ini", "linuxcnc-xyzbc-trt")] {
        let Some(folder) = sample(&format!("table-rotary-tilting/{ini}")) else { return };
        let done = with_rest(&folder, &[ini], &[]).unwrap();
        let mut wanted = shipped_profile(name);
        // The shipped profile leaves these to the defaults; the ini says 300 for every axis.
        wanted.limits.acceleration_mm_per_s2 = 300.0;
        wanted.limits.z_acceleration_mm_per_s2 = 300.0;
        wanted.limits.turn_acceleration_deg_per_s2 = 300.0;
        wanted.machine = done.profile.machine.clone();
        assert_eq!(done.profile, wanted, "{ini}");
        assert_eq!(done.like.name, name);
        assert_eq!(done.unanswered, ["table.radius_mm", "process.nozzle_mm"], "{ini}");
        // A sample without a filament axis, whose pins a program might set too.
        assert_eq!(done.notes.len(), 2, "{:?}", done.notes);
        let untold = import(&request(&folder, &[ini])).unwrap_err();
        assert!(fails(&untold, "job/untold: table.radius_mm | process.nozzle_mm"), "{untold}");
    }
}

#[test]
fn linuxcncs_other_machines_are_refused() {
    for (ini, words) in [
        ("bridgemill/5axis.ini", "kinematics \"5axiskins\""),
        ("table-dual-rotary/xyzab-tdr.ini", "kinematics \"xyzab_tdr_kins\""),
        ("max5/max5kins.ini", "kinematics \"maxkins\""),
    ] {
        let Some(folder) = sample(ini) else { return };
        let refused = with_rest(&folder, &[ini.rsplit('/').next().unwrap()], &[]).unwrap_err();
        assert!(fails(&refused, &format!("import/at: {words}")), "{ini}: {refused}");
    }
}

/// The imported chain, word by word, against the published formulas with LinuxCNC's own numbers.
#[test]
fn an_imported_chain_is_the_published_formula() {
    let mut numbers = Numbers::seeded(81);
    for round in 0..40 {
        let about_y = round % 2 == 1;
        let conventional = round % 4 > 1;
        let (r, [e, d, _]) = (numbers.triple(50.0), numbers.triple(40.0));
        let (name, beside) = if about_y { ("xyzbc-trt-kins", "x") } else { ("xyzac-trt-kins", "y") };
        let mut ini = small_ini().replace("xyzac-trt-kins.y-offset 20", &format!("{name}.{beside}-offset {e}"));
        ini =
            ini.replace("xyzac-trt-kins.z-offset 10", &format!("{name}.z-offset {d}")).replace("xyzac-trt-kins", name);
        if about_y {
            ini = ini.replace("XYZACU", "XYZBCU").replace("AXIS_A", "AXIS_B");
        }
        ini += "[HAL]\n";
        for (axis, r) in ["x", "y", "z"].iter().zip(r) {
            ini += &format!("HALCMD = setp {name}.{axis}-rot-point {r}\n");
        }
        if conventional {
            ini += &format!("HALCMD = setp {name}.conventional-directions 1\n");
        }
        let folder = folder();
        lay(folder.path(), &vec![("m.ini", ini)]);
        let table = with_rest(folder.path(), &["m.ini"], &[]).unwrap().profile.kinematics();
        let s = if conventional { 1.0 } else { -1.0 };
        for _ in 0..10 {
            let (p, a, c) = (numbers.triple(100.0), numbers.between(-90.0, 45.0), numbers.between(-400.0, 400.0));
            let wanted =
                if about_y { xyzbc_inverse(p, a, c, r, [e, d], [s, s]) } else { xyzac_inverse(p, a, c, r, e, d, s) };
            let pose = Pose {
                tilt: table.tilt.angle_of(Angle::from_deg(a)),
                rotation: table.rotation.angle_of(Angle::from_deg(c)),
            };
            let got = table.forward(pose).point(Point::from(Vec3::from(p) - Vec3::from(r))).at;
            // The offsets are kept to a millionth of a millimetre.
            let off = (0..3).map(|i| (got[i] - wanted[i]).abs()).fold(0.0, f64::max);
            assert!(off < 5e-6, "{round}: {got:?}, wanted {wanted:?}");
        }
    }
}
