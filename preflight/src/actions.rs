//! Effects of actions when nothing is carried out.

use base::apart::apart;
use base::failure::{Failure, short};
use base::needs::needs;
use base::ports::MotionPort;
use motion::{Latch, Motion};
use parts::motion_codes;
use parts::outputs::{self, Outputs};
use program::{Action, Effect, Function, Next, Part, Place, Words};
use thermal::OFF_BELOW;
use units::{Axis, AxisSet, Celsius, HeaterId, PerAxis};

use super::cost::Costs;
use super::finding::Kind;
use super::homing;
use super::lines::{Reading, Said};
use super::settings;

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
    pub(super) async fn action(&mut self, action: &Action<'_>, next: &mut Next) -> Result<(), Said> {
        match *action {
            Action::Move(ref request) => return self.movement(request).await,
            Action::Effect(effect) => return self.effect(effect),
            Action::Dwell(time) | Action::Pause { time: Some(time), .. } => {
                self.standstill().await;
                self.wait(time.0 as f64 * 1e-6);
            }
            Action::HeatAndWait { heater, target, .. } => {
                self.standstill().await;
                self.waits_for(heater, target);
                return self.target(heater, target);
            }
            Action::Home(axes) => self.home(axes).await,
            Action::SetPosition { ref to, homed } => self.set_position(to, homed).await,
            Action::ForgetHoming(axes) => self.preflight.homed = self.preflight.homed.without(axes),
            Action::Acceleration(value) => {
                let set = motion_codes::acceleration(self.preflight.texts, &mut self.shadow(), value);
                set.map_err(|failure| self.failed(Kind::Word, failure))?;
                self.acceleration_is_asked();
            }
            Action::Function(function, ref words) => return self.function(function, words).await,
            Action::EndProgram => {
                self.standstill().await;
                self.preflight.program.end_program();
                self.preflight.has_ended = true;
            }
            Action::Call { number, times } => match self.preflight.program.call(number, times, self.after) {
                Ok(place) => *next = place,
                Err(fault) => return Err(self.say(Kind::Flow, short(format_args!("{fault}")))),
            },
            Action::Return => {
                *next = self.preflight.program.end_call().unwrap_or(Next::At(Place::default()));
                if *next == Next::At(Place::default()) {
                    // M99 of the main program begins it anew, for ever.
                    self.preflight.has_ended = true;
                }
            }
            Action::Finish | Action::Overrides { .. } | Action::Orient { .. } => self.standstill().await,
            Action::ProbeDown(_) | Action::ProbeAlong(_) | Action::AwaitInput(_) => {
                self.standstill().await;
                self.unforeseen();
            }
            Action::Pause { time: None, .. }
            | Action::ChangeTool(_)
            | Action::Suspend { .. }
            | Action::RetractByHand => {
                self.standstill().await;
            }
            Action::Halt => return Err(self.say(Kind::Unforeseen, short(format_args!("M112 halts the machine")))),
            _ => {}
        }
        Ok(())
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
        let name = settings.name.as_str();
        if settings.heater_pin.is_none() {
            return Err(self.say(Kind::TooHot, short(format_args!("{name} is a sensor without a heater"))));
        }
        if target > most {
            let text = format_args!("{name}: {:.1} C is above its max_temp {:.1} C", target.0, most.0);
            return Err(self.say(Kind::TooHot, short(text)));
        }
        Ok(())
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

    fn shadow(&mut self) -> Shadow<'_> {
        Shadow { motion: self.motion, latch: Latch::new() }
    }

    /// Follows those of the machine's functions that change where and how fast it may go.
    async fn function(&mut self, function: Function, words: &Words<'_>) -> Result<(), Said> {
        let set = match function {
            Function::LabelObject => {
                self.listener.labelled(self.preflight.begun, words.text().unwrap_or(""));
                Ok(())
            }
            Function::BedPlane => self.set(function, words).await,
            _ if words.is_bare()
                && !matches!(function, Function::LoadGrid | Function::WaitForHeaters | Function::WaitForTargets) =>
            {
                Ok(())
            }
            Function::WaitForHeaters | Function::WaitForTargets => {
                self.standstill().await;
                self.preflight.totals.heat_waits += 1;
                Ok(())
            }
            Function::StepsPerMm => {
                self.standstill().await;
                apart(|| self.set_steps_per_mm(words))
            }
            _ => match apart(|| self.set_limits(function, words)) {
                Some(set) => set,
                None => self.set(function, words).await,
            },
        };
        set.map_err(|failure| self.failed(Kind::Word, failure))
    }

    fn set_steps_per_mm(&mut self, words: &Words<'_>) -> Result<(), Failure> {
        let Self { preflight, motion, .. } = self;
        let shadow = &mut Shadow { motion, latch: Latch::new() };
        motion_codes::set_steps_per_mm(preflight.texts, shadow, preflight.config, preflight.program.tools(), words)
    }

    /// Sets limits of speed or place for axes and motors. `None` for every other function.
    fn set_limits(&mut self, function: Function, words: &Words<'_>) -> Option<Result<(), Failure>> {
        let Self { preflight, motion, .. } = self;
        let (texts, config, tools) = (preflight.texts, preflight.config, preflight.program.tools());
        let shadow = &mut Shadow { motion, latch: Latch::new() };
        Some(match function {
            Function::AxisSpeeds => motion_codes::set_axis_speeds(texts, shadow, config, tools, words).map(|rate| {
                if let Some(rate) = rate {
                    preflight.program.set_seek_rate(rate);
                    preflight.asks_of_rapids = true;
                }
            }),
            Function::MotorSpeeds => motion_codes::set_motor_speeds(texts, shadow, config, tools, words).map(drop),
            Function::Accelerations => motion_codes::accelerations(texts, shadow, config, tools, words).map(|_| {
                if words.has('S') {
                    self.acceleration_is_asked();
                }
            }),
            Function::CornerSettings => motion_codes::corner_settings(texts, shadow, words).map(drop),
            Function::Jerk => motion_codes::jerk(texts, shadow, words).map(drop),
            Function::SpeedFactor => {
                motion_codes::set_speed_factor(preflight.program, words);
                Ok(())
            }
            Function::SoftEndstops => {
                if let Some(on) = words.get('S') {
                    preflight.travel.switch(on != 0.0);
                }
                Ok(())
            }
            _ => return None,
        })
    }

    async fn set(&mut self, function: Function, words: &Words<'_>) -> Result<(), Failure> {
        if settings::stands_first(function) {
            self.standstill().await;
        }
        settings::set(self.preflight.texts, self.preflight, self.motion, function, words)?;
        if settings::stands_first(function) {
            self.preflight.program.resynchronise(self.motion.commanded_position());
        }
        Ok(())
    }

    /// Notes the acceleration that the file has asked for.
    fn acceleration_is_asked(&mut self) {
        self.preflight.asked_acceleration = self.motion.config().map(|config| config.limits.acceleration.get());
    }

    /// Notes that the rest of the file depends on results that only the job has.
    fn unforeseen(&mut self) {
        if !core::mem::replace(&mut self.preflight.once.unforeseen, true) {
            let text = "what is found here decides what follows: it is looked at as if nothing had been found";
            self.say(Kind::Unforeseen, short(format_args!("{text}")));
        }
    }

    // --- places ---

    async fn set_position(&mut self, to: &PerAxis<Option<f64>>, homed: bool) {
        self.standstill().await;
        let mut position = self.motion.commanded_position();
        let named = AxisSet::collect(Axis::ALL.into_iter().filter(|axis| to[*axis].is_some()));
        named.axes().for_each(|axis| position[axis] = to[axis].unwrap_or(position[axis]));
        self.stand_at(position);
        if homed {
            self.preflight.homed = self.preflight.homed.or(named);
        }
    }

    /// Sets the place where the machine stands now.
    fn stand_at(&mut self, position: PerAxis<f64>) {
        // The machine refuses a place that steps cannot count; then the old place stays.
        let _ = self.motion.set_position(position);
        let position = self.motion.commanded_position();
        self.preflight.program.resynchronise(position);
    }

    async fn home(&mut self, named: AxisSet) {
        self.standstill().await;
        let preflight = &mut *self.preflight;
        let here = self.motion.commanded_position();
        let homed = homing::foresee(preflight.config, &preflight.tuning, preflight.can_home, named, &here);
        preflight.totals.homing_seconds += homed.seconds;
        preflight.homed = preflight.homed.or(homed.axes);
        self.listener.waited(preflight.begun, homed.seconds);
        self.stand_at(homed.place);
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
