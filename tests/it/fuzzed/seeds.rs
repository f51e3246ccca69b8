//! What the changes begin with: whole files of each kind, made of the shipped fixtures and profiles, behind the bytes that choose how a
//! target reads them.

use trunnion::job::{self, MachineSource, PlanRequest, Silent, Source, World};
use trunnion::link::{Header, Record};
use trunnion::mesh::{ReadOptions, read_model, threemf};
use trunnion::profile::{SHIPPED, resolve, shipped};

use super::bodies::mesh::XML;
use super::bodies::program::victims;
use super::bodies::rewrite::made;
use crate::imported::{koala, small_ini, small_klipper, small_marlin, small_reprap};
use crate::support::root;

/// The seeds of a target.
pub(super) fn seeds(target: &str) -> Vec<Vec<u8>> {
    match target {
        "config" => config(),
        "gcode" => gcode(),
        "journal" => journal(),
        "mesh" => mesh(),
        "plan" => plan(),
        "profile" => profile(),
        "program" => program(),
        "reply" => reply(),
        "rewrite" => rewrite(),
        _ => Vec::new(),
    }
}

fn behind(choice: &[u8], bytes: impl AsRef<[u8]>) -> Vec<u8> {
    [choice, bytes.as_ref()].concat()
}

/// At most so many bytes, up to a line's end.
fn begin(bytes: &[u8], most: usize) -> &[u8] {
    let end = bytes[..bytes.len().min(most)].iter().rposition(|byte| *byte == b'\n');
    &bytes[..end.map_or(0, |end| end + 1)]
}

/// Words and comments that slices and programs of other people have.
const PROGRAMS: [&str; 4] = [
    "N1 G21*18\n%\nG28\nG90\nM82\nG92 E0\nM104 S210\nM109 S210\nG1 Z5 F9000\n;LAYER_CHANGE\n;TYPE:External perimeter\n;WIDTH:0.45\n;HEIGHT:0.2\n\
     G1 X10 Y10 Z0.2 E.5 F1200\nG2 X20 Y10 I5 J0 E1\nG3 X10 Y10 R5 E2\nG4 P500\nM106 S127\nM204 P800 T1500\nM117 hello\nM84\nM30\n",
    "G21\nG90\nM83\nSET_PRESSURE_ADVANCE ADVANCE=0.05\nEXCLUDE_OBJECT_DEFINE NAME=a CENTER=1,2\nSTART_PRINT EXTRUDER_TEMP=210\n@pause\n\
     G1 A10 C20 F600\nG93\nG1 X1 A20 F60\nG94\nG1 X2 F600\nM400\nG92.1\n",
    "G17 G21 G40 G49 G64 P0.01 G80 G90 G94\nM428\nG0 X0 Y0 Z50\nG2 X0 Y0 I5 P2 F600\nG1 A30 F1000\nG1 C90\nM429\nG53 G0 Z0\n#<_x> = 5\nM2\n",
    "G10 P0 X0 Y0 Z0 S210 R160\nM98 P\"home all.g\"\nM208 U-200:200 X1\nM584 X0 Y1\nM665 L1\nG29 S1\nM572 D0 S0.05\nT0\nM116\n\
     ; layer_height = 0.2\n; first_layer_height = 50%\n; gcode_flavor = reprapfirmware\n;SETTING_3 {\"x\": \"[values]\\\\nlayer_height = 0.3\"}\n",
];

fn gcode() -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<u8>> = PROGRAMS.iter().map(|text| behind(&[0], text)).collect();
    for (number, (_, file, text)) in SHIPPED.iter().enumerate() {
        let dialect = resolve(file, text).unwrap().0.dialect;
        let both = format!("{}\n{}\n{}", dialect.start, PROGRAMS[number % PROGRAMS.len()], dialect.end);
        all.push(behind(&[number as u8], both));
    }
    let generic = SHIPPED.iter().position(|(name, ..)| *name == "generic-ac").unwrap() as u8;
    all.push(behind(&[generic], begin(&made().program, 6000)));
    all.extend(made().slices.iter().map(|slice| behind(&[generic], begin(slice, 4000))));
    all
}

fn rewrite() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for (print, slice) in made().slices.iter().enumerate() {
        let lines = slice.split_inclusive(|byte| *byte == b'\n');
        // Without its sum, or every change would be refused as one.
        let changeable: Vec<u8> = lines.filter(|line| !line.starts_with(b"; crc32 = ")).flatten().copied().collect();
        all.extend([behind(&[print as u8], slice), behind(&[print as u8], changeable)]);
    }
    all.push(behind(&[255], &made().program));
    all
}

