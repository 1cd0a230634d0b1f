//! What a cell knows of its light.

use crate::bad_input::BadInput;

/// The functions by which cells tell their light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Basis {
    /// Linear between its corners; the indirect light is quadratic between nodes.
    #[default]
    Linear,
    /// The same all over it: classic radiosity.
    Constant,
    /// The same functions as the linear one, told by those on the largest cells and wavelets: what none of the nodes can tell
    /// apart is left out of their links.
    Wavelet,
}

impl Basis {
    /// All of them, the default first.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Constant, Self::Wavelet];

    /// Its name for users.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Constant => "constant",
            Self::Wavelet => "wavelet",
        }
    }
}

impl std::str::FromStr for Basis {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let found = Self::ALL.into_iter().find(|b| b.name() == text);
        found.ok_or_else(|| {
            let what = format!("\"{text}\" is no basis");
            BadInput::new("--basis", what, "give linear, constant or wavelet")
        })
    }
}
