//! Machines with towers and arms: their geometry (M665), their trims (M666), and where they home (M206,
//! G28.6).

pub mod words;

use core::fmt;

use base::CodeContext;
use base::axes::Axes;
use base::failure::{Answer, Failure, Outcome};
use base::ports::MotionPort;
use base::saved_value::Value;
use base::sessions::Reply;
use base::tuning::Tuning;
use config::MachineConfig;
use motion::{Kinematics, MotionConfig};
use program::Words;
use units::{Axis, AxisSet, PerAxis};

use base::hands::Hands;
use words::{homes_by_tool, set_arm_tuning, set_arms};

/// Returns whether X, Y and Z home together, motor by motor.
pub const fn homes_by_motor(config: &MachineConfig) -> bool {
    let homing = &config.homing;
    homing.delta || homing.rotary_delta || homing.scara
}

/// Returns whether the machine is a linear delta, with three towers.
pub fn is_linear_delta(config: &MachineConfig) -> bool {
    config.motion.arm_solution == config::ArmSolution::LinearDelta
}

/// Returns the place of the tool of a linear delta with every carriage at its end stop and no trims, mm.
pub fn delta_home(config: &MachineConfig, tuning: &Tuning) -> PerAxis<f64> {
    // A linear delta with all carriages at the top has its tool in the middle.
    let mut place = PerAxis([0.0; units::MAX_AXES]);
    place[Axis::Z] = tuning.homing_position(config, Axis::Z) + tuning.home_offset()[Axis::Z];
    place
}

/// M665: parameters of the arms, Z of the homing position, S and U for cutting lines.
///
/// # Errors
/// When motion refuses the geometry, or the machine halts.
pub fn arm_settings<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Result<(), Failure> {
    hands.standstill()?;
    let (texts, config) = (hands.texts(), hands.config());
    hands.motion(|motion| set_arms(texts, motion, words))?;
    set_arm_tuning(hands.tuning(), config, words);
    report_arms(hands, config, words);
    Ok(())
}

/// Prints the parameters of the arms, and the settings of line segmentation that the words have changed.
fn report_arms<'c>(hands: &mut impl Hands<'c>, config: &MachineConfig, words: &Words<'_>) {
    let Ok(motion_config) = hands.motion_config() else { return };
    let mut any = false;
    for (letter, value) in motion_config.kinematics.parameters().iter() {
        // Parameters of a single tower are printed where they differ from the drawing's (zero).
        if value != 0.0 || "LR".contains(letter) {
            hands.say(format_args!("{letter}: {value:8.4} "));
            any = true;
        }
    }
    if homes_by_tool(config) {
        let height = hands.tuning().home_z();
        hands.say(format_args!("Max Z: {height:8.3} "));
        any = true;
    }
    if any {
        hands.say(format_args!("\n"));
    }
    let lines = hands.tuning().lines;
    if words.has('S') {
        let rate = lines.segments_per_second.unwrap_or(0.0);
        hands.say(format_args!("Delta segments set to {rate:6.4} segs/sec\n"));
    } else if words.has('U') {
        let length = lines.segment_length.unwrap_or(0.0);
        hands.say(format_args!("mm per line segment set to {length:8.4}\n"));
    }
}

/// G28.4: sets the positions of the motors of X, Y and Z, mm. Allowed only while idle.
///
/// # Errors
/// When motion is not configured.
pub fn motor_positions(CodeContext { texts, ports, words, .. }: CodeContext<'_, impl MotionPort>) -> Outcome {
    let config = ports.motion(|motion| motion.config().copied());
    let kinematics = config.ok_or_else(|| Failure::refused(&"motion is not configured"))?.kinematics;
    let set = ports.motion(|motion| {
        let place = motion.commanded_position();
        let mut motors = kinematics.actuators(&motion.compensation().motors(&place));
        for (motor, axis) in motors.0.iter_mut().zip(Axis::PRIMARY) {
            *motor = words.axis(axis).unwrap_or(*motor);
        }
        let place = motion.compensation().program(&kinematics.point(&motors));
        motion.set_position(place)
    });
    set.map(|()| Answer::Ok).map_err(|refusal| texts.refused(format_args!("{refusal}")))
}

/// M306: makes the present place read as the words say, from the next homing on; without words prints the
/// corrections.
///
/// # Errors
/// When an axis is not homed, or arms home it.
pub fn home_offsets_from_here(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl MotionPort>,
    axes: &mut Axes,
    tuning: &mut Tuning,
) -> Outcome {
    let here = ports.motion(|motion| motion.commanded_position());
    let named = || Axis::PRIMARY.into_iter().filter(|axis| words.has(axis.letter()));
    if config.homing.rotary_delta && named().next().is_some() {
        return Err(Failure::refused(&"M306 on a rotary delta is not there yet: use M206"));
    }
    if let Some(axis) = named().find(|axis| !axes.homed().has(*axis)) {
        let letter = axis.letter();
        return Err(texts.refused(format_args!("Axis {letter} must be homed before setting Homing offset")));
    }
    for axis in named() {
        let reads = words.axis(axis).unwrap_or(here[axis]);
        tuning.set_home_offset(axis, tuning.home_offset()[axis] + reads - here[axis]);
        axes.forget_homed(AxisSet::of(axis));
    }
    let offset = tuning.home_offset();
    let [x, y, z] = Axis::PRIMARY.map(|axis| offset[axis]);
    reply.say(format_args!("// Homing Offset: X {x:5.3} Y {y:5.3} Z {z:5.3} will take effect next home\n"));
    Ok(Answer::Ok)
}

