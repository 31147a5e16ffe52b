//! `?`: report of the machine's state, position, speed and temperatures.

use base::ports::{HeatPort, MotionPort};
use base::safety::Mode;
use base::sessions::Reply;
use config::MachineConfig;
use program::{Dialect, Interpreter, MotionMode, State};
use units::{MmPerSecond, PerAxis};

use super::{Line, add, auxiliary_axes};

/// Facts for a status report, beside those of the ports.
#[derive(Clone, Copy, Debug)]
pub struct Status<'m> {
    /// State of the machine.
    pub mode: Mode,
    /// The program's interpreter, with the modes in force.
    pub program: &'m Interpreter,
    /// The machine as configured.
    pub config: &'m MachineConfig,
    /// Dialect of the session that asks.
    pub dialect: Dialect,
    /// Seconds and percent of the job, if there is a job.
    pub progress: Option<(u64, u64)>,
}

/// Returns whether something may be moving in a state. At rest the position is the end of the last accepted
/// move, to the last decimal.
#[must_use]
pub const fn is_live(state: State) -> bool {
    !matches!(state, State::Idle | State::Suspended | State::Check | State::Alarm | State::Sleep | State::Invalid)
}

/// Reports `<State|MPos:x,y,z|WPos:x,y,z|F:...|S:...>`.
pub fn status(ports: &mut (impl MotionPort + HeatPort), of: &Status<'_>, reply: &mut Reply<'_>) {
    let line = fields(ports, of);
    reply.say(format_args!("<{line}>\n"));
}

/// Returns the text between the brackets of `?`; `get status` reports it without them.
pub(super) fn fields(ports: &mut (impl MotionPort + HeatPort), of: &Status<'_>) -> Line {
    let live = is_live(of.mode.state());
    let machine = ports.motion(|motion| if live { motion.live_position() } else { motion.commanded_position() });
    let mut line = Line::new();
    add!(line, "{}|MPos:", of.mode.state().name());
    add_xyz(&mut line, of.program, &machine);
    for axis in auxiliary_axes(of.config) {
        add!(line, ",{:.4}", machine[axis]);
    }
    add!(line, "|WPos:");
    add_xyz(&mut line, of.program, &of.program.modal().work(&machine));
    add_rates(&mut line, of.program, ports, live);
    if of.dialect != Dialect::Grbl {
        add_temperatures(&mut line, of.config, ports);
    }
    if let Some((seconds, percent)) = of.progress {
        add!(line, "|SD:{seconds},{percent}");
    }
    line
}

fn add_xyz(line: &mut Line, program: &Interpreter, position: &PerAxis<f64>) {
    let [x, y, z, ..] = position.0.map(|mm| program.modal().in_program_units(mm));
    add!(*line, "{x:.4},{y:.4},{z:.4}");
}

fn add_rates(line: &mut Line, program: &Interpreter, ports: &mut impl MotionPort, live: bool) {
    let modal = program.modal();
    let requested = requested_rate(program);
    let (current, percent) =
        ports.motion(|motion| (motion.speed(), motion.overrides().feed * modal.speed_factor * 100.0));
    let unit = |rate: MmPerSecond| modal.in_program_units(rate.per_minute());
    if live {
        add!(*line, "|F:{:.1},{:.1},{percent:.1}|S:{:.4}", unit(current), unit(requested), modal.power);
    } else {
        add!(*line, "|F:{:.1},{percent:.1}|S:{:.2}", unit(requested), modal.power);
    }
}

/// Returns the rate of moves by the motion code in force.
pub(super) fn requested_rate(program: &Interpreter) -> MmPerSecond {
    let modal = program.modal();
    if modal.motion == MotionMode::Rapid { modal.seek_rate } else { modal.feed_rate }
}

fn add_temperatures(line: &mut Line, config: &MachineConfig, ports: &mut impl HeatPort) {
    ports.heat(|heat| {
        for ((_, controller), (_, heater)) in config.heaters().zip(heat.heaters()) {
            let reading = heater.reading().map_or(f32::INFINITY, |celsius| celsius.0);
            add!(*line, "|{}:{reading:.1},{:.1}", controller.designator, heater.target().0);
        }
    });
}

/// `get mode`: reports the exact state in words, of which `?` has fewer names, and whether a job is
/// suspended.
pub(super) fn mode(mode: Mode, reply: &mut Reply<'_>) {
    let mut name = Line::new();
    add!(name, "{:?}", mode.state());
    name.make_ascii_lowercase();
    reply.say(format_args!("{name}{}\n", if mode.is_suspended() { " (suspended)" } else { "" }));
}
