//! What a person has chosen: models, machine, and the words of the commands. Pure values, which undo puts back as they were.

use std::collections::{BTreeMap, BTreeSet};

use super::WorkbenchError;
use super::cuts::CutsOfPart;
use super::doors::{is_below, plain_of};
use super::printers::ChosenPrinters;
use super::task::numbered;
use crate::job::{GivenCut, ordered};
use crate::profile::shipped;

/// As many plates as a slicer's project has at most.
pub(super) const MOST_PLATE: u8 = 36;
/// Most copies of one model.
const MOST_COPIES: u32 = 999;
/// The longest order, bytes: some hundred parts.
const MOST_ORDER: usize = 4000;
/// The longest list of cuts, bytes, and how many there are at most.
const MOST_CUTS: (usize, usize) = (8000, 40);
/// Ways to print that can be chosen.
pub(super) const WAYS: [&str; 6] = ["auto", "as-drawn", "turned", "supports", "turned-supports", "cut"];
/// Units of models that can be chosen.
pub(super) const UNITS: [&str; 7] = ["auto", "um", "mm", "cm", "in", "ft", "m"];
const UPS: [&str; 2] = ["auto", "recommended"];
/// Qualities of overhangs that can be chosen.
pub(super) const FINISHES: [&str; 2] = ["auto", "fine"];
/// Slicers that can be chosen.
pub(super) const SLICERS: [&str; 6] = ["auto", "builtin", "prusa-slicer", "slic3r", "cura", "orca"];
/// Names of the choices that are set by a word.
pub(super) const CHOICES: [&str; 14] = [
    "machine",
    "way",
    "unit",
    "plate",
    "up",
    "cuts",
    "finish",
    "slicer",
    "order",
    "printer_name",
    "port",
    "server",
    "key_file",
    "fingerprint",
];

/// Endings of the files that preparing makes.
pub(super) const ENDINGS: [&str; 3] = ["gcode", "plan.json", "html"];

/// Flags of the command and the choices that they are.
const FLAGS: [(&str, &str); 8] = [
    ("-m", "machine"),
    ("--unit", "unit"),
    ("--plate", "plate"),
    ("--up", "up"),
    ("--way", "way"),
    ("--order", "order"),
    ("--finish", "finish"),
    ("--slicer", "slicer"),
];

/// A model that was chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct ChosenModel {
    /// The same for as long as the workbench runs, whatever its file is called.
    pub(super) id: u64,
    /// Its file, as the command line names it from the project's folder.
    pub(super) path: String,
    /// How many are printed.
    pub(super) copies: u32,
}

impl ChosenModel {
    /// Its name without folders.
    pub(super) fn name(&self) -> &str {
        self.path.rsplit(['/', '\\']).next().unwrap_or_default()
    }

    fn word(&self) -> String {
        match self.copies {
            1 => guarded(&self.path),
            n => format!("{}*{n}", guarded(&self.path)),
        }
    }
}

/// Everything that was chosen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Choices {
    /// The models in order.
    pub(super) models: Vec<ChosenModel>,
    /// The machine: a name or a profile's file.
    pub(super) machine: Option<String>,
    /// Unit of the models' numbers, or `auto`.
    pub(super) unit: String,
    /// The plate of the first model, which is a slicer's project with several, or `auto`.
    pub(super) plate: String,
    /// The way to print, or `auto`.
    pub(super) way: String,
    /// Direction of the model that points up, as three numbers; `auto` as drawn, `recommended` as `trunnion orient` says.
    pub(super) up: String,
    /// Cuts that are made first, as `--cut` has them, with a `;` between, or `auto`. Where another way than `cut` is chosen they wait.
    pub(super) cuts: String,
    /// Quality of overhangs, or `auto`.
    pub(super) finish: String,
    /// The slicer, or `auto`.
    pub(super) slicer: String,
    /// The order of the prints, as `--order` has it, or `auto`.
    pub(super) order: String,
    /// Where it is printed.
    pub(super) printers: ChosenPrinters,
}

impl Choices {
    /// Those of a project with nothing in it.
    pub(super) fn new(machine: Option<String>) -> Self {
        let auto = || "auto".to_owned();
        let [unit, plate, way, up, cuts, finish, slicer, order] = [(); 8].map(|()| auto());
        Self { machine, unit, plate, way, up, cuts, finish, slicer, order, ..Self::default() }
    }

