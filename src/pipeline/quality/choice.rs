//! Result of a search for quality settings: the choice, its trials, and its text.

use super::{Budget, QualitySettings, settings};
use crate::pipeline::draw_call::SceneOptions;
use crate::scene::{Interpolation, Scene};
use std::fmt;

/// One combination of levels that was tried on all objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Description of the settings.
    pub name: String,
    /// The 99.9th percentile of the error over the sample, in 1/255 steps.
    pub error: u8,
    /// Fraction of the sample's pixels over E.
    pub over: f64,
    /// Cost in units of the cost table.
    pub cost: f64,
    /// Number of objects for which the error stays within the limit.
    pub holds_for: usize,
}

/// The chosen settings, and the reasons.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// E, in 1/255 steps.
    pub max_error: f64,
    /// Settings of each object.
    pub recipes: Vec<QualitySettings>,
    /// Interpolation across faces.
    pub interp: Interpolation,
    /// Trials, in order.
    pub trials: Vec<Trial>,
    /// Number of pixels drawn on.
    pub pixels: usize,
    /// Number of pixels of the last certification sample; 0 if nothing cheaper than exact was
    /// certified.
    pub sampled: usize,
    /// Number of these over E.
    pub over: usize,
    /// Confidence that at most 1 in 1000 pixels is over E.
    pub confidence: f64,
    /// The reference that errors are measured against.
    pub reference: &'static str,
    /// Costs of the exact picture and of the choice, in units of the cost table.
    pub costs: [f64; 2],
    /// Further remarks.
    pub notes: Vec<String>,
}

impl Choice {
    /// Creates the choice that changes nothing.
    pub(super) fn exact(budget: &Budget, note: String) -> Choice {
        Choice {
            max_error: budget.max_error,
            recipes: budget.scene.objects.iter().map(|_| QualitySettings::default()).collect(),
            interp: budget.options.interp,
            trials: Vec::new(),
            pixels: 0,
            sampled: 0,
            over: 0,
            confidence: 1.0,
            reference: "nothing: exact",
            costs: [0.0; 2],
            notes: vec![note],
        }
    }

    /// Returns whether everything is drawn exactly.
    pub fn is_exact(&self, options: &SceneOptions) -> bool {
        self.interp == options.interp && self.recipes.iter().all(|r| *r == QualitySettings::default())
    }

    /// Applies the choice to a scene and its options.
    pub fn apply(&self, scene: &mut Scene, options: &mut SceneOptions) {
        options.interp = self.interp;
        for (object, recipe) in scene.objects.iter_mut().zip(&self.recipes) {
            recipe.apply(object);
        }
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "budget: at most {} steps of 255 for 999 of 1000 pixels drawn on", self.max_error)?;
        writeln!(f, "  truth      {}", self.reference)?;
        for t in &self.trials {
            writeln!(
                f,
                "  tried      {}: {} steps, {:.2} % of the sample over; cost {:.3e}; holds for {} of {} objects",
                t.name,
                t.error,
                100.0 * t.over,
                t.cost,
                t.holds_for,
                self.recipes.len()
            )?;
        }
        for note in &self.notes {
            writeln!(f, "  note       {note}")?;
        }
        for (recipe, objects) in settings::grouped(&self.recipes) {
            writeln!(f, "  chosen     {recipe} for {objects} objects")?;
        }
        writeln!(f, "  values run {} across faces", self.interp.as_str())?;
        let [exact, chosen] = self.costs;
        if exact > 0.0 {
            let part = 100.0 * chosen / exact;
            writeln!(f, "  cost       {chosen:.3e} of {exact:.3e} units by the fixed table ({part:.0} %)")?;
        }
        if self.sampled > 0 {
            writeln!(
                f,
                "  sample     {} of {} pixels drawn on, {} over; that at most 1 in 1000 is over is sure to {:.2} %",
                self.sampled,
                self.pixels,
                self.over,
                100.0 * self.confidence
            )?;
        }
        Ok(())
    }
}
