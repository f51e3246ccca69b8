//! A machine's pivot, offset and zeros from touches, and the touches that are to be made.

use std::fmt::Write;
use std::path::Path;

use super::error::MachineError;
use crate::calibrate::{
    ChainFit, Choice, Estimate, Feature, FitOptions, Of, Refusal, Tip, TipShape, TouchShape, Touches, Uncalibrated,
    Unknown, Visit, choose, fit, form, visit,
};
use crate::input::{BadSetting, LoadedProfile, MachineSource, Source, load_table};
use crate::motion::TableKinematics;
use crate::profile::{Profile, TiltAxisName};
use crate::spelling::counted;
use crate::world::World;

/// Touches of one machine.
#[derive(Clone, Debug)]
pub struct CalibrateRequest {
    /// The machine, as its profile says today.
    pub machine: MachineSource,
    /// What was touched where.
    pub touches: Source,
    /// How to fit.
    pub options: FitOptions,
}

/// What the touches say.
#[derive(Clone, Debug)]
pub struct CalibrateResult {
    /// The machine, as its profile says today.
    pub machine: LoadedProfile,
    /// The touches.
    pub touches: Touches,
    /// Their file, as given.
    pub file: String,
    /// The fit.
    pub fit: ChainFit,
    /// By how much axes may be elsewhere before they are written, mm.
    pub allowed_mm: f64,
    /// Why no profile can hold the result, if none can.
    unfit: Option<String>,
}

/// What `--tolerance` may be, mm.
const TOLERANCES_MM: [f64; 2] = [0.001, 5.0];
/// What `--repeats-to` may be, mm.
const REPEATS_MM: [f64; 2] = [0.0005, 1.0];
/// What `--by-eye` may be at most, mm.
const BY_EYE_MM: f64 = 2.0;
/// How many touches may be asked for.
const MOST: [f64; 2] = [3.0, 1000.0];

/// Fits the machine to its touches.
///
/// # Errors
///
/// What cannot be read, [`MachineError::Touches`], and [`MachineError::Calibration`] where the touches do not tell everything.
pub fn calibrate(request: &CalibrateRequest, world: &World<'_>) -> Result<CalibrateResult, MachineError> {
    BadSetting::within("tolerance", request.options.tolerance_mm, " mm", TOLERANCES_MM)?;
    let machine = load_table(&request.machine, world)?;
    let file = request.touches.name().into_owned();
    let touches = Touches::parse(&file, &request.touches.text(world)?)?;
    let fit = fit(&machine.profile, &touches, &request.options)
        .map_err(|no| MachineError::Calibration(Box::new(Uncalibrated::of(no, &file, &machine.profile, &touches))))?;
    let allowed_mm = request.options.tolerance_mm;
    let mut done = CalibrateResult { machine, touches, file, fit, allowed_mm, unfit: None };
    done.unfit = done.written().profile().validate().err().map(|error| error.to_string());
    Ok(done)
}

/// Rounded to a tenth of what a machine can do.
fn round(value: f64, digits: i32) -> f64 {
    let scale = 10.0_f64.powi(digits);
    (value * scale).round() / scale + 0.0
}

/// A machine as a profile holds it.
#[derive(Clone, Copy, Debug)]
pub struct Written<'a> {
    pub(super) machine: &'a LoadedProfile,
    pub(super) table: &'a TableKinematics,
    pub(super) misaligned: bool,
}

