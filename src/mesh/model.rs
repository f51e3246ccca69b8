//! A model: its parts, what they share, and what stands on the table.

use std::collections::BTreeMap;

use hashbrown::{HashMap, HashSet};

use super::captive::{captive, catchers, is_joint};
use super::error::{Fault, FilePlace, Located};
use super::interface::{INTERFACE_ANGLE_DEG, Interface, interfaces, most_pairs};
use super::shells::Surface;
use super::soup::{OtherVolume, Soup};
use super::{ReadOptions, Repair, TriangleMesh, Unit, guess_unit, parts, warnings, winding};
use crate::geom::{Bounds, Object, Vec3};
use crate::spelling::{part_named, unnamed};

/// A part stands on the table up to this height above the model's lowest point, mm.
pub const TABLE_GAP_MM: f64 = 0.05;

/// Corners up to so far apart are joined where that closes a surface, mm: a tenth of a line.
const CRACK_MM: f64 = 0.04;

/// A closed piece of a model.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its place in [`Model::parts`], from 0, in the order of the first facets in the file.
    pub id: usize,
    /// The file's name for it, or else `part-<id>`; no two parts of a model share one.
    pub name: String,
    /// Its surface with the cavities in it, mm, facing out of the material; facets in file order.
    pub mesh: TriangleMesh<Object>,
}

/// A model in mm.
#[derive(Clone, Debug)]
pub struct Model {
    /// The parts; at least one.
    pub parts: Vec<Part>,
    /// What parts share, by ascending ids.
    pub interfaces: Vec<Interface>,
    /// Ids of the parts that stand on the table, ascending: those with a face at the lowest z, and those with only an
    /// edge or corner there that nothing else holds (with a warning). Never empty.
    pub on_table: Vec<usize>,
    /// Ids of the parts that touch nothing and cannot be pulled straight out of those around them, ascending: the roller of a bearing, a link of a
    /// chain. They are printed in place, with what stands on the table.
    pub captive: Vec<usize>,
    /// The unit that the file's numbers were read in.
    pub unit: Unit,
    /// What was guessed, mended or passed over, one sentence each.
    pub warnings: Vec<String>,
    /// The box around all parts, mm.
    pub bounds: Bounds,
    /// Volumes of the file that are not printed.
    pub others: Vec<OtherVolume>,
}

/// A closed volume that is to be cut away from parts.
#[derive(Clone, Debug)]
pub struct Away {
    /// The file's name for it.
    pub name: String,
    /// Its surface, mm.
    pub mesh: TriangleMesh<Object>,
    /// From which parts, where they meet it: those of its object.
    pub parts: Vec<usize>,
}

/// A model as its file has it, with what is still to be done to its parts.
#[derive(Clone, Debug)]
pub struct DrawnModel {
    /// The parts.
    pub model: Model,
    /// Volumes that are to be cut away from them.
    pub away: Vec<Away>,
    /// Parts that are one solid where they overlap: those of one object of a slicer's project. Each ascending, two at least.
    pub objects: Vec<Vec<usize>>,
}

impl Model {
    /// A model of `parts` (name and closed mesh, mm) whose interfaces are looked for; ids are given in order.
    ///
    /// The meshes are taken as they are: closed and facing outward is for the caller to see to.
    pub fn from_parts(parts: Vec<(String, TriangleMesh<Object>)>) -> Self {
        let parts = numbered(parts);
        let interfaces = interfaces(&parts, usize::MAX).unwrap_or_default();
        Self::joined(parts, interfaces)
    }

    /// The same of a stranger's file.
    fn from_file(parts: Vec<(String, TriangleMesh<Object>)>) -> Result<Self, Located> {
        let parts = numbered(parts);
        let most = most_pairs(parts.len());
        let crowded = || Fault::Crowded { parts: parts.len(), most }.at(FilePlace::File);
        let interfaces = interfaces(&parts, most).ok_or_else(crowded)?;
        Ok(Self::joined(parts, interfaces))
    }

    /// What stands on the table, what is caught, and what is said of the parts.
    fn joined(parts: Vec<Part>, interfaces: Vec<Interface>) -> Self {
        let bounds = parts.iter().fold(Bounds::EMPTY, |all, part| all.union(&part.mesh.bounds()));
        let (unit, warnings) = (Unit::Millimetre, winding::overlaps(&parts));
        let mut model = Self {
            parts,
            interfaces,
            on_table: Vec::new(),
            captive: Vec::new(),
            unit,
            warnings,
            bounds,
            others: Vec::new(),
        };
        model.find_table();
        let held = model.held();
        model.captive = captive(&model.parts, &held);
        let told = model.captive.iter().map(|&id| is_captive(&model.parts[id]));
        model.warnings.extend(told.collect::<Vec<String>>());
        model
    }

