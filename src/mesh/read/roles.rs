//! What a project's volumes are for: slicers keep that beside the meshes.
//!
//! | program | where | by |
//! |---|---|---|
//! | PrusaSlicer | `Metadata/Slic3r_PE_model.config`: `volume_type` | stretches of triangles of an object |
//! | Bambu Studio, OrcaSlicer | `Metadata/model_settings.config`: `subtype` | components of an object |
//! | Slic3r 1.3 | `slic3r:volume` with `modifier` in the mesh | stretches of triangles of an object |
//! | Cura | `cura:.._mesh` in the object's own metadata, or in `settings` | object |
//! | 3MF core | `type` of an object, `printable` of an item | object |
//! | PrusaSlicer | `slic3rpe:custom_supports`, .. of a triangle | painted triangles |
//! | Bambu Studio, OrcaSlicer | `paint_supports`, .. of a triangle | painted triangles |
//!
//! Sources: PrusaSlicer and OrcaSlicer, `libslic3r/Format/3mf.cpp` and `bbs_3mf.cpp`, `ModelVolume::type_from_string`; Cura,
//! `ThreeMFWriter.py`; 3MF *Core Specification* 1.3, 4.1.

use std::collections::BTreeMap;
use std::ops::Range;

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::attributes::attribute;
use super::plates::Plates;
use crate::mesh::OtherVolume;
use crate::mesh::error::Fault;
use crate::spelling::counted;

/// What a volume is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Role {
    /// It is printed.
    #[default]
    Part,
    /// It is cut away from the parts of its object.
    Negative,
    /// It is not printed.
    Aside(Aside),
}

/// What is not printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Aside {
    Modifier,
    Blocker,
    Enforcer,
    Support,
    Other,
    Unprinted,
    OffPlate,
}

impl Aside {
    /// What is said of one called so.
    pub(super) fn told(self, name: Option<&str>) -> String {
        format!("{} {}", name.unwrap_or("a volume"), self.words())
    }

    /// The volume of that name, as a model lists it.
    pub(super) fn other(self, name: Option<&str>) -> OtherVolume {
        OtherVolume { name: name.unwrap_or_default().to_owned(), role: self.word() }
    }

    /// As scripts read it.
    fn word(self) -> &'static str {
        match self {
            Self::Modifier => "modifier",
            Self::Blocker => "blocker",
            Self::Enforcer => "enforcer",
            Self::Support => "support",
            Self::Other => "other",
            Self::Unprinted => "unprinted",
            Self::OffPlate => "off-plate",
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Modifier => "is a modifier: it is not printed, and its settings are ignored",
            Self::Blocker => {
                "is a support blocker: it is not printed, and supports are still placed where they are needed"
            }
            Self::Enforcer => {
                "is a support enforcer: it is not printed, and supports are placed only where they are needed"
            }
            Self::Support => "is a support of the file's own: it is not printed; --supports makes new ones",
            Self::Other => "is of a type that is not printed (3MF: other, surface)",
            Self::OffPlate => "lies on no plate of the project, and is left out",
            Self::Unprinted => "is marked as not to be printed, and is left out",
        }
    }
}

/// Roles by PrusaSlicer's words and by those of Bambu Studio and OrcaSlicer.
const WORDS: [(&str, Role); 10] = [
    ("ModelPart", Role::Part),
    ("NegativeVolume", Role::Negative),
    ("ParameterModifier", Role::Aside(Aside::Modifier)),
    ("SupportBlocker", Role::Aside(Aside::Blocker)),
    ("SupportEnforcer", Role::Aside(Aside::Enforcer)),
    ("normal_part", Role::Part),
    ("negative_part", Role::Negative),
    ("modifier_part", Role::Aside(Aside::Modifier)),
    ("support_blocker", Role::Aside(Aside::Blocker)),
    ("support_enforcer", Role::Aside(Aside::Enforcer)),
];

fn role(word: &str, name: &str) -> Result<Role, Fault> {
    let known = WORDS.iter().find(|(known, _)| *known == word);
    known.map(|(_, role)| *role).ok_or_else(|| Fault::Role { name: shown(name), role: shown(word) })
}

