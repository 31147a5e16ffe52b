//! The record of step edges: every edge a driver takes as a step, with time, motor and direction.

use units::{Actuator, Direction, MAX_ACTUATORS};

/// Step edge of a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepEdge {
    /// Time of the edge, nanoseconds since power-on.
    pub time_ns: u64,
    /// Motor that took the step.
    pub actuator: Actuator,
    /// Direction of the step, as the machine counts (direction inversion undone).
    pub direction: Direction,
}

/// Change of a laser's duty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PowerChange {
    /// Time of the change, nanoseconds since power-on.
    pub time_ns: u64,
    /// Duty from then on, in 1/65535.
    pub duty: u16,
}

/// FNV-1a, 64 bit. Published by Fowler, Noll and Vo; offset basis and prime from their reference page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fnv1a(u64);

impl Default for Fnv1a {
    fn default() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }
}

impl Fnv1a {
    /// Takes these bytes in.
    pub fn update(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }

    /// The hash so far.
    #[must_use]
    pub const fn value(self) -> u64 {
        self.0
    }
}

/// Counts and speeds of one motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActuatorTally {
    /// Number of step edges taken.
    pub steps: u64,
    /// Forward minus backward edges.
    pub net_steps: i64,
    /// Highest rate over any two consecutive edges of one direction, steps per second.
    pub max_steps_per_s: f64,
    last: Option<(u64, Direction)>,
}

/// Record of a run. Edges are kept until taken; hash and tallies cover all of them.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    edges: Vec<StepEdge>,
    powers: Vec<PowerChange>,
    hash: Fnv1a,
    tallies: [ActuatorTally; MAX_ACTUATORS],
    total: u64,
}

impl Trace {
    /// Appends an edge. The hash takes its time (u64), actuator index (u8) and direction (i8), little-endian.
    pub fn push(&mut self, edge: StepEdge) {
        self.hash.update(&edge.time_ns.to_le_bytes());
        self.hash.update(&[edge.actuator as u8, edge.direction.sign() as i8 as u8]);
        let tally = &mut self.tallies[edge.actuator as usize];
        if let Some((before_ns, direction)) = tally.last
            && direction == edge.direction
            && edge.time_ns > before_ns
        {
            tally.max_steps_per_s = tally.max_steps_per_s.max(1e9 / (edge.time_ns - before_ns) as f64);
        }
        tally.last = Some((edge.time_ns, edge.direction));
        tally.steps += 1;
        tally.net_steps += i64::from(edge.direction.sign());
        self.total += 1;
        self.edges.push(edge);
    }

    /// Appends a change of a laser's power. The hash of edges is that of steps alone.
    pub fn push_power(&mut self, change: PowerChange) {
        self.powers.push(change);
    }

    /// Hands the changes of power over.
    pub fn take_power(&mut self) -> Vec<PowerChange> {
        std::mem::take(&mut self.powers)
    }

    /// Hash over every edge so far.
    #[must_use]
    pub const fn edge_hash(&self) -> u64 {
        self.hash.value()
    }

    /// Returns the number of edges in all.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.total
    }

    /// Counts and speeds of one motor.
    #[must_use]
    pub const fn tally(&self, actuator: Actuator) -> &ActuatorTally {
        &self.tallies[actuator as usize]
    }

    /// Edges since the last [`Self::take`], oldest first.
    #[must_use]
    pub fn edges(&self) -> &[StepEdge] {
        &self.edges
    }

    /// Hands the edges over, so that a long run need not keep them in memory.
    pub fn take(&mut self) -> Vec<StepEdge> {
        std::mem::take(&mut self.edges)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_fnv1a() {
        let mut hash = Fnv1a::default();
        hash.update(b"foobar");
        assert_eq!(hash.value(), 0x8594_4171_F739_67E8);
    }

    #[test]
    fn the_hash_does_not_depend_on_when_edges_are_taken() {
        let edges = (0..100).map(|n| StepEdge {
            time_ns: n * 1_000,
            actuator: Actuator::Beta,
            direction: if n % 3 == 0 { Direction::Backward } else { Direction::Forward },
        });
        let (mut kept, mut taken) = (Trace::default(), Trace::default());
        for (index, edge) in edges.enumerate() {
            kept.push(edge);
            taken.push(edge);
            if index % 7 == 0 {
                taken.take();
            }
        }
        assert_eq!(kept.edge_hash(), taken.edge_hash());
        assert_eq!(kept.total(), taken.total());
        assert_eq!(kept.tally(Actuator::Beta), taken.tally(Actuator::Beta));
        assert_eq!(kept.tally(Actuator::Beta).net_steps, 66 - 34);
        assert_eq!(kept.tally(Actuator::Beta).max_steps_per_s, 1e6);
    }
}
