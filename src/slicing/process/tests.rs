//! The slicers that are installed, and scripts that pose as slicers and misbehave.

use super::*;
use crate::geom::Vec3;
use crate::slicing::Adhesion;
use crate::slicing::testing::{block, extrusion_box, extrusions, layer_heights};

#[test]
fn lists_of_processors_are_read() {
    assert_eq!(processors("\t0-2,7\n"), [0, 1, 2, 7]);
    assert_eq!(processors("5"), [5]);
    assert!(processors("").is_empty());
}

fn options(folder: &Path) -> ExternalOptions {
    let (timeout, interrupt) = (Duration::from_secs(120), Interrupt::default());
    ExternalOptions { configs: Vec::new(), timeout, work_dir: folder.to_owned(), interrupt }
}

fn job() -> SliceJob {
    SliceJob { name: "slot01__box".into(), on_table: false, bed_mm: [300.0, 300.0], adhesion: Adhesion::default() }
}

fn cube() -> TriangleMesh<Slot> {
    block([140.0, 140.0, 0.0], [160.0, 160.0, 20.0])
}

/// The installed program, or `None` and a word about it.
fn real(choice: &SlicerChoice, options: &ExternalOptions) -> Option<Box<dyn Slicer>> {
    match find(choice, options) {
        Ok(slicer) => Some(slicer),
        Err(SliceError::NotFound { .. }) => {
            println!("SKIPPED: {choice} is not installed");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// Checks the box, the layers and the neutral first layer of a sliced 20 mm cube.
fn assert_true_to_the_cube(gcode: &[u8], width: f64, layer_um: i64) {
    let lines = extrusions(gcode);
    let (half, top) = (width / 2.0, (20_000 / layer_um * layer_um) as f64 / 1000.0);
    let got = extrusion_box(&lines);
    let low = layer_um as f64 / 1000.0;
    let wanted = [140.0 + half, 140.0 + half, low, 160.0 - half, 160.0 - half, top];
    assert!(got.iter().zip(wanted).all(|(a, b)| (a - b).abs() <= 0.01), "{got:?}, wanted {wanted:?}");
    let heights = layer_heights(&lines);
    assert_eq!(heights, (1..=20_000 / layer_um).map(|k| k * layer_um).collect::<Vec<_>>());
    let longest_wall = |layer: usize| {
        let on_layer = lines.iter().filter(|l| (l.to[2] * 1000.0).round() as i64 == heights[layer]);
        let outer = on_layer.filter(|l| l.from[1] == l.to[1] && (l.to[1] - got[1]).abs() < 0.001);
        let line = outer.max_by(|a, b| a.length().total_cmp(&b.length())).unwrap();
        (line.e / line.length(), line.feed)
    };
    let (first, second) = (longest_wall(0), longest_wall(1));
    assert!((first.0 / second.0 - 1.0).abs() < 0.001 && first.1 == second.1, "{first:?} {second:?}");
}

fn assert_without_start_code(gcode: &[u8]) {
    let text = String::from_utf8_lossy(gcode);
    assert!(!text.lines().any(|l| ["M109", "M190", "M104 S0", "M140 S0"].iter().any(|w| l.starts_with(w))));
    let extrusion = text.lines().position(|l| l.starts_with("G1 X") && l.contains(" E")).unwrap();
    assert!(!text.lines().take(extrusion).any(|l| l.starts_with("M104") || l.starts_with("M140")));
    assert_eq!(crate::slicing::config_values(gcode)["temperature"], "210");
    assert_eq!(crate::slicing::config_values(gcode)["bed_temperature"], "60");
}

#[test]
fn prusaslicer_returns_the_cube_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let Some(slicer) = real(&SlicerChoice::PrusaSlicer, &options(folder.path())) else { return };
    let gcode = slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap().gcode;
    assert_true_to_the_cube(&gcode, 0.45, 200);
    assert_without_start_code(&gcode);
    let text = String::from_utf8_lossy(&gcode);
    assert!(text.contains("; printing object slot01__box.stl id:0 copy 0"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "a run leaves nothing behind");
}

#[test]
fn slic3r_returns_the_cube_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let Some(slicer) = real(&SlicerChoice::Slic3r, &options(folder.path())) else { return };
    let gcode = slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap().gcode;
    assert_true_to_the_cube(&gcode, 0.45, 200);
    assert_without_start_code(&gcode);
}

#[test]
fn the_users_configuration_counts_and_cannot_bring_a_first_layer_back() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("mine.ini");
    let text = "layer_height = 0.25\nextrusion_width = 0.6\nexternal_perimeter_extrusion_width = 0.6\n\
                first_layer_height = 0.35\nskirts = 3\nstart_gcode = G28\nsupport_material = 1\n";
    fs::write(&config, text).unwrap();
    for choice in [SlicerChoice::PrusaSlicer, SlicerChoice::Slic3r] {
        let options = ExternalOptions { configs: vec![config.clone()], ..options(folder.path()) };
        let Some(slicer) = real(&choice, &options) else { continue };
        let gcode = slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap().gcode;
        assert_true_to_the_cube(&gcode, 0.6, 250);
        assert!(!String::from_utf8_lossy(&gcode).lines().any(|l| l.starts_with("G28")));
    }
}

/// A roof upside down: it begins in an edge, 20 mm long, and is 10 mm high.
fn wedge() -> TriangleMesh<Slot> {
    let corners = [[150.0, 0.0], [155.0, 10.0], [145.0, 10.0]];
    let vertices = [140.0, 160.0].iter().flat_map(|&y| corners.map(|[x, z]| Vec3::new(x, y, z))).collect();
    let facets = vec![[0, 1, 2], [3, 5, 4], [0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2], [2, 5, 3], [2, 3, 0]];
    TriangleMesh::new(vertices, facets)
}

#[test]
fn what_begins_in_an_edge_comes_from_the_built_in_slicer_under_the_users_configuration() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("mine.ini");
    fs::write(&config, "layer_height = 0.25\nskirts = 3\n").unwrap();
    let options = ExternalOptions { configs: vec![config], ..options(folder.path()) };
    let Some(slicer) = real(&SlicerChoice::PrusaSlicer, &options) else { return };
    let sliced = slicer.slice(&wedge(), &SliceSettings::default(), &job()).unwrap();
    let told: Vec<String> = sliced.flaws.iter().map(ToString::to_string).collect();
    assert!(told.iter().any(|t| t.contains("of which PrusaSlicer prints no first layer")), "{told:?}");
    let heights = layer_heights(&extrusions(&sliced.gcode));
    assert!(heights.iter().all(|h| h % 250 == 0) && heights.last() == Some(&10_000), "{heights:?}");
    // What it slices itself is its own.
    assert!(slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap().flaws.is_empty());
}

