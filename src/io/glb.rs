//! A binary glTF under construction: the JSON tree and the one buffer behind it, in the order in which things are added.

use crate::texture::{ImageFormat, Texture, Wrap};
use gltf_json as gj;
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::validation::Checked::Valid;
use gltf_json::validation::USize64;
use std::borrow::Cow;

/// The largest number of vertices that 16-bit indices can name: 65535 itself is reserved by glTF.
const MAX_SHORT_VERTICES: usize = 65535;

/// What the JSON tree takes for "no source".
const NO_SOURCE: u32 = u32::MAX;

/// How a material is drawn. None is shaded by the viewer: the light is in the vertices.
pub(super) struct Unlit {
    pub(super) name: String,
    /// Texture of the base colour.
    pub(super) texture: Option<gj::Index<gj::Texture>>,
    /// Texels and colours whose opacity is below this are not there.
    pub(super) cut_off: Option<f32>,
    /// Linear base colour and opacity, 0…1.
    pub(super) base_colour: [f32; 4],
}

/// The file so far.
pub(super) struct GlbBuilder {
    root: gj::Root,
    buffer: Vec<u8>,
}

impl GlbBuilder {
    pub(super) fn new() -> Self {
        let generator = format!("umbrage {}", env!("CARGO_PKG_VERSION"));
        Self {
            root: gj::Root {
                asset: gj::Asset {
                    generator: Some(generator),
                    ..Default::default()
                },
                ..Default::default()
            },
            buffer: Vec::new(),
        }
    }

    pub(super) fn node(&mut self, node: gj::Node) -> gj::Index<gj::Node> {
        self.root.push(node)
    }

    pub(super) fn camera(&mut self, camera: gj::Camera) -> gj::Index<gj::Camera> {
        self.root.push(camera)
    }

    /// A mesh and the node that shows it, both called `name`.
    pub(super) fn mesh_node(
        &mut self,
        name: &str,
        primitives: Vec<gj::mesh::Primitive>,
    ) -> gj::Index<gj::Node> {
        let mesh = self.root.push(gj::Mesh {
            extensions: None,
            extras: None,
            name: Some(name.to_owned()),
            primitives,
            weights: None,
        });
        self.node(gj::Node {
            mesh: Some(mesh),
            name: Some(name.to_owned()),
            ..Default::default()
        })
    }

    /// An opaque or blended material that is seen from its front only.
    pub(super) fn material(&mut self, unlit: Unlit) -> gj::Index<gj::Material> {
        const EXTENSION: &str = "KHR_materials_unlit";
        self.use_extension(EXTENSION);
        let alpha_mode = match unlit.cut_off {
            Some(_) => gj::material::AlphaMode::Mask,
            None if unlit.base_colour[3] < 1.0 => gj::material::AlphaMode::Blend,
            None => gj::material::AlphaMode::Opaque,
        };
        // Viewers without the extension fall back to a rough dielectric, the nearest they have.
        self.root.push(gj::Material {
            name: Some(unlit.name),
            alpha_mode: Valid(alpha_mode),
            alpha_cutoff: unlit.cut_off.map(gj::material::AlphaCutoff),
            pbr_metallic_roughness: gj::material::PbrMetallicRoughness {
                base_color_factor: gj::material::PbrBaseColorFactor(unlit.base_colour),
                base_color_texture: unlit.texture.map(|index| gj::texture::Info {
                    index,
                    tex_coord: 0,
                    extensions: None,
                    extras: None,
                }),
                metallic_factor: gj::material::StrengthFactor(0.0),
                ..Default::default()
            },
            extensions: Some(gj::extensions::material::Material {
                unlit: Some(gj::extensions::material::Unlit {}),
                ..Default::default()
            }),
            ..Default::default()
        })
    }

    fn use_extension(&mut self, name: &str) {
        let used = &mut self.root.extensions_used;
        if !used.iter().any(|known| known == name) {
            used.push(name.to_owned());
        }
    }

