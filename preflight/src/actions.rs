//! Effects of actions when nothing is carried out.

use base::failure::{Failure, short};
use base::needs::needs;
use base::own_frame::apart;
use base::ports::MotionPort;
use motion::{Latch, Motion};
use parts::heat_codes::TargetRefusal;
use parts::motion_codes::{self, Limited};
use parts::outputs::{self, Outputs};
use procedures::arms::words::{set_arm_tuning, set_arms};
use procedures::homing;
use program::dry_run::{self, DryRun};
use program::{
    Action, Effect, FileFunction, Function, Geometry, LimitCode, Move, Next, Part, Place, Sequence, Setting, Standing,
    Words,
};
use thermal::{OFF_BELOW, TargetRefused};
use units::{Axis, AxisSet, Celsius, HeaterId, Micros, PerAxis};

use super::cost::Costs;
use super::finding::Kind;
use super::homing as homing_time;
use super::lines::{Reading, Said};
use super::power;
use super::setting_changes;
use super::state::Preflight;

/// Port to the motion object that makes no steps, for codes that set limits.
struct Shadow<'m> {
    motion: &'m mut Motion,
    latch: Latch,
}

impl MotionPort for Shadow<'_> {
    fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        f(self.motion)
    }

    fn latch(&self) -> &Latch {
        &self.latch
    }
}

impl Reading<'_, '_> {
    /// Follows an action, and moves in turns.
    pub(super) async fn action(&mut self, action: &Action<'_>) -> Result<(), Said> {
        if !self.listener.acts(action).map_err(|what| self.say(Kind::Word, what))? {
            return Ok(());
        }
        if let Action::Move(request) = action {
            return self.movement(request).await;
        }
        if action.stands_first() {
            self.standstill().await;
        }
        dry_run::carry_out(self, action)
    }

    /// Follows an output that changes along the path.
    pub(super) fn effect(&mut self, effect: Effect) -> Result<(), Said> {
        match effect {
            Effect::Target { heater, target } => self.target(heater, target),
            Effect::Switch { switch, on, value } => {
                let checked = Outputs::check(self.preflight.texts, self.preflight.config, switch, on, value, true);
                checked.map_err(|failure| self.failed(Kind::Off, failure))?;
                let beyond = outputs::beyond(self.preflight.config, switch, value);
                if let Some(beyond) =
                    beyond.filter(|_| !core::mem::replace(&mut self.preflight.once.spindle_speed, true))
                {
                    self.say(Kind::Speed, short(format_args!("{beyond}")));
                }
                Ok(())
            }
            Effect::Arm { .. } | Effect::Light(_) => Ok(()),
            Effect::Ignored { code, letter } => {
                let text = format_args!("{code} takes no {letter}: the part is the same without");
                self.say(Kind::PassedOver, short(text));
                Ok(())
            }
        }
    }

    fn target(&mut self, heater: HeaterId, target: Celsius) -> Result<(), Said> {
        if let Some(slot) = self.preflight.targets.get_mut(heater.index()) {
            *slot = target;
        }
        if target <= OFF_BELOW {
            return Ok(());
        }
        let config = self.preflight.config;
        needs(self.preflight.texts, config, Part::Heater(heater), true)
            .map_err(|failure| self.failed(Kind::Off, failure))?;
        let Some(settings) = config.heater(heater) else { return Ok(()) };
        let most = self.preflight.most_celsius.get(heater.index()).copied().unwrap_or(settings.max_temp);
        let why = match settings.heater_pin {
            None => TargetRefused::HasNoHeater,
            Some(_) if target > most => TargetRefused::AboveMaximum(most),
            Some(_) => return Ok(()),
        };
        let refusal = TargetRefusal { config, heater, target, why };
        Err(self.say(Kind::TooHot, short(format_args!("{refusal}"))))
    }

    /// Counts a wait for heat, whose duration nobody knows beforehand.
    fn waits_for(&mut self, heater: HeaterId, target: Celsius) {
        let totals = &mut self.preflight.totals;
        totals.heat_waits += 1;
        if let Some((times, most)) = totals.heats.get_mut(heater.index()) {
            *times += 1;
            *most = if target > *most { target } else { *most };
        }
    }

