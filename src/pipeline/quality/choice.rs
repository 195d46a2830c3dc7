//! The chosen quality settings, their grounds, and their text.

use super::{Budget, QualitySettings, settings};
use crate::scene::Scene;
use std::fmt;

/// A picture with cheaper settings, compared with the exact picture at every pixel drawn on.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Number of pixels drawn on.
    pub pixels: usize,
    /// Number of these whose difference is over the limit.
    pub over: usize,
    /// The 99.9th percentile of the difference, in 1/255 steps.
    pub error: u8,
    /// Number of objects that were drawn with cheaper settings.
    pub objects: usize,
    /// Number of these that stay within the limit.
    pub holds_for: usize,
}

/// The chosen settings, and the grounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// E, in 1/255 steps.
    pub max_error: f64,
    /// Settings of each object.
    pub settings: Vec<QualitySettings>,
    /// Largest proven bound of an object's error, in 1/255 steps, rounding included; 0 where all
    /// is exact.
    pub proven: f64,
    /// Comparison with the exact picture, if there was one.
    pub trial: Option<Trial>,
    /// Costs of the exact picture and of the choice, in units of the calibration table.
    pub costs: [f64; 2],
    /// Further remarks.
    pub notes: Vec<String>,
}

impl Choice {
    /// Creates the choice that changes nothing.
    pub fn exact(budget: &Budget, note: &str) -> Choice {
        Choice {
            max_error: budget.max_error,
            settings: vec![QualitySettings::default(); budget.scene.objects.len()],
            proven: 0.0,
            trial: None,
            costs: [0.0; 2],
            notes: vec![note.to_owned()],
        }
    }

    /// Returns whether everything is drawn exactly.
    pub fn is_exact(&self) -> bool {
        self.settings.iter().all(|s| *s == QualitySettings::default())
    }

    /// Applies the choice to a scene.
    pub fn apply(&self, scene: &mut Scene) {
        scene.objects.iter_mut().zip(&self.settings).for_each(|(object, own)| own.apply(object));
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "budget: at most {} steps of 255 for 999 of 1000 pixels drawn on", self.max_error)?;
        for (own, objects) in settings::grouped(&self.settings) {
            writeln!(f, "  chosen     {own} for {objects} objects")?;
        }
        if self.proven > 0.0 {
            writeln!(f, "  proven     at most {:.2} steps for any camera", self.proven)?;
        }
        if let Some(t) = &self.trial {
            writeln!(
                f,
                "  compared   {} of {} pixels over the limit, {} steps; holds for {} of {} objects",
                t.over, t.pixels, t.error, t.holds_for, t.objects
            )?;
        }
        let [exact, chosen] = self.costs;
        if exact > 0.0 {
            let part = 100.0 * chosen / exact;
            writeln!(f, "  cost       {chosen:.3e} of {exact:.3e} units by the calibration ({part:.0} %)")?;
        }
        self.notes.iter().try_for_each(|note| writeln!(f, "  note       {note}"))
    }
}
