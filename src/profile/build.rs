//! A resolved profile to the types of `geom` and `motion`, and the checks of its values.

use super::layers::{Origin, ProfileError, out_of_range};
use super::schema::{AxisTurns, BodyKind, BodySpec, Commands, FeedReference, Profile, TiltAxisName};
use crate::gcode::meaning::Firmware;
use crate::geom::{Angle, Body, Vec3};
use crate::motion::replay::Reading;
use crate::motion::{
    Accelerations, AxisDirections, AxisRange, LinearLimits, MOST_LEAN_DEG, TableKinematics, TiltAbout,
};
use crate::spelling::nearest;
use crate::trace::{self, FeedCount, Rates};

/// Corners of the polygon that stands for a round table; circumscribed, so it contains the disc.
const DISC_SIDES: usize = 72;

/// Farther beyond an axis' end than this no machine is sent by a mistake of millimetres, mm.
pub const ABSURD_MM: f64 = 200.0;

/// Names that differ by more letters were not meant.
const MOST_EDITS: usize = 4;

impl Profile {
    /// All values as one text: equal for equal profiles, and the other way round.
    pub fn canonical(&self) -> String {
        let mut same = self.clone();
        // Whether somebody looked changes no plan.
        (same.machine.jogged, same.machine.jogged_as, same.head.measured) = (None, None, false);
        serde_json::to_string(&same).unwrap_or_default()
    }

    /// The kinematic chain with its axes.
    pub fn kinematics(&self) -> TableKinematics {
        let (tilt, rotation) = (&self.kinematics.tilt, &self.kinematics.rotation);
        let degrees = |low: f64, high: f64| (Angle::from_deg(low), Angle::from_deg(high));
        // What turns the head right-handed turns the table below it the other way.
        let below =
            |direction: i32, turns: AxisTurns| f64::from(if turns == AxisTurns::Head { -direction } else { direction });
        let head = self.swivel();
        let [pivot, offset] = match &head {
            Some(_) => [Vec3::zeros(); 2],
            None => [self.kinematics.pivot_mm, self.kinematics.offset_mm].map(Vec3::from),
        };
        let mut table = TableKinematics {
            about: self.tilt_about(),
            pivot,
            offset,
            tilt: AxisRange {
                letter: tilt.letter as u8,
                direction: below(tilt.direction, tilt.turns),
                zero: Angle::from_deg(tilt.zero_deg),
                range: Some(degrees(tilt.min_deg, tilt.max_deg)),
                max_rate: tilt.max_deg_per_s.to_radians(),
                absent: tilt.turns == AxisTurns::None,
            },
            rotation: AxisRange {
                letter: rotation.letter as u8,
                direction: below(rotation.direction, rotation.turns),
                zero: Angle::from_deg(rotation.zero_deg),
                range: rotation.stops_deg().map(|[low, high]| degrees(low, high)),
                max_rate: rotation.max_deg_per_s.to_radians(),
                absent: rotation.turns == AxisTurns::None,
            },
            misaligned: self.misaligned(),
            head,
        };
        for axis in [&mut table.tilt, &mut table.rotation].into_iter().filter(|axis| axis.absent) {
            (axis.zero, axis.range) = (Angle::ZERO, Some((Angle::ZERO, Angle::ZERO)));
        }
        table
    }

    pub(super) fn tilt_about(&self) -> TiltAbout {
        match self.kinematics.tilt.about {
            TiltAxisName::X => TiltAbout::X,
            TiltAxisName::Y => TiltAbout::Y,
        }
    }

    /// Where the axes point: `None` where no key says so, or says that they are square.
    pub(super) fn misaligned(&self) -> Option<AxisDirections> {
        let square = self.square_axes();
        let [tilt, rotation] = [self.kinematics.tilt.along, self.kinematics.rotation.along];
        let given = |along: Option<[f64; 3]>, square: Vec3| along.map_or(square, |v| Vec3::from(v).normalize());
        let axes = AxisDirections { tilt: given(tilt, square.tilt), rotation: given(rotation, square.rotation) };
        (axes != square).then_some(axes)
    }