/// What slicers note of an object or a volume that says nothing of how it is to be printed.
const NOTES: [&str; 12] = [
    "name",
    "volume_type",
    "modifier",
    "matrix",
    "part_type",
    "subtype",
    "module",
    "thumbnail_file",
    "thumbnail_no_light_file",
    "top_file",
    "pick_file",
    "gcode_file",
];

/// Whether a key is of a setting; the first extruder is everybody's.
fn is_setting(key: &str, value: &str) -> bool {
    let note = NOTES.contains(&key)
        || ["source_", "mesh_", "text_", "svg_", "cut_"].iter().any(|start| key.starts_with(start));
    !(note || (key == "extruder" && matches!(value, "0" | "1")))
}

fn shown(text: &str) -> String {
    text.chars().take(80).collect()
}

/// What is painted on an object: triangles with some of each of [`PAINTS`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Painted([usize; PAINTS.len()]);

/// What slicers paint on triangles: the attribute of PrusaSlicer and that of Bambu Studio and OrcaSlicer, and what becomes of it.
const PAINTS: [([&str; 2], &str); 4] = [
    (
        ["custom_supports", "paint_supports"],
        "has painted supports, which are ignored: supports are placed only where they are needed",
    ),
    (["custom_seam", "paint_seam"], "has a painted seam, which is ignored"),
    (["mmu_segmentation", "paint_color"], "has painted colours, which are ignored: it is printed in one material"),
    (["fuzzy_skin", "paint_fuzzy_skin"], "has painted fuzzy skin, which is ignored"),
];

impl Painted {
    /// Takes a triangle into account; a triangle without paint has no attribute of it, or an empty one.
    pub(super) fn add(&mut self, tag: &BytesStart<'_>) -> Result<(), Fault> {
        // Hardly any triangle has.
        if !tag.contains("paint_") && !tag.contains("slic3rpe:") {
            return Ok(());
        }
        for (count, (names, _)) in self.0.iter_mut().zip(&PAINTS) {
            for name in names {
                *count += usize::from(attribute(tag, name)?.is_some_and(|paint| !paint.is_empty()));
            }
        }
        Ok(())
    }

    /// What is said of an object called so.
    pub(super) fn told<'a>(&'a self, name: Option<&'a str>) -> impl Iterator<Item = String> + 'a {
        let some = self.0.iter().zip(&PAINTS).filter(|(count, _)| **count > 0);
        some.map(move |(count, (_, words))| {
            format!("{} {words} ({})", name.unwrap_or("a volume"), counted(*count, "facet"))
        })
    }
}

/// The role of an object by its `type`.
pub(super) fn of_type(word: Option<&str>) -> Result<Role, Fault> {
    match word {
        None | Some("model") => Ok(Role::Part),
        Some("support" | "solidsupport") => Ok(Role::Aside(Aside::Support)),
        Some("other" | "surface") => Ok(Role::Aside(Aside::Other)),
        Some(other) => Err(Fault::Role { name: "an object".to_owned(), role: shown(other) }),
    }
}

/// The role that a Cura setting gives an object, where it is true.
pub(super) fn of_setting(name: &str) -> Option<Role> {
    let aside = match name.strip_prefix("cura:")? {
        "anti_overhang_mesh" => Aside::Blocker,
        "support_mesh" => Aside::Support,
        "infill_mesh" | "cutting_mesh" => Aside::Modifier,
        _ => return None,
    };
    Some(Role::Aside(aside))
}

/// A volume as Slic3r 1.3 notes it, by its first and last triangle; `None` for an element of another meaning.
pub(super) fn of_volume(tag: &BytesStart<'_>) -> Result<Option<(Range<usize>, Volume)>, Fault> {
    let (Some(first), Some(last)) = (attribute(tag, "ts")?, attribute(tag, "te")?) else { return Ok(None) };
    let number = |text: String| -> Result<usize, Fault> {
        text.parse().map_err(|_| Fault::Syntax { found: shown(&text), expected: "a triangle index" })
    };
    let (first, last) = (number(first)?, number(last)?);
    let aside = attribute(tag, "modifier")?.is_some_and(|word| word == "1");
    let role = if aside { Role::Aside(Aside::Modifier) } else { Role::Part };
    Ok(Some((first..last.saturating_add(1).max(first), Volume { role, name: None })))
}

