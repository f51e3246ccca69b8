//! How the page looks, held against the pictures that are kept: a screenshot in quarters, in which every letter is a box.
//!
//! `box.ttf` (made by `box.py`) has one shape for every character: what lettering a system has, and which digits a price has, does
//! not matter. The preview's frame is left out, whose pictures are kept by themselves.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::browser::{SHOWN, eval, shot, until};
use super::open;
use crate::preview::browser::browse_any;
use crate::support::{folder, note, root};

/// Pixels of a screenshot that are one of a picture, along each side.
const SHRUNK: usize = 4;
/// Pixels of a picture, along each side, that are judged together.
const BLOCK: usize = 8;
/// How far a block may be from the kept one, of 255 and in the mean over its pixels: the same page again is at most 3 off, a button at half
/// its strength 23.
const OFF: f64 = 10.0;

/// Screenshots of one visit.
pub(super) struct Looks {
    folder: tempfile::TempDir,
    names: Vec<&'static str>,
}

/// Rows of red, green and blue.
struct Picture {
    width: usize,
    bytes: Vec<u8>,
}

impl Picture {
    fn read(path: &Path) -> Option<Self> {
        let file = std::fs::File::open(path).ok()?;
        let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        let channels = info.color_type.samples();
        let bytes = bytes.chunks(channels).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        Some(Self { width: info.width as usize, bytes })
    }

    fn write(&self, path: &Path) {
        let height = self.bytes.len() / 3 / self.width;
        let mut encoder = png::Encoder::new(std::fs::File::create(path).unwrap(), self.width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        encoder.write_header().unwrap().write_image_data(&self.bytes).unwrap();
    }

    /// The mean of each square of `by` pixels; what is left at the right and below is dropped.
    fn shrunk(&self, by: usize) -> Self {
        let (width, height) = (self.width / by, self.bytes.len() / 3 / self.width / by);
        let mut bytes = Vec::with_capacity(width * height * 3);
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            for channel in 0..3 {
                let at = |k: usize| ((y * by + k / by) * self.width + x * by + k % by) * 3 + channel;
                let sum: usize = (0..by * by).map(|k| usize::from(self.bytes[at(k)])).sum();
                bytes.push((sum / (by * by)) as u8);
            }
        }
        Self { width, bytes }
    }

    /// The block that is farthest from that of another picture of this size: how far (of 255), and where its corner is in the screenshot.
    fn farthest(&self, other: &Self) -> (f64, [usize; 2]) {
        assert_eq!((self.width, self.bytes.len()), (other.width, other.bytes.len()));
        let differences: Vec<u8> = self.bytes.iter().zip(&other.bytes).map(|(a, b)| a.abs_diff(*b)).collect();
        let (columns, rows) = (self.width / BLOCK, self.bytes.len() / 3 / self.width / BLOCK);
        let block = |x: usize, y: usize| {
            let row = |k: usize| ((y * BLOCK + k) * self.width + x * BLOCK) * 3;
            let sum: f64 =
                (0..BLOCK).flat_map(|k| &differences[row(k)..row(k) + BLOCK * 3]).map(|d| f64::from(*d)).sum();
            (sum / (BLOCK * BLOCK * 3) as f64, [x, y].map(|k| k * BLOCK * SHRUNK))
        };
        let all = (0..columns).flat_map(|x| (0..rows).map(move |y| block(x, y)));
        all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }
}

/// Letters are boxes from here on, and what scrolls is at one end, wherever it was; waits until the page is drawn so.
fn dressed() -> String {
    let font = include_bytes!("box.ttf");
    format!(
        "(async () => {{ if (!window.dressed) {{ window.dressed = true; \
         document.fonts.add(await new FontFace('Box', new Uint8Array({font:?})).load()); const sheet = new CSSStyleSheet(); \
         sheet.replaceSync('* {{ font-family: Box !important; font-synthesis: none !important; transition: none !important; animation: none !important }} \
         #folder, iframe {{ visibility: hidden }}'); document.adoptedStyleSheets.push(sheet); }} \
         for (const [id, end] of [['panel', 0], ['deck', 1e6]]) document.getElementById(id).scrollTop = end; \
         for (let k = 0; k < 3; k++) await new Promise(requestAnimationFrame); }})()"
    )
}

