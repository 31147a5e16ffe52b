//! The laser beside the path: its lock, its beam at rest, and the codes of its scale.

use base::CodeContext;
use base::failure::{Answer, Failure, Outcome, Texts};
use base::laser::LaserScale;
use base::ports::{LaserPort, MotionPort};
use base::reason::Reason;
use base::tuning::Tuning;
use config::MachineConfig;
use program::{Interpreter, LaserSetup, State, Words};
use units::{Micros, STEP_CLOCK_HZ};

/// Time of `fire` where none is given, milliseconds.
const USUAL_MS: f64 = 1e3;
/// Longest time of `fire`, milliseconds.
const MOST_MS: f64 = 60e3;
/// Longest time of a beam at rest.
const LONGEST: Micros = Micros::from_seconds(60);

/// Beam that `fire` has lit while the machine stands.
#[derive(Clone, Copy, Debug)]
struct Fire {
    duty: u16,
    until: Micros,
}

/// Whether the laser may burn, and its beam at rest.
#[derive(Clone, Debug, Default)]
pub struct Beam {
    /// Whether the port has been told that the laser is locked; it is, at the start.
    is_unlocked: bool,
    /// Whether the port has been told to keep the output off for a hold.
    is_dark: bool,
    /// Beam that `fire` asked for.
    fire: Option<Fire>,
    /// Duty at rest that the program asks for without laser mode, and since when.
    asked: (u16, Micros),
    /// Duty at rest that the port has been told.
    given: u16,
    /// Whether an open interlock was told.
    pub told_open: bool,
    /// Whether power has gone off by itself: locked until the machine rests, or is told to go on.
    has_lapsed: bool,
}

impl Beam {
    /// Locks the laser off, or lets the path's power through.
    pub fn lock(&mut self, port: &mut impl LaserPort, is_locked: bool) {
        if is_locked {
            (self.fire, self.given) = (None, 0);
        }
        if self.is_unlocked == is_locked {
            port.lock_laser(is_locked);
            self.is_unlocked = !is_locked;
        }
    }

    /// Locks the laser, keeps its output off for a hold, or both. What ends power comes before what lets it
    /// through.
    pub fn shut(&mut self, port: &mut impl LaserPort, is_locked: bool, is_dark: bool) {
        if is_dark {
            self.darken(port, true);
        }
        self.lock(port, is_locked);
        self.darken(port, is_dark);
    }

    /// Keeps the output off while the machine holds, or lets the path's power come out again.
    pub fn darken(&mut self, port: &mut impl LaserPort, is_dark: bool) {
        if self.is_dark != is_dark {
            port.darken_laser(is_dark);
            self.is_dark = is_dark;
        }
    }

    /// Looks whether the laser has locked itself. Returns true when it just has and there is something to
    /// tell: it burnt, or should burn on along a path. It is locked then until the machine rests, or
    /// [`Self::goes_on`].
    pub fn lapses(&mut self, port: &mut impl LaserPort, rests: bool) -> bool {
        let has_locked_itself = port.look_at_laser();
        let lapses = has_locked_itself && (self.given != 0 || !rests);
        if has_locked_itself {
            self.force_off(port);
        }
        self.has_lapsed = lapses || self.has_lapsed && !rests;
        lapses
    }

    /// Whether power has gone off by itself, and neither rest nor going on has come since.
    #[must_use]
    pub const fn has_lapsed(&self) -> bool {
        self.has_lapsed
    }

    /// The machine goes on after a hold.
    pub fn goes_on(&mut self) {
        self.has_lapsed = false;
    }

    /// Locks the laser off whatever was told before.
    pub fn force_off(&mut self, port: &mut impl LaserPort) {
        self.is_unlocked = true;
        self.lock(port, true);
    }

    /// Ends the beam at rest, before anything moves.
    #[inline]
    pub fn end(&mut self, port: &mut impl LaserPort) {
        self.fire = None;
        if self.given != 0 {
            self.give(port, 0);
        }
    }

