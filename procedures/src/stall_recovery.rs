//! State of a job that a stall has stopped, and the number of recent stalls.

use config::StallRecoveryConfig;
use heapless::Vec;
use program::BEGINNING_BYTES;
use units::{Actuator, AxisSet, Micros, PerAxis};

/// Greatest number of recoveries remembered; the configuration allows no more.
const MOST: usize = 16;
/// Extruders whose flow factor is kept.
const FLOWS: usize = 3;

/// Job that a stall has stopped, from the stop on until it is suspended.
#[derive(Clone, Copy, Debug)]
pub struct Stopped {
    /// Motor that has stalled.
    pub motor: Actuator,
    /// Axes that have lost their place.
    pub lost: AxisSet,
    /// Place where the machine came to rest, as far as it knows, mm.
    pub at: PerAxis<f64>,
    /// Lines of the job that were made before the line under way. `None`: the line was none of the job's.
    pub made: Option<u32>,
    /// Number of the line that was under way.
    pub line: u32,
    /// End of the straight move that was under way, mm.
    pub straight_to: Option<PerAxis<f64>>,
    /// Objects that are left out, a bit each.
    pub left_out: u64,
    /// Flow factors of the extruders.
    pub flow: [f64; FLOWS],
}

/// Progress of the recovery from a stall.
#[derive(Clone, Copy, Debug, Default)]
pub enum Phase {
    /// No stall has stopped a job.
    #[default]
    Rest,
    /// Braking because of this motor.
    Brakes(Actuator),
    /// At rest; sequences that waited for the moves are ending.
    Stands(Stopped),
    /// Finding out where the job was.
    Looks(Stopped),
    /// Homing, and going back to where the job was.
    Returns,
}

/// Stalls of the present job.
#[derive(Debug, Default)]
pub struct StallRecovery {
    /// State of the recovery.
    pub phase: Phase,
    /// Number of a job since boot, and the program's state at its beginning.
    beginning: Option<(u32, [u8; BEGINNING_BYTES])>,
    /// Times of recent recoveries.
    recovered: Vec<Micros, MOST>,
}

impl StallRecovery {
    /// Returns whether a job is not where its file says.
    pub const fn is_under_way(&self) -> bool {
        !matches!(self.phase, Phase::Rest)
    }

    /// Ends a recovery: the job has ended, or is suspended.
    pub const fn rest(&mut self) {
        self.phase = Phase::Rest;
    }

    /// Keeps the program's state at the beginning of this job.
    pub const fn keep_beginning(&mut self, job: u32, beginning: Option<[u8; BEGINNING_BYTES]>) {
        self.beginning = match beginning {
            Some(bytes) => Some((job, bytes)),
            None => None,
        };
    }

    /// Forgets the beginning: the file alone does not lead to the program's state any more.
    pub const fn forget_beginning(&mut self) {
        self.beginning = None;
    }

    /// Returns the program's state at the beginning of this job.
    pub fn beginning_of(&self, job: u32) -> Option<[u8; BEGINNING_BYTES]> {
        self.beginning.filter(|(of, _)| *of == job).map(|(_, bytes)| bytes)
    }

    /// Counts a recovery if the job may make one more now; returns its number within the configured time.
    pub fn take_recovery(&mut self, now: Micros, settings: &StallRecoveryConfig) -> Option<usize> {
        self.recovered.retain(|at| now.since(*at) < settings.time);
        if self.recovered.len() >= usize::from(settings.most) {
            return None;
        }
        // There is room, for the configuration allows no more.
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
