//! Changing the compensation, at rest: the motors stay where they are, the program's position becomes what
//! belongs to it.

use units::PerAxis;

use super::Motion;
use crate::compensation::{Compensation, CompensationError, Fade, GridShape, Interpolation, Plane, Skew};

impl Motion {
    /// Returns the compensation between the program's machine space and the motors.
    #[must_use]
    pub const fn compensation(&self) -> &Compensation {
        &self.compensation
    }

    /// Heights being gathered, mm, row by row along X; nothing of it is in force before
    /// [`Self::level_by_draft`].
    pub fn draft(&mut self) -> &mut [f32] {
        self.compensation.draft()
    }

    /// Begins a draft with the heights in force, or with a flat bed.
    pub fn copy_to_draft(&mut self) {
        self.compensation.copy_to_draft();
    }

    /// Levels by the heights in [`Self::draft`]: what the motors' Z must be where the program's Z is 0, at
    /// each point of the grid, and what `interpolation` makes of them between. Replaces any levelling in
    /// force.
    ///
    /// # Errors
    /// A mistake in the grid, or a machine that moves; nothing was changed then.
    pub fn level_by_draft(
        &mut self,
        shape: &GridShape,
        interpolation: Interpolation,
        fade: Option<Fade>,
    ) -> Result<(), CompensationError> {
        self.recompensate(|compensation| compensation.set_grid(shape, interpolation, fade))
    }

    /// Levels by the grid that did last, after [`Self::level_off`], moved by so much along X and Y, mm.
    ///
    /// # Errors
    /// No last grid, a grid too high for this fading, or a machine that moves; nothing was changed then.
    pub fn level_by_last_grid(&mut self, by: [f64; 2], fade: Option<Fade>) -> Result<(), CompensationError> {
        self.recompensate(|compensation| compensation.set_last_grid(by, fade))
    }

    /// Levels by a plane, without fading.
    ///
    /// # Errors
    /// A plane that is too steep, or a machine that moves; nothing was changed then.
    pub fn level_by_plane(&mut self, plane: Plane) -> Result<(), CompensationError> {
        self.recompensate(|compensation| compensation.set_plane(plane))
    }

    /// Switches levelling off for good.
    ///
    /// # Errors
    /// [`CompensationError::Busy`].
    pub fn level_off(&mut self) -> Result<(), CompensationError> {
        self.recompensate(|compensation| {
            compensation.set_flat();
            Ok(())
        })
    }

    /// Sets the skew that is taken back.
    ///
    /// # Errors
    /// A factor out of bounds, or a machine that moves; nothing was changed then.
    pub fn set_skew(&mut self, skew: Skew) -> Result<(), CompensationError> {
        self.recompensate(|compensation| compensation.set_skew(skew))
    }

    /// Suspends compensation, for homing and probing: the program's space is then the motors', or puts it in
    /// force again.
    ///
    /// # Errors
    /// [`CompensationError::Busy`].
    pub fn suspend_compensation(&mut self, suspended: bool) -> Result<(), CompensationError> {
        self.recompensate(|compensation| {
            compensation.set_suspended(suspended);
            Ok(())
        })
    }

    fn recompensate(
        &mut self,
        change: impl FnOnce(&mut Compensation) -> Result<(), CompensationError>,
    ) -> Result<(), CompensationError> {
        if !self.is_idle() {
            return Err(CompensationError::Busy);
        }
        let motors = self.compensation.motors(&self.planned);
        change(&mut self.compensation)?;
        let position: PerAxis<f64> = self.compensation.program(&motors);
        self.place = position;
        self.planned = position;
        self.last = None;
        self.filters.settle(position, self.clock);
        Ok(())
    }
}
