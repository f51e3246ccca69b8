//! Small pictures of a model for the head of a program: what the pages of printers' servers, and displays, show beside a file's name.
//!
//! The form is PrusaSlicer's (`GCode/Thumbnails.hpp`): comments with a PNG in base64, its size in dots and the length of the text. Moonraker
//! (`metadata.py`), `OctoPrint`'s plugins and RepRapFirmware (`FileInfoParser`) read it. The sizes are those that Mainsail asks slicers for.

use std::fmt::Write;

use super::drawing::{Alpha, encoded};
use super::eye::Eye;
use super::pack::push_base64;
use super::solids::{Solids, Surface, Window};
use crate::geom::{Bounds, Vec3};

/// Dots from left to right and from top to bottom; the small one first, since RepRapFirmware reads a file's first 20 kB only.
const SIZES: [[usize; 2]; 2] = [[32, 32], [400, 300]];
/// Characters of base64 in a line.
const ROW: usize = 78;
/// Places along a side of a dot.
const FINE: usize = 3;
/// So much of the picture is left free on each side.
const EDGE: f64 = 0.04;
/// From where a model is looked at: turn and rise, degrees.
const EYE: [f64; 2] = [-35.0, 24.0];

/// The comments of all pictures of `surfaces`, which stand as they are seen, Z upward: whole lines, the same for the same surfaces. Nothing
/// where there is nothing to be seen.
pub fn thumbnails(surfaces: &[Surface]) -> String {
    let mut out = String::new();
    if surfaces.iter().all(|surface| surface.facets.is_empty()) {
        return out;
    }
    for [width, height] in SIZES {
        let mut text = String::new();
        push_base64(&drawn(surfaces, [width, height]), &mut text);
        let _ = writeln!(out, ";\n; thumbnail begin {width}x{height} {}", text.len());
        for row in text.as_bytes().chunks(ROW) {
            let _ = writeln!(out, "; {}", String::from_utf8_lossy(row));
        }
        out.push_str("; thumbnail end\n;\n");
    }
    out
}

/// The picture as a PNG file; what is not covered lets the page shine through.
fn drawn(surfaces: &[Surface], [width, height]: [usize; 2]) -> Vec<u8> {
    let eye = Eye::at(EYE[0], EYE[1]);
    let flat = |p: &Vec3| {
        let [x, y, _] = eye.seen(p);
        Vec3::new(x, y, 0.0)
    };
    let extent = Bounds::of(surfaces.iter().flat_map(|surface| &surface.points).map(flat));
    let places = [width * FINE, height * FINE];
    let fits = |k: usize| (1.0 - 2.0 * EDGE) * places[k] as f64 / extent.size()[k].max(1e-6);
    let middle = [extent.centre().x, extent.centre().y];
    let solids = Solids::of(surfaces.iter(), &eye, &Window { places, scale: fits(0).min(fits(1)), middle });
    let mut dots = Vec::with_capacity(width * height * 4);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let rows = (0..FINE).map(|row| (y * FINE + row) * places[0] + x * FINE);
        let seen = rows.flat_map(|first| first..first + FINE).filter_map(|place| solids.at(place));
        let (mut sum, mut count) = ([0; 3], 0);
        for one in seen {
            sum = [0, 1, 2].map(|k: usize| sum[k] + u32::from(one.colour[k]));
            count += 1;
        }
        dots.extend(sum.map(|all| (all / count.max(1)) as u8));
        dots.push((255 * count / (FINE * FINE) as u32) as u8);
    }
    encoded([width, height], Alpha::Told, &dots)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures;

    /// The pictures in a text: size as told, and dots as read back.
    fn read(text: &str) -> Vec<([u32; 2], Vec<u8>)> {
        const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let of = |part: &str| {
            let (head, rest) = part.split_once('\n').unwrap();
            let (body, _) = rest.split_once("; thumbnail end\n").unwrap();
            let letters: String = body.lines().map(|line| line.strip_prefix("; ").unwrap()).collect();
            let (size, length) = head.split_once(' ').unwrap();
            assert_eq!(length.parse::<usize>().unwrap(), letters.len());
            let bits = letters.bytes().filter_map(|c| LETTERS.iter().position(|l| *l == c));
            let (mut bytes, mut held, mut count) = (Vec::new(), 0, 0);
            for six in bits {
                (held, count) = (held << 6 | six, count + 6);
                if count >= 8 {
                    count -= 8;
                    bytes.push((held >> count & 255) as u8);
                }
            }
            let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
            let mut dots = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut dots).unwrap();
            assert_eq!(format!("{}x{}", info.width, info.height), size);
            ([info.width, info.height], dots)
        };
        text.split("; thumbnail begin ").skip(1).map(of).collect()
    }

    #[test]
    fn the_model_fills_its_pictures_and_nothing_else_does() {
        let part = |color, (_, mesh): &fixtures::NamedMesh| Surface { edges: false, ..Surface::of(mesh, color) };
        let tree: Vec<Surface> = fixtures::y_tree().parts.iter().map(|one| part([240, 170, 60], one)).collect();
        let text = thumbnails(&tree);
        assert!(text.lines().all(|line| line.starts_with(';') && line.len() <= ROW + 2));
        let pictures = read(&text);
        assert_eq!(pictures.iter().map(|(size, _)| *size).collect::<Vec<_>>(), [[32, 32], [400, 300]]);
        for ([width, height], dots) in pictures {
            let at = |x: u32, y: u32| &dots[4 * (y * width + x) as usize..][..4];
            let covered = (0..width * height).filter(|i| dots[4 * *i as usize + 3] == 255).count() as f64;
            let share = covered / f64::from(width * height);
            assert!((0.1..0.6).contains(&share), "{share} of {width}x{height}");
            // The corners are free; the trunk's foot stands in the middle below, in shades of its colour.
            assert!([at(0, 0), at(width - 1, 0), at(0, height - 1)].iter().all(|dot| dot[3] == 0));
            let [red, green, blue, alpha] = at(width / 2, height * 3 / 4) else { unreachable!() };
            assert!(*alpha == 255 && red > green && green > blue, "{red} {green} {blue} {alpha}");
        }
        assert_eq!(thumbnails(&tree), text);
        assert_eq!(thumbnails(&[]), "");
    }
}