#[test]
fn the_built_in_slicer_takes_a_configuration_and_says_what_it_leaves() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("mine.ini");
    fs::write(&config, "layer_height = 0.25\nraft_layers = 3\n").unwrap();
    let options = ExternalOptions { configs: vec![config], ..options(folder.path()) };
    let slicer = find(&SlicerChoice::BuiltIn, &options).unwrap();
    let sliced = slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap();
    assert_eq!(layer_heights(&extrusions(&sliced.gcode)).first(), Some(&250));
    assert_eq!(slicer.flaws(), [Flaw::Unheeded(vec!["raft_layers".to_owned()])]);
    assert_eq!(slicer.around(&SliceSettings::default()).unwrap().layer_height_mm, 0.25);
}

#[test]
fn on_the_table_only_the_first_layers_speed_differs() {
    let folder = tempfile::tempdir().unwrap();
    let on_table = SliceJob { on_table: true, ..job() };
    for choice in [SlicerChoice::PrusaSlicer, SlicerChoice::Slic3r] {
        let Some(slicer) = real(&choice, &options(folder.path())) else { continue };
        let lines = extrusions(&slicer.slice(&cube(), &SliceSettings::default(), &on_table).unwrap().gcode);
        let first: Vec<_> = lines.iter().filter(|l| l.to[2] < 0.3).collect();
        assert!(first.iter().all(|l| l.feed <= 1200.0), "{choice}");
        assert!((extrusion_box(&lines)[0] - 140.225).abs() < 0.01, "{choice}: no brim, no skirt");
    }
}

