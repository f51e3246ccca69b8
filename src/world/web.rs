//! Sockets and TLS for requests to servers, and the key that the environment has.
//!
//! TLS is there where the crate is built with the feature `tls`.
//! Certificates are held against this computer's own authorities (on Linux what `SSL_CERT_FILE` or the usual folders have). No proxy
//! is used: printers stand on one's own network. No redirection is followed.

use std::io::{ErrorKind, Read};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use ureq::config::Config;
use ureq::http::{Request, Response};
use ureq::unversioned::transport::DefaultConnector;
use ureq::{Agent, AsSendBody, Body, SendBody};

use super::names::Names;
use crate::publish::{Ask, Fingerprint, HttpMethod, ServerAnswer, Trouble, Web};
use crate::slicing::KEY_VARIABLE;

/// A server that is there answers the first packet much sooner.
const CONNECT: Duration = Duration::from_secs(10);

/// The environment's `TRUNNION_KEY`.
pub fn key_from_environment() -> Option<String> {
    std::env::var_os(KEY_VARIABLE).map(|key| key.to_string_lossy().into_owned())
}

/// This computer's way to servers.
#[derive(Clone, Copy, Debug, Default)]
pub struct OwnWeb;

impl Web for OwnWeb {
    fn ask(&self, ask: &Ask<'_>, sent: &dyn Fn(usize)) -> Result<ServerAnswer, Trouble> {
        let agent = &agent_for(ask.fingerprint.as_ref())?;
        let method = match ask.method {
            HttpMethod::Get => "GET",
            HttpMethod::Post => "POST",
            HttpMethod::Delete => "DELETE",
        };
        let mut request = Request::builder().method(method).uri(&ask.url);
        for (name, value) in &ask.headers {
            request = request.header(*name, value);
        }
        let mut pieces = Pieces { pieces: ask.body.as_deref().unwrap_or_default(), at: 0, sent, gone: 0 };
        let answer = match &ask.body {
            None => {
                let request = request.body(()).map_err(|error| garbled(&error))?;
                agent.run(patient(agent, request, ask.silence))
            }
            Some(body) => {
                let length: usize = body.iter().map(|piece| piece.len()).sum();
                let body = SendBody::from_reader(&mut pieces);
                let request = request.header("Content-Length", length).body(body).map_err(|error| garbled(&error))?;
                agent.run(patient(agent, request, ask.silence))
            }
        };
        read(answer.map_err(trouble)?, ask.most)
    }

    fn wait(&self, time: Duration) {
        std::thread::sleep(time);
    }

    fn speaks_tls(&self) -> bool {
        cfg!(feature = "tls")
    }
}

/// `request`, given up where the server says or takes nothing for so long.
fn patient<S: AsSendBody>(agent: &Agent, request: Request<S>, silence: Duration) -> Request<S> {
    let request = agent.configure_request(request);
    let request = request.timeout_per_read(Some(silence)).timeout_per_write(Some(silence));
    request.timeout_recv_response(Some(silence)).build()
}

/// Connections and authorities are kept for the next request.
fn agent_for(fingerprint: Option<&Fingerprint>) -> Result<Agent, Trouble> {
    static AGENTS: Mutex<Vec<(Option<Fingerprint>, Agent)>> = Mutex::new(Vec::new());
    let mut agents = AGENTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, agent)) = agents.iter().find(|(of, _)| of.as_ref() == fingerprint) {
        return Ok(agent.clone());
    }
    let agent = match fingerprint {
        None => Agent::with_parts(config(), DefaultConnector::new(), Names),
        Some(fingerprint) => pinned(*fingerprint)?,
    };
    agents.push((fingerprint.copied(), agent.clone()));
    Ok(agent)
}

/// Whoever shows another certificate is nobody.
#[cfg(feature = "tls")]
fn pinned(fingerprint: Fingerprint) -> Result<Agent, Trouble> {
    use ureq::unversioned::transport::{Connector, TcpConnector};
    let connector = super::pinned::PinnedConnector::new(fingerprint).map_err(|error| of_tls(&error))?;
    Ok(Agent::with_parts(config(), ().chain(TcpConnector::default()).chain(connector), Names))
}

#[cfg(not(feature = "tls"))]
fn pinned(_: Fingerprint) -> Result<Agent, Trouble> {
    Ok(Agent::with_parts(config(), DefaultConnector::new(), Names))
}

