//! One request and its answer, as values; whoever has a socket carries them.

use std::time::Duration;

use super::fingerprint::Fingerprint;

/// What is done with a place on a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HttpMethod {
    /// Read.
    Get,
    /// Written.
    Post,
    /// Taken away.
    Delete,
}

/// A request. Its address and headers may hold the key, so it cannot be printed.
pub struct Ask<'a> {
    /// What is done.
    pub method: HttpMethod,
    /// The whole address.
    pub url: String,
    /// Headers besides host and length.
    pub headers: Vec<(&'static str, String)>,
    /// The body, piece after piece; `None` for none.
    pub body: Option<Vec<&'a [u8]>>,
    /// An answer of more bytes is none.
    pub most: u64,
    /// How long the server may say, and take, nothing.
    pub silence: Duration,
    /// The only certificate that is taken; `None`: what this computer's authorities vouch for.
    pub fingerprint: Option<Fingerprint>,
}

/// What a server said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerAnswer {
    /// HTTP's number.
    pub status: u16,
    /// Where it says the place is now.
    pub location: Option<String>,
    /// Which login is asked for, where one is (`WWW-Authenticate`).
    pub challenge: Option<String>,
    /// What it said.
    pub body: Vec<u8>,
}

/// Why there was no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// No connection.
    Away {
        /// The system's words.
        why: String,
    },
    /// A connection without an answer.
    Silent,
    /// The connection ended before the answer did.
    Closed,
    /// Its certificate, or what it says as TLS.
    Tls {
        /// The library's words.
        why: String,
    },
    /// TLS was asked for, and it answers without.
    Plain,
    /// What it says is no HTTP.
    Garbled {
        /// The library's words.
        why: String,
    },
    /// More than was asked for.
    TooMuch,
}

/// Whoever has a socket.
pub trait Web {
    /// Sends `ask` and waits for the answer; follows no redirection, since the key would go with it. `sent` is told the bytes of the
    /// body that have gone.
    ///
    /// # Errors
    ///
    /// [`Trouble`]; whether the server has done what it was asked is not known then.
    fn ask(&self, ask: &Ask<'_>, sent: &dyn Fn(usize)) -> Result<ServerAnswer, Trouble>;

    /// Returns after `time`.
    fn wait(&self, time: Duration);

    /// Whether `https://` addresses can be asked.
    fn speaks_tls(&self) -> bool {
        true
    }
}
