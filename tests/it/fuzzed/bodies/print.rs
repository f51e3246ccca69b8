//! A print under way, for what talks to printers.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use trunnion::link::sim::MachineModel;
use trunnion::link::{Heaters, Program, ProgramRules, Protocol, Retreat, SenderSettings};
use trunnion::profile::Profile;

use super::profiles;

/// A program with layers and two slots, and how it is sent.
pub(super) struct Print {
    pub(super) profile: &'static Profile,
    pub(super) protocol: Protocol,
    pub(super) program: Arc<Program>,
    pub(super) settings: SenderSettings,
}

/// One for each shipped profile that can be sent to.
pub(super) fn prints() -> &'static [Print] {
    static ALL: OnceLock<Vec<Print>> = OnceLock::new();
    ALL.get_or_init(|| profiles().iter().filter_map(print).collect())
}

fn print(profile: &'static Profile) -> Option<Print> {
    let (link, transition, table) = (&profile.link, &profile.transition, profile.kinematics());
    let protocol = Protocol::named(&link.protocol)?;
    let axes = [table.tilt, table.rotation];
    let letters = [&axes[0], &axes[1]].map(|axis| char::from(axis.letter));
    let retreat = Retreat {
        axes,
        z_max_mm: profile.limits.z_mm[1],
        head: None,
        lift_mm: link.lift_mm,
        retract_mm: transition.retract_mm,
        retract_feed: transition.retract_mm_per_s * 60.0,
        travel_feed: transition.travel_mm_per_min,
        z_feed: transition.z_mm_per_min,
        extruder: profile.dialect.extruder as u8,
        heaters: Heaters::Off,
        turning: Default::default(),
        home: vec!["G28".to_owned()],
    };
    let setting = profile.trace_setting();
    let rules = ProgramRules { protocol, longest_line: link.longest_line as usize, setting };
    let program = Program::read(text(letters, char::from(retreat.extruder)).as_bytes(), &rules).ok()?;
    Some(Print { profile, protocol, program: Arc::new(program), settings: SenderSettings::new(protocol, retreat) })
}

/// 120 lines of a print at two poses.
fn text([tilt, rotation]: [char; 2], extruder: char) -> String {
    let mut text = "G21\nG90\nM83\n".to_owned();
    for slot in 0..2 {
        text += &format!(";TRUNNION slot={slot} tilt=0 rotation=0\nG1 Z40 F600\n");
        text += &format!("G1 {rotation}{} F600\nG1 {tilt}0 F600\nG1 X0 Y0 Z10 F3000\n", slot * 90);
        for layer in 0..5 {
            text += &format!(";LAYER_CHANGE\nG1 Z{}\n", 10.0 + 0.2 * f64::from(layer));
            for i in 0..10 {
                text += &format!("G1 X{} Y{} {extruder}0.1\n", i % 4 * 5, i * 3 % 7);
            }
        }
    }
    text
}

/// The machine that a profile describes.
pub(super) fn model(profile: &Profile) -> MachineModel {
    let (table, limits) = (profile.kinematics(), profile.linear_limits());
    MachineModel {
        head: None,
        reading: profile.reading(),
        axes: [table.tilt, table.rotation],
        home_mm: [limits.min.x, limits.min.y, limits.max.z],
        limits,
        rates: profile.trace_setting().rates,
        accelerations: profile.accelerations(),
        coldest_extrusion_c: 170.0,
        heat_factor: 20.0,
        person: Duration::from_secs(30),
    }
}
