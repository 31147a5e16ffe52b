//! Status report `?` of GRBL 1.1: `<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000>`.
//!
//! Fields that seldom change are reported seldom: offsets in every thirtieth report while something goes on
//! and in every tenth else, overrides in every twentieth and tenth, and both as soon as they have changed.

use base::ports::{Input, Inputs, MotionPort};
use base::safety::Mode;
use base::sessions::Reply;
use base::tuning::Tuning;
use config::MachineConfig;
use motion::Motion;
use parts::outputs::Outputs;
use parts::reports::{Line, add, free_axes};
use program::{Interpreter, State};
use units::{Axis, AxisSet, PerAxis};

use super::last_report::{Overrides, Told};
use super::reports::{Length, MM_PER_INCH};
use crate::features::grbl::hal;
use crate::features::grbl::state::Own;

/// Contents of a report, beside the state in the ports.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Report<'m> {
    pub mode: Mode,
    pub program: &'m Interpreter,
    pub config: &'m MachineConfig,
    pub tuning: &'m Tuning,
    pub outputs: &'m Outputs,
    pub own: &'m Own,
    /// Override of the spindle's speed, percent.
    pub spindle_percent: f64,
    /// Number of the line that the motors make.
    pub line: Option<u32>,
    /// Bytes that the session may still send.
    pub room: usize,
    /// Axes that are homed, and those that can be.
    pub homed: [AxisSet; 2],
    /// Progress of the file being played.
    pub job: Option<hal::Share<'m>>,
}

impl Report<'_> {
    /// Returns whether something may be moving, or waits to.
    const fn is_busy(&self) -> bool {
        matches!(
            self.mode.state(),
            State::Run | State::Hold | State::Homing | State::Probing | State::Jog | State::Door
        )
    }

    fn overrides(&self, motion: &Motion) -> Overrides {
        let factors = motion.overrides();
        let feed = factors.feed * self.program.modal().speed_factor;
        let told = self.program.modal().auxiliary.spindle;
        let is_laser = program::laser::of(self.program).is_some();
        let spindle = if is_laser { told } else { self.outputs.spindle(self.config, told) };
        let is_on = |code| match code {
            3 | 4 => spindle.code() == code,
            _ => self.outputs.is_on_by_code(self.config, code),
        };
        let on = [3, 4, 8, 7].into_iter().enumerate().filter(|(_, code)| is_on(*code));
        Overrides {
            percents: [libm::round(feed * 100.0), libm::round(factors.rapid * 100.0), self.spindle_percent],
            accessories: on.fold(0, |bits, (bit, _)| bits | 1 << bit),
        }
    }
}

/// Answers the query `?`.
pub(crate) fn report(ports: &mut (impl MotionPort + Inputs), of: &Report<'_>, told: &mut Told, reply: &mut Reply<'_>) {
    let live = of.is_busy();
    let (place, speed, overrides, room, rests) = ports.motion(|motion| {
        let place = if live { motion.live_position() } else { motion.commanded_position() };
        let (used, size) = motion.queue_level();
        (place, motion.speed(), of.overrides(motion), size.saturating_sub(used), motion.speed().0 == 0.0)
    });
    let mut line = Line::new();
    add!(line, "<{}{}", of.mode.state().name(), sub_state(of.mode.state(), rests, is_door_open(of.config, ports)));
    let shows_machine = of.own.report_mask & 1 != 0;
    add!(line, "|{}:", if shows_machine { "MPos" } else { "WPos" });
    add_point(&mut line, of, &if shows_machine { place } else { of.program.modal().work(&place) });
    if of.own.report_mask & 2 != 0 {
        add!(line, "|Bf:{room},{}", of.room);
    }
    if let Some(number) = of.line {
        add!(line, "|Ln:{number}");
    }
    let feed = speed.per_minute() / if of.own.inches { MM_PER_INCH } else { 1.0 };
    let power = of.program.modal().power;
    let speed =
        if program::laser::of(of.program).is_some() { power } else { of.outputs.spindle_speed(of.config, power) };
    add!(line, "|FS:{feed:.0},{speed:.0}");
    add_pins(&mut line, of, ports);
    if told.wants_all {
        (told.offsets_in, told.overrides_in) = (0, 0);
    }
    add_seldom(&mut line, of, &place, overrides, told);
    if of.config.general.grblhal {
        let [homed, can_home] = of.homed;
        hal::add_fields(&mut line, hal::extra(of.program, homed), can_home, of.job, told);
    }
    reply.say(format_args!("{line}>\n"));
}

