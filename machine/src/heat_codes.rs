//! Temperatures over M-codes: set, wait, report, gains and limits.

use config::TemperatureConfig;
use gcode::Block;
use units::{Celsius, Duty, Micros};

use crate::console::Target;
use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::heat::{Heater, LawSettings};
use crate::ports::Ports;

/// How often a wait says the temperature.
const WAIT_REPORT: Micros = Micros::from_millis(1_200);
/// Controllers numbered from here are always addressed, whatever tool is selected.
const ALWAYS_ACTIVE: u8 = 250;
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
        let Some(index) = self.addressed(number, block.get('T')) else {
            return Err(Failure::Refused(message(format_args!("M{number}: no heater answers to that tool"))));
        };
        if celsius > 0.0 {
            let name = self.config.temperatures.get(index).map_or("", |controller| controller.name.as_str());
            self.needs("temperature control", name)?;
        }
        self.wait_idle().await?;
        if celsius > 0.0 && !self.ports.supervisor(|supervisor| supervisor.fet_supply_on()) {
            return Err(Failure::alarm("heater supply is off (vfet below 6 V): switch it on, then M999"));
        }
        self.set_temperature(index, celsius as f32);
        if what == Meaning::SetAndWait {
            self.wait_for_temperature(index).await?;
        }
        Ok(Some(Answer::Ok))
    }

    /// The controller that a set code addresses: by T, else the active tool's, else one that is always active.
    fn addressed(&self, number: u16, tool: Option<f64>) -> Option<usize> {
        let active = self.tools.active_id();
        self.config.temperatures.iter().position(|controller| {
            let listens = matches!(meaning(controller, number), Some(Meaning::Set | Meaning::SetAndWait));
            listens
                && match tool {
                    Some(id) => f64::from(controller.tool_id) == id,
                    None => controller.tool_id == active || controller.tool_id >= ALWAYS_ACTIVE,
                }
        })
    }

    /// Sets a target; 1 and 2 stand for the presets. Says so when it had to be cut.
    pub(crate) fn set_temperature(&mut self, index: usize, celsius: f32) {
        let Some(controller) = self.config.temperatures.get(index) else { return };
        let wanted = match (celsius, controller.presets) {
            (1.0, [first, _]) => first,
            (2.0, [_, second]) => second,
            _ => Celsius(celsius),
        };
        let now = self.ports.now();
        let set = self.ports.heat(|heat| heat.set_target(index, wanted, now));
        if let Some(set) = set.filter(|set| set.0 > 0.0 && *set < wanted) {
            let name = self.config.temperatures.get(index).map_or("?", |controller| controller.designator.as_str());
            self.consoles.write(
                Target::All,
                format_args!("// WARNING {name}: {:.1} is above max_temp, set to {:.1}\n", wanted.0, set.0),
            );
        }
    }

    /// Waits until the reading has come up to the target.
    pub(crate) async fn wait_for_temperature(&mut self, index: usize) -> Result<(), Failure> {
        let mut report_due = self.ports.now().plus(WAIT_REPORT);
        loop {
            let (halted, heater) = self.ports.heat(|heat| {
                let heater = heat.heaters().get(index).map(|heater| (heater.reading(), heater.target()));
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
                self.write_temperature(target, index);
                self.say(format_args!("\n"));
            }
            if let Err(failure) = self.pause().await {
                self.say(format_args!("Wait on temperature aborted by kill\n"));
                return Err(failure);
            }
        }
    }

    /// `T:25.0 /0.0 @0`
    pub(crate) fn write_temperature(&mut self, target: Target, index: usize) {
        let Self { ports, config, consoles, .. } = self;
        let Some(controller) = config.temperatures.get(index) else { return };
        let shown = ports.heat(|heat| heat.heaters().get(index).map(shown));
        let Some((reading, goal, duty)) = shown else { return };
        consoles.write(target, format_args!("{}:{reading:.1} /{goal:.1} @{duty}", controller.designator));
    }

    /// M105: `ok T:25.0 /0.0 @0 B:24.9 /0.0 @0 `
    fn report_temperatures(&mut self, number: u16) {
        self.say(format_args!("ok "));
        for index in 0..self.config.temperatures.len() {
            if self.config.temperatures.get(index).is_some_and(|controller| controller.get_m_code == number) {
                let target = self.target;
                self.write_temperature(target, index);
                self.say(format_args!(" "));
            }
        }
        self.say(format_args!("\n"));
    }

    /// M143 and M301; S is the place of the controller in the configuration, by name.
    pub(crate) fn heater_settings_code(&mut self, number: u16, block: &Block<'_>) -> Outcome {
        let Some(id) = block.get('S') else {
            for index in 0..self.config.temperatures.len() {
                self.report_heater_settings(number, index);
            }
            return Ok(Answer::Ok);
        };
        let index = id as usize;
        if id < 0.0 || index >= self.config.temperatures.len() {
            return Err(Failure::Refused(message(format_args!("M{number}: there is no temperature control S{id}"))));
        }
        if block.words().count() == 1 {
            self.report_heater_settings(number, index);
            return Ok(Answer::Ok);
        }
        let changed = self.ports.heat(|heat| match heat.heater_mut(index) {
            Some(heater) if number == 143 => set_maximum(heater, block),
            Some(heater) => set_gains(heater, block),
            None => false,
        });
        if changed { Ok(Answer::Ok) } else { Err(Failure::refused("that cannot be set on this temperature control")) }
    }

    fn report_heater_settings(&mut self, number: u16, index: usize) {
        let Self { ports, config, consoles, target, .. } = self;
        let Some(name) = config.temperatures.get(index).map(|controller| controller.designator.as_str()) else {
            return;
        };
        let Some(settings) = ports.heat(|heat| heat.heaters().get(index).map(|heater| heater.settings.clone())) else {
            return;
        };
        let max_duty = settings.max_duty.0;
        match settings.law {
            _ if number == 143 => {
                consoles.write(*target, format_args!("{name}(S{index}): max_temp {:.6}\n", settings.max.0));
            }
            LawSettings::Pid(g) => consoles.write(
                *target,
                format_args!(
                    "{name}(S{index}): PonM: {} P: {:.6} I: {:.6} D: {:.6} X(I_max):{:.6} max pwm: {max_duty} O:0\n",
                    u8::from(g.on_measurement),
                    g.p,
                    g.i,
                    g.d,
                    g.i_max,
                ),
            ),
            LawSettings::BangBang { hysteresis } => consoles.write(
                *target,
                format_args!("{name}(S{index}): bang bang, hysteresis: {:.6} max pwm: {max_duty}\n", hysteresis.0),
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
