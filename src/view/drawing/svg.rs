//! A drawing as SVG 1.1: numbers to a tenth of a unit, so that a file is small and the same on every machine.

use std::fmt::Write;

use super::{Anchor, Colour, Drawing, DrawnMark};

pub(super) fn written(drawing: &Drawing) -> String {
    let [width, height] = drawing.size.map(tenth);
    let title = escaped(&drawing.title);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" font-family=\"sans-serif\">\n\
         <title>{title}</title>\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    drawing.marks.iter().for_each(|mark| push(&mut out, mark));
    out.push_str("</svg>\n");
    out
}

/// To a tenth, without a zero's sign.
fn tenth(v: f64) -> f64 {
    (v * 10.0).round() / 10.0 + 0.0
}

fn hex([r, g, b]: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Text between tags or in an attribute. What XML 1.0 cannot hold at all is left out.
fn escaped(text: &str) -> String {
    let kept = text.chars().filter(|c| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}'));
    kept.fold(String::new(), |mut out, c| {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
        out
    })
}

/// Corners as a path, each by its way from the one before; those that fall on that one are left out.
fn path(points: &[[f64; 2]], out: &mut String) {
    let mut last: Option<[i64; 2]> = None;
    for point in points {
        // In tenths, so that ways add up to places.
        let at = point.map(|v| (v * 10.0).round() as i64);
        let short = |v: i64| v as f64 / 10.0;
        let _ = match last {
            None => write!(out, "M{} {}l", short(at[0]), short(at[1])),
            Some(last) if last == at => Ok(()),
            Some(last) => write!(out, "{} {} ", short(at[0] - last[0]), short(at[1] - last[1])),
        };
        last = Some(at);
    }
    while out.ends_with([' ', 'l']) {
        out.pop();
    }
}

fn push(out: &mut String, mark: &DrawnMark) {
    match mark {
        DrawnMark::Area { rings, fill, opacity } => {
            let mut all = String::new();
            for ring in rings {
                path(ring, &mut all);
                all.push('z');
            }
            let fill = hex(*fill);
            // Neighbours meet along a line; a thin one of their own colour keeps the paper from shining through.
            let seam = if *opacity < 1.0 {
                format!(" fill-opacity=\"{opacity}\"")
            } else {
                format!(" stroke=\"{fill}\" stroke-width=\"0.3\"")
            };
            let _ = writeln!(out, "<path d=\"{all}\" fill=\"{fill}\" fill-rule=\"evenodd\"{seam}/>");
        }
        DrawnMark::Lines { lines, width, colour } => {
            let mut all = String::new();
            lines.iter().for_each(|line| path(line, &mut all));
            let _ = writeln!(
                out,
                "<path d=\"{all}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" stroke-linecap=\"round\" stroke-linejoin=\"round\"/>",
                hex(*colour)
            );
        }
        DrawnMark::Text { at, size, anchor, colour, text, halo } => {
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let halo = if *halo {
                " stroke=\"#ffffff\" stroke-width=\"3\" stroke-linejoin=\"round\" paint-order=\"stroke\""
            } else {
                ""
            };
            let _ = writeln!(
                out,
                "<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"{halo}>{}</text>",
                tenth(at[0]),
                tenth(at[1]),
                tenth(*size),
                hex(*colour),
                escaped(text)
            );
        }
    }
}
