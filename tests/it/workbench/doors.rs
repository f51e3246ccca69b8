//! Who may come in, by raw bytes on a socket.

use std::io::Write;

use super::{Workbench, open};
use crate::support::{root, said, trunnion};

/// The code of a refusal, or the status of an answer that is none.
fn code(workbench: &Workbench, request: &str) -> String {
    let answer = workbench.raw(request.as_bytes());
    let refused = (answer.status >= 400).then(|| answer.json()["code"].as_str().unwrap().to_owned());
    assert!(!answer.head.to_ascii_lowercase().contains("access-control"), "{}", answer.head);
    for header in ["X-Content-Type-Options: nosniff", "Referrer-Policy: no-referrer", "Content-Security-Policy: "] {
        assert!(answer.head.contains(header), "{header}: {}", answer.head);
    }
    refused.unwrap_or_else(|| answer.status.to_string())
}

#[test]
fn nobody_comes_in_without_the_secret_from_another_site_or_by_another_name() {
    let workbench = open(&["cube"], &["cube.stl"]);
    let (port, secret) = (workbench.port, workbench.secret());
    let own = format!("Host: 127.0.0.1:{port}\r\n");
    let known = format!("{own}Authorization: Bearer {secret}\r\n");
    let with = |line: &str, headers: &str| code(&workbench, &format!("{line} HTTP/1.1\r\n{headers}\r\n"));
    // The page is for everybody, and holds nothing.
    assert_eq!(with("GET /", &own), "200");
    assert_eq!(with("GET /api/state", &known), "200");
    for (line, headers, wanted) in [
        ("GET /api/state", own.clone(), "unauthorised"),
        ("GET /api/state", format!("{own}Authorization: Bearer {}\r\n", "0".repeat(48)), "unauthorised"),
        ("GET /api/state", format!("{own}Authorization: Basic {secret}\r\n"), "unauthorised"),
        ("GET /api/state?secret=x", own.clone(), "unauthorised"),
        // Not even what there is.
        ("GET /api/none", own.clone(), "unauthorised"),
        ("GET /files/cube.stl", own.clone(), "unauthorised"),
        ("POST /api/quit", own.clone(), "unauthorised"),
        ("GET /", "Host: evil.example\r\n".to_owned(), "wrong-host"),
        ("GET /", String::new(), "wrong-host"),
        ("GET /api/state", known.replace("127.0.0.1", "127.0.0.1.evil.example"), "wrong-host"),
        ("POST /api/quit", format!("{known}Origin: https://evil.example\r\n"), "foreign-origin"),
        ("POST /api/quit", format!("{known}Origin: null\r\n"), "foreign-origin"),
        ("GET /", format!("{own}Origin: http://127.0.0.1:1\r\n"), "foreign-origin"),
        ("OPTIONS /api/state", known.clone(), "wrong-method"),
        ("OPTIONS *", known.clone(), "not-found"),
        ("PUT /api/models", known.clone(), "wrong-method"),
        ("GET /api/none", known.clone(), "not-found"),
        ("GET /page/../../Cargo.toml", known.clone(), "not-found"),
        ("GET /files/cube.stl", known.clone(), "not-found"),
        ("GET /files/..%2fcube.stl", known.clone(), "not-found"),
        ("GET /files/%2fetc%2fpasswd", known.clone(), "not-found"),
        ("GET /files/cube.trunnion.gcode", known.clone(), "not-found"),
        ("GET /api/state", format!("{known}Transfer-Encoding: chunked\r\n"), "bad-request"),
        ("GET /%", known.clone(), "bad-request"),
        ("POST /api/models?name=big.stl", format!("{known}Content-Length: 400000000\r\n"), "too-large"),
        ("POST /api/run", format!("{known}Content-Length: 20000\r\n"), "too-large"),
        ("GET /", format!("{known}X: {}\r\n", "x".repeat(20_000)), "too-large"),
    ] {
        assert_eq!(with(line, &headers), format!("workbench/{wanted}"), "{line} {headers}");
    }
    for name in
        ["..%2fa.stl", "a%2fb.stl", "%2ftmp%2fa.stl", "..", "-o.stl", "a%00.stl", "a%0a.stl", "a.exe", "", "C:%5ca.stl"]
    {
        let answer = workbench.ask("POST", &format!("/api/models?name={name}"), b"solid");
        assert_eq!((answer.status, answer.json()["code"].as_str()), (400, Some("workbench/bad-name")), "{name}");
    }
    let mut names: Vec<_> =
        std::fs::read_dir(workbench.folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["cube.stl"]);
}

