//! Warnings about a model whose file brings thousands of them.

use std::cmp::Reverse;

/// So many are kept.
const MOST: usize = 1000;
/// Kinds of those that are not kept that are told, and that are looked for.
const KINDS: [usize; 2] = [5, 20];

/// Keeps the first, and says how many there were besides.
pub(super) fn keep(warnings: &mut Vec<String>) {
    if warnings.len() > MOST {
        let more = warnings.split_off(MOST);
        warnings.push(not_shown(&more));
    }
}

/// How many there are besides, and how many of each kind, the most frequent first, with one of each.
fn not_shown(more: &[String]) -> String {
    let mut kinds: Vec<(String, usize, &str)> = Vec::new();
    for text in more {
        let kind = kind_of(text);
        match kinds.iter().position(|(known, ..)| *known == kind) {
            Some(at) => kinds[at].1 += 1,
            None if kinds.len() < KINDS[1] => kinds.push((kind, 1, text)),
            None => {}
        }
    }
    kinds.sort_by_key(|(_, count, _)| Reverse(*count));
    kinds.truncate(KINDS[0]);
    let mut told: Vec<String> = kinds.iter().map(|(_, count, text)| format!("{count} such as \"{text}\"")).collect();
    let others = more.len() - kinds.iter().map(|(_, count, _)| count).sum::<usize>();
    if others > 0 {
        told.push(format!("{others} others"));
    }
    format!("{} more warnings are not shown: {}", more.len(), told.join(", "))
}

/// A sentence without its numbers, and without what stands in quotes or brackets.
fn kind_of(text: &str) -> String {
    let (mut depth, mut quoted) = (0, false);
    let is_told = |c: &char| {
        match c {
            '"' => quoted = !quoted,
            '(' => depth += 1,
            ')' if depth > 0 => depth -= 1,
            _ => {}
        }
        !quoted && depth == 0 && !c.is_ascii_digit()
    };
    text.chars().filter(is_told).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_kept_is_counted_by_kind() {
        let text = |i: usize| match i {
            i if i % 10 == 3 => format!("part {i} (\"knob {i} (2)\") hangs in the air"),
            i if i % 100 == 7 => format!("{:?} is called twice", format!("x{i}")),
            i => format!("removed a shell of {i} facets"),
        };
        let mut few: Vec<String> = (0..MOST).map(text).collect();
        keep(&mut few);
        assert_eq!(few.len(), MOST);
        let mut many: Vec<String> = (0..5000).map(text).collect();
        keep(&mut many);
        assert_eq!(many[..MOST], few);
        let last = &many[MOST..];
        let counted = ["4000 more", "3560 such as \"removed", "400 such as \"part", "40 such as \"\"x"];
        assert!(last.len() == 1 && counted.iter().all(|part| last[0].contains(part)), "{last:?}");
    }

    #[test]
    fn kinds_without_end_are_told_as_others() {
        let word = |i: usize| "ab".chars().cycle().take(i % 300 + 1).collect::<String>();
        let mut many: Vec<String> = (0..3000).map(word).collect();
        keep(&mut many);
        let last = many.last().unwrap();
        assert!(many.len() == MOST + 1 && last.contains("2000 more") && last.contains("others"), "{last}");
    }
}
