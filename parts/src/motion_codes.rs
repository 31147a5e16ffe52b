//! Codes that change speeds, accelerations, steps and pressure advance: M92, M203, M204, M205, M220, M900.
//! M211 does so for the ends of travel.
//!
//! M92 and M900 change what every step means: they are for a machine that stands still.

use base::CodeContext;
use base::failure::{Answer, Failure, Outcome, Texts};
use base::needs::failure_of;
use base::ports::MotionPort;
use base::safety::travel::Travel;
use base::sessions::Reply;
use base::tuning::Tuning;
use config::MachineConfig;
use motion::{ConfigError, Limits, MotionConfig, Shaper, ShaperKind};
use program::{Interpreter, LimitCode, Tools, Words};
use units::{Actuator, Axis, Mm, MmPerSecond, MmPerSecond2};

/// Bounds of the speed factor (M220).
const FACTOR: core::ops::RangeInclusive<f64> = 0.1..=10.0;
/// Greatest overall speed limit that means no limit, mm/s.
const NO_LIMIT: f64 = 0.1;
/// Damping ratio of a resonance without a word for it, as Klipper's.
const USUAL_DAMPING: f64 = 0.1;

fn motors() -> impl Iterator<Item = (Axis, Actuator)> {
    Axis::ALL.into_iter().zip(Actuator::ALL)
}

fn refuse(texts: &Texts, error: ConfigError) -> Failure {
    texts.refused(format_args!("{error}"))
}

fn motion_config(ports: &mut impl MotionPort) -> Result<MotionConfig, Failure> {
    let config = ports.motion(|motion| motion.config().copied());
    config.ok_or_else(|| Failure::refused(&"motion is not configured"))
}

fn set_limits(texts: &Texts, ports: &mut impl MotionPort, limits: Limits) -> Outcome {
    ports.motion(|motion| motion.set_limits(limits)).map_err(|error| refuse(texts, error))?;
    Ok(Answer::Ok)
}

/// Returns the place of an extruder's pressure advance among the filters: tools turn A, B and C, in this
/// order.
pub const fn advance_of(axis: Axis) -> usize {
    (axis as usize).saturating_sub(Axis::PRIMARY.len())
}

/// Returns the motor of the extruder in use.
fn extruder_in_use(tools: &Tools) -> Option<Actuator> {
    tools.active().and_then(|tool| Actuator::from_index(tool.settings.axis as usize))
}

/// Returns the axis of the extruder in use, or of tool P.
fn extruder_axis(texts: &Texts, words: &Words<'_>, tools: &Tools, config: &MachineConfig) -> Result<Axis, Failure> {
    // A tool that the machine does not have never halts here, whatever is being played.
    let tool = tools.selected(words).map_err(|fault| failure_of(texts, config, &fault, false))?;
    Ok(tool.settings.axis)
}

/// Returns the value of E, and the motor it is for.
fn extruder_word(
    texts: &Texts,
    words: &Words<'_>,
    tools: &Tools,
    config: &MachineConfig,
) -> Result<Option<(Actuator, f64)>, Failure> {
    let Some(value) = words.get('E') else { return Ok(None) };
    let axis = extruder_axis(texts, words, tools, config)?;
    Ok(Actuator::from_index(axis as usize).map(|motor| (motor, value)))
}

/// What the codes of limits change.
pub struct Limited<'a, M> {
    /// Texts of failures.
    pub texts: &'a Texts,
    /// Port to motion.
    pub ports: &'a mut M,
    /// Configuration of the machine.
    pub config: &'a MachineConfig,
    /// Program, which keeps the rate of G0 and the speed factor.
    pub program: &'a mut Interpreter,
    /// Settings that codes have changed.
    pub tuning: &'a mut Tuning,
    /// Ends of travel.
    pub travel: &'a mut Travel,
}

