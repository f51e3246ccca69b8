//! Projects whose volumes are not all parts, as four programs write them: what is printed is what their author sees, or the role is named.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::support::{fails, folder, installed, note, prusa_slicer, said, skip, trunnion};

/// Writes a project: its file, its unit, the volume beside the body, that volume's word, the items.
type Write = fn(&Path, &str, Cuboid, &str, &str);

/// Corners of a box, mm.
type Cuboid = [[f64; 3]; 2];

const BODY: Cuboid = [[0.0, 0.0, 0.0], [40.0, 20.0, 10.0]];

/// The vertices and triangles of boxes, each facing outward.
fn mesh(boxes: &[Cuboid]) -> String {
    const FACETS: [[usize; 3]; 12] = [
        [0, 2, 1],
        [0, 3, 2],
        [4, 5, 6],
        [4, 6, 7],
        [0, 1, 5],
        [0, 5, 4],
        [1, 2, 6],
        [1, 6, 5],
        [2, 3, 7],
        [2, 7, 6],
        [3, 0, 4],
        [3, 4, 7],
    ];
    let (mut vertices, mut triangles) = (String::new(), String::new());
    for (number, [a, b]) in boxes.iter().enumerate() {
        for z in [a[2], b[2]] {
            for [x, y] in [[a[0], a[1]], [b[0], a[1]], [b[0], b[1]], [a[0], b[1]]] {
                vertices += &format!("<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
            }
        }
        for [p, q, r] in FACETS.map(|facet| facet.map(|v| v + 8 * number)) {
            triangles += &format!("<triangle v1=\"{p}\" v2=\"{q}\" v3=\"{r}\"/>");
        }
    }
    format!("<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>")
}

/// A package of these resources, items and files beside.
fn package(path: &Path, unit: &str, resources: &str, items: &str, beside: &[(&str, String)]) {
    // PrusaSlicer reads its own projects alone so.
    let own = beside.iter().any(|(name, _)| name.contains("Slic3r"));
    let own = if own {
        "<metadata name=\"slic3rpe:Version3mf\">1</metadata><metadata name=\"Application\">PrusaSlicer-2.5.0</metadata>"
    } else {
        ""
    };
    let model = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?><model unit=\"{unit}\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
         xmlns:cura=\"http://software.ultimaker.com/xml/cura/3mf/2015/10\" \
         xmlns:slic3rpe=\"http://schemas.slic3r.org/3mf/2017/06\">{own}<resources>{resources}</resources><build>{items}</build></model>"
    );
    let types = "<?xml version=\"1.0\"?><Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"><Default Extension=\"rels\" \
                 ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/><Default Extension=\"model\" \
                 ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>";
    let relations = "<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship \
                     Target=\"/3D/3dmodel.model\" Id=\"r0\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    let mut file = zip::ZipWriter::new(std::fs::File::create(path).unwrap());
    let all =
        [("[Content_Types].xml", types.to_owned()), ("_rels/.rels", relations.to_owned()), ("3D/3dmodel.model", model)];
    for (name, text) in all.iter().chain(beside) {
        file.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        file.write_all(text.as_bytes()).unwrap();
    }
    file.finish().unwrap();
}

/// What a volume beside the body is for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    Part,
    Negative,
    Modifier,
    Blocker,
    Enforcer,
}

