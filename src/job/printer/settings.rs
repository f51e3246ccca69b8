//! A profile as the link's settings: how it is sent to, left, and simulated.

use std::time::Duration;

use super::error::PrinterError;
use crate::input::BadSetting;
use crate::link::sim::{MachineModel, Quirks};
use crate::link::{Abilities, Heaters, ProgramRules, Protocol, Retreat, SenderSettings, Turning};
use crate::profile::{OnStop, Profile, Prove};

pub(crate) fn protocol(profile: &Profile) -> Result<Protocol, PrinterError> {
    let name = &profile.link.protocol;
    Protocol::named(name)
        .ok_or_else(|| PrinterError::Protocol { profile: profile.machine.name.clone(), protocol: name.clone() })
}

pub(crate) fn rules(profile: &Profile) -> Result<ProgramRules, PrinterError> {
    Ok(ProgramRules {
        protocol: protocol(profile)?,
        longest_line: profile.link.longest_line as usize,
        setting: profile.trace_setting(),
    })
}

pub(crate) fn abilities(profile: &Profile) -> Abilities {
    let table = profile.kinematics();
    Abilities {
        limits: profile.linear_limits(),
        axes: [table.tilt, table.rotation],
        max_nozzle_c: profile.link.max_nozzle_c,
        max_bed_c: profile.link.max_bed_c,
    }
}

fn turning(profile: &Profile) -> Turning {
    let [before, after] = profile.transition.around_turn().map(|lines| lines.into_iter().map(str::to_owned).collect());
    Turning { before, after, steppers: profile.steppers() }
}

pub(crate) fn retreat(profile: &Profile) -> Retreat {
    let table = profile.kinematics();
    let (transition, link) = (&profile.transition, &profile.link);
    Retreat {
        axes: [table.tilt, table.rotation],
        z_max_mm: profile.limits.z_mm[1],
        head: table.head.map(|head| (head, profile.linear_limits())),
        lift_mm: link.lift_mm,
        retract_mm: transition.retract_mm,
        retract_feed: transition.retract_mm_per_s * 60.0,
        travel_feed: transition.travel_mm_per_min,
        z_feed: transition.z_mm_per_min,
        extruder: profile.dialect.extruder as u8,
        heaters: match link.on_stop {
            OnStop::Off => Heaters::Off,
            OnStop::KeepBed => Heaters::KeepBed,
            OnStop::Keep => Heaters::Keep,
        },
        turning: turning(profile),
        home: link.rehome.lines().map(str::trim).filter(|l| !l.is_empty()).map(str::to_owned).collect(),
    }
}

pub(crate) fn settings(profile: &Profile) -> Result<SenderSettings, PrinterError> {
    let protocol = protocol(profile)?;
    let (buffer, commands) = (profile.link.buffer as usize, profile.link.commands as usize);
    let mut settings = SenderSettings::new(protocol, retreat(profile)).with_buffers(buffer, commands);
    settings.reads = Duration::from_secs_f64(profile.link.reads_ms / 1000.0);
    settings.blank_after_number = profile.link.blank_after_number;
    settings.prove_layers = profile.link.prove == Prove::Layer;
    if settings.prove_layers && !protocol.firmware().is_printer() {
        let wanted = "this firmware has no M114; use \"count\"".to_owned();
        return Err(BadSetting::Words { name: "[link] prove", text: "layer".to_owned(), wanted }.into());
    }
    settings.planner_blocks = profile.link.planner;
    settings.identity = Some(profile.link.identity.clone()).filter(|i| !i.is_empty());
    Ok(settings)
}

/// The machine that a profile describes, as far as it does.
pub(crate) fn model(profile: &Profile) -> Result<MachineModel, PrinterError> {
    let table = profile.kinematics();
    let limits = profile.linear_limits();
    let heated = protocol(profile)?.firmware().is_printer();
    Ok(MachineModel {
        reading: profile.reading(),
        axes: [table.tilt, table.rotation],
        home_mm: [limits.min.x, limits.min.y, limits.max.z],
        limits,
        head: table.head,
        rates: profile.trace_setting().rates,
        accelerations: profile.accelerations(),
        coldest_extrusion_c: if heated { 170.0 } else { 0.0 },
        heat_factor: 1.0,
        person: Duration::from_secs(30),
    })
}

pub(crate) fn quirks(profile: &Profile) -> Result<Quirks, PrinterError> {
    let mut quirks = Quirks::of(protocol(profile)?);
    quirks.receive_buffer = profile.link.buffer as usize;
    quirks.queue = (profile.link.commands as usize).max(1);
    quirks.name.clone_from(&profile.machine.name);
    quirks.wanted.clone_from(&profile.link.identity);
    Ok(quirks)
}
