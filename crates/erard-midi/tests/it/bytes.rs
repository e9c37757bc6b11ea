//! Files, byte by byte.

/// 480 ticks for a quarter note.
pub const METRICAL: [u8; 2] = [0x01, 0xE0];
/// The end of a track.
pub const END: [u8; 4] = [0, 0xFF, 0x2F, 0];

/// A file of the given format, division and tracks.
pub fn smf(format: u8, division: [u8; 2], tracks: &[&[u8]]) -> Vec<u8> {
    let mut bytes = b"MThd\0\0\0\x06\0".to_vec();
    bytes.extend([format, 0, tracks.len() as u8]);
    bytes.extend(division);
    for track in tracks {
        bytes.extend(b"MTrk");
        bytes.extend((track.len() as u32).to_be_bytes());
        bytes.extend(*track);
    }
    bytes
}

/// Events, and the end of their track.
pub fn track(events: &[u8]) -> Vec<u8> {
    [events, &END].concat()
}
