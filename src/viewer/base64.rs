//! Numbers as text: little-endian bytes in base64 (RFC 4648 §4).

use serde::{Serialize, Serializer};

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// A list of numbers that is written as base64.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Packed(Vec<u8>);

impl Packed {
    pub(super) fn floats(values: impl IntoIterator<Item = f64>) -> Self {
        // Never infinite: a page would lose its picture for one such number.
        let limit = f64::from(f32::MAX);
        let bytes = |v: f64| (v.clamp(-limit, limit) as f32).to_le_bytes();
        Self(values.into_iter().flat_map(bytes).collect())
    }

    pub(super) fn indices(values: impl IntoIterator<Item = u32>) -> Self {
        Self(values.into_iter().flat_map(u32::to_le_bytes).collect())
    }
}

impl Serialize for Packed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&encode(&self.0))
    }
}

pub(crate) fn encode(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let [a, b, c] = std::array::from_fn(|i| u32::from(chunk.get(i).copied().unwrap_or(0)));
        let bits = a << 16 | b << 8 | c;
        for k in 0..4 {
            let digit = ALPHABET[(bits >> (18 - 6 * k)) as usize & 63];
            text.push(if k <= chunk.len() { digit.into() } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::encode;

    #[test]
    fn the_examples_of_the_standard_come_out() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(encode(bytes.as_bytes()), text);
        }
        assert_eq!(encode(&[0xfb, 0xff]), "+/8=");
    }
}
