//! What the readers of scenes and of lit files share: a glTF document whose parts can be trusted, its bytes, typed arrays
//! out of them, its textures.

pub(super) mod accessor;
pub(super) mod buffers;
pub(super) mod document;
pub(super) mod place;
pub(super) mod texture;
