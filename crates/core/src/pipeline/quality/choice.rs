//! The chosen quality settings, their grounds, and their text.

use super::{Budget, Detail, QualitySettings, settings};
use crate::scene::{MaxError, Scene};
use std::fmt;

/// Largest number of different levels and reasons that are named.
const MOST_DETAILS: usize = 8;

/// The chosen settings, and the grounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The allowed error.
    pub max_error: MaxError,
    /// Settings of each object.
    pub settings: Vec<QualitySettings>,
    /// Levels of detail of meshes of many faces, or the reasons why there are none; each once, with
    /// the number of objects.
    pub details: Vec<(Detail, usize)>,
    /// Largest proven bound of an object's error, in 1/255 steps, rounding included; 0 where all
    /// is exact.
    pub proven: f64,
    /// Costs of the exact picture and of the choice, in units of the calibration table.
    pub costs: [f64; 2],
    /// Number of objects whose meshes are drawn for the first time, so that nothing is known of them.
    pub unknown: usize,
    /// Number of objects whose meshes cost more to measure than two exact frames.
    pub unmeasured: usize,
    /// Reason why all is exact, if there is one for the whole scene.
    pub exact_because: Option<&'static str>,
}

impl Choice {
    /// Creates the choice that changes nothing.
    pub fn exact(budget: &Budget) -> Choice {
        Choice {
            max_error: budget.max_error,
            settings: vec![QualitySettings::default(); budget.scene.objects.len()],
            details: Vec::new(),
            proven: 0.0,
            costs: [0.0; 2],
            unknown: 0,
            unmeasured: 0,
            exact_because: None,
        }
    }

    /// Returns whether everything is drawn exactly.
    pub fn is_exact(&self) -> bool {
        self.settings.iter().all(|s| *s == QualitySettings::default())
    }

    /// Adds what was decided for the faces of an object.
    pub(super) fn note_detail(&mut self, detail: Detail) {
        match self.details.iter().position(|(known, _)| *known == detail) {
            Some(at) => self.details[at].1 += 1,
            None if self.details.len() < MOST_DETAILS => self.details.push((detail, 1)),
            None => {}
        }
    }

    /// Applies the choice to a scene.
    pub fn apply(&self, scene: &mut Scene) {
        scene.objects.iter_mut().zip(&self.settings).for_each(|(object, own)| own.apply(object));
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let MaxError { steps, shift } = self.max_error;
        write!(f, "budget: at most {steps} steps of 255 for 999 of 1000 pixels drawn on")?;
        match shift > 0.0 {
            true => writeln!(f, ", each within {shift} pixels")?,
            false => writeln!(f)?,
        }
        for (own, objects) in settings::grouped(&self.settings) {
            writeln!(f, "  chosen     {own} for {objects} objects")?;
        }
        for (detail, objects) in &self.details {
            writeln!(f, "  detail     {detail}, for {objects} objects")?;
        }
        if self.proven > 0.0 {
            let view = if self.settings.iter().any(|s| s.level.is_some()) { "this" } else { "any" };
            writeln!(f, "  proven     at most {:.2} steps for {view} camera", self.proven)?;
        }
        let [exact, chosen] = self.costs;
        if exact > 0.0 {
            let part = 100.0 * chosen / exact;
            writeln!(f, "  cost       {chosen:.3e} of {exact:.3e} units by the calibration ({part:.0} %)")?;
        }
        if self.unknown > 0 {
            writeln!(f, "  note       {} meshes are drawn for the first time: exact", self.unknown)?;
        }
        if self.unmeasured > 0 {
            let count = self.unmeasured;
            writeln!(f, "  note       {count} meshes would cost more to measure than two exact frames")?;
        }
        if let Some(reason) = self.exact_because {
            writeln!(f, "  note       {reason}")?;
        }
        Ok(())
    }
}
