//! `profile import`: machines from the configuration of their firmware. The files are written here, in the form of the real ones; LinuxCNC's
//! own examples are read where its package has installed them.

mod command;
mod examples;
pub(crate) mod koala;
mod refused;
mod written;

use std::path::Path;

use trunnion::job::{Answers, ImportProfile, ImportedProfile, Silent, Source, World, import_profile};

use crate::support::coded;

/// Files and what is in them.
pub(crate) type Files = Vec<(&'static str, String)>;

/// Writes `files` below `folder`.
fn lay(folder: &Path, files: &Files) {
    for (name, text) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
}

/// A request for the machine of `given` files of `folder`, nothing answered.
fn request(folder: &Path, given: &[&str]) -> ImportProfile {
    let files = given.iter().map(|name| Source::from(&folder.join(name))).collect();
    ImportProfile { files, name: Some("mine".to_owned()), like: None, answers: Answers::default() }
}

/// The machine, or what the command would print.
fn import(request: &ImportProfile) -> Result<ImportedProfile, String> {
    import_profile(request, &World::here(&Silent)).map_err(|error| coded(error.code(), &error))
}

/// The same with whatever is not told as in the shipped profile; directions, which few firmwares state and none is kept of, are 1.
fn with_rest(folder: &Path, given: &[&str], set: &[(&str, &str)]) -> Result<ImportedProfile, String> {
    let directions = DIRECTIONS.map(|key| (key, "1"));
    kept(folder, given, set).or_else(|error| match DIRECTIONS.iter().any(|key| error.contains(key)) {
        true => kept(folder, given, &[set, &directions].concat()),
        false => Err(error),
    })
}

const DIRECTIONS: [&str; 2] = ["kinematics.tilt.direction", "kinematics.rotation.direction"];

fn kept(folder: &Path, given: &[&str], set: &[(&str, &str)]) -> Result<ImportedProfile, String> {
    let mut request = request(folder, given);
    request.answers.set = set.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    request.answers.rest = true;
    import(&request)
}

/// An ini of a table that tilts, five axes and a filament axis, in as few lines as there may be.
pub(crate) fn small_ini() -> String {
    let mut ini =
        "[KINS]\nKINEMATICS = xyzac-trt-kins sparm=identityfirst\n[TRAJ]\nCOORDINATES = XYZACU\nLINEAR_UNITS = mm\n\
                   [HAL]\nHALCMD = setp xyzac-trt-kins.y-offset 20\nHALCMD = setp xyzac-trt-kins.z-offset 10\n"
            .to_owned();
    for (axis, low, high) in [("X", -200, 200), ("Y", -100, 100), ("Z", -120, 120), ("A", -100, 50), ("C", -3600, 3600)]
    {
        ini += &format!("[AXIS_{axis}]\nMIN_LIMIT = {low}\nMAX_LIMIT = {high}\nMAX_VELOCITY = 20\n");
    }
    ini + "[RS274NGC]\nREMAP = M428 modalgroup=10 ngc=428remap\nREMAP = M429 modalgroup=10 ngc=429remap\n"
}

pub(crate) fn small_klipper() -> String {
    let mut text = "[printer]\nkinematics: corexy\nmax_velocity: 200\nmax_accel: 2000\n".to_owned();
    for axis in ["x", "y", "z"] {
        text += &format!("[stepper_{axis}]\nposition_max: 150\n");
    }
    for (name, letter) in [("tilt", "A"), ("rot", "C")] {
        text += &format!(
            "[manual_stepper {name}]\nvelocity: 20\n[gcode_macro ADD_{letter}]\ngcode:\n  MANUAL_STEPPER STEPPER={name} GCODE_AXIS={letter}\n"
        );
    }
    text + "[heater_bed]\nmax_temp: 120\n"
}

pub(crate) fn small_reprap() -> String {
    "; a machine\nM584 X0 Y1 Z2 A3 C4 E5\nM208 X-100:100 Y-90:90 Z-20:150 A-90:90\nM203 X6000 Y6000 Z600 A1200 C2400\nM201 X1000 Y900 Z100 A200 C300\n"
        .to_owned()
}

pub(crate) fn small_marlin() -> String {
    let mut text = "/* a board */\n#define CONFIGURATION_H_VERSION 02010300\n#define I_DRIVER_TYPE TMC2209\n#define J_DRIVER_TYPE TMC2209\n\
                    #ifdef I_DRIVER_TYPE\n  #define AXIS4_NAME 'A'\n  #define AXIS4_ROTATES\n#endif\n\
                    #ifdef J_DRIVER_TYPE\n  #define AXIS5_NAME 'C'\n  #define AXIS5_ROTATES\n#endif\n\
                    #define DEFAULT_MAX_FEEDRATE { 200, 200, 10, 30, 40, 25 }\n"
        .to_owned();
    for (axis, low, high) in [("X", -100, 100), ("Y", -100, 100), ("Z", -20, 200), ("I", -90, 90)] {
        text += &format!("#define {axis}_MIN_POS {low}\n#define {axis}_MAX_POS {high}\n");
    }
    text
}
