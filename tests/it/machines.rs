//! `profile check`: a machine explained, drawn, or refused.

use quick_xml::events::Event;

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
    let (mut polygons, mut texts) = (0, 0);
    loop {
        match reader.read_event().unwrap() {
            Event::Start(tag) if tag.name().as_ref() == "polygon" => polygons += 1,
            Event::Start(tag) if tag.name().as_ref() == "text" => texts += 1,
            Event::Eof => break,
            _ => {}
        }
    }
    // Where the tip may go, the table three times, the four pieces of the head.
    assert_eq!((polygons, texts), (8, 5), "{svg}");
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
