//! `erard studio`: the page that plays, served to this machine's own browser.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use clap::Args;

use crate::answer::Answer;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::number::whole;
use crate::print_line;
use crate::session::Session;

/// The page's files where it was built in: names and bytes. `build.rs` fills it from the folder that ERARD_STUDIO
/// names.
mod built_in {
    include!(concat!(env!("OUT_DIR"), "/studio.rs"));
}

/// Text below the options.
const AFTER: &str = include_str!("help/studio.txt");

/// Opens the studio in the browser: press the key, turn the screws, compare two actions.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Studio {
    /// Port on this machine; 0 takes any free one
    #[arg(long, value_name = "NUMBER", default_value_t = 8088, value_parser = whole::<u16>(0, 65535))]
    port: u16,
    /// Folder of the built page
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
    /// Print the address and do not open a browser
    #[arg(long)]
    no_open: bool,
}

/// How long a browser may take for a request, s.
const PATIENCE: Duration = Duration::from_secs(10);
/// Longest request line and headers that are read, bytes.
const MAX_REQUEST_BYTES: u64 = 16 * 1024;
/// What the page may do, as it says itself; its workers get the same here.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'; style-src 'self'; \
     img-src 'self' data: blob:; manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Where the page's files are.
enum Page {
    BuiltIn,
    Folder(PathBuf),
}

impl Studio {
    /// Runs the command, until it is interrupted.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let page = self.page()?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, self.port)).map_err(|error| {
            Failure::Usage(format!(
                "port {} cannot be opened: {error}. Choose another with --port, or --port 0 for any free one",
                self.port
            ))
        })?;
        let port = listener.local_addr().map_err(|error| Failure::Internal(error.to_string()))?.port();
        let address = format!("http://localhost:{port}/");
        print_line!(session, "The studio runs at {address}. Stop it with Control-C.");
        session.printer.finish().map_err(Failure::Said)?;
        if !self.no_open {
            open(&address);
        }
        std::thread::scope(|scope| {
            for stream in listener.incoming().flatten() {
                scope.spawn(|| {
                    // A browser that goes away in the middle misses nothing that it wants.
                    let _ = answer(stream, &page);
                });
            }
        });
        Ok(Answer::default())
    }

    fn page(&self) -> Result<Page, Failure> {
        let is_page = |folder: &Path| folder.join("index.html").is_file() && folder.join("engine.bin").is_file();
        if let Some(folder) = &self.folder {
            return if is_page(folder) {
                Ok(Page::Folder(folder.clone()))
            } else {
                let folder = shown(folder);
                Err(Failure::Usage(format!(
                    "{folder}: is not a built studio; expected index.html and engine.bin in it. Build one with studio/build"
                )))
            };
        }
        if !built_in::FILES.is_empty() {
            return Ok(Page::BuiltIn);
        }
        let command = std::env::current_exe().map_err(|error| Failure::Internal(error.to_string()))?;
        let beside = command.parent().unwrap_or(Path::new("."));
        let mut places = vec![beside.join("studio"), beside.join("../share/erard/studio")];
        places.extend(beside.ancestors().map(|folder| folder.join("studio/site")));
        places.into_iter().find(|place| is_page(place)).map(Page::Folder).ok_or_else(|| {
            Failure::Usage(format!(
                "the studio's page was not found in this command nor in {}. Build it with studio/build from the source, or name its folder with --folder",
                shown(&beside.join("studio"))
            ))
        })
    }
}

impl Page {
    /// A file by its path in the page; `None` where there is none. Nothing outside the page can be asked for.
    fn file(&self, path: &str) -> Option<Vec<u8>> {
        let name = path.strip_prefix('/')?;
        let name = if name.is_empty() { "index.html" } else { name };
        let is_plain = |part: &str| {
            !part.is_empty()
                && !part.starts_with('.')
                && part.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c))
        };
        if !name.split('/').all(is_plain) {
            return None;
        }
        match self {
            Page::BuiltIn => built_in::FILES.iter().find(|(known, _)| *known == name).map(|(_, bytes)| bytes.to_vec()),
            Page::Folder(folder) => std::fs::read(folder.join(name)).ok(),
        }
    }
}

/// Answers one request.
fn answer(stream: TcpStream, page: &Page) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut reader = BufReader::new((&stream).take(MAX_REQUEST_BYTES));
    let mut first = String::new();
    reader.read_line(&mut first)?;
    let mut line = String::new();
    while reader.read_line(&mut line)? > 2 {
        line.clear();
    }
    let mut words = first.split_whitespace();
    let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let path = target.split(['?', '#']).next().unwrap_or_default();
    let mut out = &stream;
    if method != "GET" && method != "HEAD" {
        return out.write_all(
            b"HTTP/1.1 405 Method Not Allowed\r\nAllow: GET, HEAD\r\nContent-Length: 0\r\nConnection: close\r\n\r\n",
        );
    }
    let Some(bytes) = page.file(path) else {
        return out.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    };
    let kind = match path.rsplit('.').next() {
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("webmanifest") => "application/manifest+json",
        Some("bin") => "application/octet-stream",
        _ => "text/html; charset=utf-8",
    };
    write!(
        out,
        "HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nContent-Security-Policy: {POLICY}\r\n\
         X-Content-Type-Options: nosniff\r\nCache-Control: no-cache\r\nConnection: close\r\n\r\n",
        bytes.len()
    )?;
    if method == "GET" {
        out.write_all(&bytes)?;
    }
    out.flush()
}

/// Asks the system for its browser. Where there is none the address has been said.
fn open(address: &str) {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("cmd", &["/C", "start", ""])
    } else {
        ("xdg-open", &[])
    };
    let quiet = Stdio::null;
    let _ = Command::new(program).args(arguments).arg(address).stdin(quiet()).stdout(quiet()).stderr(quiet()).spawn();
}
