//! Bytes beside those written in the specifications, and read back by another implementation.

use erard_midi::{Law, Message, Packet, Resolution, Velocity};
use midi2::channel_voice2::ChannelVoice2;
use midi2::prelude::*;

#[test]
fn bytes_of_midi_1() {
    let velocity = Velocity::new(77.5);
    assert_eq!(Message::note_on(3, 60, velocity, Resolution::SevenBits).bytes(), [0x93, 60, 78]);
    assert_eq!(Message::note_on(3, 60, velocity, Resolution::FourteenBits).bytes(), [0xB3, 88, 64, 0x93, 60, 77]);
    assert_eq!(Message::note_off(0, 21, velocity, Resolution::FourteenBits).bytes(), [0xB0, 88, 64, 0x80, 21, 77]);
    assert_eq!(Message::controller(15, 64, 127).bytes(), [0xBF, 64, 127]);
    // The softest note is no note-off, in either resolution.
    for soft in [0.0, 1e-9, 0.4, f64::NAN] {
        assert_eq!(Message::note_on(0, 60, Velocity::new(soft), Resolution::SevenBits).bytes()[2], 1);
        let fine = Message::note_on(0, 60, Velocity::new(soft), Resolution::FourteenBits);
        assert_eq!(fine.bytes(), [0xB0, 88, 0, 0x90, 60, 1]);
    }
    // A byte of data never has its highest bit.
    let wild = Message::note_on(255, 255, Velocity::new(1e300), Resolution::FourteenBits);
    assert_eq!(wild.bytes(), [0xBF, 88, 0, 0x9F, 127, 127]);
    let times = [Resolution::SevenBits, Resolution::FourteenBits]
        .map(|resolution| Message::note_on(0, 60, velocity, resolution).on_a_cable_s());
    assert!((times[0] - 0.96e-3).abs() < 1e-9 && (times[1] - 1.92e-3).abs() < 1e-9, "{times:?}");
}

/// Fourteen bits come back to half of their last one, sixteen to half of theirs.
#[test]
fn more_bits_tell_more() {
    for n in 0..=10_000 {
        let counts = 1.0 + 126.0 * f64::from(n) / 10_000.0;
        let velocity = Velocity::new(counts);
        let back = Velocity::of_fourteen_bits(velocity.fourteen_bits()).counts();
        assert!((back - counts).abs() <= 0.5 / 128.0 + 1e-12, "{counts}: {back}");
        let back = Velocity::of_sixteen_bits(velocity.sixteen_bits()).counts();
        assert!((back - counts).abs() <= 0.5 / 512.0 + 1e-12, "{counts}: {back}");
        assert!((f64::from(velocity.seven_bits()) - counts).abs() <= 0.5, "{counts}");
    }
}

/// The translation of the specification repeats the lower bits above the centre: 7 to 16 bits. Whole counts come within
/// one of it, and a receiver that drops nine bits has them back.
#[test]
fn sixteen_bits_are_those_of_the_translation() {
    for counts in 0..=127_u16 {
        let lower = counts & 0x3F;
        let translated = if counts <= 64 { counts << 9 } else { counts << 9 | lower << 3 | lower >> 3 };
        let found = Velocity::of_seven_bits(counts as u8).sixteen_bits();
        assert!(found.abs_diff(translated) <= 1, "{counts}: {found} for {translated}");
        assert_eq!(found >> 9, counts);
    }
}

/// Packets read by the crate `midi2`.
#[test]
fn packets_are_read_back_by_another_implementation() {
    let velocity = Law::GOEBL.velocity(2.0);
    let sent = Packet::note_on(5, 3, 60, velocity);
    let UmpMessage::ChannelVoice2(ChannelVoice2::NoteOn(on)) = UmpMessage::try_from(&sent.0[..]).unwrap() else {
        panic!("{sent:?}")
    };
    assert_eq!(u8::from(on.group()), 5);
    assert_eq!(u8::from(on.channel()), 3);
    assert_eq!(u8::from(on.note_number()), 60);
    assert_eq!(on.velocity(), velocity.sixteen_bits());
    assert!(on.attribute().is_none());
    let sent = Packet::note_off(0, 15, 108, Velocity::new(64.0));
    let UmpMessage::ChannelVoice2(ChannelVoice2::NoteOff(off)) = UmpMessage::try_from(&sent.0[..]).unwrap() else {
        panic!("{sent:?}")
    };
    assert_eq!((u8::from(off.channel()), u8::from(off.note_number()), off.velocity()), (15, 108, 0x8000));
    let sent = Packet::controller(1, 2, 64, 0xFFFF_FFFF);
    let UmpMessage::ChannelVoice2(ChannelVoice2::ControlChange(change)) = UmpMessage::try_from(&sent.0[..]).unwrap()
    else {
        panic!("{sent:?}")
    };
    assert_eq!(change.control_change_data(), 0xFFFF_FFFF);
    assert_eq!(sent.bytes(), [0x41, 0xB2, 64, 0, 255, 255, 255, 255]);
}