fn config() -> Config {
    let config = Agent::config_builder()
        .http_status_as_error(false)
        .max_redirects(0)
        .max_redirects_will_error(false)
        .proxy(None)
        .user_agent(concat!("trunnion/", env!("CARGO_PKG_VERSION")))
        .timeout_resolve(Some(CONNECT))
        .timeout_connect(Some(CONNECT));
    #[cfg(feature = "tls")]
    let config = config.tls_config(of_this_computer());
    config.build()
}

/// Certificates are checked against the authorities that this computer trusts.
#[cfg(feature = "tls")]
fn of_this_computer() -> ureq::tls::TlsConfig {
    use ureq::tls::{RootCerts, TlsConfig};
    let provider = std::sync::Arc::new(rustls::crypto::ring::default_provider());
    let tls = TlsConfig::builder().root_certs(RootCerts::PlatformVerifier).unversioned_rustls_crypto_provider(provider);
    tls.build()
}

fn read(answer: Response<Body>, most: u64) -> Result<ServerAnswer, Trouble> {
    let status = answer.status().as_u16();
    let challenge = answer.headers().get("www-authenticate").and_then(|v| v.to_str().ok()).map(str::to_owned);
    let location = answer.headers().get("location").and_then(|v| v.to_str().ok()).map(str::to_owned);
    let mut body = Vec::new();
    let mut reader = answer.into_body().into_reader().take(most + 1);
    reader.read_to_end(&mut body).map_err(|error| trouble(ureq::Error::from(error)))?;
    if body.len() as u64 > most {
        return Err(Trouble::TooMuch);
    }
    Ok(ServerAnswer { status, location, challenge, body })
}

fn garbled(error: &dyn std::fmt::Display) -> Trouble {
    Trouble::Garbled { why: error.to_string().to_lowercase() }
}

fn trouble(error: ureq::Error) -> Trouble {
    use ureq::{Error, Timeout};
    match error {
        Error::HostNotFound => Trouble::Away { why: "host not found".to_owned() },
        Error::Timeout(Timeout::Resolve | Timeout::Connect) => {
            Trouble::Away { why: format!("no answer within {} s", CONNECT.as_secs()) }
        }
        Error::Timeout(_) => Trouble::Silent,
        #[cfg(feature = "tls")]
        Error::Rustls(error) => of_tls(&error),
        Error::Tls(why) => Trouble::Tls { why: why.to_owned() },
        Error::ConnectionFailed => Trouble::Away { why: "no connection".to_owned() },
        Error::Io(error) => of_io(&error),
        other => garbled(&other),
    }
}

#[cfg(feature = "tls")]
fn of_tls(error: &rustls::Error) -> Trouble {
    match error {
        // Its first bytes are no record of TLS.
        rustls::Error::InvalidMessage(rustls::InvalidMessage::InvalidContentType) => Trouble::Plain,
        rustls::Error::General(why) => Trouble::Tls { why: why.clone() },
        other => Trouble::Tls { why: other.to_string() },
    }
}

fn of_io(error: &std::io::Error) -> Trouble {
    #[cfg(feature = "tls")]
    if let Some(tls) = error.get_ref().and_then(|inner| inner.downcast_ref::<rustls::Error>()) {
        return of_tls(tls);
    }
    if let Some(inner) = error.get_ref().and_then(|inner| inner.downcast_ref::<ureq::Error>()) {
        return match inner {
            ureq::Error::Timeout(_) => Trouble::Silent,
            _ => Trouble::Closed,
        };
    }
    match error.kind() {
        ErrorKind::UnexpectedEof
        | ErrorKind::ConnectionReset
        | ErrorKind::ConnectionAborted
        | ErrorKind::BrokenPipe
        | ErrorKind::NotConnected => Trouble::Closed,
        ErrorKind::TimedOut | ErrorKind::WouldBlock => Trouble::Silent,
        _ => Trouble::Away { why: super::in_words(error) },
    }
}

/// A body read piece after piece, so that a file is not copied for its form.
struct Pieces<'a> {
    pieces: &'a [&'a [u8]],
    at: usize,
    sent: &'a dyn Fn(usize),
    gone: usize,
}

impl Read for Pieces<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        while let Some((first, rest)) = self.pieces.split_first() {
            if self.at == first.len() {
                (self.pieces, self.at) = (rest, 0);
                continue;
            }
            let count = into.len().min(first.len() - self.at);
            into[..count].copy_from_slice(&first[self.at..self.at + count]);
            self.at += count;
            self.gone += count;
            (self.sent)(self.gone);
            return Ok(count);
        }
        Ok(0)
    }
}
