//! `erard studio`: the page is served as it was built, and nothing else; what is missing is said.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

use crate::common::Folder;

/// A command that serves, and ends with the test.
struct Serving(Child, u16);

impl Serving {
    fn new(folder: &Folder) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_erard"))
            .current_dir(&folder.0)
            .args(["studio", "--no-open", "--port", "0", "--folder", "page"])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut said).unwrap();
        let port = said.split("localhost:").nth(1).and_then(|rest| rest.split('/').next()).unwrap_or_default();
        let port = port.parse().unwrap_or_else(|_| panic!("no address in {said:?}"));
        Serving(child, port)
    }

    fn asked(&self, request: &str) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.1)).unwrap();
        write!(stream, "{request}\r\nHost: localhost\r\n\r\n").unwrap();
        let mut all = Vec::new();
        stream.read_to_end(&mut all).unwrap();
        let end = all.windows(4).position(|four| four == b"\r\n\r\n").expect("headers end") + 4;
        (String::from_utf8(all[..end].to_vec()).unwrap(), all[end..].to_vec())
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn folder(test: &str) -> Folder {
    let folder = Folder::for_command("studio", test);
    for (name, text) in [
        ("page/index.html", "<!doctype html>the page"),
        ("page/engine.bin", "the engine"),
        ("page/assets/index-1.js", "script"),
        ("page/.hidden", "hidden"),
        ("secret.txt", "secret"),
    ] {
        std::fs::create_dir_all(folder.0.join(name).parent().unwrap()).unwrap();
        folder.file(name, text);
    }
    folder
}

#[test]
fn the_page_is_served_and_nothing_else() {
    let folder = folder("served");
    let serving = Serving::new(&folder);
    for (path, body, kind) in [
        ("/", "<!doctype html>the page", "text/html"),
        ("/index.html?a#b", "<!doctype html>the page", "text/html"),
        ("/engine.bin", "the engine", "application/octet-stream"),
        ("/assets/index-1.js", "script", "text/javascript"),
    ] {
        let (head, found) = serving.asked(&format!("GET {path} HTTP/1.1"));
        assert!(head.starts_with("HTTP/1.1 200 ") && head.contains(&format!("Content-Type: {kind}")), "{path}: {head}");
        assert!(head.contains("Content-Security-Policy: default-src 'none'"), "{head}");
        assert_eq!(found, body.as_bytes(), "{path}");
        let (head, found) = serving.asked(&format!("HEAD {path} HTTP/1.1"));
        assert!(head.contains(&format!("Content-Length: {}", body.len())) && found.is_empty(), "{path}: {head}");
    }
    for path in [
        "/../secret.txt",
        "/assets/../../secret.txt",
        "/%2e%2e/secret.txt",
        "/.hidden",
        "/nothing",
        "//secret.txt",
        "secret.txt",
        "/assets",
    ] {
        let (head, found) = serving.asked(&format!("GET {path} HTTP/1.1"));
        assert!(head.starts_with("HTTP/1.1 404 ") && found.is_empty(), "{path}: {head}");
    }
    assert!(serving.asked("POST / HTTP/1.1").0.starts_with("HTTP/1.1 405 "));
    assert!(serving.asked("").0.starts_with("HTTP/1.1 405 "));
    // It still serves after what was wrong.
    assert!(serving.asked("GET / HTTP/1.1").0.starts_with("HTTP/1.1 200 "));
}

#[test]
fn what_is_missing_is_said() {
    let folder = folder("missing");
    let said = folder.bad(&["--no-open", "--port", "0", "--folder", "page/assets"]);
    assert!(said.contains("page/assets") && said.contains("engine.bin"), "{said}");
    let serving = Serving::new(&folder);
    let taken = serving.1.to_string();
    let said = folder.bad(&["--no-open", "--folder", "page", "--port", &taken]);
    assert!(said.contains(&taken) && said.contains("--port"), "{said}");
}