    fn square_axes(&self) -> AxisDirections {
        let tilt = if self.kinematics.tilt.about == TiltAxisName::X { Vec3::x() } else { Vec3::y() };
        AxisDirections { tilt, rotation: Vec3::z() }
    }

    /// Where the tip may go.
    pub fn linear_limits(&self) -> LinearLimits {
        let l = &self.limits;
        LinearLimits {
            min: Vec3::new(l.x_mm[0], l.y_mm[0], l.z_mm[0]),
            max: Vec3::new(l.x_mm[1], l.y_mm[1], l.z_mm[1]),
        }
    }

    /// How our own output is read back.
    pub fn reading(&self) -> Reading {
        let table = self.kinematics();
        Reading {
            firmware: self.firmware(),
            extruder: self.dialect.extruder as u8,
            rotary: Some((table.tilt, table.rotation)),
            absolute_switches_extruder: self.dialect.g90_switches_extruder,
            steppers: self.steppers(),
            reach_mm: self.arcs_reach(),
        }
    }

    /// How far from zero an arc may go: to the axes' ends and as far beyond them as a mistake still can be told by its measure, mm.
    fn arcs_reach(&self) -> f64 {
        let l = &self.limits;
        [l.x_mm, l.y_mm].as_flattened().iter().map(|end| end.abs()).fold(0.0, f64::max) + ABSURD_MM
    }

    /// Klipper's names of the motors of tilt and rotation, where commands turn them.
    pub fn steppers(&self) -> Option<[String; 2]> {
        let (tilt, rotation) = (&self.kinematics.tilt.stepper, &self.kinematics.rotation.stepper);
        Some([tilt.clone()?, rotation.clone()?])
    }

    /// How final files are read: words, what F means, the axes' speeds.
    pub fn trace_setting(&self) -> trace::TraceSetting {
        let table = self.kinematics();
        let axis = |a: &AxisRange| (char::from(a.letter), a.max_rate.to_degrees());
        let feed = match self.dialect.feed {
            FeedReference::AllAxes => FeedCount::AllAxes,
            FeedReference::LargestAxis => FeedCount::LargestAxis,
            FeedReference::LinearOnly | FeedReference::InverseTime => FeedCount::Linear,
        };
        let rates = Rates {
            feed,
            max_feed: self.limits.max_feed_mm_per_min,
            rapid_is_free: self.dialect.commands == Commands::Rs274,
            axes: [axis(&table.tilt), axis(&table.rotation)],
        };
        trace::TraceSetting {
            reading: self.reading(),
            rates,
            accelerations: self.accelerations(),
            swivel: self.swivel(),
        }
    }

    /// How fast its axes' speeds change.
    pub fn accelerations(&self) -> Accelerations {
        let l = &self.limits;
        let (tip, turn) = (l.acceleration_mm_per_s2, l.turn_acceleration_deg_per_s2);
        let axes = [tip, tip, l.z_acceleration_mm_per_s2, turn, turn, l.e_acceleration_mm_per_s2];
        Accelerations { axes, junction_mm: l.junction_mm }
    }

    /// Whose words are written for it.
    pub fn firmware(&self) -> Firmware {
        Firmware::named(&self.dialect.firmware).unwrap_or_default()
    }

    /// The radius of the nozzle's end, mm: of the frustums that begin at the tip; 0 where none does.
    pub fn tip_radius_mm(&self) -> f64 {
        let ends = self.head.body.iter().filter(|b| b.z_mm.is_some_and(|z| z[0] == 0.0));
        ends.filter_map(|b| b.r_mm).map(|r| r[0]).fold(0.0, f64::max)
    }

    /// The head's convex pieces, tip at the origin, tool upright.
    pub fn head_bodies(&self) -> Vec<Body> {
        self.head.body.iter().filter_map(body).collect()
    }

    /// The frame's convex pieces, machine coordinates.
    pub fn fixed_bodies(&self) -> Vec<Body> {
        self.fixed.body.iter().filter_map(body).collect()
    }