/// A volume of an object.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Volume {
    pub(super) role: Role,
    pub(super) name: Option<String>,
}

/// What the volumes of a project are for.
#[derive(Clone, Debug, Default)]
pub(super) struct Roles {
    /// Whether a slicer has said so.
    pub(super) known: bool,
    /// By object: stretches of its triangles, in order.
    stretches: BTreeMap<String, Vec<(Range<usize>, Volume)>>,
    /// By object and component.
    components: BTreeMap<(String, String), Volume>,
    /// By object: what it is called, and the settings that are its own or its volumes'.
    objects: BTreeMap<String, (Option<String>, Vec<String>)>,
    pub(super) plates: Plates,
}

impl Roles {
    /// The volumes among an object's triangles.
    pub(super) fn stretches(&self, object: &str) -> &[(Range<usize>, Volume)] {
        self.stretches.get(object).map_or(&[], Vec::as_slice)
    }

    /// A component of an object.
    pub(super) fn component(&self, object: &str, component: &str) -> Option<&Volume> {
        self.components.get(&(object.to_owned(), component.to_owned()))
    }

    /// What an object is called.
    pub(super) fn name(&self, object: &str) -> Option<&String> {
        self.objects.get(object)?.0.as_ref()
    }

    /// What is said of an object's own settings, where it has some.
    pub(super) fn settings(&self, object: &str, called: Option<&str>) -> Option<String> {
        let (_, keys) = self.objects.get(object)?;
        let name = called.unwrap_or("an object");
        (!keys.is_empty()).then(|| format!("{name} has settings of its own, which are ignored: {}", keys.join(", ")))
    }

    /// The first object with a volume that is no part, of which `has` knows nothing: it is asked for the object and, where that has one, the component.
    pub(super) fn unknown(&self, has: impl Fn(&str, Option<&str>) -> bool) -> Option<&str> {
        let special = |volume: &Volume| volume.role != Role::Part;
        let stretches = self.stretches.iter().filter(|(_, all)| all.iter().any(|(_, volume)| special(volume)));
        let stretches = stretches.map(|(object, _)| (object, None));
        let components = self.components.iter().filter(|(_, volume)| special(volume));
        let components = components.map(|((object, part), _)| (object, Some(part.as_str())));
        stretches.chain(components).find(|(object, part)| !has(object, *part)).map(|(object, _)| object.as_str())
    }

    /// Takes what `Metadata/Slic3r_PE_model.config` or `Metadata/model_settings.config` says; what is wrong, and before which byte.
    pub(super) fn read(&mut self, text: &str) -> Result<(), (Fault, u64)> {
        let mut reader = Reader::from_str(text);
        let mut state = Open::default();
        self.known = true;
        loop {
            let event = reader.read_event().map_err(|error| Fault::Xml { reason: error.to_string() });
            let more = event.and_then(|event| state.take(&event, self));
            if !more.map_err(|fault| (fault, reader.buffer_position()))? {
                return self.check().map_err(|fault| (fault, reader.buffer_position()));
            }
        }
    }

    /// A triangle is of one volume.
    fn check(&mut self) -> Result<(), Fault> {
        for (id, stretches) in &mut self.stretches {
            stretches.sort_by_key(|(stretch, _)| (stretch.start, stretch.end));
            if stretches.windows(2).any(|pair| pair[1].0.start < pair[0].0.end) {
                return Err(Fault::Object { id: id.clone(), trouble: "has two volumes that share a triangle" });
            }
        }
        Ok(())
    }
}

/// Where in a configuration the reader is.
#[derive(Default)]
struct Open {
    object: String,
    volume: Option<OpenVolume>,
    /// Elements that are open, and whether there was one.
    depth: usize,
    begun: bool,
}

/// A volume whose end has not come.
struct OpenVolume {
    /// PrusaSlicer's first and last triangle, or the component's id.
    place: Result<[usize; 2], String>,
    word: Option<String>,
    /// Before PrusaSlicer 1.42 a modifier had no other word.
    modifier: bool,
    name: Option<String>,
}

