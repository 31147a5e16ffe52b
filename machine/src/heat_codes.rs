//! Temperatures over M-codes: set, wait, report, gains and limits.

use core::fmt::Write;

use config::{HeaterId, TemperatureConfig, ToolId};
use gcode::Block;
use units::{Celsius, Duty, Micros};

use crate::console::Target;
use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::heat::{Heater, LawSettings, TargetRefused};
use crate::ports::Ports;

/// How often a wait says the temperature.
const WAIT_REPORT: Micros = Micros::from_millis(1_200);
/// Controllers numbered from here are always addressed, whatever tool is selected.
const ALWAYS_ACTIVE: ToolId = ToolId(250);
/// What an unreadable sensor is reported as.
const NO_READING: f32 = -100.0;

/// What a code means to a temperature controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    Set,
    SetAndWait,
    Get,
}

fn meaning(controller: &TemperatureConfig, number: u16) -> Option<Meaning> {
    if number == controller.set_m_code {
        Some(Meaning::Set)
    } else if number == controller.set_and_wait_m_code {
        Some(Meaning::SetAndWait)
    } else if number == controller.get_m_code {
        Some(Meaning::Get)
    } else {
        None
    }
}

impl<P: Ports> Controller<P> {
    /// Runs the code if a temperature controller claims it.
    pub(crate) async fn heat_code(&mut self, number: u16, block: &Block<'_>) -> Result<Option<Answer>, Failure> {
        let claimed = self.config.temperatures.iter().find_map(|controller| meaning(controller, number));
        let Some(what) = claimed else { return Ok(None) };
        if what == Meaning::Get {
            self.report_temperatures(number);
            return Ok(Some(Answer::Said));
        }
        let Some(celsius) = block.get('S') else { return Ok(Some(Answer::Ok)) };
        let heater = self.addressed(number, block.get('T'))?;
        if celsius > 0.0 {
            self.needs_heater(heater)?;
        }
        self.check_target(heater, Celsius(celsius as f32))?;
        self.wait_idle().await?;
        if celsius > 0.0 && !self.ports.supervisor(|supervisor| supervisor.fet_supply_on()) {
            return Err(Failure::alarm("heater supply is off (vfet below 6 V): switch it on, then M999"));
        }
        self.set_temperature(heater, Celsius(celsius as f32))?;
        if what == Meaning::SetAndWait {
            self.wait_for_temperature(heater).await?;
        }
        Ok(Some(Answer::Ok))
    }

    /// Refuses a heater that an error in the configuration keeps off.
    pub(crate) fn needs_heater(&self, id: HeaterId) -> Result<(), Failure> {
        self.needs("temperature control", self.config.heater(id).map_or("", |heater| heater.name.as_str()))
    }

    /// The controller that a set code addresses: by T, else the active tool's, else one that is always active.
    fn addressed(&self, number: u16, tool: Option<f64>) -> Result<HeaterId, Failure> {
        let active = self.tools.active_id();
        let tool = tool.map(|word| ToolId::from_word(word).ok_or(word)).transpose();
        let mut listening = self
            .config
            .heaters()
            .filter(|(_, heater)| matches!(meaning(heater, number), Some(Meaning::Set | Meaning::SetAndWait)));
        let found = listening.find(|(_, heater)| match tool {
            Ok(Some(id)) => heater.tool_id == id,
            Ok(None) => heater.tool_id == active || heater.tool_id >= ALWAYS_ACTIVE,
            Err(_) => false,
        });
        found.map(|(id, _)| id).ok_or_else(|| match tool {
            Ok(Some(id)) => Failure::Refused(message(format_args!("M{number}: no heater answers to T{id}"))),
            Ok(None) => Failure::Refused(message(format_args!("M{number}: the active tool T{active} has no heater"))),
            Err(word) => Failure::Refused(message(format_args!("M{number}: no heater answers to T{word}"))),
        })
    }

