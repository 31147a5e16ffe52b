//! What is known of a job that a stall has stopped, and how often that has happened.

use config::StallRecoveryConfig;
use heapless::Vec;
use program::BEGINNING_BYTES;
use units::{Actuator, AxisSet, Micros, PerAxis};

/// Recoveries that are remembered; the configuration allows no more.
const MOST: usize = 16;
/// Extruders whose flow is kept.
const FLOWS: usize = 3;

/// A job that a stall has stopped, from the stop on until it is suspended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stopped {
    /// The motor that has stalled.
    pub motor: Actuator,
    /// Axes that have lost their place.
    pub lost: AxisSet,
    /// Where the machine came to rest, as far as it knows, mm.
    pub at: PerAxis<f64>,
    /// Lines of the job that were made before the one under way. `None`: that was none of the job's.
    pub made: Option<u32>,
    /// The number of the line that was under way.
    pub line: u32,
    /// Where the straight move that was under way ends, mm.
    pub straight_to: Option<PerAxis<f64>>,
    /// Objects that are left out, a bit each.
    pub left_out: u64,
    /// Factors of flow.
    pub flow: [f64; FLOWS],
}

/// How far the machine is with a stall.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum Phase {
    /// None has stopped a job.
    #[default]
    Rest,
    /// It brakes because of this motor.
    Brakes(Actuator),
    /// It has come to rest; whatever waited for its moves is ending.
    Stands(Stopped),
    /// It finds out where the job was.
    Looks(Stopped),
    /// It homes, and goes back to where the job was.
    Returns,
}

/// Stalls of the job.
#[derive(Debug, Default)]
pub(crate) struct StallRecovery {
    pub phase: Phase,
    /// Which job since boot this is of, and what the program stood on where that began.
    beginning: Option<(u32, [u8; BEGINNING_BYTES])>,
    /// When jobs got over stalls, lately.
    recovered: Vec<Micros, MOST>,
}

impl StallRecovery {
    /// A job is not where its file says.
    pub const fn is_under_way(&self) -> bool {
        !matches!(self.phase, Phase::Rest)
    }

    /// Nothing of it goes on: the job has ended, or is suspended.
    pub const fn rest(&mut self) {
        self.phase = Phase::Rest;
    }

    /// What this job begins with.
    pub const fn keep_beginning(&mut self, job: u32, beginning: Option<[u8; BEGINNING_BYTES]>) {
        self.beginning = match beginning {
            Some(bytes) => Some((job, bytes)),
            None => None,
        };
    }

    /// The file alone does not lead to where the program stands any more.
    pub const fn forget_beginning(&mut self) {
        self.beginning = None;
    }

    /// What this job began with.
    pub fn beginning_of(&self, job: u32) -> Option<[u8; BEGINNING_BYTES]> {
        self.beginning.filter(|(of, _)| *of == job).map(|(_, bytes)| bytes)
    }

    /// Whether a job may get over one more stall now, which is counted then: which one it is within the time.
    pub fn take_recovery(&mut self, now: Micros, settings: &StallRecoveryConfig) -> Option<usize> {
        self.recovered.retain(|at| now.since(*at) < settings.time);
        if self.recovered.len() >= usize::from(settings.most) {
            return None;
        }
        // There is room: the configuration allows no more.
        let _ = self.recovered.push(now);
        Some(self.recovered.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::Mm;

    #[test]
    fn so_many_recoveries_within_a_time_and_no_more() {
        let settings = StallRecoveryConfig { most: 2, time: Micros::from_seconds(60), lift: Mm(5.0) };
        let mut stalls = StallRecovery::default();
        let mut at = |seconds| stalls.take_recovery(Micros::from_seconds(seconds), &settings);
        assert_eq!([at(0), at(30), at(40), at(59)], [Some(1), Some(2), None, None]);
        assert_eq!([at(61), at(62)], [Some(2), None], "the first one is long ago");
        assert_eq!([at(200), at(201)], [Some(1), Some(2)]);
    }

    #[test]
    fn a_beginning_is_of_its_job_alone() {
        let mut stalls = StallRecovery::default();
        stalls.keep_beginning(3, Some([7; BEGINNING_BYTES]));
        assert!(stalls.beginning_of(3).is_some() && stalls.beginning_of(4).is_none());
        stalls.forget_beginning();
        assert!(stalls.beginning_of(3).is_none());
    }
}
