//! Base64 (RFC 4648), for typed arrays inside a text file.

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// The values as little-endian `f32`, in base64. What is not finite becomes 0: the page draws numbers only.
pub fn floats(values: impl Iterator<Item = f64>) -> String {
    let mut bytes = Vec::with_capacity(4 * values.size_hint().0);
    for value in values {
        let value = if value.is_finite() { value as f32 } else { 0.0 };
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    encode(&bytes)
}

/// Bytes in base64.
pub fn encode(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word =
            chunk.iter().enumerate().fold(0u32, |word, (index, byte)| word | u32::from(*byte) << (16 - 8 * index));
        for index in 0..4 {
            if index <= chunk.len() {
                out.push(char::from(ALPHABET[(word >> (18 - 6 * index)) as usize & 63]));
            } else {
                out.push('=');
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The test vectors of RFC 4648, section 10.
    #[test]
    fn rfc_4648() {
        let cases = ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"];
        for (length, expected) in cases.into_iter().enumerate() {
            assert_eq!(encode(&b"foobar"[..length]), expected);
        }
    }

    #[test]
    fn floats_are_little_endian_and_finite() {
        assert_eq!(floats([1.0, f64::NAN].into_iter()), encode(&[0, 0, 0x80, 0x3f, 0, 0, 0, 0]));
    }
}
