//! 3MF: build items and components place the objects of its model files. File units throughout; frames are the file's own.
//!
//! Source: 3MF Consortium, *Core Specification* 1.3, 3 and 4.

use std::collections::{BTreeMap, BTreeSet};

use super::plates::ProjectPlates;
use super::roles::{Aside, Role, Roles, Volume};
use super::threemf_package::Package;
use super::threemf_xml::{Object, Reference, Transform};
use crate::geom::{Bounds, Vec3};
use crate::mesh::error::{Fault, FilePlace, Located, coordinate};
use crate::mesh::soup::{Label, MAX_FACETS, Soup};
use crate::mesh::{OtherVolume, TriangleMesh, Unit};

/// What reaches so far below its project's table was put there, mm.
const SUNK_MM: f64 = 0.01;
/// Components within components; deeper ones only go round in a circle.
const MAX_DEPTH: usize = 32;
/// The most placed objects, so that components that double level by level end: what looks for shared faces looks at pairs. As many as a
/// packed plate has at most.
const MAX_BODIES: usize = 5000;

/// Facets that any archive may place, some 600 MB of memory, and for each of its bytes besides: a large archive has large meshes, and
/// places each a few times.
const PLACED_FACETS: usize = 8_000_000;
const FACETS_PER_BYTE: usize = 40;

/// Reads every build item, in order; each mesh that an item places is a body of its own.
pub(super) fn read(bytes: &[u8], plates: ProjectPlates) -> Result<Soup, Located> {
    let mut package = Package::open(bytes)?;
    let root = package.root_path();
    let roles = package.roles()?;
    let mut ignored = package.ignored();
    package.load(&root)?;
    ignored.extend(package.files[&root].without_settings(roles.known));
    let mut build = Build::new(package, roles, plates).counted_first(&root)?;
    build.counting = false;
    build.object = 0;
    build.place_all(&root)?;
    build.below_the_table(build.package.files[&root].unit)?;
    build.soup.unit = Some(build.package.files[&root].unit);
    build.soup.is_project = build.roles.known;
    let Build { mut soup, left_out, .. } = build;
    if let (true, [first, others @ ..]) = (soup.facets.is_empty(), &left_out[..]) {
        return Err(Fault::NothingPrinted { first: first.clone(), others: others.len() }.at(FilePlace::File));
    }
    let mut told = BTreeSet::new();
    soup.warnings = ignored.into_iter().chain(soup.warnings).chain(left_out).collect();
    soup.warnings.retain(|text| told.insert(text.clone()));
    Ok(soup)
}

/// Facets that are placed; nothing is made of them.
pub(super) fn placed(bytes: &[u8], plates: ProjectPlates) -> Result<usize, Located> {
    let mut package = Package::open(bytes)?;
    let root = package.root_path();
    let roles = package.roles()?;
    package.load(&root)?;
    package.files[&root].without_settings(roles.known);
    let [_, facets, _] = Build::new(package, roles, plates).counted_first(&root)?.counted;
    Ok(facets)
}

/// Objects being placed into the soup.
struct Build<'a> {
    package: Package<'a>,
    soup: Soup,
    /// What is said of volumes that are not printed.
    left_out: Vec<String>,
    /// The objects that lead to the current one.
    trail: Vec<(String, String)>,
    /// Whether objects are only counted.
    counting: bool,
    /// Objects, facets and vertices so far.
    counted: [usize; 3],
    /// Facets that may be placed.
    allowed: usize,
    roles: Roles,
    plates: ProjectPlates,
    /// The item that is being placed, by number.
    object: u32,
}

impl<'a> Build<'a> {
    fn new(package: Package<'a>, roles: Roles, plates: ProjectPlates) -> Self {
        let allowed = (package.packed as usize).saturating_mul(FACETS_PER_BYTE).clamp(PLACED_FACETS, MAX_FACETS);
        Self {
            package,
            soup: Soup::default(),
            left_out: Vec::new(),
            trail: Vec::new(),
            counting: true,
            counted: [0; 3],
            allowed,
            roles,
            plates,
            object: 0,
        }
    }