    fn give(&mut self, port: &mut impl LaserPort, duty: u16) {
        if duty != self.given {
            self.given = duty;
            port.set_laser(duty);
        }
    }

    /// Has the beam at rest follow time, and the duty that the program asks for without laser mode. No beam
    /// stays for longer than a minute, and one that `fire` asked for ends as the machine moves, whatever has
    /// it move: it must not come back at another place.
    pub fn look(&mut self, port: &mut impl LaserPort, now: Micros, rests: bool, asked: u16) {
        if self.asked.0 != asked {
            self.asked = (asked, now);
        }
        self.fire = self.fire.filter(|fire| rests && now < fire.until);
        let is_fresh = now < self.asked.1.plus(LONGEST);
        let duty = self.fire.map_or(if is_fresh { asked } else { 0 }, |fire| fire.duty);
        self.give(port, if rests && self.is_unlocked { duty } else { 0 });
    }

    /// `fire percent [ms] | off | status`: the beam at rest.
    ///
    /// # Errors
    /// With the reason, where it may not be.
    pub fn fire(
        &mut self,
        texts: &Texts,
        port: &mut impl LaserPort,
        now: Micros,
        most: f32,
        arguments: &str,
    ) -> Result<f32, Failure> {
        let mut words = arguments.split_whitespace();
        let (percent, ms) = match (words.next(), words.next(), words.next()) {
            (Some("off"), None, None) => {
                self.end(port);
                return Ok(0.0);
            }
            (None | Some("status"), None, None) => return Ok(self.percent(most)),
            (Some(percent), ms, None) => (gcode::read_f64(percent), ms.map_or(Some(USUAL_MS), gcode::read_f64)),
            _ => (None, None),
        };
        let percent = percent.filter(|percent| (0.0..=100.0).contains(percent));
        let (Some(percent), Some(ms)) = (percent, ms.filter(|ms| (1.0..=MOST_MS).contains(ms))) else {
            return Err(texts.because("fire takes percent, 0 to 100, and ms, 1 to 60000; or off, or status"));
        };
        if !self.is_unlocked {
            return Err(texts.because("the laser is locked: close the door and its interlocks"));
        }
        let duty = (percent as f32 / 100.0 * most * f32::from(u16::MAX) + 0.5) as u16;
        self.fire = Some(Fire { duty, until: now.plus(Micros((ms * 1e3) as u64)) });
        self.give(port, duty);
        Ok(percent as f32)
    }

    /// Returns the power that comes out, a share of full power, while the path has this one; and whether it
    /// is the beam that `fire` has lit.
    #[must_use]
    pub fn power(&self, most: f32, path: f32) -> (f32, bool) {
        let share = if self.given != 0 { self.percent(most) / 100.0 } else { path };
        (if self.is_unlocked && !self.is_dark { share } else { 0.0 }, self.fire.is_some() && self.given != 0)
    }

    /// Returns the beam at rest, percent of full power.
    fn percent(&self, most: f32) -> f32 {
        f32::from(self.given) / f32::from(u16::MAX) / most.max(f32::EPSILON) * 100.0
    }
}

/// Returns the duty at rest that the program asks for: S, while M3 or M4 is in force without laser mode.
#[must_use]
pub fn asked_at_rest(program: &Interpreter, scale: &LaserScale, config: &MachineConfig) -> u16 {
    let is_on = program.modal().auxiliary.spindle != program::Spindle::Stopped;
    if !is_on || program::laser::of(program).is_none_or(|laser| laser.is_laser_mode) {
        return 0;
    }
    (f32::from(scale.level(program.modal().power)) * config.laser.maximum_power) as u16
}

/// Returns whether a laser is locked in this state of the machine.
#[must_use]
pub const fn locks(state: State) -> bool {
    matches!(state, State::Alarm | State::Sleep | State::Invalid | State::Door | State::Check)
}

