//! Machine profiles: TOML layers to one checked description of a machine and its firmware.
//!
//! Built-in commented defaults (`firmware-profiles/defaults.toml`, the reference of every key) < shipped profile < user's
//! file. Each value keeps where it came from, and an unknown key is an error with the nearest name. Lengths mm,
//! angles degrees, as every key's suffix says; [`Profile::kinematics`] and its neighbours turn them into `motion`'s types.
//!
//! A profile of your own over a shipped one:
//!
//! ```
//! use trunnion::profile::{ProfileError, resolve};
//!
//! // Your machine: a shipped one, with what you measured.
//! let own = "extends = \"generic-ac\"\n[kinematics.tilt]\nmax_deg = 75.0\n";
//! let (profile, origin) = resolve("mine.toml", own)?;
//! assert_eq!(profile.kinematics.tilt.max_deg, 75.0);
//! // Every value knows where it comes from.
//! assert_eq!(origin["kinematics.tilt.max_deg"], "mine.toml:3");
//! // In the types that the rest of the library works with, that is the highest tilt.
//! let highest = profile.kinematics().tilt.range.map(|(_, highest)| highest.deg());
//! assert!((highest.unwrap_or_default() - 75.0).abs() < 1e-9);
//!
//! // A misspelt key is an error with the nearest key.
//! let refused = resolve("mine.toml", &own.replace("max_deg", "max_degs"));
//! assert!(
//!     matches!(refused, Err(ProfileError::UnknownKey { nearest: Some(near), .. }) if near == "kinematics.tilt.max_deg")
//! );
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod build;
mod chain;
mod code;
mod complete;
mod head;
mod import;
mod layers;
mod prime;
mod process;
mod ranges;
mod schema;
mod sight;

pub use build::ABSURD_MM;
pub use head::{HEAD_QUESTIONS, HeadFault, measured};
pub use import::{
    AxisRoles, Contradiction, Fact, File as ImportedFile, ImportError, Imported, Rotary, Shelf, Stated, StatedAt,
    import,
};
pub use layers::{Base, Origin, ProfileError, SHIPPED, resolve, resolve_over, shipped};
pub use prime::{Prime, prime};
pub use process::{InfillPattern, Seam, SliceSettings};
pub use ranges::{OutOfRange, check_number};
pub use schema::{
    AxisTurns, BodyKind, BodySpec, Commands, Dialect, Extrusion, FeedReference, JointSettings, Kinematics, Limits,
    Link, MachineInfo, OnStop, PriceSettings, Profile, Prove, RotationAxis, TableSpec, TiltAxis, TiltAxisName,
    Transition,
};
pub use sight::Sight;