    /// The table's slab, table frame: the outline at z = 0 first, then at z = -thickness.
    pub fn table_slab(&self) -> Vec<Vec3> {
        let outline = self.table_outline();
        let lower = outline.iter().map(|p| p - Vec3::z() * self.table.thickness_mm);
        outline.iter().copied().chain(lower).collect()
    }

    /// How far the table's surface reaches from its middle, mm.
    pub fn table_reach_mm(&self) -> f64 {
        self.table_outline().iter().map(|p| p.x.hypot(p.y)).fold(0.0, f64::max)
    }

    fn table_outline(&self) -> Vec<Vec3> {
        if let (true, Some([x, y])) = (self.table.radius_mm == 0.0, self.table.size_mm) {
            let (x, y) = (x / 2.0, y / 2.0);
            return [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
        }
        let radius = self.table.radius_mm / (std::f64::consts::PI / DISC_SIDES as f64).cos();
        let corner = |i: usize| {
            let (s, c) = (std::f64::consts::TAU * i as f64 / DISC_SIDES as f64).sin_cos();
            Vec3::new(radius * c, radius * s, 0.0)
        };
        (0..DISC_SIDES).map(corner).collect()
    }

    /// How far (mm) a point of the table's surface lies beyond the part of it that may be printed on; 0 or less is
    /// inside.
    pub fn beyond_table(&self, x: f64, y: f64) -> f64 {
        match (self.table.radius_mm == 0.0, self.table.size_mm) {
            (true, Some([w, d])) => (x.abs() - w / 2.0).max(y.abs() - d / 2.0) + self.table.keep_out_mm,
            _ => x.hypot(y) - self.table.radius_mm + self.table.keep_out_mm,
        }
    }

    /// What relates several keys; each by itself is in its range.
    pub(super) fn check(&self, origin: &Origin) -> Result<(), ProfileError> {
        let check = |key: &str, fine: bool, value: String, allowed: &str| {
            let place = origin.get(key).cloned().unwrap_or_default();
            let error = ProfileError::Range { place, key: key.to_owned(), value, allowed: allowed.to_owned() };
            if fine { Ok(()) } else { Err(error) }
        };
        let firmware = &self.dialect.firmware;
        let known = Firmware::NAMES.map(|(name, _)| name).join(", ");
        let near = nearest(firmware, Firmware::NAMES.map(|(name, _)| name)).filter(|(edits, _)| *edits <= MOST_EDITS);
        let meant = near.map_or_else(String::new, |(_, name)| format!("; the nearest is {name}"));
        let allowed = format!("one of {known}{meant}");
        check("dialect.firmware", Firmware::named(firmware).is_some(), firmware.clone(), &allowed)?;
        let (tilt, rotation) = (&self.kinematics.tilt, &self.kinematics.rotation);
        check("kinematics.tilt.direction", tilt.direction.abs() == 1, tilt.direction.to_string(), "1 or -1")?;
        check(
            "kinematics.rotation.direction",
            rotation.direction.abs() == 1,
            rotation.direction.to_string(),
            "1 or -1",
        )?;
        let range = format!("{}..{}", tilt.min_deg, tilt.max_deg);
        check(
            "kinematics.tilt.max_deg",
            tilt.min_deg <= tilt.max_deg,
            range,
            "min_deg..max_deg with min_deg at most max_deg",
        )?;
        let level = self.kinematics().tilt.admits(Angle::ZERO);
        let range = format!("{}..{}", tilt.min_deg, tilt.max_deg);
        let holds =
            format!("a range that includes level (zero_deg = {}): printing starts with a level table", tilt.zero_deg);
        check("kinematics.tilt.min_deg", level, range, &holds)?;
        self.check_directions(origin)?;
        self.check_steppers(origin)?;
        let both = rotation.min_deg.is_some() == rotation.max_deg.is_some();
        let ordered = rotation.min_deg.zip(rotation.max_deg).is_none_or(|(a, b)| a <= b);
        let stop = |deg: Option<f64>| deg.map_or("none".to_owned(), |deg| deg.to_string());
        let range = format!("{}..{}", stop(rotation.min_deg), stop(rotation.max_deg));
        let allowed = if both {
            "min_deg..max_deg with min_deg at most max_deg"
        } else {
            "given with both min_deg and max_deg, or with neither"
        };
        check("kinematics.rotation.max_deg", both && ordered, range, allowed)?;
        if let Some(turns) = rotation.max_turns {
            let allowed = "absent where min_deg and max_deg are given";
            check("kinematics.rotation.max_turns", rotation.max_deg.is_none(), turns.to_string(), allowed)?;
        }
        for (key, [low, high]) in
            [("limits.x_mm", self.limits.x_mm), ("limits.y_mm", self.limits.y_mm), ("limits.z_mm", self.limits.z_mm)]
        {
            check(key, low < high, format!("[{low}, {high}]"), "[lowest, highest] with lowest below highest")?;
        }
        self.process.fit().map_err(|out| out_of_range(out, origin))?;
        if let Some(celsius) = self.joint.nozzle_c {
            let (least, most) = (self.limits.min_extrude_c, self.link.max_nozzle_c);
            let allowed = format!("{least}..{most} deg C (limits.min_extrude_c, link.max_nozzle_c)");
            check("joint.nozzle_c", (least..=most).contains(&celsius), celsius.to_string(), &allowed)?;
        }
        let (overlap_mm, half_mm) = (self.joint.overlap_mm, self.process.layer_height_mm / 2.0);
        let allowed =
            format!("0..{half_mm} mm, half of process.layer_height_mm: the nozzle must not touch what it prints on");
        check("joint.overlap_mm", overlap_mm <= half_mm, overlap_mm.to_string(), &allowed)?;
        if let Some([x, y]) = self.transition.park_mm {
            let within = |v: f64, [low, high]: [f64; 2]| (low..=high).contains(&v);
            let (own_x, own_y) = (self.limits.x_mm, self.limits.y_mm);
            let inside = within(x, own_x) && within(y, own_y);
            let allowed = format!("within X {own_x:?} and Y {own_y:?} mm (limits.x_mm, limits.y_mm)");
            check("transition.park_mm", inside, format!("{:?}", [x, y]), &allowed)?;
        }
        // Without a head nothing would ever collide.
        check("head.body", !self.head.body.is_empty(), "[]".to_owned(), "at least one body")?;
        let extent = self.table.radius_mm > 0.0 || self.table.size_mm.is_some();
        check("table.radius_mm", extent, self.table.radius_mm.to_string(), "above 0, or 0 with table.size_mm")?;
        self.check_chain(origin)?;
        let letters = [tilt.letter, rotation.letter, self.dialect.extruder];
        let distinct = letters[0] != letters[1] && letters[1] != letters[2] && letters[0] != letters[2];
        let capital = letters.iter().all(|l| l.is_ascii_uppercase() && !"FGMNTXYZIJKR".contains(*l));
        let text = format!("{letters:?}");
        check(
            "kinematics.tilt.letter",
            distinct && capital,
            text,
            "three different capital letters other than F G I J K M N R T X Y Z (with kinematics.rotation.letter and dialect.extruder)",
        )?;
        self.check_bodies(origin)?;
        self.check_code(origin)
    }

    /// Axes as measured: near to where they are on a square machine.
    fn check_directions(&self, origin: &Origin) -> Result<(), ProfileError> {
        let square = self.square_axes();
        let about = if self.kinematics.tilt.about == TiltAxisName::X { "X" } else { "Y" };
        for (axis, along, square, name) in [
            ("tilt", self.kinematics.tilt.along, square.tilt, about),
            ("rotation", self.kinematics.rotation.along, square.rotation, "Z"),
        ] {
            let Some(given) = along else { continue };
            let (v, key) = (Vec3::from(given), format!("kinematics.{axis}.along"));
            let lean_deg = v.angle(&square).to_degrees();
            let allowed = match v.norm() {
                length if !(0.5..=2.0).contains(&length) => "a vector of length 1 (0.5 to 2 is accepted)".to_owned(),
                _ if lean_deg > MOST_LEAN_DEG => format!(
                    "within {MOST_LEAN_DEG} deg of +{name}, and is {lean_deg:.2} deg from it (direction of the axis while both angles are zero)"
                ),
                _ => continue,
            };
            let place = origin.get(&key).cloned().unwrap_or_default();
            return Err(ProfileError::Range { place, key, value: format!("{given:?}"), allowed });
        }
        Ok(())
    }

    /// Motors that commands turn: of both axes, on Klipper, by two names that a line of G-code can hold.
    fn check_steppers(&self, origin: &Origin) -> Result<(), ProfileError> {
        let given = [&self.kinematics.tilt.stepper, &self.kinematics.rotation.stepper];
        let is_name = |name: &String| !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
        let allowed = match given {
            [None, None] => return Ok(()),
            [None, _] | [_, None] => {
                "set for both axes or for neither (kinematics.tilt.stepper, kinematics.rotation.stepper)"
            }
            _ if self.firmware() != Firmware::Klipper => "absent: only Klipper has MANUAL_STEPPER (dialect.firmware)",
            [Some(tilt), Some(rotation)] if tilt == rotation || !is_name(tilt) || !is_name(rotation) => {
                "two different names of letters, digits and _"
            }
            _ => return Ok(()),
        };
        let axis = if given[0].is_some() { "tilt" } else { "rotation" };
        let key = format!("kinematics.{axis}.stepper");
        let place = origin.get(&key).cloned().unwrap_or_default();
        Err(ProfileError::Range {
            place,
            key,
            value: format!("{:?}", given.map(|name| name.as_deref().unwrap_or_default())),
            allowed: allowed.to_owned(),
        })
    }

    fn check_bodies(&self, origin: &Origin) -> Result<(), ProfileError> {
        for (key, bodies) in [("head.body", &self.head.body), ("fixed.body", &self.fixed.body)] {
            for spec in bodies {
                let problem = match (body(spec), spec.moves.chars().find(|c| !"XYZ".contains(*c))) {
                    (None, _) => "a frustum with z_mm and r_mm, a box with min_mm and max_mm, or a hull with points_mm",
                    (_, Some(_)) => "moves made of X, Y and Z",
                    _ => continue,
                };
                return Err(ProfileError::Range {
                    place: origin.get(key).cloned().unwrap_or_default(),
                    key: format!("{key} {:?}", spec.name),
                    value: format!("{:?}", spec.kind).to_lowercase(),
                    allowed: problem.to_owned(),
                });
            }
        }
        Ok(())
    }
}

/// The body of a `[[head.body]]`; `None` where its kind's numbers are missing or turned round.
fn body(spec: &BodySpec) -> Option<Body> {
    let body = shaped(spec)?;
    Some(Body { stays: !spec.turns, ..body })
}

fn shaped(spec: &BodySpec) -> Option<Body> {
    let follows = ['X', 'Y', 'Z'].map(|axis| spec.moves.contains(axis));
    match spec.kind {
        BodyKind::Frustum => {
            let (z, r) = (spec.z_mm?, spec.r_mm?);
            (z[0] < z[1] && r[0] >= 0.0 && r[1] >= 0.0).then(|| Body::frustum(&spec.name, z, r, follows))
        }
        BodyKind::Box => {
            let (min, max) = (Vec3::from(spec.min_mm?), Vec3::from(spec.max_mm?));
            (0..3).all(|i| min[i] < max[i]).then(|| Body::cuboid(&spec.name, min, max, follows))
        }
        BodyKind::Hull => {
            let points: Vec<Vec3> = spec.points_mm.as_ref()?.iter().map(|&p| Vec3::from(p)).collect();
            (points.len() >= 4).then(|| Body { name: spec.name.clone(), points, follows, stays: false })
        }
    }
}
