//! Stretches of line whose ends meet become one.

use super::narrow::Stretch;
use super::thickness::{Vec2, dot, length, plus, sub};

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

/// Shorter legs are not looked at where a line goes back over itself, mm.
const BACK_MM: f64 = 0.3;
/// Two legs along one line, one there and one back, by the cosine of their angle.
const BACK: f64 = -0.9999;

/// The line without what would be laid twice: where it goes back over itself it ends, and goes on as another one behind that.
pub(super) fn unfolded(mut line: Stretch) -> Vec<Stretch> {
    let leg = |points: &[Vec2], k: usize| sub(points[k + 1], points[k]);
    let turns_back = |points: &[Vec2], k: usize| {
        let [there, back] = [leg(points, k), leg(points, k + 1)];
        let (far, near) = (length(there), length(back));
        far > BACK_MM && near > BACK_MM && dot(there, back) < BACK * far * near
    };
    let (mut all, mut at) = (Vec::new(), 0);
    while at + 2 < line.points.len() {
        if !turns_back(&line.points, at) {
            at += 1;
        } else if at + 3 < line.points.len()
            && turns_back(&line.points, at + 1)
            && length(sub(line.points[at + 2], line.points[at])) < BACK_MM
        {
            // There, back, and there again: once is enough.
            line.points.drain(at + 1..at + 3);
            line.widths.drain(at + 1..at + 3);
        } else {
            let behind =
                Stretch { points: line.points.split_off(at + 2), widths: line.widths.split_off(at + 2), closed: false };
            let before = std::mem::replace(&mut line, behind);
            if before.closed {
                // Opened where it turns back.
                line.points.extend(before.points);
                line.widths.extend(before.widths);
            } else {
                all.push(before);
            }
            at = 0;
        }
    }
    all.push(line);
    all
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

    #[test]
    fn a_line_that_goes_back_over_itself_is_laid_once() {
        // Down, up and down again, as two sides of a slot were joined: once.
        let thrice = stretch(&[[8.0, 5.0], [0.0, 5.0], [0.0, 0.0], [0.0, 5.0], [0.0, 0.0], [-0.2, -0.4]]);
        let once = unfolded(thrice);
        assert_eq!(once.len(), 1);
        assert_eq!(once[0].points, [[8.0, 5.0], [0.0, 5.0], [0.0, 0.0], [-0.2, -0.4]]);
        assert_eq!(once[0].widths.len(), 4);
        // Into a dead end and out: to its end, and on from where it came from.
        let dead_end = stretch(&[[0.0, 0.0], [5.0, 0.0], [2.0, 0.0], [2.0, 4.0]]);
        let parts: Vec<Vec<Vec2>> = unfolded(dead_end).into_iter().map(|line| line.points).collect();
        assert_eq!(parts, [vec![[0.0, 0.0], [5.0, 0.0]], vec![[2.0, 0.0], [2.0, 4.0]]]);
        // A ring is opened where it does so; one that does not stays closed.
        let corners = [[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [5.0, 0.5], [5.0, 9.0], [0.0, 9.0]];
        let ring = unfolded(Stretch { closed: true, ..stretch(&corners) });
        assert_eq!(ring.len(), 1, "{ring:?}");
        assert!(!ring[0].closed && ring[0].length() < 5.0 + 3.0 + 8.5 + 5.0 + 9.0 + 0.1, "{ring:?}");
        let square = Stretch { closed: true, ..stretch(&[[0.0, 0.0], [5.0, 0.0], [5.0, 5.0], [0.0, 5.0]]) };
        assert!(unfolded(square)[0].closed);
    }
}
