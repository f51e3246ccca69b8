//! `profile check`: a machine explained, drawn, or refused.

use quick_xml::events::Event;

use trunnion::job::{Answers, NewProfile, QUESTIONS, Silent, World, new_profile};
use trunnion::profile::{BodySpec, HEAD_QUESTIONS, Profile};

use crate::support::{coded, fails, folder, said, states, trunnion};

#[test]
fn a_machine_is_explained_and_drawn_from_its_side() {
    let folder = folder();
    let picture = folder.path().join("side.svg");
    let own = folder.path().join("mine.toml");
    std::fs::write(&own, "extends = \"generic-ac\"\n[machine]\nname = \"a <b> & \\\"c\\\"\"\n").unwrap();
    let run = trunnion().args(["profile", "check"]).arg(&own).arg("--view").arg(&picture).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    for facts in [
        "A0.00 | X 0 Y 0 Z 0 | Z 0.0 | 320.0 mm",
        "A90.00 | X 0 Y -20 Z -20 | Z 80.1 | 239.9 mm",
        "largest | 196.0 mm | 315.0 mm",
        "Z 100.4",
    ] {
        assert!(states(&said(&run), facts), "{facts}: {}", said(&run));
    }
    let svg = std::fs::read_to_string(&picture).unwrap();
    let mut reader = quick_xml::Reader::from_str(&svg);
    let mut texts = 0;
    loop {
        match reader.read_event().unwrap() {
            Event::Start(tag) if tag.name().as_ref() == "text" => texts += 1,
            Event::Eof => break,
            _ => {}
        }
    }
    // The table three times and the four pieces of the head; angles, axis, legend, and what is across.
    assert_eq!((svg.matches("fill-opacity").count(), texts), (7, 9), "{svg}");
    assert!(svg.contains("a &lt;b&gt; &amp; &quot;c&quot;") && svg.contains("tilt axis, Y0 Z-20"), "{svg}");

    let json = trunnion().args(["profile", "check", "fibr3d", "--json"]).output().unwrap();
    let document: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(
        (&document["ok"], &document["table"][0]["tilt_deg"]),
        (&serde_json::json!(true), &serde_json::json!(0.0))
    );
    // At the far end of its tilt the middle is below the axes.
    assert_eq!(document["largest_at_every_tilt_mm"], 0.0);
}

#[test]
fn what_no_print_can_be_made_with_is_refused() {
    let folder = folder();
    let own = folder.path().join("mine.toml");
    let cone =
        "[head]\nbody = [{ name = \"n\", moves = \"XYZ\", kind = \"frustum\", z_mm = [0, 60], r_mm = [0.5, 8] }]\n";
    for (text, code, words) in [
        (cone, 1, "command/no: mine.toml | bare_cone = true"),
        ("[kinematics]\npivot_mm = [0.0, 900.0, 0.0]\n", 1, "command/no: mine.toml | X 0 Y 900 Z 20 | pivot_mm"),
        (
            "[kinematics.tilt]\nmin_deg = 5.0\n",
            2,
            "profile/range: mine.toml:2 | kinematics.tilt.min_deg | 5..90 | zero_deg",
        ),
        ("[dialect]\nfirmware = \"marlni\"\n", 2, "profile/range: mine.toml:2 | dialect.firmware | marlni | marlin"),
    ] {
        std::fs::write(&own, text).unwrap();
        let run = trunnion().args(["profile", "check"]).arg(&own).output().unwrap();
        assert_eq!(run.status.code(), Some(code), "{text}: {}", said(&run));
        assert!(fails(&said(&run), words), "{text}: {}", said(&run));
    }
}