/// M452, and M221 on a machine with a laser: scale of S, laser mode, factor of every power, frequency.
///
/// # Errors
/// Without a laser, and where the words contradict each other.
pub fn settings<P: MotionPort + LaserPort>(
    code: CodeContext<'_, P>,
    tuning: &mut Tuning,
    program: &mut Interpreter,
) -> Outcome {
    let (words, scale) = (code.words, &mut tuning.laser);
    let Some(laser) = program::laser::of(program) else {
        return Err(Failure::refused(&"there is no laser: see [laser]").with_reason(Reason::NoLaserOutput));
    };
    if words.is_bare() {
        tell(code, words.code().number == 452, scale, laser);
        return Ok(Answer::Ok);
    }
    let (new, laser) = changed(code.texts, words, *scale, laser)?;
    if let (221, Some(hertz)) = (words.code().number, words.get('R')) {
        code.ports.set_laser_frequency(hertz as u32);
    }
    let in_motion = new.in_motions_terms(code.config);
    let taken = code.ports.motion(|motion| motion.configure_laser(in_motion));
    taken.map_err(|error| code.texts.refused(format_args!("{error}")))?;
    *scale = new;
    program::laser::set(program, laser);
    Ok(Answer::Ok)
}

/// Returns scale and modes of a laser after M452 or M221.
///
/// # Errors
/// Where the words contradict each other.
pub fn changed(
    texts: &Texts,
    words: &Words<'_>,
    mut scale: LaserScale,
    mut laser: LaserSetup,
) -> Result<(LaserScale, LaserSetup), Failure> {
    if words.code().number == 452 {
        scale.least_s = words.get('L').map_or(scale.least_s, |s| s as f32);
        if let Some(most) = words.get('R') {
            scale.set_most(most as f32);
        }
        if scale.least_s >= scale.most_s {
            let text = format_args!("L, the S of the least power, must be below R, {}", scale.most_s);
            return Err(texts.refused(text));
        }
        if let Some(is_on) = words.get('S') {
            laser.is_laser_mode = is_on != 0.0;
        }
    } else {
        if let Some(factor) = words.get('S') {
            scale.set_factor(factor as f32);
        }
        if let Some(is_constant) = words.get('P') {
            laser.always_by_speed = is_constant == 0.0;
        }
    }
    Ok((scale, laser))
}

