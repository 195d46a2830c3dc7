//! Drawing modes: closed enums with the command language's keywords.

macro_rules! keywords {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $word:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
        pub enum $name { $($(#[$vdoc])* $variant),+ }

        impl $name {
            /// All values, in the protocol's order.
            pub const ALL: &'static [$name] = &[$($name::$variant),+];

            /// Returns the keyword of the command language.
            pub const fn as_str(self) -> &'static str {
                match self { $($name::$variant => $word),+ }
            }

            /// Returns the value of a keyword in either case, or `None`.
            pub fn from_keyword(word: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|v| v.as_str().eq_ignore_ascii_case(word))
            }
        }
    };
}

keywords! {
    /// Shading of faces.
    ShadeMode {
        /// Wireframe: edges only, each polygon edge once.
        Wire = "wire",
        /// One colour per face, lit at its centroid with its geometric normal.
        Flat = "flat",
        /// Lit at the vertices, with interpolated colours.
        Gouraud = "gouraud",
        /// Lit per pixel, with interpolated normals.
        #[default]
        Phong = "phong",
    }
}

keywords! {
    /// Faces that are culled.
    Cull {
        /// Faces that are clockwise on the screen.
        #[default]
        Back = "back",
        /// Faces that are counter-clockwise on the screen.
        Front = "front",
        /// No faces.
        None = "none",
    }
}

keywords! {
    /// Hidden-surface removal.
    HiddenSurface {
        /// Depth buffer: a fragment passes if its depth is strictly less.
        #[default]
        ZBuffer = "zbuffer",
        /// Painter's algorithm: faces of one DRAW from far to near, by view z of their centroids.
        Painter = "painter",
        /// None: the last face drawn is seen; depth is neither tested nor written.
        None = "none",
    }
}

keywords! {
    /// Interpolation of attributes across a face.
    Interpolation {
        /// Perspective-correct: a = sum(w_i a_i / Z_i) / sum(w_i / Z_i).
        #[default]
        Perspective = "perspective",
        /// Linear in screen space, as on early hardware.
        Affine = "affine",
    }
}

keywords! {
    /// Texture filter.
    Filter {
        /// The texel that contains the sample point.
        Nearest = "nearest",
        /// Four texels of level 0, weighted by distance.
        #[default]
        Bilinear = "bilinear",
        /// Bilinear in level floor(D + 0.5), where D is the level of detail.
        Mipmap = "mipmap",
        /// Bilinear in levels floor(D) and the next, blended.
        Trilinear = "trilinear",
    }
}

keywords! {
    /// Addressing of texture coordinates outside 0..1.
    Wrap {
        /// Repeats the texture.
        #[default]
        Repeat = "repeat",
        /// Extends the edge texels.
        Clamp = "clamp",
    }
}

/// Filter and wrap modes of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Sampling {
    /// Texture filter.
    pub filter: Filter,
    /// Wrap mode along s (u).
    pub wrap_s: Wrap,
    /// Wrap mode along t (v).
    pub wrap_t: Wrap,
}
