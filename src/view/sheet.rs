//! Frames side by side on one sheet, with captions, one scale, and a legend.

use super::drawing::{Anchor, Colour, Drawing, width_of};
use super::eye::Eye;
use super::frame::{Frame, scale_bar, scale_for};

/// Height of a line of words, and of its letters.
const LINE: f64 = 16.0;
const WORDS: f64 = 12.0;
const EDGE: Colour = [214, 218, 224];

/// A picture of some frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// For those who cannot see it.
    pub title: String,
    /// Width and height of a frame without its caption, units.
    pub side: f64,
    /// Frames in a row, at most.
    pub columns: usize,
    /// The frames.
    pub frames: Vec<Frame>,
    /// What colours mean.
    pub legend: Vec<(Colour, &'static str)>,
    /// Sentences below all.
    pub story: Vec<String>,
}

impl Sheet {
    /// Draws it; without frames, what is said alone.
    pub fn drawing(&self) -> Drawing {
        let columns = self.columns.min(self.frames.len()).max(1);
        let width = self.side * columns as f64;
        let captions: Vec<Vec<String>> = self.frames.iter().map(|f| wrapped(&f.caption, self.side - 12.0)).collect();
        let caption = LINE * captions.iter().map(Vec::len).max().unwrap_or(0) as f64 + 6.0;
        let rows = self.frames.len().div_ceil(columns);
        let frames = (self.side + caption) * rows as f64;
        let story = wrapped(&self.story, width - 20.0);
        let (legend, legend_height) = self.legend(width, frames);
        let height = frames + legend_height + LINE * story.len() as f64 + if story.is_empty() { 0.0 } else { 8.0 };
        let mut drawing = Drawing::new([width, height.max(LINE)], self.title.clone());
        let eyes: Vec<Eye> = self.frames.iter().map(Frame::eye).collect();
        let fitting = |(frame, eye): (&Frame, &Eye)| scale_for(&frame.extent(eye), self.side);
        let scale = self.frames.iter().zip(&eyes).map(fitting).fold(f64::INFINITY, f64::min);
        for (i, (frame, eye)) in self.frames.iter().zip(&eyes).enumerate() {
            let at = [(i % columns) as f64 * self.side, (i / columns) as f64 * (self.side + caption)];
            frame.draw(&mut drawing, at, self.side, eye, scale);
            border(&mut drawing, at, self.side);
            scale_bar(&mut drawing, [at[0] + self.side - 12.0, at[1] + self.side - 10.0], scale);
            for (line, text) in captions[i].iter().enumerate() {
                let y = at[1] + self.side + LINE * (line as f64 + 0.9);
                drawing.text([at[0] + self.side / 2.0, y], WORDS, Anchor::Middle, text.clone());
            }
        }
        drawing.marks.extend(legend.marks);
        for (line, text) in story.iter().enumerate() {
            let y = frames + legend_height + LINE * (line as f64 + 0.8);
            drawing.text([width / 2.0, y], WORDS, Anchor::Middle, text.clone());
        }
        drawing
    }

    /// The legend from `top` on, and how high it is.
    fn legend(&self, width: f64, top: f64) -> (Drawing, f64) {
        let mut drawing = Drawing::new([width, 0.0], "");
        let (mut x, mut y) = (10.0, top + 6.0);
        for (colour, text) in &self.legend {
            let wide = 16.0 + width_of(text, WORDS) + 14.0;
            if x + wide > width && x > 10.0 {
                (x, y) = (10.0, y + LINE);
            }
            drawing.rectangle([x, y], [x + 11.0, y + 11.0], *colour);
            drawing.text([x + 16.0, y + 10.0], WORDS, Anchor::Start, *text);
            x += wide;
        }
        (drawing, if self.legend.is_empty() { 0.0 } else { y + LINE + 4.0 - top })
    }
}

fn border(drawing: &mut Drawing, [x, y]: [f64; 2], side: f64) {
    let (a, b) = (2.0, side - 2.0);
    let ring = [[a, a], [b, a], [b, b], [a, b], [a, a]];
    drawing.line(ring.map(|p| [p[0] + x, p[1] + y]).to_vec(), 0.8, EDGE);
}

/// Sentences in lines that are no wider, broken between words where there are any.
fn wrapped(texts: &[String], wide: f64) -> Vec<String> {
    let most = (wide / width_of("m", WORDS)).floor().max(8.0) as usize;
    let mut lines = Vec::new();
    for text in texts.iter().filter(|text| !text.is_empty()) {
        let mut line = String::new();
        for word in text.split_whitespace() {
            let mut word: Vec<char> = word.chars().collect();
            if !line.is_empty() && line.chars().count() + 1 + word.len() > most {
                lines.push(std::mem::take(&mut line));
            }
            while word.len() > most {
                lines.push(word.drain(..most).collect());
            }
            if !line.is_empty() {
                line.push(' ');
            }
            line.extend(word);
        }
        lines.push(line);
    }
    lines
}