/// A program's way to write a project: a body and another volume, placed by `items`.
type Program = (&'static str, Write);

/// PrusaSlicer: one mesh, its volumes by stretches of triangles.
fn prusa(path: &Path, unit: &str, other: Cuboid, word: &str, items: &str) {
    let volume = |first: usize, word: &str| {
        format!(
            "<volume firstid=\"{first}\" lastid=\"{}\"><metadata type=\"volume\" key=\"name\" value=\"the {word}\"/><metadata type=\"volume\" \
             key=\"volume_type\" value=\"{word}\"/></volume>",
            first + 11
        )
    };
    let configuration = format!(
        "<?xml version=\"1.0\"?><config><object id=\"3\" instances_count=\"1\">{}{}</object></config>",
        volume(0, "ModelPart"),
        volume(12, word)
    );
    let resources = format!("<object id=\"3\" type=\"model\">{}</object>", mesh(&[BODY, other]));
    package(path, unit, &resources, items, &[("Metadata/Slic3r_PE_model.config", configuration)]);
}

/// Bambu Studio and OrcaSlicer: one object of two components.
fn bambu(path: &Path, unit: &str, other: Cuboid, word: &str, items: &str) {
    let configuration = format!(
        "<?xml version=\"1.0\"?><config><object id=\"3\"><metadata key=\"name\" value=\"all\"/><part id=\"1\" subtype=\"normal_part\"><metadata \
         key=\"name\" value=\"body\"/></part><part id=\"2\" subtype=\"{word}\"><metadata key=\"name\" value=\"the {word}\"/></part></object></config>"
    );
    let resources = format!(
        "<object id=\"1\" type=\"model\">{}</object><object id=\"2\" type=\"model\">{}</object><object id=\"3\" type=\"model\"><components><component \
         objectid=\"1\"/><component objectid=\"2\"/></components></object>",
        mesh(&[BODY]),
        mesh(&[other])
    );
    package(path, unit, &resources, items, &[("Metadata/model_settings.config", configuration)]);
}

/// Cura: an object of its own, with a setting in its metadata.
fn cura(path: &Path, unit: &str, other: Cuboid, word: &str, items: &str) {
    let group = format!(
        "<metadatagroup><metadata name=\"cura:drop_to_buildplate\" type=\"xs:boolean\">True</metadata><metadata name=\"{word}\" \
         type=\"xs:boolean\">True</metadata></metadatagroup>"
    );
    let resources = format!(
        "<object id=\"1\" type=\"model\">{}</object><object id=\"2\" type=\"model\" name=\"the {word}\">{group}{}</object><object id=\"3\" \
         type=\"model\"><components><component objectid=\"1\"/><component objectid=\"2\"/></components></object>",
        mesh(&[BODY]),
        mesh(&[other])
    );
    package(path, unit, &resources, items, &[]);
}

/// 3MF core: an object's type.
fn core(path: &Path, unit: &str, other: Cuboid, word: &str, items: &str) {
    let resources = format!(
        "<object id=\"1\" type=\"model\">{}</object><object id=\"2\" type=\"{word}\" name=\"the {word}\">{}</object><object id=\"3\" \
         type=\"model\"><components><component objectid=\"1\"/><component objectid=\"2\"/></components></object>",
        mesh(&[BODY]),
        mesh(&[other])
    );
    package(path, unit, &resources, items, &[]);
}

fn inspected(path: &Path) -> Result<(f64, String), String> {
    let run = trunnion().arg("inspect").arg(path).arg("--json").output().unwrap();
    if !run.status.success() {
        return Err(said(&run));
    }
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    let parts = report["parts"].as_array().unwrap();
    Ok((parts.iter().map(|part| part["volume_mm3"].as_f64().unwrap()).sum(), report["warnings"].to_string()))
}

/// What both boxes fill, mm3.
fn common(other: Cuboid) -> f64 {
    (0..3).map(|i| (BODY[1][i].min(other[1][i]) - BODY[0][i].max(other[0][i])).max(0.0)).product()
}

#[test]
fn what_is_printed_is_what_the_author_sees() {
    let folder = folder();
    let programs: [(Program, &[(&str, Role)]); 4] = [
        (
            ("PrusaSlicer", prusa),
            &[
                ("ModelPart", Role::Part),
                ("NegativeVolume", Role::Negative),
                ("ParameterModifier", Role::Modifier),
                ("SupportBlocker", Role::Blocker),
                ("SupportEnforcer", Role::Enforcer),
            ],
        ),
        (
            ("Bambu Studio", bambu),
            &[
                ("normal_part", Role::Part),
                ("negative_part", Role::Negative),
                ("modifier_part", Role::Modifier),
                ("support_blocker", Role::Blocker),
                ("support_enforcer", Role::Enforcer),
            ],
        ),
        (("Cura", cura), &[("cura:anti_overhang_mesh", Role::Blocker), ("cura:infill_mesh", Role::Modifier)]),
        (("3MF", core), &[("model", Role::Part), ("support", Role::Enforcer), ("other", Role::Modifier)]),
    ];
    // A notch, an end cut off, one through all, one that stands on it, one beside it, one within.
    let others: [Cuboid; 6] = [
        [[30.0, 5.0, 0.0], [40.0, 15.0, 10.0]],
        [[30.0, -1.0, -1.0], [41.0, 21.0, 11.0]],
        [[18.0, -1.0, -1.0], [22.0, 21.0, 11.0]],
        [[0.0, 0.0, 10.0], [40.0, 20.0, 14.0]],
        [[50.0, 0.0, 0.0], [70.0, 20.0, 10.0]],
        [[10.0, 5.0, 2.0], [20.0, 15.0, 8.0]],
    ];
    let items = [
        "<item objectid=\"3\"/>",
        "<item objectid=\"3\" printable=\"1\"/><item objectid=\"3\" transform=\"0 1 0 -1 0 0 0 0 1 200 0 0\"/>",
    ];
    let mut count = 0;
    for ((program, write), words) in programs {
        for (word, role) in words {
            for (index, other) in others.iter().enumerate() {
                for (item, unit) in items.iter().zip(["millimeter", "inch"]) {
                    let path = folder.path().join("project.3mf");
                    write(&path, unit, *other, word, item);
                    let own: f64 = (0..3).map(|i| other[1][i] - other[0][i]).product();
                    let each = match role {
                        // Below the table they are cut off, and without a slicer's word they are two parts in one place.
                        Role::Part if index == 1 || index == 2 => continue,
                        Role::Part if program == "3MF" && common(*other) > 0.0 => continue,
                        Role::Part => 8000.0 + own - common(*other),
                        Role::Negative => 8000.0 - common(*other),
                        _ => 8000.0,
                    };
                    let (instances, mm) = if unit == "inch" { (2.0, 25.4_f64.powi(3)) } else { (1.0, 1.0) };
                    let what = format!("{program}, {word}, volume {index}, {unit}");
                    let (volume, warnings) = inspected(&path).unwrap_or_else(|error| panic!("{what}: {error}"));
                    let wanted = each * instances * mm;
                    assert!((volume / wanted - 1.0).abs() < 1e-6, "{what}: {volume} mm3, wanted {wanted}");
                    let silent = *role == Role::Part && common(*other) == 0.0;
                    assert_eq!(warnings.contains(word), !silent, "{what}: {warnings}");
                    count += 1;
                }
            }
        }
    }
    note(&format!("{count} projects in the forms of four programs"));
    assert!(count > 100, "{count}");
}

/// A file, and words of its refusal.
fn refused(path: &Path, words: &str) {
    let error = inspected(path).map(|(volume, _)| volume).unwrap_err();
    assert!(fails(&error, words), "{error}");
}

#[test]
fn what_is_not_known_or_leaves_nothing_is_refused_by_name() {
    let folder = folder();
    let path = folder.path().join("project.3mf");
    let one = "<item objectid=\"3\"/>";
    let notch = [[30.0, 5.0, 0.0], [40.0, 15.0, 10.0]];
    prusa(&path, "millimeter", notch, "FuzzySkin", one);
    refused(&path, "mesh/role: the FuzzySkin | \"FuzzySkin\"");
    bambu(&path, "millimeter", notch, "magic_part", one);
    refused(&path, "mesh/role: the magic_part | \"magic_part\"");
    core(&path, "millimeter", notch, "ghost", one);
    refused(&path, "mesh/role: \"ghost\"");
    // All of it is cut away.
    prusa(&path, "millimeter", [[-1.0; 3], [50.0; 3]], "NegativeVolume", one);
    refused(&path, "assembly/nothing: the NegativeVolume");
    // Nothing is placed that is printed.
    prusa(&path, "millimeter", notch, "ModelPart", "<item objectid=\"3\" printable=\"0\"/>");
    refused(&path, "mesh/nothing-printed");
    let alone = format!("<object id=\"3\" type=\"support\" name=\"a prop\">{}</object>", mesh(&[BODY]));
    package(&path, "millimeter", &alone, one, &[]);
    refused(&path, "mesh/nothing-printed: a prop | support");
    // Whatever else of the project is ignored is not why.
    let pauses = "<c><layer top_z=\"5\"/></c>".to_owned();
    package(&path, "millimeter", &alone, one, &[("Metadata/custom_gcode_per_layer.xml", pauses)]);
    refused(&path, "mesh/nothing-printed: a prop | support");
    // What says so is broken.
    let whole = format!("<object id=\"3\" type=\"model\">{}</object>", mesh(&[BODY]));
    for (name, text) in [
        (
            "Metadata/Slic3r_PE_model.config",
            "<config><object id=\"3\"><volume firstid=\"0\" lastid=\"many\"/></object></config>",
        ),
        ("Metadata/model_settings.config", "<config><object id=\"3\"></part></config>"),
        (
            "Metadata/Slic3r_PE_model.config",
            "<config><object id=\"3\"><volume firstid=\"0\" lastid=\"6\"><metadata key=\"modifier\" value=\"1\"/></volume><volume firstid=\"6\" \
             lastid=\"11\"><metadata key=\"modifier\" value=\"1\"/></volume></object></config>",
        ),
    ] {
        package(&path, "millimeter", &whole, one, &[(name, text.to_owned())]);
        let error = inspected(&path).unwrap_err();
        assert!(error.contains("error[mesh/") && error.contains(name), "{error}");
    }
    // Negative volumes and modifiers of triangles, objects and components that are not there: nobody knows what was meant.
    let volume = |first: usize, last: usize| {
        format!(
            "<volume firstid=\"{first}\" lastid=\"{last}\"><metadata key=\"volume_type\" value=\"NegativeVolume\"/></volume>"
        )
    };
    let of = |object: u32, volume: &str| format!("<config><object id=\"{object}\">{volume}</object></config>");
    let prusa = "Metadata/Slic3r_PE_model.config";
    let bambu = "Metadata/model_settings.config";
    let component = "<part id=\"7\" subtype=\"negative_part\"></part>";
    for (name, text, words) in [
        (prusa, of(3, &volume(6, 99_999_999_999)), "mesh/object: object 3 | triangles"),
        (prusa, of(3, &volume(6, 5)), "mesh/object: object 3 | before its first"),
        (prusa, of(8, &volume(0, 5)), "mesh/object: object 8"),
        (bambu, of(3, component), "mesh/object: object 3"),
        (bambu, of(8, component), "mesh/object: object 8"),
        (prusa, String::new(), "mesh/xml: config | ends before"),
        (prusa, of(3, &volume(0, 5)).replace("</object></config>", ""), "mesh/xml: ends before"),
        (bambu, "<html><body>404</body></html>".to_owned(), "mesh/syntax: config | `html`"),
        (bambu, "<config>\u{fffd}".replace('\u{fffd}', ""), "mesh/xml: ends before"),
    ] {
        package(&path, "millimeter", &whole, one, &[(name, text)]);
        refused(&path, words);
    }
    // Names in a package are the same in capitals; a volume that is a part may be missing.
    package(&path, "millimeter", &whole, one, &[("metadata/SLIC3R_PE_MODEL.config", of(3, &volume(6, 99)))]);
    refused(&path, "mesh/object: object 3 | triangles");
    package(&path, "millimeter", &whole, one, &[(bambu, of(8, "<part id=\"7\" subtype=\"normal_part\"/>"))]);
    assert!((inspected(&path).unwrap().0 - 8000.0).abs() < 1e-6);
}

/// Filament that PrusaSlicer lays for a project, full, mm3.
fn laid_by_prusa(project: &Path, output: PathBuf) -> f64 {
    let full = [
        "--fill-density",
        "100%",
        "--fill-pattern",
        "rectilinear",
        "--skirts",
        "0",
        "--brim-width",
        "0",
        "--perimeters",
        "2",
        "--first-layer-height",
        "0.2",
        "--layer-height",
        "0.2",
    ];
    let run = prusa_slicer().arg(project).arg("-g").args(full).arg("-o").arg(&output).output().unwrap();
    let text = std::fs::read_to_string(output).unwrap_or_else(|_| panic!("{}", said(&run)));
    let line = text.lines().find_map(|line| line.strip_prefix("; filament used [cm3] = ")).unwrap();
    1000.0 * line.trim().parse::<f64>().unwrap()
}

#[test]
fn prusa_slicer_lays_as_much() {
    if !installed("prusa-slicer") {
        return skip("prusa-slicer is not installed: its own projects are not held against it");
    }
    let folder = folder();
    let path = folder.path().join("project.3mf");
    let item = "<item objectid=\"3\" transform=\"1 0 0 0 1 0 0 0 1 100 100 0\"/>";
    for (word, other) in [
        ("NegativeVolume", [[30.0, 5.0, 0.0], [40.0, 15.0, 10.0]]),
        ("NegativeVolume", [[30.0, -1.0, -1.0], [41.0, 21.0, 11.0]]),
        ("ParameterModifier", [[10.0, 5.0, 0.0], [20.0, 15.0, 10.0]]),
        ("SupportBlocker", [[50.0, 0.0, 0.0], [70.0, 20.0, 10.0]]),
        ("ModelPart", [[50.0, 0.0, 0.0], [70.0, 20.0, 10.0]]),
    ] {
        prusa(&path, "millimeter", other, word, item);
        let (own, _) = inspected(&path).unwrap();
        let laid = laid_by_prusa(&path, folder.path().join("prusa.gcode"));
        note(&format!("{word}: {own:.0} mm3 here, {laid:.0} mm3 laid by PrusaSlicer"));
        assert!((laid / own - 1.0).abs() < 0.03, "{word}: {own} mm3, PrusaSlicer lays {laid}");
    }
}

/// A plate's number and name, and what lies on it: objects, and which item of each.
type Plate<'a> = (u32, &'a str, &'a [(u32, usize)]);

/// A Bambu Studio project: two objects, the second one twice, on the plates that list them; each item 100 mm further.
fn on_plates(path: &Path, plates: &[Plate<'_>]) {
    let plate = |(number, name, items): &Plate<'_>| {
        let item = |(object, which): &(u32, usize)| {
            format!(
                "<model_instance><metadata key=\"object_id\" value=\"{object}\"/><metadata key=\"instance_id\" value=\"{which}\"/><metadata \
                 key=\"identify_id\" value=\"99\"/></model_instance>"
            )
        };
        let items: String = items.iter().map(item).collect();
        format!(
            "<plate><metadata key=\"plater_id\" value=\"{number}\"/><metadata key=\"plater_name\" value=\"{name}\"/>{items}</plate>"
        )
    };
    let plates: String = plates.iter().map(plate).collect();
    let (large, small) = (mesh(&[BODY]), mesh(&[[[0.0; 3], [10.0; 3]]]));
    let resources = format!(
        "<object id=\"1\" type=\"model\" name=\"large\">{large}</object><object id=\"2\" type=\"model\" name=\"small\">{small}</object>"
    );
    let at = |id: u32, x: u32| format!("<item objectid=\"{id}\" transform=\"1 0 0 0 1 0 0 0 1 {x} 0 0\"/>");
    let items = at(1, 0) + &at(2, 100) + &at(2, 200);
    package(
        path,
        "millimeter",
        &resources,
        &items,
        &[("Metadata/model_settings.config", format!("<config>{plates}</config>"))],
    );
}

#[test]
fn a_plate_of_a_project_is_printed_as_it_is_and_several_are_asked_for() {
    let folder = folder();
    let path = folder.path().join("project.3mf");
    let volume = |plate: &str| {
        let run = trunnion().args(["inspect", "--json", "--plate", plate]).arg(&path).output().unwrap();
        let report: Value = serde_json::from_slice(&run.stdout).unwrap();
        let parts = report["parts"]
            .as_array()
            .map(|parts| parts.iter().map(|p| p["volume_mm3"].as_f64().unwrap()).sum::<f64>());
        parts.ok_or_else(|| said(&run))
    };
    on_plates(&path, &[(1, "base", &[(1, 0), (2, 1)]), (2, "", &[(2, 0)]), (3, "empty", &[])]);
    assert!((volume("1").unwrap() - 9000.0_f64).abs() < 1e-6);
    assert!((volume("2").unwrap() - 1000.0_f64).abs() < 1e-6);
    let none = volume("3").unwrap_err();
    assert!(fails(&none, "mesh/no-such-plate: plate 3 | 2 plates: 1 (base, 2 objects), 2 (1 object)"), "{none}");
    // All of them where they are only looked at, with a word about it; the main job asks.
    let (all, warnings) = inspected(&path).unwrap();
    assert!((all - 10_000.0).abs() < 1e-6 && warnings.contains("2 plates"), "{warnings}");
    let output = folder.path().join("out.gcode");
    let prepare = |rest: &[&str]| {
        let args = ["-m", "generic-ac", "--slicer", "builtin", "--json", "-o"];
        trunnion().arg("prepare").arg(&path).args(args).arg(&output).args(rest).output().unwrap()
    };
    let asked = said(&prepare(&[]));
    assert!(fails(&asked, "mesh/several-plates: --plate N | --plates DIR"), "{asked}");
    // What was made of a plate is proved anew from the disk: the plan's model is that plate.
    let done = prepare(&["--plate", "2", "--plan-out", folder.path().join("plan.json").to_str().unwrap()]);
    assert!(done.status.success(), "{}", said(&done));
    let again =
        trunnion().arg("verify").arg(&output).arg("--plan").arg(folder.path().join("plan.json")).output().unwrap();
    assert!(again.status.success(), "{}", said(&again));
    let document: Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(document["plan"]["parts"].as_array().unwrap().len(), 1);
}

#[test]
fn what_lies_on_no_plate_is_left_out_and_said_and_one_plate_needs_no_word() {
    let folder = folder();
    let path = folder.path().join("project.3mf");
    on_plates(&path, &[(1, "", &[(1, 0)])]);
    let (volume, warnings) = inspected(&path).unwrap();
    assert!((volume - 8000.0).abs() < 1e-6 && warnings.contains("no plate"), "{warnings}");
    // Plates on which nothing lies say nothing of what is there.
    on_plates(&path, &[(1, "", &[]), (2, "", &[(7, 0)])]);
    assert!((inspected(&path).unwrap().0 - 10_000.0).abs() < 1e-6);
    on_plates(&path, &[]);
    assert!((inspected(&path).unwrap().0 - 10_000.0).abs() < 1e-6);
    let run = trunnion().args(["inspect", "--plate", "1"]).arg(&path).output().unwrap();
    assert!(fails(&said(&run), "mesh/no-plates: --plate"), "{}", said(&run));
    let broken = "<config><plate><metadata key=\"plater_id\" value=\"one\"/></plate></config>".to_owned();
    let whole = format!("<object id=\"3\" type=\"model\">{}</object>", mesh(&[BODY]));
    package(&path, "millimeter", &whole, "<item objectid=\"3\"/>", &[("Metadata/model_settings.config", broken)]);
    refused(&path, "mesh/syntax: plater_id");
}

#[test]
fn paint_is_told_by_what_it_is() {
    let folder = folder();
    let path = folder.path().join("painted.3mf");
    for (paint, words) in [
        ("slic3rpe:custom_supports=\"4\"", "has painted supports"),
        ("paint_supports=\"8\"", "has painted supports"),
        ("slic3rpe:custom_seam=\"4\"", "has a painted seam"),
        ("paint_seam=\"4\"", "has a painted seam"),
        ("slic3rpe:mmu_segmentation=\"8\"", "has painted colours"),
        ("paint_color=\"8\"", "has painted colours"),
        ("paint_fuzzy_skin=\"4\"", "has painted fuzzy skin"),
        ("paint_supports=\"\"", ""),
        ("pid=\"1\" p1=\"0\"", ""),
    ] {
        let painted = mesh(&[BODY]).replacen("v3=\"1\"/>", &format!("v3=\"1\" {paint}/>"), 1);
        assert!(painted.contains(paint));
        let whole = format!("<object id=\"3\" type=\"model\" name=\"knob\">{painted}</object>");
        package(&path, "millimeter", &whole, "<item objectid=\"3\"/>", &[]);
        let (volume, warnings) = inspected(&path).unwrap();
        let told = if words.is_empty() { "[]".to_owned() } else { format!("knob {words}") };
        assert!((volume - 8000.0).abs() < 1e-6 && warnings.contains(&told), "{paint}: {warnings}");
    }
}

/// What a slicer's window shows as one solid is one; a second part inside the first is no cavity.
#[test]
fn parts_of_an_object_that_overlap_are_one_solid() {
    let folder = folder();
    let path = folder.path().join("project.3mf");
    let one = "<item objectid=\"3\" transform=\"1 0 0 0 1 0 0 0 1 20 30 0\"/><item objectid=\"3\" transform=\"1 0 0 0 1 0 0 0 1 90 30 0\"/>";
    for (other, union, parts) in [
        // Inside, flush with the top, flush with the bottom, proud, across, apart, and touching as any assembly.
        ([[10.0, 5.0, 2.0], [20.0, 15.0, 6.0]], 8000.0, 1),
        ([[10.0, 5.0, 6.0], [20.0, 15.0, 10.0]], 8000.0, 1),
        ([[10.0, 5.0, 0.0], [20.0, 15.0, 3.0]], 8000.0, 1),
        ([[10.0, 5.0, 6.0], [20.0, 15.0, 12.0]], 8200.0, 1),
        ([[10.0, -5.0, 2.0], [20.0, 25.0, 6.0]], 8400.0, 1),
        ([[60.0, 0.0, 0.0], [65.0, 10.0, 10.0]], 8500.0, 2),
        ([[10.0, 5.0, 10.0], [20.0, 15.0, 12.0]], 8200.0, 2),
    ] {
        for (make, word) in [(prusa as Write, "ModelPart"), (bambu, "normal_part")] {
            make(&path, "millimeter", other, word, one);
            let run = trunnion().arg("inspect").arg(&path).arg("--json").output().unwrap();
            let report: Value = serde_json::from_slice(&run.stdout).unwrap_or_else(|_| panic!("{}", said(&run)));
            let all = report["parts"].as_array().unwrap();
            let volume: f64 = all.iter().map(|part| part["volume_mm3"].as_f64().unwrap()).sum();
            assert!((volume - 2.0 * union).abs() < 1e-3 && all.len() == 2 * parts, "{word} {other:?}: {report}");
        }
    }
}

/// A body below the table of its project is cut there, as its slicer does; elsewhere a model's height means nothing.
#[test]
fn what_is_sunk_into_the_table_of_a_project_is_cut_off_there() {
    let folder = folder();
    let path = folder.path().join("project.3mf");
    let item = |z: f64| format!("<item objectid=\"3\" transform=\"1 0 0 0 1 0 0 0 1 9 9 {z}\"/>");
    let apart = [[60.0, 0.0, 0.0], [70.0, 10.0, 10.0]];
    for (make, word) in [(prusa as Write, "ModelPart"), (bambu, "normal_part")] {
        for (unit, mm) in [("millimeter", 1.0), ("inch", 25.4)] {
            for (z, left) in [(0.0, 1.0), (-1e-4, 1.0), (-3.0, 0.7), (-9.5, 0.05), (4.0, 1.0)] {
                make(&path, unit, apart, word, &item(z));
                let (volume, warnings) = inspected(&path).unwrap();
                let expected = 9000.0 * left * mm * mm * mm;
                assert!((volume - expected).abs() < 1e-6 * expected, "{word} {z}: {volume} {expected}");
                assert_eq!(warnings.contains("sunk"), left < 1.0, "{warnings}");
            }
            make(&path, unit, apart, word, &item(-10.0));
            refused(&path, "mesh/below");
        }
    }
    // What stands beside is as it was.
    bambu(&path, "millimeter", apart, "normal_part", &(item(0.0) + &item(-5.0).replace(" 9 9 ", " 200 9 ")));
    assert!((inspected(&path).unwrap().0 - 13_500.0).abs() < 1e-6);
    // No slicer's project.
    core(&path, "millimeter", apart, "model", &item(-3.0));
    assert!((inspected(&path).unwrap().0 - 9000.0).abs() < 1e-6);
}

/// What changes a print and is not obeyed is said by name.
#[test]
fn what_is_ignored_of_a_project_is_said() {
    let folder = folder();
    let path = folder.path().join("project.3mf");
    let whole = format!("<object id=\"3\" type=\"model\">{}</object>", mesh(&[BODY]));
    let one = "<item objectid=\"3\"/>";
    let setting = |key: &str, value: &str| {
        format!(
            "<config><object id=\"3\"><metadata type=\"object\" key=\"name\" value=\"Lid\"/><metadata key=\"{key}\" value=\"{value}\"/></object></config>"
        )
    };
    for (name, text, words) in [
        (
            "Metadata/Prusa_Slicer_custom_gcode_per_print_z.xml",
            "<c><code print_z=\"5\"/></c>".to_owned(),
            "pauses and filament changes",
        ),
        (
            "Metadata/custom_gcode_per_layer.xml",
            "<c><layer top_z=\"5\"/></c>".to_owned(),
            "pauses and filament changes",
        ),
        ("Metadata/Prusa_Slicer_layer_config_ranges.xml", "<o><range min_z=\"0\"/></o>".to_owned(), "certain heights"),
        ("Metadata/layer_heights_profile.txt", "object_id=1|0;0.2".to_owned(), "variable layer heights"),
        ("Metadata/layer_heights_profile.txt", String::new(), ""),
        ("Metadata/custom_gcode_per_layer.xml", "<custom_gcodes_per_layer/>".to_owned(), ""),
        ("Metadata/Slic3r_PE_model.config", setting("fill_density", "80%"), "fill_density = 80%"),
        ("Metadata/Slic3r_PE_model.config", setting("extruder", "2"), "extruder = 2"),
        ("Metadata/Slic3r_PE_model.config", setting("extruder", "1"), ""),
        ("Metadata/Slic3r_PE_model.config", setting("source_file", "lid.stl"), ""),
    ] {
        package(&path, "millimeter", &whole, one, &[(name, text)]);
        let (volume, warnings) = inspected(&path).unwrap();
        assert!((volume - 8000.0).abs() < 1e-6, "{name}");
        assert!(if words.is_empty() { warnings == "[]" } else { warnings.contains(words) }, "{name}: {warnings}");
    }
    // A negative volume that meets nothing, and one that leaves nothing of one of two parts.
    prusa(&path, "millimeter", [[60.0, 0.0, 0.0], [70.0, 10.0, 10.0]], "NegativeVolume", one);
    let (volume, warnings) = inspected(&path).unwrap();
    assert!((volume - 8000.0).abs() < 1e-6 && warnings.contains("removes nothing"), "{warnings}");
    // Settings that are lost, where a program always writes some.
    let bambu = whole.replace("<object", "<metadata name=\"Application\">OrcaSlicer-2.3.0</metadata><object");
    package(&path, "millimeter", &bambu, one, &[]);
    assert!(inspected(&path).unwrap().1.contains("OrcaSlicer-2.3.0 does not say"));
}

/// Roles as older programs note them.
#[test]
fn older_forms_of_roles_are_read() {
    let folder = folder();
    let path = folder.path().join("project.3mf");
    let other = [[0.0, 0.0, 10.0], [10.0, 10.0, 12.0]];
    for (settings, printed) in [
        ("<cura:settings><cura:setting key=\"anti_overhang_mesh\">True</cura:setting></cura:settings>", 8000.0),
        ("<settings><setting key=\"support_mesh\">True</setting></settings>", 8000.0),
        ("<settings><setting key=\"infill_mesh\">False</setting></settings>", 8200.0),
    ] {
        let resources = format!(
            "<object id=\"1\" type=\"model\">{}</object><object id=\"2\" type=\"model\">{settings}{}</object>",
            mesh(&[BODY]),
            mesh(&[other])
        );
        package(&path, "millimeter", &resources, "<item objectid=\"1\"/><item objectid=\"2\"/>", &[]);
        assert!((inspected(&path).unwrap().0 - printed).abs() < 1e-6, "{settings}");
    }
    // They are listed with what they are for, in words and for scripts.
    let blocked = "<cura:settings><cura:setting key=\"anti_overhang_mesh\">True</cura:setting></cura:settings>";
    let resources = format!("<object id=\"2\" type=\"model\" name=\"keep off\">{blocked}{}</object>", mesh(&[other]));
    let resources = format!("<object id=\"1\" type=\"model\">{}</object>{resources}", mesh(&[BODY]));
    package(&path, "millimeter", &resources, "<item objectid=\"1\"/><item objectid=\"2\"/>", &[]);
    let run = trunnion().arg("inspect").arg(&path).arg("--json").output().unwrap();
    let report: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(report["others"], serde_json::json!([{"name": "keep off", "role": "blocker"}]));
    let run = trunnion().arg("inspect").arg(&path).output().unwrap();
    assert!(String::from_utf8_lossy(&run.stdout).contains("keep off (blocker)"));
    for (modifier, printed) in [("1", 8000.0), ("0", 8200.0)] {
        let volumes = format!(
            "<slic3r:volumes><slic3r:volume ts=\"0\" te=\"11\" modifier=\"0\"/><slic3r:volume ts=\"12\" te=\"23\" modifier=\"{modifier}\"/></slic3r:volumes></mesh>"
        );
        let both = mesh(&[BODY, other]).replace("</mesh>", &volumes);
        let resources = format!("<object id=\"3\" type=\"model\" xmlns:slic3r=\"s\">{both}</object>");
        package(&path, "millimeter", &resources, "<item objectid=\"3\"/>", &[]);
        assert!((inspected(&path).unwrap().0 - printed).abs() < 1e-6, "modifier {modifier}");
    }
}
