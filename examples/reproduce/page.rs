//! The page: every table and figure with what is printed, what this run makes of it, and why the two differ.

use std::fmt::Write;

use super::item::{Document, Item, Kind, Row, State, figures};

const STYLE: &str = include_str!("page.css");

/// The whole page; it asks for nothing from elsewhere.
pub(crate) fn page(documents: &[Document]) -> String {
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>Five documents, remade</title>\n<style>{STYLE}</style></head><body>\n<main>\n<h1>Five documents, remade</h1>\n\
         <p>Each table and figure of the documents whose methods trunnion implements. <b>Printed</b> is what the document says, or \
         what a definition, an equation or another method lets expect where it prints nothing; <b>ours</b> is what the library computed for this page. A tick: as near as expected. A dash: the two cannot be compared, and the \
         last column says why.</p>\n"
    );
    overview(&mut out, documents);
    for document in documents {
        let _ = writeln!(
            out,
            "<section id=\"{key}\"><h2>{authors} ({year})</h2><p class=\"title\">{title}</p>",
            key = document.key,
            authors = escaped(document.authors),
            year = document.year,
            title = escaped(document.title)
        );
        document.items.iter().filter(|item| !item.is_left()).for_each(|one| item(&mut out, document.key, one));
        left(&mut out, document);
        out.push_str("</section>\n");
    }
    out.push_str("</main></body></html>\n");
    out
}

/// How much of each document is here.
fn overview(out: &mut String, documents: &[Document]) {
    out.push_str("<table class=\"overview\"><thead><tr><th>document</th><th>tables</th><th>figures</th><th>values compared</th><th>as near as expected</th></tr></thead><tbody>\n");
    let mut all = [0; 6];
    for document in documents {
        let [tables, tables_made] = document.count(Kind::Table);
        let [drawn, drawn_made] = document.count(Kind::Figure);
        let judged: Vec<bool> = document.items.iter().flat_map(|item| &item.rows).filter_map(Row::holds).collect();
        let near = judged.iter().filter(|holds| **holds).count();
        for (sum, one) in all.iter_mut().zip([tables_made, tables, drawn_made, drawn, judged.len(), near]) {
            *sum += one;
        }
        let _ = writeln!(
            out,
            "<tr><td><a href=\"#{}\">{} ({})</a></td><td>{tables_made} of {tables}</td><td>{drawn_made} of {drawn}</td><td>{}</td><td>{near}</td></tr>",
            document.key,
            escaped(document.authors),
            document.year,
            judged.len()
        );
    }
    let _ = writeln!(
        out,
        "</tbody><tfoot><tr><td>all</td><td>{} of {}</td><td>{} of {}</td><td>{}</td><td>{}</td></tr></tfoot></table>",
        all[0], all[1], all[2], all[3], all[4], all[5]
    );
}

fn item(out: &mut String, key: &str, item: &Item) {
    let _ = writeln!(
        out,
        "<article id=\"{}\"><h3>{}</h3><p class=\"caption\">{}</p>",
        anchor(key, item),
        escaped(&item.name()),
        escaped(item.caption)
    );
    if let State::StandIn(instead) = &item.state {
        let _ = writeln!(out, "<p class=\"instead\">Stand-in: {}</p>", escaped(instead));
    }
    out.push_str("<div class=\"body\">");
    if !item.pictures.is_empty() {
        out.push_str("<div class=\"pictures\">");
        for (below, svg) in &item.pictures {
            let _ = write!(out, "<figure>{svg}<figcaption>{}</figcaption></figure>", escaped(below));
        }
        out.push_str("</div>\n");
    }
    if !item.rows.is_empty() {
        out.push_str("<table><thead><tr><th></th><th>printed or expected</th><th>ours</th><th>deviation</th><th></th><th>why</th></tr></thead><tbody>\n");
        item.rows.iter().for_each(|one| row(out, one));
        out.push_str("</tbody></table>\n");
    }
    out.push_str("</div>\n");
    for note in &item.notes {
        let _ = writeln!(out, "<p class=\"note\">{}</p>", escaped(note));
    }
    out.push_str("</article>\n");
}

fn row(out: &mut String, row: &Row) {
    let deviation = match row.deviation {
        None => String::new(),
        Some(_) if row.unit == "words" => String::new(),
        Some(off) => match figures(rounded(off)).as_str() {
            "0" => "0".to_owned(),
            words => format!("{words} {}", row.unit),
        },
    };
    let (class, sign) = match row.holds() {
        Some(true) => ("yes", "✓"),
        Some(false) => ("no", "✗"),
        None => ("open", "–"),
    };
    let [what, printed, ours, reason] = [&row.what, &row.printed, &row.ours, &row.reason].map(|text| escaped(text));
    let _ = writeln!(
        out,
        "<tr><th>{what}</th><td>{printed}</td><td>{ours}</td><td>{deviation}</td><td class=\"{class}\">{sign}</td><td class=\"why\">{reason}</td></tr>"
    );
}

/// What is not here, and why.
fn left(out: &mut String, document: &Document) {
    let all: Vec<(&Item, &String)> = document
        .items
        .iter()
        .filter_map(|item| if let State::Left(why) = &item.state { Some((item, why)) } else { None })
        .collect();
    if all.is_empty() {
        return;
    }
    out.push_str("<h3>Not remade</h3><table class=\"left\"><tbody>\n");
    for (item, why) in all {
        let _ = writeln!(
            out,
            "<tr id=\"{}\"><th>{}</th><td>{}</td><td class=\"why\">{}</td></tr>",
            anchor(document.key, item),
            escaped(&item.name()),
            escaped(item.caption),
            escaped(why)
        );
    }
    out.push_str("</tbody></table>\n");
}

fn anchor(key: &str, item: &Item) -> String {
    format!("{key}-{}", item.name().to_lowercase().replace([' ', '.'], "-"))
}

/// Three figures are enough for a deviation.
fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let unit = 10f64.powf(value.abs().log10().floor() - 2.0);
    let plain = (value / unit).round() * unit;
    if plain.abs() < 1e-9 { 0.0 } else { plain }
}

pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
