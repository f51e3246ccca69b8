//! Programs: sliced, rewritten for the machine, proved, and looked at.

mod error;
mod plates;
mod prepare;
mod preview;
mod rewrite;
mod slice;
mod verify;

pub use error::{PrintError, Rejected};
pub use plates::{PlateEvent, PlateFolder, prepare_plates};
pub use prepare::{PrepareRequest, PrepareResult, Seconds, prepare};
pub use preview::{MOST_LOOKED_AT, PoseShown, PreviewRequest, PreviewResult, is_page, preview, show, show_rejected};
pub use rewrite::{RewriteRequest, RewriteResult, is_finished, rewrite};
pub use slice::{LARGEST_BED_MM, Prints, SliceRequest, SliceResult, SlicerName, SlicingOptions, bed, slice};
pub use verify::{RefereeRequest, RefereeResult, Verified, VerifyRequest, VerifyResult, referee, verify};