#[test]
fn auto_always_finds_a_slicer_and_a_stranger_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let slicer = find(&SlicerChoice::Auto, &options(folder.path())).unwrap();
    assert!(!slicer.version().is_empty());
    let stranger = find(&SlicerChoice::Path("/bin/ls".into()), &options(folder.path()));
    assert!(matches!(stranger, Err(SliceError::NotASlicer { .. })));
    let missing = find(&SlicerChoice::Path("/no/such/slicer".into()), &options(folder.path()));
    assert!(matches!(missing, Err(SliceError::File { action: "start", .. })));
}

/// A program that calls itself PrusaSlicer and then does `body`; `$out` is the output file.
#[cfg(unix)]
fn fake(folder: &Path, body: &str) -> Box<dyn Slicer> {
    fake_until(folder, body, Duration::from_secs(1), Interrupt::default())
}

#[cfg(unix)]
fn fake_until(folder: &Path, body: &str, timeout: Duration, interrupt: Interrupt) -> Box<dyn Slicer> {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.join("fake-slicer");
    let script = format!(
        "#!/bin/sh\nif [ \"$1\" = --help ]; then echo 'PrusaSlicer-2.6.1 based on'; exit 0; fi\n\
         while [ \"$1\" != --output ]; do shift; done\nout=\"$2\"\n{body}\n"
    );
    fs::write(&path, script).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    let options = ExternalOptions { timeout, interrupt, ..options(&folder.join("work")) };
    find(&SlicerChoice::Path(path), &options).unwrap()
}

#[cfg(unix)]
fn refused(body: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let slicer = fake(folder.path(), body);
    assert_eq!(slicer.version(), "2.6.1");
    let error = slicer.slice(&cube(), &SliceSettings::default(), &job()).unwrap_err();
    assert!(error.is_slicer_failure(), "{error}");
    assert_eq!(fs::read_dir(folder.path().join("work")).unwrap().count(), 0);
    error.to_string()
}

#[cfg(unix)]
#[test]
fn a_slicer_that_fails_hangs_or_drops_the_part_is_named() {
    let failed = refused("echo 'half' > \"$out\"; echo 'no layers were detected' >&2; exit 1");
    assert!(failed.contains("exit status: 1") && failed.contains("no layers were detected"), "{failed}");
    assert!(refused("exit 0").contains("wrote no file"));
    assert!(refused(": > \"$out\"").contains("wrote an empty file"));
    assert!(refused("echo 'G1 X1 Y1 F100' > \"$out\"").contains("`slot01__box`"));
}

/// The number that a script wrote into `file`, once it is there whole.
#[cfg(unix)]
fn written(file: &Path) -> String {
    for _ in 0..4000 {
        if let Some(number) = fs::read_to_string(file).ok().filter(|text| text.ends_with('\n')) {
            return number.trim().to_owned();
        }
        thread::sleep(POLL);
    }
    panic!("{} is not written", file.display());
}

/// What is killed ends when the system comes to it, on a busy machine a little later.
#[cfg(unix)]
fn wait_for_its_end(process: &str) {
    (0..4000).take_while(|_| alive(process)).for_each(|_| thread::sleep(POLL));
}

#[cfg(unix)]
fn alive(process: &str) -> bool {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    // Who was killed and has nobody to fetch him is dead.
    !status.is_empty() && !status.contains("State:\tZ")
}

