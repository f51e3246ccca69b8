//! The part as it lies beside each objective's best: what supports, stairs, height and contact come to.

use std::fmt::Write;

use serde_json::{Value, json};

use super::outcome::Outcome;
use crate::geom::Vec3;
use crate::orient::{ContactArea, Facets, Height, Objective, Settings, Staircase, SupportVolumeColumn, overhang_area};

/// One orientation.
pub(super) struct Compared {
    name: String,
    up: Vec3,
    /// In the order of [`COLUMNS`].
    values: [f64; 5],
}

/// Their names, with their units, and their keys.
const COLUMNS: [(&str, &str); 5] = [
    ("support mm3", "support_volume_mm3"),
    ("overhang mm2", "overhang_area_mm2"),
    ("staircase mm4", "staircase_mm4"),
    ("height mm", "height_mm"),
    ("contact mm2", "contact_area_mm2"),
];

/// As it lies, and the best of each result.
pub(super) fn table(facets: &Facets, results: &[Outcome], settings: &Settings) -> Vec<Compared> {
    let column = SupportVolumeColumn { overhang: settings.overhang, resolution_mm: settings.resolution_mm };
    let row = |(name, up): (String, Vec3)| {
        let values = [
            column.value(facets, &up),
            overhang_area(facets, &up, settings.overhang),
            Staircase { layer_mm: settings.layer_mm }.value(facets, &up),
            Height.value(facets, &up),
            0.0 - ContactArea.value(facets, &up),
        ];
        Compared { name, up, values }
    };
    let best = results.iter().map(|result| (result.objective.clone(), result.best().up));
    std::iter::once(("as it lies".to_owned(), Vec3::z())).chain(best).map(row).collect()
}

impl Compared {
    pub(super) fn document(&self) -> Value {
        let mut row = json!({"orientation": self.name, "up": self.up.as_slice()});
        COLUMNS.iter().zip(self.values).for_each(|((_, key), value)| row[*key] = value.into());
        row
    }
}

pub(super) fn text(rows: &[Compared]) -> String {
    let wide = rows.iter().map(|row| row.name.len()).max().unwrap_or(0);
    let mut out = format!("\n  {:wide$}", "");
    COLUMNS.iter().for_each(|(name, _)| {
        let _ = write!(out, " {name:>14}");
    });
    for row in rows {
        let _ = write!(out, "\n  {:wide$}", row.name);
        row.values.iter().for_each(|value| {
            let _ = write!(out, " {value:>14.4}");
        });
    }
    out.push('\n');
    out
}
