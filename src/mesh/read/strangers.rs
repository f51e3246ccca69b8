//! What a file is that is no model: named, with what makes a model of it.

use std::io::Cursor;

use zip::ZipArchive;

use super::stl_binary;
use crate::mesh::error::Fault;

/// Entries of an archive that are looked at.
const MOST_ENTRIES: usize = 4096;
/// What programs call a part's design, and what such files end in.
const DESIGNS: [(&str, &[&str]); 9] = [
    ("a Fusion design", &["f3d", "f3z"]),
    ("a FreeCAD document", &["fcstd"]),
    ("a SolidWorks part", &["sldprt", "sldasm"]),
    ("an Inventor part", &["ipt", "iam"]),
    ("a Blender scene", &["blend"]),
    ("a SketchUp model", &["skp"]),
    ("a Rhino model", &["3dm"]),
    ("an OpenSCAD script", &["scad"]),
    ("an Onshape or Parasolid part", &["x_t", "x_b"]),
];

fn extension(name: &str) -> String {
    name.rsplit_once('.').map(|(_, end)| end.to_ascii_lowercase()).unwrap_or_default()
}

/// What a file is by how it begins, where that is no model, whatever it is called.
pub(super) fn known(bytes: &[u8], name: &str) -> Option<Fault> {
    if stl_binary::has_exact_length(bytes) {
        return None;
    }
    let is_iges = || bytes.get(72..80).is_some_and(|word| word == b"S      1");
    let fault = match bytes {
        [0x1f, 0x8b, ..] => Fault::Compressed { kind: "gzip", within: unpacked_name(name) },
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Fault::Utf16,
        _ if bytes.starts_with(b"GCDE") => Fault::Program,
        _ if bytes.starts_with(b"BLENDER") => Fault::Design { kind: "a Blender scene" },
        _ if bytes.trim_ascii_start().starts_with(b"ISO-10303-21") => surfaces("STEP", name),
        _ if is_iges() => surfaces("IGES", name),
        _ if is_web_page(bytes) => Fault::WebPage,
        _ => return None,
    };
    Some(fault)
}

/// What a file is by its name, where what is in it says nothing.
pub(super) fn by_name(bytes: &[u8], name: &str) -> Fault {
    match &*extension(name) {
        "gcode" | "gco" | "g" | "nc" | "ngc" | "bgcode" => Fault::Program,
        "igs" | "iges" if bytes.is_ascii() => surfaces("IGES", name),
        _ => design(name).unwrap_or(Fault::UnknownFormat),
    }
}

fn design(name: &str) -> Option<Fault> {
    let end = extension(name);
    let found = DESIGNS.iter().find(|(_, ends)| ends.contains(&&*end))?;
    Some(Fault::Design { kind: found.0 })
}

/// What an archive holds in which there is no model that can be read.
pub(super) fn in_archive(bytes: &[u8], name: &str) -> Option<Fault> {
    if let Some(design) = design(name) {
        return Some(design);
    }
    let archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let names: Vec<_> = archive.file_names().take(MOST_ENTRIES).filter_map(Result::ok).collect();
    let ends = |wanted: &[&str]| names.iter().filter(|name| wanted.contains(&&*extension(name))).min();
    if ends(&["gcode"]).is_some() {
        return Some(Fault::Program);
    }
    if names.iter().any(|name| extension(name) == "model") {
        return None;
    }
    if ["Document.xml", "GuiDocument.xml"].iter().all(|wanted| names.iter().any(|name| name == wanted)) {
        return Some(Fault::Design { kind: "a FreeCAD document" });
    }
    let within = ends(&["stl", "obj", "3mf", "off", "step", "stp"])?;
    Some(Fault::Compressed { kind: "zip", within: within.to_string() })
}

/// What unpacking leaves.
fn unpacked_name(name: &str) -> String {
    match name.rsplit_once('.') {
        Some((stem, end)) if end.eq_ignore_ascii_case("gz") => stem.to_owned(),
        _ => "the model".to_owned(),
    }
}

/// What is saved where a download asks for a login first, under the model's name.
fn is_web_page(bytes: &[u8]) -> bool {
    let text = bytes.trim_ascii_start();
    let begins = |with: &str| text.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with.as_bytes()));
    begins("<!doctype html") || begins("<html")
}

/// A part as a CAD program exchanges it, with the command that makes facets of it: some 48 to a full turn.
fn surfaces(kind: &'static str, name: &str) -> Fault {
    let own = if kind == "STEP" { ["step", "stp"] } else { ["iges", "igs"] };
    let (stem, renamed) = match name.rsplit_once('.') {
        Some((stem, end)) if own.iter().any(|one| end.eq_ignore_ascii_case(one)) => (stem, None),
        Some((stem, _)) => (stem, Some(format!("{stem}.{}", own[0]))),
        None => (name, Some(format!("{name}.{}", own[0]))),
    };
    let from = renamed.as_deref().unwrap_or(name);
    // gmsh goes by the name.
    let first = renamed.as_ref().map(|to| format!("cp {} {} && ", quoted(name), quoted(to))).unwrap_or_default();
    let to = if renamed.is_some() { format!("{stem}-facets.stl") } else { format!("{stem}.stl") };
    let (from, to) = (quoted(from), quoted(&to));
    let command = format!("{first}gmsh {from} -2 -setnumber Mesh.MeshSizeFromCurvature 48 -format stl -o {to}");
    Fault::Surfaces { kind, command }
}

