//! Faults that sensor chips report, each told once: also while nothing heats, and if the fault ends before
//! anybody asks.

use config::HeaterId;
use units::Micros;

use crate::io::{MAX_HEATERS, SensorReading, SensorReadings};

/// Time after which the same fault of the same sensor is told again.
const AGAIN: Micros = Micros::from_seconds(60);

/// Faults told of each sensor, and their times.
#[derive(Debug)]
pub(super) struct ChipFaults {
    told: [Option<(&'static str, Micros)>; MAX_HEATERS],
    news: Option<(HeaterId, &'static str)>,
}

impl ChipFaults {
    pub(super) const fn new() -> Self {
        Self { told: [None; MAX_HEATERS], news: None }
    }

    /// Looks at the readings of a moment. Faults beside the first wait for the next look.
    pub(super) fn look(&mut self, now: Micros, readings: &SensorReadings) {
        if self.news.is_some() {
            return;
        }
        for ((id, reading), told) in HeaterId::all().zip(readings).zip(&mut self.told) {
            let SensorReading::Fault(words) = *reading else { continue };
            if told.is_none_or(|(before, at)| before != words || now.since(at) >= AGAIN) {
                *told = Some((words, now));
                self.news = Some((id, words));
                return;
            }
        }
    }

    /// Returns the fault to be told, once.
    pub(super) const fn take(&mut self) -> Option<(HeaterId, &'static str)> {
        self.news.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_is_told_once_and_again_after_a_minute() {
        let mut faults = ChipFaults::new();
        let mut readings = SensorReadings::default();
        (readings[1], readings[4]) = (SensorReading::Fault("open"), SensorReading::Fault("reset"));
        let mut told = |readings: &SensorReadings, seconds| {
            faults.look(Micros::from_seconds(seconds), readings);
            faults.take().map(|(id, words)| (id.index(), words))
        };
        assert_eq!(told(&readings, 1), Some((1, "open")));
        assert_eq!(told(&readings, 1), Some((4, "reset")));
        assert_eq!(told(&readings, 2), None);
        readings[4] = SensorReading::MilliDegrees(0);
        readings[1] = SensorReading::Fault("short");
        assert_eq!(told(&readings, 3), Some((1, "short")));
        assert_eq!(told(&readings, 62), None);
        assert_eq!(told(&readings, 63), Some((1, "short")));
    }
}
