//! Bytes as a program: line by line, replayed with each firmware's meaning, read as a slicer's file, and taken apart for the wire.

use trunnion::gcode::settings::{Settings, config_values};
use trunnion::gcode::{ParsedLine, PlainMove, lines};
use trunnion::link::{Abilities, Program, ProgramRules, Protocol};
use trunnion::profile::Profile;
use trunnion::toolpath::{InputWords, read_sliced};
use trunnion::trace::{Trace, read, totals};

use super::{choice, chosen};

/// The first byte chooses the machine.
pub(super) fn gcode(data: &[u8]) {
    let Some((machine, program)) = choice(data) else { return };
    let profile = chosen(machine);
    let mut parsed = ParsedLine::default();
    let mut count = 0;
    for line in lines(program) {
        count = line.number;
        if parsed.read(line.bytes).is_ok() {
            assert!(
                parsed.code.end <= line.bytes.len() && parsed.comment.end <= line.bytes.len(),
                "a span leaves its line"
            );
            assert!(parsed.words.iter().filter_map(|word| word.value).all(f64::is_finite), "a word without a number");
        }
        let _ = PlainMove::read(line.bytes);
    }
    let setting = profile.trace_setting();
    let trace = read(program, &setting);
    assert_eq!(trace.lines, count, "lines");
    finite(&trace);
    // Both promise the same clock.
    let all = totals(program, &setting);
    assert_eq!(all.seconds.to_bits(), trace.seconds.to_bits(), "two clocks: {} and {}", all.seconds, trace.seconds);
    let _ = (Settings::of(program).heights_mm(), config_values(program));
    let words = InputWords { firmware: profile.firmware(), allow: &profile.dialect.allow, supports: machine >= 128 };
    for segment in read_sliced(program, "any.gcode", words).into_iter().flatten() {
        let sliced = &segment.sliced;
        assert!(!sliced.layers.is_empty() && sliced.layers.iter().all(|layer| layer.z.is_finite()), "layers");
        assert!(sliced.filament_mm.is_finite(), "filament");
    }
    sent(program, profile);
}

/// What every reader of a trace may rely on.
pub(super) fn finite(trace: &Trace) {
    assert!(trace.seconds.is_finite() && trace.seconds >= 0.0, "{} s", trace.seconds);
    for m in trace.moves() {
        let known = m.to.iter().chain(&m.from).flatten().chain(&m.width).chain(&m.height).chain(&m.feed);
        assert!(known.copied().all(f64::is_finite), "{m:?}");
        assert!(m.e.is_finite() && m.seconds.is_finite() && m.seconds >= 0.0, "{m:?}");
    }
}

/// The same bytes on their way to the printer.
fn sent(bytes: &[u8], profile: &Profile) {
    let Some(protocol) = Protocol::named(&profile.link.protocol) else { return };
    let longest_line = profile.link.longest_line as usize;
    let Ok(program) = Program::read(bytes, &ProgramRules { protocol, longest_line, setting: profile.trace_setting() })
    else {
        return;
    };
    assert!(program.seconds_print().is_finite(), "{} s", program.seconds_print());
    for index in 0..program.len() {
        let block = program.block(index);
        assert!(!block.is_empty() && block.len() <= longest_line && !block.contains(&b'\n'), "block {index}");
        assert!(program.seconds(index).is_finite() && program.seconds(index) >= 0.0, "block {index}");
    }
    let table = profile.kinematics();
    let limits = profile.linear_limits();
    let axes = [table.tilt, table.rotation];
    let (max_nozzle_c, max_bed_c) = (profile.link.max_nozzle_c, profile.link.max_bed_c);
    if let Some(unfit) = (Abilities { limits, axes, max_nozzle_c, max_bed_c }).lacking(&program) {
        assert!(!unfit.to_string().is_empty());
    }
}
