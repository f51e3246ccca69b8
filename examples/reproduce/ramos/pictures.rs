//! The machine and the objects: figures 1, 2, 6, 8 and 13, and the drawings of sequences.

use trunnion::fixtures::{Fixture, candelabrum as menorah, ding as fork, two_boxes};
use trunnion::geom::{Rigid, Table, Vec3};
use trunnion::job::PlanResult;
use trunnion::mesh::{Model, read_model};
use trunnion::motion::Pose;
use trunnion::profile::Profile;
use trunnion::view::{Frame, Surface};

use super::super::chart::graph;
use super::super::item::{Item, Row};
use super::super::scene::{AMBER, BLUE, GREEN, GREY, frame, ghost, sheet, solid};
use super::super::sources::model;
use super::optima::fibr3d;
use super::orders::listed;

/// The table's slab, machine frame, as a surface: a lid and walls between its two outlines.
fn slab(profile: &Profile, pose: Pose) -> Surface {
    let motion = profile.kinematics().forward(pose);
    let points: Vec<Vec3> = profile.table_slab().iter().map(|p| motion.rotation * p + motion.translation).collect();
    let n = points.len() / 2;
    let mut facets = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        let [a, b, c, d] = [i, j, n + j, n + i].map(|k| k as u32);
        facets.extend([[a, c, b], [a, d, c]]);
        if i > 0 && j > 0 {
            facets.extend([[0, a, b], [n as u32, c, d]]);
        }
    }
    Surface::new(points, facets, AMBER)
}

/// The head's bodies with the tip at a place, seen through.
fn head(profile: &Profile, tip: &Vec3) -> Vec<trunnion::view::Ghost> {
    let bodies = profile.head_bodies();
    bodies.iter().map(|body| ghost(body.points.iter().map(|p| p + body.origin_at(tip)).collect(), BLUE)).collect()
}

/// Figure 1.
pub(super) fn machine() -> Item {
    let item = Item::figure("1", "Virtual representation of the five-axis printer (FIBR3DEmul)");
    let profile = match fibr3d() {
        Ok(profile) => profile,
        Err(error) => return item.row(Row::same("profile", "", error)),
    };
    let drawn = |pose: Pose, below: &str| {
        let slab = slab(&profile, pose);
        let tip =
            slab.points.iter().fold(Vec3::zeros(), |sum, p| sum + p) / slab.points.len() as f64 + Vec3::z() * 60.0;
        let ghosts = head(&profile, &tip);
        let mut made = frame(vec![slab], below);
        made.scope.extend(ghosts.iter().flat_map(|ghost| ghost.points.iter().copied()));
        Frame { ghosts, ..made }
    };
    let frames = vec![drawn(Pose::LEVEL, "table level"), drawn(Pose::from_deg(70.0, -90.0), "tilt 70, rotation -90")];
    let axes = profile.kinematics();
    let degrees_of_freedom = 3 + usize::from(axes.tilt.range.is_some()) + usize::from(axes.rotation.range.is_some());
    Item { ..item }
        .picture("table in amber, head and gantry in blue", sheet("Figure 1", 2, frames, Vec::new()))
        .row(Row::absolute("axes: x, y, z, tilt and rotation of the table", 5.0, degrees_of_freedom as f64, 0.0, "axes"))
        .note("Measures from the emulator's published sources (profile fibr3d); the paper prints a picture without numbers.")
}

/// Parts of a model, as it is drawn.
pub(super) fn whole(fixture: &Fixture, parts: &[usize], below: &str) -> Frame {
    let colours = [BLUE, GREEN, AMBER, AMBER];
    let surface = |&part: &usize| {
        let (name, colour) =
            if fixture.parts.len() > 4 { (None, BLUE) } else { (Some(part.to_string()), colours[part]) };
        solid(&fixture.parts[part].1, colour, name.as_deref())
    };
    frame(parts.iter().map(surface).collect(), below)
}

/// Figure 2.
pub(super) fn two_parts() -> Item {
    let fixture = two_boxes();
    // As its file is read: one STL with two closed shells.
    let read = read_model(&fixture.stl(), fixture.file, &Default::default()).map_or(0, |model| model.parts.len());
    Item::figure("2", "Object with two closed parts")
        .picture("", sheet("Figure 2", 1, vec![whole(&fixture, &[0, 1], "parts 0 and 1")], Vec::new()))
        .row(Row::absolute("closed parts read from one STL file", 2.0, read as f64, 0.0, "parts"))
        .note("The figure's own object is not described; this one is that of figure 7.")
}

/// Lines `a-b` of the parts that touch, and `table-a` of those that stand.
fn connections_of(model: &Model) -> Vec<String> {
    let table = model.on_table.iter().map(|part| format!("table-{part}"));
    table.chain(model.interfaces.iter().map(|one| format!("{}-{}", one.a, one.b))).collect()
}

/// Boxes for the table and the parts, and lines between those that touch.
fn drawn_graph(title: &str, model: &Model, at: impl Fn(usize) -> [f64; 2]) -> String {
    let table = ("table".to_owned(), [0.0, -1.0]);
    let parts = (0..model.parts.len()).map(|part| (part.to_string(), at(part)));
    let nodes: Vec<_> = std::iter::once(table).chain(parts).collect();
    let stand = model.on_table.iter().map(|part| (0, part + 1));
    let edges: Vec<_> = stand.chain(model.interfaces.iter().map(|one| (one.a + 1, one.b + 1))).collect();
    graph(title, &nodes, &edges)
}

