//! The job as viewers see it.

use base::snapshot::JobShown;
use units::Micros;

use super::{Jobs, TimeLeft};

impl Jobs {
    /// Returns the job as viewers see it; none without a job.
    #[must_use]
    pub fn shown(&self, now: Micros, time_left: &TimeLeft) -> Option<JobShown> {
        let job = self.job.as_ref()?;
        let (line, done) = self.place(job);
        Some(JobShown {
            path: job.path.clone(),
            size: job.size,
            done,
            line,
            elapsed_s: (now.since(job.started).millis() / 1_000) as u32,
            left_s: self.time_left(job, time_left).map(|(left, ..)| left),
            is_paused: job.paused,
            is_heating: self.is_heating,
            layer: job.layers.current,
            layers: job.layers.total,
            filament: self.statistics.filament() as f32,
            end: None,
        })
    }
}