    /// A texture with its picture as it came.
    pub(super) fn texture(&mut self, texture: &Texture) -> gj::Index<gj::Texture> {
        const WEBP: &str = "EXT_texture_webp";
        let start = self.buffer.len();
        self.buffer.extend_from_slice(&texture.encoded);
        let view = self.view(start, None);
        let media_type = texture.format.media_type();
        let source = self.root.push(gj::Image {
            buffer_view: Some(view),
            mime_type: Some(gj::image::MimeType(media_type.to_owned())),
            name: Some(texture.name.clone()),
            uri: None,
            extensions: None,
            extras: None,
        });
        let sampler = self.root.push(sampler(texture));
        let mut file = gj::Texture {
            name: Some(texture.name.clone()),
            sampler: Some(sampler),
            source,
            extensions: None,
            extras: None,
        };
        if texture.format == ImageFormat::WebP {
            self.use_extension(WEBP);
            let required = &mut self.root.extensions_required;
            if required.is_empty() {
                required.push(WEBP.to_owned());
            }
            file.source = gj::Index::new(NO_SOURCE);
            let value = serde_json::json!({ "source": source.value() });
            file.extensions = Some(gj::extensions::texture::Texture {
                others: serde_json::Map::from_iter([(WEBP.to_owned(), value)]),
            });
        }
        self.root.push(file)
    }

    /// Positions, with the bounds that glTF wants for them.
    pub(super) fn positions(&mut self, values: &[[f32; 3]]) -> gj::Index<gj::Accessor> {
        let bound = |pick: fn(f32, f32) -> f32| {
            let start = values.first().copied().unwrap_or_default();
            let bound = values.iter().fold(start, |bound, v| {
                std::array::from_fn(|axis| pick(bound[axis], v[axis]))
            });
            Some(gj::Value::from(bound.to_vec()))
        };
        let (min, max) = (bound(f32::min), bound(f32::max));
        self.vectors_with(values, min, max)
    }

    /// One float VEC2 for each vertex.
    pub(super) fn pairs(&mut self, values: &[[f32; 2]]) -> gj::Index<gj::Accessor> {
        let start = self.buffer.len();
        for value in values.as_flattened() {
            self.buffer.extend_from_slice(&value.to_le_bytes());
        }
        let view = self.view(start, Some(gj::buffer::Target::ArrayBuffer));
        let (count, component) = (values.len(), ComponentType::F32);
        self.accessor(view, count, component, Type::Vec2, None, None)
    }

    /// One float VEC3 for each vertex.
    pub(super) fn vectors(&mut self, values: &[[f32; 3]]) -> gj::Index<gj::Accessor> {
        self.vectors_with(values, None, None)
    }

    fn vectors_with(
        &mut self,
        values: &[[f32; 3]],
        min: Option<gj::Value>,
        max: Option<gj::Value>,
    ) -> gj::Index<gj::Accessor> {
        let start = self.buffer.len();
        for value in values.as_flattened() {
            self.buffer.extend_from_slice(&value.to_le_bytes());
        }
        let view = self.view(start, Some(gj::buffer::Target::ArrayBuffer));
        self.accessor(view, values.len(), ComponentType::F32, Type::Vec3, min, max)
    }

    /// One number for each vertex.
    pub(super) fn scalars(&mut self, values: &[f32]) -> gj::Index<gj::Accessor> {
        let start = self.buffer.len();
        for value in values {
            self.buffer.extend_from_slice(&value.to_le_bytes());
        }
        let view = self.view(start, Some(gj::buffer::Target::ArrayBuffer));
        self.accessor(
            view,
            values.len(),
            ComponentType::F32,
            Type::Scalar,
            None,
            None,
        )
    }

    /// Indices in the narrowest type that every viewer reads: 16 bits where they suffice.
    pub(super) fn indices(&mut self, values: &[u32], vertices: usize) -> gj::Index<gj::Accessor> {
        let start = self.buffer.len();
        let component = if vertices <= MAX_SHORT_VERTICES {
            for &value in values {
                let short = u16::try_from(value).expect("indices name vertices of the mesh");
                self.buffer.extend_from_slice(&short.to_le_bytes());
            }
            ComponentType::U16
        } else {
            for value in values {
                self.buffer.extend_from_slice(&value.to_le_bytes());
            }
            ComponentType::U32
        };
        let view = self.view(start, Some(gj::buffer::Target::ElementArrayBuffer));
        self.accessor(view, values.len(), component, Type::Scalar, None, None)
    }