impl Written<'_> {
    /// Pivot and offset, mm, and the zeros of tilt and rotation, degrees, as they are written.
    pub fn keys(&self) -> ([f64; 3], [f64; 3], [f64; 2]) {
        let triple = |v: &crate::geom::Vec3| [v.x, v.y, v.z].map(|v| round(v, 4));
        let zeros = [&self.table.tilt, &self.table.rotation].map(|axis| round(axis.zero.deg(), 4));
        (triple(&self.table.pivot), triple(&self.table.offset), zeros)
    }

    /// Where the tilt and the rotation axis point, as they are written: `None` where they are where the profile has them.
    pub fn along(&self) -> Option<[[f64; 3]; 2]> {
        let axes = self.table.directions();
        let rounded = |v: crate::geom::Vec3| [v.x, v.y, v.z].map(|v| round(v, 6));
        self.misaligned.then(|| [rounded(axes.tilt), rounded(axes.rotation)])
    }

    /// The machine with these in the place of what its profile says.
    pub(super) fn profile(&self) -> Profile {
        let (pivot, offset, [tilt, rotation]) = self.keys();
        let mut profile = self.machine.profile.clone();
        (profile.kinematics.pivot_mm, profile.kinematics.offset_mm) = (pivot, offset);
        (profile.kinematics.tilt.zero_deg, profile.kinematics.rotation.zero_deg) = (tilt, rotation);
        if let Some([tilt, rotation]) = self.along() {
            (profile.kinematics.tilt.along, profile.kinematics.rotation.along) = (Some(tilt), Some(rotation));
        }
        profile
    }

    /// The same as TOML, with how well each is known, behind the line `head`; it extends the machine's profile where it is kept in a folder.
    pub(super) fn text(&self, head: &str, known: &[Estimate], kept_in: Option<&Path>, world: &World<'_>) -> String {
        let (pivot, offset, [tilt, rotation]) = self.keys();
        let mut out = head.to_owned();
        if kept_in.is_some() {
            let _ = writeln!(out, "extends = {:?}", self.machine.reference(kept_in, world).profile);
        }
        let along = |axis: usize| self.along().map_or(String::new(), |both| format!("along = {:?}\n", both[axis]));
        let of =
            |e: &Estimate| format!("{} {:.4} {}", e.name, e.error, if e.unknown.is_angle() { "deg" } else { "mm" });
        let known: Vec<String> = known.iter().map(of).collect();
        let _ = write!(
            out,
            "\n[kinematics]\n# Accuracy (95 % confidence): {}\npivot_mm = {pivot:?}\noffset_mm = {offset:?}\n\
             \n[kinematics.tilt]\nzero_deg = {tilt:?}\n{}\n[kinematics.rotation]\nzero_deg = {rotation:?}\n{}",
            known.join(", "),
            along(0),
            along(1)
        );
        out
    }
}

impl CalibrateResult {
    /// Pivot and offset, mm, and the zeros of tilt and rotation, degrees, as they are written.
    pub fn keys(&self) -> ([f64; 3], [f64; 3], [f64; 2]) {
        self.written().keys()
    }

    /// Where the tilt and the rotation axis point, as they are written: `None` where they are where the profile has them.
    pub fn along(&self) -> Option<[[f64; 3]; 2]> {
        self.written().along()
    }

    /// The keys as they are written.
    pub fn written(&self) -> Written<'_> {
        Written { machine: &self.machine, table: &self.fit.table, misaligned: self.fit.misaligned }
    }

    /// A profile that extends the machine's, kept in the folder `kept_in`; without one, its keys alone.
    pub fn profile(&self, kept_in: Option<&Path>, world: &World<'_>) -> String {
        let scatter = self.fit.rms_mm;
        let touches = counted(self.fit.deviations.len(), "touch");
        let head = format!(
            "# From {touches} in {:?}, which scatter by {scatter:.3} mm (trunnion profile calibrate).\n",
            self.file
        );
        let written = self.fit.estimates.iter().filter(|e| self.is_written(e.unknown)).cloned();
        self.written().text(&head, &written.collect::<Vec<_>>(), kept_in, world)
    }

    /// Whether a written profile says what was found of it.
    pub fn is_written(&self, unknown: Unknown) -> bool {
        unknown != Unknown::Sag && (!unknown.bends() || (self.fit.misaligned && unknown != Unknown::Unlevel))
    }

    /// Why nothing may be written; `None` where it may.
    pub fn refusal(&self) -> Option<String> {
        let found = self.fit.refusals.iter().map(|why| self.in_words(why));
        let all: Vec<String> = found.chain(self.unfit.clone()).collect();
        (!all.is_empty()).then(|| all.join("; "))
    }

    fn in_words(&self, why: &Refusal) -> String {
        match why {
            Refusal::Outliers => {
                let of = |o: &crate::calibrate::Outlier| {
                    format!("touch {} ({}:{}) by {:.3} mm", o.number, self.file, o.line, o.off_mm.abs())
                };
                let all: Vec<String> = self.fit.outliers.iter().map(of).collect();
                format!("outliers: {}; measure them again or remove them", all.join(", "))
            }
            Refusal::Scattered { rms_mm, noise_mm } => format!(
                "the touches scatter by {rms_mm:.3} mm, but each should repeat to {noise_mm} mm (repeats_to_mm); check for slip and a \
                 wrong [tip], or raise repeats_to_mm if touches are that rough"
            ),
            Refusal::Sloped { mm, allowed_mm } => {
                let k = &self.machine.profile.kinematics;
                let along = if k.tilt.about == TiltAxisName::X { 'X' } else { 'Y' };
                format!(
                    "no angle levels the table along {along}: its rim is off by {mm:.3} mm with {} and {} at zero (maximum \
                     {allowed_mm} mm); level it on its axis, or raise --tolerance",
                    k.tilt.letter, k.rotation.letter
                )
            }
            Refusal::Sagging { mm, allowed_mm } => format!(
                "the table is not flat: its rim is {:.3} mm {} than its middle (maximum {allowed_mm} mm); flatten it, or raise --tolerance",
                mm.abs(),
                if *mm > 0.0 { "lower" } else { "higher" }
            ),
        }
    }
}

