//! `profile check`: a machine explained, drawn, or refused.

use quick_xml::events::Event;

use trunnion::job::{Answers, NewProfile, QUESTIONS, Silent, World, new_profile};

use crate::support::{folder, said, trunnion};

#[test]
fn a_machine_is_explained_and_drawn_from_its_side() {
    let folder = folder();
    let picture = folder.path().join("side.svg");
    let own = folder.path().join("mine.toml");
    std::fs::write(&own, "extends = \"generic-ac\"\n[machine]\nname = \"a <b> & \\\"c\\\"\"\n").unwrap();
    let run = trunnion().args(["profile", "check"]).arg(&own).arg("--view").arg(&picture).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    for words in [
        "A0.00: the middle of the table comes to X 0 Y 0 Z 0, its highest point to Z 0.0; the tip may go 320.0 mm above that",
        "on the bare table the head reaches all of it",
        "A90.00: the middle of the table comes to X 0 Y -20 Z -20, its highest point to Z 80.1",
        "no place straight up or down from its middle",
        "largest object on the level table: 196.0 mm across, 315.0 mm high",
        "sweeps up to Z 100.4",
    ] {
        assert!(said(&run).contains(words), "{words}: {}", said(&run));
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
        (cone, 1, "one bare cone"),
        ("[kinematics]\npivot_mm = [0.0, 900.0, 0.0]\n", 1, "the tip reaches no place"),
        (
            "[kinematics.tilt]\nmin_deg = 5.0\n",
            2,
            "mine.toml:2: kinematics.tilt.min_deg = 5..90 is out of a range that holds level",
        ),
        ("[dialect]\nfirmware = \"marlni\"\n", 2, "is marlin meant?"),
    ] {
        std::fs::write(&own, text).unwrap();
        let run = trunnion().args(["profile", "check"]).arg(&own).output().unwrap();
        assert_eq!(run.status.code(), Some(code), "{text}: {}", said(&run));
        assert!(said(&run).contains(words), "{text}: {}", said(&run));
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
    assert!(row("broken", "error").contains("unknown key"), "{rows}");
    assert!(row("generic-ac", "error").contains("rename the file"), "{rows}");
    assert!(said(&listed).contains("warning: "), "{}", said(&listed));
    let near = run("XDG_CONFIG_HOME", &config, &["show", "mien"]);
    assert_eq!(near.status.code(), Some(2));
    assert!(said(&near).contains("did you mean \"mine\"?"), "{}", said(&near));
    assert!(said(&near).contains("your own are: base, broken"), "{}", said(&near));
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
    let words = "not answered: dialect.firmware, kinematics.tilt.letter";
    assert!(said(&untold).contains(words) && !said(&untold).contains("max_deg,"), "{}", said(&untold));
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
    assert!(
        text.starts_with("# mine: described by trunnion profile new") && text.contains("# Not answered, so as there: "),
        "{text}"
    );
    assert!(
        text.contains("The head ([[head.body]]) is that one's too") && text.contains("# Stops, as words."),
        "{text}"
    );
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
    assert!(again.status.code() == Some(2) && said(&again).contains("is not written over"), "{}", said(&again));
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    for (args, words) in [
        (&["new", "fibr3d", "--keep-rest"][..], "none of the shipped profiles'"),
        (&["new", "../x", "--keep-rest"], "made of letters"),
        (&["new", "x", "--keep-rest", "--set", "limits.x"], "give KEY=VALUE"),
        (&["new", "x", "--keep-rest", "--set", "limits.x_m=[0,1]"], "did you mean \"limits.x_mm\"?"),
        (
            &["new", "x", "--keep-rest", "--set", "limits.x_mm=[0,99999]"],
            "limits.x_mm = 99999 is out of -10000..10000 mm",
        ),
        (&["new", "x", "--keep-rest", "--set", "dialect.firmware=marlni"], "is marlin meant?"),
        (&["new", "x", "--keep-rest", "--set", "a b=1"], "names with dots between"),
    ] {
        let run = run(args);
        assert!(run.status.code() == Some(2) && said(&run).contains(words), "{args:?}: {}", said(&run));
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
    let lines = "U\nY\n-10\n\nV\n[-50, 50]\n\n\n35\n\n\n0.6\n";
    request.ask(lines.as_bytes(), |key, _| asked.borrow_mut().push(key.to_owned()), &world).unwrap();
    assert_eq!(*asked.borrow(), QUESTIONS[1..].iter().map(|(key, _)| *key).collect::<Vec<_>>());
    let made = new_profile(&request, &world).unwrap();
    let tilt = &made.profile.kinematics.tilt;
    assert_eq!((tilt.letter, tilt.min_deg, tilt.max_deg), ('U', -10.0, 90.0));
    assert_eq!((made.profile.table.radius_mm, made.profile.process.nozzle_mm), (35.0, 0.6));
    assert_eq!(made.unanswered.len(), 5);
    let error = request.clone().ask("".as_bytes(), |_, _| {}, &world).unwrap_err();
    assert!(error.to_string().contains("nothing was written"), "{error}");
}