/// Prints the settings of line segmentation for M503; M500 does not save them.
pub fn say_line_cutting(tuning: &Tuning, reply: &mut Reply<'_>) {
    let (rate, length) = (tuning.lines.segments_per_second, tuning.lines.segment_length);
    let (rate, length) = (rate.unwrap_or(0.0), length.unwrap_or(0.0));
    reply.say(format_args!(";Not saved: pieces of a line a second, their length:\nM665 S{rate:.5} U{length:.5}\n"));
}

/// G28.6: prints whether each axis that can home is homed.
pub fn report_homing(config: &MachineConfig, axes: &Axes, reply: &mut Reply<'_>) {
    for axis in homing_axes(config) {
        reply.say(format_args!("{}:{} ", axis.letter(), u8::from(axes.homed().has(axis))));
    }
    reply.say(format_args!("\n"));
}

fn homing_axes(config: &MachineConfig) -> impl Iterator<Item = Axis> {
    Axis::ALL.into_iter().filter(|axis| config.homing_endstop(*axis).is_some())
}

/// Writes the lines that M500 saves of the arms.
///
/// # Errors
/// When the text is full.
pub fn write_arms(
    text: &mut impl fmt::Write,
    motion_config: &MotionConfig,
    tuning: &Tuning,
    config: &MachineConfig,
) -> fmt::Result {
    let parameters = motion_config.kinematics.parameters();
    if parameters.iter().next().is_some() {
        write!(text, ";Arm solution:\nM665")?;
        // Smoothieware's deltas have rods of one length.
        let is_delta = matches!(motion_config.kinematics, Kinematics::LinearDelta(_));
        let is_of_one_rod = |letter: char| is_delta && "IJK".contains(letter);
        let all = config.motion.arms.linear_delta.arm_offset != [0.0; 3]
            || parameters.iter().any(|(letter, value)| is_of_one_rod(letter) && value != 0.0);
        for (letter, value) in parameters.iter().filter(|(letter, _)| all || !is_of_one_rod(*letter)) {
            write!(text, " {letter}{value:.5}")?;
        }
        writeln!(text)?;
    }
    // G28.7 puts slaved motors at their own trims.
    let has_slaves = Axis::PRIMARY.into_iter().any(|axis| config.slave_endstops(axis).next().is_some());
    if homes_by_motor(config) || has_slaves {
        let [x, y, z] = tuning.trim();
        writeln!(text, ";Trim:\nM666 X{x:.5} Y{y:.5} Z{z:.5}")?;
    }
    if homes_by_tool(config) && config.homing_endstop(Axis::Z).is_some() {
        writeln!(text, ";Homing height:\nM665 Z{:.5}", tuning.home_z())?;
    }
    Ok(())
}

/// Writes the line that M500 saves of the axes that home; other axes have nothing to correct.
///
/// # Errors
/// When the text is full.
pub fn write_homing(text: &mut impl fmt::Write, tuning: &Tuning, config: &MachineConfig) -> fmt::Result {
    let mut any = false;
    for axis in homing_axes(config) {
        let head = if any { "" } else { ";Home offset (mm):\nM206" };
        write!(text, "{head} {}{}", axis.letter(), Value(tuning.home_offset()[axis], 2))?;
        any = true;
    }
    if any { writeln!(text) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_z_switch() -> MachineConfig {
        let mut config = MachineConfig::default();
        let stop = config::EndstopConfig {
            axis: Some(Axis::Z),
            homing_direction: config::HomingDirection::ToMax,
            homing_position: units::Mm(250.0),
            ..config::EndstopConfig::default()
        };
        config.endstops.push(stop).unwrap();
        config
    }

    #[test]
    fn saved_lines_are_those_of_the_axes_that_home() {
        let config = with_z_switch();
        let mut tuning = Tuning::new(&config);
        tuning.set_home_offset(Axis::Z, -0.25);
        let mut text = String::new();
        write_homing(&mut text, &tuning, &config).unwrap();
        assert_eq!(text, ";Home offset (mm):\nM206 Z-0.25\n");
        text.clear();
        write_homing(&mut text, &tuning, &MachineConfig::default()).unwrap();
        assert_eq!(text, "");
    }

    #[test]
    fn a_delta_is_home_in_the_middle_at_its_height() {
        let config = with_z_switch();
        let mut tuning = Tuning::new(&config);
        tuning.set_home_z(251.5);
        tuning.set_home_offset(Axis::Z, -0.5);
        assert_eq!(delta_home(&config, &tuning).0, [0.0, 0.0, 251.0, 0.0, 0.0, 0.0]);
    }
}
