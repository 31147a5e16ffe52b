//! Probing the bed at one place after another: over to it, down, and up again.

use units::{Axis, PerAxis};

use crate::controller::Controller;
use crate::failure::{Failure, message};
use crate::ports::Ports;

impl<P: Ports> Controller<P> {
    /// The way to the bed: -1, or 1 for a probe that searches upwards.
    fn towards_bed(&self) -> f64 {
        if self.config.probe.reverse_z { 1.0 } else { -1.0 }
    }

    /// Where the nozzle is while the probe is over this place.
    pub(super) fn nozzle_over(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [dx, dy, _] = self.levelling.probe_offsets;
        [x - dx, y - dy]
    }

    /// Where the probe is now.
    pub(super) fn probed_by_nozzle_here(&self) -> [f64; 2] {
        let [dx, dy, _] = self.levelling.probe_offsets;
        [self.position[Axis::X] + dx, self.position[Axis::Y] + dy]
    }

    /// The height `probe_height` away from a contact.
    pub(super) fn clear_of(&self, contact: f64) -> f64 {
        contact - self.towards_bed() * self.config.probe.height.0
    }

    /// Finds the bed at X and Y, coming from this height. Stands `probe_height` away from it afterwards.
    pub(super) async fn find_bed(&mut self, at: [f64; 2], from: f64) -> Result<PerAxis<f64>, Failure> {
        let mut over = self.position;
        over[Axis::Z] = from;
        self.go_there(over, self.config.probe.fast_rate).await?;
        let contact = self.touch(at, from).await?;
        self.lift(self.clear_of(contact[Axis::Z])).await?;
        Ok(contact)
    }

    /// Probes the bed at X and Y, travelling there and back up at this height.
    pub(super) async fn probe_point(&mut self, at: [f64; 2], height: f64) -> Result<PerAxis<f64>, Failure> {
        let contact = self.touch(at, height).await?;
        self.lift(height).await?;
        Ok(contact)
    }

    async fn touch(&mut self, at: [f64; 2], height: f64) -> Result<PerAxis<f64>, Failure> {
        let probe = self.config.probe;
        let mut over = self.position;
        (over[Axis::X], over[Axis::Y], over[Axis::Z]) = (at[0], at[1], height);
        self.go_there(over, probe.fast_rate).await?;
        let found = self.search(&self.search_down(probe.slow_rate, probe.max_travel.0, probe.reverse_z)).await?;
        let Some(contact) = found else {
            self.lift(height).await?;
            let text =
                format_args!("ZProbe not triggered at X{:.3} Y{:.3} on {} mm of way", at[0], at[1], probe.max_travel.0);
            return Err(Failure::Refused(message(text)));
        };
        Ok(contact)
    }

    async fn lift(&mut self, height: f64) -> Result<(), Failure> {
        let mut target = self.position;
        target[Axis::Z] = height;
        self.go_there(target, self.config.probe.return_rate).await
    }
}
