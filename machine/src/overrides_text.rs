//! The lines that M500 saves and M503 shows: settings as G-code, with a comment before each.

use core::fmt::Write;

use units::{Actuator, Axis};

use crate::controller::Controller;
use crate::heat::LawSettings;
use crate::ports::Ports;
use crate::tuning::advance_of;

/// The lines of one part of the machine.
pub type Text = heapless::String<1_408>;
/// How many parts there are.
pub const PARTS: u8 = 8;

impl<P: Ports> Controller<P> {
    /// The lines of part n of [`PARTS`]. Full texts are an error, not a cut: half a line would be another setting.
    pub(crate) fn override_part(&mut self, part: u8) -> Result<Text, core::fmt::Error> {
        let mut text = Text::new();
        match part {
            0 => self.write_motion(&mut text),
            1 => self.write_arms(&mut text),
            2 => self.write_extruders(&mut text),
            3 => self.write_heaters(&mut text),
            4 => self.write_currents(&mut text),
            5 => self.write_probe(&mut text),
            6 => self.write_levelling(&mut text),
            _ => self.write_offsets(&mut text),
        }?;
        Ok(text)
    }

    fn write_extruders(&mut self, text: &mut Text) -> core::fmt::Result {
        let filters = self.ports.motion(|motion| motion.config().map(|config| config.filters)).unwrap_or_default();
        for tool in self.tools.all() {
            let settings = &tool.settings;
            let id = settings.tool_id;
            let diameter = settings.filament_diameter.map_or(0.0, |diameter| diameter.0);
            writeln!(text, ";E Filament diameter:\nM200 D{diameter:.4} P{id}")?;
            writeln!(
                text,
                ";E retract length, feedrate, zlift length, feedrate:\nM207 S{:.4} F{:.4} Z{:.4} Q{:.4} P{id}",
                settings.retract_length.0,
                settings.retract_rate.per_minute(),
                settings.z_lift.0,
                settings.z_lift_rate.per_minute()
            )?;
            writeln!(
                text,
                ";E retract recover length, feedrate:\nM208 S{:.4} F{:.4} P{id}",
                settings.recover_length.0,
                settings.recover_rate.per_minute()
            )?;
            let advance = filters.advance.get(advance_of(tool.axis)).copied().flatten();
            // Zero is worth saving where the configuration says something else.
            if let Some(advance) = advance.filter(|a| a.factor > 0.0 || settings.pressure_advance_s > 0.0) {
                writeln!(text, ";Pressure advance (s):\nM900 K{:.5} P{id}", advance.factor)?;
            }
        }
        Ok(())
    }

    fn write_motion(&mut self, text: &mut Text) -> core::fmt::Result {
        let Some(config) = self.ports.motion(|motion| motion.config().copied()) else { return Ok(()) };
        let fitted = || Axis::ALL.into_iter().zip(Actuator::ALL);
        write!(text, ";Steps per unit:\nM92")?;
        for (axis, motor) in fitted() {
            if let Some(actuator) = config.actuators[motor] {
                write!(text, " {}{:.5}", axis.letter(), actuator.steps_per_mm)?;
            }
        }
        let limits = config.limits;
        write!(text, "\n;Acceleration mm/s^2:\nM204 S{:.5}", limits.acceleration.0)?;
        for (axis, motor) in fitted() {
            if let Some(own) = limits.actuator_acceleration[motor] {
                write!(text, " {}{:.5}", axis.letter(), own.0)?;
            }
        }
        write!(text, "\n;Junction deviation:\nM205")?;
        // An X would set the square corner velocity aside.
        if limits.square_corner_velocity.is_none() {
            write!(text, " X{:.5}", limits.junction_deviation.0)?;
        }
        let z_deviation = limits.z_junction_deviation.map_or(-1.0, |deviation| deviation.0);
        write!(text, " Z{z_deviation:.5} S{:.5}\n;Max speeds in mm/s:\nM203", limits.minimum_speed.0)?;
        for (axis, speed) in Axis::PRIMARY.into_iter().zip(limits.axis_speed) {
            write!(text, " {}{:.5}", axis.letter(), speed.map_or(0.0, |speed| speed.0))?;
        }
        write!(text, " P{:.5}", limits.max_speed.map_or(0.0, |speed| speed.0))?;
        if self.config.motion.compliant_seek_rate {
            write!(text, " S{:.5}", self.modal.seek_rate.0)?;
        }
        write!(text, "\n;Max actuator speeds in mm/s:\nM203.1")?;
        for (axis, motor) in fitted().filter(|(_, motor)| config.actuators[*motor].is_some()) {
            write!(text, " {}{:.5}", axis.letter(), limits.actuator_rate[motor].0)?;
        }
        writeln!(text)
    }

    /// Homing offsets; coordinate systems with `save_wcs`, the G92 offset with `save_g92`.
    fn write_offsets(&mut self, text: &mut Text) -> core::fmt::Result {
        let [x, y, z] = Axis::PRIMARY.map(|axis| self.home_offset[axis]);
        if [x, y, z] != [0.0; 3] {
            writeln!(text, ";Home offset (mm):\nM206 X{x:.4} Y{y:.4} Z{z:.4}")?;
        }
        if !self.config.motion.save_wcs {
            writeln!(text, ";WCS settings are not saved")?;
        } else {
            writeln!(text, ";WCS settings")?;
            for (index, [x, y, z]) in self.modal.systems.into_iter().enumerate() {
                if [x, y, z] != [0.0; 3] {
                    writeln!(text, "G10 L2 P{} X{x:.4} Y{y:.4} Z{z:.4}", index + 1)?;
                }
            }
            crate::modal::write_system_name(text, self.modal.system)?;
            writeln!(text)?;
        }
        let [x, y, z] = self.modal.g92;
        if self.config.motion.save_g92 && [x, y, z] != [0.0; 3] {
            writeln!(text, ";G92 offset:\nG92.3 X{x:.4} Y{y:.4} Z{z:.4}")?;
        }
        Ok(())
    }

    fn write_heaters(&mut self, text: &mut Text) -> core::fmt::Result {
        self.ports.heat(|heat| {
            for (index, heater) in heat.heaters().iter().enumerate().filter(|(_, heater)| heater.settings.heats) {
                let settings = &heater.settings;
                if let LawSettings::Pid(g) = settings.law {
                    writeln!(
                        text,
                        ";PID settings:\nM301 S{index} P{:.4} I{:.4} D{:.4} X{:.4} Y{} Z{}",
                        g.p,
                        g.i,
                        g.d,
                        g.i_max,
                        settings.max_duty.0,
                        u8::from(g.on_measurement)
                    )?;
                }
                writeln!(text, ";Max temperature setting:\nM143 S{index} P{:.4}", settings.max.0)?;
            }
            Ok(())
        })
    }

    fn write_currents(&mut self, text: &mut Text) -> core::fmt::Result {
        let mut any = false;
        for (axis, motor) in Axis::ALL.into_iter().zip(Actuator::ALL) {
            let actuator = &self.config.actuators[motor];
            if let Some(amps) = actuator.current.filter(|_| actuator.present) {
                write!(text, "{} {}{:.5}", if any { "" } else { ";Motor currents:\nM907" }, axis.letter(), amps.0)?;
                any = true;
            }
        }
        if any { writeln!(text) } else { Ok(()) }
    }
}