    fn set_limit(&mut self, code: LimitCode, words: &Words<'_>) -> Result<(), Failure> {
        let Preflight { texts, config, program, tuning, travel, asks_of_rapids, .. } = &mut *self.preflight;
        let ports = &mut Shadow { motion: self.motion, latch: Latch::new() };
        motion_codes::set_limit(&mut Limited { texts, ports, config, program, tuning, travel }, code, words)?;
        if words.has('S') {
            *asks_of_rapids |= code == LimitCode::AxisSpeeds && config.motion.compliant_seek_rate;
            if code == LimitCode::Accelerations {
                self.acceleration_is_asked();
            }
        }
        Ok(())
    }

    fn set_steps_per_mm(&mut self, words: &Words<'_>) -> Result<(), Failure> {
        let Self { preflight, motion, .. } = self;
        let shadow = &mut Shadow { motion, latch: Latch::new() };
        motion_codes::set_steps_per_mm(preflight.texts, shadow, preflight.config, preflight.program.tools(), words)
    }

    /// Changes where places of the program lie.
    fn geometry(&mut self, what: Geometry, words: &Words<'_>) -> Result<(), Failure> {
        let Self { preflight, motion, .. } = self;
        match what {
            Geometry::LoadGrid => preflight.loads_mesh = preflight.loads_mesh.or(Some(preflight.line)),
            Geometry::FadeHeight => {
                let (height, target) = preflight.fade;
                preflight.fade = (words.as_length('H').or(height), words.as_length('T').or(target));
            }
            Geometry::ArmSettings => {
                set_arms(preflight.texts, motion, words)?;
                set_arm_tuning(&mut preflight.tuning, preflight.config, words);
            }
            Geometry::Skew => setting_changes::set_skew(preflight.texts, motion, words)?,
            Geometry::BedPlane => setting_changes::set_plane(preflight.texts, motion, words)?,
        }
        preflight.program.resynchronise(motion.commanded_position());
        Ok(())
    }

    /// Notes the acceleration that the file has asked for.
    fn acceleration_is_asked(&mut self) {
        self.preflight.asked_acceleration = self.motion.config().map(|config| config.limits.acceleration.get());
    }

    /// Sets the place where the machine stands now.
    fn stand_at(&mut self, position: PerAxis<f64>) {
        // The machine refuses a place that steps cannot count; then the old place stays.
        let _ = self.motion.set_position(position);
        let position = self.motion.commanded_position();
        self.preflight.program.resynchronise(position);
    }

    // --- time ---

    /// Passes everything submitted, to standstill.
    pub(super) async fn standstill(&mut self) {
        self.motion.flush();
        while self.pass() {
            self.preflight.turn().await;
        }
        if !self.preflight.costs.is_settled() {
            self.settle_costs(Costs::settle_all).await;
        }
        if core::mem::take(&mut self.preflight.moves) {
            let settling = self.preflight.settling;
            self.wait(settling);
        }
    }

    /// Settles the cost of limits so far, in a turn of its own.
    pub(super) async fn settle_costs(&mut self, settle: fn(&mut Costs)) {
        self.preflight.turn_alone().await;
        settle(&mut self.preflight.costs);
        self.preflight.totals.limits = *self.preflight.costs.seconds();
        self.preflight.turn_alone().await;
    }

    fn wait(&mut self, seconds: f64) {
        self.preflight.totals.waiting_seconds += seconds;
        self.listener.waited(self.preflight.begun, seconds);
    }

    /// Passes a block, if one can be begun.
    pub(super) fn pass(&mut self) -> bool {
        let Some(passage) = self.motion.pass_block() else { return false };
        let totals = &mut self.preflight.totals;
        totals.even_seconds += passage.even_seconds;
        totals.ramp_seconds += passage.ramp_seconds;
        self.listener.passed(&passage, self.motion);
        true
    }
}

impl DryRun for Reading<'_, '_> {
    type Outcome = Result<(), Said>;

    fn nothing(&mut self) -> Result<(), Said> {
        Ok(())
    }

    // Moves are made in turns: see `Reading::action`.
    fn moves(&mut self, _request: &Move) -> Result<(), Said> {
        Ok(())
    }

    fn changes(&mut self, effect: Effect) -> Result<(), Said> {
        self.effect(effect)
    }

    fn heats(&mut self, heater: HeaterId, target: Celsius) -> Result<(), Said> {
        self.waits_for(heater, target);
        self.target(heater, target)
    }

    fn waits(&mut self, time: Micros) {
        self.wait(time.0 as f64 * 1e-6);
    }

