//! The rules of shape, print by print: layers, registration, flow.

use rayon::prelude::*;

use super::evidence::{Checked, Evidence};
use super::prints::PrintedPart;
use super::report::Findings;
use super::{fill, flow, layers, registration};

/// The rules, each of one print.
const RULES: [fn(&PrintedPart<'_>, &mut Findings); 4] = [layers::check, registration::check, flow::check, fill::check];

/// Findings of all rules of shape.
pub(super) fn check(evidence: &Evidence<'_>) -> Checked {
    let each = evidence.printed.par_iter().flatten().map(|printed| {
        let mut findings = Findings::default();
        RULES.iter().for_each(|rule| rule(printed, &mut findings));
        findings
    });
    let found: Vec<Findings> = each.collect();
    let mut all = Findings::default();
    found.into_iter().for_each(|one| all.absorb(one));
    all.into()
}