    /// The model, and what is still to be done to its parts.
    pub(super) fn from_soup(mut soup: Soup, options: &ReadOptions) -> Result<DrawnModel, Located> {
        let facets = soup.facets.len();
        let mut mended: Vec<String> = Vec::new();
        let dropped = soup.weld();
        if dropped > 0 {
            mended.push(format!("{dropped} facets that use one vertex twice were removed"));
            soup.warnings.extend(mended.last().cloned());
        }
        let unit = choose_unit(&mut soup, options.unit);
        let said = soup.warnings.len();
        let mended_to = (options.repair != Repair::Off).then(|| CRACK_MM / unit.millimetres());
        let surfaces = parts::parts(&mut soup, mended_to)?;
        mended.extend_from_slice(&soup.warnings[said..]);
        if let ([first, others @ ..], Repair::Strict) = (&mended[..], options.repair) {
            return Err(Fault::Mended { first: first.clone(), others: others.len() }.at(FilePlace::File));
        }
        if surfaces.is_empty() {
            return Err(Fault::Collapsed { facets }.at(FilePlace::File));
        }
        let label = |surface: &Surface| &soup.names[soup.labels[surface.source[0] as usize] as usize];
        let (away, surfaces): (Vec<Surface>, Vec<Surface>) = surfaces.into_iter().partition(|one| label(one).away);
        if surfaces.is_empty() {
            let first = format!("{} is subtracted", label(&away[0]).away_called());
            return Err(Fault::NothingPrinted { first, others: away.len() - 1 }.at(FilePlace::File));
        }
        let named = surfaces.iter().enumerate().map(|(id, surface)| {
            let name = label(surface).name.clone().unwrap_or_else(|| unnamed(id));
            (name, mesh(&soup.vertices, surface, unit.millimetres()))
        });
        let mut model = Self::from_file(named.collect())?;
        let of = |object: u32| (0..surfaces.len()).filter(|&id| label(&surfaces[id]).object == object).collect();
        let away = away.iter().map(|surface| Away {
            name: label(surface).away_called(),
            mesh: mesh(&soup.vertices, surface, unit.millimetres()),
            parts: of(label(surface).object),
        });
        let away: Vec<Away> = away.collect();
        model.others = std::mem::take(&mut soup.others);
        let mut objects: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (id, surface) in surfaces.iter().enumerate().filter(|_| soup.is_project) {
            objects.entry(label(surface).object).or_default().push(id);
        }
        let objects = objects.into_values().filter(|parts| parts.len() > 1).collect();
        model.unit = unit;
        soup.warnings.append(&mut model.warnings);
        model.warnings = soup.warnings;
        warnings::keep(&mut model.warnings);
        Ok(DrawnModel { model, away, objects })
    }

    /// Ids of the parts that neither stand on the table, nor are [captive](Self::captive), nor hang together, through interfaces, with one that is
    /// either; ascending, empty for a model that can be built up from the table.
    pub fn floating(&self) -> Vec<usize> {
        let held = self.held();
        (0..self.parts.len()).filter(|&id| !held[id]).collect()
    }

    /// Ids of the parts that are printed upright, first of all and together: those that stand on the table and the captive ones; ascending.
    pub fn in_place(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.on_table.iter().chain(&self.captive).copied().collect();
        all.sort_unstable();
        all
    }

    /// Whether a part is one of these.
    pub fn is_in_place(&self, part: usize) -> bool {
        self.on_table.contains(&part) || self.captive.contains(&part)
    }

    /// Whether two parts make a joint: they are of different bodies, and one is [captive](Self::captive) or could not be pulled out of the other.
    /// What stands in the gap between them is caught as well.
    pub fn is_joint(&self, one: usize, other: usize) -> bool {
        let bodies = self.bodies();
        bodies[one] != bodies[other]
            && ([one, other].iter().any(|part| self.captive.contains(part))
                || is_joint(&self.parts[one].mesh, &self.parts[other].mesh))
    }

    /// By part, whether it hangs together with one that is printed in place.
    fn held(&self) -> Vec<bool> {
        let (beside, mut held) = (self.beside(), vec![false; self.parts.len()]);
        self.in_place().into_iter().for_each(|id| hold(id, &beside, &mut held));
        held
    }

    /// By part, the first part of its body: parts that hang together through interfaces, directly or through others, are one.
    pub fn bodies(&self) -> Vec<usize> {
        let (beside, none) = (self.beside(), usize::MAX);
        let mut body = vec![none; self.parts.len()];
        for first in 0..body.len() {
            let mut reached = if body[first] == none { vec![first] } else { Vec::new() };
            while let Some(part) = reached.pop() {
                body[part] = first;
                reached.extend(beside[part].iter().filter(|&&other| body[other] == none));
            }
        }
        body
    }

