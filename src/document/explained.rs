//! `trunnion explain`: what stands behind a code, out of the list of all messages.

use serde_json::{Value, json};

use crate::spelling::nearest;

/// The list, which a test makes of the sources: a heading a code, what it means, and what is said.
const MESSAGES: &str = include_str!("../../docs/reference/messages.md");

/// An entry: its code, what it means, and what is said, a sentence with the facts' names in braces.
struct Entry<'a> {
    code: &'a str,
    meaning: String,
    says: Vec<&'a str>,
}

fn entries() -> impl Iterator<Item = Entry<'static>> {
    MESSAGES.split("\n## ").skip(1).map(|section| {
        let mut lines = section.lines();
        let code = lines.next().unwrap_or_default();
        let (says, meaning): (Vec<&str>, Vec<&str>) =
            lines.filter(|line| !line.is_empty()).partition(|line| line.starts_with("> "));
        Entry { code, meaning: meaning.join(" "), says: says.iter().map(|line| &line[2..]).collect() }
    })
}

/// What a code means.
///
/// # Errors
///
/// The nearest code where there is none of that name.
pub fn explained(code: &str) -> Result<Value, &'static str> {
    let entry = entries().find(|entry| entry.code == code);
    let entry = entry.ok_or_else(|| nearest(code, entries().map(|entry| entry.code)).map_or("", |(_, near)| near))?;
    Ok(json!({"code": entry.code, "meaning": entry.meaning, "says": entry.says}))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_of_the_list_is_explained_and_none_else() {
        let all: Vec<&str> = entries().map(|entry| entry.code).collect();
        assert!(all.len() > 250);
        for code in &all {
            let entry = explained(code).unwrap();
            assert!(entry["meaning"].as_str().unwrap().len() > 3, "{code}");
        }
        assert_eq!(explained("mesh/opem").unwrap_err(), "mesh/open");
    }
}
