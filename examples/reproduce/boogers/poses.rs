//! Poses and what they cost: figures 1.1, 5.8, 5.9 and 6.1.

use trunnion::fixtures::bracket;
use trunnion::geom::{Angle, Object, Vec3};
use trunnion::mesh::TriangleMesh;
use trunnion::orient::{
    ContactArea, Facets, Multistart, Objective, ObjectiveSettings, Search, Starts, SupportVolumeColumn,
    SupportVolumeConvex, minima, objective as named, turned,
};
use trunnion::view::Frame;

use super::super::item::{Item, Kind, Row, figures};
use super::super::scene::{AMBER, BLUE, frame, painted, sheet, solid, tint};
use super::super::sources::Run;
use super::convex::upright;
use super::experiments::{Part, objective};

const COLUMNS: SupportVolumeColumn = SupportVolumeColumn { overhang: Angle::ZERO, resolution_mm: 0.25 };

/// Figure 1.1: the same part, with supports and without.
pub(super) fn direction() -> Item {
    let mesh = &bracket().parts[0].1;
    let facets = Facets::of(mesh);
    let pose = |up: Vec3, words: &str| frame(vec![solid(&turned::<_, Object>(mesh, &up), BLUE, None)], words);
    let volume = |up: &Vec3| COLUMNS.value(&facets, up);
    // As it stands the arm hangs; on its side nothing does.
    let (standing, lying) = (Vec3::z(), Vec3::y());
    Item::figure("1.1", "Influence of the build direction on the support volume")
        .stand_in("a bracket with one arm (fixtures/bracket.stl); the figure's part is not described")
        .picture(
            "",
            sheet("Figure 1.1", 2, vec![pose(lying, "needs no support"), pose(standing, "the arm hangs")], Vec::new()),
        )
        .row(Row::absolute("support volume in the left pose", 0.0, volume(&lying), 1e-6, "mm³"))
        .row(
            Row::same("in the right pose", "some", if volume(&standing) > 1.0 { "some" } else { "none" })
                .because(format!("{} mm³", figures(volume(&standing).round()))),
        )
}

pub(super) fn items(run: &Run) -> Vec<Item> {
    let part = Part::of(run);
    let mut items = extremes(&part);
    items.push(toppling(run));
    items
}

/// The part in a pose, its facets by what they add to the support volume.
fn posed(mesh: &TriangleMesh<Object>, facets: &Facets, up: &Vec3, words: &str) -> Frame {
    let costs = objective().by_facet(facets, up).unwrap_or_default();
    let per: Vec<f64> = costs.iter().zip(&facets.each).map(|(cost, facet)| cost / facet.area.norm()).collect();
    let most = per.iter().fold(0.0_f64, |most, cost| most.max(cost.abs()));
    frame(vec![painted(&turned::<_, Object>(mesh, up), |facet| Some(tint(per[facet] / most)))], words)
}

/// Figures 5.8 and 5.9: least and most support volume.
fn extremes(part: &Part) -> Vec<Item> {
    let f = objective();
    let search = Multistart { starts: 16, from: Starts::LatinHypercube, ..Multistart::default() };
    let least = search.search(&f, &part.facets).minima.first().copied();
    let smoothing = f.smoothing;
    let settings = ObjectiveSettings {
        overhang: smoothing.overhang,
        carrying: smoothing.carrying,
        k: smoothing.k,
        w: smoothing.w,
        ..ObjectiveSettings::default()
    };
    let minus = named("-1*support-volume", &settings).ok();
    let most = minus.and_then(|minus| search.search(&*minus, &part.facets).minima.first().copied());
    let drawn = Vec3::z();
    let instead = "see figure 5.2 for the part";
    let share = |up: &Vec3| f.value(&part.facets, up) / f.value(&part.facets, &drawn);
    let item = |number, caption, up: Vec3, printed: &str| {
        let value = f.value(&part.facets, &up);
        Item::figure(number, caption)
            .stand_in(instead)
            .picture(
                "blue adds, red carries",
                sheet(caption, 1, vec![posed(&part.mesh, &part.facets, &up, "")], Vec::new()),
            )
            .row(Row::open(
                "support volume",
                printed,
                format!(
                    "{} mm³, {} of that as drawn",
                    figures((value * 1e3).round() / 1e3),
                    figures((share(&up) * 100.0).round() / 100.0)
                ),
                "another part, or another number of facets",
            ))
    };
    let (Some(least), Some(most)) = (least, most) else { return Vec::new() };
    let ordered = f.value(&part.facets, &least.up) <= f.value(&part.facets, &most.up);
    vec![
        item(
            "5.8",
            "The pose with the least support volume",
            least.up,
            "15.1 mm³ at [-84, -131] (400 facets); 15.670 mm³, 77 % less than as drawn (10,000)",
        )
        .row(Row::same("least at most as large as most", "yes", if ordered { "yes" } else { "no" })),
        item("5.9", "The pose with the most support volume", most.up, "77 mm³ at [-22, 25]"),
    ]
}

/// Figure 6.1: few supports, and hardly anything on the bed.
fn toppling(run: &Run) -> Item {
    let caption = "A bunny in a pose with little support and little contact with the bed";
    let mesh = match run.mesh("bunny.off") {
        Ok(mesh) => upright(&mesh),
        Err(why) => return Item::left(Kind::Figure, "6.1", caption, why),
    };
    // 100 mm high, as somebody would print it.
    let scale = 100.0 / mesh.bounds().size().z;
    let mesh: TriangleMesh<Object> =
        TriangleMesh::new(mesh.vertices().iter().map(|p| p * scale).collect(), mesh.facets().to_vec());
    let facets = Facets::of(&mesh);
    let f = SupportVolumeConvex { overhang: Angle::from_deg(45.0) };
    let found = minima(&facets, &f, &Multistart::default(), None);
    let Some(best) = found.minima.first() else {
        return Item::left(Kind::Figure, "6.1", caption, "no minimum was found");
    };
    let contact = -ContactArea.value(&facets, &best.up);
    let pose: TriangleMesh<Object> = turned(&mesh, &best.up);
    let hangs = |facet: usize| pose.normal(facet).is_some_and(|n| n.z < -f64::sin(45f64.to_radians()));
    let picture = frame(vec![painted(&pose, |facet| hangs(facet).then_some(AMBER))], "overhanging facets in amber");
    Item::figure("6.1", caption)
        .stand_in("the bunny of de Castro (2020), 100 mm high, by the convex method")
        .picture("", sheet("Figure 6.1", 1, vec![picture], Vec::new()))
        .row(
            Row::same(
                "contact with the bed",
                "small",
                if contact < 0.01 * facets.mass().area_mm2 { "small" } else { "large" },
            )
            .because(format!(
                "{} mm² of a surface of {} mm²",
                figures((contact * 100.0).round() / 100.0),
                figures(facets.mass().area_mm2.round())
            )),
        )
        .note("trunnion's answer is --contact-area-min of orient.")
}