impl Open {
    /// Takes the next piece; `false` for the end.
    fn take(&mut self, event: &Event<'_>, roles: &mut Roles) -> Result<bool, Fault> {
        match event {
            Event::Start(tag) => {
                self.root(tag)?;
                self.depth += 1;
                self.open(tag, false, roles)?;
            }
            Event::Empty(tag) => {
                self.root(tag)?;
                self.open(tag, true, roles)?;
            }
            Event::Eof if self.depth > 0 || !self.begun => {
                return Err(Fault::Xml { reason: "the text ends before its config element does".to_owned() });
            }
            Event::End(_) => self.depth = self.depth.saturating_sub(1),
            _ => {}
        }
        match event {
            Event::End(tag) if matches!(tag.local_name().as_ref(), "volume" | "part") => self.close(roles)?,
            Event::End(tag) => roles.plates.end(tag.local_name().as_ref()),
            _ => {}
        }
        Ok(!matches!(event, Event::Eof))
    }

    /// Refuses a page of the web, or whatever else is not a configuration.
    fn root(&mut self, tag: &BytesStart<'_>) -> Result<(), Fault> {
        let name = tag.local_name();
        if !std::mem::replace(&mut self.begun, true) && name.as_ref() != "config" {
            return Err(Fault::Syntax { found: shown(name.as_ref()), expected: "a config element" });
        }
        Ok(())
    }

    fn open(&mut self, tag: &BytesStart<'_>, empty: bool, roles: &mut Roles) -> Result<(), Fault> {
        if roles.plates.begin(tag)? {
            if empty {
                roles.plates.end(tag.local_name().as_ref());
            }
            return Ok(());
        }
        match tag.local_name().as_ref() {
            "object" => self.object = attribute(tag, "id")?.unwrap_or_default(),
            "volume" => {
                let number = |name, expected| -> Result<usize, Fault> {
                    let text = attribute(tag, name)?.unwrap_or_default();
                    text.parse().map_err(|_| Fault::Syntax { found: shown(&text), expected })
                };
                let first = number("firstid", "a triangle index as firstid")?;
                let last = number("lastid", "a triangle index as lastid")?;
                if last < first {
                    let trouble = "has a volume whose last triangle comes before its first";
                    return Err(Fault::Object { id: self.object.clone(), trouble });
                }
                self.begin(Ok([first, last]), None);
            }
            "part" => {
                let (id, word) = (attribute(tag, "id")?.unwrap_or_default(), attribute(tag, "subtype")?);
                self.begin(Err(id), word);
            }
            "metadata" => self.note(attribute(tag, "key")?, attribute(tag, "value")?, roles),
            _ => {}
        }
        if empty && matches!(tag.local_name().as_ref(), "volume" | "part") { self.close(roles) } else { Ok(()) }
    }

    fn begin(&mut self, place: Result<[usize; 2], String>, word: Option<String>) {
        self.volume = Some(OpenVolume { place, word, modifier: false, name: None });
    }

    fn note(&mut self, key: Option<String>, value: Option<String>, roles: &mut Roles) {
        let (Some(key), Some(value)) = (key, value) else { return };
        let about = roles.objects.entry(self.object.clone()).or_default();
        if is_setting(&key, &value) {
            let setting = shown(&format!("{key} = {value}"));
            if !about.1.contains(&setting) {
                about.1.push(setting);
            }
        }
        let Some(volume) = &mut self.volume else {
            if key == "name" {
                about.0 = Some(value).filter(|name| !name.trim().is_empty());
            }
            return;
        };
        match key.as_str() {
            "volume_type" => volume.word = Some(value),
            "modifier" => volume.modifier = value == "1",
            "name" => volume.name = Some(value).filter(|name| !name.trim().is_empty()),
            _ => {}
        }
    }

    fn close(&mut self, roles: &mut Roles) -> Result<(), Fault> {
        let Some(OpenVolume { place, word, modifier, name }) = self.volume.take() else { return Ok(()) };
        let role = match word {
            Some(word) => role(&word, name.as_deref().unwrap_or("a volume"))?,
            None if modifier => Role::Aside(Aside::Modifier),
            None => Role::Part,
        };
        let volume = Volume { role, name };
        match place {
            Ok([first, last]) => {
                let stretch = first..last.saturating_add(1);
                roles.stretches.entry(self.object.clone()).or_default().push((stretch, volume));
            }
            Err(component) => {
                roles.components.insert((self.object.clone(), component), volume);
            }
        }
        Ok(())
    }
}
