//! Requests and answers as bytes: one request a connection, heads of bounded size, bodies by their length alone.
//!
//! `httparse` reads the heads. A server crate was compared: `tiny_http` 0.12 bounds neither a head nor the time it takes, and `axum` is
//! 26 CPU seconds of building.

use std::fmt::Write;

use super::WorkbenchError;

/// The largest model that is taken, MB.
pub(super) const MOST_UPLOADED_MB: u64 = 300;
/// The largest head of a request, bytes.
pub(super) const MOST_HEAD: usize = 16 << 10;
const MOST_HEADERS: usize = 64;

/// The head of a request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct RequestHead {
    /// Its method, in capitals.
    pub(super) method: String,
    /// The path, decoded.
    pub(super) path: String,
    /// Names and values behind the question mark, decoded.
    pub(super) query: Vec<(String, String)>,
    /// `Host`.
    pub(super) host: Option<String>,
    /// `Origin`.
    pub(super) origin: Option<String>,
    /// What follows `Bearer` in `Authorization`.
    pub(super) bearer: Option<String>,
    /// `Cookie`.
    pub(super) cookie: Option<String>,
    /// Length of the body, bytes; 0 without one.
    pub(super) length: u64,
}

impl RequestHead {
    /// The value of a name in the query; empty without one.
    pub(super) fn value(&self, name: &str) -> &str {
        self.query.iter().find(|(key, _)| key == name).map_or("", |(_, value)| value)
    }
}

const fn bad(what: &'static str) -> WorkbenchError {
    WorkbenchError::BadRequest { what }
}

/// The head at the beginning of `bytes` and its length; `None` while it is incomplete.
///
/// # Errors
///
/// [`WorkbenchError::BadRequest`] and [`WorkbenchError::TooLarge`].
pub(super) fn head(bytes: &[u8]) -> Result<Option<(RequestHead, usize)>, WorkbenchError> {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    let length = match request.parse(bytes) {
        Ok(httparse::Status::Complete(length)) => length,
        Ok(httparse::Status::Partial) if bytes.len() < MOST_HEAD => return Ok(None),
        Ok(httparse::Status::Partial) => return Err(WorkbenchError::TooLarge { limit_mb: MOST_UPLOADED_MB }),
        Err(_) => return Err(bad("it is not HTTP/1.1")),
    };
    let target = request.path.unwrap_or_default();
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let mut head = RequestHead {
        method: request.method.unwrap_or_default().to_owned(),
        path: decoded(path)?,
        query: query.split('&').filter(|pair| !pair.is_empty()).map(pair).collect::<Result<_, _>>()?,
        ..RequestHead::default()
    };
    for header in request.headers.iter() {
        let value = std::str::from_utf8(header.value).map_err(|_| bad("a header is not text"))?.trim();
        head.take(header.name, value)?;
    }
    Ok(Some((head, length)))
}

impl RequestHead {
    fn take(&mut self, name: &str, value: &str) -> Result<(), WorkbenchError> {
        let once = |kept: &mut Option<String>| match kept.replace(value.to_owned()) {
            None => Ok(()),
            Some(_) => Err(bad("a header is there twice")),
        };
        match name.to_ascii_lowercase().as_str() {
            "host" => once(&mut self.host),
            "origin" => once(&mut self.origin),
            "cookie" => once(&mut self.cookie),
            "authorization" => {
                self.bearer = value.strip_prefix("Bearer ").map(str::to_owned);
                Ok(())
            }
            "content-length" => {
                let digits = value.bytes().all(|b| b.is_ascii_digit());
                let length = value.parse().ok().filter(|_| digits && self.length == 0);
                self.length = length.ok_or(bad("its length is not a number"))?;
                Ok(())
            }
            "transfer-encoding" => Err(bad("its length is not stated")),
            _ => Ok(()),
        }
    }
}

fn pair(text: &str) -> Result<(String, String), WorkbenchError> {
    let (name, value) = text.split_once('=').unwrap_or((text, ""));
    Ok((decoded(name)?, decoded(value)?))
}

/// Text without its percent signs.
fn decoded(text: &str) -> Result<String, WorkbenchError> {
    let mut out = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(byte) = bytes.next() {
        out.push(if byte == b'%' { hex(bytes.next(), bytes.next())? } else { byte });
    }
    String::from_utf8(out).map_err(|_| bad("its address is not text"))
}

