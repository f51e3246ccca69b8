//! Pictures of an objective and of a part: PNG bytes, no file is touched.

mod canvas;
mod landscape;
#[cfg(test)]
mod tests;
mod view;

pub use landscape::landscape;
pub use view::{Paint, view};

/// A picture of 8 bits a colour.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels from left to right.
    pub width: usize,
    /// Pixels from top to bottom.
    pub height: usize,
    /// Red, green, blue of each pixel, row by row from the top.
    pub pixels: Vec<[u8; 3]>,
}

impl Picture {
    fn filled(width: usize, height: usize, colour: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![colour; width * height] }
    }

    /// Sets a pixel; outside the picture nothing happens.
    fn set(&mut self, x: i64, y: i64, colour: [u8; 3]) {
        if x >= 0 && y >= 0 && x < self.width as i64 && y < self.height as i64 {
            self.pixels[y as usize * self.width + x as usize] = colour;
        }
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    ///
    /// [`png::EncodingError`] for a picture without pixels or beyond the format's 2³¹.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels.concat())?;
        writer.finish()?;
        Ok(bytes)
    }
}