/// Sets limits by the words of their code, on the machine and in a dry run alike.
///
/// # Errors
/// When there is no such extruder, or motion refuses the limits; nothing has changed then.
pub fn set_limit<M: MotionPort>(on: &mut Limited<'_, M>, code: LimitCode, words: &Words<'_>) -> Result<(), Failure> {
    match code {
        LimitCode::AxisSpeeds
        | LimitCode::MotorSpeeds
        | LimitCode::Accelerations
        | LimitCode::Jerk
        | LimitCode::CornerSettings => {
            let mut limits = motion_config(on.ports)?.limits;
            // Other codes have another meaning for E, or none.
            let takes_extruder = !matches!(code, LimitCode::Jerk | LimitCode::CornerSettings);
            let extruder = takes_extruder.then(|| extruder_word(on.texts, words, on.program.tools(), on.config));
            let extruder = extruder.transpose()?.flatten();
            change_limits(&mut limits, code, words, extruder);
            set_limits(on.texts, on.ports, limits)?;
            let rate = words.get('S').filter(|_| code == LimitCode::AxisSpeeds && on.config.motion.compliant_seek_rate);
            if let Some(rate) = rate {
                on.program.set_seek_rate(MmPerSecond(rate));
            }
        }
        LimitCode::SpeedFactor => set_speed_factor(on.program, words),
        LimitCode::SoftEndstops => {
            if let Some(yes) = words.get('S') {
                on.travel.switch(yes != 0.0);
            }
        }
        LimitCode::Trims => set_trims(on.tuning, words),
        LimitCode::HomeOffsets => set_home_offsets(on.tuning, words),
        LimitCode::ColdExtrusion => on.tuning.set_least_warm(on.config, words),
    }
    Ok(())
}