fn is_door_open(config: &MachineConfig, ports: &impl Inputs) -> bool {
    config.safety_door.enable && ports.inputs().is_active(Input::Door)
}

/// Returns the sub-state of a hold or an open door: 0 at rest and ready to go on; else still braking, or at
/// rest with the door open.
const fn sub_state(state: State, rests: bool, is_open: bool) -> &'static str {
    match (state, rests) {
        (State::Door, true) if is_open => ":1",
        (State::Hold | State::Door, true) => ":0",
        (State::Hold, false) => ":1",
        (State::Door, false) => ":2",
        _ => "",
    }
}

fn add_point(line: &mut Line, of: &Report<'_>, place: &PerAxis<f64>) {
    for (index, axis) in Axis::PRIMARY.into_iter().chain(free_axes(of.config, of.program.tools())).enumerate() {
        let length = Length { mm: place[axis], inches: of.own.inches };
        add!(*line, "{}{length}", if index == 0 { "" } else { "," });
    }
}

/// Adds triggered inputs: the axes of limit switches, `P` the probe; `D` while the door is open.
fn add_pins(line: &mut Line, of: &Report<'_>, ports: &impl Inputs) {
    let levels = ports.inputs();
    let is_hit = |axis: Axis| {
        let stops = (0..).zip(&of.config.endstops).filter(|(_, stop)| stop.pin.is_some() && stop.axis == Some(axis));
        stops.into_iter().any(|(index, _)| levels.is_active(Input::Endstop(index)))
    };
    let mut pins = heapless::String::<8>::new();
    // At most seven letters fit.
    Axis::PRIMARY.into_iter().filter(|axis| is_hit(*axis)).for_each(|axis| drop(pins.push(axis.letter())));
    if of.config.probe.enable && of.config.probe.pin.is_some() && of.tuning.probe_touches(levels) {
        let _ = pins.push('P');
    }
    if of.mode.state() == State::Door || is_door_open(of.config, ports) {
        let _ = pins.push('D');
    }
    if !pins.is_empty() {
        add!(*line, "|Pn:{pins}");
    }
}

fn add_seldom(line: &mut Line, of: &Report<'_>, here: &PerAxis<f64>, overrides: Overrides, told: &mut Told) {
    let modal = of.program.modal();
    let mut offsets = Axis::PRIMARY.map(|axis| modal.offset(axis));
    if modal.rotations.any() {
        // In a rotated coordinate system the offsets differ from place to place.
        let work = modal.work(here);
        offsets = Axis::PRIMARY.map(|axis| here[axis] - work[axis]);
    }
    if told.offsets != offsets {
        told.offsets_in = 0;
    }
    if told.overrides != overrides {
        told.overrides_in = 0;
    }
    if told.offsets_in == 0 {
        told.offsets_in = if of.is_busy() { 30 } else { 10 };
        told.offsets = offsets;
        let mut place = PerAxis([0.0; units::MAX_AXES]);
        Axis::PRIMARY.into_iter().zip(offsets).for_each(|(axis, offset)| place[axis] = offset);
        add!(*line, "|WCO:");
        add_point(line, of, &place);
        // Only offsets or overrides at a time, so that the line stays short.
        told.overrides_in = if told.wants_all { 0 } else { told.overrides_in.max(1) };
    }
    told.offsets_in -= 1;
    if told.overrides_in == 0 {
        told.overrides_in = if of.is_busy() { 20 } else { 10 };
        told.overrides = overrides;
        let [feed, rapid, spindle] = overrides.percents;
        add!(*line, "|Ov:{feed:.0},{rapid:.0},{spindle:.0}");
        if overrides.accessories != 0 {
            add!(*line, "|A:");
            let letters = ['S', 'C', 'F', 'M'].into_iter().enumerate();
            for (_, letter) in letters.filter(|(bit, _)| overrides.accessories & 1 << bit != 0) {
                add!(*line, "{letter}");
            }
        }
    }
    told.overrides_in -= 1;
}
