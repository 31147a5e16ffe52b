//! `tune_driver`: measures the stallGuard threshold for a motor on the machine as it is.
//!
//! A driver's stall output says stall while its reading is 0, and the threshold shifts all readings. So there
//! are two ends: below the lower end a motor that runs free reads 0 now and then; above the upper end a motor
//! that stands does not. The first is measured as it is, at two or three speeds. The second would take
//! stalls; in their place the axis crawls, for a motor that hardly turns induces as little as a motor that
//! stands. The threshold lies between both ends. With stallGuard4 the order is the other way round, see
//! [`stall_guard_4`]. The chopper is left alone: no reading of these chips says how good it is. The settings
//! of a chopper are computed, in [`chopper`], on request.
//!
//! The driver is set as for a search for a stall, which keeps the settings before it, and gets them back
//! however the test ends.

mod chopper;
mod readings;
mod stall_guard_4;
mod strokes;

use base::failure::{Answer, Failure, Outcome};
use base::ports::{MotorDrivers, StallSearch};
use base::tuning::StallThreshold;
use config::{ArmSolution, MachineConfig};
use units::{Actuator, Amps, Axis, AxisSet};

use crate::endstop_phase::PhaseHands;
use readings::{FIRST, Halving, LAST, Readings, middle};
use strokes::Way;

/// A free motor reads at least this in the mean, as homing without a switch asks for.
const LEAST_MEAN: f32 = 100.0;
/// Speed of the crawl, as a share of the least speed at which load can be measured.
const CRAWL: f64 = 0.1;
/// Ratio of the slowest speed that is measured to the least speed at which load can be measured.
const ABOVE_LEAST: f64 = 1.2;
/// Distance kept from the ends of the travel, mm.
const CLEAR: f64 = 5.0;
/// Number of thresholds between both ends that makes the result sure.
const SURE: i16 = 6;
/// Number of thresholds that makes stallGuard4's result sure: its threshold step is a fifth as much.
const SURE_4: i16 = 30;
const USAGE: &str = "tune_driver takes: axis, and up to three speeds in mm/s, or the word chopper";

/// Speeds of the test, mm/s, the fastest first.
type Speeds = heapless::Vec<f64, 3>;

/// Result of the search for a current.
#[derive(Clone, Copy, Debug)]
struct Found {
    threshold: i16,
    /// Last threshold with which the motor runs free.
    free: i16,
    /// Last threshold with which a crawl says stall.
    stands: i16,
    /// Slowest speed for which the threshold is right, mm/s, and the readings at it.
    slowest: f64,
    readings: Readings,
}

/// `tune_driver axis [mm/s ...]`
///
/// # Errors
/// If the axis cannot be measured, when no threshold fits, and when the machine halts. Then the driver is as
/// it was.
pub fn tune<'c>(hands: &mut impl PhaseHands<'c>, arguments: &str) -> Outcome {
    if let Some((letter, "chopper")) = arguments.trim().split_once(' ').map(|(axis, what)| (axis, what.trim())) {
        hands.standstill()?;
        return chopper::tune(hands, letter.chars().next().unwrap_or(' '));
    }
    let (way, speeds) = prepare(hands, arguments)?;
    let from = hands.position();
    hands.enable_motors()?;
    let overrides = hands.motion(|motion| motion.overrides());
    hands.motion(|motion| motion.set_overrides(1.0, 1.0));
    hands.watch_stalls(false);
    let found = measure(hands, &way, &speeds);
    // The driver must leave the search even if the measurement failed.
    let put_back = hands.drivers(|drivers| drivers.end_stall_search(way.motor));
    hands.watch_stalls(true);
    hands.motion(|motion| motion.set_overrides(overrides.feed, overrides.rapid));
    let found = match found {
        Err(Failure::HALTED) => return Err(Failure::HALTED),
        found => found,
    };
    hands.standstill()?;
    hands.go_there(from, units::MmPerSecond(speeds.first().copied().unwrap_or(1.0)))?;
    put_back.map_err(|fault| strokes::silent(hands.texts(), way.motor, fault))?;
    keep(hands, &way, found?)
}

