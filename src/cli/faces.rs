//! Faces that are named on the command line.

use clap::ValueEnum;
use umbrage::bad_input::BadInput;
use umbrage::scene::{FaceId, FaceSide, Scene};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Side {
    /// From which its corners turn counter-clockwise
    Front,
    /// The other one
    Back,
}

impl From<Side> for FaceSide {
    fn from(side: Side) -> Self {
        match side {
            Side::Front => Self::Front,
            Side::Back => Self::Back,
        }
    }
}

/// The face of that object, or of that number; names go before numbers.
pub(super) fn find_face(scene: &Scene, name: &str) -> Result<FaceId, BadInput> {
    let named: Vec<FaceId> = scene
        .faces
        .iter()
        .filter(|(_, f)| scene.groups[f.group as usize] == name)
        .map(|(id, _)| id)
        .collect();
    let bad = |what: String, remedy: &str| Err(BadInput::new("--face", what, remedy));
    match named[..] {
        [face] => Ok(face),
        [] => match name.parse::<usize>() {
            Ok(index) if index < scene.faces.len() => Ok(FaceId::from(index)),
            _ => bad(
                format!(
                    "\"{name}\" is neither the name of an object with one face nor a number below {}",
                    scene.faces.len()
                ),
                "umbrage inspect SCENE -v lists the faces",
            ),
        },
        _ => {
            let numbers: Vec<String> = named.iter().map(ToString::to_string).collect();
            bad(
                format!("\"{name}\" has {} faces", named.len()),
                &format!("give one of their numbers: {}", numbers.join(", ")),
            )
        }
    }
}
