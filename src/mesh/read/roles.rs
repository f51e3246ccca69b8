//! What a project's volumes are for: slicers keep that beside the meshes.
//!
//! | program | where | by |
//! |---|---|---|
//! | PrusaSlicer | `Metadata/Slic3r_PE_model.config`: `volume_type` | stretches of triangles of an object |
//! | Bambu Studio, OrcaSlicer | `Metadata/model_settings.config`: `subtype` | components of an object |
//! | Cura | `cura:.._mesh` in the object's own metadata | object |
//! | 3MF core | `type` of an object, `printable` of an item | object |
//!
//! Sources: PrusaSlicer and OrcaSlicer, `libslic3r/Format/3mf.cpp` and `bbs_3mf.cpp`, `ModelVolume::type_from_string`; Cura,
//! `ThreeMFWriter.py`; 3MF *Core Specification* 1.3, 4.1.

use std::collections::BTreeMap;
use std::ops::Range;

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use super::attributes::attribute;
use crate::mesh::error::Fault;

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
}

impl Aside {
    /// What is said of one called so.
    pub(super) fn told(self, name: Option<&str>) -> String {
        format!("{} {}", name.unwrap_or("a volume"), self.words())
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

fn shown(text: &str) -> String {
    text.chars().take(80).collect()
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

/// A volume of an object.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Volume {
    pub(super) role: Role,
    pub(super) name: Option<String>,
}

/// What the volumes of a project are for.
#[derive(Clone, Debug, Default)]
pub(super) struct Roles {
    /// By object: stretches of its triangles.
    stretches: BTreeMap<String, Vec<(Range<usize>, Volume)>>,
    /// By object and component.
    components: BTreeMap<(String, String), Volume>,
}

impl Roles {
    /// The volumes among an object's triangles that are no parts.
    pub(super) fn stretches(&self, object: &str) -> &[(Range<usize>, Volume)] {
        self.stretches.get(object).map_or(&[], Vec::as_slice)
    }

    /// A component of an object.
    pub(super) fn component(&self, object: &str, component: &str) -> Option<&Volume> {
        self.components.get(&(object.to_owned(), component.to_owned()))
    }

    /// Takes what `Metadata/Slic3r_PE_model.config` or `Metadata/model_settings.config` says; what is wrong, and before which byte.
    pub(super) fn read(&mut self, text: &str) -> Result<(), (Fault, u64)> {
        let mut reader = Reader::from_str(text);
        let mut state = Open::default();
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
            Event::Start(tag) => self.open(tag, false, roles)?,
            Event::Empty(tag) => self.open(tag, true, roles)?,
            Event::End(tag) if matches!(tag.local_name().as_ref(), "volume" | "part") => self.close(roles)?,
            _ => {}
        }
        Ok(!matches!(event, Event::Eof))
    }

    fn open(&mut self, tag: &BytesStart<'_>, empty: bool, roles: &mut Roles) -> Result<(), Fault> {
        match tag.local_name().as_ref() {
            "object" => self.object = attribute(tag, "id")?.unwrap_or_default(),
            "volume" => {
                let number = |name, expected| -> Result<usize, Fault> {
                    let text = attribute(tag, name)?.unwrap_or_default();
                    text.parse().map_err(|_| Fault::Syntax { found: shown(&text), expected })
                };
                let first = number("firstid", "a triangle index as firstid")?;
                self.begin(Ok([first, number("lastid", "a triangle index as lastid")?]), None);
            }
            "part" => {
                let (id, word) = (attribute(tag, "id")?.unwrap_or_default(), attribute(tag, "subtype")?);
                self.begin(Err(id), word);
            }
            "metadata" => self.note(attribute(tag, "key")?, attribute(tag, "value")?),
            _ => {}
        }
        if empty && matches!(tag.local_name().as_ref(), "volume" | "part") { self.close(roles) } else { Ok(()) }
    }

    fn begin(&mut self, place: Result<[usize; 2], String>, word: Option<String>) {
        self.volume = Some(OpenVolume { place, word, modifier: false, name: None });
    }

    fn note(&mut self, key: Option<String>, value: Option<String>) {
        let (Some(volume), Some(key), Some(value)) = (&mut self.volume, key, value) else { return };
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
        if role == Role::Part {
            return Ok(());
        }
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