impl Looks {
    pub(super) fn new() -> Self {
        Self { folder: folder(), names: Vec::new() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(format!("{name}.png"))
    }

    /// A picture that is kept. Somebody who looks (`TRUNNION_SHOTS`) is given letters, and nothing is held against anything.
    pub(super) fn shot(&mut self, name: &'static str) -> Value {
        if std::env::var_os("TRUNNION_SHOTS").is_some() {
            return shot(name);
        }
        self.names.push(name);
        json!({"shot": self.path(name), "first": dressed()})
    }

    fn taken(&self, name: &str) -> Picture {
        Picture::read(&self.path(name)).unwrap().shrunk(SHRUNK)
    }

    /// Every picture is as the one that is kept. UPDATE_FIXTURES=1 writes them anew; look at them before they are committed.
    #[track_caller]
    pub(super) fn are_kept(&self) {
        let mut unlike = Vec::new();
        for name in &self.names {
            let (kept, taken) = (root().join(format!("tests/it/workbench/looks/{name}.png")), self.taken(name));
            if std::env::var_os("UPDATE_FIXTURES").is_some() {
                taken.write(&kept);
            }
            let picture = Picture::read(&kept).unwrap_or_else(|| panic!("{}: is not there", kept.display()));
            let (off, [x, y]) = taken.farthest(&picture);
            note(&format!("the page, {name}: at most {off:.1} of 255 away from the kept picture"));
            if off >= OFF {
                unlike.push(format!("{name}: {off:.1} of 255 away from the kept picture at {x}, {y}"));
            }
        }
        assert!(unlike.is_empty(), "{unlike:#?}; UPDATE_FIXTURES=1 writes them anew");
    }
}

/// Each fault from nothing to gross, as rules of the page's style: none is seen in what is the same, all are in what a person would see.
#[test]
fn what_moves_vanishes_or_pales_is_seen() {
    // A rule with a size in it, from which size on it has to be seen, and sizes from nothing to gross.
    let faults: [(&str, &str, f64, &[f64]); 5] = [
        (
            "the panel aside, in pixels",
            "#panel { transform: translateX(SIZEpx) }",
            2.0,
            &[0.0, 1.0, 2.0, 4.0, 8.0, 16.0],
        ),
        ("a button fainter, share", "#pick { opacity: calc(1 - SIZE) }", 0.5, &[0.0, 0.2, 0.5, 0.9, 1.0]),
        ("the scene fainter, share", "#canvas { opacity: calc(1 - SIZE) }", 0.5, &[0.0, 0.02, 0.1, 0.5, 1.0]),
        ("words as pale as paper, share", "h2 { opacity: calc(1 - SIZE) }", 0.5, &[0.0, 0.2, 0.5, 0.9, 1.0]),
        ("rooms over the panel, in pixels", "nav { transform: translateX(SIZEpx) }", 3.0, &[0.0, 1.0, 3.0, 8.0, 700.0]),
    ];
    let workbench = open(&["hook"], &["hook.stl", "-m", "generic-ac"]);
    let looks = Looks::new();
    let mut steps = vec![
        until(SHOWN),
        json!({"size": [1000, 700]}),
        json!({"shot": looks.path("right"), "first": dressed()}),
        eval("window.fault = new CSSStyleSheet(), document.adoptedStyleSheets.push(fault)"),
    ];
    for (k, (_, rule, _, sizes)) in faults.iter().enumerate() {
        for (size, value) in sizes.iter().enumerate() {
            let rule = rule.replace("SIZE", &value.to_string());
            let first = format!("(fault.replaceSync('{rule}'), {})", dressed());
            steps.push(json!({"shot": looks.path(&format!("{k}-{size}")), "first": first}));
        }
    }
    let Some(answers) = browse_any(workbench.address.as_ref(), &steps) else { return };
    assert_eq!(answers.console, Vec::<Value>::new());
    let plain = looks.taken("right");
    for (k, (what, _, seen, sizes)) in faults.iter().enumerate() {
        for (size, value) in sizes.iter().enumerate() {
            let off = plain.farthest(&looks.taken(&format!("{k}-{size}"))).0;
            note(&format!("{what}, {value}: {off:.1}"));
            let right = if *value == 0.0 { off < OFF } else { *value < *seen || off >= OFF };
            assert!(right, "{what}, {value}: {off:.1}");
        }
    }
}
