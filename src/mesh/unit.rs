//! The unit of a file's coordinates.

use std::fmt;
use std::str::FromStr;

/// A length unit of a model file; parsed from and shown as `um`, `mm`, `cm`, `in`, `ft`, `m`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// `um`, 0.001 mm.
    Micron,
    /// `mm`.
    #[default]
    Millimetre,
    /// `cm`, 10 mm.
    Centimetre,
    /// `in`, 25.4 mm.
    Inch,
    /// `ft`, 304.8 mm.
    Foot,
    /// `m`, 1000 mm.
    Metre,
}

impl Unit {
    /// All units, smallest first.
    pub const ALL: [Self; 6] = [Self::Micron, Self::Millimetre, Self::Centimetre, Self::Inch, Self::Foot, Self::Metre];

    /// Millimetres in one of this unit.
    pub const fn millimetres(self) -> f64 {
        match self {
            Self::Micron => 0.001,
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Inch => 25.4,
            Self::Foot => 304.8,
            Self::Metre => 1000.0,
        }
    }

    /// The short name: `um`, `mm`, `cm`, `in`, `ft` or `m`.
    pub const fn short(self) -> &'static str {
        match self {
            Self::Micron => "um",
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Inch => "in",
            Self::Foot => "ft",
            Self::Metre => "m",
        }
    }

    const fn plural(self) -> &'static str {
        match self {
            Self::Micron => "microns",
            Self::Millimetre => "millimetres",
            Self::Centimetre => "centimetres",
            Self::Inch => "inches",
            Self::Foot => "feet",
            Self::Metre => "metres",
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.short())
    }
}

/// A unit's name that is none of the six.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unit `{0}` is unknown; use um, mm, cm, in, ft or m")]
pub struct UnknownUnit(pub String);

impl FromStr for Unit {
    type Err = UnknownUnit;

    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        Self::ALL.into_iter().find(|unit| unit.short() == text).ok_or_else(|| UnknownUnit(text.to_owned()))
    }
}

/// A model shorter than this in file units is taken to be in metres: no one prints a part below 1 mm.
pub const METRES_BELOW: f64 = 1.0;
/// A model shorter than this may be in inches: PrusaSlicer asks so, too, below 9 mm3. It is read in mm, and said.
pub const INCHES_BELOW: f64 = 4.0;
/// Longer parts than this are rare, mm.
const TABLES_MM: f64 = 400.0;
/// A model longer than this in file units is taken to be in microns: no printer holds a part of 5 m.
pub const MICRONS_ABOVE: f64 = 5000.0;

/// The likely unit of a model whose box is `longest` file units long, and a warning where it is not surely mm.
pub fn guess_unit(longest: f64) -> (Unit, Option<String>) {
    let unit = match longest {
        l if l < METRES_BELOW => Unit::Metre,
        l if l > MICRONS_ABOVE => Unit::Micron,
        l if l < INCHES_BELOW => {
            let mm = longest * Unit::Inch.millimetres();
            let text =
                format!("{longest} long in file units: read in mm; if these are inches, use --unit in ({mm:.1} mm)");
            return (Unit::Millimetre, Some(text));
        }
        _ => return (Unit::Millimetre, None),
    };
    let mm = longest * unit.millimetres();
    let inches_mm = longest * Unit::Inch.millimetres();
    // What would be longer than most tables in metres is as well in inches.
    let large = unit == Unit::Metre && mm > TABLES_MM;
    let inches = if large { format!("--unit in for inches ({inches_mm:.1} mm), ") } else { String::new() };
    let text = format!(
        "{longest} long in file units: read as {} = {mm:.1} mm; use {inches}--unit mm to keep mm",
        unit.plural()
    );
    (unit, Some(text))
}

#[cfg(test)]
mod tests {
    use super::{INCHES_BELOW, Unit, UnknownUnit, guess_unit};

    #[test]
    fn names_go_there_and_back() {
        for unit in Unit::ALL {
            assert_eq!(unit.to_string().parse(), Ok(unit));
        }
        assert_eq!("MM".parse::<Unit>(), Err(UnknownUnit("MM".to_owned())));
        assert_eq!(
            Unit::ALL.map(Unit::millimetres),
            [0.001, 1.0, 10.0, 25.4, 304.8, 1000.0],
            "exact by definition of the inch"
        );
    }

    #[test]
    fn guesses_metres_and_microns_with_a_warning_and_mm_without() {
        let (unit, warning) = guess_unit(0.036);
        assert_eq!(unit, Unit::Metre);
        let wanted = "0.036 long in file units: read as metres = 36.0 mm; use --unit mm to keep mm";
        assert_eq!(warning.as_deref(), Some(wanted));
        assert_eq!(guess_unit(INCHES_BELOW), (Unit::Millimetre, None));
        let (unit, said) = guess_unit(2.95);
        assert_eq!(unit, Unit::Millimetre);
        assert!(said.is_some_and(|said| said.contains("--unit in (74.9 mm)")));
        assert_eq!(guess_unit(5000.0), (Unit::Millimetre, None));
        assert_eq!(guess_unit(5000.5).0, Unit::Micron);
    }
}
