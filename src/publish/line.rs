//! The line to one server: addresses and keys put on requests, answers read and every kind of no turned into its [`ServerFault`].

use std::time::Duration;

use serde_json::Value;

use super::address::{Key, Kind, ServerAddress};
use super::fault::ServerFault;
use super::fingerprint::Fingerprint;
use super::web::{Ask, HttpMethod, ServerAnswer, Trouble, Web};

/// More than this no answer has that is not a file.
const LARGEST_ANSWER: u64 = 16 << 20;
/// A question that changes nothing is asked so often, after such waits.
const PAUSES: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(3)];
/// So much of a server's own words is passed on.
const WORDS: usize = 160;

/// A server, and what is asked of it.
#[derive(Clone, Copy)]
pub(super) struct Reached<'a> {
    pub(super) address: &'a ServerAddress,
    pub(super) key: Option<&'a Key>,
    /// How long it may say nothing.
    pub(super) silence: Duration,
    /// The only certificate that is taken; `None`: what this computer's authorities vouch for.
    pub(super) fingerprint: Option<Fingerprint>,
    /// Bytes of the file that goes there; 0 for none.
    pub(super) bytes: u64,
    /// Whether a print is to begin.
    pub(super) start: bool,
}

/// The line.
pub(super) struct Line<'a> {
    pub(super) to: Reached<'a>,
    pub(super) web: &'a dyn Web,
}

/// A request of ours.
pub(super) struct Question<'a> {
    pub(super) method: HttpMethod,
    /// Behind the server's address.
    pub(super) path: String,
    pub(super) headers: Vec<(&'static str, String)>,
    pub(super) body: Option<Vec<&'a [u8]>>,
    pub(super) most: u64,
}

impl<'a> Question<'a> {
    /// One that reads.
    pub(super) fn get(path: String) -> Self {
        Self { method: HttpMethod::Get, path, headers: Vec::new(), body: None, most: LARGEST_ANSWER }
    }

    /// One that changes something.
    pub(super) fn post(path: String, kind: &str, body: Vec<&'a [u8]>) -> Self {
        let headers = vec![("Content-Type", kind.to_owned())];
        Self { method: HttpMethod::Post, headers, body: Some(body), ..Self::get(path) }
    }
}

