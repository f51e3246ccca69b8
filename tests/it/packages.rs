//! What packages install: completions and manual pages name every verb and flag, and every file that the Debian package lists is made or there.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::support::{folder, installed, root, said, skip};

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
    typed_in_fish(&folder.path().join("completions/trunnion.fish"));
    typed_in_zsh(&folder.path().join("completions"));
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
        skip("bash is not installed (its completions)");
        return;
    }
    assert_eq!(asked("trunnion prep", 1), BTreeSet::from(["prepare".to_owned()]));
    assert_eq!(asked("trunnion profile che", 2), BTreeSet::from(["check".to_owned()]));
    assert!(asked("trunnion plan --ove", 2).contains("--overhang"));
    assert!(asked("trunnion plan --slots o", 3).contains("only-single"));
}

/// What is typed before the tabulator, and what stands there after it.
const TYPED: [(&str, &str); 4] = [
    ("trunnion prep", "trunnion prepare"),
    ("trunnion profile che", "trunnion profile check"),
    ("trunnion plan --ove", "trunnion plan --overhang"),
    ("trunnion plan --slots on", "trunnion plan --slots only-single"),
];

fn typed_in_fish(script: &Path) {
    if !installed("fish") {
        return skip("fish is not installed (its completions)");
    }
    for (typed, wanted) in TYPED {
        let text = format!("source {}; complete -C '{typed}'", script.display());
        let run = Command::new("fish").args(["--no-config", "-c", &text]).output().unwrap();
        let found = String::from_utf8_lossy(&run.stdout).into_owned();
        // A line each: the last word whole, a tabulator, and what it is.
        let found: Vec<&str> = found.lines().map(|line| line.split('\t').next().unwrap()).collect();
        assert_eq!(found, [wanted.rsplit(' ').next().unwrap()], "{typed}: {}", said(&run));
    }
}

/// A zsh of its own behind a pseudo-terminal: each word line, the tabulator, then Ctrl-A and a colon, so that nothing is carried out.
const IN_ZSH: &str = r#"
zmodload zsh/zpty
zpty t TERM=dumb zsh -f -i
zpty -w t "fpath=($1 \$fpath); autoload -Uz compinit; compinit -u -D; echo rea''dy"
zpty -r t out '*ready*'
shift
for words in "$@"; do
  zpty -w -n t "$words"$'\t\C-a: \n'
  sleep 0.5
done
zpty -w t "echo do''ne"
zpty -r t out '*done*'
print -r -- "$out"
zpty -d t
"#;

fn typed_in_zsh(completions: &Path) {
    if !installed("zsh") {
        return skip("zsh is not installed (its completions)");
    }
    let typed = TYPED.map(|(typed, _)| typed);
    let run = Command::new("zsh").args(["-f", "-c", IN_ZSH, "zsh"]).arg(completions).args(typed).output().unwrap();
    let screen = String::from_utf8_lossy(&run.stdout).into_owned();
    for (typed, wanted) in TYPED {
        assert!(screen.contains(&format!(": {wanted}")), "{typed}: {}", said(&run));
    }
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

/// The package as `cargo deb` lays it out, built by Debian's own tool from the same list, unpacked and run.
#[test]
fn the_debian_package_installs_a_command_that_runs() {
    if Command::new("dpkg-deb").arg("--version").output().is_err() {
        return skip("dpkg-deb is not installed (the Debian package)");
    }
    let (folder, all) = made();
    let text = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let manifest: toml::Value = toml::from_str(&text).unwrap();
    let package = &manifest["package"];
    let place = folder.path().join("deb");
    let put = |from: &Path, into: &str, mode: &str| {
        let into = place.join(into);
        let to = if into.to_str().unwrap().ends_with('/') { into.join(from.file_name().unwrap()) } else { into };
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        let done = Command::new("install").args(["-m", mode]).arg(from).arg(&to).output().unwrap();
        assert!(done.status.success(), "{}", said(&done));
    };
    for asset in package["metadata"]["deb"]["assets"].as_array().unwrap() {
        let [source, into, mode] = [0, 1, 2].map(|i| asset[i].as_str().unwrap());
        if source == "target/release/trunnion" {
            put(Path::new(env!("CARGO_BIN_EXE_trunnion")), into, mode);
            continue;
        }
        let own = source.strip_prefix("target/packages/");
        let pattern = own.map_or_else(|| root().join(source), |own| folder.path().join(own));
        let name = pattern.file_name().unwrap().to_str().unwrap();
        let (before, behind) = name.split_once('*').unwrap_or((name, ""));
        for entry in std::fs::read_dir(pattern.parent().unwrap()).unwrap() {
            let path = entry.unwrap().path();
            let is = path.file_name().unwrap().to_str().unwrap();
            let fits = if name.contains('*') { is.starts_with(before) && is.ends_with(behind) } else { is == name };
            if fits && path.is_file() {
                put(&path, into, mode);
            }
        }
    }
    let (name, version) = (package["name"].as_str().unwrap(), package["version"].as_str().unwrap());
    let architecture = Command::new("dpkg").arg("--print-architecture").output().unwrap();
    let control = format!(
        "Package: {name}\nVersion: {version}\nArchitecture: {}Maintainer: {} <nobody@localhost>\nSection: {}\nDescription: {}\n",
        String::from_utf8_lossy(&architecture.stdout),
        package["metadata"]["deb"]["maintainer"].as_str().unwrap(),
        package["metadata"]["deb"]["section"].as_str().unwrap(),
        package["description"].as_str().unwrap(),
    );
    std::fs::create_dir(place.join("DEBIAN")).unwrap();
    std::fs::write(place.join("DEBIAN/control"), control).unwrap();
    let (deb, unpacked) = (folder.path().join("trunnion.deb"), folder.path().join("unpacked"));
    // Unpacked again at once: no time is spent on making it small.
    let done =
        Command::new("dpkg-deb").args(["-Znone", "--root-owner-group", "--build"]).arg(&place).arg(&deb).output();
    let done = done.unwrap();
    assert!(done.status.success(), "{}", said(&done));
    let done = Command::new("dpkg-deb").arg("-x").arg(&deb).arg(&unpacked).output().unwrap();
    assert!(done.status.success(), "{}", said(&done));
    let run = Command::new(unpacked.join("usr/bin/trunnion")).arg("--version").output().unwrap();
    assert_eq!(said(&run).trim(), format!("trunnion {version}"));
    for (verb, _) in &all {
        assert!(unpacked.join(format!("usr/share/man/man1/{verb}.1")).is_file(), "{verb}");
    }
    for file in [
        "bash-completion/completions/trunnion",
        "zsh/vendor-completions/_trunnion",
        "doc/trunnion/docs/schemas/plan.json",
    ] {
        assert!(unpacked.join("usr/share").join(file).is_file(), "{file}");
    }
}
