//! Boxes from a text, a line each.

use super::error::PackError;
use super::result::{self, PackResult, UNITS};
use super::{Asked, BadPacking, MOST_PIECES, counted};
use crate::input::Source;
use crate::pack::{Instance, Item, PackGoal, check, pack};
use crate::world::World;

/// A line of the text.
struct Line {
    name: String,
    size: [f64; 3],
    count: usize,
    value: f64,
}

/// Whether a word between blanks is a number as half the world writes it, `10,5`: here it would be two.
fn has_decimal_comma(word: &str) -> bool {
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    word.split_once(',').is_some_and(|(whole, rest)| digits(whole) && digits(rest))
}

/// `w d h [count [value]]`, mm; empty lines and what follows a `#` say nothing.
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
        let numbers: Option<Vec<f64>> =
            said.split([' ', '\t', ',']).filter(|word| !word.is_empty()).map(|word| word.parse().ok()).collect();
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
        lines.push(Line { name: place, size, count, value });
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
    space_mm: [f64; 3],
    asked: &Asked<'_>,
    stop: &dyn Fn() -> bool,
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
    let items = of.iter().map(|&line| Item { size: lines[line].size.map(units), value: values[line] }).collect();
    let space = space_mm.map(|mm| (mm * UNITS + 1e-3).floor() as i64);
    let gap = units(asked.options.gap_mm.unwrap_or(0.0));
    let instance = Instance { space, gap, turns: asked.turns, items };
    let goal = asked.goal();
    let seed = asked.options.seed;
    let answer = asked.watched(stop, world, |watch| pack(&instance, goal, asked.method, seed, watch));
    let no_fit = |item: usize| {
        let line = &lines[of[item]];
        BadPacking::NoFit { name: line.name.clone(), size: line.size, space: space_mm, turn: asked.turns, proved: true }
    };
    let answer = answer.map_err(|why| asked.unpackable(why, no_fit))?;
    check(&instance, &answer.placed, goal == PackGoal::Runs).map_err(BadPacking::from)?;
    let names: Vec<(String, usize)> = lines.iter().map(|line| (line.name.clone(), line.count)).collect();
    Ok(result::of_boxes(&instance, &names, &of, &answer, space_mm, asked))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_or_refused_by_number() {
        let good = lines("b.txt", "# boxes\n1 2 3\n\n4.5,5,6 2  # two\n7\t8 9 3 1.5\n").unwrap();
        let told: Vec<_> = good.iter().map(|l| (l.size, l.count, l.value)).collect();
        assert_eq!(told, [([1.0, 2.0, 3.0], 1, 6.0), ([4.5, 5.0, 6.0], 2, 135.0), ([7.0, 8.0, 9.0], 3, 1.5)]);
        for (text, wanted) in [
            ("1 2", "line 1"),
            ("1 2 3\n1 2 x", "line 2"),
            ("1 2 -3", "line 1"),
            ("1 2 3 4 5 6", "line 1"),
            ("1 2 inf", "line 1"),
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
