//! The rules of shape, print by print: layers, registration, flow.

use rayon::prelude::*;

use super::prints::PrintedPart;
use super::report::Findings;
use super::{fill, flow, layers, registration};

/// Findings of all rules of shape.
pub(super) fn check(printed: &[Option<PrintedPart<'_>>]) -> Findings {
    let each = printed.par_iter().flatten().map(|printed| {
        let mut findings = Findings::default();
        layers::check(printed, &mut findings);
        registration::check(printed, &mut findings);
        flow::check(printed, &mut findings);
        fill::check(printed, &mut findings);
        findings
    });
    let found: Vec<Findings> = each.collect();
    found.into_iter().fold(Findings::default(), |mut all, one| {
        all.absorb(one);
        all
    })
}
