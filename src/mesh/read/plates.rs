//! The plates of a Bambu Studio or OrcaSlicer project: which of its items lie on which.
//!
//! `Metadata/model_settings.config` has a `plate` for each, with its number and name, and a `model_instance` for each item on it: the
//! object's id, and which of the object's items it is, in the order of the build, from 0. Source: OrcaSlicer, `libslic3r/Format/bbs_3mf.cpp`.

use std::collections::{BTreeMap, BTreeSet};

use quick_xml::events::BytesStart;

use super::attributes::attribute;
use crate::mesh::error::Fault;
use crate::spelling::counted;

/// Which plates of a project are read; other files have none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProjectPlates {
    /// The one on which something lies; several are refused.
    #[default]
    Only,
    /// This one, by its number.
    Number(u32),
    /// All of them.
    All,
}

/// The plates as the project lists them.
#[derive(Clone, Debug, Default)]
pub(super) struct Plates {
    all: Vec<Listed>,
    /// The item in hand: its object, and which of the object's.
    item: (Option<String>, usize),
    open: bool,
    in_item: bool,
}

#[derive(Clone, Debug, Default)]
struct Listed {
    number: u32,
    name: String,
    items: BTreeSet<(String, usize)>,
}

/// What is read of the items of a build.
pub(super) struct Chosen {
    /// By item: whether it is read.
    pub(super) items: Vec<bool>,
    /// By item: whether it lies on no plate, though others do.
    pub(super) lost: Vec<bool>,
    /// All plates in words, where there are several and all are read.
    pub(super) all: Option<String>,
}

impl Plates {
    /// Takes the beginning of an element; whether it belongs to a plate.
    pub(super) fn begin(&mut self, tag: &BytesStart<'_>) -> Result<bool, Fault> {
        match tag.local_name().as_ref() {
            "plate" => {
                self.all.push(Listed::default());
                self.open = true;
            }
            "model_instance" if self.open => (self.item, self.in_item) = ((None, 0), true),
            "metadata" if self.open => {
                let (key, value) = (attribute(tag, "key")?, attribute(tag, "value")?);
                self.note(key.as_deref().unwrap_or_default(), value.unwrap_or_default())?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn note(&mut self, key: &str, value: String) -> Result<(), Fault> {
        let number = |expected| {
            let found = || value.chars().take(80).collect();
            value.trim().parse::<u32>().map_err(|_| Fault::Syntax { found: found(), expected })
        };
        let Some(plate) = self.all.last_mut() else { return Ok(()) };
        match (key, self.in_item) {
            ("plater_id", false) => plate.number = number("a plate's number as plater_id")?,
            ("plater_name", false) => plate.name = value.trim().to_owned(),
            ("object_id", true) => self.item.0 = Some(value),
            ("instance_id", true) => self.item.1 = number("an item's number as instance_id")? as usize,
            _ => {}
        }
        Ok(())
    }

    /// Takes the end of an element.
    pub(super) fn end(&mut self, name: &str) {
        match name {
            "plate" => self.open = false,
            "model_instance" => {
                self.in_item = false;
                let (Some(object), which) = std::mem::take(&mut self.item) else { return };
                self.all.last_mut().into_iter().for_each(|plate| _ = plate.items.insert((object.clone(), which)));
            }
            _ => {}
        }
    }

    /// Which of the items of a build are read, each of them told by its object's id and whether it is printed.
    pub(super) fn chosen(&self, items: &[(&str, bool)], choice: ProjectPlates) -> Result<Chosen, Fault> {
        let mut so_far: BTreeMap<&str, usize> = BTreeMap::new();
        let keys: Vec<(String, usize)> = items
            .iter()
            .map(|&(id, _)| {
                let count = so_far.entry(id).or_default();
                *count += 1;
                (id.to_owned(), *count - 1)
            })
            .collect();
        let printed =
            |plate: &&Listed| keys.iter().zip(items).any(|(key, (_, printed))| *printed && plate.items.contains(key));
        let used: Vec<&Listed> = self.all.iter().filter(printed).collect();
        let on = |plates: &[&Listed]| -> Vec<bool> {
            keys.iter().map(|key| plates.iter().any(|plate| plate.items.contains(key))).collect()
        };
        let (items, several) = match (choice, &used[..]) {
            (ProjectPlates::Number(given), []) => return Err(Fault::NoPlates { given }),
            (_, []) => (vec![true; keys.len()], false),
            (ProjectPlates::Number(given), _) => match used.iter().find(|plate| plate.number == given) {
                Some(plate) => (on(&[plate]), false),
                None => return Err(Fault::NoSuchPlate { given, known: in_words(&used) }),
            },
            (ProjectPlates::Only, [_, _, ..]) => return Err(Fault::SeveralPlates { known: in_words(&used) }),
            (_, used) => (on(used), used.len() > 1),
        };
        let anywhere = on(&self.all.iter().collect::<Vec<_>>());
        let lost = anywhere.iter().map(|on| !used.is_empty() && !on).collect();
        Ok(Chosen { items, lost, all: several.then(|| in_words(&used)) })
    }
}

/// Names that are told of plates, at most.
const TOLD: usize = 12;

/// `2 plates: 1 (base, 2 objects), 2 (1 object)`.
fn in_words(plates: &[&Listed]) -> String {
    let one = |plate: &&Listed| {
        let name = if plate.name.is_empty() { String::new() } else { format!("{}, ", plate.name) };
        format!("{} ({name}{})", plate.number, counted(plate.items.len(), "object"))
    };
    let mut told: Vec<String> = plates.iter().take(TOLD).map(one).collect();
    if plates.len() > TOLD {
        told.push(format!("and {} more", plates.len() - TOLD));
    }
    format!("{}: {}", counted(plates.len(), "plate"), told.join(", "))
}
