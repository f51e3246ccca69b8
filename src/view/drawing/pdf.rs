//! A drawing as PDF 1.4 (ISO 32000-1 has all that is used here): one page, Helvetica as every reader has it, the page's contents
//! deflated. A unit is 0.75 points.

use std::fmt::Write as _;
use std::io::Write as _;

use flate2::{Compression, write::ZlibEncoder};

use super::{Anchor, Colour, Drawing, DrawnMark, width_of};

/// Points in a unit.
const POINTS: f64 = 0.75;

pub(super) fn written(drawing: &Drawing) -> Vec<u8> {
    let [width, height] = drawing.size;
    let mut page = format!("{POINTS} 0 0 {POINTS} 0 0 cm 1 J 1 j\n1 1 1 rg 0 0 {width:.2} {height:.2} re f\n");
    let mut opacities: Vec<f64> = Vec::new();
    for mark in &drawing.marks {
        push(&mut page, mark, height, &mut opacities);
    }
    let states = opacities.iter().enumerate().fold(String::new(), |mut all, (i, opacity)| {
        let _ = write!(all, "/O{i} << /ca {opacity} >> ");
        all
    });
    let contents = deflated(page.as_bytes());
    let mut file = File::new();
    file.object(b"<< /Type /Catalog /Pages 2 0 R >>");
    file.object(b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>");
    let box_of_page = format!("[0 0 {:.2} {:.2}]", width * POINTS, height * POINTS);
    file.object(
        format!("<< /Type /Page /Parent 2 0 R /MediaBox {box_of_page} /Contents 4 0 R /Resources << /Font << /F 5 0 R >> /ExtGState << {states}>> >> >>")
            .as_bytes(),
    );
    let mut stream = format!("<< /Length {} /Filter /FlateDecode >>\nstream\n", contents.len()).into_bytes();
    stream.extend_from_slice(&contents);
    stream.extend_from_slice(b"\nendstream");
    file.object(&stream);
    file.object(b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>");
    file.object(format!("<< /Title <{}> >>", hex(&drawing.title)).as_bytes());
    file.finish()
}

/// The file with the places of its objects.
struct File {
    bytes: Vec<u8>,
    places: Vec<usize>,
}

impl File {
    fn new() -> Self {
        // Four bytes beyond ASCII say that this is no text.
        Self { bytes: b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n".to_vec(), places: Vec::new() }
    }

    fn object(&mut self, content: &[u8]) {
        self.places.push(self.bytes.len());
        self.bytes.extend_from_slice(format!("{} 0 obj\n", self.places.len()).as_bytes());
        self.bytes.extend_from_slice(content);
        self.bytes.extend_from_slice(b"\nendobj\n");
    }

    /// The table of places; the first object is the catalogue, the last one says what the file is.
    fn finish(mut self) -> Vec<u8> {
        let (table, count) = (self.bytes.len(), self.places.len());
        let mut end = format!("xref\n0 {}\n0000000000 65535 f \n", count + 1);
        self.places.iter().for_each(|place| {
            let _ = writeln!(end, "{place:010} 00000 n ");
        });
        let _ = write!(
            end,
            "trailer\n<< /Size {} /Root 1 0 R /Info {count} 0 R >>\nstartxref\n{table}\n%%EOF\n",
            count + 1
        );
        self.bytes.extend_from_slice(end.as_bytes());
        self.bytes
    }
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(6));
    // A vector takes whatever is written to it.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// A string in hexadecimal, in the letters of Windows-1252, which up to 0xff are those of Latin-1; others become a question mark.
fn hex(text: &str) -> String {
    let letter = |c: char| match c {
        ' '..='~' | '\u{a0}'..='\u{ff}' => u32::from(c),
        _ => u32::from('?'),
    };
    text.chars().map(|c| format!("{:02x}", letter(c))).collect()
}

fn rgb([r, g, b]: Colour) -> String {
    let share = |v: u8| f64::from(v) / 255.0;
    format!("{:.3} {:.3} {:.3}", share(r), share(g), share(b))
}

fn path(page: &mut String, points: &[[f64; 2]], height: f64) {
    for (i, [x, y]) in points.iter().enumerate() {
        let _ = write!(page, "{x:.2} {:.2} {} ", height - y, if i == 0 { 'm' } else { 'l' });
    }
}

fn push(page: &mut String, mark: &DrawnMark, height: f64, opacities: &mut Vec<f64>) {
    match mark {
        DrawnMark::Area { rings, fill, opacity } => {
            if *opacity < 1.0 {
                let known = opacities.iter().position(|known| known == opacity).unwrap_or_else(|| {
                    opacities.push(*opacity);
                    opacities.len() - 1
                });
                let _ = write!(page, "q /O{known} gs ");
            }
            let _ = write!(page, "{0} rg {0} RG 0.3 w ", rgb(*fill));
            for ring in rings {
                path(page, ring, height);
                page.push_str("h ");
            }
            page.push_str(if *opacity < 1.0 { "f* Q\n" } else { "B*\n" });
        }
        DrawnMark::Lines { lines, width, colour } => {
            let _ = write!(page, "{} RG {width} w ", rgb(*colour));
            lines.iter().for_each(|line| path(page, line, height));
            page.push_str("S\n");
        }
        DrawnMark::Text { at: [x, y], size, anchor, colour, text, halo } => {
            let before = match anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5,
                Anchor::End => 1.0,
            };
            // PDF's words are placed by their beginning.
            let from = x - before * width_of(text, *size) * HELVETICA;
            let letters = hex(text);
            let show =
                |mode: &str| format!("BT /F {size:.2} Tf {mode} {from:.2} {:.2} Td <{letters}> Tj ET\n", height - y);
            if *halo {
                let _ = write!(page, "1 1 1 RG 3 w {}", show("1 Tr"));
            }
            let _ = write!(page, "{} rg {}", rgb(*colour), show("0 Tr"));
        }
    }
}

/// Helvetica is so much narrower than the mean letter that a drawing counts with.
const HELVETICA: f64 = 0.92;
