//! Why touches give no machine.

use super::{NoFit, Of, Touches, Undetermined};
use crate::profile::Profile;

/// Why touches give no machine, with where they stand.
#[derive(Debug)]
pub struct Uncalibrated {
    file: String,
    letters: [char; 2],
    names: Vec<String>,
    no: NoFit,
}

impl Uncalibrated {
    /// Why `touches` of `file` give no machine, in the letters of `profile`.
    pub fn of(no: NoFit, file: &str, profile: &Profile, touches: &Touches) -> Self {
        let names = touches.features.iter().map(|f| f.name.clone()).collect();
        let k = &profile.kinematics;
        Self { file: file.to_owned(), letters: [k.tilt.letter, k.rotation.letter], names, no }
    }
}

impl std::fmt::Display for Uncalibrated {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.no {
            NoFit::Touch(number, line, why) => write!(f, "{}:{line}: touch {number}: {why}", self.file),
            NoFit::Unsettled => write!(
                f,
                "{}: no machine fits these touches; check for a mark under a wrong name, or swapped X, Y, Z or angles",
                self.file
            ),
            NoFit::Undetermined(what) => self.undetermined(what, f),
        }
    }
}

impl Uncalibrated {
    fn undetermined(&self, what: &Undetermined, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let told = |(name, error, angle): &(String, f64, bool)| {
            let (unit, hardly) = if *angle { ("deg", 3.0) } else { ("mm", 6.0) };
            let to = if *error > hardly { "unknown".to_owned() } else { format!("known only to {error:.3} {unit}") };
            format!("{name} ({to})")
        };
        let unknowns: Vec<String> = what.unknowns.iter().map(told).collect();
        write!(f, "{}: the touches do not determine {}", self.file, unknowns.join(", "))?;
        if let Some([x, y]) = what.new_mark {
            write!(f, "; draw a mark near X{x} Y{y} of the table and touch it")?;
        }
        if !what.next.is_empty() {
            f.write_str(if what.new_mark.is_some() { " at" } else { "; touch next" })?;
        }
        let [tilt, rotation] = self.letters;
        for (i, one) in what.next.iter().enumerate() {
            let [a, c] = one.words_deg;
            let of = match one.of {
                Of::Table => "the table, ",
                Of::Feature(index) => self.names.get(index).map_or("", |name| name),
            };
            let gap = if matches!(one.of, Of::Feature(i) if i < self.names.len()) { ", " } else { "" };
            write!(
                f,
                "{} {of}{gap}{tilt}{a} {rotation}{c} near X{:.0} Y{:.0}",
                if i > 0 { ";" } else { "" },
                one.tip.x,
                one.tip.y
            )?;
        }
        f.write_str("; trunnion profile calibrate --poses lists all touches to make")
    }
}
