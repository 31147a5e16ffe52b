//! The lines that M500 saves and M503 shows: settings as G-code, with a comment before each.
//!
//! Lines, order and decimals are those of Smoothieware v2, so that either firmware reads the other's file. A
//! value that needs more decimals to come back as it was gets them.

use core::fmt::{self, Write};

use base::bed::Bed;
use base::motors::{write_choppers, write_currents, write_stall_thresholds, write_stealth_thresholds};
use base::ports::{HeatPort, MotionPort};
use base::saved_value::Value;
use base::tuning::Tuning;
use config::{FilamentDetectorConfig, MachineConfig};
use motion::MotionConfig;
use parts::heat_codes::write_sensor;
use parts::motion_codes::advance_of;
use parts::z_thermal::Thermal;
use procedures::arms::{write_arms, write_homing};
use procedures::leveling::write_leveling;
use procedures::probing::write_probe;
use program::{Interpreter, ParkPosition, Tool, write_system_name};
use thermal::LawSettings;
use units::{Actuator, Axis};

/// Text of one part's lines.
pub type Text = heapless::String<1_408>;
/// Number of parts of the settings.
pub const PARTS: u8 = 8;

/// Returns the lines of part n of [`PARTS`].
///
/// # Errors
/// When the lines do not fit whole: half a line would be another setting.
pub(crate) fn part(
    n: u8,
    ports: &mut (impl MotionPort + HeatPort),
    program: &Interpreter,
    config: &MachineConfig,
    (tuning, thermal): (&Tuning, &Thermal),
    bed: &Bed,
) -> Result<Text, fmt::Error> {
    let mut text = Text::new();
    let motion = ports.motion(|motion| motion.config().copied());
    match n {
        0 => motion.map_or(Ok(()), |motion| write_motion(&mut text, &motion, program, config)),
        1 => motion.map_or(Ok(()), |motion| write_arms(&mut text, &motion, tuning, config)),
        2 => write_offsets(&mut text, program, config),
        3 => motion
            .map_or(Ok(()), |motion| write_extruders(&mut text, &motion, program, config))
            .and_then(|()| write_filament(&mut text, tuning, config)),
        4 => write_heaters(&mut text, ports, config, tuning),
        5 => write_homing(&mut text, tuning, config)
            .and_then(|()| procedures::endstop_phase::write(&mut text, tuning, config)),
        6 => write_probe(&mut text, config, tuning)
            .and_then(|()| write_leveling(&mut text, ports, config, bed))
            .and_then(|()| thermal.write(&mut text, config)),
        _ => write_currents(&mut text, tuning, config)
            .and_then(|()| write_stall_thresholds(&mut text, tuning))
            .and_then(|()| write_stealth_thresholds(&mut text, tuning))
            .and_then(|()| write_choppers(&mut text, tuning))
            .and_then(|()| write_laser(&mut text, tuning, program)),
    }?;
    Ok(text)
}

/// Returns the motors that are not an extruder's; settings of an extruder's go by its tool.
fn axis_motors<'a>(program: &'a Interpreter, config: &'a MachineConfig) -> impl Iterator<Item = (Axis, Actuator)> + 'a {
    let motors = Axis::ALL.into_iter().zip(Actuator::ALL);
    motors.filter(|(axis, motor)| config.actuators[*motor].present && !program.tools().uses(*axis))
}

fn write_motion(text: &mut Text, motion: &MotionConfig, program: &Interpreter, config: &MachineConfig) -> fmt::Result {
    let limits = &motion.limits;
    write!(text, ";Steps per unit:\nM92")?;
    for (axis, motor) in axis_motors(program, config) {
        if let Some(actuator) = motion.actuators[motor] {
            write!(text, " {}{}", axis.letter(), Value(actuator.steps_per_mm, 5))?;
        }
    }
    write!(text, "\n;Acceleration mm/s^2:\nM204 S{}", Value(limits.acceleration.0, 5))?;
    for (axis, motor) in axis_motors(program, config) {
        if let Some(own) = limits.actuator_acceleration[motor] {
            write!(text, " {}{}", axis.letter(), Value(own.0, 5))?;
        }
    }
    write!(text, "\n;Junction deviation mm, of Z alone, least speed mm/s:\nM205")?;
    // X is left out beside a square corner velocity, which reading X back would cancel.
    if limits.square_corner_velocity.is_none() {
        write!(text, " X{}", Value(limits.junction_deviation.0, 5))?;
    }
    let z_deviation = limits.z_junction_deviation.map_or(-1.0, |deviation| deviation.0);
    write!(text, " Z{} S{}", Value(z_deviation, 5), Value(limits.minimum_speed.0, 5))?;
    write!(text, "\n;Max speeds in mm/s:\nM203")?;
    for (axis, speed) in Axis::PRIMARY.into_iter().zip(limits.axis_speed) {
        write!(text, " {}{}", axis.letter(), Value(speed.map_or(0.0, |speed| speed.0), 5))?;
    }
    // Smoothieware's rate has single precision, and so has its text.
    write!(text, " S{:.5}", program.modal().seek_rate.0 as f32)?;
    // A missing limit is saved only where the configuration has a limit.
    if limits.max_speed.is_some() || config.motion.max_speed.is_some() {
        write!(text, " P{}", Value(limits.max_speed.map_or(0.0, |speed| speed.0), 5))?;
    }
    write!(text, "\n;Max actuator speeds in mm/s:\nM203.1")?;
    for (axis, motor) in axis_motors(program, config) {
        write!(text, " {}{}", axis.letter(), Value(limits.actuator_rate[motor].0, 5))?;
    }
    writeln!(text)
}