    /// Makes a choice by its name; `machines` are the profiles that there are. Behind what is a printer's its number stands, as in `port:2`.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::BadChoice`].
    pub(super) fn set(&mut self, name: &str, value: &str, machines: &[String]) -> Result<(), WorkbenchError> {
        let plate = || value == "auto" || value.parse::<u8>().is_ok_and(|number| (1..=MOST_PLATE).contains(&number));
        let bad_name = || WorkbenchError::BadChoice { name: "name", value: name.to_owned() };
        let (plain, printer) = numbered(name).ok_or_else(bad_name)?;
        if let Some((place, name, good)) = self.printers.get_mut(printer)?.place(plain, value) {
            return put(place, name, value, good);
        }
        let (place, name, good) = match name {
            "machine" if machines.iter().any(|one| one == value) => {
                (self.machine.get_or_insert_default(), "machine", true)
            }
            "machine" => return Err(WorkbenchError::BadChoice { name: "machine", value: value.to_owned() }),
            "way" => (&mut self.way, "way", WAYS.contains(&value)),
            "unit" => (&mut self.unit, "unit", UNITS.contains(&value)),
            "plate" => (&mut self.plate, "plate", plate()),
            "up" => (&mut self.up, "up", UPS.contains(&value) || is_direction(value)),
            "cuts" => (&mut self.cuts, "cuts", value == "auto" || are_cuts(value)),
            "finish" => (&mut self.finish, "finish", FINISHES.contains(&value)),
            "slicer" => (&mut self.slicer, "slicer", SLICERS.contains(&value)),
            "order" => {
                (&mut self.order, "order", value == "auto" || value.len() <= MOST_ORDER && ordered(value).is_ok())
            }
            _ => return Err(bad_name()),
        };
        put(place, name, value, good)
    }

    /// Prints so many copies of a model.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::BadChoice`] and [`WorkbenchError::NotFound`].
    pub(super) fn set_copies(&mut self, index: usize, value: &str) -> Result<(), WorkbenchError> {
        let model = self.models.get_mut(index).ok_or(WorkbenchError::NotFound)?;
        let copies = value.parse().ok().filter(|n| (1..=MOST_COPIES).contains(n));
        model.copies = copies.ok_or_else(|| WorkbenchError::BadChoice { name: "copies", value: value.to_owned() })?;
        Ok(())
    }

    /// The words that say how the models are read and how they stand.
    pub(super) fn push_reading(&self, words: &mut Vec<String>) {
        push(words, "--unit", &self.unit);
        push(words, "--plate", &self.plate);
        match self.up.as_str() {
            "recommended" => words.extend(["--up".to_owned(), "auto".to_owned()]),
            up => push(words, "--up", up),
        }
    }

    /// An order is one of the parts that there were: where these may be others than in `before`, it is left to the plan.
    pub(super) fn order_after(&mut self, before: &Self) {
        let parts = |choices: &Self| Self {
            order: String::new(),
            slicer: String::new(),
            printers: ChosenPrinters::default(),
            ..choices.clone()
        };
        if self.order == before.order && parts(self) != parts(before) {
            "auto".clone_into(&mut self.order);
        }
    }

    /// The choices that the words of a command make, or the first word that is none of the page's.
    ///
    /// # Errors
    ///
    /// That word.
    pub(super) fn of_words(words: &[String]) -> Result<Self, String> {
        let mut choices = Self::new(None);
        let (verb, rest) = words.split_first().ok_or("")?;
        if verb != "prepare" {
            return Err(verb.clone());
        }
        let mut words = rest.iter();
        while let Some(word) = words.next() {
            if !word.starts_with('-') {
                choices.add_word(word)?;
                continue;
            }
            if word == "--cut" {
                let cut = words.next().ok_or_else(|| word.clone())?;
                let cuts = if choices.cuts == "auto" { cut.clone() } else { format!("{};{cut}", choices.cuts) };
                choices.set("cuts", &cuts, &[]).map_err(|_| format!("{word} {cut}"))?;
                continue;
            }
            let name = FLAGS.iter().find(|(flag, _)| flag == word).map(|(_, name)| *name);
            let (name, value) = name.zip(words.next()).ok_or_else(|| word.clone())?;
            let known = is_file(value) || shipped(value).is_ok();
            let value = if (name, value.as_str()) == ("up", "auto") { "recommended" } else { value };
            let machines = if known { &[value.to_owned()][..] } else { &[] };
            choices.set(name, value, machines).map_err(|_| format!("{word} {value}"))?;
        }
        Ok(choices)
    }

