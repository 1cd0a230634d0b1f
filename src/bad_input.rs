//! The one kind of error a user can cause: a place, what is wrong there, and what to do about it.

/// Input or use that the program cannot work with: shown as one line, exit code 2.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {what}; {remedy}")]
pub struct BadInput {
    /// File, `file:line`, material, or option.
    pub place: String,
    /// What is wrong, with the value found and the limit.
    pub what: String,
    /// What the user can do.
    pub remedy: String,
}

impl BadInput {
    /// An error at `place`.
    pub fn new(
        place: impl Into<String>,
        what: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            place: place.into(),
            what: what.into(),
            remedy: remedy.into(),
        }
    }
}