    /// The same where what is [captive](Self::captive) belongs to what stands around it: of several bodies to the one whose box it shares most.
    /// For whoever asks whether things stand: what is caught cannot fall over, and rests on what caught it.
    pub fn standing_bodies(&self) -> Vec<usize> {
        let mut bodies = self.bodies();
        for (id, other) in catchers(&self.parts, &self.captive, &self.on_table) {
            bodies[id] = bodies[other];
        }
        bodies
    }

    /// By part, those that share a face with it.
    fn beside(&self) -> Vec<Vec<usize>> {
        let mut beside = vec![Vec::new(); self.parts.len()];
        for one in &self.interfaces {
            beside[one.a].push(one.b);
            beside[one.b].push(one.a);
        }
        beside
    }

    /// The warnings that hold in whatever pose the model is printed.
    pub fn warnings_in_any_pose(&self) -> impl Iterator<Item = &String> {
        let tips: HashSet<String> = self.parts.iter().map(on_a_tip).collect();
        self.warnings.iter().filter(move |text| !tips.contains(*text))
    }

    fn find_table(&mut self) {
        let low = self.bounds.min.z + TABLE_GAP_MM;
        let touching = self.parts.iter().filter(|part| part.mesh.bounds().min.z <= low);
        let (mut standing, tips): (Vec<usize>, Vec<usize>) =
            touching.map(|part| part.id).partition(|&id| has_foot(&self.parts[id].mesh, low));
        let (beside, mut held) = (self.beside(), vec![false; self.parts.len()]);
        standing.iter().for_each(|&id| hold(id, &beside, &mut held));
        for id in tips {
            if !held[id] {
                standing.push(id);
                hold(id, &beside, &mut held);
                self.warnings.push(on_a_tip(&self.parts[id]));
            }
        }
        standing.sort_unstable();
        self.on_table = standing;
    }
}

/// Marks what hangs together with part `id` as held.
fn hold(id: usize, beside: &[Vec<usize>], held: &mut [bool]) {
    let mut queue = vec![id];
    while let Some(id) = queue.pop() {
        if !std::mem::replace(&mut held[id], true) {
            queue.extend(&beside[id]);
        }
    }
}

fn is_captive(part: &Part) -> String {
    let who = part_named(part.id, &part.name);
    format!(
        "{who} is captive: it touches no other part and cannot be pulled out of those around it, so it is printed in place as drawn"
    )
}

fn on_a_tip(part: &Part) -> String {
    format!("{} touches the table at an edge or corner only: 0 mm2 of contact", part_named(part.id, &part.name))
}

/// Whether a facet below `low` faces down.
fn has_foot(mesh: &TriangleMesh<Object>, low: f64) -> bool {
    let down = -INTERFACE_ANGLE_DEG.to_radians().cos();
    (0..mesh.facets().len()).any(|facet| {
        mesh.corners(facet).iter().all(|corner| corner.z <= low) && mesh.normal(facet).is_some_and(|n| n.z < down)
    })
}

/// The caller's word, or else the file's, or else a guess.
fn choose_unit(soup: &mut Soup, given: Option<Unit>) -> Unit {
    match (given, soup.unit) {
        (Some(given), Some(stated)) if given != stated => {
            soup.warnings.push(format!("the file states {stated}; read as {given}, as requested"));
            given
        }
        (Some(unit), _) | (None, Some(unit)) => unit,
        (None, None) => {
            let size = Bounds::of(soup.vertices.iter().copied()).size();
            let (unit, warning) = guess_unit(size.max());
            soup.warnings.extend(warning);
            unit
        }
    }
}

/// The part's mesh with its vertices numbered in the order of first use, scaled to mm.
fn mesh(vertices: &[Vec3], surface: &Surface, scale: f64) -> TriangleMesh<Object> {
    let mut number = HashMap::new();
    let mut own = Vec::new();
    let facets = surface.facets.iter().map(|facet| {
        facet.map(|index| {
            *number.entry(index).or_insert_with(|| {
                own.push(vertices[index as usize] * scale);
                own.len() as u32 - 1
            })
        })
    });
    let facets = facets.collect();
    TriangleMesh::new(own, facets)
}

/// With their places as ids, and names of their own.
fn numbered(parts: Vec<(String, TriangleMesh<Object>)>) -> Vec<Part> {
    let mut names = HashMap::new();
    let part = |(id, (name, mesh))| Part { id, name: unique(&mut names, name), mesh };
    parts.into_iter().enumerate().map(part).collect()
}

/// `name`, or `name-2`, `name-3` ... where it is taken; `names` has all that are, each with the last number tried.
fn unique(names: &mut HashMap<String, u32>, name: String) -> String {
    let mut number = names.get(&name).copied().unwrap_or(0);
    if number == 0 {
        names.insert(name.clone(), 1);
        return name;
    }
    let free = loop {
        number += 1;
        let tried = format!("{name}-{number}");
        if !names.contains_key(&tried) {
            break tried;
        }
    };
    names.insert(name, number);
    names.insert(free.clone(), 1);
    free
}
