//! Rule `heat` as a state: while anything is printed the bed is hot and was waited for, and behind the end nothing is.
//!
//! The nozzle's own heat is the trace's. A bed that the file never heats is none of this rule's, unless the profile's start code waits
//! for it.

use std::collections::BTreeMap;

use super::commands::Permitted;
use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Firmware, Hazard, Heater, effect};
use crate::trace::Zone;

/// A bed at less than this share of the highest that it was set to is as good as off.
const WARM: f64 = 0.5;

/// What is wrong: measured, allowed, in words.
pub(super) type Objection = ([f64; 2], String);

/// The heaters, line after line.
pub(super) struct Heaters {
    /// Whether the profile's start code waits for the bed.
    waits: bool,
    targets: BTreeMap<String, f64>,
    /// The bed's highest target, and whether the program stood until the bed was hot.
    highest_c: f64,
    waited: bool,
    /// Whether anything was laid among the prints, and whether the bed's heat was judged since heaters last changed.
    begun: bool,
    told: bool,
    /// Whether a macro stands behind the end: it may switch off what is on.
    unknown_end: bool,
}

impl Heaters {
    pub(super) fn of(permitted: &Permitted<'_>, firmware: Firmware) -> Self {
        let waits = permitted.start().iter().any(|line| waits_for_bed(firmware, line));
        let (targets, highest_c) = (BTreeMap::new(), 0.0);
        Self { waits, targets, highest_c, waited: false, begun: false, told: false, unknown_end: false }
    }

    /// Takes a line; `own` where it is one of the profile's end code.
    pub(super) fn note(&mut self, effect: Effect, zone: Zone, own: bool) -> Option<Objection> {
        match effect {
            Effect::Heat { heater, target_c, waits } => self.heat(heater, target_c, waits),
            Effect::HeatWait => self.waited |= self.bed_c() > 0.0,
            Effect::HeatersOff | Effect::Hazard(Hazard::Stop | Hazard::End) => self.targets.clear(),
            // A macro may heat and wait, or switch off.
            Effect::Hazard(Hazard::Unknown) => {
                self.waited = true;
                self.unknown_end |= zone == Zone::End;
            }
            _ => return None,
        }
        self.told = false;
        let Effect::Heat { heater, target_c: Some(target), .. } = effect else { return None };
        (zone == Zone::End && target > 0.0 && !own).then(|| {
            let name = name(heater);
            ([target, 0.0], format!("the {name} is set to {target} C after the end of the print; remove the line"))
        })
    }

    fn heat(&mut self, heater: Heater, target_c: Option<f64>, waits: bool) {
        if let Some(target) = target_c {
            self.targets.insert(name(heater), target);
        }
        if heater == Heater::Bed {
            self.waited |= waits;
            self.highest_c = self.highest_c.max(self.bed_c());
        }
    }

    fn bed_c(&self) -> f64 {
        self.targets.get(&name(Heater::Bed)).copied().unwrap_or_default()
    }

    /// Before filament is laid.
    pub(super) fn lay(&mut self) -> Option<Objection> {
        if self.told {
            return None;
        }
        let (now, least) = (self.bed_c(), WARM * self.highest_c);
        let first = !std::mem::replace(&mut self.begun, true);
        let wrong = if first && !self.waited && (self.waits || self.highest_c > 0.0) {
            Some((
                [0.0, 1.0],
                "filament is extruded without waiting for the bed temperature; add M190 with the temperature"
                    .to_owned(),
            ))
        } else if now < least {
            let text = format!(
                "filament is extruded with the bed set to {now} C (minimum {least:.0} C, half of its highest target)"
            );
            Some(([now, least], text))
        } else {
            None
        };
        self.told = true;
        wrong
    }

    /// What is on at the end of the file.
    pub(super) fn end(&self) -> Option<Objection> {
        let (name, target) = self.targets.iter().find(|(_, target)| **target > 0.0)?;
        (!self.unknown_end).then(|| {
            ([*target, 0.0], format!("the {name} stays at {target} C at the end; switch it off in [dialect] end"))
        })
    }
}

fn name(heater: Heater) -> String {
    match heater {
        Heater::Nozzle => "nozzle".to_owned(),
        Heater::OtherNozzle(tool) => format!("nozzle of tool {tool}"),
        Heater::Bed => "bed".to_owned(),
        Heater::Chamber => "chamber".to_owned(),
    }
}

fn waits_for_bed(firmware: Firmware, template: &str) -> bool {
    let mut line = ParsedLine::default();
    let text = template.replace("{bed_c}", "60").replace("{nozzle_c}", "210");
    let read = line.read(text.as_bytes()).is_ok();
    read && matches!(effect(firmware, &line), Effect::Heat { heater: Heater::Bed, waits: true, .. })
}
