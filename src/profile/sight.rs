//! What a person saw a machine's axes do, held against its profile.

use super::layers::resolve;
use super::schema::{Profile, TiltAxisName};

/// Whether somebody saw on the machine what each axis does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Sight {
    /// On this day, and the profile says the same.
    Seen(String),
    /// On this day, and the profile was changed since.
    Changed(String),
    /// Never.
    Never,
}

impl Profile {
    /// Whether the head is the reference's, which is no machine's: a print is then proved with a head that nobody has measured.
    pub fn head_is_assumed(&self) -> bool {
        let reference = resolve("defaults.toml", "").map(|(reference, _)| reference.head.body);
        !self.head.measured && reference.is_ok_and(|body| body == self.head.body)
    }

    /// What each axis of the table does, as `[machine] jogged_as` has it; with the word at which it is level where that was seen too.
    pub fn axes_in_words(&self, level: bool) -> String {
        let (tilt, rotation) = (&self.kinematics.tilt, &self.kinematics.rotation);
        let name = |letter: char, stepper: &Option<String>| stepper.clone().unwrap_or_else(|| letter.to_string());
        let about = if tilt.about == TiltAxisName::X { 'X' } else { 'Y' };
        let [tilts, turns] = [name(tilt.letter, &tilt.stepper), name(rotation.letter, &rotation.stepper)];
        let (up, round) = (tilt.direction, rotation.direction);
        // A profile for another machine that extends this one is not seen by that.
        let name = &self.machine.name;
        let level = if level { format!(", level at {}", tilt.zero_deg) } else { String::new() };
        format!("{name}: {tilts} about {about} {up:+}{level}; {turns} {round:+}")
    }

    /// Whether what the axes do was seen on the machine, and is still what the profile says.
    pub fn sight(&self) -> Sight {
        match (&self.machine.jogged, &self.machine.jogged_as) {
            (Some(date), Some(seen)) if [true, false].iter().any(|level| *seen == self.axes_in_words(*level)) => {
                Sight::Seen(date.clone())
            }
            (Some(date), _) => Sight::Changed(date.clone()),
            _ => Sight::Never,
        }
    }
}
