//! Why a file is not where it was to go, each in a sentence that says what can be done and holds no key.

use super::{Kind, ServerAddress};

/// Why a file is not published, and by which server.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{kind} at {url}: {fault}{}", if *.left { "; part of the file may be left there" } else { "" })]
pub struct PublishError {
    /// The server.
    pub kind: Kind,
    /// Its address.
    pub url: String,
    /// What went wrong.
    pub fault: ServerFault,
    /// Whether a part of the file is left there.
    pub left: bool,
}

impl PublishError {
    pub(super) fn new(address: &ServerAddress, fault: ServerFault, left: bool) -> Self {
        Self { kind: address.kind, url: address.url().to_owned(), fault, left }
    }
}

/// What went wrong.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "server/")]
pub enum ServerFault {
    /// No connection.
    #[error("no response ({why}); check that the server is on and that host and port are right")]
    Away {
        /// The system's words.
        why: String,
    },
    /// A connection without an answer.
    #[error("no answer for {seconds} s; try again, or allow more time with --timeout SECONDS")]
    Silent {
        /// How long it was waited for.
        seconds: u64,
    },
    /// A connection that was closed during every try.
    #[error("the server closed the connection, or did not store the whole file; try again")]
    Closed,
    /// A certificate that is not trusted.
    #[error(
        "its certificate is not trusted: {why}; {}pass --fingerprint (on the server: openssl x509 -in CERTIFICATE -noout -fingerprint -sha256){}",
        if *.pinned { "if it is the right server, " } else { "" },
        if *.pinned { "" } else { ", or set SSL_CERT_FILE to the CA certificate" }
    )]
    Tls {
        /// The library's words.
        why: String,
        /// Whether a fingerprint was given.
        pinned: bool,
    },
    /// TLS was asked for, and it answers without.
    #[error("it does not use https there; write http://, or give its https port")]
    Plain,
    /// Another protocol.
    #[error("it does not speak HTTP: {why}; check the port, and whether it is http or https")]
    Garbled {
        /// The library's words.
        why: String,
    },
    /// A page for people.
    #[error(
        "it answers {what} with a web page or other text instead of data; check that it is {kind} and that no login page is in front of it"
    )]
    Page {
        /// What was asked.
        what: &'static str,
        /// What was looked for.
        kind: Kind,
    },
    /// It sends elsewhere.
    #[error("it redirects to {to}; the key was not sent there, so pass that address with --to if it is right")]
    Moved {
        /// Without what may follow a question mark.
        to: String,
    },
    /// A proxy that asks for a login.
    #[error("a proxy asks for a login ({login}) before the request reaches the server; pass the server's own address")]
    Login {
        /// Which, in its words.
        login: String,
    },
    /// Its printer has another firmware.
    #[error(
        "its printer runs {says}, but the file is written for {firmware}; prepare it with a profile for that, or connect the right printer"
    )]
    OtherFirmware {
        /// The printer's words.
        says: String,
        /// The file's.
        firmware: &'static str,
    },
    /// A server that requires a key.
    #[error("it requires a key; pass --key-file FILE or set TRUNNION_KEY")]
    NoKey,
    /// The key is wrong, or may not do this.
    #[error(
        "it rejects the {}; check the one in --key-file or TRUNNION_KEY{}",
        if *.kind == Kind::Duet { "password" } else { "key" },
        match (.kind, .start) {
            (Kind::OctoPrint, false) => ", which needs permission to upload",
            (Kind::OctoPrint, true) => ", which needs permission to upload and to print",
            (Kind::Moonraker | Kind::Duet, _) => "",
        }
    )]
    WrongKey {
        /// The server.
        kind: Kind,
        /// Whether a print was to begin.
        start: bool,
    },
    /// All sessions are in use.
    #[error("all its sessions are in use; close a browser tab that shows it, and try again")]
    Busy,
    /// The file does not go there.
    #[error("its disk is full: {}the file needs {needs} bytes; delete old files there", .free.map(|free| format!("{free} bytes are free, ")).unwrap_or_default())]
    Full {
        /// What is free there, where it says.
        free: Option<u64>,
        /// What the file needs.
        needs: u64,
    },
    /// A file above the server's limit.
    #[error("it rejects a file of {bytes} bytes; raise its upload limit")]
    TooLarge {
        /// The file's size.
        bytes: u64,
    },
    /// Another file has the name.
    #[error("it has another file called {name} ({bytes} bytes); replace it with --replace, or choose another --name")]
    Another {
        /// The name.
        name: String,
        /// That file's size.
        bytes: u64,
    },
    /// A print in progress.
    #[error("it is printing{}; {}", .file.as_ref().map(|file| format!(" {file}")).unwrap_or_default(), if *.uploaded { "the file is there, but was not started" } else { "nothing was started or uploaded" })]
    Printing {
        /// What it prints, where it says.
        file: Option<String>,
        /// Whether the file is there.
        uploaded: bool,
    },
    /// No printer that could begin.
    #[error("its printer is not ready: {why}; {}", if *.uploaded { "the file is there, but was not started" } else { "nothing was uploaded; leave out --start to upload only" })]
    NotReady {
        /// In its words.
        why: String,
        /// Whether the file is there.
        uploaded: bool,
    },
    /// A start whose result is unknown.
    #[error(
        "the file was uploaded, but the reply to the start command was lost; check the printer before starting again"
    )]
    Unclear,
    /// Not what was sent.
    #[error("upload corrupted ({sent} bytes sent, {there} bytes stored on the server); try again")]
    Differs {
        /// What was sent.
        sent: u64,
        /// What it has.
        there: u64,
    },
    /// The file has another name there.
    #[error(
        "it stored the file {}, not as {name}; delete that file there, and choose another --name",
        .stored.as_ref().map_or("under a name that it did not report".to_owned(), |stored| format!("as {stored}"))
    )]
    Renamed {
        /// What it is called there, where the server says.
        stored: Option<String>,
        /// The name that was asked for.
        name: String,
    },
    /// A server that knows nothing of the machine's settings.
    #[error("OctoPrint does not know the printer's settings; stop it, and read them with --port")]
    NoConfiguration,
    /// A printer that is not to be moved now.
    #[error("its printer is not idle: {why}; nothing was moved")]
    NotIdle {
        /// What it does, or why it does nothing.
        why: String,
    },
    /// A server that hands no single lines to its printer.
    #[error("only moonraker:URL is driven line by line; connect this printer to this computer, and pass --port")]
    NoConsole,
    /// A file that is to go, and stays.
    #[error("it did not delete the file {name}; delete it there")]
    NotDeleted {
        /// The name.
        name: String,
    },
    /// A refusal for the server's own reason.
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

impl ServerFault {
    /// Whether it may pass by itself.
    pub(super) fn may_pass(&self) -> bool {
        match self {
            Self::Away { .. } | Self::Silent { .. } | Self::Closed => true,
            Self::Refused { status, .. } => matches!(status, 502..=504),
            _ => false,
        }
    }
}
