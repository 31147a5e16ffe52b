//! What a program goes on with after somebody worked at the machine.

use units::{Axis, PerAxis};

use crate::cycles::Series;
use crate::interpreter::Interpreter;
use crate::modal::Modal;

/// Less than this, mm, is rounding.
const NOTHING: f64 = 1e-9;

/// Modes and E of a program.
#[derive(Clone, Debug)]
pub struct Kept {
    modal: Modal,
    series: Series,
    e: f64,
}

impl Interpreter {
    /// Modes and E of the program as they are, to come back to.
    #[must_use]
    pub fn keep(&self) -> Kept {
        let series = *self.cycles.series();
        Kept { series, modal: self.modal.clone(), e: self.tools.active().map_or(0.0, |tool| tool.e) }
    }

    /// Comes back to what was kept. What makes up for temperature is the machine's, and is as it is now.
    pub fn come_back_to(&mut self, kept: Kept) {
        let thermal_z = self.modal.thermal_z;
        self.modal = kept.modal;
        self.modal.set_thermal_z(thermal_z);
        self.cycles.set_series(kept.series);
        if let Some(tool) = self.tools.active_mut() {
            tool.e = kept.e;
        }
    }

    /// The same, but for offsets: those that were set meanwhile, for another cutter or another part, stay.
    pub fn go_on_from(&mut self, mut kept: Kept) {
        kept.modal.take_offsets_of(&self.modal);
        self.come_back_to(kept);
    }

    /// Where a place of the machine lies now that had the same work coordinates, in the coordinate system in
    /// force then, when `kept` was kept.
    pub fn same_work_place(&mut self, kept: &Kept, place: &PerAxis<f64>) -> PerAxis<f64> {
        let work = kept.modal.work(place);
        let in_force = core::mem::replace(&mut self.modal.system, kept.modal.system);
        let [x, y] = self.modal.machine_xy([work[Axis::X], work[Axis::Y]]);
        let z = work[Axis::Z] + self.modal.offset(Axis::Z);
        self.modal.system = in_force;
        let mut now = *place;
        for (axis, to) in Axis::PRIMARY.into_iter().zip([x, y, z]) {
            now[axis] = if libm::fabs(to - place[axis]) > NOTHING { to } else { place[axis] };
        }
        now
    }
}
