//! Quality settings of an object: deviations from drawing it exactly.

use super::levels::Level;
use crate::scene::{Object, ShadeMode};
use std::fmt;

/// Deviations from drawing an object exactly; `None` leaves a property as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QualitySettings {
    /// Shading mode.
    pub shade: Option<ShadeMode>,
    /// Indices of the lights that reach the object.
    pub lights: Option<Vec<u32>>,
    /// Error, in steps of 1/255, of light that is interpolated over pixels of large faces.
    pub light_error: Option<f64>,
    /// Level of detail of the mesh.
    pub level: Option<Level>,
}

impl QualitySettings {
    /// Applies the settings to an object.
    pub fn apply(&self, object: &mut Object) {
        object.shade = self.shade.or(object.shade);
        if let Some(lights) = &self.lights {
            object.lights = Some(lights.clone());
        }
        object.light_error = self.light_error.or(object.light_error);
        if let Some(level) = &self.level {
            object.geometry = level.geometry.clone();
        }
    }
}

impl fmt::Display for QualitySettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shade = self.shade.map(|s| format!("shade {}", s.as_str()));
        let lights = self.lights.as_ref().map(|l| match l.len() {
            1 => "1 light".to_owned(),
            n => format!("{n} lights"),
        });
        let light_error = self.light_error.map(|steps| format!("light within {steps} steps"));
        let level = self.level.as_ref().map(|l| format!("{} faces", l.geometry.mesh.triangles.len()));
        let parts: Vec<String> = [shade, lights, light_error, level].into_iter().flatten().collect();
        if parts.is_empty() { f.write_str("exact") } else { f.write_str(&parts.join(", ")) }
    }
}

/// Groups equal settings, in order of their first object, and counts the objects of each group.
pub(super) fn grouped(settings: &[QualitySettings]) -> Vec<(&QualitySettings, usize)> {
    let mut groups: Vec<(&QualitySettings, usize)> = Vec::new();
    for own in settings {
        match groups.iter_mut().find(|g| g.0 == own) {
            Some(group) => group.1 += 1,
            None => groups.push((own, 1)),
        }
    }
    groups
}