fn tell<P>(code: CodeContext<'_, P>, is_scale: bool, scale: &LaserScale, laser: LaserSetup) {
    if is_scale {
        let mode = if laser.is_laser_mode { "on" } else { "off" };
        let law = if laser.always_by_speed { "M3 by the speed" } else { "M3 constant" };
        let LaserScale { least_s, most_s, .. } = scale;
        code.reply.say(format_args!("Laser mode {mode}, full power at S{most_s}, least power at S{least_s}, {law}\n"));
        if let Some(of) = scale.in_motions_terms(code.config) {
            let [on, off] = [of.on_delay, of.off_delay].map(|ticks| ticks / (STEP_CLOCK_HZ / 1_000_000) as i32);
            code.reply.say(format_args!("on {on} us and off {off} us late, {} points of power\n", of.curve.count));
        }
    } else {
        // Smoothieware's line.
        let (percent, is_constant) = (scale.factor() * 100.0, u8::from(!laser.always_by_speed));
        code.reply.say(format_args!("Laser power: {percent:6.2} %, disable auto power: {is_constant}\n"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Port that keeps what it was told.
    #[derive(Default)]
    struct Told {
        locked: Vec<bool>,
        duties: Vec<u16>,
        has_lapsed: bool,
    }

    impl LaserPort for Told {
        fn lock_laser(&mut self, is_locked: bool) {
            self.locked.push(is_locked);
        }

        fn darken_laser(&mut self, _: bool) {}

        fn set_laser(&mut self, duty: u16) {
            self.duties.push(duty);
        }

        fn look_at_laser(&mut self) -> bool {
            core::mem::take(&mut self.has_lapsed)
        }

        fn set_laser_frequency(&mut self, _: u32) {}
    }

    const fn at(ms: u64) -> Micros {
        Micros(ms * 1_000)
    }

    #[test]
    fn fire_ends_by_itself_by_a_line_and_by_a_lock() {
        let (texts, mut port, mut beam) = (Texts::new(), Told::default(), Beam::default());
        assert!(beam.fire(&texts, &mut port, at(0), 1.0, "5").is_err(), "it is locked at the start");
        beam.lock(&mut port, false);
        assert_eq!(beam.fire(&texts, &mut port, at(0), 0.5, "100").ok(), Some(100.0));
        beam.look(&mut port, at(999), true, 0);
        beam.look(&mut port, at(1_000), true, 0);
        assert_eq!(port.duties, [32_768, 0], "half of the duty is full power");
        assert!(beam.fire(&texts, &mut port, at(2_000), 1.0, "5 60000").is_ok());
        beam.end(&mut port);
        beam.look(&mut port, at(2_001), true, 0);
        assert_eq!(port.duties[2..], [3_277, 0]);
        assert!(beam.fire(&texts, &mut port, at(2_000), 1.0, "5 60000").is_ok());
        beam.look(&mut port, at(2_001), false, 0);
        beam.look(&mut port, at(2_002), true, 0);
        assert_eq!(port.duties[4..], [3_277, 0], "a motion ends it for good");
        port.duties.clear();
        assert!(beam.fire(&texts, &mut port, at(2_000), 1.0, "5").is_ok());
        beam.lock(&mut port, true);
        beam.lock(&mut port, true);
        beam.look(&mut port, at(2_001), true, 0);
        assert_eq!((port.locked, port.duties.len()), (vec![false, true], 1), "the lock itself is off");
    }

    #[test]
    fn power_that_went_off_by_itself_is_not_given_again() {
        let (texts, mut port, mut beam) = (Texts::new(), Told::default(), Beam::default());
        beam.lock(&mut port, false);
        assert!(beam.fire(&texts, &mut port, at(0), 1.0, "5").is_ok());
        assert!(!beam.lapses(&mut port, true));
        port.has_lapsed = true;
        beam.end(&mut port);
        assert!(!beam.lapses(&mut port, true), "nothing to tell of a dark laser at rest");
        beam.lock(&mut port, false);
        (port.locked, port.duties) = (vec![false], Vec::new());
        port.has_lapsed = true;
        assert!(beam.lapses(&mut port, false) && !beam.lapses(&mut port, false) && beam.has_lapsed());
        assert!(!beam.lapses(&mut port, true) && !beam.has_lapsed(), "rest ends it");
        beam.lock(&mut port, false);
        beam.look(&mut port, at(1), true, 0);
        assert_eq!((port.locked, port.duties.len()), (vec![false, true, false], 0));
    }

    #[test]
    fn fire_takes_nothing_else() {
        let (texts, mut port, mut beam) = (Texts::new(), Told::default(), Beam::default());
        beam.lock(&mut port, false);
        for wrong in ["-1", "101", "x", "5 0", "5 60001", "5 x", "5 5 5", "off 5"] {
            assert!(beam.fire(&texts, &mut port, at(0), 1.0, wrong).is_err(), "{wrong}");
        }
        assert!(port.duties.is_empty());
        assert!(beam.fire(&texts, &mut port, at(0), 1.0, "40 10").is_ok());
        assert!((beam.fire(&texts, &mut port, at(1), 1.0, "status").unwrap_or(0.0) - 40.0).abs() < 0.01);
        assert_eq!(beam.fire(&texts, &mut port, at(1), 1.0, "off").ok(), Some(0.0));
        assert_eq!(port.duties.last(), Some(&0));
    }

    #[test]
    fn without_laser_mode_s_is_the_power_at_rest_for_a_minute() {
        let (mut port, mut beam) = (Told::default(), Beam::default());
        beam.lock(&mut port, false);
        beam.look(&mut port, at(5_000), true, 300);
        beam.look(&mut port, at(6_000), false, 300);
        beam.look(&mut port, at(7_000), true, 300);
        beam.look(&mut port, at(65_000), true, 300);
        assert_eq!(port.duties, [300, 0, 300, 0]);
        beam.look(&mut port, at(66_000), true, 400);
        assert_eq!(port.duties.last(), Some(&400));
    }
}
