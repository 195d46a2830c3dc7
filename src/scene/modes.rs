//! The modes of drawing, each a closed list with the command language's keywords.

macro_rules! keywords {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $word:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
        pub enum $name { $($(#[$vdoc])* $variant),+ }

        impl $name {
            /// Every value, in the protocol's order.
            pub const ALL: &'static [$name] = &[$($name::$variant),+];

            /// The keyword of the command language.
            pub const fn as_str(self) -> &'static str {
                match self { $($name::$variant => $word),+ }
            }

            /// The value of a keyword, in either case.
            pub fn from_keyword(word: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|v| v.as_str().eq_ignore_ascii_case(word))
            }
        }
    };
}

keywords! {
    /// How a face gets its colours.
    ShadeMode {
        /// Edges only, each polygon edge once.
        Wire = "wire",
        /// One colour a face, lit at its centroid with its geometric normal.
        Flat = "flat",
        /// Lit at the vertices, colours interpolated.
        Gouraud = "gouraud",
        /// Normals interpolated, lit per pixel.
        #[default]
        Phong = "phong",
    }
}

keywords! {
    /// Which faces are left out.
    Cull {
        /// Clockwise ones on the screen.
        #[default]
        Back = "back",
        /// Counter-clockwise ones on the screen.
        Front = "front",
        /// None.
        None = "none",
    }
}

keywords! {
    /// How hidden surfaces are found.
    HiddenSurface {
        /// By a depth a pixel, strictly less passes.
        #[default]
        ZBuffer = "zbuffer",
        /// By drawing the faces of one DRAW far to near, by view z of their centroids.
        Painter = "painter",
        /// Not at all: what is drawn last is seen; depth is neither tested nor written.
        None = "none",
    }
}

keywords! {
    /// How values run across a face.
    Interpolation {
        /// a = sum(w_i a_i / Z_i) / sum(w_i / Z_i).
        #[default]
        Perspective = "perspective",
        /// Straight on the screen, as the old machines did it.
        Affine = "affine",
    }
}

keywords! {
    /// How a texture is sampled.
    Filter {
        /// The texel that holds the point.
        Nearest = "nearest",
        /// Four texels of level 0, weighed by distance.
        #[default]
        Bilinear = "bilinear",
        /// Bilinear in level floor(D + 0.5).
        Mipmap = "mipmap",
        /// Bilinear in levels floor(D) and the next, blended.
        Trilinear = "trilinear",
    }
}

keywords! {
    /// What happens outside 0..1 of texture space.
    Wrap {
        /// The texture goes on.
        #[default]
        Repeat = "repeat",
        /// The edge texel goes on.
        Clamp = "clamp",
    }
}

/// A texture's filter and wrap rules, along s and t.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Sampling {
    /// The filter.
    pub filter: Filter,
    /// Wrapping along s (u).
    pub wrap_s: Wrap,
    /// Wrapping along t (v).
    pub wrap_t: Wrap,
}