impl Line<'_> {
    /// Asks once; whatever is said is an answer, but what only says that we are at the wrong door.
    pub(super) fn once(&self, question: Question<'_>, sent: &dyn Fn(usize)) -> Result<ServerAnswer, ServerFault> {
        let mut headers = question.headers;
        if let Some(key) = self.header_key() {
            headers.push(("X-Api-Key", key.to_owned()));
        }
        let url = format!("{}{}", self.to.address.url(), question.path);
        let (silence, most) = (self.to.silence, question.most);
        let (fingerprint, method, body) = (self.to.fingerprint, question.method, question.body);
        let ask = Ask { method, url, headers, body, most, silence, fingerprint };
        let answer = self.web.ask(&ask, sent).map_err(|trouble| self.fault(trouble))?;
        match answer.status {
            300..=399 => Err(ServerFault::Moved { to: elsewhere(answer.location.as_deref()) }),
            // None of the three asks so: what stands before it does.
            401 if let Some(login) = &answer.challenge => Err(ServerFault::Login { login: plain(login) }),
            401 | 403 if self.to.key.is_none() => Err(ServerFault::NoKey),
            401 | 403 => Err(ServerFault::WrongKey { kind: self.to.address.kind, start: self.to.start }),
            413 => Err(ServerFault::TooLarge { bytes: self.to.bytes }),
            507 => Err(ServerFault::Full { free: None, needs: self.to.bytes }),
            _ => Ok(answer),
        }
    }

    /// Reads; asked again where that may help. `None` where there is no such thing.
    pub(super) fn look(&self, what: &'static str, path: &str) -> Result<Option<Value>, ServerFault> {
        let answer = self.patiently(|| {
            let answer = self.once(Question::get(path.to_owned()), &|_| {})?;
            if answer.status == 404 { Ok(answer) } else { self.good(what, answer) }
        })?;
        if answer.status == 404 { Ok(None) } else { self.value(what, &answer).map(Some) }
    }

    /// Reads what must be there.
    pub(super) fn read(&self, what: &'static str, path: &str) -> Result<Value, ServerFault> {
        self.look(what, path)?.ok_or(ServerFault::Page { what, kind: self.to.address.kind })
    }

    /// The bytes of a file as large as ours.
    pub(super) fn fetch(&self, path: &str) -> Result<Vec<u8>, ServerFault> {
        let (what, most) = ("a download", self.to.bytes + 1);
        let get = || Question { most, ..Question::get(path.to_owned()) };
        Ok(self.patiently(|| self.good(what, self.once(get(), &|_| {})?))?.body)
    }

    /// `ask`, and again after a while where what went wrong may pass.
    fn patiently(&self, ask: impl Fn() -> Result<ServerAnswer, ServerFault>) -> Result<ServerAnswer, ServerFault> {
        for pause in PAUSES {
            match ask() {
                Err(fault) if fault.may_pass() => self.web.wait(pause),
                done => return done,
            }
        }
        ask()
    }

    /// An answer that says yes.
    pub(super) fn good(&self, what: &'static str, answer: ServerAnswer) -> Result<ServerAnswer, ServerFault> {
        match answer.status {
            200..=299 => Ok(answer),
            status => Err(ServerFault::Refused { what, status, words: self.words(&answer) }),
        }
    }

    /// The data of an answer; Moonraker wraps it.
    pub(super) fn value(&self, what: &'static str, answer: &ServerAnswer) -> Result<Value, ServerFault> {
        let page = ServerFault::Page { what, kind: self.to.address.kind };
        let value: Value = serde_json::from_slice(&answer.body).map_err(|_| page.clone())?;
        match value {
            Value::Object(mut all) if self.to.address.kind == Kind::Moonraker => {
                Ok(all.remove("result").unwrap_or(Value::Object(all)))
            }
            Value::Object(_) => Ok(value),
            _ => Err(page),
        }
    }

    /// Why a server says no, in its words, without the key.
    pub(super) fn words(&self, answer: &ServerAnswer) -> String {
        let value: Value = serde_json::from_slice(&answer.body).unwrap_or_default();
        let error = &value["error"];
        let said = error["message"].as_str().or_else(|| error.as_str());
        let text = String::from_utf8_lossy(&answer.body);
        let page = text.trim_start().starts_with('<');
        let said = said.unwrap_or(if page { "" } else { text.lines().next().unwrap_or_default() });
        let said = match self.to.key {
            Some(key) => said.replace(key.secret(), "..."),
            None => said.to_owned(),
        };
        plain(&said)
    }

    fn header_key(&self) -> Option<&str> {
        // A Duet takes its password once, on entering.
        let takes = self.to.address.kind != Kind::Duet;
        self.to.key.filter(|_| takes).map(Key::secret)
    }

    fn fault(&self, trouble: Trouble) -> ServerFault {
        match trouble {
            Trouble::Away { why } => ServerFault::Away { why },
            Trouble::Silent => ServerFault::Silent { seconds: self.to.silence.as_secs() },
            Trouble::Closed => ServerFault::Closed,
            Trouble::Tls { why } => ServerFault::Tls { why, pinned: self.to.fingerprint.is_some() },
            Trouble::Plain => ServerFault::Plain,
            Trouble::Garbled { why } => ServerFault::Garbled { why },
            Trouble::TooMuch => ServerFault::Page { what: "a question", kind: self.to.address.kind },
        }
    }
}

/// A stranger's words as they may be shown.
pub(super) fn plain(said: &str) -> String {
    said.chars().filter(|c| !c.is_control()).take(WORDS).collect()
}

/// Where a redirection leads, without what may hold a key.
fn elsewhere(location: Option<&str>) -> String {
    let plain = |c: &char| c.is_ascii_graphic();
    let to: String =
        location.unwrap_or_default().split(['?', '#']).next().unwrap_or_default().chars().filter(plain).collect();
    if to.is_empty() || to.contains('@') { "an address that is missing or contains a login".to_owned() } else { to }
}

/// `text` with all but letters and digits in per cent.
pub(super) fn escaped(text: &str) -> String {
    let one = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'.' | b'_' | b'-' => char::from(byte).to_string(),
        _ => format!("%{byte:02X}"),
    };
    text.bytes().map(one).collect()
}
