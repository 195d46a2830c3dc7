//! The plan: what a picture needs, and why - "model only what a scene needs".
//!
//! In: a draw or a scene, and the memories there are. Out: one value that says for every part of the pipeline whether it
//! runs or exists, its reason, how many items go through it and the bytes it takes. The pipeline does what its plan says
//! and nothing else; `--explain` and STATS print it.

use std::fmt;

/// A part of the pipeline, in the order in which data meets it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[expect(missing_docs, reason = "named by as_str")]
pub enum Part {
    VideoMemory,
    DepthMemory,
    PickBuffer,
    Textures,
    TransformVertices,
    FaceNormals,
    VertexNormals,
    SortFaces,
    CutFaces,
    CullFaces,
    LightFaces,
    LightVertices,
    Coverage,
    PerspectiveDivision,
    InterpolateNormals,
    InterpolatePositions,
    InterpolateColors,
    InterpolateTexcoords,
    LightPixels,
    SampleTextures,
    Fog,
    ReadBack,
    Lines,
    Points,
    TileRenderer,
    CoarseDepth,
    FacesInOrder,
}

impl Part {
    /// Every part, in order.
    pub const ALL: [Part; 27] = [
        Part::VideoMemory,
        Part::DepthMemory,
        Part::PickBuffer,
        Part::Textures,
        Part::TransformVertices,
        Part::FaceNormals,
        Part::VertexNormals,
        Part::SortFaces,
        Part::CutFaces,
        Part::CullFaces,
        Part::LightFaces,
        Part::LightVertices,
        Part::Coverage,
        Part::PerspectiveDivision,
        Part::InterpolateNormals,
        Part::InterpolatePositions,
        Part::InterpolateColors,
        Part::InterpolateTexcoords,
        Part::LightPixels,
        Part::SampleTextures,
        Part::Fog,
        Part::ReadBack,
        Part::Lines,
        Part::Points,
        Part::TileRenderer,
        Part::CoarseDepth,
        Part::FacesInOrder,
    ];

    /// The part's name in a printed plan, and what its count counts.
    pub const fn as_str(self) -> (&'static str, &'static str) {
        match self {
            Part::VideoMemory => ("video memory", "pixels"),
            Part::DepthMemory => ("depth memory", "pixels"),
            Part::PickBuffer => ("id memory", "pixels"),
            Part::Textures => ("textures", "textures"),
            Part::TransformVertices => ("transform vertices", "vertices"),
            Part::FaceNormals => ("face normals", "polygons"),
            Part::VertexNormals => ("vertex normals", "vertices"),
            Part::SortFaces => ("sort faces", "faces"),
            Part::CutFaces => ("cut at the eye", "faces"),
            Part::CullFaces => ("cull faces", "faces"),
            Part::LightFaces => ("light faces", "faces"),
            Part::LightVertices => ("light vertices", "corners"),
            Part::Coverage => ("coverage", "faces"),
            Part::PerspectiveDivision => ("divide by w", "vertices"),
            Part::InterpolateNormals => ("run normals", "faces"),
            Part::InterpolatePositions => ("run positions", "faces"),
            Part::InterpolateColors => ("run colours", "faces"),
            Part::InterpolateTexcoords => ("run u,v", "faces"),
            Part::LightPixels => ("light pixels", "lights"),
            Part::SampleTextures => ("sample textures", "faces"),
            Part::Fog => ("fog", "faces"),
            Part::ReadBack => ("read back", "faces"),
            Part::Lines => ("lines", "lines"),
            Part::Points => ("points", "points"),
            Part::TileRenderer => ("tile renderer", "faces"),
            Part::CoarseDepth => ("coarse depth", "faces"),
            Part::FacesInOrder => ("faces in order", "faces"),
        }
    }
}

/// What a plan says about one part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanItem {
    /// The part.
    pub part: Part,
    /// Whether it runs, or exists.
    pub used: bool,
    /// Why, or why not.
    pub reason: &'static str,
    /// How many items go through it (see [`Part::as_str`]); 0 when it is not used.
    pub count: u64,
    /// The bytes that it takes; 0 when it is not used.
    pub bytes: u64,
}

/// What a plan is for, in a few words: its `Display`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Title {
    /// These words.
    Words(&'static str),
    /// One draw.
    Draw {
        /// Its triangles.
        faces: u64,
        /// Its positions.
        vertices: u64,
    },
    /// A whole scene.
    Scene {
        /// Its objects.
        objects: usize,
    },
}

impl fmt::Display for Title {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Title::Words(words) => f.write_str(words),
            Title::Draw { faces, vertices } => write!(f, "draw of {faces} faces, {vertices} vertices"),
            Title::Scene { objects } => write!(f, "scene of {objects} objects"),
        }
    }
}

