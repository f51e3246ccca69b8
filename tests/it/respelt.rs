//! Every extruding move of a sliced file is in the rewritten one, moved into the machine and else as it was: for real files of all
//! flavours, and for one file spelt at random. What is not rewritten is refused for the true reason.

use std::path::{Path, PathBuf};

use trunnion::gcode::{ParsedLine, lines};
use trunnion::geom::Vec3;
use trunnion::mesh::stl_binary;
use trunnion::motion::replay::{Controller, Reading, Step};

use crate::own_settings::rewrite;
use crate::pipeline::fixture;
use crate::sliced_files::unpack;
use crate::split::solids;
use crate::support::{Numbers, folder, said, seeds, states, trunnion};

/// A line that is laid: both ends, filament, and the way to the centre of an arc.
type Laid = ([Vec3; 2], f64, Option<[f64; 2]>);

/// The extruding moves of a file, as the one controller carries them out.
fn laid(bytes: &[u8]) -> Vec<Laid> {
    let mut controller = Controller::new(Reading::sliced());
    let mut parsed = ParsedLine::default();
    let mut all = Vec::new();
    for line in lines(bytes) {
        if parsed.read(line.bytes).is_err() {
            continue;
        }
        let Ok(Step::Move(m)) = controller.step(&parsed) else { continue };
        if let (Some(from), Some(to), true) = (m.from.tip(), m.to.tip(), m.e > 0.0)
            && (from != to || m.arc.is_some())
        {
            all.push(([from, to], m.e, m.arc.map(|arc| arc.to_centre)));
        }
    }
    all
}

