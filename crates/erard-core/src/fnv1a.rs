//! The one check sum of the project. The firmware, which has no standard library, compiles this file, too.

/// Starting value of [`fnv1a`].
pub const FNV1A: u64 = 0xcbf2_9ce4_8422_2325;

/// FNV-1a with 64 bits, continued from `hash`: for saved states, identities and promised bits.
pub fn fnv1a(hash: u64, bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(hash, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}