/// What a picture needs. Made for every draw, so nothing of it lies on the heap.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// What the plan is for.
    pub title: Title,
    items: [PlanItem; Part::ALL.len()],
    /// Bytes of working memory at worst.
    working: u64,
}

impl Plan {
    /// A plan of nothing but the frame itself, every other part absent for `reason`.
    pub fn of_frame(title: Title, width: u32, height: u32, reason: &'static str) -> Self {
        let absent = |part| PlanItem { part, used: false, reason, count: 0, bytes: 0 };
        let mut plan = Plan { title, items: Part::ALL.map(absent), working: 0 };
        let pixels = width as u64 * height as u64;
        plan.add(Part::VideoMemory, "the frame", pixels, pixels * 4);
        plan
    }

    /// The plan of a stream that only draws in two dimensions: no part of the 3-D pipeline.
    pub fn of_2d(width: u32, height: u32) -> Self {
        Plan::of_frame(Title::Words("2-D"), width, height, "nothing is drawn in 3-D")
    }

    /// The plan of a frame in which nothing moved: nothing is drawn again.
    pub fn of_unchanged_frame(width: u32, height: u32) -> Self {
        Plan::of_frame(
            Title::Words("unchanged frame"),
            width,
            height,
            "nothing moved, so nothing is drawn again",
        )
    }

    /// What the plan says about `part`.
    pub fn item(&self, part: Part) -> &PlanItem {
        &self.items[part as usize]
    }

    /// Whether `part` runs, or exists.
    pub fn uses(&self, part: Part) -> bool {
        self.item(part).used
    }

    /// All parts, in order.
    pub fn items(&self) -> &[PlanItem] {
        &self.items
    }

    /// The bytes of all memories and tables together.
    pub fn bytes(&self) -> u64 {
        self.items.iter().map(|i| i.bytes).sum()
    }

    /// The bytes of working memory that drawing takes at worst, whatever the faces are like: the frame's memories, textures and
    /// tables that live as long as the mesh aside. A renderer with a budget reserves them, or draws in smaller pieces.
    pub fn working_bytes(&self) -> u64 {
        self.working
    }

    /// Says what drawing takes at worst.
    pub(crate) fn set_working_bytes(&mut self, bytes: u64) {
        self.working = bytes;
    }

    /// Makes a part run, with `count` more items and `bytes` more.
    pub(crate) fn add(&mut self, part: Part, reason: &'static str, count: u64, bytes: u64) {
        let item = &mut self.items[part as usize];
        if !item.used {
            *item = PlanItem { part, used: true, reason, count: 0, bytes: 0 };
        }
        item.count += count;
        item.bytes += bytes;
    }

    /// Says what a part takes.
    pub(crate) fn set_bytes(&mut self, part: Part, bytes: u64) {
        self.items[part as usize].bytes = bytes;
    }

    /// Gives another reason for a part.
    pub(crate) fn explain(&mut self, part: Part, reason: &'static str) {
        self.items[part as usize].reason = reason;
    }

    /// Says why a part is absent.
    pub(crate) fn leave_out(&mut self, part: Part, reason: &'static str) {
        self.items[part as usize] = PlanItem { part, used: false, reason, count: 0, bytes: 0 };
    }

    /// Adds one object's plan to a scene's: what any object needs is there, the frame's memories once.
    pub(crate) fn merge(&mut self, object: &Plan) {
        for item in &object.items {
            let own = &mut self.items[item.part as usize];
            let is_first = !own.used;
            match item.part {
                Part::VideoMemory | Part::DepthMemory | Part::PickBuffer if own.used => {}
                _ if item.used => {
                    let (count, bytes) = if is_first { (0, 0) } else { (own.count, own.bytes) };
                    if is_first {
                        *own = *item;
                    }
                    own.count = count + item.count;
                    own.bytes = bytes + item.bytes;
                }
                _ if is_first => own.reason = item.reason,
                _ => {}
            }
        }
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "plan: {}, {} bytes", self.title, self.bytes())?;
        match self.working {
            0 => writeln!(f)?,
            most => writeln!(f, ", working memory at most {most}")?,
        }
        for item in &self.items {
            let (name, unit) = item.part.as_str();
            let mark = if item.used { '+' } else { '-' };
            write!(f, "  {mark} {name:<18} {}", item.reason)?;
            if item.used && item.count > 0 {
                write!(f, "; {} {unit}", item.count)?;
            }
            if item.bytes > 0 {
                write!(f, ", {} bytes", item.bytes)?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