/// A file's name as a shell takes it for one word, and a program for no option.
fn quoted(name: &str) -> String {
    let name = if name.starts_with('-') { format!("./{name}") } else { name.to_owned() };
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-/+,:@%".contains(c);
    if name.chars().all(is_plain) { name } else { format!("'{}'", name.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::quoted;
    use crate::mesh::write::zipped;
    use crate::mesh::{Fault, ReadOptions, Repair, read_model};

    fn fault(bytes: &[u8], name: &str) -> Fault {
        read_model(bytes, name, &ReadOptions { repair: Repair::Auto, ..ReadOptions::default() }).unwrap_err().fault
    }

    #[test]
    fn what_is_no_model_is_named() {
        let gzip = [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3, 1];
        assert_eq!(fault(&gzip, "x.stl.gz"), Fault::Compressed { kind: "gzip", within: "x.stl".to_owned() });
        assert_eq!(fault(&gzip, "x.obj"), Fault::Compressed { kind: "gzip", within: "the model".to_owned() });
        for text in ["v 0 0 0", "solid x"] {
            let utf16 =
                |mark: [u8; 2]| mark.into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect();
            for (bytes, name) in [(utf16([0xff, 0xfe]), "x.obj"), (utf16([0xfe, 0xff]), "x.stl")] {
                let bytes: Vec<u8> = bytes;
                assert_eq!(fault(&bytes, name), Fault::Utf16);
            }
        }
        assert_eq!(fault(b"GCDE\x01\0\0\0", "x.bgcode"), Fault::Program);
        assert_eq!(fault(b"GCDE\x01\0\0\0", "x.stl"), Fault::Program);
        let empty: &[u8] = b"<model unit=\"millimeter\"><resources/><build/></model>";
        let sliced = zipped(&[("3D/3dmodel.model", empty), ("Metadata/plate_1.gcode", b"G28")]);
        assert_eq!(fault(&sliced, "x.gcode.3mf"), Fault::Program);
        assert_ne!(fault(&zipped(&[("3D/3dmodel.model", empty)]), "x.gcode.3mf"), Fault::Program);
        let packed = zipped(&[("readme.txt", b"x"), ("b/lid.STL", b"x"), ("box.obj", b"x")]);
        assert_eq!(fault(&packed, "x.zip"), Fault::Compressed { kind: "zip", within: "b/lid.STL".to_owned() });
        let document = zipped(&[("Document.xml", b"x"), ("GuiDocument.xml", b"x")]);
        for (bytes, name) in [(&document[..], "x.zip"), (b"PK\x03\x04aa", "x.FCStd")] {
            assert_eq!(fault(bytes, name), Fault::Design { kind: "a FreeCAD document" });
        }
        assert_eq!(fault(b"PK\x03\x04", "x.f3d"), Fault::Design { kind: "a Fusion design" });
        assert_eq!(fault(b"cube(1);", "x.scad"), Fault::Design { kind: "an OpenSCAD script" });
        assert!(matches!(fault(b"PK\x03\x04aa", "x.3mf"), Fault::Archive { .. }));
    }

    #[test]
    fn the_command_for_surfaces_can_be_pasted() {
        let command = |name: &str| match fault(b"ISO-10303-21;\nHEADER;\n", name) {
            Fault::Surfaces { kind: "STEP", command } => command,
            other => panic!("{other:?}"),
        };
        let options = "-2 -setnumber Mesh.MeshSizeFromCurvature 48 -format stl -o";
        assert_eq!(command("a/part.step"), format!("gmsh a/part.step {options} a/part.stl"));
        assert_eq!(command("it's.STP"), format!("gmsh 'it'\\''s.STP' {options} 'it'\\''s.stl'"));
        // It would write over what it reads, and not know what that is.
        assert_eq!(command("x.stl"), format!("cp x.stl x.step && gmsh x.step {options} x-facets.stl"));
        for (name, wanted) in [("-x.step", "./-x.step"), ("a b", "'a b'"), ("$(x);", "'$(x);'"), ("ü.stl", "'ü.stl'")]
        {
            assert_eq!(quoted(name), wanted);
        }
        let mut iges = vec![b' '; 72];
        iges.extend(b"S      1\n");
        assert!(matches!(fault(&iges, "x.stl"), Fault::Surfaces { kind: "IGES", .. }));
    }
}
