//! The page: one file of HTML with its style, its program, what it shows and nothing from elsewhere.
//!
//! Names and sentences come as one JSON document in which no `<` is left, so that nothing in it can end its element; the program
//! puts them on the page as text, never as HTML. The page's own policy lets only this program run (by its hash) and fetches
//! nothing at all.

use sha2::{Digest, Sha256};

use super::pack::push_base64;

const FRAME: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/style.css");
/// In the order in which they need each other.
const SCRIPTS: [&str; 11] = [
    include_str!("page/decode.js"),
    include_str!("page/matrix.js"),
    include_str!("page/replay.js"),
    include_str!("page/colours.js"),
    include_str!("page/beads.js"),
    include_str!("page/machine.js"),
    include_str!("page/draw.js"),
    include_str!("page/panels.js"),
    include_str!("page/pointer.js"),
    include_str!("page/beside.js"),
    include_str!("page/main.js"),
];

/// What draws on the page, as a module for other pages.
pub const RENDERER: &str = concat!(
    include_str!("page/decode.js"),
    include_str!("page/matrix.js"),
    include_str!("page/colours.js"),
    include_str!("page/beads.js"),
    include_str!("page/machine.js"),
    include_str!("page/draw.js"),
    "export { Camera, Drawing, IDENTITY, KINDS, axes, boxLines, cross, dot, inverted, moved, plus, readShapes, shifted, solid, tableAt, tableGrid, times, turned };\n",
);

/// The page that shows `packed` (see [`super::Scene::packed`]), with the document that says what is in it.
///
/// The program reads the document's keys as `document::viewed` writes them.
pub fn page(facts: &str, packed: &[u8]) -> String {
    let (script, hash) = script();
    let mut out = String::with_capacity(script.len() + STYLE.len() + facts.len() + packed.len() * 4 / 3 + 8192);
    // Pieces are put between the marks, not for them: what they hold may look like a mark.
    for (i, piece) in FRAME.split("@@").enumerate() {
        match (i % 2, piece) {
            (0, text) => out.push_str(text),
            (_, "hash") => out.push_str(&hash),
            (_, "style") => out.push_str(STYLE),
            (_, "facts") => out.push_str(&facts.replace('<', "\\u003c")),
            (_, "packed") => push_base64(packed, &mut out),
            (_, "script") => out.push_str(&script),
            (_, other) => unreachable!("no piece {other} of the page"),
        }
    }
    out
}

/// The program, and by what a policy knows it.
fn script() -> (String, String) {
    let script = format!("\n'use strict';\n{}", SCRIPTS.concat());
    let mut hash = String::new();
    push_base64(&Sha256::digest(script.as_bytes()), &mut hash);
    (script, hash)
}

/// Two pages ([`page`]) side by side, each with its name; their cameras go together.
///
/// Each stays a page of its own, within this one's policy, which lets the same program run and nothing else.
pub fn pair(two: [(String, String); 2]) -> String {
    let names: Vec<String> = two.iter().map(|(name, _)| escaped(name)).collect();
    let mut out = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'sha256-{}'; style-src 'unsafe-inline'\">\n\
         <meta name=\"referrer\" content=\"no-referrer\">\n<title>{} beside {} - trunnion preview</title>\n\
         <style>\nhtml, body {{ margin: 0; height: 100%; }}\nbody {{ display: flex; gap: 3px; background: #5b6775; }}\n\
         iframe {{ flex: 1; min-width: 0; border: 0; background: #f3f4f6; }}\n</style>\n</head>\n<body>\n",
        script().1,
        names[0],
        names[1],
    );
    for ((_, page), name) in two.iter().zip(&names) {
        out.push_str("<iframe title=\"");
        out.push_str(name);
        out.push_str("\" srcdoc=\"");
        out.push_str(&escaped(page));
        out.push_str("\"></iframe>\n");
    }
    out.push_str("</body>\n</html>\n");
    out
}

/// Text in an attribute or an element.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('"', "&quot;").replace('<', "&lt;")
}
