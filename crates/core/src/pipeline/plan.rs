//! The plan of a picture: the parts of the pipeline that it needs, and why.
//!
//! In: a draw or a scene, and its target. Out: one value that says for every part of the pipeline
//! whether it runs or exists, the reason, how many items go through it and the bytes it takes. The
//! pipeline does exactly what its plan says; `--explain` and STATS print it.

mod parts;

pub(crate) use parts::{Parts, PlanRecord};
use std::fmt;

/// A part of the pipeline, in the order of data flow.
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
    SurfaceMaps,
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
    pub const ALL: [Part; 28] = [
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
        Part::SurfaceMaps,
        Part::Fog,
        Part::ReadBack,
        Part::Lines,
        Part::Points,
        Part::TileRenderer,
        Part::CoarseDepth,
        Part::FacesInOrder,
    ];

    /// Returns the part's name in a printed plan, and the unit of its count.
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
            Part::SurfaceMaps => ("surface maps", "faces"),
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

/// A plan's entry for one part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanItem {
    /// The part.
    pub part: Part,
    /// True if the part runs, or exists.
    pub used: bool,
    /// Reason for using or leaving out the part.
    pub reason: &'static str,
    /// Number of items that go through it (units: [`Part::as_str`]); 0 when it is not used.
    pub count: u64,
    /// Bytes that it takes; 0 when it is not used.
    pub bytes: u64,
}

/// Subject of a plan; its `Display` is a short phrase.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Title {
    /// Fixed text.
    Words(&'static str),
    /// One draw.
    Draw {
        /// Number of triangles.
        faces: u64,
        /// Number of positions.
        vertices: u64,
    },
    /// A scene.
    Scene {
        /// Number of objects.
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

/// The parts that a picture needs. It holds no heap memory, since one is made for every draw.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Subject of the plan.
    pub title: Title,
    items: [PlanItem; Part::ALL.len()],
    /// Worst-case bytes of working memory.
    working: u64,
}

impl Plan {
    /// Creates a plan of the frame alone, with `reason` for leaving out every other part.
    pub fn of_frame(title: Title, width: u32, height: u32, reason: &'static str) -> Self {
        let absent = |part| PlanItem { part, used: false, reason, count: 0, bytes: 0 };
        let mut plan = Plan { title, items: Part::ALL.map(absent), working: 0 };
        let pixels = width as u64 * height as u64;
        plan.add(Part::VideoMemory, "the frame", pixels, pixels * 4);
        plan
    }

    /// Creates the plan of a stream that draws in two dimensions only: no part of the 3-D pipeline.
    pub fn of_2d(width: u32, height: u32) -> Self {
        Plan::of_frame(Title::Words("2-D"), width, height, "nothing is drawn in 3-D")
    }

    /// Creates the plan of a frame in which nothing moved, so that nothing is drawn again.
    pub fn of_unchanged_frame(width: u32, height: u32) -> Self {
        Plan::of_frame(
            Title::Words("unchanged frame"),
            width,
            height,
            "nothing moved, so nothing is drawn again",
        )
    }

    /// Returns the entry for `part`.
    pub fn item(&self, part: Part) -> &PlanItem {
        &self.items[part as usize]
    }

    /// Returns whether `part` runs, or exists.
    pub fn uses(&self, part: Part) -> bool {
        self.item(part).used
    }

    /// Returns all entries, in order.
    pub fn items(&self) -> &[PlanItem] {
        &self.items
    }

    /// Returns the bytes of all memories and tables together.
    pub fn bytes(&self) -> u64 {
        self.items.iter().map(|i| i.bytes).sum()
    }

    /// Returns the worst-case bytes of working memory for drawing, whatever the faces are like.
    /// Excluded are the frame's memories, textures, and tables that live as long as the mesh. A
    /// renderer with a budget reserves these bytes, or draws in smaller pieces.
    pub fn working_bytes(&self) -> u64 {
        self.working
    }

    /// Sets the worst-case bytes of working memory.
    pub(crate) fn set_working_bytes(&mut self, bytes: u64) {
        self.working = bytes;
    }

    /// Marks a part as used, and adds `count` items and `bytes` bytes to it. The first reason
    /// stays.
    pub(crate) fn add(&mut self, part: Part, reason: &'static str, count: u64, bytes: u64) {
        let item = &mut self.items[part as usize];
        if !item.used {
            *item = PlanItem { part, used: true, reason, count: 0, bytes: 0 };
        }
        item.count += count;
        item.bytes += bytes;
    }

    /// Sets the bytes of a part.
    pub(crate) fn set_bytes(&mut self, part: Part, bytes: u64) {
        self.items[part as usize].bytes = bytes;
    }

    /// Replaces the reason of a part.
    pub(crate) fn explain(&mut self, part: Part, reason: &'static str) {
        self.items[part as usize].reason = reason;
    }

    /// Marks a part as unused for `reason`.
    pub(crate) fn leave_out(&mut self, part: Part, reason: &'static str) {
        self.items[part as usize] = PlanItem { part, used: false, reason, count: 0, bytes: 0 };
    }

    /// Merges one object's plan into a scene's: items and bytes add up, but the frame's memories
    /// count once.
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