    /// Adds the model that a word names; each once.
    fn add_word(&mut self, word: &str) -> Result<(), String> {
        let counted = word.rsplit_once('*').and_then(|(path, n)| Some((path, n.parse().ok()?)));
        let (path, copies) = counted.unwrap_or((word, 1));
        let good =
            (1..=MOST_COPIES).contains(&copies) && is_below(path) && !self.models.iter().any(|one| one.path == path);
        if !good {
            return Err(word.to_owned());
        }
        self.models.push(ChosenModel { id: self.models.len() as u64, path: path.to_owned(), copies });
        Ok(())
    }

    /// The files that it names, each once: models, and the machine where that is one.
    pub(super) fn files(&self) -> Vec<&str> {
        let machine = self.machine.as_deref().filter(|machine| is_file(machine));
        self.models.iter().map(|model| model.path.as_str()).chain(machine).collect()
    }

    /// Gives every file a name that it can have in a project, and the machine too where it `is_a_file`; the models' files and those names.
    pub(super) fn name_for_project(&mut self, is_a_file: bool) -> Vec<(String, String)> {
        let mut taken: BTreeSet<String> = ["project.json", "plan.json"].map(str::to_owned).into();
        let mut free = |path: &str, ending: &str| {
            let plain = if is_below(path) {
                path.to_owned()
            } else {
                plain_of(path.rsplit(['/', '\\']).next().unwrap_or(path))
            };
            let plain = if plain.ends_with(ending) { plain } else { format!("{plain}{ending}") };
            let (stem, end) = plain.rsplit_once('.').unwrap_or((&plain, ""));
            let names = std::iter::once(plain.clone()).chain((2_u32..).map(|n| format!("{stem}-{n}.{end}")));
            let name = names.into_iter().find(|name| !taken.contains(name)).unwrap_or_default();
            taken.insert(name.clone());
            name
        };
        let mut names = Vec::new();
        for model in &mut self.models {
            let name = free(&model.path, "");
            names.push((std::mem::replace(&mut model.path, name.clone()), name));
        }
        if let Some(machine) = self.machine.as_mut().filter(|_| is_a_file) {
            *machine = free(machine, ".toml");
        }
        names
    }

    /// Gives files other names.
    pub(super) fn renamed(&mut self, files: &BTreeMap<String, String>) {
        let paths = self.models.iter_mut().map(|model| &mut model.path).chain(&mut self.machine);
        paths.for_each(|path| files.get(path).into_iter().for_each(|name| path.clone_from(name)));
    }

    /// Gives models other files.
    pub(super) fn moved(&mut self, files: &BTreeMap<u64, String>) {
        for model in &mut self.models {
            files.get(&model.id).into_iter().for_each(|path| model.path.clone_from(path));
        }
    }

    /// The words that name the models.
    pub(super) fn words_of_models(&self) -> Vec<String> {
        self.models.iter().map(ChosenModel::word).collect()
    }

    /// The file of this ending that preparing makes: called after the first model, and so that it is no other program's.
    pub(super) fn output(&self, ending: &str) -> Option<String> {
        let name = self.models.first()?.name();
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        Some(guarded(&format!("{stem}.trunnion.{ending}")))
    }

    /// The flags that name what preparing writes, with their files.
    pub(super) fn written(&self) -> Vec<[String; 2]> {
        let flags = ["-o", "--plan-out", "--preview"].into_iter().zip(ENDINGS);
        flags.filter_map(|(flag, ending)| Some([flag.to_owned(), self.output(ending)?])).collect()
    }

    /// The words of the command that inspects a model.
    pub(super) fn inspect(&self, index: usize) -> Vec<String> {
        let mut words = vec!["inspect".to_owned(), guarded(&self.models[index].path)];
        push(&mut words, "--unit", &self.unit);
        push(&mut words, "--plate", self.plate_of(index));
        words
    }

    /// The plate that is read of a model: the command takes one of its first model alone.
    pub(super) fn plate_of(&self, index: usize) -> &str {
        if index == 0 { &self.plate } else { "auto" }
    }