/// Without pictures and figures, too, so that changes strike what is printed.
fn program() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for (victim, number) in victims().iter().zip(0..) {
        let lines = victim.program().split_inclusive(|byte| *byte == b'\n');
        let bare: Vec<u8> = lines.filter(|line| !line.starts_with(b"; ")).flatten().copied().collect();
        all.extend([behind(&[number], victim.program()), behind(&[number], bare)]);
    }
    all
}

/// A model in text: a box, as an STL, an OBJ and an OFF.
const TEXTS: [&str; 3] = [
    "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 9 0\nvertex 9 0 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\n\
     vertex 0 0 0\nvertex 9 0 0\nvertex 0 0 9\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 9\nvertex 0 9 0\n\
     endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 9 0 0\nvertex 0 9 0\nvertex 0 0 9\nendloop\nendfacet\nendsolid x\n",
    "# made up\no one\nv 0 0 0\nv 9 0 0 1 0 0\nv 0 9 0\nv 0 0 9\nvt 0 0\nvn 0 0 1\ng a\nusemtl m\ns 1\nf 1/1/1 3/1/1 2/1/1\nf 1 2 4\nf 1// 4// 3//\nf -3 -2 -1\n",
    "OFF\n4 4 6\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n",
];

const MODEL: &str = "<?xml version=\"1.0\"?><model unit=\"millimeter\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\
    <resources><object id=\"1\" type=\"model\" name=\"a\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"9\" y=\"0\" z=\"0\"/>\
    <vertex x=\"0\" y=\"9\" z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"9\"/></vertices><triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\"/>\
    <triangle v1=\"0\" v2=\"1\" v3=\"3\"/><triangle v1=\"0\" v2=\"3\" v3=\"2\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/></triangles></mesh>\
    </object><object id=\"2\"><components><component objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 20 0 0\"/><component objectid=\"1\"/>\
    </components></object></resources><build><item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 0 0 0\"/></build></model>";

fn mesh() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for (number, text) in TEXTS.iter().enumerate() {
        // As it stands, in inches, and mended.
        all.extend([0, 10, 15].map(|how| behind(&[how + number as u8], text)));
    }
    for file in ["two-boxes.stl", "cube.stl"] {
        let bytes = std::fs::read(root().join("fixtures").join(file)).unwrap();
        let model = read_model(&bytes, file, &ReadOptions::default()).unwrap();
        let parts: Vec<_> = model.parts.iter().map(|part| (part.name.clone(), &part.mesh)).collect();
        all.extend([behind(&[3], threemf(&parts)), behind(&[0], &bytes), behind(&[15], bytes)]);
    }
    all.extend([behind(&[XML], MODEL), behind(&[XML + 18], MODEL.replace("millimeter", "inch"))]);
    all
}

fn plan() -> Vec<Vec<u8>> {
    let world = World::here(&Silent);
    let model = || Source::Bytes {
        name: "y-tree.stl".to_owned(),
        bytes: std::fs::read(root().join("fixtures/y-tree.stl")).unwrap(),
    };
    let text = |machine: MachineSource| {
        let mut request = PlanRequest::new(model(), "generic-ac");
        (request.machine, request.options.overhang_deg) = (machine, Some(40.0));
        job::plan(&request, &world).unwrap().plan.plan.to_text()
    };
    let (file, own) = shipped("generic-ac").unwrap();
    let mut own = resolve(file, own).unwrap().0;
    own.machine.name = "own".to_owned();
    let (plain, full) = (text("generic-ac".into()), text(own.into()));
    let supported = plain.replacen(
        "\"rotation_deg\"",
        "\"supports\": {\"step_mm\": 2.0, \"overhang_deg\": 45.0, \"gap_mm\": 0.2},\n\"rotation_deg\"",
        1,
    );
    let supported = supported.replacen("\"version\": 1", "\"version\": 2", 1);
    vec![behind(&[0], &plain), behind(&[3], plain), behind(&[3], full), behind(&[0], supported)]
}

fn profile() -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<u8>> = SHIPPED.iter().map(|(_, _, text)| behind(&[0], text)).collect();
    let defaults = std::fs::read(root().join("firmware-profiles/defaults.toml")).unwrap();
    all.push(behind(&[0], defaults));
    all.push(behind(&[0], "extends = \"generic-ac\"\n[machine]\nname = \"x\"\n[kinematics.tilt]\nmin_deg = -30\n[process]\nlayer_height_mm = 0.3\n"));
    all.extend([small_ini(), small_klipper(), small_reprap(), small_marlin()].map(|text| behind(&[1], text)));
    all.push(behind(&[1], small_ini() + "[HAL]\nHALFILE = m.hal\n\n=== m.hal\nloadrt xyzac-trt-kins\nsetp xyzac-trt-kins.x-rot-point 1\nnet a b => c\nsource more.tcl\n"));
    all.push(behind(
        &[1],
        small_klipper()
            + "[include more/*.cfg]\n\n=== more/a.cfg\n[extruder]\nnozzle_diameter: 0.4\n[include ../k.cfg]\n",
    ));
    all.push(behind(
        &[1],
        small_reprap() + "M98 P\"more.g\"\nM669 K13\n\n=== more.g\nG10 L2 P1 X0\nM566 X600\nif true\n  M207 S1\n",
    ));
    all.push(behind(&[1], small_marlin() + "\n=== Configuration_adv.h\n#define CONFIGURATION_ADV_H_VERSION 02010300\n#if ENABLED(X) && (1 + 2 * 3 > 4)\n#define LIN_ADVANCE\n#endif\n"));
    all.push(behind(&[1], koala::machine().to_string()));
    all
}