    fn homes(&mut self, named: AxisSet) {
        let preflight = &mut *self.preflight;
        let (config, here) = (preflight.config, self.motion.commanded_position());
        let axes = homing::chosen(config, named);
        let place = homing::ends_at(config, &preflight.tuning, named, &here);
        let ways = PerAxis(Axis::ALL.map(|axis| libm::fabs(here[axis] - place[axis])));
        let seconds = homing_time::seconds(config, axes, &ways);
        preflight.totals.homing_seconds += seconds;
        preflight.homed = preflight.homed.or(axes);
        self.listener.waited(preflight.begun, seconds);
        self.stand_at(place);
    }

    fn stands_at(&mut self, to: &PerAxis<Option<f64>>, homed: bool) {
        let mut position = self.motion.commanded_position();
        let named = AxisSet::collect(Axis::ALL.into_iter().filter(|axis| to[*axis].is_some()));
        named.axes().for_each(|axis| position[axis] = to[axis].unwrap_or(position[axis]));
        self.stand_at(position);
        if homed {
            self.preflight.homed = self.preflight.homed.or(named);
        }
    }

    fn forgets_homing(&mut self, axes: AxisSet) {
        self.preflight.homed = self.preflight.homed.without(axes);
    }

    fn asks(&mut self) {
        if !core::mem::replace(&mut self.preflight.once.unforeseen, true) {
            let text = "what is found here decides what follows: it is looked at as if nothing had been found";
            self.say(Kind::Unforeseen, short(format_args!("{text}")));
        }
    }

    fn accelerates(&mut self, value: f64) -> Result<(), Said> {
        let shadow = &mut Shadow { motion: self.motion, latch: Latch::new() };
        let set = motion_codes::acceleration(self.preflight.texts, shadow, value);
        set.map_err(|failure| self.failed(Kind::Word, failure))?;
        self.acceleration_is_asked();
        Ok(())
    }

    fn runs(&mut self, function: Function, words: &Words<'_>) -> Result<(), Said> {
        let done = match function {
            Function::File(FileFunction::LabelObject) => {
                self.listener.labelled(self.preflight.begun, words.text().unwrap_or(""));
                Ok(())
            }
            // Without words these only say what is set.
            Function::Limit(_) if words.is_bare() => Ok(()),
            Function::Limit(code) => apart(|| self.set_limit(code, words)),
            Function::Setting(Setting::MaximumTemperature) => setting_changes::set_maximum(self.preflight, words),
            Function::Standing(Standing::StepsPerMm) => apart(|| self.set_steps_per_mm(words)),
            Function::Standing(Standing::Laser) if words.is_bare() => Ok(()),
            Function::Standing(Standing::Laser) => apart(|| power::set(self.preflight, self.motion, words)),
            Function::Geometry(what) => apart(|| self.geometry(what, words)),
            Function::Sequence(Sequence::WaitForHeaters | Sequence::WaitForTargets) => {
                self.preflight.totals.heat_waits += 1;
                Ok(())
            }
            // Neither where nor how fast the machine goes; or it is measured, and only the job itself knows.
            Function::Setting(_) | Function::Standing(_) | Function::Sequence(_) => Ok(()),
            Function::Report(_) | Function::File(_) => Ok(()),
        };
        done.map_err(|failure| self.failed(Kind::Word, failure))
    }

    fn calls(&mut self, number: u32, times: u32) -> Result<(), Said> {
        if self.is_left_in_macros("subroutines") {
            return Ok(());
        }
        let called = self.preflight.program.call(number, times, self.after);
        self.next = called.map_err(|fault| self.say(Kind::Flow, short(format_args!("{fault}"))))?;
        Ok(())
    }

    fn returns(&mut self) -> Result<(), Said> {
        if self.is_left_in_macros("subroutines") {
            return Ok(());
        }
        self.next = self.preflight.program.end_call().unwrap_or(Next::At(Place::default()));
        // M99 of the main program begins it anew, for ever.
        self.preflight.has_ended |= self.next == Next::At(Place::default());
        Ok(())
    }

    fn ends(&mut self) -> Result<(), Said> {
        self.preflight.program.end_program();
        self.preflight.has_ended = true;
        Ok(())
    }

    fn halts(&mut self) -> Result<(), Said> {
        Err(self.say(Kind::Unforeseen, short(format_args!("M112 halts the machine"))))
    }
}