/// Which touches to make.
#[derive(Clone, Debug)]
pub struct PosesRequest {
    /// The machine.
    pub machine: MachineSource,
    /// Standard deviation of one touch, mm.
    pub repeats_to_mm: f64,
    /// The same of X and Y over a mark, mm; `None` for the same.
    pub by_eye_mm: Option<f64>,
    /// How many touches at most.
    pub most: usize,
    /// Whether its axes are taken as the profile has them.
    pub square: bool,
}

/// Touches to be made.
#[derive(Clone, Debug)]
pub struct PosesResult {
    /// The machine.
    pub machine: LoadedProfile,
    /// What was chosen.
    pub choice: Choice,
    /// Standard deviation of one touch, mm.
    pub repeats_to_mm: f64,
    /// The file to be filled in.
    pub form: String,
    /// The G-code that goes there, or why it cannot.
    pub visit: Result<Visit, String>,
}

/// Of one touch's error, what is to be left of a length: 95 of 100 results are then off by less than one touch.
const AIM: f64 = 0.5;

/// Chooses touches that tell everything about a machine.
///
/// # Errors
///
/// What cannot be read, a number out of its range, and [`MachineError::NoTouches`] for a machine that nothing can be told of.
pub fn poses(request: &PosesRequest, world: &World<'_>) -> Result<PosesResult, MachineError> {
    BadSetting::within("repeats-to", request.repeats_to_mm, " mm", REPEATS_MM)?;
    if let Some(by_eye) = request.by_eye_mm {
        BadSetting::within("by-eye", by_eye, " mm", [request.repeats_to_mm, BY_EYE_MM])?;
    }
    BadSetting::within("most", request.most as f64, "", MOST)?;
    let machine = load_table(&request.machine, world)?;
    let profile = &machine.profile;
    let radius_mm = profile.tip_radius_mm();
    let tip = Tip {
        shape: TipShape::Flat,
        radius_mm,
        repeats_to_mm: request.repeats_to_mm,
        by_eye_mm: request.by_eye_mm,
        paper_mm: 0.1,
        offset_mm: [0.0; 3],
    };
    // What marks alone tell is told less well where they are met by eye.
    let aim_mm = AIM * (tip.repeats_to_mm * tip.across_mm()).sqrt();
    let choice = choose(profile, &tip, aim_mm, request.most, request.square);
    if choice.poses.is_empty() {
        return Err(MachineError::NoTouches { profile: machine.name.clone() });
    }
    let shape = TouchShape::Mark { height: 0.0, known: None };
    let features: Vec<Feature> = choice.marks.iter().map(|(name, _)| Feature { name: name.clone(), shape }).collect();
    let letters = [profile.kinematics.tilt.letter, profile.kinematics.rotation.letter];
    let form = form(&tip, &features, &choice.poses, letters);
    let name = |of: Of| if let Of::Feature(i) = of { features[i].name.clone() } else { "the table".to_owned() };
    let names: Vec<String> = choice.poses.iter().map(|one| name(one.of)).collect();
    let visit = visit(profile, &choice.poses, &names).map_err(|no| no.to_string());
    Ok(PosesResult { choice, repeats_to_mm: request.repeats_to_mm, form, visit, machine })
}