fn journal() -> Vec<Vec<u8>> {
    let header = Header { sha256: "ab".into(), bytes: 7, path: "a b.gcode".into(), ..Header::default() };
    let run = |number, block| Record::Run { number, block };
    let begun = [
        Record::Printer("FIRMWARE_NAME:Marlin UUID:1".into()),
        run(3, 0),
        run(36, 32),
        Record::Ack { number: 70, block: 60 },
    ];
    let ends: [&[Record]; 7] = [
        &[],
        &[Record::Sent(64)],
        &[Record::Away, Record::Paused(61)],
        &[Record::Away, Record::Paused(61), Record::Back, run(70, 61)],
        &[Record::Entering, Record::Anew, run(2, 40), run(3, 40)],
        &[Record::Anew, Record::Locating, run(2, 60), Record::Back, Record::Sent(70)],
        &[Record::Done, Record::Stopped("the printer was reset".into())],
    ];
    let mut all = Vec::new();
    for (number, end) in ends.iter().enumerate() {
        let text: String = begun.iter().chain(*end).map(Record::to_text).collect();
        for machine in 0..4 {
            all.push(behind(
                &[machine * 5 + number as u8 % 2, if number % 3 == 0 { 0 } else { 70 }],
                header.to_text() + &text,
            ));
        }
    }
    all
}

const INI: &str = "# made by hand\nlayer_height = 0.2\nfirst_layer_height = 0.3\nperimeters = 2\nfill_density = 20%\nfill_pattern = rectilinear\n\
    extrusion_width = 150%\nexternal_perimeter_speed = 50%\nperimeter_speed = 60\ninfill_speed = 80\nfirst_layer_speed = 30%\n\
    temperature = 215,220\nbed_temperature = 60\nnozzle_diameter = 0.4\nfilament_diameter = 1.75\ninfill_overlap = 25%\ncooling = 1\n\
    max_fan_speed = 100\nmin_fan_speed = 35\nretract_length = 2\nretract_speed = 40\nretract_before_travel = 2\ntravel_speed = 130\n\
    top_solid_layers = 4\nbottom_solid_layers = 3\nsolid_infill_below_area = 70\nbridge_flow_ratio = 1\nbridge_speed = 30\n\
    slowdown_below_layer_time = 5\nmin_print_speed = 10\nspiral_vase = 0\nbrim_width = 0\n";

const TOUCHES: &str = "[tip]\nradius_mm = 1.5\noffset_mm = [0, 0, 0]\npaper_mm = 0.1\n[[mark]]\nname = \"a\"\nat_mm = [10, 20, 3]\n\
    [[ball]]\nname = \"b\"\nradius_mm = 5\nat_mm = [0, 0, 10]\n[[touch]]\nof = \"table\"\ntilt_deg = 0\nrotation_deg = 0\nat_mm = [10, 0, 0.1]\n\
    [[touch]]\nof = \"a\"\ntilt_deg = 30\nrotation_deg = 90\nat_mm = []\n";

fn config() -> Vec<Vec<u8>> {
    let as_gcode: String = INI.lines().skip(1).map(|line| format!("; {line}\n")).collect();
    vec![behind(&[0], INI), behind(&[0], as_gcode), behind(&[1], TOUCHES)]
}

fn reply() -> Vec<Vec<u8>> {
    let mut files: Vec<_> =
        std::fs::read_dir(root().join("fixtures/wire")).unwrap().map(|file| file.unwrap().path()).collect();
    files.sort();
    let mut all = Vec::new();
    for (number, file) in files.iter().filter(|file| file.extension().is_some_and(|end| end == "txt")).enumerate() {
        let text = std::fs::read_to_string(file).unwrap();
        // What the printer says, and what it is told.
        for side in ["<- ", "-> "] {
            let said: String =
                text.lines().filter_map(|line| Some(line.strip_prefix(side)?.to_owned() + "\n")).collect();
            all.push(behind(&[number as u8, (number * 37) as u8], said));
        }
    }
    all
}