    /// Itself, with everything counted and nothing made: what is too much costs no memory.
    fn counted_first(mut self, root: &str) -> Result<Self, Located> {
        self.package.load(root)?;
        self.place_all(root)?;
        let objects = &self.package.files[root].objects;
        let has = |id: &str, part: Option<&str>| {
            let object = objects.get(id);
            object.is_some_and(|object| part.is_none_or(|part| object.components.iter().any(|c| c.id == part)))
        };
        if let Some(id) = self.roles.unknown(has) {
            let trouble = "has a volume in the project's settings that the model does not have";
            return Err(Fault::Object { id: id.to_owned(), trouble }.at(FilePlace::File));
        }
        Ok(self)
    }

    fn place_all(&mut self, root: &str) -> Result<(), Located> {
        let items = self.package.files[root].items.clone();
        let told: Vec<(&str, bool)> = items.iter().map(|item| (&*item.id, item.printed)).collect();
        let chosen = self.roles.plates.chosen(&told, self.plates).map_err(|fault| fault.at(FilePlace::File))?;
        if let (Some(all), true) = (chosen.all, self.counting) {
            self.soup.warnings.push(format!("the project has {all}; all of them are read"));
        }
        let mut seen = BTreeSet::new();
        let each = items.iter().zip(chosen.items.iter().zip(&chosen.lost));
        each.filter(|(_, (chosen, lost))| **chosen || **lost).try_for_each(|(item, (_, lost))| {
            self.object += 1;
            let role = if *lost {
                Role::Aside(Aside::OffPlate)
            } else if item.printed {
                Role::Part
            } else {
                Role::Aside(Aside::Unprinted)
            };
            if seen.insert(&item.id) && !self.counting && role == Role::Part {
                let name = self.package.files[root].objects.get(&item.id).and_then(|object| object.name.as_deref());
                let called = name.or_else(|| self.roles.name(&item.id).map(String::as_str));
                self.soup.warnings.extend(self.roles.settings(&item.id, called));
            }
            self.place(root, item, &Transform::IDENTITY, &Volume { role, name: None })
        })
    }

    /// What a slicer's project has below its table is cut off there, as the slicer does.
    fn below_the_table(&mut self, unit: Unit) -> Result<(), Located> {
        if !self.roles.known {
            return Ok(());
        }
        let Self { soup, .. } = self;
        let mut objects: BTreeMap<u32, (Bounds, Option<String>)> = BTreeMap::new();
        for (facet, label) in soup.facets.iter().zip(&soup.labels) {
            let label = &soup.names[*label as usize];
            if !label.away {
                let (bounds, _) = objects.entry(label.object).or_insert_with(|| (Bounds::EMPTY, label.name.clone()));
                facet.iter().for_each(|&v| *bounds = bounds.union(&Bounds::of([soup.vertices[v as usize]])));
            }
        }
        let least = SUNK_MM / unit.millimetres();
        for (object, (bounds, name)) in objects.into_iter().filter(|(_, (bounds, _))| bounds.min.z < -least) {
            if bounds.max.z <= least {
                let name = name.unwrap_or_else(|| "an object".to_owned());
                return Err(Fault::Below { name }.at(FilePlace::File));
            }
            let name = Some("the table of its project, into which it is sunk".to_owned());
            soup.names.push(Label { name, body: soup.names.len() as u32, object, away: true });
            let room = (bounds.max - bounds.min).norm();
            let around = |corner: Vec3, by: f64| corner + Vec3::repeat(by);
            let top = around(bounds.max, room);
            let below = TriangleMesh::<crate::geom::Object>::cuboid(&Bounds {
                min: around(bounds.min, -room),
                max: Vec3::new(top.x, top.y, 0.0),
            });
            let first = soup.vertices.len() as u32;
            soup.vertices.extend(below.vertices());
            below.facets().iter().for_each(|facet| soup.push(facet.map(|v| first + v)));
        }
        Ok(())
    }