    fn push_cuts(&self, words: &mut Vec<String>) {
        let cuts = if self.cuts == "auto" { "" } else { &self.cuts };
        cuts.split(';')
            .filter(|cut| !cut.is_empty())
            .for_each(|cut| words.extend(["--cut".to_owned(), cut.to_owned()]));
    }

    /// The words of the command that makes the chosen cuts of a part and no others, and writes nothing.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NotYet`] with what is missing.
    pub(super) fn split(&self, part: &CutsOfPart) -> Result<Vec<String>, WorkbenchError> {
        let machine = self.machine.as_ref().ok_or(WorkbenchError::NotYet { what: "choose a machine" })?;
        let path = guarded(&self.models[part.model].path);
        let mut words = ["split", &path, "-m", machine].map(str::to_owned).to_vec();
        push(&mut words, "--unit", &self.unit);
        push(&mut words, "--plate", self.plate_of(part.model));
        words.extend(part.part.into_iter().flat_map(|part| ["--part".to_owned(), part.to_string()]));
        push(&mut words, "--finish", &self.finish);
        words.extend(part.cuts.iter().flat_map(|(_, cut)| ["--cut".to_owned(), cut.clone()]));
        words.extend(["--max-cuts".to_owned(), part.cuts.len().to_string()]);
        Ok(words)
    }

    /// The words of the command that prepares, without those that name what it writes.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::NotYet`] with what is missing.
    pub(super) fn prepare(&self) -> Result<Vec<String>, WorkbenchError> {
        if self.models.is_empty() {
            return Err(WorkbenchError::NotYet { what: "add a model" });
        }
        let machine = self.machine.as_ref().ok_or(WorkbenchError::NotYet { what: "choose a machine" })?;
        let mut words = vec!["prepare".to_owned()];
        words.extend(self.words_of_models());
        words.extend(["-m".to_owned(), machine.clone()]);
        self.push_reading(&mut words);
        push(&mut words, "--way", &self.way);
        if ["auto", "cut"].contains(&self.way.as_str()) {
            self.push_cuts(&mut words);
        }
        push(&mut words, "--order", &self.order);
        push(&mut words, "--finish", &self.finish);
        push(&mut words, "--slicer", &self.slicer);
        Ok(words)
    }
}

/// Chooses `value` where it is good.
fn put(place: &mut String, name: &'static str, value: &str, good: bool) -> Result<(), WorkbenchError> {
    if !good {
        return Err(WorkbenchError::BadChoice { name, value: value.to_owned() });
    }
    value.clone_into(place);
    Ok(())
}

/// Whether a machine's name is that of a file.
pub(super) fn is_file(machine: &str) -> bool {
    machine.to_ascii_lowercase().ends_with(".toml") || machine.contains(['/', '\\'])
}

/// Whether the command takes each word for a cut.
fn are_cuts(text: &str) -> bool {
    let cuts: Vec<&str> = text.split(';').collect();
    text.len() <= MOST_CUTS.0 && cuts.len() <= MOST_CUTS.1 && cuts.iter().all(|cut| GivenCut::parsed(cut).is_some())
}

/// Three numbers, not all of them 0.
fn is_direction(text: &str) -> bool {
    let numbers: Vec<Option<f64>> =
        text.split(',').map(|word| word.parse().ok().filter(|v: &f64| v.is_finite())).collect();
    numbers.len() == 3 && numbers.iter().all(Option::is_some) && numbers.iter().flatten().any(|v| *v != 0.0)
}

/// A flag and its value, where it is not `auto`.
pub(super) fn push(words: &mut Vec<String>, flag: &str, value: &str) {
    if value != "auto" {
        words.extend([flag.to_owned(), value.to_owned()]);
    }
}

/// A file that the command does not take for a flag.
pub(super) fn guarded(path: &str) -> String {
    if path.starts_with('-') { format!("./{path}") } else { path.to_owned() }
}

/// The command line of these words, quoted for a shell.
pub(super) fn line(words: &[String]) -> String {
    let plain = |word: &str| !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || "-_./:=,+@%".contains(c));
    let quoted = |word: &String| if plain(word) { word.clone() } else { format!("'{}'", word.replace('\'', r"'\''")) };
    std::iter::once("trunnion".to_owned()).chain(words.iter().map(quoted)).collect::<Vec<_>>().join(" ")
}
