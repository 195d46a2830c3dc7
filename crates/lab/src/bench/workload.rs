//! Names of the benchmark workloads.

use fbptr_core::scene::Filter;
use fbptr_formats::models;

/// Benchmark workload.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Workload {
    /// W1: a knot of 70,000 faces, lit per pixel.
    Phong70k,
    /// W2: a knot of 1,000,000 faces, lit per pixel.
    Phong1M,
    /// W3: 20 layers over the whole frame, each nearer than the one before.
    Fill20,
    /// W4: the knot of W1 with a texture of 1024x1024, unlit.
    Textured(Filter),
    /// W5: the knot of W1, lit per vertex.
    Gouraud70k,
    /// W6: 1,000,000 lines over the whole frame.
    LinesLong,
    /// W6: 5,000,000 lines of at most 12 pixels.
    LinesShort,
    /// W7: 100,000,000 pixels at random places, one call each.
    PutPixel,
    /// S1: a room seen from inside, with faces through the eye plane.
    Room,
    /// S2: up to 64 transparent layers.
    Layers64,
    /// S3: up to 10,000 boxes of 12 faces, one draw each, with different modes.
    Objects10k,
    /// S3: the boxes of `Objects10k` as one scene.
    Scene10k,
    /// S4: a knot of up to 4,000,000 faces.
    Mesh4M,
    /// S5: a knot on frames from VGA to 8K.
    Sizes,
    /// S6: a knot among 1 to 64 lights.
    Lights,
    /// S7: 32 walls of many faces, nearest first.
    Hidden,
    /// A built-in model of three dimensions, as `fbptr render` draws it.
    Model(&'static str),
}

impl Workload {
    /// All workloads but the built-in models, in the order of their names.
    pub const ALL: [Workload; 18] = [
        Workload::Phong70k,
        Workload::Phong1M,
        Workload::Fill20,
        Workload::Textured(Filter::Trilinear),
        Workload::Textured(Filter::Bilinear),
        Workload::Textured(Filter::Nearest),
        Workload::Gouraud70k,
        Workload::LinesLong,
        Workload::LinesShort,
        Workload::PutPixel,
        Workload::Room,
        Workload::Layers64,
        Workload::Objects10k,
        Workload::Scene10k,
        Workload::Mesh4M,
        Workload::Sizes,
        Workload::Lights,
        Workload::Hidden,
    ];

    /// Number of workloads that other programs draw, too: W1 to W7.
    pub const OF_PEERS: usize = 10;

    /// Returns the workload's name in the tables of all compared programs.
    pub const fn name(self) -> &'static str {
        match self {
            Workload::Phong70k => "W1_phong70k",
            Workload::Phong1M => "W2_phong1M",
            Workload::Fill20 => "W3_fill20",
            Workload::Textured(Filter::Trilinear) => "W4_tex_trilinear",
            Workload::Textured(Filter::Bilinear) => "W4_tex_bilinear",
            Workload::Textured(Filter::Nearest) => "W4_tex_nearest",
            Workload::Textured(Filter::Mipmap) => "W4_tex_mipmap",
            Workload::Gouraud70k => "W5_gouraud70k",
            Workload::LinesLong => "W6_lines_long",
            Workload::LinesShort => "W6_lines_short",
            Workload::PutPixel => "W7_putpixel_100M",
            Workload::Room => "S1_room",
            Workload::Layers64 => "S2_layers64",
            Workload::Objects10k => "S3_objects10k",
            Workload::Scene10k => "S3_scene10k",
            Workload::Mesh4M => "S4_mesh4M",
            Workload::Sizes => "S5_sizes",
            Workload::Lights => "S6_lights",
            Workload::Hidden => "S7_hidden",
            Workload::Model(name) => name,
        }
    }

    /// Returns whether threads share its frame in pieces that an executor's observer is told of: not that
    /// of W6 and W7, which one thread draws.
    pub fn is_shared(self) -> bool {
        !matches!(self, Workload::LinesLong | Workload::LinesShort | Workload::PutPixel)
    }

    /// Returns the workloads with a name, or with a name's beginning up to a `_` (`W4` is three),
    /// in either case. `scenes` is all from S1 on. A built-in model of three dimensions is a workload
    /// by its name. An unknown name returns an empty list.
    pub fn named(name: &str) -> Vec<Workload> {
        if name.eq_ignore_ascii_case("scenes") {
            return Self::ALL[Self::OF_PEERS..].to_vec();
        }
        if let Some(model) = models::named(name).filter(|model| !model.is_polytope()) {
            return vec![Workload::Model(model.name)];
        }
        let begins = |w: &Workload| {
            let own = w.name();
            own.eq_ignore_ascii_case(name)
                || own.get(..name.len()).is_some_and(|start| start.eq_ignore_ascii_case(name))
                    && own.as_bytes().get(name.len()) == Some(&b'_')
        };
        Self::ALL.into_iter().filter(begins).collect()
    }
}
