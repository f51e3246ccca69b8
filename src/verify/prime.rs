//! Rule `outside-part` for prime lines: what the machine's own start code lays before the first print is no part, and no part's rules
//! miss or see it.
//!
//! What such a line may be by itself is for [`profile::prime`]; here it is held against all that is printed later, whose nozzle would
//! scrape it off and carry it along. What the head does above it is for [`super::walk`].

use super::ReplayJob;
use super::evidence::{Checked, Evidence};
use super::report::{FindingPlace, Findings, Rule};
use crate::geom::Bounds;
use crate::geom::convex::{separation, support};
use crate::profile::{self, Prime};
use crate::trace::{Trace, TraceMove, Zone};

/// Holds all filament that is laid before the first slot.
pub(super) fn check(&Evidence { trace, job, .. }: &Evidence<'_>) -> Checked {
    let mut findings = Findings::default();
    let mut primes = Vec::new();
    for m in trace.moves().take_while(|m| trace.state(m).zone == Zone::Start).filter(TraceMove::prints) {
        let at = FindingPlace { line: m.line, slot: None, part: None };
        match profile::prime(&m, trace, job.profile) {
            Ok(prime) => primes.push(prime),
            Err(why) => findings.add(Rule::OutsidePart, at, [0.0; 2], || why),
        }
    }
    primes.iter().filter_map(|prime| touched(prime, trace, job)).for_each(|(prime, [room, least], by)| {
        let at = FindingPlace { line: prime.line, slot: None, part: None };
        findings.add(Rule::OutsidePart, at, [room, least], || {
            format!("the prime line is {room:.2} mm from the print at line {by} (minimum {least:.2} mm); move it in dialect.start")
        });
    });
    findings.into()
}

/// The line of a print that comes nearest to it of those that come too near: how near, how near it may, and where in the file.
fn touched<'a>(prime: &'a Prime, trace: &Trace, job: &ReplayJob<'_>) -> Option<(&'a Prime, [f64; 2], u32)> {
    let table = job.profile.kinematics();
    let (mut pose, mut back) = (None, None);
    let mut nearest: Option<([f64; 2], u32)> = None;
    for m in trace.moves().filter(|m| m.prints() && trace.state(m).print.is_some()) {
        let Some(at) = trace.state(&m).pose() else { continue };
        if pose.replace(at) != Some(at) {
            back = Some(table.forward(at).inverse());
        }
        let (Some(back), Some(ends)) = (&back, m.ends()) else { continue };
        let ends = ends.map(|p| back.point(p.into()).at);
        // As wide as its nozzle's flat end, which goes along it.
        let half = m.width.unwrap_or(job.profile.process.line_width_mm) / 2.0;
        let least = prime.width / 2.0 + half.max(job.profile.tip_radius_mm());
        if !Bounds::of(prime.ends).inflated(least).meets(&Bounds::of(ends)) {
            continue;
        }
        let apart = separation(|along| support(&prime.ends, along) - support(&ends, &-along), least).distance();
        if apart < least && nearest.is_none_or(|([room, _], _)| apart < room) {
            nearest = Some(([apart, least], m.line));
        }
    }
    nearest.map(|(room, line)| (prime, room, line))
}
