//! Machine profiles: TOML layers to one checked description of a machine and its firmware.
//!
//! Built-in commented defaults (`firmware-profiles/defaults.toml`, the reference of every key) < shipped profile < user's
//! file. Each value keeps where it came from, and an unknown key is an error with the nearest name. Lengths mm,
//! angles degrees, as every key's suffix says; [`Profile::kinematics`] and its neighbours turn them into `motion`'s types.

mod build;
mod code;
mod complete;
mod head;
mod import;
mod layers;
mod prime;
mod process;
mod ranges;
mod schema;

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
    BodyKind, BodySpec, Commands, Dialect, Extrusion, FeedReference, JointSettings, Kinematics, Limits, Link,
    MachineInfo, OnStop, PriceSettings, Profile, Prove, RotationAxis, TableSpec, TiltAxis, TiltAxisName, Transition,
};
