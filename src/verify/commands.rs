//! Rule `command`: what every line that is no move does is known, and harmless where it stands.
//!
//! What shifts coordinates, changes steps, factors or tools, lets motors go or is unknown may stand only where the profile's
//! own start or end code has it, or where `[dialect] allow` names it. Lines beside turns of the table: see `turn_lines`.

use crate::gcode::ParsedLine;
use crate::gcode::meaning::{Effect, Hazard};
use crate::profile::Dialect;
use crate::trace::Zone;

/// What the profile lets pass.
pub(super) struct Permitted<'a> {
    start: Vec<&'a str>,
    end: Vec<&'a str>,
    allow: &'a [String],
}

impl<'a> Permitted<'a> {
    pub(super) fn by(dialect: &'a Dialect) -> Self {
        let lines = |text: &'a str| text.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
        Self { start: lines(&dialect.start), end: lines(&dialect.end), allow: &dialect.allow }
    }

    /// The end code's lines, in order.
    pub(super) fn end(&self) -> &[&'a str] {
        &self.end
    }

    /// Whether `[dialect] allow` names a command.
    pub(super) fn allows(&self, name: &str) -> bool {
        self.allow.iter().any(|known| known.eq_ignore_ascii_case(name))
    }

    /// Whether a line is one of the profile's own at this place.
    pub(super) fn owns(&self, zone: Zone, text: &[u8]) -> bool {
        let own = match zone {
            Zone::Start => &self.start[..],
            Zone::End => &self.end[..],
            Zone::Prints => &[],
        };
        let text = String::from_utf8_lossy(text);
        own.iter().any(|template| fits(template, text.trim()))
    }

    /// The start code's lines, in order.
    pub(super) fn start(&self) -> &[&'a str] {
        &self.start
    }

    /// What is wrong with a line of this effect at this place, as a sentence; `None` where nothing is. `clear` where the tip is above all
    /// that stands, with the filament pulled back: there a person may be waited for.
    pub(super) fn objection(
        &self,
        effect: Effect,
        zone: Zone,
        line: &ParsedLine,
        text: &[u8],
        clear: bool,
    ) -> Option<String> {
        let does = match effect {
            Effect::Hazard(Hazard::Person) if clear && zone == Zone::Prints => return None,
            Effect::Hazard(hazard) => hazard.does(),
            Effect::Factor { percent: Some(100.0), .. } => return None,
            Effect::Factor { speed: true, .. } => "changes the speed of all later moves",
            Effect::Factor { .. } => "changes the flow of all later lines",
            Effect::Home if zone == Zone::Prints => "homes in the middle of the print",
            Effect::Home if zone == Zone::End => "homes with the finished print on the table",
            Effect::HeatersOff if zone == Zone::Prints => "switches all heaters off in the middle of the print",
            _ => return None,
        };
        let name = name_of(line, text);
        // The tool in use is followed nowhere.
        let allowed = self.allows(&name) && effect != Effect::Hazard(Hazard::Tool);
        if allowed || self.owns(zone, text) {
            return None;
        }
        let place = match zone {
            Zone::Start => "before the prints, and not in [dialect] start",
            Zone::Prints => "between start and end code",
            Zone::End => "after the prints, and not in [dialect] end",
        };
        let remedy = if effect == Effect::Hazard(Hazard::Tool) { "" } else { ", or add it to [dialect] allow" };
        Some(format!("{place}: {name} {does}; remove it{remedy}"))
    }
}

/// The command of a line, as `[dialect] allow` names it.
pub(super) fn name_of(line: &ParsedLine, text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text);
    let word = || text.trim().split([' ', '=']).next().unwrap_or_default().to_owned();
    line.commands.first().map_or_else(word, ToString::to_string)
}

/// Whether `line` is `template` with numbers in the place of `{nozzle_c}` and `{bed_c}`.
pub(super) fn fits(template: &str, line: &str) -> bool {
    let Some((before, rest)) = template.split_once('{') else { return template == line };
    let Some((_, after)) = rest.split_once('}') else { return template == line };
    let Some(line) = line.strip_prefix(before) else { return false };
    let digits = line.bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
    digits > 0 && fits(after, &line[digits..])
}

#[cfg(test)]
mod tests {
    use super::fits;

    #[test]
    fn a_line_of_the_start_code_is_known_with_its_numbers_filled_in() {
        assert!(fits("M109 S{nozzle_c}", "M109 S215.5") && fits("G28", "G28"));
        assert!(fits("START N={nozzle_c} B={bed_c}", "START N=215 B=60"));
        assert!(!fits("M109 S{nozzle_c}", "M109 S") && !fits("M109 S{nozzle_c}", "M104 S215"));
        assert!(!fits("START N={nozzle_c} B={bed_c}", "START N=215 B=60 X"));
    }
}