/// Holds the rewritten file against the sliced one: the same lines, shifted by one vector.
fn assert_same(name: &str, sliced: &[Laid], out: &[Laid]) {
    assert_eq!(sliced.len(), out.len(), "{name}");
    let shift = out[0].0[0] - sliced[0].0[0];
    let (mut given, mut taken) = (0.0, 0.0);
    for ((ends, e, centre), (out_ends, out_e, out_centre)) in sliced.iter().zip(out) {
        for i in 0..2 {
            assert!((ends[i] + shift - out_ends[i]).norm() < 2e-3, "{name}: {ends:?} {out_ends:?}");
        }
        assert!((e - out_e).abs() < 2e-5, "{name}: {e} {out_e}");
        let apart = centre.zip(*out_centre).map_or(0.0, |(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
        assert!(centre.is_some() == out_centre.is_some() && apart < 2e-3, "{name}: {centre:?} {out_centre:?}");
        (given, taken) = (given + e, taken + out_e);
    }
    assert!((given - taken).abs() < 1e-3, "{name}: {given} {taken}");
}

/// A plan for one solid, `model`, as it lies.
fn planned(folder: &Path, model: &Path) -> PathBuf {
    let plan = folder.join("plan.json");
    let run = trunnion().arg("plan").arg(model).args(["-m", "generic-ac", "-q", "-o"]).arg(&plan).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    plan
}

/// What becomes of a real file.
enum Becomes {
    /// Rewritten, a disc of 40 x 5 mm of so many sides being its part.
    Same(usize),
    /// Refused with these words, whatever the part.
    Refused(&'static str),
}

#[test]
fn real_files_of_all_flavours_are_rewritten_move_by_move_or_refused_for_the_true_reason() {
    use Becomes::{Refused, Same};
    let cases = [
        ("ps_base_rel", Same(180)),
        ("ps_base_rel_crlf", Same(180)),
        ("ps_base720_arcs", Same(720)),
        ("s3_rel_fwretract", Same(180)),
        // Sliced 5 mm above the bed.
        ("ps_stem_abs", Refused("extrusion ends at z")),
        ("ps_stem_abs_nospace_lower", Refused("extrusion ends at z")),
        ("ps_armL_fwretract", Refused("extrusion ends at z")),
        ("ps_klipper_macros", Refused("times as large as the part in x, y and z")),
        // Several parts, none of them named as ours.
        ("cu_four_parts", Refused("extrusion ends at z")),
        ("cu_seq3", Refused("times as large as the part in x, y and z")),
        ("ps_four_labels", Refused("extrusion ends at z")),
        ("ps_seq4", Refused("times as large as the part in x, y and z")),
        ("s3_two_parts_merge", Refused("times as large as the part in x, y and z")),
        ("ps_mach3_Aaxis", Refused("choose a G-code flavour that extrudes with E")),
        ("edge_cases", Refused("the file is damaged")),
    ];
    let folder = folder();
    let (model, sliced) = (folder.path().join("disc.stl"), folder.path().join("print-00.gcode"));
    for (name, becomes) in cases {
        let Some(bytes) = unpack(name) else { return };
        let sides = if let Same(sides) = becomes { sides } else { 180 };
        std::fs::write(&model, stl_binary(&solids::rod(20.0, 5.0, sides).mesh())).unwrap();
        let plan = planned(folder.path(), &model);
        std::fs::write(&sliced, &bytes).unwrap();
        let run = rewrite(std::slice::from_ref(&sliced), &plan, &[]);
        let out = std::fs::read(folder.path().join("out.gcode"));
        match becomes {
            Same(_) => {
                assert!(run.status.success(), "{name}: {}", said(&run));
                assert_same(name, &laid(&bytes), &laid(&out.unwrap()));
            }
            Refused(why) => {
                assert!(run.status.code() == Some(2) && out.is_err(), "{name}: {}", said(&run));
                assert!(said(&run).contains(why), "{name}: {}", said(&run));
            }
        }
    }
}

/// Spells the moves of a file anew: modes, words, digits and decoration drawn at random.
struct Speller {
    numbers: Numbers,
    absolute: bool,
    absolute_e: bool,
    /// Whole hundred-thousandths, so that sums keep their last digit.
    e: i64,
    line: u32,
    at: [f64; 3],
}

impl Speller {
    fn chance(&mut self, share: f64) -> bool {
        self.numbers.between(0.0, 1.0) < share
    }

    fn number(&mut self, value: f64, digits: usize) -> String {
        let mut text = format!("{value:.digits$}");
        if self.chance(0.5) {
            text = text.trim_end_matches('0').trim_end_matches('.').to_owned();
        }
        if self.chance(0.3) {
            text = text.replacen("0.", ".", usize::from(text.starts_with("0.") || text.starts_with("-0.")));
        }
        if value > 0.0 && self.chance(0.1) { format!("+{text}") } else { text }
    }

    fn modes(&mut self, out: &mut String) {
        if self.chance(0.02) {
            self.absolute = !self.absolute;
            self.absolute_e = self.chance(0.5);
            // Marlin's G90 and G91 switch E too, so that is said behind them.
            let e = if self.absolute_e { "M82" } else { "M83" };
            out.push_str(&format!("{}\n{e}\n", if self.absolute { "G90" } else { "g91" }));
        }
        if self.chance(0.01) {
            out.push_str("G92 E0\n");
            self.e = 0;
        }
    }

    fn a_move(&mut self, to: [f64; 3], e: f64, feed: Option<f64>, out: &mut String) {
        self.modes(out);
        let mut words = vec![["G1", "G01", "g1"][self.numbers.between(0.0, 3.0) as usize].to_owned()];
        for (i, letter) in ["X", "Y", "Z"].iter().enumerate() {
            if (to[i] - self.at[i]).abs() > 1e-9 || self.chance(0.1) {
                let value = if self.absolute { to[i] } else { to[i] - self.at[i] };
                words.push(format!("{letter}{}", self.number(value, 3)));
            }
        }
        let e_units = (e * 1e5).round() as i64;
        self.e += e_units;
        if e_units != 0 {
            let value = if self.absolute_e { self.e } else { e_units };
            words.push(format!("E{}", self.number(value as f64 / 1e5, 5)));
        }
        if let Some(feed) = feed {
            words.push(format!("F{feed}"));
        }
        self.at = to;
        if words.len() == 1 {
            return;
        }
        let mut text = words.join(if self.chance(0.3) { "" } else { " " });
        if self.chance(0.2) {
            text = text.to_ascii_lowercase();
        }
        if self.chance(0.1) {
            self.line += 1;
            text = format!("N{} {text}", self.line);
            let sum = text.bytes().fold(0u8, |sum, byte| sum ^ byte);
            text = format!("{text}*{sum}");
        } else if self.chance(0.1) {
            text += [" ; a word", " (a word)", "\t"][self.numbers.between(0.0, 3.0) as usize];
        }
        out.push_str(&text);
        out.push_str(if self.chance(0.1) { "\r\n" } else { "\n" });
    }
}

/// `text` (absolute XYZ, relative E) spelt anew.
fn respelt(text: &str, seed: u64) -> String {
    let mut speller =
        Speller { numbers: Numbers::seeded(seed), absolute: true, absolute_e: false, e: 0, line: 0, at: [f64::NAN; 3] };
    let mut controller = Controller::new(Reading::sliced());
    let (mut parsed, mut out) = (ParsedLine::default(), String::new());
    for line in text.lines() {
        parsed.read(line.as_bytes()).unwrap();
        match controller.step(&parsed) {
            Ok(Step::Move(m)) if m.to.tip().is_some() => {
                let tip = m.to.tip().unwrap();
                let first = speller.at[0].is_nan();
                if first {
                    out.push_str(&format!("{line}\n"));
                    speller.at = [tip.x, tip.y, tip.z];
                    continue;
                }
                let feed = parsed.value(b'F');
                speller.a_move([tip.x, tip.y, tip.z], m.e, feed, &mut out);
            }
            _ if line.starts_with("G92") => {}
            _ => out.push_str(&format!("{line}\n")),
        }
    }
    out
}

/// The only print of `plan` from the built-in slicer, and its text without the checksum, so that it may be changed.
fn sliced(folder: &Path, plan: &Path) -> (PathBuf, String) {
    let mut command = trunnion();
    command.arg("slice").arg(plan).args(["--slicer", "builtin", "-q", "-o"]).arg(folder);
    let run = command.output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    let file = folder.join("print-00-part-0.gcode");
    let mut text = std::fs::read_to_string(&file).unwrap();
    text.truncate(text.rfind("; crc32 = ").unwrap());
    (file, text)
}

#[test]
fn however_a_file_is_spelt_its_lines_are_the_same() {
    let folder = folder();
    let plan = planned(folder.path(), Path::new(&fixture("cube")));
    let (file, text) = sliced(folder.path(), &plan);
    let wanted = laid(text.as_bytes());
    for seed in seeds(6, 200) {
        let other = respelt(&text, seed);
        assert_ne!(other, text);
        std::fs::write(&file, &other).unwrap();
        let run = rewrite(std::slice::from_ref(&file), &plan, &[]);
        assert!(run.status.success(), "seed {seed}: {}", said(&run));
        let out = std::fs::read(folder.path().join("out.gcode")).unwrap();
        assert_same(&format!("seed {seed}"), &wanted, &laid(&out));
    }
}

/// An angle with legs of 30 and 20 mm: turned however it may be, its mirror image is another shape.
fn angle() -> Vec<u8> {
    let (corners, top) = ([[0.0, 0.0], [30.0, 0.0], [30.0, 10.0], [10.0, 10.0], [10.0, 20.0], [0.0, 20.0]], 8.0f32);
    let at = |i: usize, z: f32| [corners[i][0], corners[i][1], z];
    let caps = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    let flat = caps
        .iter()
        .flat_map(|[a, b, c]| [[at(*a, 0.0), at(*c, 0.0), at(*b, 0.0)], [at(*a, top), at(*b, top), at(*c, top)]]);
    let sides = (0..6).flat_map(|i| {
        let j = (i + 1) % 6;
        [[at(i, 0.0), at(j, 0.0), at(j, top)], [at(i, 0.0), at(j, top), at(i, top)]]
    });
    crate::bad_input::stl(&flat.chain(sides).collect::<Vec<_>>())
}

/// The moves of `text` with X and Y scaled, then turned, then shifted.
fn transformed(text: &str, scale: [f64; 2], degrees: f64, shift: [f64; 2]) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mut controller = Controller::new(Reading::sliced());
    let (mut parsed, mut out) = (ParsedLine::default(), String::new());
    for line in text.lines() {
        parsed.read(line.as_bytes()).unwrap();
        let step = controller.step(&parsed);
        let (Ok(Step::Move(m)), true) = (step, parsed.has(b'X') || parsed.has(b'Y')) else {
            out.push_str(&format!("{line}\n"));
            continue;
        };
        let at = |i: usize| m.to.linear[i].unwrap() * scale[i];
        let (x, y) = (cos * at(0) - sin * at(1) + shift[0], sin * at(0) + cos * at(1) + shift[1]);
        let rest = [b'Z', b'E', b'F'].map(|letter| {
            parsed.value(letter).map_or_else(String::new, |value| format!(" {}{value}", char::from(letter)))
        });
        out.push_str(&format!("G1 X{x:.3} Y{y:.3}{}\n", rest.concat()));
    }
    out
}

/// Moved and turned by hand, whatever the angle: the lines of the file as it was put there. Mirrored and scaled: refused for that.
#[test]
fn a_print_is_found_wherever_it_was_moved_or_turned() {
    let folder = folder();
    let model = folder.path().join("angle.stl");
    std::fs::write(&model, angle()).unwrap();
    let plan = planned(folder.path(), &model);
    let (file, text) = sliced(folder.path(), &plan);
    let rewritten = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let run = rewrite(std::slice::from_ref(&file), &plan, &[]);
        (said(&run), run.status.code(), std::fs::read(folder.path().join("out.gcode")).unwrap_or_default())
    };
    let (_, code, out) = rewritten(&text);
    assert_eq!(code, Some(0));
    let wanted = laid(&out);
    let mut numbers = Numbers::seeded(3);
    for turn in [0.0, 90.0, 180.0, -33.7, 12.34, 0.8, -121.9] {
        let shift = [0.0; 2].map(|_| numbers.between(-300.0, 300.0));
        let (told, code, out) = rewritten(&transformed(&text, [1.0; 2], turn, shift));
        assert!(code == Some(0) && states(&told, "moved | slicer"), "{turn}: {told}");
        let out = laid(&out);
        assert_eq!(out.len(), wanted.len());
        for (a, b) in out.iter().zip(&wanted) {
            let apart = (0..2).map(|i| (a.0[i] - b.0[i]).norm()).fold(0.0, f64::max);
            assert!(apart < 5e-3 && (a.1 - b.1).abs() < 2e-5, "{turn}: {a:?} {b:?}");
        }
    }
    for (scale, turn, why) in [
        ([-1.0, 1.0], 0.0, "the part's mirror image"),
        ([1.0, -1.0], 25.0, "the part's mirror image"),
        ([1.05, 1.05], 40.0, "it is 1.0"),
        ([1.2, 1.0], 10.0, "it is 1.19"),
    ] {
        let (told, code, _) = rewritten(&transformed(&text, scale, turn, [3.0, 4.0]));
        assert!(code == Some(2) && told.contains(why), "{scale:?}, {turn}: {told}");
    }
}
