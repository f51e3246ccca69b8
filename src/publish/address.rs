//! Where a server is, the key to it, and the name that a file gets there; each held to what all three servers take.

use std::fmt;

use super::web::Web;
use crate::gcode::meaning::Firmware;

/// What kind of server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// OctoPrint.
    OctoPrint,
    /// Moonraker, which drives Klipper.
    Moonraker,
    /// RepRapFirmware's own on a Duet.
    Duet,
}

impl Kind {
    /// As an address begins.
    pub fn word(self) -> &'static str {
        match self {
            Self::OctoPrint => "octoprint",
            Self::Moonraker => "moonraker",
            Self::Duet => "duet",
        }
    }

    /// The only firmware that it drives; `None` for OctoPrint, behind which any printer stands.
    pub fn drives(self) -> Option<Firmware> {
        match self {
            Self::OctoPrint => None,
            Self::Moonraker => Some(Firmware::Klipper),
            Self::Duet => Some(Firmware::RepRapFirmware),
        }
    }

    /// That a program in the words of `firmware`, as `profile` has it, is understood behind this server.
    ///
    /// # Errors
    ///
    /// [`BadInput::Firmware`].
    pub fn takes(self, firmware: Firmware, profile: &str) -> Result<(), BadInput> {
        let Some(drives) = self.drives().filter(|drives| *drives != firmware) else { return Ok(()) };
        Err(BadInput::Firmware {
            kind: self,
            drives: drives.name(),
            firmware: firmware.name(),
            profile: profile.to_owned(),
            example: if drives == Firmware::Klipper { "fractal-5-pro" } else { "open5x-voron0" },
        })
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OctoPrint => "OctoPrint",
            Self::Moonraker => "Moonraker",
            Self::Duet => "Duet",
        })
    }
}

/// What was given and cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "publish/")]
pub enum BadInput {
    /// A server of an unsupported kind.
    #[error("to: must begin with octoprint:, moonraker: or duet:, for example octoprint:http://printer.local")]
    Server,
    /// Not http or https, or no host.
    #[error(
        "to: {kind}: must be followed by an http:// or https:// address, for example {kind}:http://printer.local:5000"
    )]
    Url {
        /// The server's word.
        kind: &'static str,
    },
    /// A password or a query in an address would end in shells' histories and servers' logs.
    #[error(
        "to: the address must not have a user name, a password, a query or a fragment; pass the key with --key-file or TRUNNION_KEY"
    )]
    Secret,
    /// `https://`, and the build has no TLS.
    #[error(
        "to: this build of trunnion cannot use https://; use the server's http:// address, or build with: cargo build --release --features tls"
    )]
    NoTls,
    /// A program for another firmware, which would ignore the table's words and print tilted parts on a level table.
    #[error(
        "to: a {kind} drives {drives}, but the file is written for {firmware} (profile {profile}); prepare it with a profile whose \
         [dialect] firmware is {drives:?}, such as {example}"
    )]
    Firmware {
        /// The server.
        kind: Kind,
        /// What it drives.
        drives: &'static str,
        /// What the file is written for.
        firmware: &'static str,
        /// By which profile.
        profile: String,
        /// A shipped one that would do.
        example: &'static str,
    },
    /// A key that no header can carry.
    #[error("the key in {place} {why}; give one line with the key only")]
    Key {
        /// Where it was found.
        place: String,
        /// What is wrong with it, without any of it.
        why: &'static str,
    },
    /// A name that a server would change.
    #[error(
        "name: {name:?} {why}; pass --name with at most 80 ASCII letters, digits, '.', '_' or '-', ending in .gcode, .gco or .g"
    )]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        why: &'static str,
    },
}

/// A server's place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerAddress {
    /// What it is.
    pub kind: Kind,
    /// `http://host[:port][/path]`, without a slash at its end.
    url: String,
}

impl ServerAddress {
    /// Reads `octoprint:URL`, `moonraker:URL` or `duet:URL`.
    ///
    /// # Errors
    ///
    /// [`BadInput`], which repeats nothing of the address.
    pub fn parse(text: &str) -> Result<Self, BadInput> {
        let known = [Kind::OctoPrint, Kind::Moonraker, Kind::Duet];
        let split = |kind: Kind| text.strip_prefix(kind.word())?.strip_prefix(':').map(|url| (kind, url));
        let (kind, url) = known.into_iter().find_map(split).ok_or(BadInput::Server)?;
        let bad = BadInput::Url { kind: kind.word() };
        let rest = ["http://", "https://"].iter().find_map(|scheme| url.strip_prefix(scheme)).ok_or(bad.clone())?;
        if rest.contains(['@', '?', '#']) {
            return Err(BadInput::Secret);
        }
        let host = rest.split('/').next().unwrap_or_default();
        let plain = |c: char| c.is_ascii_graphic() && !"\"<>\\^`{|}".contains(c);
        if host.is_empty() || host.starts_with(':') || !rest.chars().all(plain) {
            return Err(bad);
        }
        Ok(Self { kind, url: url.trim_end_matches('/').to_owned() })
    }

    /// The same, if `web` can reach it.
    ///
    /// # Errors
    ///
    /// [`BadInput::NoTls`].
    pub fn reached_by(self, web: &dyn Web) -> Result<Self, BadInput> {
        if self.url.starts_with("https://") && !web.speaks_tls() { Err(BadInput::NoTls) } else { Ok(self) }
    }

    /// The address, in which there is no secret.
    pub fn url(&self) -> &str {
        &self.url
    }
}

/// What opens a server; printed nowhere.
#[derive(Clone, PartialEq, Eq)]
pub struct Key(String);

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(..)")
    }
}

impl Key {
    /// The one line of `text`, which was found in `place`.
    ///
    /// # Errors
    ///
    /// [`BadInput::Key`], which repeats nothing of it.
    pub fn new(text: &str, place: &str) -> Result<Self, BadInput> {
        let key = text.trim();
        let why = match () {
            () if key.is_empty() => "is empty",
            () if key.len() > 512 => "is longer than 512 bytes",
            () if !key.chars().all(|c| c.is_ascii_graphic() || c == ' ') => {
                "has characters other than printable ASCII, or several lines"
            }
            () => return Ok(Self(key.to_owned())),
        };
        Err(BadInput::Key { place: place.to_owned(), why })
    }

    /// The key itself, for a request.
    pub(super) fn secret(&self) -> &str {
        &self.0
    }
}

/// The longest name that is given to a file.
const LONGEST_NAME: usize = 80;

/// `name`, if every server keeps it as it is.
///
/// # Errors
///
/// [`BadInput::Name`].
pub fn file_name(name: &str) -> Result<&str, BadInput> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    let why = match () {
        () if name.is_empty() => "is empty",
        () if name.len() > LONGEST_NAME => "is longer than 80 bytes",
        () if !name.chars().all(plain) => "has characters that are not allowed",
        () if name.starts_with(['.', '-']) => "begins with '.' or '-'",
        () if ![".gcode", ".gco", ".g"].iter().any(|end| name.ends_with(end)) => "does not end in .gcode, .gco or .g",
        () => return Ok(name),
    };
    Err(BadInput::Name { name: name.to_owned(), why })
}
