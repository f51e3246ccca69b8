//! The model on the table: placed parts, and whether they fit.

use crate::geom::{Angle, Bounds, Object, Rigid, Table, Vec3};
use crate::mesh::{Model, TriangleMesh};
use crate::motion::Pose;
use crate::planning::plan::Placement;
use crate::profile::Profile;
use crate::spelling::part_named;

/// The model's parts in the table's frame.
pub struct Workpiece<'a> {
    /// As read.
    pub model: &'a Model,
    /// From the file's frame to the table's.
    pub placed: Rigid<Object, Table>,
    /// The parts there.
    pub parts: Vec<TriangleMesh<Table>>,
}

/// How exactly the model stands on the table, mm: well below a layer, and above the last digit of an `f32` file.
const STANDS_MM: f64 = 0.01;

/// The model does not lie on the table.
#[derive(Clone, Debug, PartialEq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "table/")]
pub enum Misplaced {
    /// A part stands over the rim.
    #[error(
        "{who} reaches {beyond_mm:.1} mm beyond the edge of the table ({extent}); {}scale the model, choose another machine, or split it",
        if *parts > 1 { "print fewer of its parts at once, " } else { "" }, who = part_named(*part, name)
    )]
    OverRim {
        /// The part.
        part: usize,
        /// Its name.
        name: String,
        /// How far.
        beyond_mm: f64,
        /// The table's size, in words.
        extent: String,
        /// How many parts the model has.
        parts: usize,
    },
    /// The placement leaves it in the air, or sinks it.
    #[error(
        "the model's lowest point is {:.2} mm {} the table (tolerance {STANDS_MM} mm); plan again",
        above_mm.abs(),
        if *above_mm < 0.0 { "below" } else { "above" }
    )]
    NotOnTable {
        /// How far.
        above_mm: f64,
    },
    /// The model is higher than the machine.
    #[error("the model is {height_mm:.1} mm high, but this machine's Z reaches only {reach_mm:.1} mm above its table")]
    TooHigh {
        /// The model's height.
        height_mm: f64,
        /// What is there.
        reach_mm: f64,
    },
}

impl<'a> Workpiece<'a> {
    /// The placement that centres the model's footprint on the table, its lowest point on the surface.
    pub fn centred(model: &Model) -> Placement {
        let centre = model.bounds.centre();
        let z = -model.bounds.min.z;
        // A model drawn where it should stand is left there to the last bit.
        let tidy = |v: f64| if v.abs() < 1e-6 { 0.0 } else { v };
        Placement { origin_mm: [tidy(-centre.x), tidy(-centre.y), tidy(z)], turn_deg: 0.0 }
    }

    /// The parts of `model` at `placement`.
    pub fn place(model: &'a Model, placement: &Placement) -> Self {
        let turn = crate::motion::rotation_z(Angle::from_deg(placement.turn_deg));
        let placed = Rigid::new(turn, Vec3::from(placement.origin_mm));
        let parts = model.parts.iter().map(|p| p.mesh.moved(&placed)).collect();
        Self { model, placed, parts }
    }

    /// What stands on the table must stand on its usable surface, and the whole below the machine's top.
    ///
    /// # Errors
    ///
    /// [`Misplaced`] with the part and the millimetres.
    pub fn check(&self, profile: &Profile) -> Result<(), Misplaced> {
        let above_mm = self.bounds().min.z;
        if above_mm.abs() > STANDS_MM {
            return Err(Misplaced::NotOnTable { above_mm });
        }
        for &part in &self.model.on_table {
            let standing = self.parts[part].vertices().iter().filter(|v| v.z < 1.0);
            let beyond = standing.map(|v| profile.beyond_table(v.x, v.y)).fold(f64::NEG_INFINITY, f64::max);
            if beyond > 0.0 {
                let name = self.model.parts[part].name.clone();
                let extent = match (profile.table.radius_mm == 0.0, profile.table.size_mm) {
                    (true, Some([x, y])) => format!("{x} x {y} mm"),
                    _ => format!("{} mm disc", profile.table.radius_mm * 2.0),
                };
                let parts = self.parts.len();
                return Err(Misplaced::OverRim { part, name, beyond_mm: beyond, extent, parts });
            }
        }
        let height = self.bounds().max.z;
        let table = profile.kinematics().forward(Pose::LEVEL).translation.z;
        let reach = profile.limits.z_mm[1] - table;
        if height > reach {
            return Err(Misplaced::TooHigh { height_mm: height, reach_mm: reach });
        }
        Ok(())
    }

    /// The box of all parts, table frame.
    pub fn bounds(&self) -> Bounds {
        self.parts.iter().map(TriangleMesh::bounds).fold(Bounds::EMPTY, |all, b| all.union(&b))
    }
}