    /// Takes an object into account.
    fn count(&mut self, id: &str, object: &Object) -> Result<(), Located> {
        // Objects without a mesh count as well: it is they who multiply.
        let volumes = 1 + self.roles.stretches(id).len();
        for (sum, more) in self.counted.iter_mut().zip([volumes, object.mesh.1.len(), object.mesh.0.len()]) {
            *sum += more;
        }
        let [objects, facets, vertices] = self.counted;
        if objects > MAX_BODIES {
            return Err(Fault::TooManyBodies { limit: MAX_BODIES }.at(FilePlace::File));
        }
        if facets.max(vertices / 3) > self.allowed {
            return Err(Fault::TooManyFacets { limit: self.allowed }.at(FilePlace::File));
        }
        Ok(())
    }

    /// Places an object as `volume` of what is around it.
    fn place(&mut self, path: &str, to: &Reference, outer: &Transform, volume: &Volume) -> Result<(), Located> {
        let path = to.path.as_deref().map_or(path, |path| path.trim_start_matches('/')).to_owned();
        let step = (path.clone(), to.id.clone());
        let trouble = |trouble| Fault::Object { id: to.id.clone(), trouble }.at(FilePlace::File);
        if self.trail.contains(&step) {
            return Err(trouble("is a component of itself"));
        }
        if self.trail.len() >= MAX_DEPTH {
            return Err(trouble("is nested more than 32 components deep"));
        }
        self.package.load(&path)?;
        let object = self.package.files[&path].objects.get(&to.id).cloned();
        let object = object.ok_or_else(|| trouble("is placed but not defined"))?;
        let transform = to.transform.then(outer);
        let name = volume.name.clone().filter(|_| volume.role != Role::Part).or_else(|| object.name.clone());
        let name = name.or_else(|| volume.name.clone()).or_else(|| self.roles.name(&to.id).cloned());
        let role = if volume.role == Role::Part { object.role } else { volume.role };
        if self.counting {
            self.count(&to.id, &object)?;
        } else if let Role::Aside(aside) = role {
            self.left_out.push(aside.told(name.as_deref()));
            self.soup.others.push(aside.other(name.as_deref()));
        } else {
            self.append(&to.id, &object, &transform, &Volume { role, name: name.clone() })?;
        }
        self.trail.push(step);
        let aside = matches!(role, Role::Aside(_)) && !self.counting;
        for component in object.components.iter().filter(|_| !aside) {
            let own = self.roles.component(&to.id, &component.id);
            let own = own.map_or(Volume { role, name: name.clone() }, Clone::clone);
            self.place(&path, component, &transform, &own)?;
        }
        self.trail.pop();
        Ok(())
    }