fn write_laser(text: &mut Text, tuning: &Tuning, program: &Interpreter) -> fmt::Result {
    let Some(laser) = program::laser::of(program) else { return Ok(()) };
    let (scale, mode) = (tuning.laser, u8::from(laser.is_laser_mode));
    writeln!(text, ";Laser:\nM452 R{} L{} S{mode}", scale.most_s, scale.least_s)
}

/// Writes coordinate systems with `save_wcs`, the G92 offset with `save_g92`, and the park position.
fn write_offsets(text: &mut Text, program: &Interpreter, config: &MachineConfig) -> fmt::Result {
    let modal = program.modal();
    if !config.motion.save_wcs {
        writeln!(text, ";WCS settings are not saved")?;
    } else {
        writeln!(text, ";WCS settings")?;
        write_system_name(text, modal.system)?;
        writeln!(text)?;
        for (index, [x, y, z]) in modal.systems.into_iter().enumerate() {
            let turned = modal.rotations.of(index);
            if [x, y, z] != [0.0; 3] || turned != 0.0 {
                let [x, y, z] = [x, y, z].map(|mm| Value(mm, 6));
                write!(text, "G10 L2 P{} X{x} Y{y} Z{z}", index + 1)?;
                if turned != 0.0 {
                    write!(text, " R{}", Value(turned, 6))?;
                }
                write!(text, " ; ")?;
                write_system_name(text, index)?;
                writeln!(text)?;
            }
        }
    }
    if config.motion.save_g92 && modal.g92 != [0.0; 3] {
        let [x, y, z] = modal.g92.map(|mm| Value(mm, 6));
        writeln!(text, "G92.3 X{x} Y{y} Z{z}")?;
    }
    let park = Some(program.park()).filter(|park| **park != ParkPosition::default());
    write_park_position(text, "G28.1", park)?;
    write_park_position(text, "G30.1", program.second_park())
}

fn write_park_position(text: &mut Text, code: &str, park: Option<&ParkPosition>) -> fmt::Result {
    let Some(park) = park else { return Ok(()) };
    write!(text, ";Park position:\n{code} X{} Y{}", Value(park.x, 4), Value(park.y, 4))?;
    if let Some(z) = park.z {
        write!(text, " Z{}", Value(z, 4))?;
    }
    writeln!(text)
}

fn write_extruders(
    text: &mut Text,
    motion: &MotionConfig,
    program: &Interpreter,
    config: &MachineConfig,
) -> fmt::Result {
    program.tools().all().iter().try_for_each(|tool| write_extruder(text, motion, tool, config))
}

/// Writes the settings that M404 and M603 have changed; nothing where they are as configured.
fn write_filament(text: &mut Text, tuning: &Tuning, config: &MachineConfig) -> fmt::Result {
    let (now, configured) = (&tuning.filament, &config.filament_detector);
    let of =
        |detector: &FilamentDetectorConfig| (detector.check_every, detector.pulses_per_mm, detector.leave_heaters_on);
    if of(now) != of(configured) {
        let (seconds, heaters) = (now.check_every.0 as f64 / 1e6, u8::from(now.leave_heaters_on));
        writeln!(text, ";Filament detector:\nM404 S{} P{} H{heaters}", Value(seconds, 1), Value(now.pulses_per_mm, 4))?;
    }
    let (now, configured) = (&tuning.filament_width, &config.filament_width);
    if now.nominal != configured.nominal {
        writeln!(text, ";Filament diameter (nominal):\nM404 W{}", Value(now.nominal.0, 4))?;
    }
    if now.delay != configured.delay {
        writeln!(text, ";Filament from the width sensor to the nozzle (cm):\nM406 D{}", Value(now.delay.0 / 10.0, 4))?;
    }
    let (now, configured) = (&tuning.filament_change, &config.filament_change);
    if (now.load, now.unload) != (configured.load, configured.unload) {
        writeln!(text, ";Filament change:\nM603 L{} U{}", Value(now.load.0, 4), Value(now.unload.0, 4))?;
    }
    Ok(())
}

