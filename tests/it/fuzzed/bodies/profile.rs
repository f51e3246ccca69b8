//! Bytes as a machine's profile, and as the configuration of its firmware.

use trunnion::job::{Answers, ImportProfile, MachineSource, Source, check_profile, import_profile};
use trunnion::profile::{Base, Profile, resolve};

use super::choice;
use super::shelf::Shelf;

/// What stands before the name of each further file.
const NEXT: &str = "\n=== ";

/// An even first byte: a profile; an odd one: up to four files of a firmware, the second and later ones behind a line `=== NAME`.
pub(super) fn profile(data: &[u8]) {
    let Some((how, bytes)) = choice(data) else { return };
    if how % 2 == 0 { own(bytes) } else { imported(bytes, how / 2 % 2 == 0) }
}

fn own(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let _ = Base::of("any.toml", text);
    match resolve("any.toml", text) {
        Ok((profile, _)) => sound(&profile),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// What passes every check is a machine.
fn sound(profile: &Profile) {
    profile.validate().expect("what was resolved is valid");
    assert_eq!(profile.canonical(), profile.clone().canonical());
    let shelf = Shelf::empty();
    let checked = check_profile(&MachineSource::from(profile.clone()), &shelf.world()).expect("it was valid");
    assert_eq!(checked.machine.profile, *profile);
    let figures = checked.tilts.iter().flat_map(|tilted| [tilted.top_mm, tilted.room_mm, tilted.tilt_deg]);
    let figures = figures.chain(checked.largest_level_mm).chain([checked.half_mm, checked.largest_any_mm]);
    assert!(figures.chain([checked.sweeps_to_mm]).all(f64::is_finite), "a figure that is none");
    let text = checked.machine.annotated().expect("it has words for all");
    let (again, _) = resolve("again.toml", &text).expect("what is shown is read again");
    assert_eq!(again, *profile, "another profile is read than was shown");
    let (limits, slab) = (profile.linear_limits(), profile.table_slab());
    assert!(slab.iter().flatten().chain(limits.min.iter()).chain(limits.max.iter()).all(|v| v.is_finite()));
    let _ = (profile.trace_setting(), profile.head_bodies(), profile.fixed_bodies());
}

fn imported(bytes: &[u8], rest: bool) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let mut files = text.splitn(4, NEXT).enumerate().map(|(index, file)| match index {
        0 => ("first.cfg", file),
        _ => file.split_once('\n').unwrap_or((file, "")),
    });
    let Some((first, text)) = files.next() else { return };
    let shelf = Shelf(files.map(|(name, text)| (name.into(), text.as_bytes().to_vec())).collect());
    let source = Source::Bytes { name: first.to_owned(), bytes: text.as_bytes().to_vec() };
    // Marlin's two files are given both; what others name is looked for.
    let beside = shelf.0.iter().filter(|(name, _)| name.to_string_lossy().ends_with(".h"));
    let beside =
        beside.map(|(name, bytes)| Source::Bytes { name: name.to_string_lossy().into(), bytes: bytes.clone() });
    let request = ImportProfile {
        files: std::iter::once(source).chain(beside).collect(),
        name: Some("any".to_owned()),
        like: None,
        answers: Answers { file: None, set: Vec::new(), rest },
    };
    match import_profile(&request, &shelf.world()) {
        Ok(done) => {
            done.profile.validate().expect("what was imported is valid");
            assert!(done.facts.iter().all(|fact| !fact.from.is_empty()), "a fact without a line");
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}
