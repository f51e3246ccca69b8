//! The archive of a 3MF file: its entries, unpacked within bounds, and what slicers keep in it beside the model.

use std::collections::BTreeMap;
use std::io::{BufReader, Cursor, Read};

use zip::ZipArchive;

use super::meter::Meter;
use super::roles::Roles;
use super::threemf_xml::{self, ModelFile};
use crate::mesh::error::{Fault, FilePlace, Located};

/// Where the model is when the archive's relations do not say.
const USUAL_PATH: &str = "3D/3dmodel.model";
/// Where slicers keep what volumes are for: PrusaSlicer; Bambu Studio and OrcaSlicer.
const CONFIGURATIONS: [&str; 2] = ["Metadata/Slic3r_PE_model.config", "Metadata/model_settings.config"];
/// Where they keep what is to change at some height, what is in such a file that is not empty, and what is said of it.
const BY_HEIGHT: [(&str, &str, &str); 6] = [
    ("Metadata/Prusa_Slicer_custom_gcode_per_print_z.xml", "<code", PAUSES),
    ("Metadata/custom_gcode_per_layer.xml", "<layer", PAUSES),
    ("Metadata/Prusa_Slicer_layer_config_ranges.xml", "<range", RANGES),
    ("Metadata/layer_config_ranges.xml", "<range", RANGES),
    ("Metadata/Slic3r_PE_layer_heights_profile.txt", "=", HEIGHTS),
    ("Metadata/layer_heights_profile.txt", "=", HEIGHTS),
];
/// What is said of each.
const PAUSES: &str = "pauses and filament changes at certain heights are ignored";
const RANGES: &str = "settings for certain heights are ignored";
const HEIGHTS: &str = "variable layer heights are ignored";
/// Theirs have some hundred bytes for a volume.
const LARGEST_CONFIGURATION: u64 = 16 << 20;
/// Models pack five to fifty times smaller, nothing but repetitions a thousand times.
const MAX_RATIO: u64 = 200;
/// What any archive may unpack to, and no archive may exceed.
const UNPACKED: [u64; 2] = [64 << 20, 4 << 30];

fn archive_fault(error: &zip::result::ZipError) -> Located {
    Fault::Archive { reason: error.to_string() }.at(FilePlace::File)
}

/// The archive and the model files read from it so far.
pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    pub(super) files: BTreeMap<String, ModelFile>,
    pub(super) packed: u64,
    /// The most bytes that all of it may unpack to, so that a small archive cannot fill the memory.
    allowed: u64,
    /// Of these, what is left.
    left: u64,
}

impl<'a> Package<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, Located> {
        let archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| archive_fault(&error))?;
        let allowed = (bytes.len() as u64).saturating_mul(MAX_RATIO).clamp(UNPACKED[0], UNPACKED[1]);
        Ok(Self { archive, files: BTreeMap::new(), packed: bytes.len() as u64, allowed, left: allowed })
    }

    /// The path that `_rels/.rels` names as the 3D model.
    pub(super) fn root_path(&mut self) -> String {
        let mut text = String::new();
        let found = self.archive.by_name("_rels/.rels").ok().and_then(|entry| {
            entry.take(1 << 20).read_to_string(&mut text).ok()?;
            threemf_xml::model_target(&text)
        });
        found.map_or_else(|| USUAL_PATH.to_owned(), |path| path.trim_start_matches('/').to_owned())
    }

    /// An entry's own name: those of a package are the same in capitals.
    fn called(&self, path: &str) -> Option<String> {
        let mut names = self.archive.file_names().flatten();
        names.find(|name| name.eq_ignore_ascii_case(path)).map(std::borrow::Cow::into_owned)
    }

    /// What of a project is ignored that changes how it is printed, by height.
    pub(super) fn ignored(&mut self) -> Vec<String> {
        let mut found = Vec::new();
        for (path, mark, words) in BY_HEIGHT {
            let Some(Ok(entry)) = self.called(path).map(|name| self.archive.by_name(&name)) else { continue };
            let mut text = Vec::new();
            let read = entry.take(LARGEST_CONFIGURATION).read_to_end(&mut text);
            let has = text.windows(mark.len()).any(|piece| piece == mark.as_bytes());
            if read.is_ok() && has && !found.iter().any(|told| told == words) {
                found.push(words.to_owned());
            }
        }
        found
    }

    /// What the project's volumes are for, where it says so.
    pub(super) fn roles(&mut self) -> Result<Roles, Located> {
        let mut roles = Roles::default();
        for path in CONFIGURATIONS {
            let Some(name) = self.called(path) else { continue };
            let Ok(entry) = self.archive.by_name(&name) else { continue };
            let mut text = String::new();
            let (packed, allowed) = (self.packed, self.allowed);
            entry.take(LARGEST_CONFIGURATION + 1).read_to_string(&mut text).map_err(|error| {
                let reason = match error.kind() {
                    std::io::ErrorKind::InvalidData => format!("{path}: it is not UTF-8 text"),
                    _ => format!("{path}: {error}"),
                };
                Fault::Archive { reason }.at(FilePlace::File)
            })?;
            if text.len() as u64 > LARGEST_CONFIGURATION {
                return Err(Fault::Unpacked { packed, allowed }.at(FilePlace::File));
            }
            let place = |byte| FilePlace::Entry { name: path.to_owned(), byte };
            roles.read(&text).map_err(|(fault, byte)| fault.at(place(byte)))?;
        }
        Ok(roles)
    }

    pub(super) fn load(&mut self, path: &str) -> Result<(), Located> {
        if !self.files.contains_key(path) {
            let entry = self
                .archive
                .by_name(path)
                .map_err(|error| Fault::Archive { reason: format!("{path}: {error}") }.at(FilePlace::File))?;
            let (packed, allowed) = (self.packed, self.allowed);
            let over = || Fault::Unpacked { packed, allowed }.at(FilePlace::File);
            if entry.size() > self.left {
                return Err(over());
            }
            // An archive may say anything of itself: what comes out is measured as well.
            let mut text = Meter::new(BufReader::new(entry), self.left);
            let file = threemf_xml::parse(&mut text, path);
            self.left = text.left();
            let file = if text.is_over() { Err(over()) } else { file }?;
            self.files.insert(path.to_owned(), file);
        }
        Ok(())
    }
}
