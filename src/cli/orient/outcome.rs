//! What `trunnion orient` found, as text and as JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use super::compare::Compared;
use crate::orient::{Found, Minimum, Stop, to_angles};

/// Minima whose values agree to this, relative, are the same: the gap to which the best is proved.
const SAME_VALUE: f64 = 1e-6;

/// One objective's result.
pub(super) struct Outcome {
    pub(super) objective: String,
    pub(super) method: &'static str,
    pub(super) found: Found,
    /// Why there is no lower bound, where there is none.
    pub(super) unproved: Option<String>,
    pub(super) seconds: f64,
}

impl Outcome {
    pub(super) fn best(&self) -> &Minimum {
        &self.found.minima[0]
    }

    /// The gap in words.
    fn gap(&self, bound: f64) -> String {
        let best = self.best().value;
        let gap = if best == bound { 0.0 } else { (best - bound) / best.abs() };
        let end = if self.found.stop == Stop::Budget { ", where the budget ended" } else { "" };
        if gap.is_finite() && bound != 0.0 {
            format!(" (gap {gap:.1e}{end})")
        } else {
            format!(" (gap {:.3e}{end})", best - bound)
        }
    }

    fn kind(&self, minimum: &Minimum) -> &'static str {
        let best = self.best().value;
        if minimum.value <= best + SAME_VALUE * best.abs() { "global" } else { "local" }
    }

    fn document(&self) -> Value {
        // Minus nothing is nothing: `+ 0.0` takes the sign off.
        let minimum = |m: &Minimum| {
            let (alpha, beta) = to_angles(&m.up);
            json!({
                "value": m.value + 0.0, "up": m.up.as_slice(), "kind": self.kind(m),
                "alpha_deg": alpha.to_degrees(), "beta_deg": beta.to_degrees(),
            })
        };
        let mut document = json!({
            "objective": self.objective, "method": self.method,
            "minima": self.found.minima.iter().map(minimum).collect::<Vec<_>>(),
            "lower_bound": self.found.lower_bound, "stop": stopped(self.found.stop), "evaluations": self.found.evaluations, "seconds": self.seconds,
        });
        if let Some(why) = &self.unproved {
            document["unproved"] = why.as_str().into();
        }
        document
    }

    fn text(&self, out: &mut String) {
        let proof = match self.found.lower_bound {
            Some(bound) => format!("proved at least {bound:.9e}{}", self.gap(bound)),
            None => self.unproved.as_ref().map_or("not proved".to_owned(), |why| format!("not proved ({why})")),
        };
        let (evaluations, seconds) = (self.found.evaluations, self.seconds);
        let _ = writeln!(
            out,
            "\n  {} by {}: {proof}, {evaluations} evaluations, {seconds:.2} s",
            self.objective, self.method
        );
        let _ = writeln!(out, "    value             up                              alpha     beta  deg");
        for m in self.found.minima.iter().take(SHOWN) {
            let (alpha, beta) = to_angles(&m.up);
            let up = format!("({:.5}, {:.5}, {:.5})", m.up.x, m.up.y, m.up.z);
            let (alpha, beta) = (alpha.to_degrees(), beta.to_degrees());
            let _ = writeln!(out, "    {:<17.9e} {up:30} {alpha:8.3} {beta:8.3}  {}", m.value + 0.0, self.kind(m));
        }
        if self.found.minima.len() > SHOWN {
            let _ = writeln!(out, "    and {} more; --json lists them", self.found.minima.len() - SHOWN);
        }
    }
}

/// Minima shown of each objective.
const SHOWN: usize = 8;

/// One part's results.
pub(super) struct Done {
    pub(super) id: usize,
    pub(super) facets: usize,
    pub(super) results: Vec<Outcome>,
    pub(super) compared: Option<Vec<Compared>>,
}

impl Done {
    pub(super) fn document(&self) -> Value {
        let results: Vec<Value> = self.results.iter().map(Outcome::document).collect();
        let mut document = json!({"id": self.id, "facets": self.facets, "results": results});
        if let Some(rows) = &self.compared {
            document["compare"] = rows.iter().map(Compared::document).collect();
        }
        document
    }

    pub(super) fn text(&self) -> String {
        let mut out = format!("part {}, {} facets\n", self.id, self.facets);
        self.results.iter().for_each(|result| result.text(&mut out));
        self.compared.iter().for_each(|rows| out.push_str(&super::compare::text(rows)));
        out.push('\n');
        out
    }
}

fn stopped(stop: Stop) -> &'static str {
    match stop {
        Stop::Converged => "converged",
        Stop::Budget => "budget",
    }
}