#[cfg(unix)]
#[test]
fn messages_and_files_are_read_within_bounds() {
    let failed = refused("head -c 9000000 /dev/zero | tr '\\0' '\\n' >&2; echo 'no layers' >&2; exit 1");
    assert!(failed.ends_with("no layers"), "{failed}");
    let big = refused("truncate -s 2G \"$out\"; sleep 600");
    assert!(big.contains("wrote 2147483648 bytes") && big.contains("(maximum 1073741824)"), "{big}");
    assert!(refused("mkfifo \"$out\"").contains("wrote no file"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_child_that_keeps_the_streams_open_holds_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let left = folder.path().join("left");
    let failed = refused(&format!("setsid sleep 600 & echo $! > {}; echo 'no layers' >&2; exit 1", left.display()));
    let child = written(&left);
    assert!(failed.ends_with("no layers"), "{failed}");
    assert!(alive(&child), "it was waited for");
    let _ = Command::new("kill").args(["-KILL", &child]).status();
}

#[cfg(unix)]
#[test]
fn a_program_that_says_nothing_is_given_up_when_the_users_time_is() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("silent");
    fs::write(&path, "#!/bin/sh\ntrap '' TERM\nsleep 600\nsleep 600\n").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    let options = ExternalOptions { timeout: Duration::from_millis(300), ..options(&folder.path().join("work")) };
    let Err(error) = find(&SlicerChoice::Path(path), &options) else { panic!("it is none") };
    assert!(error.to_string().contains("did not answer --help within 0.3 s") && error.is_slicer_failure(), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_ends_the_slicer_with_its_children_and_begins_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let [first, child] = ["first", "child"].map(|name| folder.path().join(name));
    let body = format!("sleep 600 & echo $! > {}; echo $$ > {}; wait", child.display(), first.display());
    let interrupt = Interrupt::default();
    // The longest time there is must not be too long for the clock.
    let slicer = fake_until(folder.path(), &body, Duration::MAX, interrupt.clone());
    let slice = || slicer.slice(&cube(), &SliceSettings::default(), &job());
    let ended = thread::scope(|scope| {
        let run = scope.spawn(slice);
        written(&first);
        assert!(interrupt.is_running());
        interrupt.ask();
        run.join().unwrap()
    });
    assert!(matches!(ended, Err(SliceError::Interrupted)), "{ended:?}");
    assert!(!interrupt.is_running());
    let [first, child] = [written(&first), written(&child)];
    [&first, &child].into_iter().for_each(|process| wait_for_its_end(process));
    assert!(!alive(&first) && !alive(&child));
    assert_eq!(fs::read_dir(folder.path().join("work")).unwrap().count(), 0);
    assert!(matches!(slice(), Err(SliceError::Interrupted)));
}

#[cfg(unix)]
#[test]
fn a_slicer_that_hangs_is_stopped_with_its_children() {
    let folder = tempfile::tempdir().unwrap();
    let child = folder.path().join("child");
    // On a busy machine its second may be over before it has a child.
    while !child.exists() {
        let text = refused(&format!("sleep 600 & echo $! > {}; wait", child.display()));
        assert!(text.contains("stopped after 1.0 s"), "{text}");
    }
    let child = written(&child);
    wait_for_its_end(&child);
    assert!(!alive(&child), "the child lives on");
}

#[cfg(target_os = "linux")]
#[test]
fn a_child_in_a_session_of_its_own_ends_with_the_slicer() {
    let folder = tempfile::tempdir().unwrap();
    let left = folder.path().join("left");
    let body = "setsid sh -c 'echo $$ > LEFT; exec sleep 600' & while [ ! -s LEFT ]; do sleep 0.01; done; truncate -s 2G \"$out\"; sleep 600";
    let big = refused(&body.replace("LEFT", &left.display().to_string()));
    assert!(big.contains("(maximum 1073741824)"), "{big}");
    let child = written(&left);
    wait_for_its_end(&child);
    assert!(!alive(&child), "it goes on");
}