/// Results for the watch over stalls, and for homing without a switch.
type Both = [Option<Found>; 2];

fn measure<'c>(hands: &mut impl PhaseHands<'c>, way: &Way, speeds: &Speeds) -> Result<Both, Failure> {
    let config = hands.config();
    let letter = way.axis.letter();
    hands.say(format_args!("// {letter} moves over {:.0} mm\n", way.ends[1] - way.ends[0]));
    let watched = find_either(hands, way, speeds, None)?;
    let stop = config.homing_endstop(way.axis).filter(|stop| stop.stall.homing);
    let Some(stop) = stop else { return Ok([Some(watched), None]) };
    hands.say(format_args!("// as it homes: at {:.0} mm/s, at stall_current\n", stop.slow_rate.0));
    let mut rates = Speeds::new();
    for rate in [stop.fast_rate.0, stop.slow_rate.0] {
        if rates.last().is_none_or(|last| (last - rate).abs() > 0.01) {
            // The list holds three speeds, and no more are accepted.
            let _ = rates.push(rate);
        }
    }
    let homing = find_either(hands, way, &rates, stop.stall.current)?;
    if homing.slowest > stop.slow_rate.0.min(stop.fast_rate.0) + 0.01 {
        return Err(hands.texts().refused(format_args!(
            "at {:.0} mm/s no threshold tells a stall from running free: home faster, or with more stall_current",
            stop.slow_rate.0
        )));
    }
    Ok([Some(watched), Some(homing)])
}

/// Finds the threshold for a current, by the method that fits the driver.
fn find_either<'c>(
    hands: &mut impl PhaseHands<'c>,
    way: &Way,
    speeds: &Speeds,
    current: Option<Amps>,
) -> Result<Found, Failure> {
    if hands.config().stall_thresholds(way.motor) == Some(stall_guard_4::THRESHOLDS) {
        return stall_guard_4::find(hands, way, speeds, current);
    }
    find(hands, way, speeds, current)
}

/// Finds the threshold for a current, of a driver whose readings the threshold shifts.
fn find<'c>(
    hands: &mut impl PhaseHands<'c>,
    way: &Way,
    speeds: &Speeds,
    current: Option<Amps>,
) -> Result<Found, Failure> {
    let highest = crawl(hands, way, current)?;
    let mut found: Option<Found> = None;
    let mut from = FIRST;
    for rate in speeds {
        let lowest = lowest_free(hands, way, *rate, current, from)?;
        let Some(lowest) = lowest.filter(|lowest| *lowest <= highest) else {
            hands.say(format_args!("// at {rate:.0} mm/s it reads too little for any threshold\n"));
            break;
        };
        let threshold = middle(lowest, highest);
        strokes::set(hands, way.motor, StallSearch { current, threshold: threshold.into() })?;
        let readings = strokes::there_and_back(hands, way, *rate, false)?;
        hands.say(format_args!(
            "// at {rate:.0} mm/s free from {lowest} on; with {threshold} it reads {:.0}, noise {:.0}, least {}\n",
            readings.mean(),
            readings.noise(),
            readings.least()
        ));
        from = lowest;
        let [threshold, free, stands] = [threshold, lowest, highest].map(i16::from);
        found = Some(Found { threshold, free, stands, slowest: *rate, readings });
    }
    found.ok_or_else(|| {
        Failure::refused(&"no threshold tells a stall from running free: a higher speed, or less current, may")
    })
}

/// Returns the highest threshold at which a motor that hardly turns reads 0.
fn crawl<'c>(hands: &mut impl PhaseHands<'c>, way: &Way, current: Option<Amps>) -> Result<i8, Failure> {
    let rate = hands.config().load_speed(way.motor).0 * CRAWL;
    let mut halving = Halving::from(FIRST);
    while let Some(threshold) = halving.next() {
        strokes::set(hands, way.motor, StallSearch { current, threshold: threshold.into() })?;
        let readings = strokes::there_and_back(hands, way, rate, true)?;
        halving.tell(!readings.are_stalled());
    }
    let highest = halving.found().map_or(LAST, |first| first.saturating_sub(1));
    hands.say(format_args!(
        "// crawling at {rate:.1} mm/s, where it induces next to nothing, it reads 0 up to {highest}\n"
    ));
    if halving.found() == Some(FIRST) {
        return Err(Failure::refused(&"it reads something even where it hardly turns: its load cannot be told so"));
    }
    Ok(highest)
}