/// Figure 6 and the second study.
pub(super) fn ding() -> Item {
    let fixture = fork();
    let model = model(fixture.clone());
    let drawing = sheet("Figure 6a", 1, vec![whole(&fixture, &[0, 1, 2, 3], "after Ding et al.")], Vec::new());
    let graph = drawn_graph("Figure 6b: connections", &model, |part| match part {
        2 | 3 => [2.0 * part as f64 - 5.0, 2.0],
        _ => [0.0, part as f64],
    });
    let (z, x) = ("+z", "+x");
    let printed =
        [("L5 = L7", format!("0 {z} | 1 {x} | 2 {z}, 3 {z}")), ("L13 = L15", format!("0 {x} | 1 {x} | 2 {z}, 3 {z}"))];
    Item::figure("6", "Complex object of Ding et al., its connections, and its sequences (section 5.4)")
        .picture("", drawing)
        .picture("", graph)
        .row(Row::same("connections", "table-0, 0-1, 1-2, 1-3", connections_of(&model).join(", ")))
        .rows(listed(&fixture, &[&[z, x], &[z, x], &[z], &[z]], &printed))
        .note("Measures are not printed; ours leave no room for a head between parts 2 and 3, as section 5.4 assumes.")
}

/// Figure 8.
pub(super) fn candelabrum() -> Item {
    let fixture = menorah();
    let facets: Vec<usize> = fixture.parts.iter().map(|(_, mesh)| mesh.facets().len()).collect();
    let all: Vec<usize> = (0..facets.len()).collect();
    let count = |what: &str, printed: f64, ours: usize| Row::absolute(what, printed, ours as f64, 0.0, "facets");
    Item::figure("8", "Candelabrum used as a complex case-study")
        .picture("", sheet("Figure 8", 1, vec![whole(&fixture, &all, "reconstructed")], Vec::new()))
        .row(Row::absolute("parts", 18.0, facets.len() as f64, 0.0, "parts"))
        .row(count("facets in all", 15190.0, facets.iter().sum()))
        .row(count("base", 740.0, facets[0]))
        .row(count("stem", 12.0, facets[1]))
        .row(count("an arm of boxes, two parts", 24.0, facets[2] + facets[3]))
        .row(count("smooth part 11 (section 6.1.4)", 1676.0, facets[11]))
        .row(
            Row::relative("a smooth arm, two parts", 4000.0, (facets[10] + facets[11]) as f64, 0.12)
                .because("printed as approximately 4000; 1676 for part 11 leaves less, so that all sum up to 15190"),
        )
}

/// Figure 13.
pub(super) fn connections() -> Item {
    let model = model(menorah());
    let slanted = [3, 5, 11, 13, 7, 8, 15, 17];
    let carried = |part: usize| {
        model.interfaces.iter().find(|one| one.b == part || one.a == part && one.a > 1).map(|one| one.a + one.b - part)
    };
    let place = |part: usize| slanted.iter().position(|&p| p == part).map(|i| i as f64 - 3.5);
    let at = |part: usize| match part {
        0 => [0.0, 0.0],
        1 => [0.0, 1.0],
        part => match place(part) {
            Some(x) => [x, 2.0],
            None => [carried(part).and_then(place).unwrap_or(0.0), 3.0],
        },
    };
    let edges = connections_of(&model);
    // From what section 6 says: a stem on a base, eight arms on the stem, one upright on each arm.
    Item::figure("13", "Graph of the parts' connections for the candelabrum")
        .picture("", drawn_graph("Figure 13: connections", &model, at))
        .row(Row::absolute("connections, the table's among them", 18.0, edges.len() as f64, 0.0, "lines"))
        .row(Row::same(
            "parts on the table",
            "0",
            model.on_table.iter().map(usize::to_string).collect::<Vec<_>>().join(" "),
        ))
        .row(Row::absolute(
            "parts on the stem",
            8.0,
            edges.iter().filter(|one| one.starts_with("1-")).count() as f64,
            0.0,
            "parts",
        ))
        .note("The graph's lines are those that the printed sequences need; its picture has no numbers in the text.")
}

/// What stands and what is printed at the pose of one print, and the head above that print's top.
pub(super) fn at_pose(title: &str, made: &PlanResult, before: &[usize], now: &[usize], shown: usize) -> String {
    let plan = &made.plan.plan;
    let Some(print) = plan.slots.iter().flat_map(|slot| &slot.prints).find(|print| print.part == shown) else {
        return String::new();
    };
    let Ok(profile) = fibr3d() else { return String::new() };
    let pose = Pose::from_deg(print.tilt_deg, print.rotation_deg);
    let motion = profile.kinematics().forward(pose);
    let placed = Rigid::<_, Table>::shift(Vec3::from(plan.placement.origin_mm));
    let model = &made.plan.model.model;
    let moved = |part: usize| model.parts[part].mesh.moved(&placed).moved(&motion);
    let surfaces =
        |parts: &[usize], colour| parts.iter().map(|&part| solid(&moved(part), colour, None)).collect::<Vec<_>>();
    let printed = moved(shown);
    let tip = printed.vertices().iter().copied().max_by(|a, b| a.z.total_cmp(&b.z)).unwrap_or_default();
    let all: Vec<Surface> = surfaces(before, GREY).into_iter().chain(surfaces(now, BLUE)).collect();
    let small = profile.head_bodies().into_iter().filter(|body| body.name != "gantry");
    let ghosts =
        small.map(|body| ghost(body.points.iter().map(|p| p + body.origin_at(&tip)).collect(), GREEN)).collect();
    let words = format!(
        "tilt {}, rotation {}; the head above part {shown}",
        print.tilt_deg.round(),
        print.rotation_deg.round()
    );
    sheet(title, 1, vec![Frame { ghosts, ..frame(all, &words) }], Vec::new())
}
