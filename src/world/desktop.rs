//! The desktop of this computer.

use std::path::Path;
use std::process::{Command, Stdio};

/// Has a page opened in the browser, and does not wait for it; `false` where no program for that can be started.
pub fn open_in_browser(page: &Path) -> bool {
    let program = if cfg!(windows) {
        "explorer"
    } else if cfg!(target_os = "macos") {
        "open"
    } else {
        "xdg-open"
    };
    let silent = || Stdio::null();
    Command::new(program).arg(page).stdin(silent()).stdout(silent()).stderr(silent()).spawn().is_ok()
}