    /// The heater that a word names by its `tool_id`. One that nobody has is refused, with those there are.
    pub(crate) fn heater_named(&self, number: u16, letter: char, word: f64) -> Result<HeaterId, Failure> {
        let id = ToolId::from_word(word).and_then(|id| self.config.heater_with(id));
        id.ok_or_else(|| {
            let mut text = message(format_args!("M{number}: no temperature control has tool_id {word}; there are"));
            for (place, (_, heater)) in self.config.heaters().enumerate() {
                let comma = if place == 0 { "" } else { "," };
                // What does not fit any more is left out.
                let _ = write!(text, "{comma} {letter}{} {}", heater.tool_id, heater.name);
            }
            Failure::Refused(text)
        })
    }

    /// What a target means: 1 and 2 stand for the presets.
    fn meant(&self, id: HeaterId, celsius: Celsius) -> Celsius {
        match (celsius.0, self.config.heater(id).map(|heater| heater.presets)) {
            (1.0, Some([first, _])) => first,
            (2.0, Some([_, second])) => second,
            _ => celsius,
        }
    }

    /// Refuses a target that the heater would refuse, before anything waits or changes for it.
    pub(crate) fn check_target(&mut self, id: HeaterId, celsius: Celsius) -> Result<(), Failure> {
        let wanted = self.meant(id, celsius);
        let max = self.ports.heat(|heat| heat.heater(id).map(|heater| heater.settings.max));
        match max.filter(|max| wanted > *max) {
            Some(max) => Err(self.target_refused(id, wanted, TargetRefused::AboveMaximum(max))),
            None => Ok(()),
        }
    }

    fn target_refused(&self, id: HeaterId, wanted: Celsius, why: TargetRefused) -> Failure {
        let name = self.config.heater(id).map_or("?", |heater| heater.name.as_str());
        Failure::Refused(match why {
            TargetRefused::AboveMaximum(max) => {
                message(format_args!("{name}: {:.1} C is above its max_temp {:.1} C", wanted.0, max.0))
            }
            TargetRefused::HasNoHeater => message(format_args!("{name} is a sensor without a heater")),
        })
    }

    /// Sets a target; 1 and 2 stand for the presets.
    pub(crate) fn set_temperature(&mut self, id: HeaterId, celsius: Celsius) -> Result<(), Failure> {
        let wanted = self.meant(id, celsius);
        let now = self.ports.now();
        let set = self.ports.heat(|heat| heat.set_target(id, wanted, now));
        set.map_err(|why| self.target_refused(id, wanted, why))
    }

    /// Switches a heater off, which cannot fail.
    pub(crate) fn switch_heater_off(&mut self, id: HeaterId) {
        let now = self.ports.now();
        // Off is never refused.
        let _ = self.ports.heat(|heat| heat.set_target(id, Celsius(0.0), now));
    }

    /// Waits until the reading has come up to the target.
    pub(crate) async fn wait_for_temperature(&mut self, id: HeaterId) -> Result<(), Failure> {
        let mut report_due = self.ports.now().plus(WAIT_REPORT);
        loop {
            let (halted, heater) = self.ports.heat(|heat| {
                let heater = heat.heater(id).map(|heater| (heater.reading(), heater.target()));
                (heat.is_halted(), heater)
            });
            match heater {
                // A fault has taken the target away. The machine halts at one of the next waiting points; going on to the
                // next line before that would move a machine that must stand.
                _ if halted => {}
                Some((Some(reading), target)) if reading >= target => return Ok(()),
                Some((_, target)) if target.0 > 0.0 => {}
                // Turned off meanwhile: nothing to wait for.
                _ => return Ok(()),
            }
            if self.ports.now() >= report_due {
                report_due = report_due.plus(WAIT_REPORT);
                let target = self.target;
                self.write_temperature(target, id);
                self.say(format_args!("\n"));
            }
            if let Err(failure) = self.pause().await {
                self.say(format_args!("Wait on temperature aborted by kill\n"));
                return Err(failure);
            }
        }
    }

    /// `T:25.0 /0.0 @0`
    pub(crate) fn write_temperature(&mut self, target: Target, id: HeaterId) {
        let Self { ports, config, consoles, .. } = self;
        let Some(controller) = config.heater(id) else { return };
        let shown = ports.heat(|heat| heat.heater(id).map(shown));
        let Some((reading, goal, duty)) = shown else { return };
        consoles.write(target, format_args!("{}:{reading:.1} /{goal:.1} @{duty}", controller.designator));
    }

