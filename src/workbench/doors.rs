//! Who may come in: the secret, the names of this computer, other sites' pages, names of files, sizes. Pure functions.

use super::WorkbenchError;
use super::http::RequestHead;

const MOST_NAME: usize = 120;
const MODELS: [&str; 4] = [".stl", ".obj", ".3mf", ".off"];

/// The ending of project files.
pub(super) const PROJECT: &str = ".trunnion";

/// What opens this workbench.
#[derive(Clone, Debug)]
pub(super) struct Doors {
    port: u16,
    /// Sent by the page with every request, out of the fragment of its address, which browsers keep to themselves.
    secret: String,
    /// In a cookie, for frames and downloads, which cannot send a header; good for files alone.
    cookie: String,
}

impl Doors {
    /// For this port, with two random texts.
    pub(super) fn new(port: u16, secret: String, cookie: String) -> Self {
        Self { port, secret, cookie }
    }

    /// The address for the person's browser.
    pub(super) fn address(&self) -> String {
        format!("http://127.0.0.1:{}/#{}", self.port, self.secret)
    }

    /// The cookie for files, as a header's value.
    pub(super) fn cookie(&self) -> String {
        format!("trunnion-{}={}; Path=/files/; HttpOnly; SameSite=Strict", self.port, self.cookie)
    }

    /// That the request was sent to this computer's own name, and by no page of another site.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::WrongHost`] and [`WorkbenchError::ForeignOrigin`].
    pub(super) fn near(&self, head: &RequestHead) -> Result<(), WorkbenchError> {
        let names = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", self.port));
        if !head.host.as_ref().is_some_and(|host| names.contains(host)) {
            return Err(WorkbenchError::WrongHost);
        }
        let own =
            |origin: &str| origin.strip_prefix("http://").is_some_and(|host| names.iter().any(|name| name == host));
        if head.origin.as_deref().is_some_and(|origin| !own(origin)) {
            return Err(WorkbenchError::ForeignOrigin);
        }
        Ok(())
    }

    /// That the request has the secret; for `files` the cookie is enough.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Unauthorised`].
    pub(super) fn known(&self, head: &RequestHead, files: bool) -> Result<(), WorkbenchError> {
        let name = format!("trunnion-{}", self.port);
        let cookies = head.cookie.iter().flat_map(|all| all.split(';')).filter_map(|one| one.trim().split_once('='));
        let cookie = || cookies.clone().any(|(key, value)| key == name && same(value, &self.cookie));
        let known = head.bearer.as_ref().is_some_and(|given| same(given, &self.secret)) || (files && cookie());
        if known { Ok(()) } else { Err(WorkbenchError::Unauthorised) }
    }
}

