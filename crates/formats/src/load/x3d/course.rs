//! Readings of X3D that a course's files need and the standard does not have. None is a default.
//!
//! The course is that of Luciano Soares and Fabio Orfali at Insper, whose renderer is called
//! Renderizador. Expected:
//!
//! - [`Dialect::Renderizador`]: a scene whose shapes all have a geometry of the Geometry2D component is
//!   drawn in pixels, (0, 0) at the upper left corner, x right, y down, without its Viewpoint, lights,
//!   fog and background, in emissive colours alone, seen from both sides, later shapes over earlier
//!   ones. Transforms move the shapes in pixels. A scene with any other geometry is left as it is.
//!   The corner of the first pixel is (0, 0). But ends of lines in whole numbers name pixels, as in
//!   the course's algorithm for lines: such a line goes from centre to centre, and has both ends.
//! - [`FieldOfView::Diagonal`]: the field of view lies on the picture's diagonal, and the window on the
//!   near plane is as high as the course's slides have it, with the whole angle in the tangent where
//!   the standard has its half:
//!
//! ```text
//! fovy  = 2 atan(tan(fieldOfView/2) h / sqrt(h^2 + w^2))
//! top   = near tan(fovy)
//! right = top w/h
//! ```

use super::X3dDocument;
use super::graph::{GraphView, Overrides};
use fbptr_core::scene::{Camera, Cull, LightingModel, LookAt, Material, Object, Projection, Scene};
use glam::{DVec3, DVec4};

/// Meaning of coordinates in scenes of two dimensions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dialect {
    /// The standard's.
    #[default]
    Standard,
    /// Pixels, y down.
    Renderizador,
}

/// Extent of the picture that the field of view of a Viewpoint is the angle of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FieldOfView {
    /// The smaller side, as the standard has it.
    #[default]
    SmallerSide,
    /// The diagonal, by the course's formula.
    Diagonal,
}

/// How a document is read where a course differs from the standard.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Meaning of coordinates.
    pub dialect: Dialect,
    /// Meaning of the field of view.
    pub field_of_view: FieldOfView,
}

/// Geometry of the Geometry2D component.
const FLAT: [&str; 8] = [
    "Arc2D",
    "ArcClose2D",
    "Circle2D",
    "Disk2D",
    "Polyline2D",
    "Polypoint2D",
    "Rectangle2D",
    "TriangleSet2D",
];

/// Returns whether every shape has a geometry of two dimensions, and there is one.
fn is_flat(view: &GraphView) -> bool {
    let ids = 0..view.graph.nodes.len() as u32;
    let mut geometry =
        { ids }.filter(|id| view.name(*id) == "Shape").filter_map(|id| view.child(id, "geometry"));
    let mut is_any = false;
    geometry.all(|id| {
        is_any = true;
        FLAT.contains(&view.name(id))
    }) && is_any
}

impl X3dDocument {
    /// Sets how the document is read by [`X3dDocument::at_size`].
    pub fn set_reading(&mut self, reading: Reading) {
        let still = Overrides::new();
        let is_flat = || is_flat(&GraphView { graph: &self.graph, overrides: &still });
        self.is_in_pixels = reading.dialect == Dialect::Renderizador && is_flat();
        self.field_of_view = reading.field_of_view;
    }

    /// Returns whether the scene is drawn in pixels, as the dialect of its [`Reading`] has it.
    pub fn is_in_pixels(&self) -> bool {
        self.is_in_pixels
    }

    /// [`X3dDocument::at`], for a picture of `size`, width and height in pixels, as the document's
    /// [`Reading`] has it.
    pub fn at_size(&self, time: f64, size: [u32; 2]) -> Scene {
        let mut scene = self.at(time);
        if self.is_in_pixels {
            return in_pixels(scene, size);
        }
        if let (FieldOfView::Diagonal, Some(camera)) = (self.field_of_view, &mut scene.camera) {
            on_diagonal(&mut camera.projection, size);
        }
        scene
    }
}

