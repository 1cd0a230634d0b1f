//! What one unit of a file is, and which way is up in it.

use crate::bad_input::BadInput;
use glam::DVec3;
use std::str::FromStr;

/// A unit of length in which files are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// Metre.
    #[default]
    Metre,
    /// Centimetre.
    Centimetre,
    /// Millimetre.
    Millimetre,
    /// Inch, 0.0254 m.
    Inch,
    /// Foot, 0.3048 m.
    Foot,
}

impl Unit {
    /// A position in this unit, in metres. The decimal units divide by a whole number, so the result is the f64 nearest
    /// to the true quotient; metres come back unchanged.
    pub fn to_metres(self, position: DVec3) -> DVec3 {
        match self {
            Self::Metre => position,
            Self::Centimetre => position / 100.0,
            Self::Millimetre => position / 1000.0,
            Self::Inch => position * 0.0254,
            Self::Foot => position * 0.3048,
        }
    }
}

impl FromStr for Unit {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "m" => Ok(Self::Metre),
            "cm" => Ok(Self::Centimetre),
            "mm" => Ok(Self::Millimetre),
            "in" => Ok(Self::Inch),
            "ft" => Ok(Self::Foot),
            _ => Err(BadInput::new(
                "unit",
                format!("\"{text}\" is no unit of length known here"),
                "use m, cm, mm, in or ft",
            )),
        }
    }
}

/// The axis of a file that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// y up, the convention of OBJ and glTF.
    #[default]
    Y,
    /// z up, as many CAD programs write.
    Z,
}

impl UpAxis {
    /// A vector of the file, turned so that y is up: z-up `(x, y, z)` becomes `(x, z, −y)`, a rotation about x.
    pub fn to_y_up(self, v: DVec3) -> DVec3 {
        match self {
            Self::Y => v,
            Self::Z => DVec3::new(v.x, v.z, -v.y),
        }
    }

    /// The way back: a vector with y up as the file would write it.
    pub fn from_y_up(self, v: DVec3) -> DVec3 {
        match self {
            Self::Y => v,
            Self::Z => DVec3::new(v.x, -v.z, v.y),
        }
    }
}

impl FromStr for UpAxis {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "y" | "Y" => Ok(Self::Y),
            "z" | "Z" => Ok(Self::Z),
            _ => Err(BadInput::new(
                "up axis",
                format!("\"{text}\" is no axis that can point up"),
                "use y or z",
            )),
        }
    }
}