/// Reports the limits of a code, where it reports them with these words.
///
/// # Errors
/// When motion is not configured.
pub fn report_limit<M: MotionPort>(
    on: &mut Limited<'_, M>,
    code: LimitCode,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Result<(), Failure> {
    match code {
        LimitCode::AxisSpeeds if words.is_bare() => {
            report_axis_speeds(&motion_config(on.ports)?.limits, on.program, reply);
        }
        LimitCode::MotorSpeeds if words.is_bare() => {
            report_motor_speeds(&motion_config(on.ports)?.limits, on.config, on.program.tools(), reply);
        }
        LimitCode::SoftEndstops => report_travel(on.travel.up_to_date(on.config, on.tuning), on.config, reply),
        LimitCode::Trims => {
            let [x, y, z] = on.tuning.trim();
            reply.say(format_args!("X: {x:5.4} Y: {y:5.4} Z: {z:5.4}\n"));
        }
        LimitCode::HomeOffsets => {
            for axis in Axis::PRIMARY {
                let mm = on.tuning.home_offset()[axis];
                reply.say(format_args!("{}: {mm:5.3} ", axis.letter()));
            }
            reply.say(format_args!(" will take effect next home\n"));
        }
        LimitCode::ColdExtrusion if words.is_bare() => report_cold_extrusion(on.tuning, on.program.tools(), reply),
        LimitCode::AxisSpeeds | LimitCode::MotorSpeeds | LimitCode::ColdExtrusion => {}
        LimitCode::Accelerations | LimitCode::Jerk | LimitCode::CornerSettings | LimitCode::SpeedFactor => {}
    }
    Ok(())
}

/// Changes limits of motion by the words of a code, and the motor of an extruder by its word E.
fn change_limits(limits: &mut Limits, code: LimitCode, words: &Words<'_>, extruder: Option<(Actuator, f64)>) {
    let own = |acceleration: f64| (acceleration > 0.0).then_some(MmPerSecond2(acceleration));
    match code {
        // M203: the greatest speeds of axes, of the tool along its path, of extruders' motors.
        LimitCode::AxisSpeeds => {
            for (axis, limit) in Axis::PRIMARY.into_iter().zip(&mut limits.axis_speed) {
                if let Some(speed) = words.axis(axis) {
                    *limit = (speed > 0.0).then_some(MmPerSecond(speed));
                }
            }
            // Beside E, P is the number of an extruder.
            if let Some(speed) = words.get('P').filter(|_| !words.has('E') && !words.has('V')) {
                limits.max_speed = (speed > NO_LIMIT).then_some(MmPerSecond(speed));
            }
            if let Some((motor, speed)) = extruder {
                limits.actuator_rate[motor] = MmPerSecond(speed);
            }
        }
        // M203.1: the greatest speeds of motors.
        LimitCode::MotorSpeeds => {
            for (axis, motor) in motors() {
                let rate = &mut limits.actuator_rate[motor];
                *rate = words.axis(axis).map_or(*rate, MmPerSecond);
            }
            if let Some((motor, speed)) = extruder {
                limits.actuator_rate[motor] = MmPerSecond(speed);
            }
        }
        // M204: the accelerations of axes and extruders.
        LimitCode::Accelerations => {
            if let Some(acceleration) = words.get('S') {
                limits.acceleration = MmPerSecond2(if acceleration < 1.0 { 1.0 } else { acceleration });
            }
            for (axis, motor) in motors() {
                if let Some(acceleration) = words.axis(axis) {
                    limits.actuator_acceleration[motor] = own(acceleration);
                }
            }
            if let Some((motor, acceleration)) = extruder {
                limits.actuator_acceleration[motor] = own(acceleration);
            }
        }
        LimitCode::Jerk | LimitCode::CornerSettings => change_corners(limits, code == LimitCode::Jerk, words),
        LimitCode::SpeedFactor | LimitCode::SoftEndstops | LimitCode::Trims => {}
        LimitCode::HomeOffsets | LimitCode::ColdExtrusion => {}
    }
}

/// Changes the limits of corners: by M205's words junction deviation and least speed; by those of M205 and
/// M566 of printers' firmwares the jerk of X and Y, taken as square corner velocity (speed kept through a
/// right angle).
fn change_corners(limits: &mut Limits, is_jerk: bool, words: &Words<'_>) {
    let velocity = match (words.get('X'), words.get('Y')) {
        _ if !is_jerk => None,
        (Some(x), Some(y)) => Some(x.min(y)),
        (x, y) => x.or(y),
    };
    if let Some(speed) = velocity {
        limits.square_corner_velocity = Some(MmPerSecond(speed));
    }
    if let Some(deviation) = words.get(if is_jerk { 'J' } else { 'X' }) {
        limits.junction_deviation = Mm(deviation);
        // A junction deviation takes the place of a square corner velocity.
        limits.square_corner_velocity = None;
    }
    if let Some(deviation) = words.get('Z').filter(|_| !is_jerk) {
        limits.z_junction_deviation = (deviation >= 0.0).then_some(Mm(deviation));
    }
    if let Some(speed) = words.get('S').filter(|_| !is_jerk) {
        limits.minimum_speed = MmPerSecond(speed);
    }
    if let Some(speed) = words.get('V') {
        limits.square_corner_velocity = Some(MmPerSecond(speed));
    }
    if let Some(ratio) = words.get('C') {
        limits.cruise_ratio = ratio;
    }
}

/// M220: scales the speeds of moves read from now on, within a tenth and tenfold. B keeps the factor, R
/// brings back the kept one.
fn set_speed_factor(program: &mut Interpreter, words: &Words<'_>) {
    if words.has('B') {
        program::speed_factor::keep(program);
    }
    let kept = words.has('R').then(|| program.modal().kept_speed_factor);
    if let Some(factor) = words.get('S').or(kept) {
        program::speed_factor::set(program, units::within(factor, *FACTOR.start(), *FACTOR.end()));
    }
}

/// M666: trims of the towers or arms, from the next homing on.
fn set_trims(tuning: &mut Tuning, words: &Words<'_>) {
    let mut trims = tuning.trim();
    for (axis, trim) in Axis::PRIMARY.into_iter().zip(&mut trims) {
        *trim = words.axis(axis).unwrap_or(*trim);
    }
    tuning.set_trim(trims);
}

/// M206: corrections of homing positions, from the next homing on.
fn set_home_offsets(tuning: &mut Tuning, words: &Words<'_>) {
    for axis in Axis::ALL {
        if let Some(mm) = words.axis(axis) {
            tuning.set_home_offset(axis, mm);
        }
    }
}

fn report_axis_speeds(limits: &Limits, program: &Interpreter, reply: &mut Reply<'_>) {
    for (axis, limit) in Axis::PRIMARY.into_iter().zip(limits.axis_speed) {
        reply.say(format_args!(" {}:{:.6} ", axis.letter(), limit.map_or(0.0, |limit| limit.0)));
    }
    // Smoothieware prints in single precision.
    let (seek, most) = (program.modal().seek_rate.0 as f32, limits.max_speed.map_or(0.0, |limit| limit.0));
    reply.say(format_args!(" S:{seek:.6} P:{most:.6} "));
    report_extruder(limits, program.tools(), reply);
    reply.say(format_args!("\n"));
}

fn report_motor_speeds(limits: &Limits, config: &MachineConfig, tools: &Tools, reply: &mut Reply<'_>) {
    let own = motors().filter(|(axis, motor)| config.actuators[*motor].present && !tools.uses(*axis));
    for (axis, motor) in own {
        reply.say(format_args!(" {}:{:.6} ", axis.letter(), limits.actuator_rate[motor].0));
    }
    report_extruder(limits, tools, reply);
    reply.say(format_args!("\n"));
}

fn report_extruder(limits: &Limits, tools: &Tools, reply: &mut Reply<'_>) {
    if let (Some(motor), Some(tool)) = (extruder_in_use(tools), tools.active()) {
        let flow = tool.settings.flow_limit.unwrap_or(0.0);
        reply.say(format_args!("E:{:.6} V:{flow:.6}", limits.actuator_rate[motor].0));
    }
}

/// Reports the ends of travel (M211), as Marlin does.
fn report_travel(travel: &Travel, config: &MachineConfig, reply: &mut Reply<'_>) {
    reply.say(format_args!("Soft endstops: {}", if travel.is_on(config) { "On" } else { "Off" }));
    for (name, ends) in ["Min", "Max"].into_iter().zip(travel.ends()) {
        reply.say(format_args!("  {name}:"));
        for axis in Axis::PRIMARY.into_iter().filter(|axis| ends[*axis].is_finite()) {
            reply.say(format_args!(" {}{:.3}", axis.letter(), ends[axis]));
        }
    }
    reply.say(format_args!("\n"));
}

/// Reports how warm the nozzle in use must be for extrusion (M302).
fn report_cold_extrusion(tuning: &Tuning, tools: &Tools, reply: &mut Reply<'_>) {
    let [least, back] = tuning.least_warm.get(usize::from(tools.active_id().0)).copied().unwrap_or_default();
    if least > 0.0 || back > 0.0 {
        reply.say(format_args!("Cold extrusion is refused below {least:.0} C, to draw back {back:.0} C\n"));
    } else {
        reply.say(format_args!("Cold extrusion is allowed\n"));
    }
}

/// M204 of printers' firmwares: sets the acceleration of all moves.
///
/// # Errors
/// When motion refuses the value; nothing has changed then.
pub fn acceleration(texts: &Texts, ports: &mut impl MotionPort, value: f64) -> Outcome {
    let mut limits = motion_config(ports)?.limits;
    limits.acceleration = MmPerSecond2(value);
    set_limits(texts, ports, limits)
}

/// M92: sets steps per mm, and prints them. The machine stands still.
///
/// # Errors
/// When there is no such extruder, or motion refuses the steps; nothing has changed then.
pub fn steps_per_mm(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl MotionPort>,
    tools: &Tools,
) -> Outcome {
    set_steps_per_mm(texts, ports, config, tools, words)?;
    let settings = ports.motion(|motion| motion.config().copied());
    let steps = |motor: Actuator| settings.and_then(|all| all.actuators[motor]).map(|motor| motor.steps_per_mm);
    for (axis, motor) in motors() {
        if let Some(steps) = steps(motor).filter(|_| !tools.uses(axis)) {
            reply.say(format_args!("{}:{steps:.6} ", axis.letter()));
        }
    }
    if let Some(steps) = extruder_in_use(tools).and_then(steps) {
        reply.say(format_args!("E:{steps:.6} "));
    }
    reply.say(format_args!("\n"));
    Ok(Answer::Ok)
}

/// Sets the steps per mm of M92's words without printing them.
///
/// # Errors
/// As [`steps_per_mm`].
pub fn set_steps_per_mm(
    texts: &Texts,
    ports: &mut impl MotionPort,
    config: &MachineConfig,
    tools: &Tools,
    words: &Words<'_>,
) -> Result<(), Failure> {
    if words.is_bare() {
        return Ok(());
    }
    let mut settings = motion_config(ports)?;
    set_steps(texts, &mut settings, words, tools, config)?;
    ports.motion(|motion| motion.configure(settings)).map_err(|error| refuse(texts, error))
}

fn set_steps(
    texts: &Texts,
    settings: &mut MotionConfig,
    words: &Words<'_>,
    tools: &Tools,
    config: &MachineConfig,
) -> Result<(), Failure> {
    for (axis, motor) in motors() {
        if let (Some(actuator), Some(steps)) = (&mut settings.actuators[motor], words.axis(axis)) {
            actuator.steps_per_mm = steps;
        }
    }
    if let Some((motor, steps)) = extruder_word(texts, words, tools, config)?
        && let Some(actuator) = &mut settings.actuators[motor]
    {
        actuator.steps_per_mm = steps;
    }
    Ok(())
}

/// M900 K and M572 S: sets the pressure advance of the tool in use, or of tool P or D, in seconds, and W its
/// smoothing time; without them prints it. The machine stands still.
///
/// # Errors
/// When there is no such extruder, it has no pressure advance, or motion refuses the value; nothing has
/// changed then.
pub fn pressure_advance(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl MotionPort>,
    tools: &Tools,
) -> Outcome {
    let tool = tools.named_by(words, if words.has('D') { 'D' } else { 'P' });
    let index = advance_of(tool.map_err(|fault| failure_of(texts, config, &fault, false))?.settings.axis);
    let (factor, smooth_time) = (words.get('K').or(words.get('S')), words.get('W'));
    if factor.is_none() && smooth_time.is_none() {
        let settings = ports.motion(|motion| motion.config().copied());
        if let Some(Some(advance)) = settings.and_then(|settings| settings.filters.advance.get(index).copied()) {
            reply.say(format_args!("K:{:.4} smooth time:{:.4}\n", advance.factor, advance.smooth_time));
        }
        return Ok(Answer::Ok);
    }
    let mut settings = motion_config(ports)?;
    let Some(Some(advance)) = settings.filters.advance.get_mut(index) else {
        return Err(Failure::refused(&"this extruder has no pressure advance"));
    };
    advance.factor = factor.unwrap_or(advance.factor);
    advance.smooth_time = smooth_time.unwrap_or(advance.smooth_time);
    ports.motion(|motion| motion.configure(settings)).map_err(|error| refuse(texts, error))?;
    Ok(Answer::Ok)
}

/// M593: sets input shaping of X, of Y, or of both; F is the frequency in Hz, 0 for none; the text is the
/// kind of shaper. Without words prints the settings. The machine stands still.
///
/// # Errors
/// When the kind is not known, or motion refuses the shaper; nothing has changed then.
pub fn input_shaping(CodeContext { texts, ports, words, reply, .. }: CodeContext<'_, impl MotionPort>) -> Outcome {
    let mut settings = motion_config(ports)?;
    if words.is_bare() {
        for (axis, shaper) in Axis::PRIMARY.into_iter().zip(settings.filters.shapers) {
            let frequency = shaper.map_or(0.0, |shaper| shaper.frequency);
            reply.say(format_args!("M593 {} F{frequency:.1}\n", axis.letter()));
        }
        return Ok(Answer::Ok);
    }
    let kind = words.text().map(shaper_kind).transpose()?;
    let named = words.has('X') || words.has('Y');
    for (axis, shaper) in [Axis::X, Axis::Y].into_iter().zip(&mut settings.filters.shapers) {
        if named && !words.has(axis.letter()) {
            continue;
        }
        let before = *shaper;
        let Some(frequency) = words.get('F').or(before.map(|shaper| shaper.frequency)) else { continue };
        let damping = words.get('D').or(words.get('S')).or(before.map(|shaper| shaper.damping));
        *shaper = (frequency > 0.0).then_some(Shaper {
            // Marlin has only this shaper.
            kind: kind.or(before.map(|shaper| shaper.kind)).unwrap_or(ShaperKind::Zv),
            frequency,
            damping: damping.unwrap_or(USUAL_DAMPING),
        });
    }
    ports.motion(|motion| motion.configure(settings)).map_err(|error| refuse(texts, error))?;
    Ok(Answer::Ok)
}

/// Parses the kind of a shaper, by Klipper's and RepRapFirmware's names.
fn shaper_kind(name: &str) -> Result<ShaperKind, Failure> {
    const KINDS: [(&str, ShaperKind); 8] = [
        ("zv", ShaperKind::Zv),
        ("mzv", ShaperKind::Mzv),
        ("zvd", ShaperKind::Zvd),
        ("ei", ShaperKind::Ei),
        ("2hump_ei", ShaperKind::TwoHumpEi),
        ("3hump_ei", ShaperKind::ThreeHumpEi),
        ("ei2", ShaperKind::TwoHumpEi),
        ("ei3", ShaperKind::ThreeHumpEi),
    ];
    let kind = KINDS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, kind)| *kind);
    kind.ok_or_else(|| {
        Failure::refused(&"M593: the kinds of input shapers are zv, mzv, zvd, ei, 2hump_ei and 3hump_ei")
    })
}
