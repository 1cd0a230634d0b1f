//! umbrage bakes light into meshes: a scene of polygons in, the same surfaces out with the light at their vertices.
//!
//! The shadows of area lights end along lines that can be computed. The mesh follows these lines, so that few elements
//! show sharp contact shadows and soft penumbrae alike; light that has been reflected is solved for on a coarser mesh and
//! added. One number decides everything: the error of the irradiance that the user accepts.
//!
//! # The stages
//!
//! | module | makes of | what | after |
//! |---|---|---|---|
//! | [`io`] | a file | a [`RawScene`](scene::RawScene), metres, y up | |
//! | [`texture`] | a picture file | its texels, their mean over a triangle | Williams 1983 |
//! | [`scene`] | that | welded, planar, maximal faces with their neighbours | |
//! | [`visibility`] | faces | who hides whom: the part of a polygon that a point sees, exactly | Woop, Benthin & Wald 2013 for rays |
//! | [`direct`] | a point | the irradiance straight from the emitters, exact where exactness shows | Lambert 1760 |
//! | [`form_factor`] | two polygons | the share of light that one sends the other, with its error | Sparrow 1963; Baum, Rushmeier & Winget 1989 |
//! | [`discontinuity`] | emitters and edges | the lines where that irradiance or its derivatives break | Heckbert 1992; Lischinski, Tampieri & Greenberg 1992; Drettakis & Fiume 1994 |
//! | [`mesh`] | lines on a face | triangles that cross no line | Hobby 1999; Halperin & Packer 2002 |
//! | [`radiosity`] | a coarse mesh | the light by way of other faces | Lischinski, Tampieri & Greenberg 1993; Atkinson & Chien 1998 |
//! | [`adapt`] | an error | the display mesh: which lines and elements it takes, and values that fit the light | Dörfler 1996; Dyn, Levin & Rippa 1990; Kavan, Bargteil & Sloan 2011 |
//! | [`pipeline`] | all of these | a [`Solution`](pipeline::Solution), measured against the exact light | |
//! | [`io`], [`render`], [`viewer`] | a solution | a lit glTF, a picture of it, a page to look around in | |
//!
//! Each module's own page tells where it departs from the papers and why.
//!
//! # Conventions
//!
//! Metres, radians, linear RGB, right-handed, y up. A face's front is where its corners turn counter-clockwise.
//! Irradiance, exitance and radiosity are W/m², radiance W/(m² sr), each with its own type ([`quantity`]). The library
//! prints nothing, and the same input gives the same result to the last bit on any number of threads.
//!
//! # Example
//!
//! A lamp of 1 m² that hangs 1 m above a floor:
//!
//! ```
//! use glam::DVec3;
//! use umbrage::quantity::{Radiance, Rgb};
//! use umbrage::scene::{Material, RawPolygon, RawScene};
//! use umbrage::settings::Settings;
//!
//! let matte = |name: &str, reflectance, radiance| Material {
//!     name: name.to_owned(),
//!     reflectance: Rgb::grey(reflectance),
//!     emission: Radiance(Rgb::grey(radiance)),
//!     ..Material::default()
//! };
//! let corners = |half: f64, y: f64| {
//!     [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
//!         .map(|(x, z)| DVec3::new(half * x, y, half * z))
//! };
//! let raw = RawScene {
//!     source: "lamp over floor".to_owned(),
//!     positions: [corners(2.0, 0.0), corners(0.5, 1.0)].concat(),
//!     polygons: vec![
//!         // Counter-clockwise seen from above, and from below.
//!         RawPolygon { corners: vec![0, 1, 2, 3], material: 0, group: 0 },
//!         RawPolygon { corners: vec![7, 6, 5, 4], material: 1, group: 1 },
//!     ],
//!     materials: vec![matte("floor", 0.5, 0.0), matte("lamp", 0.0, 10.0)],
//!     groups: vec!["floor".to_owned(), "lamp".to_owned()],
//!     ..RawScene::default()
//! };
//!
//! let settings = Settings { error: 0.02, ..Settings::default() };
//! let baked = umbrage::bake(&raw, &settings)?;
//! assert!(baked.summary.measured.relative_rms < 0.02);
//!
//! let glb = umbrage::io::write_glb(&baked.scene);
//! assert!(glb.starts_with(b"glTF"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod adapt;
pub mod bad_input;
mod bake;
pub mod budget;
pub mod compare;
pub mod direct;
pub mod discontinuity;
pub mod form_factor;
pub mod geom;
pub mod io;
pub mod lit_scene;
pub mod mesh;
pub mod pipeline;
pub mod quantity;
pub mod radiosity;
pub mod render;
pub mod report;
pub mod scene;
pub mod settings;
pub mod texture;
pub mod viewer;
pub mod visibility;
pub mod warning;

pub use bake::{Baked, bake};
