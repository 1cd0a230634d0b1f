//! The bytes behind a glTF document: its binary chunk, `data:` URIs and files beside it.

use crate::bad_input::BadInput;
use crate::io::read_file;
use std::path::{Component, Path, PathBuf};

/// All buffers of a document, in its order, each at least as long as the document says.
#[derive(Debug)]
pub(in crate::io) struct Buffers {
    bytes: Vec<Vec<u8>>,
}

impl Buffers {
    /// Loads the buffers of the document; `blob` is the binary chunk of a GLB.
    pub(in crate::io) fn load(
        document: &gltf::Document,
        mut blob: Option<Vec<u8>>,
        folder: &Folder<'_>,
        place: &str,
    ) -> Result<Self, BadInput> {
        let mut bytes = Vec::new();
        for buffer in document.buffers() {
            let at = format!("{place}: buffer {}", buffer.index());
            let content = match buffer.source() {
                gltf::buffer::Source::Bin => blob.take().ok_or_else(|| {
                    BadInput::new(
                        &at,
                        "there is no binary chunk for it",
                        "export the file again",
                    )
                })?,
                gltf::buffer::Source::Uri(uri) => folder.load(uri, &at)?,
            };
            if content.len() < buffer.length() {
                return Err(BadInput::new(
                    &at,
                    format!(
                        "{} bytes of the promised {}",
                        content.len(),
                        buffer.length()
                    ),
                    "the file was cut off: copy or export it again",
                ));
            }
            bytes.push(content);
        }
        Ok(Self { bytes })
    }

    /// The bytes of a view, where it lies within its buffer.
    pub(in crate::io) fn view(&self, view: &gltf::buffer::View<'_>) -> Option<&[u8]> {
        let end = view.offset().checked_add(view.length())?;
        self.bytes
            .get(view.buffer().index())?
            .get(view.offset()..end)
    }
}

/// Where the files beside the document are.
#[derive(Clone, Copy, Debug)]
pub(in crate::io) enum Folder<'a> {
    /// In the folder of this file.
    Of(&'a Path),
    /// Nowhere: all data are in the document.
    None,
}

impl Folder<'_> {
    /// The bytes behind a URI; `at` is the place for messages.
    pub(in crate::io) fn load(&self, uri: &str, at: &str) -> Result<Vec<u8>, BadInput> {
        if let Some(data) = uri.strip_prefix("data:") {
            let encoded = data.split_once(";base64,").map(|(_, encoded)| encoded);
            return encoded.and_then(decode_base64).ok_or_else(|| {
                BadInput::new(
                    at,
                    "its data: URI is not valid base64",
                    "export the file again",
                )
            });
        }
        let Self::Of(path) = self else {
            return Err(BadInput::new(
                at,
                "lies in another file",
                "give a .glb that holds all its data",
            ));
        };
        let file = relative_file(uri).ok_or_else(|| {
            BadInput::new(
                at,
                format!("refers to \"{uri}\", which is not a file beside or below the scene"),
                "use relative paths without \"..\" or a scheme, or export as .glb",
            )
        })?;
        read_file(&path.parent().unwrap_or(Path::new("")).join(file)).map_err(|error| {
            BadInput::new(
                at,
                format!("its file {}: {}", error.place, error.what),
                "keep the files beside the scene, or export as .glb",
            )
        })
    }
}

/// A URI as a path that cannot leave the scene's directory by its own words.
fn relative_file(uri: &str) -> Option<PathBuf> {
    let decoded = decode_percent(uri)?;
    // A colon makes a scheme or a Windows drive, a backslash a Windows path.
    if decoded.is_empty() || decoded.contains([':', '\\', '\0']) {
        return None;
    }
    let file = PathBuf::from(decoded);
    let stays = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    file.components().all(stays).then_some(file)
}

fn decode_percent(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        rest = after;
        if byte == b'%' {
            let digits = rest.get(..2)?;
            if !digits.iter().all(u8::is_ascii_hexdigit) {
                return None;
            }
            bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
            rest = &rest[2..];
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok()
}

/// RFC 4648 base64 with or without padding; `None` for any other character or a length no encoder writes.
fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=');
    if text.len() % 4 == 1 {
        return None;
    }
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    // The low `count` bits of `bits` are decoded and not yet written.
    let mut bits = 0u32;
    let mut count = 0;
    for character in text.bytes() {
        let digit = match character {
            b'A'..=b'Z' => character - b'A',
            b'a'..=b'z' => character - b'a' + 26,
            b'0'..=b'9' => character - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(digit);
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count & 0xff) as u8);
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_rfc_4648_decodes() {
        for (encoded, plain) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg", "foob"),
            ("Zm9vYmFy", "foobar"),
        ] {
            assert_eq!(decode_base64(encoded).as_deref(), Some(plain.as_bytes()));
        }
        assert_eq!(decode_base64("/+8="), Some(vec![0xff, 0xef]));
        assert_eq!(decode_base64("Zm9v Zg=="), None);
        assert_eq!(decode_base64("Z"), None);
    }

    #[test]
    fn uris_stay_below_the_scene() {
        assert_eq!(
            relative_file("a%20b/c.bin"),
            Some(PathBuf::from("a b/c.bin"))
        );
        for uri in [
            "../a.bin",
            "a/../../b.bin",
            "%2e%2e/a.bin",
            "/etc/passwd",
            "file:///etc/passwd",
            "https://example.org/a.bin",
            "C:\\a.bin",
            "a%ff.bin",
            "a%2",
            "a%+1.bin",
            "",
        ] {
            assert_eq!(relative_file(uri), None, "{uri}");
        }
    }
}
