//! The pictures in the head of a program, taken out again as Moonraker's `metadata.py` does, and what must not be among them.

use std::collections::BTreeMap;

use regex_lite::Regex;

use super::prepared;
use crate::pipeline::{fixture, prepare};
use crate::preview::decoder::from_base64;
use crate::support::{folder, said, trunnion};

/// RepRapFirmware looks for pictures in so much of a file.
const DUETS_HEAD: usize = 20_000;

/// A picture: width, height, and red, green, blue, alpha of each dot.
struct Picture {
    size: [u32; 2],
    dots: Vec<[u8; 4]>,
}

/// Size in the head line, text joined without what begins a comment, its length compared with what the head line says.
fn pictures(text: &str) -> Vec<Picture> {
    let block = Regex::new(r"; thumbnail begin[;/+=\w\s]+?; thumbnail end").unwrap();
    let number = Regex::new(r"\d+").unwrap();
    let read = |found: &str| {
        let found = found.replace("; ", "");
        let lines: Vec<&str> = found.lines().collect();
        let told: Vec<u32> = number.find_iter(lines[0]).map(|n| n.as_str().parse().unwrap()).collect();
        let [width, height, length] = told[..] else { panic!("{}", lines[0]) };
        let text = lines[1..lines.len() - 1].concat();
        assert_eq!(text.len(), length as usize, "Moonraker leaves it out where these differ");
        let png = from_base64(&text);
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut dots = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut dots).unwrap();
        assert_eq!(([info.width, info.height], info.color_type), ([width, height], png::ColorType::Rgba));
        Picture { size: [width, height], dots: dots.chunks(4).map(|dot| dot.try_into().unwrap()).collect() }
    };
    block.find_iter(text).map(|found| read(found.as_str())).collect()
}

/// Which of red, green and blue is the most and which the least: the shade of a colour does not change that.
fn kind(dot: [u8; 4]) -> [usize; 2] {
    let by = |of: fn(&[u8]) -> Option<&u8>| dot[..3].iter().position(|v| Some(v) == of(&dot[..3])).unwrap();
    [by(|all| all.iter().max()), by(|all| all.iter().min())]
}

#[test]
fn a_program_shows_its_model_on_the_pages_of_servers() {
    let text = String::from_utf8(prepared().bytes.clone()).unwrap();
    let head = text.lines().take_while(|line| line.starts_with(';')).map(|line| line.len() + 1).sum::<usize>();
    let found = pictures(&text[..head]);
    assert_eq!(found.iter().map(|one| one.size).collect::<Vec<_>>(), [[32, 32], [400, 300]]);
    assert_eq!(text.matches("thumbnail begin").count(), 2);
    let first_end = text.find("; thumbnail end").unwrap();
    assert!(first_end < DUETS_HEAD, "the small one ends after {first_end} bytes");
    assert!(text[..head].lines().all(|line| line.len() <= 256));
    let rows = text[..head].lines().skip_while(|l| !l.starts_with("; thumbnail begin"));
    let longest = rows.take_while(|l| !l.starts_with("; thumbnail end")).map(str::len).max().unwrap();
    assert!(longest <= 80, "{longest}");
    for one in found {
        let solid: Vec<[u8; 4]> = one.dots.iter().copied().filter(|dot| dot[3] == 255).collect();
        let share = solid.len() as f64 / one.dots.len() as f64;
        assert!((0.1..0.6).contains(&share), "{share:.2} of {:?} is covered", one.size);
        // Three parts in three colours; where two meet, dots are a mixture.
        let mut kinds: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        solid.iter().for_each(|dot| *kinds.entry(kind(*dot)).or_default() += 1);
        kinds.retain(|_, count| *count * 50 > solid.len());
        assert_eq!(kinds.len(), 3, "{kinds:?} of {}", solid.len());
        let [width, height] = one.size.map(|side| side as usize);
        let rim = (0..width).flat_map(|x| [x, (height - 1) * width + x]);
        assert!(rim.into_iter().all(|i| one.dots[i][3] == 0), "nothing is cut off at the rim");
    }
}

