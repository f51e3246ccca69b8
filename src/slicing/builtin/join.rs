//! Stretches of line whose ends meet become one.

use super::narrow::Stretch;
use super::thickness::{Vec2, length, plus, sub};

/// How far apart two ends may lie, mm.
const REACH_MM: f64 = 0.35;

/// The stretches, joined at their ends, the nearest pair first; ends that meet their own other end close. Nothing is laid where the
/// middle between two ends is not `inside`.
pub(super) fn joined(mut stretches: Vec<Stretch>, inside: impl Fn(Vec2) -> bool) -> Vec<Stretch> {
    stretches.retain(|stretch| !stretch.points.is_empty());
    let partner = partners(&stretches, inside);
    let mut used = vec![false; stretches.len()];
    let mut found = Vec::new();
    // Lines with a free end begin there; what is left are rings.
    let begins = (0..2 * stretches.len()).filter(|&end| partner[end].is_none());
    for end in begins.chain(0..2 * stretches.len()) {
        if !used[end / 2] {
            found.push(followed(&stretches, &partner, end, &mut used));
        }
    }
    found
}

/// For each end, `2 i` for the first point of stretch `i` and `2 i + 1` for its last, the one it is joined to.
fn partners(stretches: &[Stretch], inside: impl Fn(Vec2) -> bool) -> Vec<Option<usize>> {
    let at = |end: usize| {
        let points = &stretches[end / 2].points;
        if end.is_multiple_of(2) { points[0] } else { points[points.len() - 1] }
    };
    let mut ends: Vec<usize> = (0..2 * stretches.len()).filter(|end| !stretches[end / 2].closed).collect();
    ends.sort_by(|a, b| at(*a)[0].total_cmp(&at(*b)[0]).then(a.cmp(b)));
    let mut pairs = Vec::new();
    for (i, &one) in ends.iter().enumerate() {
        for &other in ends[i + 1..].iter().take_while(|other| at(**other)[0] - at(one)[0] <= REACH_MM) {
            let far = length(sub(at(one), at(other)));
            let own = one / 2 == other / 2;
            // A line does not close over its own length.
            if far <= REACH_MM && (!own || stretches[one / 2].length() > 4.0 * REACH_MM) {
                pairs.push((far, one.min(other), one.max(other)));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut partner = vec![None; 2 * stretches.len()];
    for (_, one, other) in pairs {
        // Two short lines that meet at both ends are no ring.
        let twice = partner[one ^ 1].is_some_and(|end: usize| end / 2 == other / 2) && one / 2 != other / 2;
        let short = |end: usize| stretches[end / 2].length() < 2.0 * REACH_MM;
        if twice && (short(one) || short(other)) {
            continue;
        }
        let middle = plus(at(one), sub(at(other), at(one)), 0.5);
        if partner[one].is_none() && partner[other].is_none() && inside(middle) {
            (partner[one], partner[other]) = (Some(other), Some(one));
        }
    }
    partner
}

/// The line that begins at `end`.
fn followed(stretches: &[Stretch], partner: &[Option<usize>], end: usize, used: &mut [bool]) -> Stretch {
    let mut line = Stretch { closed: stretches[end / 2].closed, ..Stretch::default() };
    let mut at = end;
    loop {
        let stretch = &stretches[at / 2];
        used[at / 2] = true;
        let ordered = stretch.points.iter().zip(&stretch.widths);
        if at.is_multiple_of(2) {
            line.take(ordered)
        } else {
            line.take(ordered.rev())
        }
        match partner[at ^ 1] {
            Some(next) if next == end => {
                line.closed = true;
                return line;
            }
            Some(next) if !used[next / 2] => at = next,
            _ => return line,
        }
    }
}

impl Stretch {
    fn take<'a>(&mut self, points: impl Iterator<Item = (&'a [f64; 2], &'a f64)>) {
        for (point, width) in points {
            if self.points.last() != Some(point) {
                self.points.push(*point);
                self.widths.push(*width);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stretch(points: &[[f64; 2]]) -> Stretch {
        Stretch { points: points.to_vec(), widths: vec![0.4; points.len()], closed: false }
    }

    #[test]
    fn ends_that_meet_are_joined_and_rings_close() {
        let lines = vec![
            stretch(&[[0.0, 0.0], [5.0, 0.0]]),
            stretch(&[[5.1, 5.0], [5.1, 0.1]]),
            stretch(&[[20.0, 0.0], [25.0, 0.0]]),
        ];
        let apart = joined(lines.clone(), |_| false);
        assert_eq!(apart.len(), 3, "nothing is laid across what is outside");
        let lines = joined(lines, |_| true);
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0].points, [[0.0, 0.0], [5.0, 0.0], [5.1, 0.1], [5.1, 5.0]]);
        assert!(!lines[0].closed && lines[1].points.len() == 2);
        let ring =
            joined(vec![stretch(&[[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]]), stretch(&[[5.0, 5.2], [0.0, 0.2]])], |_| true);
        assert!(ring.len() == 1 && ring[0].closed && ring[0].points.len() == 5, "{ring:?}");
    }
}