fn hex(high: Option<u8>, low: Option<u8>) -> Result<u8, WorkbenchError> {
    let digit = |byte: Option<u8>| byte.and_then(|b| char::from(b).to_digit(16));
    let both = digit(high).zip(digit(low)).map(|(high, low)| (high * 16 + low) as u8);
    both.ok_or(bad("its address has a percent sign without two digits"))
}

/// What is answered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct HttpAnswer {
    /// The status.
    pub(super) status: u16,
    /// `Content-Type`.
    pub(super) kind: &'static str,
    /// More headers, beside those that every answer has.
    pub(super) more: Vec<(&'static str, String)>,
    /// The body.
    pub(super) body: Vec<u8>,
}

impl HttpAnswer {
    /// A body of this kind.
    pub(super) fn of(kind: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self { status: 200, kind, more: Vec::new(), body: body.into() }
    }

    /// A JSON document.
    pub(super) fn json(value: &serde_json::Value) -> Self {
        Self::of("application/json", value.to_string())
    }

    /// Why not, with the same keys as a failure of the command.
    pub(super) fn refusal(error: &WorkbenchError) -> Self {
        let document = serde_json::json!({"error": error.to_string(), "code": error.code()});
        Self { status: error.status(), ..Self::json(&document) }
    }

    /// The head of the answer, with the headers that keep other sites out. `length` is `None` for a stream of events.
    pub(super) fn head(&self, length: Option<u64>) -> String {
        let mut out = format!("HTTP/1.1 {} {}\r\nContent-Type: {}\r\n", self.status, reason(self.status), self.kind);
        if let Some(length) = length {
            let _ = write!(out, "Content-Length: {length}\r\n");
        }
        for (name, value) in &self.more {
            let _ = write!(out, "{name}: {value}\r\n");
        }
        if !self.more.iter().any(|(name, _)| *name == "Content-Security-Policy") {
            let _ = write!(out, "Content-Security-Policy: {POLICY}\r\n");
        }
        out.push_str(
            "X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
             Cross-Origin-Opener-Policy: same-origin\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
        );
        out
    }
}

/// What the page may do: run its own modules, ask this server, and show the preview in a frame.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
    frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        204 => "No Content",
        400 => "Bad Request",
        401 => "Unauthorized",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        409 => "Conflict",
        413 => "Content Too Large",
        503 => "Service Unavailable",
        _ => "Internal Server Error",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Option<(RequestHead, usize)>, &'static str> {
        head(text.as_bytes()).map_err(|error| error.code())
    }

    #[test]
    fn a_head_is_read_with_its_query_and_length() {
        let text = "POST /api/models?name=a%20b.stl&x= HTTP/1.1\r\nHost: localhost:1\r\nAuthorization: Bearer s\r\nContent-Length: 5\r\n\r\nhello";
        let (head, length) = read(text).unwrap().unwrap();
        assert_eq!(
            (head.path.as_str(), head.value("name"), head.value("x"), head.value("y")),
            ("/api/models", "a b.stl", "", "")
        );
        assert_eq!((head.length, head.bearer.as_deref(), &text[length..]), (5, Some("s"), "hello"));
        assert_eq!(read("GET / HTTP/1.1\r\nHos"), Ok(None));
    }

    #[test]
    fn what_is_not_understood_is_refused() {
        let long = format!("GET / HTTP/1.1\r\nX: {}", "x".repeat(MOST_HEAD));
        for (text, code) in [
            ("GET /%zz HTTP/1.1\r\n\r\n", "workbench/bad-request"),
            ("GET /%ff HTTP/1.1\r\n\r\n", "workbench/bad-request"),
            ("hello\r\n\r\n", "workbench/bad-request"),
            ("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n", "workbench/bad-request"),
            ("POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n", "workbench/bad-request"),
            ("POST / HTTP/1.1\r\nContent-Length: 5\r\nContent-Length: 6\r\n\r\n", "workbench/bad-request"),
            ("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", "workbench/bad-request"),
            (&long, "workbench/too-large"),
        ] {
            assert_eq!(read(text), Err(code), "{}", &text[..text.len().min(60)]);
        }
    }

    #[test]
    fn every_answer_keeps_other_sites_out() {
        let answer = HttpAnswer::refusal(&WorkbenchError::Unauthorised);
        let head = answer.head(Some(2));
        assert!(head.starts_with("HTTP/1.1 401 Unauthorized\r\n") && head.ends_with("\r\n\r\n"), "{head}");
        for words in ["default-src 'none'", "frame-ancestors 'none'", "nosniff", "no-referrer", "no-store"] {
            assert!(head.contains(words), "{words}");
        }
        assert!(!head.contains("Access-Control"));
    }
}
