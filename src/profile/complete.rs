//! A profile as a file of its own: every key with its value, under the reference's comments.
//!
//! The reference (`defaults.toml`) is gone through line by line, and only values are exchanged, so that the comments stay what they are there.

use std::fmt::Write;

use toml::{Table, Value};

use super::layers::DEFAULTS;
use super::schema::{BodySpec, Profile};

/// Comments of the reference behind which keys stand that may be absent.
const BEHIND: [(&str, &[&str]); 17] = [
    ("# jogged = ", &["machine.jogged", "machine.jogged_as"]),
    ("# turns = \"head\"", &["kinematics.tilt.turns"]),
    ("# from_tip_mm = [0.0, 0.0, 50", &["kinematics.tilt.from_tip_mm"]),
    ("# turns = \"none\"", &["kinematics.rotation.turns"]),
    ("# from_tip_mm = [0.0, 0.0, 55", &["kinematics.rotation.from_tip_mm"]),
    ("# along = [0.99999, ", &["kinematics.tilt.along"]),
    ("# along = [0.0, ", &["kinematics.rotation.along"]),
    ("# min_deg, max_deg: stops, as words.", &["kinematics.rotation.min_deg", "kinematics.rotation.max_deg"]),
    ("# max_turns = ", &["kinematics.rotation.max_turns"]),
    ("# holding_nm = ", &["kinematics.tilt.holding_nm"]),
    ("# stepper = \"tilt\"", &["kinematics.tilt.stepper"]),
    ("# stepper = \"rot\"", &["kinematics.rotation.stepper"]),
    ("# size_mm = ", &["table.size_mm"]),
    ("# park_mm = ", &["transition.park_mm"]),
    ("# mm_per_s = ", &["joint.mm_per_s"]),
    ("# fan = ", &["joint.fan"]),
    ("# nozzle_c = ", &["joint.nozzle_c"]),
];

impl Profile {
    /// The whole of it as TOML, `heading` first, each line of which becomes a comment. Read again it is the same profile.
    pub fn complete(&self, heading: &str) -> String {
        let values = Table::try_from(self).unwrap_or_default();
        let mut writer = Writer { values: &values, profile: self, section: String::new(), out: String::new() };
        for line in heading.lines() {
            let _ = writeln!(writer.out, "# {line}");
        }
        let mut lines = DEFAULTS.1.lines().skip_while(|line| line.starts_with('#')).peekable();
        while let Some(line) = lines.next() {
            if line == "[[head.body]]" {
                writer.bodies("head.body", &self.head.body);
                while lines.next_if(|next| !next.starts_with('#')).is_some() {}
            } else if line == "[fixed]" {
                lines.next();
                writer.fixed();
            } else {
                writer.line(line);
                if line.ends_with("\"\"\"") && line.contains('=') {
                    while lines.next().is_some_and(|next| !next.ends_with("\"\"\"")) {}
                }
            }
        }
        writer.out
    }
}

struct Writer<'a> {
    values: &'a Table,
    profile: &'a Profile,
    section: String,
    out: String,
}

impl Writer<'_> {
    fn value(&self, key: &str) -> Option<&Value> {
        let (sections, last) = key.rsplit_once('.')?;
        let table = sections.split('.').try_fold(self.values, |table, name| table.get(name)?.as_table())?;
        table.get(last)
    }

    fn line(&mut self, line: &str) {
        if line.starts_with('[') {
            line.trim_matches(['[', ']']).clone_into(&mut self.section);
        }
        let behind = BEHIND.iter().find(|(comment, _)| line.starts_with(comment));
        let key = line.split_once('=').map(|(key, _)| key.trim()).filter(|_| !line.starts_with('#'));
        let value = key.and_then(|key| Some((key, self.value(&format!("{}.{key}", self.section))?)));
        let written = match value {
            Some((key, value)) => {
                let written = format!("{key} = {value}");
                match line.rsplit_once(" # ").filter(|_| !value.is_str()) {
                    Some((_, comment)) => format!("{written:33} # {comment}"),
                    None => written,
                }
            }
            None => line.to_owned(),
        };
        self.out.push_str(&written);
        self.out.push('\n');
        for key in behind.map_or(&[][..], |(_, keys)| keys) {
            if let (Some(value), Some((_, name))) = (self.value(key), key.rsplit_once('.')) {
                let written = format!("{name} = {value}\n");
                self.out.push_str(&written);
            }
        }
    }

    fn bodies(&mut self, of: &str, bodies: &[BodySpec]) {
        for body in bodies {
            let body = Table::try_from(body).map(|table| table.to_string()).unwrap_or_default();
            let _ = write!(self.out, "[[{of}]]\n{body}\n");
        }
    }

    fn fixed(&mut self) {
        if self.profile.fixed.body.is_empty() {
            self.out.push_str("[fixed]\nbody = []\n");
        } else {
            let profile = self.profile;
            self.bodies("fixed.body", &profile.fixed.body);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::profile::{SHIPPED, resolve};

    #[test]
    fn a_whole_file_is_the_same_profile_and_says_what_each_key_is() {
        let rich = "[table]\nradius_mm = 0.0\nsize_mm = [120.0, 90.5]\n[transition]\npark_mm = [1.0, 2.0]\n\
                    before_turn = \"\"\"\nM400\nM42 P5 S1\"\"\"\nafter_turn = \"M42 P5 S0\"\n\
                    [joint]\nlayers = 2\noverlap_mm = 0.08\nmm_per_s = 12.0\nfan = 0.0\nnozzle_c = 221.5\n\
                    [[fixed.body]]\nname = \"post \\\"a\\\"\"\nkind = \"box\"\nmin_mm = [0, 0, 0]\nmax_mm = [1, 2, 3]\n\
                    [dialect]\nend = \"M84 ; \\\\ \\\"x\\\"\"\nallow = [\"M42\"]\n[kinematics.rotation]\nmin_deg = -5.0\nmax_deg = 300.0\n";
        let all = SHIPPED.map(|(_, file, text)| (file, text));
        let named = "[kinematics.tilt]\nstepper = \"swing\"\nholding_nm = 0.4\n[kinematics.rotation]\nstepper = \"turner\"\nmax_turns = 1.5\n[dialect]\nfirmware = \"klipper\"\n";
        let more = [("rich.toml", rich), ("named.toml", named), ("none.toml", "")];
        for (file, text) in all.into_iter().chain(more) {
            let (profile, _) = resolve(file, text).unwrap();
            let whole = profile.complete("one\ntwo");
            let (again, origin) = resolve("whole.toml", &whole).unwrap_or_else(|e| panic!("{file}: {e}\n{whole}"));
            assert_eq!(again, profile, "{file}:\n{whole}");
            assert!(
                whole.starts_with("# one\n# two\n") && whole.contains("# p_machine = pivot + R_tilt(A)"),
                "{whole}"
            );
            // No value is left to the defaults.
            let left: Vec<_> = origin.iter().filter(|(_, place)| !place.starts_with("whole.toml")).collect();
            assert!(left.is_empty(), "{file}: {left:?}");
        }
    }
}