    fn append(&mut self, id: &str, object: &Object, transform: &Transform, of: &Volume) -> Result<(), Located> {
        let Self { soup, left_out, roles, object: number, .. } = self;
        let said = roles.stretches(id);
        let stretches = if said.is_empty() { &object.stretches[..] } else { said };
        let (number, away) = (*number, of.role == Role::Negative);
        soup.warnings.extend(object.painted.told(of.name.as_deref()));
        let label = |soup: &Soup, name: Option<String>, away: bool| Label {
            name,
            body: soup.names.len() as u32,
            object: number,
            away,
        };
        if away {
            soup.others.push(OtherVolume { name: of.name.clone().unwrap_or_default(), role: "negative" });
        }
        soup.names.push(label(soup, of.name.clone(), away));
        let first = soup.vertices.len() as u32;
        for at in &object.mesh.0 {
            let at = transform.point(at);
            let checked =
                |value| coordinate(value).map_err(|fault| fault.at(FilePlace::Facet(soup.facets.len() as u64)));
            let at = Vec3::new(checked(at.x)?, checked(at.y)?, checked(at.z)?);
            soup.vertices.push(at);
        }
        // A mirrored solid would face inward.
        let turned = |[a, b, c]: [u32; 3]| if transform.mirrors() { [a, c, b] } else { [a, b, c] };
        let placed = |facet: &[u32; 3]| turned(*facet).map(|v| first + v);
        let facets = &object.mesh.1;
        if stretches.iter().any(|(stretch, _)| stretch.end > facets.len()) {
            let trouble = "has a volume in the project's settings with triangles that its mesh does not have";
            return Err(Fault::Object { id: id.to_owned(), trouble }.at(FilePlace::File));
        }
        let mut free = vec![true; facets.len()];
        stretches.iter().for_each(|(stretch, _)| free[stretch.clone()].fill(false));
        facets.iter().zip(&free).filter(|(_, free)| **free).for_each(|(facet, _)| soup.push(placed(facet)));
        let alone = stretches.iter().filter(|(_, volume)| volume.role == Role::Part).count() == 1;
        for (stretch, volume) in stretches {
            // An object of one part is called as the object.
            let of_object = of.name.clone().filter(|_| alone && volume.role == Role::Part);
            let name = of_object.or_else(|| volume.name.clone()).or_else(|| of.name.clone());
            match volume.role {
                Role::Aside(aside) => {
                    left_out.push(aside.told(name.as_deref()));
                    soup.others.push(aside.other(name.as_deref()));
                }
                role => {
                    if role == Role::Negative {
                        soup.others.push(OtherVolume { name: name.clone().unwrap_or_default(), role: "negative" });
                    }
                    soup.names.push(label(soup, name, away || role == Role::Negative));
                    facets[stretch.clone()].iter().for_each(|facet| soup.push(placed(facet)));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{MAX_BODIES, ProjectPlates};
    use crate::geom::{Bounds, Vec3};
    use crate::mesh::Unit;
    use crate::mesh::error::Fault;
    use crate::mesh::read::threemf_xml::MAX_NAMED;
    use crate::mesh::soup::Soup;
    use crate::mesh::write::zipped;

    /// A right-angled corner of legs 1, 2, 3.
    const MESH: &str = r#"<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>
        <vertex x="0" y="2" z="0"/><vertex x="0" y="0" z="3"/></vertices><triangles>
        <triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/>
        <triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh>"#;

    fn read_all(bytes: &[u8]) -> Result<Soup, super::Located> {
        super::read(bytes, ProjectPlates::All)
    }

    fn model(objects: &str, build: &str) -> Vec<u8> {
        let text = format!(
            r#"<?xml version="1.0"?><m:model unit="inch" xmlns:m="x"><resources>{objects}</resources>
            <build>{build}</build></m:model>"#
        );
        zipped(&[("3D/3dmodel.model", text.as_bytes())])
    }

    fn box_of(soup: &Soup, facets: std::ops::Range<usize>) -> Bounds {
        Bounds::of(soup.facets[facets].iter().flatten().map(|&i| soup.vertices[i as usize]))
    }

    #[test]
    fn places_items_and_nested_components() {
        let objects = format!(
            r#"<object id="1" name="corner &amp; leg">{MESH}</object>
            <object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 10 0 0"/></components></object>
            <object id="3" name="pair"><components><component objectid="2"/>
              <component objectid="2" transform="2 0 0 0 1 0 0 0 1 0 0 5"/></components></object>"#
        );
        // A quarter turn about +Z takes x to y: the rows of a 3MF matrix are the images of the axes.
        let build = r#"<item objectid="3" transform="0 1 0 -1 0 0 0 0 1 0 0 100"/><item objectid="1"/>"#;
        let soup = read_all(&model(&objects, build)).unwrap();
        assert_eq!(soup.unit, Some(Unit::Inch));
        assert_eq!(soup.facets.len(), 12);
        let one = box_of(&soup, 0..4);
        assert_eq!((one.min, one.max), (Vec3::new(-2.0, 10.0, 100.0), Vec3::new(0.0, 11.0, 103.0)));
        let two = box_of(&soup, 4..8);
        assert_eq!((two.min, two.max), (Vec3::new(-2.0, 20.0, 105.0), Vec3::new(0.0, 22.0, 108.0)));
        assert_eq!(box_of(&soup, 8..12).max, Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(soup.names[soup.labels[0] as usize].name.as_deref(), Some("corner & leg"));
        assert_ne!(soup.labels[0], soup.labels[4]);
    }

    #[test]
    fn a_mirrored_item_still_faces_outward() {
        let objects = format!(r#"<object id="1">{MESH}</object>"#);
        let soup = read_all(&model(&objects, r#"<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>"#)).unwrap();
        let volume: f64 = soup
            .facets
            .iter()
            .map(|f| {
                let [a, b, c] = f.map(|i| soup.vertices[i as usize]);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum();
        assert!((volume - 1.0).abs() < 1e-12, "{volume}");
    }

    #[test]
    fn references_that_lead_nowhere_or_in_a_circle_are_refused() {
        let circle = r#"<object id="1"><components><component objectid="2"/></components></object>
            <object id="2"><components><component objectid="1"/></components></object>"#;
        let error = read_all(&model(circle, r#"<item objectid="1"/>"#)).unwrap_err();
        assert_eq!(error.fault, Fault::Object { id: "1".to_owned(), trouble: "is a component of itself" });
        let error = read_all(&model("", r#"<item objectid="7"/>"#)).unwrap_err();
        assert_eq!(error.fault, Fault::Object { id: "7".to_owned(), trouble: "is placed but not defined" });
    }

    #[test]
    fn bad_numbers_and_bad_archives_are_refused() {
        let objects = |from: &str, to: &str| format!(r#"<object id="1">{}</object>"#, MESH.replacen(from, to, 1));
        let fails =
            |from: &str, to: &str| read_all(&model(&objects(from, to), r#"<item objectid="1"/>"#)).unwrap_err().fault;
        assert_eq!(fails("v3=\"1\"", "v3=\"4\""), Fault::IndexOutOfRange { index: 4, count: 4, first: 0 });
        assert!(matches!(fails("x=\"1\"", "x=\"NaN\""), Fault::NotFinite { .. }));
        assert_eq!(fails("x=\"1\"", "x=\"1e8\""), Fault::TooLarge { value: 1e8 });
        assert_eq!(fails("x=\"1\"", "x=\"a\""), Fault::Syntax { found: "a".to_owned(), expected: "a number" });
        assert!(matches!(fails("y=\"0\"", ""), Fault::Syntax { .. }));
        assert!(matches!(fails("</mesh>", "</mess>"), Fault::Xml { .. }));
        let cut = format!(
            r#"<model><build><item objectid="1"/></build><object id="1">{}"#,
            MESH.replace("v3=\"1\"", "v3=\"4\"")
        );
        let cut = zipped(&[("3D/3dmodel.model", cut.as_bytes())]);
        assert_eq!(read_all(&cut).unwrap_err().fault, Fault::IndexOutOfRange { index: 4, count: 4, first: 0 });
        assert!(matches!(read_all(b"PK\x03\x04rubbish").unwrap_err().fault, Fault::Archive { .. }));
        assert!(matches!(read_all(&zipped(&[("a", b"b")])).unwrap_err().fault, Fault::Archive { .. }));
    }

    #[test]
    fn an_archive_that_unpacks_to_far_more_than_its_size_is_refused() {
        let padded = |mebibytes: usize, between: &str| {
            let pad = format!("{}{between}", " ".repeat((1 << 20) - between.len())).repeat(mebibytes);
            let objects = format!(r#"<object id="1">{MESH}</object>{pad}"#);
            model(&objects, r#"<item objectid="1"/>"#)
        };
        assert_eq!(read_all(&padded(63, "<x/>")).unwrap().facets.len(), 4);
        let bomb = padded(65, "<x/>");
        let fault = Fault::Unpacked { packed: bomb.len() as u64, allowed: 64 << 20 };
        assert!(bomb.len() < 1 << 20, "{} bytes", bomb.len());
        assert!(fault.to_string().contains(" 64 MiB"), "{fault}");
        assert_eq!(read_all(&bomb).unwrap_err().fault, fault);
        assert!(matches!(read_all(&padded(20, "")).unwrap_err().fault, Fault::Unpacked { .. }), "one text of 20 MiB");
        // Two files of half the size each are as large together.
        let rels = |to: &str| format!(r#"<component p:path="/{to}.model" objectid="1"/>"#);
        let root = format!(
            r#"<model xmlns:p="p"><resources><object id="5"><components>{}{}</components></object></resources>
            <build><item objectid="5"/></build></model>"#,
            rels("a"),
            rels("b")
        );
        let pad = format!("{}<x/>", " ".repeat(1 << 20)).repeat(40);
        let half = format!(r#"<model><resources><object id="1">{MESH}</object>{pad}</resources></model>"#);
        let two = [("3D/3dmodel.model", root.as_str()), ("a.model", &half), ("b.model", &half)];
        let two = zipped(&two.map(|(name, text)| (name, text.as_bytes())));
        assert!(matches!(read_all(&two).unwrap_err().fault, Fault::Unpacked { .. }));
    }

    #[test]
    fn tags_that_each_take_much_room_are_counted() {
        let many = r#"<item objectid="1"/>"#.repeat(MAX_NAMED + 1);
        assert_eq!(read_all(&model("", &many)).unwrap_err().fault, Fault::TooManyObjects { limit: MAX_NAMED });
    }

    /// A few hundred bytes that place thousands of objects in one another, each of which would be held against all others.
    #[test]
    fn components_that_double_level_by_level_are_refused() {
        let doubled = |levels: usize| {
            let mut objects = format!(r#"<object id="1">{MESH}</object>"#);
            for level in 1..=levels {
                let next = level + 1;
                let twice = format!(r#"<component objectid="{level}"/>"#).repeat(2);
                objects += &format!(r#"<object id="{next}"><components>{twice}</components></object>"#);
            }
            model(&objects, &format!(r#"<item objectid="{}"/>"#, levels + 1))
        };
        assert_eq!(read_all(&doubled(9)).unwrap().facets.len(), 4 << 9);
        for levels in [12, 16, 31] {
            let fault = read_all(&doubled(levels)).unwrap_err().fault;
            assert_eq!(fault, Fault::TooManyBodies { limit: MAX_BODIES });
        }
    }

    /// A hundred kilobytes that would be fifty million facets.
    #[test]
    fn what_is_placed_is_counted_before_it_is_made() {
        let fan = |facets: usize| {
            let vertices = r#"<vertex x="0" y="0" z="0"/>"#.repeat(3);
            let facets = r#"<triangle v1="0" v2="1" v3="2"/>"#.repeat(facets);
            format!(
                r#"<object id="1"><mesh><vertices>{vertices}</vertices><triangles>{facets}</triangles></mesh></object>"#
            )
        };
        let placed = |facets: usize, times: usize| {
            let file = model(&fan(facets), &r#"<item objectid="1"/>"#.repeat(times));
            let package = super::Package::open(&file).unwrap();
            let made = super::Build::new(package, super::Roles::default(), ProjectPlates::All)
                .counted_first("3D/3dmodel.model");
            (made.map(|made| (made.soup.facets.len(), made.counted)), file.len())
        };
        for (facets, times) in [(10, 1), (10, 4900), (1000, 100)] {
            assert_eq!(placed(facets, times).0.unwrap(), (0, [times, times * facets, times * 3]));
        }
        let limit = super::PLACED_FACETS;
        for (facets, times) in [(10_000, 4900), (10_000, 801), (2000, 4001)] {
            let (refused, bytes) = placed(facets, times);
            assert!(bytes < 100_000, "{bytes}");
            assert_eq!(refused.err().unwrap().fault, Fault::TooManyFacets { limit });
        }
        assert!(placed(10_000, 800).0.is_ok());
    }

    #[test]
    fn characters_that_xml_forbids_are_refused() {
        let named = |name: &str| {
            read_all(&model(&format!(r#"<object id="1" name="{name}">{MESH}</object>"#), r#"<item objectid="1"/>"#))
        };
        for good in ["corner &#38; leg", "&#x41;&#9;&#x1f600;", "é"] {
            assert!(named(good).is_ok(), "{good}");
        }
        for bad in ["&#27;]0;x&#7;", "&#x1b;", "\u{1b}[2J", "&#xfffe;", "&#1;"] {
            let fault = named(bad).unwrap_err().fault;
            assert!(
                matches!(&fault, Fault::Xml { reason } if reason.ends_with("is not allowed in XML")),
                "{bad}: {fault:?}"
            );
        }
    }

    #[test]
    fn what_only_an_extension_tells_is_refused_by_name() {
        let text = |attributes: &str, inner: &str| {
            let objects = format!(r#"<object id="1">{}</object>"#, MESH.replace("</mesh>", &format!("{inner}</mesh>")));
            let text = format!(
                r#"<model {attributes}><resources>{objects}</resources><build><item objectid="1"/></build></model>"#
            );
            read_all(&zipped(&[("3D/3dmodel.model", text.as_bytes())])).map(|soup| soup.facets.len())
        };
        let space = |name: &str| format!("http://schemas.microsoft.com/3dmanufacturing/{name}");
        let needs =
            |prefix: &str, name: &str| format!(r#"requiredextensions="{prefix}" xmlns:{prefix}="{}""#, space(name));
        for (prefix, name) in [("p", "production/2015/06"), ("m", "material/2015/02"), ("q", "trianglesets/2021/07")] {
            assert_eq!(text(&needs(prefix, name), ""), Ok(4), "{name}");
        }
        for (prefix, name) in [("b", "beamlattice/2017/02"), ("s", "slice/2015/07"), ("p", "boolean/2023/07")] {
            let fault = Fault::Extension { name: format!("{prefix} ({})", space(name)) };
            assert_eq!(text(&needs(prefix, name), "").unwrap_err().fault, fault);
        }
        let undeclared = text(r#"requiredextensions="v""#, "").unwrap_err().fault;
        assert_eq!(undeclared, Fault::Extension { name: "v".to_owned() });
        // Not required, but there: its beams would be missing.
        let beams = r#"<b:beamlattice radius="1"><b:beams><b:beam v1="0" v2="1"/></b:beams></b:beamlattice>"#;
        let declared = format!(r#"xmlns:b="{}""#, space("beamlattice/2017/02"));
        let fault = text(&declared, beams).unwrap_err().fault;
        assert_eq!(fault, Fault::Extension { name: "beamlattice".to_owned() });
    }

    #[test]
    fn components_may_lie_in_other_files_that_the_relations_name() {
        let rels = r#"<Relationships><Relationship Target="/m/root.model" Id="r"
            Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;
        let root = r#"<model xmlns:p="p"><resources><object id="5"><components>
            <component p:path="/m/parts.model" objectid="1"/></components></object></resources>
            <build><item objectid="5"/></build></model>"#;
        let parts = format!(r#"<model><resources><object id="1">{MESH}</object></resources></model>"#);
        let bytes = zipped(&[
            ("_rels/.rels", rels.as_bytes()),
            ("m/root.model", root.as_bytes()),
            ("m/parts.model", parts.as_bytes()),
        ]);
        let soup = read_all(&bytes).unwrap();
        assert_eq!(soup.facets.len(), 4);
        assert_eq!(soup.unit, Some(Unit::Millimetre), "the default of the format");
    }
}