#[test]
fn own_profiles_are_found_by_their_names() {
    let folder = folder();
    let own = folder.path().join("config/trunnion/profiles");
    std::fs::create_dir_all(&own).unwrap();
    std::fs::write(own.join("mine.toml"), "extends = \"base\"\n[table]\nradius_mm = 90.0\n").unwrap();
    std::fs::write(own.join("base.toml"), "extends = \"fibr3d\"\n[machine]\nname = \"base\"\nabout = \"mine\"\n")
        .unwrap();
    std::fs::write(own.join("broken.toml"), "[tabel]\n").unwrap();
    std::fs::write(own.join("generic-ac.toml"), "").unwrap();
    let run = |key: &str, value: &str, args: &[&str]| {
        let mut command = trunnion();
        command.env_remove("XDG_CONFIG_HOME").env_remove("HOME").env(key, value).current_dir(folder.path());
        command.arg("profile").args(args).output().unwrap()
    };
    let config = folder.path().join("config").display().to_string();
    let shown = run("XDG_CONFIG_HOME", &config, &["show", "mine", "--json"]);
    let shown: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    assert_eq!((&shown["table"]["radius_mm"], &shown["kinematics"]["tilt"]["letter"]), (&90.0.into(), &"B".into()));
    let listed = run("XDG_CONFIG_HOME", &config, &["list", "--json"]);
    let rows: serde_json::Value = serde_json::from_slice(&listed.stdout).unwrap();
    let row = |name: &str, key: &str| {
        let rows = rows.as_array().unwrap().iter().filter(|row| row["name"] == name && !row[key].is_null());
        rows.map(|row| row[key].to_string()).collect::<String>()
    };
    assert!(row("base", "file").contains("base.toml") && row("mine", "about").contains("mine"), "{rows}");
    assert!(states(&row("broken", "error"), "tabel"), "{rows}");
    assert!(states(&row("generic-ac", "error"), "generic-ac.toml | generic-ac"), "{rows}");
    assert!(said(&listed).contains("warning: "), "{}", said(&listed));
    let near = run("XDG_CONFIG_HOME", &config, &["show", "mien"]);
    assert_eq!(near.status.code(), Some(2));
    assert!(fails(&said(&near), "profile/no-such-profile: \"mien\" | \"mine\""), "{}", said(&near));
    assert!(said(&near).contains("base, broken"), "{}", said(&near));
    // A relative folder is none, and ~/.config stands in for it.
    assert_eq!(run("XDG_CONFIG_HOME", "config", &["show", "mine"]).status.code(), Some(2));
    std::fs::rename(folder.path().join("config"), folder.path().join(".config")).unwrap();
    let home = folder.path().display().to_string();
    assert!(run("HOME", &home, &["check", "mine"]).status.success());
}

