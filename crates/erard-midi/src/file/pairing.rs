//! Note-ons and note-offs of a key, put together.

use std::vec::Vec;

/// What a channel does to a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Touch {
    /// A note-on, with its velocity, 14 bits.
    On(u16),
    /// A note-off, with its velocity, 14 bits, where it was measured.
    Off(Option<u16>),
    /// The end of all that the channel holds.
    AllOff,
}

/// A note-on with its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Hold {
    pub on: u64,
    pub velocity: u16,
    /// Tick of its note-off, and the velocity there; `None` without one.
    pub off: Option<(u64, Option<u16>)>,
}

/// Strike of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Strike {
    pub on: u64,
    /// Of its note-ons, the loudest.
    pub velocity: u16,
    /// Tick at which it ends, and the velocity of its release; `None`: it is held to the end of the file.
    pub off: Option<(u64, Option<u16>)>,
    /// Number of note-ons.
    pub count: usize,
    /// Whether none of these has a note-off.
    pub is_endless: bool,
}

/// The holds of one channel on a key, from its touches in the order of ticks and, within a tick, of the file; and the
/// ticks of notes that end as they begin. A note-off ends the last of what began before its tick, or else what began in
/// its tick before it.
pub(super) fn holds(touches: &[(u64, Touch)]) -> (Vec<Hold>, Vec<u64>) {
    let (mut holds, mut empty) = (Vec::new(), Vec::new());
    let mut held: Vec<Hold> = Vec::new();
    for together in touches.chunk_by(|a, b| a.0 == b.0) {
        let mut begun = Vec::new();
        for &(on, touch) in together {
            match touch {
                Touch::On(velocity) => begun.push(Hold { on, velocity, off: None }),
                Touch::Off(release) => match held.pop() {
                    Some(hold) => holds.push(Hold { off: Some((on, release)), ..hold }),
                    None => empty.extend(begun.pop().map(|_| on)),
                },
                Touch::AllOff => holds.extend(held.drain(..).map(|hold| Hold { off: Some((on, None)), ..hold })),
            }
        }
        held.append(&mut begun);
    }
    holds.append(&mut held);
    (holds, empty)
}

/// The strikes of a key from the holds of all channels. A key that is struck while it is held ends one note and begins
/// the next, which lasts until all have let go.
pub(super) fn strikes(mut holds: Vec<Hold>) -> Vec<Strike> {
    holds.sort_by_key(|hold| hold.on);
    let mut strikes: Vec<Strike> = Vec::new();
    // The last to let go.
    let mut last: Option<(u64, Option<u16>)> = None;
    for together in holds.chunk_by(|a, b| a.on == b.on) {
        let on = together[0].on;
        if let Some(before) = strikes.last_mut()
            && before.off.is_none_or(|(off, _)| off > on)
        {
            before.off = Some((on, None));
        }
        let own = together.iter().filter_map(|hold| hold.off).max_by_key(|(tick, _)| *tick);
        last = last.filter(|(tick, _)| *tick > on);
        if let Some(own) = own
            && last.is_none_or(|(tick, _)| tick < own.0)
        {
            last = Some(own);
        }
        let velocity = together.iter().map(|hold| hold.velocity).max().unwrap_or(0);
        strikes.push(Strike { on, velocity, off: last, count: together.len(), is_endless: own.is_none() });
    }
    strikes
}
