//! What the machine says about itself: `?`, `$G`, `$#`, M114, M115, M119.

use core::fmt::Write;

use units::{Actuator, Axis, PerAxis};

use crate::console::Target;
use crate::controller::Controller;
use crate::failure::{Answer, Outcome};
use crate::modal::{COORDINATE_SYSTEMS, MotionMode, write_system_name};
use crate::ports::{Input, Ports};
use crate::state::State;

/// A status report: positions, rates and eight heaters.
type Line = heapless::String<512>;

/// Formats onto a line; what does not fit is cut at its end.
macro_rules! add {
    ($line:expr, $($format:tt)*) => {{
        // See the macro's comment: a cut line is still a line.
        let _ = write!($line, $($format)*);
    }};
}

impl<P: Ports> Controller<P> {
    /// `<State|MPos:x,y,z|WPos:x,y,z|F:...|S:...>`
    pub(crate) fn report_status(&mut self, target: Target) {
        let live = matches!(self.state, State::Run | State::Home | State::Hold { .. });
        let machine = if live { self.live_position() } else { self.position };
        let work = self.modal.work(&machine);
        let mut line = Line::new();
        add!(line, "<{}|MPos:", self.state.name());
        self.add_xyz(&mut line, &machine);
        for axis in [Axis::A, Axis::B, Axis::C].into_iter().filter(|axis| self.has_axis(*axis)) {
            add!(line, ",{:.4}", machine[axis]);
        }
        add!(line, "|WPos:");
        self.add_xyz(&mut line, &work);
        self.add_rates(&mut line, live);
        if !self.config.general.grbl_mode {
            self.add_temperatures(&mut line);
        }
        if let Some((seconds, percent)) = self.player.progress(self.ports.now()) {
            add!(line, "|SD:{seconds},{percent}");
        }
        self.consoles.write(target, format_args!("{line}>\n"));
    }

    fn add_xyz(&self, line: &mut Line, position: &PerAxis<f64>) {
        let [x, y, z] = [Axis::X, Axis::Y, Axis::Z].map(|axis| self.modal.in_program_units(position[axis]));
        add!(line, "{x:.4},{y:.4},{z:.4}");
    }

    fn add_rates(&mut self, line: &mut Line, live: bool) {
        let requested = match self.modal.motion {
            MotionMode::Rapid => self.modal.seek_rate,
            _ => self.modal.feed_rate,
        };
        let (current, percent) = self.ports.motion(|motion| (motion.speed(), motion.overrides().feed * 100.0));
        let unit = |rate: units::MmPerSecond| self.modal.in_program_units(rate.per_minute());
        if live {
            add!(line, "|F:{:.1},{:.1},{percent:.1}|S:{:.4}", unit(current), unit(requested), self.modal.power);
        } else {
            add!(line, "|F:{:.1},{percent:.1}|S:{:.2}", unit(requested), self.modal.power);
        }
    }

    fn add_temperatures(&mut self, line: &mut Line) {
        let Self { ports, config, .. } = self;
        ports.heat(|heat| {
            for ((_, controller), (_, heater)) in config.heaters().zip(heat.heaters()) {
                let reading = heater.reading().map_or(-100.0, |celsius| celsius.0);
                add!(line, "|{}:{reading:.1},{:.1}", controller.designator, heater.target().0);
            }
        });
    }

    fn has_axis(&self, axis: Axis) -> bool {
        let motor = Actuator::from_index(axis as usize).map(|motor| &self.config.actuators[motor]);
        motor.is_some_and(|motor| motor.present && motor.slaved_to.is_none())
    }

    /// Where the motors are at this moment.
    pub(crate) fn live_position(&mut self) -> PerAxis<f64> {
        self.ports.motion(|motion| motion.live_position())
    }

    /// `[GC:G0 G54 G17 G21 G90 G94 G61 M0 M5 M9 T0 F4000.0000 S0.0000]`
    pub(crate) fn report_modal(&mut self, target: Target) {
        let modal = &self.modal;
        let spindle = self.config.switches.iter().position(|switch| switch.name == "spindle");
        let spindle_on = spindle.is_some_and(|index| self.switches.is_on(index));
        let mut system = heapless::String::<8>::new();
        // Eight characters hold every name.
        let _ = write_system_name(&mut system, modal.system);
        let plane = match modal.plane {
            motion::geometry::Plane::Xy => 17,
            motion::geometry::Plane::Xz => 18,
            motion::geometry::Plane::Yz => 19,
        };
        let requested = if modal.motion == MotionMode::Rapid { modal.seek_rate } else { modal.feed_rate };
        let (motion, path, units) = (modal.motion.code(), modal.path.code(), if modal.inches { 20 } else { 21 });
        let (distance, spindle) = (if modal.absolute { 90 } else { 91 }, if spindle_on { 3 } else { 5 });
        let (feed, power, tool) = (modal.in_program_units(requested.per_minute()), modal.power, self.tools.active_id());
        self.consoles.write(
            target,
            format_args!(
                "[GC:{motion} {system} G{plane} G{units} G{distance} G94 {path} M0 M{spindle} M9 T{tool} F{feed:.4} S{power:.4}]\n"
            ),
        );
    }

