//! Changes that the words of M665 make, kept apart so that a preflight without a machine can apply them too.

use base::failure::{Failure, Texts};
use base::tuning::Tuning;
use config::MachineConfig;
use motion::{Kinematics, Motion, MotionConfig};
use program::Words;

/// Returns whether the homing position of Z is a place of the tool, which M665 changes.
pub const fn homes_by_tool(config: &MachineConfig) -> bool {
    config.homing.delta || config.homing.scara
}

/// Changes the arms by the words of M665. Allowed only while idle.
///
/// # Errors
/// When motion is not configured, or refuses the geometry.
pub fn set_arms(texts: &Texts, motion: &mut Motion, words: &Words<'_>) -> Result<(), Failure> {
    let config = motion.config().ok_or_else(|| Failure::refused(&"motion is not configured"))?;
    let before = config.kinematics.parameters();
    let mut parameters = config.kinematics.parameters();
    for (letter, _) in before.iter() {
        if let Some(value) = words.get(letter) {
            parameters.set(letter, value);
        }
    }
    if parameters == before {
        Ok(())
    } else {
        change_arms(texts, motion, config.kinematics.with_parameters(&parameters))
    }
}

/// Changes the geometry: motors stay where they are, and the tool's place is computed anew. Allowed only
/// while idle.
///
/// # Errors
/// When motion refuses the geometry.
pub fn change_arms(texts: &Texts, motion: &mut Motion, kinematics: Kinematics) -> Result<(), Failure> {
    let config = *motion.config().ok_or_else(|| Failure::refused(&"motion is not configured"))?;
    let place = motion.commanded_position();
    let motors = config.kinematics.actuators(&motion.compensation().motors(&place));
    motion.configure(MotionConfig { kinematics, ..config }).map_err(|error| texts.refusal(error))?;
    let place = motion.compensation().program(&kinematics.point(&motors));
    motion.set_position(place).map_err(|refusal| texts.refused(format_args!("{refusal}")))
}

/// Sets the parameters of M665 that are not part of the arms.
pub fn set_arm_tuning(tuning: &mut Tuning, config: &MachineConfig, words: &Words<'_>) {
    set_home_height(tuning, config, words);
    set_line_cutting(tuning, words);
}

fn set_home_height(tuning: &mut Tuning, config: &MachineConfig, words: &Words<'_>) {
    if let Some(height) = words.get('Z').filter(|_| homes_by_tool(config)) {
        tuning.set_home_z(height);
    }
}

fn set_line_cutting(tuning: &mut Tuning, words: &Words<'_>) {
    if let Some(rate) = words.get('S') {
        // U does not count beside S.
        tuning.lines.segments_per_second = (rate > 1.0).then_some(rate);
    } else if let Some(length) = words.get('U') {
        tuning.lines.segments_per_second = None;
        tuning.lines.segment_length = (length >= 1e-4).then_some(length);
    }
}
