//! Machines for the tests of sequences: straight axes with switches, a probe over a bed.

use base::bench::BenchHands;
use base::ports::Input;
use units::Actuator;

use crate::endstop_phase::{EndstopPhases, PhaseHands};
use crate::paper::{Paper, PaperHands};
use crate::probing::{DeltaRecords, Deployment, ProbeHands};

/// What sequences keep from one to the next.
#[derive(Default)]
pub struct Kept {
    phases: EndstopPhases,
    delta: DeltaRecords,
    pub deployment: Deployment,
    paper: Paper,
}

/// The machine in the hands of a sequence.
pub type Bench = BenchHands<Kept>;

impl PhaseHands<'static> for Bench {
    fn phases(&mut self) -> &mut EndstopPhases {
        &mut self.extra.phases
    }

    fn homes_by_template(&self) -> bool {
        false
    }
}

impl ProbeHands<'static> for Bench {
    fn delta_records(&mut self) -> &mut DeltaRecords {
        &mut self.extra.delta
    }

    fn deployment(&mut self) -> &mut Deployment {
        &mut self.extra.deployment
    }
}

impl PaperHands<'static> for Bench {
    fn paper(&mut self) -> &mut Paper {
        &mut self.extra.paper
    }
}

/// Settings of a machine with a switch at the low end of X, Y and Z, and a probe.
const MACHINE: &str = "\
[motion control]
arm_solution = cartesian
default_feed_rate = 3000
default_seek_rate = 9000
default_acceleration = 1000
[actuator]
alpha.steps_per_mm = 40
alpha.max_rate = 18000
alpha.step_pin = PD3
alpha.dir_pin = PD4
beta.steps_per_mm = 40
beta.max_rate = 18000
beta.step_pin = PK2
beta.dir_pin = PG2
gamma.steps_per_mm = 100
gamma.max_rate = 1800
gamma.step_pin = PG3
gamma.dir_pin = PG4
[endstops]
minx.enable = true
minx.pin = PD0^
minx.axis = X
minx.homing_direction = home_to_min
minx.homing_position = 0
minx.max_travel = 60
minx.fast_rate = 50
minx.slow_rate = 10
minx.retract = 3
miny.enable = true
miny.pin = PI1^
miny.axis = Y
miny.homing_direction = home_to_min
miny.homing_position = -2
miny.max_travel = 60
miny.fast_rate = 50
miny.slow_rate = 10
miny.retract = 3
minz.enable = true
minz.pin = PI0^
minz.axis = Z
minz.homing_direction = home_to_min
minz.homing_position = 0
minz.max_travel = 50
minz.fast_rate = 10
minz.slow_rate = 4
minz.retract = 2
";

/// Makes that machine, with more settings, without any contact wired.
pub fn unwired(more: &str) -> Bench {
    Bench::new(&format!("{MACHINE}{more}"))
}

/// Makes that machine, with switches that close where X, Y and Z of the motors are these, mm.
pub fn machine(more: &str, switches: [f64; 3]) -> Bench {
    let mut bench = unwired(more);
    for (index, place) in switches.into_iter().enumerate() {
        bench.world.wire_input(Input::Endstop(index as u8), move |motors| motors.0[index] <= place);
    }
    bench
}

/// Settings of a probe.
pub const PROBE: &str = "\
[zprobe]
enable = true
probe_pin = PG1
slow_feedrate = 4
fast_feedrate = 20
return_feedrate = 20
max_travel = 40
probe_height = 3
";

/// Wires the probe to a bed with this height at each X and Y, mm.
pub fn put_bed(bench: &mut Bench, height: impl Fn(f64, f64) -> f64 + 'static) {
    bench.world.wire_input(Input::Probe, move |motors| {
        motors[Actuator::Gamma] <= height(motors[Actuator::Alpha], motors[Actuator::Beta])
    });
}