    /// `$#`: every offset.
    pub(crate) async fn report_offsets(&mut self, verbose: bool) {
        let mut name = heapless::String::<8>::new();
        if verbose {
            let _ = write_system_name(&mut name, self.modal.system);
            self.say(format_args!("[current WCS: {name}]\n"));
        }
        for system in 0..COORDINATE_SYSTEMS {
            name.clear();
            let _ = write_system_name(&mut name, system);
            let offsets = self.modal.systems.get(system).copied().unwrap_or_default();
            self.say_offsets(&name, offsets);
        }
        let park = self.park_position;
        self.say_offsets("G28", [park.x, park.y, park.z.unwrap_or(0.0)]);
        self.say_offsets("G30", [0.0; 3]);
        self.say_offsets("G92", self.modal.g92);
        let [x, y, z] = self.modal.tool_offset.map(|mm| self.modal.in_program_units(mm));
        if verbose {
            self.say(format_args!("[Tool Offset:{x:.4},{y:.4},{z:.4}]\n"));
        } else {
            self.say(format_args!("[TLO:{z:.4}]\n"));
        }
        let ([x, y, z], found) = self.probing.last;
        self.say(format_args!("[PRB:{x:.4},{y:.4},{z:.4}:{}]\n", u8::from(found)));
        self.drain().await;
    }

    fn say_offsets(&mut self, name: &str, offsets: [f64; 3]) {
        let [x, y, z] = offsets.map(|mm| self.modal.in_program_units(mm));
        self.say(format_args!("[{name}:{x:.4},{y:.4},{z:.4}]\n"));
    }

    /// M114 and its subcodes.
    pub(crate) fn report_position(&mut self, subcode: u8) -> Outcome {
        let live = self.live_position();
        let (label, position, in_units) = match subcode {
            0 => ("C", self.modal.work(&self.position), true),
            1 => ("WCS", self.modal.work(&live), true),
            2 => ("MCS", live, false),
            3 => ("APOS", self.motor_position(&live), false),
            4 => ("MP", self.position, false),
            5 => ("CMP", self.compensated(), false),
            _ => return Ok(Answer::Unknown),
        };
        let unit = |mm: f64| if in_units { self.modal.in_program_units(mm) } else { mm };
        let mut line = Line::new();
        add!(
            line,
            "{label}: X:{:.4} Y:{:.4} Z:{:.4}",
            unit(position[Axis::X]),
            unit(position[Axis::Y]),
            unit(position[Axis::Z])
        );
        if matches!(subcode, 2..=4) {
            for axis in
                [Axis::A, Axis::B, Axis::C].into_iter().filter(|axis| self.has_axis(*axis) && !self.tools.uses(*axis))
            {
                add!(line, " {}:{:.4}", axis.letter(), position[axis]);
            }
        }
        if let Some(tool) = self.tools.active().filter(|_| matches!(subcode, 0 | 1 | 3)) {
            add!(line, " E:{:.4} ", tool.e);
        }
        self.say(format_args!("ok {line}\n"));
        Ok(Answer::Said)
    }

    /// The commanded position after levelling and skew.
    fn compensated(&mut self) -> PerAxis<f64> {
        let position = self.position;
        self.ports.motion(|motion| motion.compensation().motors(&position))
    }

    /// Motor positions in mm, dressed as a position.
    fn motor_position(&mut self, machine: &PerAxis<f64>) -> PerAxis<f64> {
        let motors = self.ports.motion(|motion| {
            let place = motion.compensation().motors(machine);
            motion.config().map(|config| config.kinematics.actuators(&place))
        });
        motors.map_or(*machine, |motors| PerAxis(motors.0))
    }

    /// M115.
    pub(crate) fn report_firmware(&mut self) -> Outcome {
        let board = self.ports.board();
        let axes = self.config.actuators().count();
        let grbl = u8::from(self.config.general.grbl_mode);
        self.say(format_args!(
            "FIRMWARE_NAME:Velvet, FIRMWARE_VERSION:{}, PROTOCOL_VERSION:1.0, X-FIRMWARE_BUILD_DATE:{}, X-SYSTEM_CLOCK:{}MHz, \
             X-AXES:{axes}, X-PAXIS:3, X-GRBL_MODE:{grbl}, X-ARCS:1\n",
            board.version, board.build_date, board.core_mhz
        ));
        Ok(Answer::Ok)
    }

    /// M119: `X_min:0 Y_min:0 pins- (X:H:L)PD0^:0 `
    pub(crate) fn report_endstops(&mut self) -> Outcome {
        use config::HomingDirection;
        let levels = self.ports.inputs();
        let mut line = Line::new();
        let stops = || self.config.endstops.iter().enumerate().filter(|(_, stop)| stop.pin.is_some());
        for (index, stop) in stops() {
            let Some(axis) = stop.axis else { continue };
            let end = match stop.homing_direction {
                HomingDirection::ToMin => "min",
                HomingDirection::ToMax => "max",
                HomingDirection::None => "limit",
            };
            add!(line, "{}_{end}:{} ", axis.letter(), u8::from(levels.is_active(Input::Endstop(index as u8))));
        }
        add!(line, "pins- ");
        for (index, stop) in stops() {
            let Some((axis, pin)) = stop.axis.zip(stop.pin) else { continue };
            let homes = if stop.homing_direction == HomingDirection::None { "" } else { ":H" };
            let limits = if stop.limit_enable { ":L" } else { "" };
            let level = u8::from(levels.is_active(Input::Endstop(index as u8)));
            add!(line, "({}{homes}{limits}){pin}:{level} ", axis.letter());
        }
        if let Some(pin) = self.config.probe.pin.filter(|_| self.config.probe.enable) {
            add!(line, "(Probe){pin}:{} ", u8::from(self.probe_touches()));
        }
        self.say(format_args!("{line}\n"));
        Ok(Answer::Ok)
    }
}