fn write_extruder(text: &mut Text, motion: &MotionConfig, tool: &Tool, config: &MachineConfig) -> fmt::Result {
    let (settings, id) = (&tool.settings, tool.settings.id);
    let motor = Actuator::from_index(settings.axis as usize);
    if let Some(steps) = motor.and_then(|motor| motion.actuators[motor]).map(|motor| motor.steps_per_mm) {
        writeln!(text, ";E steps per mm:\nM92 E{} P{id}", Value(steps, 4))?;
    }
    writeln!(text, ";E filament diameter:\nM200 D{} P{id}", Value(settings.filament_diameter.unwrap_or(0.0), 4))?;
    writeln!(
        text,
        ";E retract length, feedrate, zlift length, feedrate:\nM207 S{} F{} Z{} Q{} P{id}",
        Value(settings.retract_length, 4),
        Value(settings.retract_rate.per_minute(), 4),
        Value(settings.z_lift, 4),
        Value(settings.z_lift_rate.per_minute(), 4)
    )?;
    writeln!(
        text,
        ";E retract recover length, feedrate:\nM208 S{} F{} P{id}",
        Value(settings.recover_length, 4),
        Value(settings.recover_rate.per_minute(), 4)
    )?;
    if let Some(own) = motor.and_then(|motor| motion.limits.actuator_acceleration[motor]) {
        writeln!(text, ";E acceleration mm/s^2:\nM204 E{} P{id}", Value(own.0, 4))?;
    }
    if let Some(rate) = motor.map(|motor| motion.limits.actuator_rate[motor]) {
        writeln!(text, ";E max speed mm/s:\nM203 E{} P{id}", Value(rate.0, 4))?;
    }
    if let Some(most) = settings.flow_limit {
        writeln!(text, ";E max flow mm3/s:\nM203 V{} P{id}", Value(most, 4))?;
    }
    let advance = motion.filters.advance.get(advance_of(settings.axis)).copied().flatten();
    let configured = config.extruders.iter().find(|extruder| extruder.tool.id == id);
    let has_configured = configured.is_some_and(|extruder| extruder.pressure_advance_s > 0.0);
    // Zero is saved only where the configuration has another value.
    if let Some(advance) = advance.filter(|advance| advance.factor > 0.0 || has_configured) {
        writeln!(text, ";Pressure advance (s):\nM900 K{} P{id}", Value(advance.factor, 5))?;
    }
    Ok(())
}

fn write_heaters(text: &mut Text, ports: &mut impl HeatPort, config: &MachineConfig, tuning: &Tuning) -> fmt::Result {
    ports.heat(|heat| {
        for (id, controller) in config.heaters() {
            let tool_id = controller.tool_id;
            let Some(settings) = heat.heater(id).map(|heater| &heater.settings).filter(|settings| settings.heats)
            else {
                continue;
            };
            if let LawSettings::Pid(g) = settings.law {
                let [p, i, d, i_max] = [g.p, g.i, g.d, g.i_max].map(|gain| Value(f64::from(gain), 4));
                let (duty, on_measurement) = (settings.max_duty.0, u8::from(g.on_measurement));
                writeln!(
                    text,
                    ";PID settings, i_max, max_pwm, PonM:\nM301 S{tool_id} P{p} I{i} D{d} X{i_max} Y{duty} Z{on_measurement}"
                )?;
            }
            if let LawSettings::Model(model) = settings.law {
                let figures = [model.power_w, model.capacity, model.loss, model.fan_loss, model.late_s, model.filament_heat];
                write!(text, ";Model of the heater (W, J/K, W/K, W/K, s, J/mm3/K):\nM307 S{tool_id}")?;
                for (letter, figure) in ['P', 'C', 'K', 'F', 'D', 'H'].into_iter().zip(figures) {
                    write!(text, " {letter}{}", Value(f64::from(figure), 4))?;
                }
                writeln!(text)?;
            }
            let max = Value(f64::from(settings.max.0), 4);
            writeln!(text, ";Max temperature setting:\nM143 S{tool_id} P{max}")?;
            write_sensor(text, controller, id, tuning)?;
        }
        Ok(())
    })
}
