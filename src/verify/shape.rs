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
    let found: Vec<Findings> = evidence.printed.par_iter().flatten().map(of_print).collect();
    let mut all = Findings::default();
    found.into_iter().for_each(|one| all.absorb(one));
    all.into()
}

/// Findings of all rules for one print. The rules run side by side: a part that is printed whole is the only print of its file.
fn of_print(printed: &PrintedPart<'_>) -> Findings {
    let by_rule = RULES.par_iter().with_max_len(1).map(|rule| {
        let mut findings = Findings::default();
        rule(printed, &mut findings);
        findings
    });
    let by_rule: Vec<Findings> = by_rule.collect();
    let mut all = Findings::default();
    by_rule.into_iter().for_each(|one| all.append(one));
    all
}