/// Changes the field of view of a perspective projection to the course's.
fn on_diagonal(projection: &mut Projection, size: [u32; 2]) {
    if let Projection::Perspective { fov_rad, on_smaller_side, .. } = projection {
        let [w, h] = size.map(f64::from);
        let fovy = 2.0 * libm::atan(libm::tan(*fov_rad / 2.0) * h / (h * h + w * w).sqrt());
        // The projection takes the tangent of the half of its angle.
        (*fov_rad, *on_smaller_side) = (2.0 * fovy, false);
    }
}

/// Returns a scene with the same objects in the plane of the pixels.
fn in_pixels(scene: Scene, size: [u32; 2]) -> Scene {
    let [w, h] = size.map(f64::from);
    let camera = Camera {
        look_at: LookAt { eye: DVec3::Z, reference: DVec3::ZERO, up: DVec3::Y },
        projection: Projection::Ortho { window: [0.0, w, h, 0.0], near: 0.0, far: 2.0 },
    };
    let count = scene.objects.len() as f64;
    let plain = |(k, object): (usize, Object)| {
        let mut model = object.model.transpose();
        // Towards the viewer in the order of the file; the shapes themselves are flat.
        model.z_axis = DVec4::new(0.0, 0.0, 1.0, (k as f64 + 1.0) / (count + 1.0));
        if is_line_in_whole_pixels(&object) {
            model.x_axis.w += 0.5;
            model.y_axis.w += 0.5;
        }
        Object {
            model: model.transpose(),
            material: Material { model: LightingModel::Unlit, ..object.material },
            back_material: None,
            cull: Cull::None,
            texture: None,
            lights: None,
            ..object
        }
    };
    let objects = scene.objects.into_iter().enumerate().map(plain).collect();
    Scene { camera: Some(camera), objects, ..Scene::default() }
}

/// Returns whether a shape is of lines whose ends are whole numbers of pixels.
fn is_line_in_whole_pixels(object: &Object) -> bool {
    let mesh = &object.geometry.mesh;
    let is_whole = |position: &DVec3| {
        let place = object.model.transform_point3(*position);
        place.x.fract() == 0.0 && place.y.fract() == 0.0
    };
    !mesh.lines.is_empty() && mesh.positions.iter().all(is_whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document(nodes: &str, reading: Reading) -> X3dDocument {
        let text = format!("<X3D><Scene>{nodes}</Scene></X3D>");
        let mut document = super::super::parse(text.as_bytes(), "t.x3d", &mut |_| None).unwrap();
        document.set_reading(reading);
        document
    }

    #[test]
    fn the_course_s_projection_has_the_numbers_of_its_formula() {
        let diagonal = Reading { field_of_view: FieldOfView::Diagonal, ..Reading::default() };
        let scene = document("<Viewpoint/>", diagonal).at_size(0.0, [640, 480]);
        let matrix = scene.camera.unwrap().matrices(640.0 / 480.0).unwrap().projection;
        // fovy = 2 atan(0.41421356 * 480/800) = 0.4871858; top = 0.01 tan(fovy) = 0.005297787
        let [near_by_right, near_by_top] = [1.4156854249492379, 1.887580566598984];
        assert!((matrix.x_axis.x - near_by_right).abs() < 1e-12, "{matrix}");
        assert!((matrix.y_axis.y - near_by_top).abs() < 1e-12, "{matrix}");
        let standard = document("<Viewpoint/>", Reading::default()).at_size(0.0, [640, 480]);
        assert_eq!(standard.camera, document("<Viewpoint/>", diagonal).at(0.0).camera);
    }

    #[test]
    fn only_scenes_of_two_dimensions_are_in_pixels() {
        let course = Reading { dialect: Dialect::Renderizador, ..Reading::default() };
        let line = "<Shape><Polyline2D lineSegments='0 0 9 9'/></Shape>";
        let both = format!("{line}<Shape><Box/></Shape>");
        for (nodes, is_in_pixels) in [(line, true), (&both, false), ("<Viewpoint/>", false)] {
            let document = document(nodes, course);
            let camera = document.at_size(0.0, [64, 48]).camera.unwrap();
            let window = Projection::Ortho { window: [0.0, 64.0, 48.0, 0.0], near: 0.0, far: 2.0 };
            assert_eq!(camera.projection == window, is_in_pixels, "{nodes}");
            assert_eq!(document.has_viewpoint(), is_in_pixels || nodes.contains("Viewpoint"), "{nodes}");
        }
    }
}
