//! What packages install: completions and manual pages name every verb and flag, and every file that the Debian package lists is made or there.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::folder;

#[path = "../../examples/packages.rs"]
#[allow(dead_code, reason = "the program's own main")]
mod program;

/// The verbs below `command`, each with its words joined by dashes, as manual pages are called.
fn verbs(command: &clap::Command, name: &str, all: &mut Vec<(String, clap::Command)>) {
    for verb in command.get_subcommands().filter(|verb| verb.get_name() != "help") {
        let name = format!("{name}-{}", verb.get_name());
        verbs(verb, &name, all);
        all.push((name, verb.clone()));
    }
}

/// The long flags that people are told of.
fn flags(verb: &clap::Command) -> impl Iterator<Item = &str> {
    verb.get_arguments().filter(|flag| !flag.is_hide_set()).filter_map(clap::Arg::get_long)
}

fn made() -> (tempfile::TempDir, Vec<(String, clap::Command)>) {
    let (folder, mut all) = (folder(), Vec::new());
    program::write(folder.path()).unwrap();
    verbs(&trunnion::cli::command(), "trunnion", &mut all);
    assert!(all.len() > 18, "{}", all.len());
    (folder, all)
}

#[test]
fn each_verb_has_a_page_with_all_its_flags() {
    let (folder, all) = made();
    for (name, verb) in &all {
        let page = std::fs::read_to_string(folder.path().join(format!("man/{name}.1"))).unwrap();
        let page = page.replace("\\-", "-");
        for flag in flags(verb) {
            assert!(page.contains(&format!("--{flag}")), "{name}: --{flag}");
        }
    }
}

#[test]
fn shells_complete_verbs_and_flags() {
    let (folder, all) = made();
    let file = |name: &str| std::fs::read_to_string(folder.path().join("completions").join(name)).unwrap();
    let (zsh, fish) = (file("_trunnion"), file("trunnion.fish"));
    for (name, verb) in &all {
        for flag in flags(verb) {
            assert!(zsh.contains(&format!("--{flag}")) && fish.contains(&format!("-l {flag}")), "{name}: --{flag}");
        }
    }
    let script = folder.path().join("completions/trunnion.bash");
    let asked = |words: &str, last: usize| -> BTreeSet<String> {
        let text = format!(
            "source {}; COMP_WORDS=({words}); COMP_CWORD={last}; _trunnion trunnion \"${{COMP_WORDS[{last}]}}\" \"${{COMP_WORDS[{}]}}\"; \
             printf '%s\\n' \"${{COMPREPLY[@]}}\"",
            script.display(),
            last - 1
        );
        let run = Command::new("bash").args(["-c", &text]).output().unwrap();
        String::from_utf8(run.stdout).unwrap().lines().map(str::to_owned).collect()
    };
    if Command::new("bash").arg("--version").output().is_err() {
        println!("SKIPPED: bash is not installed (its completions)");
        return;
    }
    assert_eq!(asked("trunnion prep", 1), BTreeSet::from(["prepare".to_owned()]));
    assert_eq!(asked("trunnion profile che", 2), BTreeSet::from(["check".to_owned()]));
    assert!(asked("trunnion plan --ove", 2).contains("--overhang"));
    assert!(asked("trunnion plan --slots o", 3).contains("only-single"));
}

/// The files that match `pattern` below the repository: a star stands for a part of the last name.
fn matching(pattern: &str) -> usize {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(pattern);
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    let Some((before, behind)) = name.split_once('*') else { return usize::from(path.is_file()) };
    let there = std::fs::read_dir(path.parent().unwrap()).unwrap().map(|entry| entry.unwrap().file_name());
    there.filter(|one| one.to_string_lossy().starts_with(before) && one.to_string_lossy().ends_with(behind)).count()
}

#[test]
fn every_file_of_the_debian_package_is_made_or_there() {
    let (folder, all) = made();
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).unwrap();
    let manifest: toml::Value = toml::from_str(&text).unwrap();
    let assets = manifest["package"]["metadata"]["deb"]["assets"].as_array().unwrap();
    let sources: Vec<&str> = assets.iter().map(|asset| asset[0].as_str().unwrap()).collect();
    for source in &sources {
        match source.strip_prefix("target/packages/") {
            Some("man/*.1") => {
                let pages = std::fs::read_dir(folder.path().join("man")).unwrap().count();
                assert_eq!(pages, all.len() + 1);
            }
            Some(file) => assert!(folder.path().join(PathBuf::from(file)).is_file(), "{source}"),
            None if *source == "target/release/trunnion" => {}
            None => assert!(matching(source) > 0, "{source}"),
        }
    }
    for made in ["target/release/trunnion", "target/packages/man/*.1", "target/packages/completions/trunnion.bash"] {
        assert!(sources.contains(&made), "{made}");
    }
}
