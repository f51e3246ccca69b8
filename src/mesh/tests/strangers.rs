//! Other people's meshes, and noise: nothing may panic.

use std::path::Path;
use std::time::Instant;

use super::{cube, read};
use crate::mesh::write::zipped;
use crate::mesh::{ReadOptions, Repair, read_model, stl_binary, threemf};

/// The folder of meshes that may not be copied here: `TRUNNION_MESHES`, or beside the checkout.
fn folder() -> Option<std::path::PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/meshes");
    let given = std::env::var_os("TRUNNION_MESHES").map(std::path::PathBuf::from);
    given.or(Some(beside)).filter(|path| path.is_dir())
}

#[test]
fn meshes_of_others_are_read_or_refused_but_never_panic() {
    let Some(folder) = folder() else {
        println!("SKIPPED: no folder ../shared/data/meshes and no TRUNNION_MESHES");
        return;
    };
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .flat_map(|sub| std::fs::read_dir(sub.unwrap().path()).unwrap())
        .map(|file| file.unwrap().path())
        .collect();
    paths.sort();
    assert!(!paths.is_empty());
    let mut refused = Vec::new();
    for path in &paths {
        let bytes = std::fs::read(path).unwrap();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let start = Instant::now();
        for repair in [Repair::Off, Repair::Auto] {
            match read_model(&bytes, &name, &ReadOptions { unit: None, repair, ..ReadOptions::default() }) {
                Ok(model) => {
                    let volumes: Vec<f64> = model.parts.iter().map(|part| part.mesh.volume()).collect();
                    assert!(volumes.iter().all(|&volume| volume > 0.0));
                    println!(
                        "{name}: repair {repair:?}, {} {volumes:.3?} {:?} {:.0?}",
                        model.unit,
                        model.warnings,
                        start.elapsed()
                    );
                }
                Err(error) => {
                    println!("{error}");
                    refused.push((name.clone(), repair));
                }
            }
        }
    }
    println!("refused: {refused:?}");
}

/// A small generator, so that a failure can be repeated.
struct Noise(u64);

impl Noise {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit
    }
}

/// Cuts, overwrites or inserts at up to three places.
fn damaged(mut bytes: Vec<u8>, noise: &mut Noise) -> Vec<u8> {
    for _ in 0..=noise.below(3) {
        let at = noise.below(bytes.len());
        match noise.below(4) {
            0 => bytes.truncate(at + 1),
            1 => bytes[at] = b"0-9 /.e\n"[noise.below(8)],
            2 => bytes[at] = noise.below(256) as u8,
            _ => bytes.insert(at, b"-9"[noise.below(2)]),
        }
    }
    bytes
}

#[test]
fn damaged_files_are_refused_or_read_but_never_panic() {
    let mesh = cube([0.0; 3], 2.0, false);
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\ng a b\nf 1/1/1 3//2 2\nf 1 2 4\nf -4 -1 -2\nf 2 3 4\n";
    let off = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
    let xml = r#"<model unit="foot"><resources><object id="1"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1"
        y="0" z="0"/><vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices><triangles><triangle v1="0" v2="2"
        v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/>
        </triangles></mesh></object><object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 0 0 0"/>
        </components></object></resources><build><item objectid="2"/></build></model>"#;
    let files: [Vec<u8>; 6] =
        [stl_binary(&mesh), threemf(&[("a".to_owned(), &mesh)]), obj.into(), off.into(), stl.into(), xml.into()];
    let mut noise = Noise(7);
    let (mut fine, mut bad) = ([0; 6], [0; 6]);
    for turn in 0..6000 {
        let kind = turn % files.len();
        let mut bytes = damaged(files[kind].clone(), &mut noise);
        if kind == 5 {
            bytes = zipped(&[("3D/3dmodel.model", &bytes)]);
        }
        for name in ["x.stl", "x.obj", "x.off", "x.3mf"] {
            let repair = ReadOptions { unit: None, repair: Repair::Auto, ..ReadOptions::default() };
            let done = if noise.below(2) == 0 { read(&bytes, name) } else { read_model(&bytes, name, &repair) };
            (if done.is_ok() { &mut fine } else { &mut bad })[kind] += 1;
        }
    }
    assert!(bad.iter().all(|&count| count > 100), "{bad:?}");
    // The lone facet of the ASCII file is open however it is damaged.
    assert!([0, 2, 3, 5].iter().all(|&kind| fine[kind] > 10), "{fine:?}");
}