#[test]
fn a_profile_leaves_the_pictures_out_and_nothing_else_changes() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("plain.toml"), "extends = \"generic-ac\"\n[dialect]\nthumbnails = false\n").unwrap();
    let machine = at("plain.toml");
    prepare(&fixture("y-tree"), machine.to_str().unwrap(), "builtin", &at("plain.gcode"), &[]);
    let plain = std::fs::read_to_string(at("plain.gcode")).unwrap();
    let shown = String::from_utf8(prepared().bytes.clone()).unwrap();
    assert!(!plain.contains("thumbnail"));
    let without = Regex::new(r";\n; thumbnail begin[;/+=\w\s]+?; thumbnail end\n;\n").unwrap().replace_all(&shown, "");
    // The plan is another one's, for another profile.
    let moves = |text: &str| text.lines().filter(|l| !l.starts_with(";TRUNNION version")).map(str::to_owned).collect();
    let (plain, without): (Vec<String>, Vec<String>) = (moves(&plain), moves(&without));
    assert_eq!(plain, without);
}

/// The picture of a slicer's window is of one print, upright: where it ends, in all its forms, and where it does not.
#[test]
fn the_pictures_of_a_slicers_window_do_not_stay() {
    let (folder, made) = (folder(), prepared());
    let slots = folder.path().join("slots");
    let run = trunnion().arg("slice").arg(&made.plan).args(["--slicer", "builtin", "-o"]).arg(&slots).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let mut files: Vec<_> = std::fs::read_dir(&slots).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|end| end == "gcode"));
    files.sort();
    let rewritten = || {
        let out = folder.path().join("out.gcode");
        let run = trunnion().arg("rewrite").args(&files).arg("--plan").arg(&made.plan).arg("-o").arg(&out).output();
        let run = run.unwrap();
        assert!(run.status.success(), "{}", said(&run));
        std::fs::read_to_string(out).unwrap()
    };
    // The built-in slicer's checksum would tell that somebody changed its file.
    let sliced = std::fs::read_to_string(&files[0]).unwrap();
    let sliced: String = sliced.lines().filter(|l| !l.starts_with("; crc32")).map(|l| format!("{l}\n")).collect();
    std::fs::write(&files[0], &sliced).unwrap();
    let wanted = rewritten();
    let (first, rest) = sliced.split_once('\n').unwrap();
    for end in ["thumbnail end\n;\n", "thumbnail_QOI end\n", ""] {
        let begin = if end.contains("QOI") { "thumbnail_QOI begin" } else { "thumbnail begin" };
        let picture = format!(";\n; {begin} 16x16 8\n; U0xJQ0VS\n");
        let end = if end.is_empty() { String::new() } else { format!("; {end}") };
        // One that was cut short ends with the first command, and so do the comments behind it.
        std::fs::write(&files[0], format!("{first}\n{picture}{end}{rest}")).unwrap();
        let made = rewritten();
        assert!(!made.contains("U0xJQ0VS"), "{begin}");
        if !end.is_empty() {
            assert_eq!(made, wanted, "{begin}");
        }
    }
}

/// What goes over the wire has no comments.
#[test]
fn a_printer_is_not_told_of_the_pictures() {
    let made = prepared();
    let folder = folder();
    let text = String::from_utf8(made.bytes.clone()).unwrap();
    let without = Regex::new(r"; thumbnail begin[;/+=\w\s]+?; thumbnail end\n").unwrap().replace_all(&text, "");
    let sent = |text: &str| {
        let file = folder.path().join("tree.gcode");
        std::fs::write(&file, text).unwrap();
        let run = trunnion().arg("send").arg(&file).arg("--plan").arg(&made.plan).arg("--dry-run").output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
        let words = said(&run);
        words.lines().find(|line| line.starts_with("rehearsal: ")).unwrap().to_owned()
    };
    assert_eq!(sent(&text), sent(&without));
}
