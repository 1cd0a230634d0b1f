//! How much a face matters to the whole.

/// A face with less than this share of the lit area is minor.
pub(crate) const MINOR_SHARE: f64 = 1e-4;

/// And tiny with less than this one.
const TINY_SHARE: f64 = 1e-6;

/// Minor faces may be lit with so many times the error.
const MINOR_ACCURACY: f64 = 8.0;

/// Real scenes have tens of thousands of faces that are nothing to the whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Size {
    /// A bolt: what one of its points sees of the emitters, all of it sees.
    Tiny,
    /// A chair leg: the mistakes of rays fall differently on each of many, and what such a face hides from its corners and
    /// its middle is nothing to the whole.
    Minor,
    /// A wall.
    #[default]
    Major,
}

impl Size {
    /// Of a face with the area `area`, where all that is lit is `lit` (both m²).
    pub fn new(area: f64, lit: f64) -> Self {
        match area / lit {
            share if share <= TINY_SHARE => Self::Tiny,
            share if share <= MINOR_SHARE => Self::Minor,
            _ => Self::Major,
        }
    }

    /// How many times the error it may be lit with where sides or emitters are many.
    pub fn accuracy(self) -> f64 {
        match self {
            Self::Tiny | Self::Minor => MINOR_ACCURACY,
            Self::Major => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Size;

    #[test]
    fn a_face_is_as_large_as_its_share() {
        let sizes = [1e-7, 1e-5, 1e-3, 1.0].map(|share| Size::new(100.0 * share, 100.0));
        assert_eq!(sizes, [Size::Tiny, Size::Minor, Size::Major, Size::Major]);
        assert!(sizes[0].accuracy() > sizes[3].accuracy());
        // Where nothing is lit nothing is small.
        assert_eq!(Size::new(0.0, 0.0), Size::Major);
    }
}