/// Returns the lowest threshold from `from` on with which a motor runs free at a speed.
fn lowest_free<'c>(
    hands: &mut impl PhaseHands<'c>,
    way: &Way,
    rate: f64,
    current: Option<Amps>,
    from: i8,
) -> Result<Option<i8>, Failure> {
    let mut halving = Halving::from(from);
    while let Some(threshold) = halving.next() {
        strokes::set(hands, way.motor, StallSearch { current, threshold: threshold.into() })?;
        let readings = strokes::there_and_back(hands, way, rate, false)?;
        halving.tell(readings.are_free(LEAST_MEAN));
    }
    Ok(halving.found())
}

/// Sets the thresholds found, and says how sure they are.
fn keep<'c>(hands: &mut impl PhaseHands<'c>, way: &Way, [watched, homing]: Both) -> Outcome {
    let (motor, config) = (way.motor, hands.config());
    let filter = config.measures_filtered(motor);
    if let Some(found) = watched {
        let kept = StallThreshold { threshold: found.threshold, filter };
        let word = kept.words();
        let set = hands.drivers(|drivers| drivers.set_option(motor, 7, &word));
        set.map_err(|fault| strokes::silent(hands.texts(), motor, fault))?;
        hands.tuning().stall_thresholds[motor] = Some(kept);
        say(hands, "stall_threshold", &found);
        let least = config.load_speed(motor).0;
        if found.slowest > ABOVE_LEAST * least + 0.1 {
            hands.say(format_args!("It sees nothing slower: stall_least_speed = {:.0} in config.ini\n", found.slowest));
        }
    }
    if let Some(found) = homing {
        hands.tuning().homing_thresholds[motor] = Some(found.threshold);
        say(hands, "stall_threshold of its endstop", &found);
    }
    let letter = way.axis.letter();
    hands.say(format_args!("The chopper stays as it is: tune_driver {letter} chopper computes one\n"));
    hands.say(format_args!("No stall was tried. In use until reset: keep with M500\n"));
    Ok(Answer::Ok)
}

fn say<'c>(hands: &mut impl PhaseHands<'c>, name: &str, found: &Found) {
    let &Found { threshold, free, stands, .. } = found;
    hands.say(format_args!("{name} = {threshold}, the middle of {free} (free) to {stands} (stands)\n"));
    let noise = found.readings.noise().max(1.0);
    let sigmas = found.readings.mean() / noise;
    // stallGuard2 is free above, stallGuard4 below.
    let is_sure = if free <= stands { stands - free >= SURE } else { free - stands >= SURE_4 };
    let sure = if is_sure { "sure" } else { "not very sure" };
    hands.say(format_args!(
        "At {:.0} mm/s a stall reads 0 and this motor {:.0}, {sigmas:.0} times its noise: {sure}\n",
        found.slowest,
        found.readings.mean()
    ));
}

