//! OBJ and MTL files as lines of text with their numbers.

use std::borrow::Cow;

/// The text of a file. Bytes that are not UTF-8 (old exporters put them into comments and names) become U+FFFD.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes))
}

/// The statements of a file: the number of the first line of each (from 1), its keyword, and the rest of the line.
///
/// A line that ends in `\` goes on in the next one. Comments and empty lines are left out; a comment never goes on, for
/// it may end in a Windows path.
pub(super) fn statements(text: &str) -> impl Iterator<Item = Statement<'_>> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        loop {
            let (index, first) = lines.next()?;
            let mut line = Cow::Borrowed(first.trim());
            if line.starts_with('#') || line.is_empty() {
                continue;
            }
            while let Some(head) = line.strip_suffix('\\') {
                let next = lines.next().map_or("", |(_, next)| next);
                line = Cow::Owned(format!("{head} {}", next.trim()));
            }
            let number = index + 1;
            return Some(Statement { number, line });
        }
    })
}

/// One statement of a file.
#[derive(Debug)]
pub(super) struct Statement<'a> {
    /// The line on which it starts, from 1.
    pub(super) number: usize,
    line: Cow<'a, str>,
}

impl Statement<'_> {
    /// The first word.
    pub(super) fn keyword(&self) -> &str {
        self.split().0
    }

    /// Everything after the first word, as it stands: names may hold spaces and `#`.
    pub(super) fn rest(&self) -> &str {
        self.split().1
    }

    /// The words after the first one, up to a comment.
    pub(super) fn values(&self) -> impl Iterator<Item = &str> {
        self.rest()
            .split_whitespace()
            .take_while(|word| !word.starts_with('#'))
    }

    fn split(&self) -> (&str, &str) {
        match self.line.split_once(char::is_whitespace) {
            Some((keyword, rest)) => (keyword, rest.trim()),
            None => (&self.line, ""),
        }
    }
}
