//! Bytes as the journal of an interrupted print, and all that resuming makes of it.

use std::sync::Arc;
use std::time::Duration;

use trunnion::link::{JournalSummary, Reentry, Sender};

use super::choice;
use super::print::{Print, prints};

/// The first byte chooses the machine and whether the host has booted since, the second a line to go on from.
pub(super) fn journal(data: &[u8]) {
    let Some((how, rest)) = choice(data) else { return };
    let Some((from, bytes)) = choice(rest) else { return };
    let text = String::from_utf8_lossy(bytes);
    let Ok(standing) = JournalSummary::parse(&text) else { return };
    let Print { program, settings, .. } = &prints()[usize::from(how / 2) % prints().len()];
    let same_boot = how % 2 == 0;
    let _ =
        (standing.began(), standing.counts(), standing.last(program.len(), 32), standing.next_block(standing.proven));
    let _ = (standing.block_at(standing.proven), standing.block_at(standing.last(program.len(), 32)));
    // As whoever resumes does first.
    if standing.check(program.len()).is_err() {
        return;
    }
    let doubtful = standing.doubtful(program, settings, same_boot);
    assert!(doubtful.start <= doubtful.end && doubtful.end <= program.len(), "{doubtful:?} of {}", program.len());
    if let Some(places) = standing.stands_at(program, settings, same_boot) {
        assert!(places.iter().all(|place| place.block <= program.len()), "a place behind the end");
        assert!(places.iter().flat_map(|place| &place.words).all(|(_, v)| v.is_finite()), "a place that is none");
        ends(Sender::locating(Arc::clone(program), settings.clone(), places, standing.paused.is_some()));
    }
    if standing.counts() {
        ends(Sender::resuming(Arc::clone(program), settings.clone(), &standing));
    }
    let from = (from > 0).then(|| u32::from(from));
    let Ok(doubtful) = Reentry::doubt(program, settings, &standing, same_boot, from) else { return };
    let Ok(choices) = Reentry::choices(program, &doubtful) else { return };
    assert!(!choices.is_empty() && choices.is_sorted(), "{choices:?}");
    let unproved = Reentry::unproved(program, &doubtful, &choices);
    for block in [choices[0], unproved, choices[choices.len() - 1]] {
        assert!((doubtful.start..=doubtful.end).contains(&block), "{block} is not in {doubtful:?}");
        let Ok(entry) = Reentry::at(program, settings, &doubtful, block) else { continue };
        assert!(entry.missing_mm.is_finite() && entry.twice_mm.is_finite(), "{entry:?}");
        ends(Sender::reentering(Arc::clone(program), settings.clone(), &entry.lines, entry.block));
    }
}

/// Whatever it resumes from, a sender that hears nothing but `ok` goes on without a panic.
fn ends(mut sender: Sender) {
    let mut now = Duration::ZERO;
    for _ in 0..60 {
        sender.poll(now);
        while sender.next_event().is_some() {}
        assert!(sender.pending().len() < 16_384, "{} bytes wait for the port", sender.pending().len());
        sender.took(usize::MAX / 2);
        now += Duration::from_millis(400);
        sender.receive(now, b"ok\n");
        if sender.outcome().is_some() {
            break;
        }
    }
}
