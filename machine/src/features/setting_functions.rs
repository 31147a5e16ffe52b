//! Functions that set something: limits, currents, places, parts of the machine.

use base::axes::Axes;
use base::bed::Bed;
use base::failure::{Answer, Outcome};
use base::motors;
use base::own_frame::apart;
use base::ports::Clock as _;
use base::safety::travel::Travel;
use base::sessions::{Recipient, Reply};
use base::tuning::Tuning;
use base::{CodeContext, Ports, World};
use parts::motion_codes::Limited;
use parts::z_thermal::Thermal;
use parts::{driver_codes, heat_codes, laser, motion_codes};
use procedures::endstop_phase::EndstopPhases;
use procedures::probing;
use procedures::{arms, autotune, endstop_phase, leveling};
use program::{Interpreter, LimitCode, Setting, Standing, Words};
use units::AxisSet;

use crate::machine::work_hands::MoveHands;
use crate::machine::{Machine, program_io};

/// Parts of the machine that functions set.
pub(crate) struct Settable<'m, 'c, P> {
    world: &'m mut World<'c, P>,
    program: &'m mut Interpreter,
    axes: &'m mut Axes,
    bed: &'m mut Bed,
    tuning: &'m mut Tuning,
    thermal: &'m mut Thermal,
    phases: &'m mut EndstopPhases,
    travel: &'m mut Travel,
}

/// The machine for functions that set something.
pub(crate) trait SettableHands<'c>: MoveHands<'c> {
    /// Returns the parts of the machine that functions set.
    fn settable(&mut self) -> Settable<'_, 'c, Self::Ports>;

    /// Reports the speed factor, or sets it beside a job that is played. False: it is the program's.
    fn speed_factor(&mut self, words: &Words<'_>, to: Recipient) -> bool;

    /// Marks axes as homed on somebody's word for their places.
    fn declare_homed(&mut self, axes: AxisSet);
}

impl<'c, P: Ports> SettableHands<'c> for Machine<'c, P> {
    fn settable(&mut self) -> Settable<'_, 'c, P> {
        let Self { world, program, axes, bed, tuning, thermal, phases, safety, .. } = self;
        Settable { world, program, axes, bed, tuning, thermal, phases, travel: &mut safety.travel }
    }

    fn speed_factor(&mut self, words: &Words<'_>, to: Recipient) -> bool {
        let is_beside = self.jobs.is_open() && self.jobs.made(self.tag).is_none();
        program_io::speed_factor(&mut self.world, &self.program, &mut self.feed_waits, is_beside, words, to)
    }

    fn declare_homed(&mut self, axes: AxisSet) {
        self.declare_homed(axes);
    }
}

/// Carries out a function that needs standstill.
pub(crate) fn set_standing<'c>(
    hands: &mut impl SettableHands<'c>,
    setting: Standing,
    words: &Words<'_>,
    to: Recipient,
) -> Outcome {
    if setting == Standing::HomeOffsetsFromHere && words.has('T') {
        return apart(|| autotune::tune_model(&mut hands.sequence(to), words));
    }
    let Settable { program, axes, tuning, world: World { ports, sessions, config, texts }, .. } = hands.settable();
    let code = CodeContext { texts, ports, config, words, reply: &mut Reply::new(sessions, to) };
    match setting {
        Standing::Microsteps => motors::microsteps(code),
        Standing::DriverRegister => motors::write_register(code),
        Standing::StealthThresholds => driver_codes::stealth_thresholds(code, tuning),
        Standing::StealthMode => driver_codes::stealth_mode(code, tuning),
        Standing::MotorPositions => arms::motor_positions(code).inspect(|_| hands.declare_homed(words.axes())),
        Standing::HomeOffsetsFromHere => arms::home_offsets_from_here(code, axes, tuning),
        Standing::StepsPerMm => motion_codes::steps_per_mm(code, program.tools()),
        Standing::PressureAdvance => motion_codes::pressure_advance(code, program.tools()),
        Standing::InputShaping => motion_codes::input_shaping(code),
        Standing::Laser => laser::settings(code, tuning, program),
        Standing::MotorsOff => {
            let extruder = program.tools().active().map(|tool| tool.settings.axis).filter(|_| words.has('E'));
            let named = extruder.map_or(words.axes(), |axis| words.axes().with(axis));
            axes.disable(code.ports, if named.is_empty() && !words.has('E') { AxisSet::ALL } else { named });
            Ok(Answer::Ok)
        }
    }
}

/// Carries out a function that sets limits.
pub(crate) fn limit<'c>(
    hands: &mut impl SettableHands<'c>,
    code: LimitCode,
    words: &Words<'_>,
    to: Recipient,
) -> Outcome {
    if code == LimitCode::SpeedFactor && hands.speed_factor(words, to) {
        return Ok(Answer::Ok);
    }
    let Settable { program, travel, tuning, world: World { ports, sessions, config, texts }, .. } = hands.settable();
    let on = &mut Limited { texts, ports, config, program, tuning, travel };
    if !words.is_bare() {
        motion_codes::set_limit(on, code, words)?;
    }
    motion_codes::report_limit(on, code, words, &mut Reply::new(sessions, to)).map(ok)
}

/// Carries out a function that sets something.
pub(crate) fn set<'c>(
    hands: &mut impl SettableHands<'c>,
    setting: Setting,
    words: &Words<'_>,
    to: Recipient,
) -> Outcome {
    let Settable { axes, bed, tuning, thermal, phases, world: World { ports, sessions, config, texts }, .. } =
        hands.settable();
    let now = ports.now();
    let code = CodeContext { texts, ports, config, words, reply: &mut Reply::new(sessions, to) };
    match setting {
        Setting::MotorsOn => axes.enable(texts, code.ports, config, tuning, now).map(ok),
        Setting::EndstopPhase => endstop_phase::endstop_phase(code, phases, tuning),
        Setting::MotorMilliamps | Setting::MotorAmps => motors::motor_currents(code, axes, tuning),
        Setting::ProbeSettings => probing::probe_settings(tuning, words, code.reply),
        Setting::ThermalAdjust => thermal.command(words, code.reply),
        Setting::ProbePoint => leveling::probe_point(bed, words, code.reply),
        Setting::ProbeOffset => leveling::probe_offset(bed, words, code.reply),
        Setting::AxisTwist => leveling::axis_twist(bed, words, code.reply),
        Setting::MarlinProbeOffset => leveling::marlin_probe_offset(bed, words, code.reply),
        Setting::MaximumTemperature => heat_codes::maximum_temperature(code),
        Setting::PidGains => heat_codes::pid_gains(code),
        Setting::HeaterModel => heat_codes::heater_model(code),
        Setting::Sensor => heat_codes::sensors(code, tuning),
        Setting::DriverChopper => motors::describe_choppers(code),
        Setting::DriverOption => motors::driver_option(code, tuning),
        Setting::ForgetDriverTroubles => driver_codes::forget_told(code),
        Setting::HomingThresholds => driver_codes::homing_thresholds(texts, config, tuning, words, code.reply),
    }
}

const fn ok((): ()) -> Answer {
    Answer::Ok
}