#[test]
fn a_machine_is_described_by_answers() {
    let folder = folder();
    let run = |args: &[&str]| {
        let mut command = trunnion();
        command.env("XDG_CONFIG_HOME", folder.path()).current_dir(folder.path()).stdin(std::process::Stdio::null());
        command.args(["profile"]).args(args).output().unwrap()
    };
    let untold = run(&["new", "mine", "--set", "kinematics.tilt.max_deg=60"]);
    assert_eq!(untold.status.code(), Some(2));
    let keys = "job/unanswered: dialect.firmware, kinematics.tilt.letter";
    assert!(fails(&said(&untold), keys) && !said(&untold).contains("max_deg,"), "{}", said(&untold));
    std::fs::write(
        folder.path().join("answers.toml"),
        "[limits]\nx_mm = [-90, 90]\n[kinematics.tilt]\nletter = \"B\"\n",
    )
    .unwrap();
    let made = [
        "new",
        "mine",
        "--set",
        "kinematics.tilt.about=Y",
        "--set",
        "limits.y_mm=[0, 200.5]",
        "--answers",
        "answers.toml",
        "--keep-rest",
    ];
    let done = run(&made);
    assert!(done.status.success(), "{}", said(&done));
    let file = folder.path().join("trunnion/profiles/mine.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.starts_with("# mine: ") && states(&text, "# | dialect.firmware | table.radius_mm"), "{text}");
    assert!(states(&text, "# | [[head.body]]") && text.contains("# Stops"), "{text}");
    let shown = run(&["show", "mine", "--json"]);
    let shown: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    assert_eq!(
        (&shown["limits"]["x_mm"], &shown["limits"]["y_mm"]),
        (&serde_json::json!([-90.0, 90.0]), &serde_json::json!([0.0, 200.5]))
    );
    assert_eq!((&shown["kinematics"]["tilt"]["letter"], &shown["machine"]["name"]), (&"B".into(), &"mine".into()));
    assert!(run(&["check", "mine"]).status.success());
    // It is not written over, and what is wrong is said as of any profile.
    let again = run(&made);
    assert!(again.status.code() == Some(2) && fails(&said(&again), "job/there: mine.toml"), "{}", said(&again));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    for (args, words) in [
        (&["new", "fibr3d", "--keep-rest"][..], "job/answer: fibr3d"),
        (&["new", "../x", "--keep-rest"], "job/answer: ../x"),
        (&["new", "x", "--keep-rest", "--set", "limits.x"], "command/usage: 'limits.x' | KEY=VALUE"),
        (
            &["new", "x", "--keep-rest", "--set", "limits.x_m=[0,1]"],
            "profile/unknown-key: \"limits.x_m\" | \"limits.x_mm\"",
        ),
        (
            &["new", "x", "--keep-rest", "--set", "limits.x_mm=[0,99999]"],
            "profile/range: limits.x_mm | 99999 | -10000..10000 mm",
        ),
        (
            &["new", "x", "--keep-rest", "--set", "dialect.firmware=marlni"],
            "profile/range: dialect.firmware | marlni | marlin",
        ),
        (&["new", "x", "--keep-rest", "--set", "a b=1"], "job/answer: a b=1 | kinematics.tilt.max_deg"),
    ] {
        let run = run(args);
        assert!(run.status.code() == Some(2) && fails(&said(&run), words), "{args:?}: {}", said(&run));
    }
    assert!(!folder.path().join("trunnion/profiles/x.toml").exists());
}

#[test]
fn questions_are_asked_one_by_one() {
    let world = World::here(&Silent);
    let mut request = NewProfile {
        name: "mine".to_owned(),
        base: "generic-ac".into(),
        answers: Answers {
            set: vec![("dialect.firmware".to_owned(), "reprapfirmware".to_owned())],
            ..Answers::default()
        },
    };
    let asked = std::cell::RefCell::new(Vec::new());
    let lines = "U\nY\n-10\n\nV\n[-50, 50]\n\n\n35\n\n\n0.6\n\n[7, 6]\n[12, 13, 14, 15]\n\n\n\nYZ\n\n[40, 60]\n";
    request.ask(lines.as_bytes(), |key, _| asked.borrow_mut().push(key.to_owned()), &world).unwrap();
    let all = QUESTIONS[1..].iter().chain(&HEAD_QUESTIONS);
    assert_eq!(*asked.borrow(), all.map(|(key, _)| *key).collect::<Vec<_>>());
    let made = new_profile(&request, &world).unwrap();
    let tilt = &made.profile.kinematics.tilt;
    assert_eq!((tilt.letter, tilt.min_deg, tilt.max_deg), ('U', -10.0, 90.0));
    assert_eq!((made.profile.table.radius_mm, made.profile.process.nozzle_mm), (35.0, 0.6));
    assert_eq!(made.unanswered.len(), 10);
    let pieces: Vec<_> =
        made.profile.head.body.iter().map(|b| (b.name.as_str(), b.z_mm, b.r_mm, b.min_mm, b.max_mm)).collect();
    let wanted = [
        ("nozzle", Some([0.0, 7.0]), Some([0.5, 3.0]), None, None),
        // What is between the cone and the block is as wide as the cone's end.
        ("nozzle's shaft", Some([7.0, 10.0]), Some([3.0, 3.0]), None, None),
        ("block", None, None, Some([-12.0, -14.0, 10.0]), Some([13.0, 15.0, 65.0])),
        ("carriage", None, None, Some([-25.0, -12.0, 65.0]), Some([25.0, 22.0, 110.0])),
        // As long as this machine's X, and 100 mm more on either side.
        ("gantry", None, None, Some([-150.0, 14.0, 40.0]), Some([150.0, 22.0, 60.0])),
    ];
    assert_eq!(pieces, wanted);
    let error = request.clone().ask("".as_bytes(), |_, _| {}, &world).unwrap_err();
    assert!(error.code() == "job/answer" && states(&error.to_string(), "kinematics.tilt.max_deg"), "{error}");
}

/// The machine of `--set KEY=VALUE`, all else as in `like`.
fn described(like: &str, set: &[(&str, &str)]) -> Result<Profile, String> {
    let set = set.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let answers = Answers { set, rest: true, ..Answers::default() };
    let request = NewProfile { name: "mine".to_owned(), base: like.into(), answers };
    new_profile(&request, &World::here(&Silent)).map(|made| made.profile).map_err(|error| coded(error.code(), &error))
}

#[test]
fn a_head_is_measured_by_callipers() {
    let of = |like: &str, name: &str, set: &[(&str, &str)]| -> Option<BodySpec> {
        let made = described(like, set).unwrap_or_else(|e| panic!("{set:?}: {e}"));
        made.head.body.into_iter().find(|body| body.name == name)
    };
    let ends = |body: Option<BodySpec>| body.map(|body| (body.moves, body.min_mm.unwrap(), body.max_mm.unwrap()));
    // Only what is measured changes.
    let block = of("generic-ac", "block", &[("head.block_z_mm", "[12, 40.5]")]);
    assert_eq!(ends(block), Some(("XYZ".to_owned(), [-10.0, -10.0, 12.0], [10.0, 10.0, 40.5])));
    let nozzle = of("generic-ac", "nozzle", &[("head.nozzle_tip_mm", "1.25")]).unwrap();
    assert_eq!((nozzle.z_mm, nozzle.r_mm), (Some([0.0, 10.0]), Some([0.625, 8.0])));
    // FIBR3D's beam lies along Y, and is as long as its Y goes and more.
    let beam = of("fibr3d", "gantry", &[("head.gantry_mm", "[-30, -12]")]);
    assert_eq!(ends(beam), Some(("XZ".to_owned(), [-30.0, -377.0, 40.0], [-12.0, 343.0, 65.0])));
    assert_eq!(ends(of("fibr3d", "gantry", &[("head.gantry_moves", "none")])), None);
    let turned = [
        ("head.gantry_moves", "YZ"),
        ("head.gantry_mm", "[5, 25]"),
        ("head.gantry_z_mm", "[30, 50]"),
        ("limits.x_mm", "[0, 200]"),
    ];
    assert_eq!(
        ends(of("fibr3d", "gantry", &turned)),
        Some(("YZ".to_owned(), [-100.0, 5.0, 30.0], [300.0, 25.0, 50.0]))
    );
    // Pieces that no measure means stay: the rods of Open5x' Prusa stand where they stood.
    let rods = of("open5x-prusa", "x rods", &[("head.block_mm", "[9, 9, 9, 9]")]);
    assert_eq!(ends(rods), ends(of("open5x-prusa", "x rods", &[])));
    for (like, set, wanted) in [
        ("generic-ac", &[("head.blok_mm", "[1, 2, 3, 4]")][..], "head.blok_mm | \"head.block_mm\""),
        ("generic-ac", &[("head.block_mm", "[1, 2, 3]")], "head.block_mm=[1, 2, 3] | 4 numbers | 0..1000 mm"),
        ("generic-ac", &[("head.block_mm", "[-1, 2, 3, 4]")], "head.block_mm=[-1, 2, 3, 4] | 4 numbers | 0..1000 mm"),
        ("generic-ac", &[("head.block_mm", "[0, 0, 3, 4]")], "head.block_mm=[0, 0, 3, 4] | above 0"),
        ("generic-ac", &[("head.nozzle_tip_mm", "fine")], "head.nozzle_tip_mm=\"fine\" | 0..1000 mm"),
        ("generic-ac", &[("head.nozzle_tip_mm", "0")], "head.cone_mm | 0 mm | 16 mm | 10 mm"),
        ("generic-ac", &[("head.cone_mm", "[8, 0.5]")], "head.cone_mm=[8, 0.5] | 1 mm | 0.5 mm | 8 mm"),
        ("generic-ac", &[("head.block_z_mm", "[40, 10]")], "head.block_z_mm=[40, 10] | swapped"),
        ("generic-ac", &[("head.gantry_moves", "Y")], "head.gantry_moves=\"Y\" | YZ, XZ or none"),
        (
            "generic-ac",
            &[("head.gantry_moves", "none"), ("head.gantry_z_mm", "[1, 2]")],
            "head.gantry_moves=\"none\" | gantry_z_mm",
        ),
        ("generic-ac", &[("head.gantry_moves", "XZ")], "head.gantry_moves, head.gantry_mm, head.gantry_z_mm | --like"),
        ("fibr3d", &[("head.carriage_mm", "[1, 2, 3, 4]")], "head.carriage_mm, head.carriage_z_mm | --like"),
        ("generic-ac", &[("head.cone_mm", "[8, 6]"), ("head.body", "[]")], "head.body | measures"),
    ] {
        let said = described(like, set).expect_err(wanted);
        assert!(fails(&said, &format!("job/answer: {wanted}")), "{set:?}: {said}");
    }
}

/// A profile whose head nobody measured is refused by `check`, and passes once callipers were at it.
#[test]
fn a_bare_cone_becomes_a_measured_head() {
    let folder = folder();
    let bare = folder.path().join("bare.toml");
    let cone = "body = [{ name = \"n\", moves = \"XYZ\", kind = \"frustum\", z_mm = [0, 10], r_mm = [0.5, 8] }]";
    std::fs::write(&bare, format!("[head]\n{cone}\n")).unwrap();
    let check = |file: &str| trunnion().current_dir(folder.path()).args(["profile", "check", file]).output().unwrap();
    let refused = check("bare.toml");
    assert!(
        refused.status.code() == Some(1) && fails(&said(&refused), "command/no: bare.toml | bare_cone = true"),
        "{}",
        said(&refused)
    );
    std::fs::write(
        folder.path().join("head.toml"),
        "[head]\nnozzle_tip_mm = 1\ncone_mm = [3.5, 7]\nblock_mm = [16, 11, 9, 12]\nblock_z_mm = [3.5, 45]\ncarriage_mm = [30, 30, 25, 20]\n\
         carriage_z_mm = [45, 100]\ngantry_moves = \"YZ\"\ngantry_mm = [20, 40]\ngantry_z_mm = [60, 85]\n",
    )
    .unwrap();
    let new = |more: &[&str]| {
        let mut command = trunnion();
        command.current_dir(folder.path()).stdin(std::process::Stdio::null());
        command.args(["profile", "new", "mine", "--like", "bare.toml", "--keep-rest"]).args(more).output().unwrap()
    };
    let made = new(&["--answers", "head.toml", "-o", "mine.toml"]);
    assert!(made.status.success(), "{}", said(&made));
    let text = std::fs::read_to_string(folder.path().join("mine.toml")).unwrap();
    assert!(!states(&text, "# | [[head.body]]") && !text.contains("head.block_mm"), "{text}");
    assert!(check("mine.toml").status.success(), "{}", said(&check("mine.toml")));
    // Half of it measured is said.
    let half = new(&["--set", "head.cone_mm=[3.5, 7]", "-o", "half.toml"]);
    assert!(half.status.success(), "{}", said(&half));
    let text = std::fs::read_to_string(folder.path().join("half.toml")).unwrap();
    assert!(text.lines().take(4).any(|l| l.starts_with('#') && l.contains("head.block_mm")), "{text}");
    assert_eq!(check("half.toml").status.code(), Some(1));
}