#[test]
fn the_cookie_of_a_frame_opens_files_alone() {
    let workbench = open(&["cube"], &["cube.stl", "-m", "generic-ac"]);
    workbench.post("/api/set?name=slicer&value=builtin");
    assert_eq!(workbench.run("prepare")["prepared"]["stale"], false);
    let session = workbench.ask("POST", "/api/session", b"");
    let cookie = session.head.lines().find_map(|line| line.strip_prefix("Set-Cookie: ")).unwrap().to_owned();
    assert!(
        cookie.ends_with("; Path=/files/; HttpOnly; SameSite=Strict") && !cookie.contains(workbench.secret()),
        "{cookie}"
    );
    let pair = cookie.split(';').next().unwrap();
    let get = |path: &str| {
        workbench.raw(
            format!("GET {path} HTTP/1.1\r\nHost: localhost:{}\r\nCookie: {pair}\r\n\r\n", workbench.port).as_bytes(),
        )
    };
    let page = get("/files/cube.trunnion.html");
    assert_eq!((page.status, page.body), (200, workbench.file("cube.trunnion.html")));
    // A preview is a site of its own, and runs no other's program.
    for words in ["sandbox allow-scripts", "default-src 'none'", "frame-ancestors 'self'"] {
        assert!(page.head.contains(words), "{}", page.head);
    }
    let file = get("/files/cube.trunnion.gcode");
    assert_eq!((file.status, file.body), (200, workbench.file("cube.trunnion.gcode")));
    assert!(file.head.contains("Content-Disposition: attachment"), "{}", file.head);
    assert_eq!(get("/api/state").status, 401);
}

#[test]
fn a_slow_client_keeps_nobody_waiting() {
    let workbench = open(&[], &[]);
    let mut slow: Vec<_> = (0..8).map(|_| workbench.connect()).collect();
    slow.iter_mut().for_each(|stream| stream.write_all(b"GET / HTTP/1.1\r\nHo").unwrap());
    let mut uploading = workbench.connect();
    let head = format!(
        "POST /api/models?name=slow.stl HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nAuthorization: Bearer {}\r\nContent-Length: 1000\r\n\r\nsolid",
        workbench.port,
        workbench.secret()
    );
    uploading.write_all(head.as_bytes()).unwrap();
    assert_eq!(workbench.state()["models"].as_array().unwrap().len(), 0);
    // Who goes away in the middle leaves nothing behind.
    drop(uploading);
    crate::support::wait_for("an empty folder", || std::fs::read_dir(workbench.folder.path()).unwrap().count() == 0);
    assert_eq!(workbench.state()["models"].as_array().unwrap().len(), 0);
}

/// The page's files as they are in the repository, and together small.
#[test]
fn the_page_is_its_sources() {
    let workbench = open(&[], &[]);
    let served = |path: &str| {
        let answer =
            workbench.raw(format!("GET {path} HTTP/1.1\r\nHost: localhost:{}\r\n\r\n", workbench.port).as_bytes());
        assert_eq!(answer.status, 200, "{path}");
        answer.body
    };
    let folder = root().join("src/workbench/page");
    let mut bytes = 0;
    for entry in std::fs::read_dir(&folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let body = served(&if name == "index.html" { "/".to_owned() } else { format!("/page/{name}") });
        assert_eq!(body, std::fs::read(folder.join(&name)).unwrap(), "{name}");
        assert!(!String::from_utf8_lossy(&body).contains("innerHTML"), "{name} makes markup of text");
        bytes += body.len();
    }
    let renderer = String::from_utf8(served("/view/renderer.js")).unwrap();
    for name in ["decode", "matrix", "colours", "beads", "machine", "draw"] {
        assert!(
            renderer.contains(&std::fs::read_to_string(root().join(format!("src/view/page/{name}.js"))).unwrap()),
            "{name}"
        );
    }
    bytes += renderer.len();
    crate::support::note(&format!("the page is {bytes} bytes"));
    assert!(bytes <= 400_000, "{bytes}");
}

#[test]
fn a_port_in_use_and_a_folder_that_takes_no_files_are_refused_in_a_sentence() {
    let workbench = open(&[], &[]);
    let port = workbench.port.to_string();
    for (words, wanted) in
        [(["--port", port.as_str()], "workbench/port"), (["--folder", "/proc/none"], "workbench/folder")]
    {
        let done = trunnion().args(["open", "--no-browser", "--json"]).args(words).output().unwrap();
        let document: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!((done.status.code(), document["code"].as_str()), (Some(2), Some(wanted)), "{}", said(&done));
    }
}
