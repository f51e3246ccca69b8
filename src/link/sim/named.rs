//! What simulated printers do otherwise than their firmware, by name.

use super::Quirks;

/// A quirk's name, and what it changes.
pub type NamedQuirk = (&'static str, fn(&mut Quirks));

/// The quirks that can be asked for.
pub const QUIRKS: [NamedQuirk; 17] = [
    ("advanced-ok", |q| q.advanced_ok = true),
    ("no-ok-after-resend", |q| q.ok_after_resend = false),
    ("refuses-doubles", |q| q.silent_duplicates = false),
    ("no-emergency-parser", |q| q.emergency_parser = false),
    ("no-busy", |q| q.busy = false),
    ("repetier-errors", |q| q.repetier_errors = true),
    ("sprinter-errors", |q| q.sprinter_errors = true),
    ("smoothie-resends", |q| q.smoothie_resends = true),
    ("blank-behind-slash", |q| q.blank_behind_slash = true),
    ("latches-errors", |q| q.latches_errors = true),
    ("work-offset", |q| q.work_offset = [10.0, -20.0, 5.0, 37.0, -8.0]),
    ("three-axes", |q| q.axes = 3),
    ("marlin-1.0", Quirks::marlin_1_0),
    ("marlin-1.1", Quirks::marlin_1_1),
    ("prusa", Quirks::prusa),
    ("rrf-2", Quirks::rrf_2),
    ("fluidnc", Quirks::fluidnc),
];
