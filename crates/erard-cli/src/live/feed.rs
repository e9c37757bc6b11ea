//! Lines of a stream, each with the instant at which it came, read by a thread of their own so that none waits.

use std::io::{BufRead, BufReader, Read};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Instant;

use erard_live::stream::MAX_LINE_LENGTH;

/// So many lines may wait. A sender that is faster then waits itself: nothing is dropped here.
const WAITING: usize = 1 << 16;

/// A line as it came, with its end.
pub(crate) struct Line {
    pub text: String,
    pub came: Instant,
}

/// Reads lines until the end.
pub(crate) fn lines(input: Box<dyn Read + Send>) -> Receiver<std::io::Result<Line>> {
    let (sender, receiver) = sync_channel(WAITING);
    std::thread::spawn(move || read(BufReader::new(input), &sender));
    receiver
}

/// The lines of a file, each with its end.
pub(crate) fn lines_of(mut file: impl BufRead) -> impl Iterator<Item = std::io::Result<String>> {
    std::iter::from_fn(move || {
        let mut line = String::new();
        match file.read_line(&mut line) {
            Ok(0) => None,
            Ok(_) => Some(Ok(line)),
            Err(error) => Some(Err(error)),
        }
    })
}

fn read(mut input: BufReader<Box<dyn Read + Send>>, sender: &SyncSender<std::io::Result<Line>>) {
    loop {
        let mut bytes = Vec::new();
        // What is longer comes in pieces, none of which is a sample.
        match input.by_ref().take(MAX_LINE_LENGTH as u64).read_until(b'\n', &mut bytes) {
            Ok(0) => return,
            Ok(_) => {
                let text = String::from_utf8_lossy(&bytes).into_owned();
                // Nobody listens any more.
                if sender.send(Ok(Line { text, came: Instant::now() })).is_err() {
                    return;
                }
            }
            Err(error) => {
                // Likewise.
                let _ = sender.send(Err(error));
                return;
            }
        }
    }
}
