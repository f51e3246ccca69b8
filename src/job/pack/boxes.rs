//! Boxes from a text, a line each; a last word `up` says that a box is only turned about Z, `up:yz` that its own y or z is upright.

use super::error::PackError;
use super::limit::Limit;
use super::result::{self, PackResult, UNITS};
use super::{Asked, BadPacking, MOST_PIECES, PackSpace, counted};
use crate::input::Source;
use crate::pack::{Instance, Item, PackGoal, Turns, check, height, pack};
use crate::world::World;

/// A line of the text.
struct Line {
    name: String,
    size: [f64; 3],
    count: usize,
    value: f64,
    up: [bool; 3],
}

/// The word for a box that stays upright; after a colon the axes that may be, if others than z.
const UPRIGHT: &str = "up";
const AXES: &str = "xyz";

/// Without the last word where that says what may be upright, and what it says.
fn upright(said: &str) -> Option<(&str, [bool; 3])> {
    let (numbers, word) = said.rsplit_once([' ', '\t', ',']).unwrap_or(("", said));
    let Some(rest) = word.strip_prefix(UPRIGHT).filter(|_| !numbers.is_empty()) else { return Some((said, [true; 3])) };
    let axes = if rest.is_empty() { "z" } else { rest.strip_prefix(':')? };
    let up = [0, 1, 2].map(|k| axes.contains(&AXES[k..=k]));
    // Each once.
    (axes.len() == up.iter().filter(|&&up| up).count() && !axes.is_empty()).then_some((numbers, up))
}

/// Whether a word between blanks is a number as half the world writes it, `10,5`: here it would be two.
fn has_decimal_comma(word: &str) -> bool {
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    word.split_once(',').is_some_and(|(whole, rest)| digits(whole) && digits(rest))
}

/// `w d h [count [value]] [up]`, mm; empty lines and what follows a `#` say nothing.
fn lines(name: &str, text: &str) -> Result<Vec<Line>, BadPacking> {
    let mut lines = Vec::new();
    for (index, whole) in text.lines().enumerate() {
        let said = whole.split('#').next().unwrap_or_default().trim();
        if said.is_empty() {
            continue;
        }
        let words: Vec<&str> = said.split_whitespace().collect();
        if let Some(word) = words.iter().find(|word| has_decimal_comma(word)).filter(|_| words.len() > 1) {
            return Err(BadPacking::Comma { name: name.to_owned(), line: index + 1, text: (*word).to_owned() });
        }
        let bad = || BadPacking::Line { name: name.to_owned(), line: index + 1, text: said.to_owned() };
        let (said_numbers, up) = upright(said).ok_or_else(bad)?;
        let numbers: Option<Vec<f64>> = said_numbers
            .split([' ', '\t', ','])
            .filter(|word| !word.is_empty())
            .map(|word| word.parse().ok())
            .collect();
        let numbers = numbers.filter(|all| (3..=5).contains(&all.len()) && all.iter().all(|v| v.is_finite()));
        let numbers = numbers.ok_or_else(bad)?;
        let size = [numbers[0], numbers[1], numbers[2]];
        let value = numbers.get(4).copied().unwrap_or_else(|| size.iter().product());
        // Whole micrometres, so that what is packed is what was written.
        let fine = |mm: &f64| (0.001..=1e6).contains(mm) && (mm * UNITS - (mm * UNITS).round()).abs() < 1e-3;
        if !size.iter().all(fine) || value <= 0.0 {
            return Err(bad());
        }
        let place = format!("{name}, line {}", index + 1);
        let count = counted(&place, numbers.get(3).copied().unwrap_or(1.0))?;
        lines.push(Line { name: place, size, count, value, up });
    }
    let pieces = lines.iter().map(|line| line.count).sum();
    match pieces {
        0 => Err(BadPacking::NoBoxes(name.to_owned())),
        1..=MOST_PIECES => Ok(lines),
        _ => Err(BadPacking::TooMany { pieces }),
    }
}

