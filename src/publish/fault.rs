//! Why a file is not where it was to go, each in a sentence that says what can be done and holds no key.

use super::{Address, Kind};

/// Why a file is not published, and by which server.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{kind} at {url}: {fault}{}", if *.left { "; a part of the file may be left there" } else { "" })]
pub struct PublishError {
    /// The server.
    pub kind: Kind,
    /// Its address.
    pub url: String,
    /// What went wrong.
    pub fault: Fault,
    /// Whether a part of the file is left there.
    pub left: bool,
}

impl PublishError {
    pub(super) fn new(address: &Address, fault: Fault, left: bool) -> Self {
        Self { kind: address.kind, url: address.url().to_owned(), fault, left }
    }
}

/// What went wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "server/")]
pub enum Fault {
    /// Nobody is there.
    #[error("nobody answers: {why}; is it switched on, and are host and port right?")]
    Away {
        /// The system's words.
        why: String,
    },
    /// Somebody is there and says nothing.
    #[error("it has said nothing for {seconds} s; try again, or give it longer with --timeout SECONDS")]
    Silent {
        /// How long it was waited for.
        seconds: u64,
    },
    /// Closed half way, as often as it was tried.
    #[error("it closes the connection half way; nothing of the file is there, try again")]
    Closed,
    /// Nobody vouches for it.
    #[error(
        "its certificate does not hold: {why}; for a certificate of your own give its fingerprint with --fingerprint (openssl x509 -in CERTIFICATE \
         -noout -fingerprint -sha256, on the server), or its authority's file in SSL_CERT_FILE"
    )]
    Tls {
        /// The library's words.
        why: String,
    },
    /// TLS was asked for, and it answers without.
    #[error("it does not speak https there; write http://, or give the port of its https")]
    Plain,
    /// Another protocol.
    #[error("it does not speak HTTP: {why}; is the port right, and is it http or https?")]
    Garbled {
        /// The library's words.
        why: String,
    },
    /// A page for people.
    #[error(
        "it answers {what} with a web page or other text instead of data; is it {kind}, and does nothing stand before it that asks for a login?"
    )]
    Page {
        /// What was asked.
        what: &'static str,
        /// What was looked for.
        kind: Kind,
    },
    /// It sends elsewhere.
    #[error("it sends to {to}; the key is not sent along, so give that address with --to if it is the right one")]
    Moved {
        /// Without what may follow a question mark.
        to: String,
    },
    /// A login is wanted, of something that stands before it.
    #[error(
        "something before it asks for a login ({login}): a proxy, and it is not the server's key that it wants; give the server's own address, \
         behind that"
    )]
    Login {
        /// Which, in its words.
        login: String,
    },
    /// Its printer has another firmware.
    #[error(
        "its printer says that it runs {says}, but the file is written for {firmware}; prepare it with a profile for that, or connect the right printer"
    )]
    OtherFirmware {
        /// The printer's words.
        says: String,
        /// The file's.
        firmware: &'static str,
    },
    /// A key is wanted.
    #[error("it wants a key; give it with --key-file FILE or in TRUNNION_KEY")]
    NoKey,
    /// The key is wrong, or may not do this.
    #[error("it refuses the key; take a new one from its settings, with the right to upload{}", if *.start { " and to print" } else { "" })]
    WrongKey {
        /// Whether a print was to begin.
        start: bool,
    },
    /// Too many others are there.
    #[error("all its sessions are in use; close a page of it somewhere, and try again")]
    Busy,
    /// The file does not go there.
    #[error("its disk is full: {}the file needs {needs} bytes; delete old files there", .free.map(|free| format!("{free} bytes are free, ")).unwrap_or_default())]
    Full {
        /// What is free there, where it says.
        free: Option<u64>,
        /// What the file needs.
        needs: u64,
    },
    /// It takes no file of this size.
    #[error("it takes no file of {bytes} bytes; raise its limit for uploads")]
    TooLarge {
        /// The file's size.
        bytes: u64,
    },
    /// Another file has the name.
    #[error("it has another file called {name} ({bytes} bytes); replace it with --replace, or give another --name")]
    Another {
        /// The name.
        name: String,
        /// That file's size.
        bytes: u64,
    },
    /// A print goes on.
    #[error("it is printing{}; {}", .file.as_ref().map(|file| format!(" {file}")).unwrap_or_default(), if *.uploaded { "the file is there, and was not started" } else { "nothing was started or uploaded" })]
    Printing {
        /// What it prints, where it says.
        file: Option<String>,
        /// Whether the file is there.
        uploaded: bool,
    },
    /// No printer that could begin.
    #[error("its printer is not ready: {why}; {}", if *.uploaded { "the file is there, and was not started" } else { "nothing was uploaded; leave out --start to upload alone" })]
    NotReady {
        /// In its words.
        why: String,
        /// Whether the file is there.
        uploaded: bool,
    },
    /// Whether it prints cannot be told.
    #[error(
        "the file is there, but the answer to its start was lost, and it does not say that it prints; look at the printer before you start it again"
    )]
    Unclear,
    /// Not what was sent.
    #[error("what arrived is not what was sent ({sent} bytes sent, {there} there); it was taken away, try again")]
    Differs {
        /// What was sent.
        sent: u64,
        /// What it has.
        there: u64,
    },
    /// It says no for a reason of its own.
    #[error("it refuses {what} with {status}{}", if .words.is_empty() { String::new() } else { format!(": {}", .words) })]
    Refused {
        /// What was asked.
        what: &'static str,
        /// HTTP's number.
        status: u16,
        /// In its words.
        words: String,
    },
}

impl Fault {
    /// Whether it may pass by itself.
    pub(super) fn may_pass(&self) -> bool {
        match self {
            Self::Away { .. } | Self::Silent { .. } | Self::Closed => true,
            Self::Refused { status, .. } => matches!(status, 502..=504),
            _ => false,
        }
    }
}
