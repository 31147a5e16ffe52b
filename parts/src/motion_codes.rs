//! Codes that change speeds, accelerations, steps and pressure advance: M92, M203, M204, M205, M220, M900.
//! M211 does so for the ends of travel.
//!
//! M92 and M900 change what every step means: they are for a machine that stands still.

use base::failure::{Answer, Failure, Outcome, Texts};
use base::needs::failure_of;
use base::ports::MotionPort;
use base::safety::travel::Travel;
use base::sessions::Reply;
use base::tuning::Tuning;
use config::MachineConfig;
use motion::{ConfigError, Limits, MotionConfig, Shaper, ShaperKind};
use program::{Interpreter, Tools, Words};
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

/// M203: sets the greatest speeds of axes, of the tool along its path, of extruders' motors; without words
/// prints them. Returns the rate of G0 where S sets it, which the program keeps.
///
/// # Errors
/// When there is no such extruder, or motion refuses the limits; nothing has changed then.
pub fn axis_speeds(
    texts: &Texts,
    ports: &mut impl MotionPort,
    config: &MachineConfig,
    program: &Interpreter,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Result<Option<MmPerSecond>, Failure> {
    if words.is_bare() {
        report_axis_speeds(&motion_config(ports)?.limits, program, reply);
        return Ok(None);
    }
    set_axis_speeds(texts, ports, config, program.tools(), words)
}

/// Sets the speeds of M203's words.
///
/// # Errors
/// As [`axis_speeds`].
pub fn set_axis_speeds(
    texts: &Texts,
    ports: &mut impl MotionPort,
    config: &MachineConfig,
    tools: &Tools,
    words: &Words<'_>,
) -> Result<Option<MmPerSecond>, Failure> {
    let mut limits = motion_config(ports)?.limits;
    for (axis, limit) in Axis::PRIMARY.into_iter().zip(&mut limits.axis_speed) {
        if let Some(speed) = words.axis(axis) {
            *limit = (speed > 0.0).then_some(MmPerSecond(speed));
        }
    }
    // Beside E, P is the number of an extruder.
    if let Some(speed) = words.get('P').filter(|_| !words.has('E') && !words.has('V')) {
        limits.max_speed = (speed > NO_LIMIT).then_some(MmPerSecond(speed));
    }
    if let Some((motor, speed)) = extruder_word(texts, words, tools, config)? {
        limits.actuator_rate[motor] = MmPerSecond(speed);
    }
    set_limits(texts, ports, limits)?;
    Ok(words.get('S').filter(|_| config.motion.compliant_seek_rate).map(MmPerSecond))
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

fn report_extruder(limits: &Limits, tools: &Tools, reply: &mut Reply<'_>) {
    if let (Some(motor), Some(tool)) = (extruder_in_use(tools), tools.active()) {
        let flow = tool.settings.flow_limit.unwrap_or(0.0);
        reply.say(format_args!("E:{:.6} V:{flow:.6}", limits.actuator_rate[motor].0));
    }
}

/// M203.1: sets the greatest speeds of motors; without words prints them.
///
/// # Errors
/// When motion refuses the limits; nothing has changed then.
pub fn motor_speeds(
    texts: &Texts,
    ports: &mut impl MotionPort,
    config: &MachineConfig,
    tools: &Tools,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Outcome {
    if words.is_bare() {
        let limits = motion_config(ports)?.limits;
        let own = motors().filter(|(axis, motor)| config.actuators[*motor].present && !tools.uses(*axis));
        for (axis, motor) in own {
            reply.say(format_args!(" {}:{:.6} ", axis.letter(), limits.actuator_rate[motor].0));
        }
        report_extruder(&limits, tools, reply);
        reply.say(format_args!("\n"));
        return Ok(Answer::Ok);
    }
    set_motor_speeds(texts, ports, config, tools, words)
}

/// Sets the speeds of M203.1's words.
///
/// # Errors
/// As [`motor_speeds`].
pub fn set_motor_speeds(
    texts: &Texts,
    ports: &mut impl MotionPort,
    config: &MachineConfig,
    tools: &Tools,
    words: &Words<'_>,
) -> Outcome {
    let mut limits = motion_config(ports)?.limits;
    for (axis, motor) in motors() {
        let rate = &mut limits.actuator_rate[motor];
        *rate = words.axis(axis).map_or(*rate, MmPerSecond);
    }
    if let Some((motor, speed)) = extruder_word(texts, words, tools, config)? {
        limits.actuator_rate[motor] = MmPerSecond(speed);
    }
    set_limits(texts, ports, limits)
}

/// M204: sets the accelerations of axes and extruders.
///
/// # Errors
/// When there is no such extruder, or motion refuses the limits; nothing has changed then.
pub fn accelerations(
    texts: &Texts,
    ports: &mut impl MotionPort,
    config: &MachineConfig,
    tools: &Tools,
    words: &Words<'_>,
) -> Outcome {
    let mut limits = motion_config(ports)?.limits;
    if let Some(acceleration) = words.get('S') {
        limits.acceleration = MmPerSecond2(if acceleration < 1.0 { 1.0 } else { acceleration });
    }
    let own = |acceleration: f64| (acceleration > 0.0).then_some(MmPerSecond2(acceleration));
    for (axis, motor) in motors() {
        if let Some(acceleration) = words.axis(axis) {
            limits.actuator_acceleration[motor] = own(acceleration);
        }
    }
    if let Some((motor, acceleration)) = extruder_word(texts, words, tools, config)? {
        limits.actuator_acceleration[motor] = own(acceleration);
    }
    set_limits(texts, ports, limits)
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

/// M205 and M566 of printers' firmwares: take the jerk of X and Y as square corner velocity (speed kept
/// through a right angle).
///
/// # Errors
/// When motion refuses the limits; nothing has changed then.
pub fn jerk(texts: &Texts, ports: &mut impl MotionPort, words: &Words<'_>) -> Outcome {
    let mut limits = motion_config(ports)?.limits;
    let jerk = match (words.get('X'), words.get('Y')) {
        (Some(x), Some(y)) => Some(x.min(y)),
        (x, y) => x.or(y),
    };
    if let Some(speed) = jerk {
        limits.square_corner_velocity = Some(MmPerSecond(speed));
    }
    if let Some(deviation) = words.get('J') {
        limits.junction_deviation = Mm(deviation);
        limits.square_corner_velocity = None;
    }
    take_corner_words(&mut limits, words);
    set_limits(texts, ports, limits)
}

/// Sets the limits of those words of M205 that are alike in every dialect.
fn take_corner_words(limits: &mut Limits, words: &Words<'_>) {
    if let Some(speed) = words.get('V') {
        limits.square_corner_velocity = Some(MmPerSecond(speed));
    }
    if let Some(ratio) = words.get('C') {
        limits.cruise_ratio = ratio;
    }
}

/// M205: sets junction deviation and least speed.
///
/// # Errors
/// When motion refuses the limits; nothing has changed then.
pub fn corner_settings(texts: &Texts, ports: &mut impl MotionPort, words: &Words<'_>) -> Outcome {
    let mut limits = motion_config(ports)?.limits;
    if let Some(deviation) = words.get('X') {
        limits.junction_deviation = Mm(deviation);
        // A junction deviation takes the place of a square corner velocity.
        limits.square_corner_velocity = None;
    }
    if let Some(deviation) = words.get('Z') {
        limits.z_junction_deviation = (deviation >= 0.0).then_some(Mm(deviation));
    }
    if let Some(speed) = words.get('S') {
        limits.minimum_speed = MmPerSecond(speed);
    }
    take_corner_words(&mut limits, words);
    set_limits(texts, ports, limits)
}

/// M220: scales the speeds of moves read from now on, within a tenth and tenfold. B keeps the factor, R
/// brings back the kept one.
pub fn set_speed_factor(program: &mut Interpreter, words: &Words<'_>) {
    if words.has('B') {
        program::speed_factor::keep(program);
    }
    let kept = words.has('R').then(|| program.modal().kept_speed_factor);
    if let Some(factor) = words.get('S').or(kept) {
        program::speed_factor::set(program, factor.clamp(*FACTOR.start(), *FACTOR.end()));
    }
}

/// M211: S0 takes the ends of travel away until the next reset, S1 gives them back; prints them, as Marlin
/// does.
pub fn soft_endstops(
    travel: &mut Travel,
    config: &MachineConfig,
    tuning: &Tuning,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Outcome {
    if let Some(on) = words.get('S') {
        travel.switch(on != 0.0);
    }
    let travel = travel.up_to_date(config, tuning);
    reply.say(format_args!("Soft endstops: {}", if travel.is_on(config) { "On" } else { "Off" }));
    for (name, ends) in ["Min", "Max"].into_iter().zip(travel.ends()) {
        reply.say(format_args!("  {name}:"));
        for axis in Axis::PRIMARY.into_iter().filter(|axis| ends[*axis].is_finite()) {
            reply.say(format_args!(" {}{:.3}", axis.letter(), ends[axis]));
        }
    }
    reply.say(format_args!("\n"));
    Ok(Answer::Ok)
}

/// M92: sets steps per mm, and prints them. The machine stands still.
///
/// # Errors
/// When there is no such extruder, or motion refuses the steps; nothing has changed then.
pub fn steps_per_mm(
    texts: &Texts,
    ports: &mut impl MotionPort,
    config: &MachineConfig,
    tools: &Tools,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
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
    texts: &Texts,
    ports: &mut impl MotionPort,
    config: &MachineConfig,
    tools: &Tools,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
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
pub fn input_shaping(texts: &Texts, ports: &mut impl MotionPort, words: &Words<'_>, reply: &mut Reply<'_>) -> Outcome {
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