/// Checks that the axis can be measured, and returns its travel and the speeds.
fn prepare<'c>(hands: &mut impl PhaseHands<'c>, arguments: &str) -> Result<(Way, Speeds), Failure> {
    let mut words = arguments.split_ascii_whitespace();
    let letter = words.next().and_then(|word| word.chars().next());
    let axis = letter.and_then(Axis::from_letter).ok_or_else(|| Failure::refused(&USAGE))?;
    let config = hands.config();
    let motor = measurable(config, axis)?;
    if hands.is_playing() {
        return Err(Failure::refused(&"a job is under way"));
    }
    if !hands.axes().homed().has(axis) {
        return Err(hands.texts().refused(format_args!("home {} first: it goes over its whole travel", axis.letter())));
    }
    let way = way(hands, axis, motor)?;
    let mut speeds = Speeds::new();
    for word in words {
        let rate = gcode::read_f64(word).filter(|rate| rate.is_finite() && *rate > 0.0);
        let pushed = rate.map(|rate| speeds.push(rate));
        if !matches!(pushed, Some(Ok(()))) {
            return Err(Failure::refused(&USAGE));
        }
    }
    let least = config.load_speed(motor).0;
    if speeds.is_empty() {
        speeds = usual_speeds(hands, &way, least)?;
    }
    units::sort_short(&mut speeds, |one, other| other.total_cmp(one));
    for rate in &speeds {
        if *rate < least || !way.is_long_enough(*rate) {
            return Err(hands.texts().refused(format_args!(
                "{rate:.0} mm/s: give speeds from stall_least_speed, {least:.0}, on, that its travel leaves room for"
            )));
        }
    }
    Ok((way, speeds))
}

/// Returns the motor of an axis that no other axis shares, with a driver that measures load.
fn measurable(config: &MachineConfig, axis: Axis) -> Result<Actuator, Failure> {
    let motor = Actuator::from_index(axis as usize).filter(|motor| config.actuators[*motor].present);
    let motor = motor.ok_or_else(|| Failure::refused(&"that axis has no motor"))?;
    if config.stall_thresholds(motor).is_none() {
        return Err(Failure::refused(&"its driver measures no load"));
    }
    let is_alone = config.motion.arm_solution == ArmSolution::Cartesian || !AxisSet::PRIMARY.has(axis);
    let has_slave = config.actuators().any(|(_, other)| other.slaved_to == Some(motor));
    if !is_alone || has_slave {
        return Err(Failure::refused(&"its motor does not move this axis alone: each would have another load"));
    }
    Ok(motor)
}

fn way<'c>(hands: &mut impl PhaseHands<'c>, axis: Axis, motor: Actuator) -> Result<Way, Failure> {
    let limits = hands.motion_config()?.limits;
    let settings = &hands.config().actuators[motor];
    let [least, most] = hands.travel().ends().map(|ends| ends[axis]);
    if !(least.is_finite() && most.is_finite()) || most - least < 4.0 * CLEAR {
        return Err(Failure::refused(&"its travel has no ends that are known, or is too short"));
    }
    let own = limits.actuator_acceleration[motor].map_or(f64::INFINITY, |own| own.0);
    let jerk = limits.axis_jerk.get(axis as usize).copied().flatten().or(limits.jerk).map(|jerk| jerk.0);
    Ok(Way {
        axis,
        motor,
        ends: [least + CLEAR, most - CLEAR],
        full_step: f64::from(settings.microsteps.max(1)) / settings.steps_per_mm,
        acceleration: own.min(limits.acceleration.0),
        jerk,
    })
}

/// Returns three speeds: the rapid speed, as far as the axis reaches it, the slowest at which load can be
/// measured, and the mean of both.
fn usual_speeds<'c>(hands: &mut impl PhaseHands<'c>, way: &Way, least: f64) -> Result<Speeds, Failure> {
    let limits = hands.motion_config()?.limits;
    let axis = limits.axis_speed.get(way.axis as usize).copied().flatten().map_or(f64::INFINITY, |rate| rate.0);
    let mut fast = hands.config().motion.default_seek_rate.0.min(axis).min(limits.actuator_rate[way.motor].0);
    let slow = ABOVE_LEAST * least;
    while !way.is_long_enough(fast) && fast > slow {
        fast *= 0.9;
    }
    if fast < slow {
        return Err(hands
            .texts()
            .refused(format_args!("it can be no faster than {fast:.0} mm/s: its load can be told from {slow:.0} on")));
    }
    let mut speeds = Speeds::new();
    for rate in [fast, libm::sqrt(fast * slow), slow] {
        if speeds.last().is_none_or(|last| rate < 0.95 * last) {
            // The list holds three speeds.
            let _ = speeds.push(rate);
        }
    }
    Ok(speeds)
}
