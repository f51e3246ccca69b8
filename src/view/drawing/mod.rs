//! A drawing of areas, lines and words, and the three files that it can be: SVG, PDF, PNG.
//!
//! Units: one is a pixel of CSS (1/96 inch), x to the right and y down from the upper left corner. The three writers draw the same
//! marks in the same order, so that a picture looks alike whatever its name ends with.

mod font;
mod pdf;
mod png;
mod svg;

pub use self::png::Picture;
pub(super) use self::png::{Alpha, encoded};

/// Red, green, blue.
pub type Colour = [u8; 3];

/// Where a line of words lies from its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// One mark; later ones lie above.
#[derive(Clone, Debug, PartialEq)]
pub enum DrawnMark {
    /// What an odd number of rings go around.
    Area {
        /// The rings, each without its first corner again.
        rings: Vec<Vec<[f64; 2]>>,
        /// Its colour.
        fill: Colour,
        /// From 0 to 1.
        opacity: f64,
    },
    /// Lines of straight pieces with round ends.
    Lines {
        /// The corners of each; nothing is drawn of fewer than two.
        lines: Vec<Vec<[f64; 2]>>,
        /// Their width.
        width: f64,
        /// Their colour.
        colour: Colour,
    },
    /// One line of words.
    Text {
        /// On the base line.
        at: [f64; 2],
        /// Height of a line of type.
        size: f64,
        /// Where they lie from there.
        anchor: Anchor,
        /// Their colour.
        colour: Colour,
        /// The words.
        text: String,
        /// Whether white goes around the letters, for words above a picture.
        halo: bool,
    },
}

/// Marks on white paper.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Width and height.
    pub size: [f64; 2],
    /// What it shows, for those who cannot see it.
    pub title: String,
    /// From the lowest to the topmost.
    pub marks: Vec<DrawnMark>,
}

/// What a drawing is written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Scalable Vector Graphics 1.1.
    Svg,
    /// Portable Network Graphics, two dots a unit.
    Png,
    /// Portable Document Format 1.4, one page.
    Pdf,
}

impl Format {
    /// The endings of file names that say a format, for sentences.
    pub const ENDINGS: &'static str = ".svg, .png, .pdf";

    /// By a file name's ending without its dot, in any case; `None` for another.
    pub fn of_ending(ending: &str) -> Option<Self> {
        match ending.to_ascii_lowercase().as_str() {
            "svg" => Some(Self::Svg),
            "png" => Some(Self::Png),
            "pdf" => Some(Self::Pdf),
            _ => None,
        }
    }
}

/// A letter is so many times as wide as its type is high, on the mean.
const LETTER: f64 = 0.56;

/// About how wide a line of words is.
pub fn width_of(text: &str, size: f64) -> f64 {
    LETTER * size * text.chars().count() as f64
}

impl Drawing {
    /// White paper.
    pub fn new(size: [f64; 2], title: impl Into<String>) -> Self {
        Self { size, title: title.into(), marks: Vec::new() }
    }

    /// The file's bytes; the same for the same drawing.
    pub fn bytes(&self, format: Format) -> Vec<u8> {
        match format {
            Format::Svg => svg::written(self).into_bytes(),
            Format::Png => Picture::of(self).png(),
            Format::Pdf => pdf::written(self),
        }
    }

    /// Draws an area.
    pub fn area(&mut self, rings: Vec<Vec<[f64; 2]>>, fill: Colour, opacity: f64) {
        self.marks.push(DrawnMark::Area { rings, fill, opacity });
    }

    /// Draws an upright rectangle by its corners.
    pub fn rectangle(&mut self, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2], fill: Colour) {
        self.area(vec![vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]], fill, 1.0);
    }

    /// Draws a line.
    pub fn line(&mut self, points: Vec<[f64; 2]>, width: f64, colour: Colour) {
        self.lines(vec![points], width, colour);
    }

    /// Draws lines of one kind.
    pub fn lines(&mut self, lines: Vec<Vec<[f64; 2]>>, width: f64, colour: Colour) {
        let lines: Vec<_> = lines.into_iter().filter(|line| line.len() > 1).collect();
        if !lines.is_empty() {
            self.marks.push(DrawnMark::Lines { lines, width, colour });
        }
    }

    /// Draws a circle's line.
    pub fn circle(&mut self, [x, y]: [f64; 2], radius: f64, width: f64, colour: Colour) {
        let at = |i: usize| (std::f64::consts::TAU * i as f64 / 48.0).sin_cos();
        let points = (0..=48).map(at).map(|(sin, cos)| [x + radius * cos, y + radius * sin]).collect();
        self.line(points, width, colour);
    }

    /// Writes dark words.
    pub fn text(&mut self, at: [f64; 2], size: f64, anchor: Anchor, text: impl Into<String>) {
        let (text, colour) = (text.into(), INK);
        self.marks.push(DrawnMark::Text { at, size, anchor, colour, text, halo: false });
    }

    /// Writes words of a colour above a picture, white around the letters.
    pub fn label(&mut self, at: [f64; 2], size: f64, colour: Colour, text: impl Into<String>) {
        let text = text.into();
        self.marks.push(DrawnMark::Text { at, size, anchor: Anchor::Middle, colour, text, halo: true });
    }
}

/// Dark words and lines.
pub const INK: Colour = [34, 34, 34];

#[cfg(test)]
mod tests;