/// Packs the boxes of a text.
pub(super) fn packed(
    source: &Source,
    space: &PackSpace,
    asked: &Asked<'_>,
    stop: &dyn Fn() -> bool,
    limit: &Limit<'_>,
    world: &World<'_>,
) -> Result<PackResult, PackError> {
    let name = source.name().into_owned();
    let lines = lines(&name, &source.text(world)?)?;
    let volumes: Vec<f64> = lines.iter().map(|line| line.size.iter().product()).collect();
    let own: Vec<f64> = lines.iter().map(|line| line.value).collect();
    let values = asked.values(&volumes, &own)?;
    let units = |mm: f64| (mm * UNITS).round() as i64;
    let copies = lines.iter().enumerate().flat_map(|(index, line)| std::iter::repeat_n(index, line.count));
    let of: Vec<usize> = copies.collect();
    let item = |&line: &usize| {
        let Line { size, up, .. } = lines[line];
        Item { size: size.map(units), value: values[line], up }
    };
    let items: Vec<Item> = of.iter().map(item).collect();
    let gap_mm = asked.options.gap_mm.unwrap_or(0.0);
    // One on the other, each as high as it may be turned.
    let highest = |line: &Line| {
        let up = if asked.turns == Turns::Any { line.up } else { [false, false, true] };
        let high = (0..3).filter(|&k| up[k]).map(|k| line.size[k]).fold(0.0, f64::max);
        (high + gap_mm) * line.count as f64
    };
    let units_of = |mm: f64| (mm * UNITS + 1e-3).floor() as i64;
    let fit_in = space.up_to(lines.iter().map(highest).sum()).map(units_of);
    let mut instance = Instance { space: fit_in, gap: units(gap_mm), turns: asked.turns, items };
    let goal = asked.goal;
    let seed = asked.options.seed;
    let answer =
        asked.watched(stop, limit, world, &mut |_| (), |watch| pack(&instance, goal, asked.method, seed, watch));
    let no_fit = |item: usize| {
        let line = &lines[of[item]];
        let (name, turn, up) = (line.name.clone(), asked.turns, line.up);
        BadPacking::NoFit { name, size: line.size, space: space.lengths_mm(), turn, up, proved: true }
    };
    let answer = answer.map_err(|why| asked.unpackable(why, space.height_mm, no_fit))?;
    if goal == PackGoal::Height {
        instance.space[2] = height(&answer.placed);
    }
    check(&instance, &answer.placed, goal != PackGoal::Filling).map_err(BadPacking::from)?;
    let names: Vec<(String, usize)> = lines.iter().map(|line| (line.name.clone(), line.count)).collect();
    Ok(result::of_boxes(&instance, &names, &of, &answer, asked))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_or_refused_by_number() {
        let good =
            lines("b.txt", "# boxes\n1 2 3\n\n4.5,5,6 2  # two\n7\t8 9 3 1.5 up\n1 2 3 up\n1 2 3 up:zx\n").unwrap();
        let told: Vec<_> = good.iter().map(|l| (l.size, l.count, l.value, l.up)).collect();
        let ([any, z], cube) = ([[true; 3], [false, false, true]], [1.0, 2.0, 3.0]);
        let more = [([7.0, 8.0, 9.0], 3, 1.5, z), (cube, 1, 6.0, z), (cube, 1, 6.0, [true, false, true])];
        assert_eq!(told[..2], [(cube, 1, 6.0, any), ([4.5, 5.0, 6.0], 2, 135.0, any)]);
        assert_eq!(told[2..], more);
        for (text, wanted) in [
            ("1 2", "line 1"),
            ("1 2 3\n1 2 x", "line 2"),
            ("1 2 -3", "line 1"),
            ("1 2 3 4 5 6", "line 1"),
            ("1 2 inf", "line 1"),
            ("1 2 3up", "line 1"),
            ("1 2 3 down", "line 1"),
            ("1 2 3 up:", "line 1"),
            ("1 2 3 up:zz", "line 1"),
            ("1 2 3 up:zw", "line 1"),
            ("up", "line 1"),
            ("1 2 up 3", "line 1"),
            ("1 2 3.0001", "line 1"),
            ("1 2 3\n10,5 10 10", "10,5"),
            ("1 2 3 1 0", "line 1"),
            ("1 2 3 0", "the count must be between 1 and 5000, got 0"),
            ("1 2 3 10000", "got 10000"),
            ("1 2 3 1.5", "got 1.5"),
            ("1 2 3 4000\n1 2 3 4000", "8000 pieces"),
            ("# none\n", "no boxes"),
        ] {
            let told = lines("b.txt", text).err().map(|e| e.to_string()).unwrap();
            assert!(told.contains(wanted) && told.contains("b.txt") != wanted.contains("pieces"), "{text}: {told}");
        }
    }
}