    /// M105: `ok T:25.0 /0.0 @0 B:24.9 /0.0 @0 `
    fn report_temperatures(&mut self, number: u16) {
        self.say(format_args!("ok "));
        for id in HeaterId::all() {
            if self.config.heater(id).is_some_and(|controller| controller.get_m_code == number) {
                let target = self.target;
                self.write_temperature(target, id);
                self.say(format_args!(" "));
            }
        }
        self.say(format_args!("\n"));
    }

    /// M143 and M301; S is the `tool_id`.
    pub(crate) fn heater_settings_code(&mut self, number: u16, block: &Block<'_>) -> Outcome {
        let Some(word) = block.get('S') else {
            for id in HeaterId::all() {
                self.report_heater_settings(number, id);
            }
            return Ok(Answer::Ok);
        };
        let id = self.heater_named(number, 'S', word)?;
        if block.words().count() == 1 {
            self.report_heater_settings(number, id);
            return Ok(Answer::Ok);
        }
        let changed = self.ports.heat(|heat| match heat.heater_mut(id) {
            Some(heater) if number == 143 => set_maximum(heater, block),
            Some(heater) => set_gains(heater, block),
            None => false,
        });
        if changed { Ok(Answer::Ok) } else { Err(Failure::refused("that cannot be set on this temperature control")) }
    }

    /// Only what heats: a sensor has no gains and no limits.
    fn report_heater_settings(&mut self, number: u16, id: HeaterId) {
        let Self { ports, config, consoles, target, .. } = self;
        let Some((name, tool_id)) = config.heater(id).map(|heater| (&heater.designator, heater.tool_id)) else {
            return;
        };
        let settings = ports.heat(|heat| heat.heater(id).map(|heater| heater.settings.clone()));
        let Some(settings) = settings.filter(|settings| settings.heats) else { return };
        let max_duty = settings.max_duty.0;
        match settings.law {
            _ if number == 143 => {
                let max = settings.max.0;
                consoles.write(*target, format_args!("Maximum temperature for {name}({tool_id}) is {max:.6}\u{b0}C\n"));
            }
            LawSettings::Pid(g) => consoles.write(
                *target,
                format_args!(
                    "{name}(S{tool_id}): PonM: {} P: {:.6} I: {:.6} D: {:.6} X(I_max):{:.6} max pwm: {max_duty} O:0\n",
                    u8::from(g.on_measurement),
                    g.p,
                    g.i,
                    g.d,
                    g.i_max,
                ),
            ),
            LawSettings::BangBang { hysteresis } => consoles.write(
                *target,
                format_args!("{name}(S{tool_id}): bang bang, hysteresis: {:.6} max pwm: {max_duty}\n", hysteresis.0),
            ),
        }
    }
}

fn shown(heater: &Heater) -> (f32, f32, u8) {
    (heater.reading().map_or(NO_READING, |celsius| celsius.0), heater.target().0, heater.duty().0)
}

fn set_maximum(heater: &mut Heater, block: &Block<'_>) -> bool {
    match block.get('P') {
        Some(celsius) if celsius > 0.0 => {
            heater.settings.max = Celsius(celsius as f32);
            true
        }
        _ => false,
    }
}

fn set_gains(heater: &mut Heater, block: &Block<'_>) -> bool {
    let LawSettings::Pid(mut gains) = heater.settings.law else { return false };
    let words = [('P', &mut gains.p), ('I', &mut gains.i), ('D', &mut gains.d), ('X', &mut gains.i_max)];
    for (letter, place) in words {
        *place = block.get(letter).map_or(*place, |value| value as f32);
    }
    gains.on_measurement = block.get('Z').map_or(gains.on_measurement, |value| value == 1.0);
    let max_duty = block.get('Y').map_or(heater.settings.max_duty, |value| Duty(value.clamp(0.0, 255.0) as u8));
    heater.set_law(LawSettings::Pid(gains), max_duty);
    true
}