    /// The bytes since `start` as a view; pads so that the next one starts at a multiple of four.
    fn view(
        &mut self,
        start: usize,
        target: Option<gj::buffer::Target>,
    ) -> gj::Index<gj::buffer::View> {
        let end = self.buffer.len();
        self.buffer.resize(end.next_multiple_of(4), 0);
        self.root.push(gj::buffer::View {
            buffer: gj::Index::new(0),
            byte_length: USize64::from(end - start),
            byte_offset: Some(USize64::from(start)),
            byte_stride: None,
            name: None,
            target: target.map(Valid),
            extensions: None,
            extras: None,
        })
    }

    fn accessor(
        &mut self,
        view: gj::Index<gj::buffer::View>,
        count: usize,
        component: ComponentType,
        type_: Type,
        min: Option<gj::Value>,
        max: Option<gj::Value>,
    ) -> gj::Index<gj::Accessor> {
        self.root.push(gj::Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(count),
            component_type: Valid(GenericComponentType(component)),
            extensions: None,
            extras: None,
            type_: Valid(type_),
            min,
            max,
            name: None,
            normalized: false,
            sparse: None,
        })
    }

    /// The finished file, with one scene below `root`.
    ///
    /// # Panics
    /// When the file would pass 4 GiB, more than the format can say: some 80 million vertices.
    pub(super) fn finish(
        mut self,
        root: gj::Index<gj::Node>,
        extras: Option<&serde_json::Value>,
    ) -> Vec<u8> {
        let extras = extras.map(|value| {
            serde_json::value::to_raw_value(value).expect("a JSON value has a JSON text")
        });
        let scene = self.root.push(gj::Scene {
            extensions: None,
            extras,
            name: None,
            nodes: vec![root],
        });
        self.root.scene = Some(scene);
        // glTF has no empty buffers: a file without meshes has none.
        if !self.buffer.is_empty() {
            self.root.push(gj::Buffer {
                byte_length: USize64::from(self.buffer.len()),
                name: None,
                uri: None,
                extensions: None,
                extras: None,
            });
        }
        let json = gj::serialize::to_vec(&self.root).expect("the tree holds finite numbers only");
        let total = json.len() as u64 + self.buffer.len() as u64 + 64;
        u32::try_from(total).expect("a binary glTF is smaller than 4 GiB");
        gltf::binary::Glb {
            header: gltf::binary::Header {
                magic: *b"glTF",
                version: 2,
                length: 0, // filled in by `to_vec`
            },
            json: Cow::Owned(json),
            bin: (!self.buffer.is_empty()).then_some(Cow::Owned(self.buffer)),
        }
        .to_vec()
        .expect("writing to memory cannot fail")
    }
}

/// How a texture is looked up, as its file said.
fn sampler(texture: &Texture) -> gj::texture::Sampler {
    use gj::texture::{MagFilter, MinFilter, WrappingMode};
    let wrap = |wrap| {
        Valid(match wrap {
            Wrap::Repeat => WrappingMode::Repeat,
            Wrap::Mirror => WrappingMode::MirroredRepeat,
            Wrap::Clamp => WrappingMode::ClampToEdge,
        })
    };
    let magnified = [MagFilter::Nearest, MagFilter::Linear];
    let minified = [
        MinFilter::Nearest,
        MinFilter::Linear,
        MinFilter::NearestMipmapNearest,
        MinFilter::LinearMipmapNearest,
        MinFilter::NearestMipmapLinear,
        MinFilter::LinearMipmapLinear,
    ];
    let [magnify, minify] = texture.filters;
    gj::texture::Sampler {
        mag_filter: magnified
            .into_iter()
            .find(|filter| Some(filter.as_gl_enum()) == magnify)
            .map(Valid),
        min_filter: minified
            .into_iter()
            .find(|filter| Some(filter.as_gl_enum()) == minify)
            .map(Valid),
        wrap_s: wrap(texture.wrap[0]),
        wrap_t: wrap(texture.wrap[1]),
        ..Default::default()
    }
}