/// In a time that does not depend on where they differ.
fn same(a: &str, b: &str) -> bool {
    a.len() == b.len() && a.bytes().zip(b.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}

/// That `name` is a plain file name of a model: no folder, no control character, nothing that a command takes for a flag.
///
/// # Errors
///
/// [`WorkbenchError::BadName`].
pub(super) fn model_name(name: &str) -> Result<&str, WorkbenchError> {
    let lower = name.to_ascii_lowercase();
    let model = MODELS.iter().any(|end| lower.len() > end.len() && lower.ends_with(end));
    if is_plain(name) && model { Ok(name) } else { Err(WorkbenchError::BadName { name: shown(name) }) }
}

/// Whether `name` is that of a project file.
pub(super) fn is_project(name: &str) -> bool {
    name.len() > PROJECT.len() && name.to_ascii_lowercase().ends_with(PROJECT)
}

/// Whether `name` is a plain file name, as every system has them.
pub(super) fn is_plain(name: &str) -> bool {
    let plain = !name.starts_with(['-', '.', ' ']) && !name.ends_with([' ', '.']) && name.len() <= MOST_NAME;
    plain && !name.is_empty() && name.chars().all(is_clean)
}

/// Whether a file's name may have this character.
fn is_clean(c: char) -> bool {
    !(c.is_control() || "/\\:*?\"<>|".contains(c) || turns_text(c))
}

/// Whether the command takes it for the value of a flag.
pub(super) fn is_word(value: &str) -> bool {
    !value.starts_with('-') && !value.chars().any(char::is_control)
}

/// Whether `path` leads to a file below a folder, by plain names alone.
pub(super) fn is_below(path: &str) -> bool {
    path.len() <= 4 * MOST_NAME && path.split('/').all(is_plain)
}

/// A plain name that is as much of this one as can be.
pub(super) fn plain_of(name: &str) -> String {
    let clean: String = name.chars().map(|c| if is_clean(c) { c } else { '_' }).collect();
    let clean = clean.trim_start_matches(['-', '.', ' ']).trim_end_matches([' ', '.']);
    let (stem, end) = clean.rsplit_once('.').unwrap_or((clean, ""));
    let most = MOST_NAME - end.len().min(20) - 1;
    let cut = (0..=stem.len().min(most)).rev().find(|&at| stem.is_char_boundary(at)).unwrap_or_default();
    let name = format!("{}.{end}", &stem[..cut]);
    if is_plain(&name) { name } else { "model.stl".to_owned() }
}

/// Invisible characters that change the order of text, which would disguise a name.
fn turns_text(c: char) -> bool {
    matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

/// As much of a name as a sentence has space for.
pub(super) fn shown(name: &str) -> String {
    name.chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doors() -> Doors {
        Doors::new(4711, "secret".to_owned(), "key".to_owned())
    }

    fn head(host: &str, origin: Option<&str>) -> RequestHead {
        RequestHead { host: Some(host.to_owned()), origin: origin.map(str::to_owned), ..RequestHead::default() }
    }

    #[test]
    fn only_this_computers_names_and_pages_come_near() {
        for host in ["127.0.0.1:4711", "localhost:4711"] {
            assert!(doors().near(&head(host, None)).is_ok());
            assert!(doors().near(&head(host, Some("http://127.0.0.1:4711"))).is_ok());
        }
        for host in ["evil.example:4711", "127.0.0.1", "127.0.0.1:80", "127.0.0.1:4711.evil.example", "[::1]:4711", ""]
        {
            assert_eq!(doors().near(&head(host, None)).unwrap_err().code(), "workbench/wrong-host", "{host}");
        }
        assert!(doors().near(&RequestHead::default()).is_err());
        for origin in ["null", "https://127.0.0.1:4711", "http://evil.example", "http://127.0.0.1:4712", "file://"] {
            let refused = doors().near(&head("localhost:4711", Some(origin))).unwrap_err();
            assert_eq!(refused.code(), "workbench/foreign-origin", "{origin}");
        }
    }

    #[test]
    fn the_cookie_opens_files_and_nothing_else() {
        let with = |bearer: Option<&str>, cookie: Option<&str>| RequestHead {
            bearer: bearer.map(str::to_owned),
            cookie: cookie.map(str::to_owned),
            ..RequestHead::default()
        };
        let cookie = Some("a=b; trunnion-4711=key");
        for (bearer, cookie, api, files) in [
            (Some("secret"), None, true, true),
            (Some("secre"), None, false, false),
            (Some("Secret"), None, false, false),
            (Some("key"), None, false, false),
            (None, cookie, false, true),
            (None, Some("trunnion-4711=secret"), false, false),
            (None, Some("trunnion-4712=key"), false, false),
            (None, None, false, false),
        ] {
            let head = with(bearer, cookie);
            assert_eq!(doors().known(&head, false).is_ok(), api, "{head:?}");
            assert_eq!(doors().known(&head, true).is_ok(), files, "{head:?}");
        }
        assert!(doors().cookie().contains("HttpOnly; SameSite=Strict") && !doors().cookie().contains("secret"));
    }

    #[test]
    fn only_plain_names_of_models_are_taken() {
        for name in ["bracket.stl", "Teil 1.3MF", "größe.obj", "a.b.off"] {
            assert_eq!(model_name(name).unwrap(), name);
        }
        let long = format!("{}.stl", "x".repeat(200));
        for name in [
            "../a.stl",
            "a/b.stl",
            "..\\a.stl",
            "/etc/a.stl",
            "C:a.stl",
            "-o.stl",
            ".stl",
            ".a.stl",
            "a.stl\0",
            "a\n.stl",
            "a.gcode",
            "",
            "a",
            "a.stl ",
            "a\u{202e}lts.stl",
            "a*2.stl",
            "~/a.stl",
            &long,
        ] {
            assert_eq!(model_name(name).unwrap_err().code(), "workbench/bad-name", "{name:?}");
        }
    }

    #[test]
    fn paths_of_a_project_stay_below_its_folder() {
        for path in ["a.stl", "parts/a.stl", "a b/c (2).3mf"] {
            assert!(is_below(path), "{path}");
        }
        for path in [
            "",
            "/a.stl",
            "../a.stl",
            "a/../b.stl",
            "a//b.stl",
            "a/",
            "a\\b.stl",
            "C:/a.stl",
            "./a.stl",
            "-a/b.stl",
            "a/.b.stl",
            "a\0.stl",
        ] {
            assert!(!is_below(path), "{path:?}");
        }
        for (name, plain) in [
            ("a*2.stl", "a_2.stl"),
            ("-x.stl", "x.stl"),
            ("<b>.off", "_b_.off"),
            ("..", "model.stl"),
            ("", "model.stl"),
        ] {
            assert_eq!(plain_of(name), plain, "{name}");
        }
        let long = plain_of(&format!("{}.stl", "ü".repeat(200)));
        assert!(is_plain(&long) && long.ends_with("ü.stl"), "{long}");
        assert!(
            is_project("a.trunnion") && is_project("a.TRUNNION") && !is_project(".trunnion") && !is_project("a.stl")
        );
    }
}
