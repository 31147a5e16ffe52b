//! M303: finds the PID gains of a heater, uses them and says them.

use config::HeaterId;
use gcode::Block;
use units::{Celsius, Micros};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::heat::{Heater, LawSettings};
use crate::ports::Ports;

/// How often progress is said.
const REPORT_PERIOD: Micros = Micros::from_seconds(1);
/// Longest tuning: a slow bed takes minutes a swing.
const TIMEOUT: Micros = Micros::from_seconds(2 * 3_600);
/// Target and swings when the words are left out.
const DEFAULT: (f64, f64) = (150.0, 8.0);

impl<P: Ports> Controller<P> {
    /// `M303 P<tool_id> [S<target>] [C<swings>]`; without P it says which there are.
    pub(crate) async fn autotune_code(&mut self, block: &Block<'_>) -> Outcome {
        let Some(word) = block.get('P') else {
            for (_, heater) in self.config.heaters().filter(|(_, heater)| heater.heater_pin.is_some()) {
                let (label, name, id) = (&heater.designator, &heater.name, heater.tool_id);
                self.consoles.write(
                    self.target,
                    format_args!(
                        "To run autopid for ({label}) {name}, select tool id with P{id}, use control X to abort\n"
                    ),
                );
            }
            return Ok(Answer::Ok);
        };
        let id = self.heater_named(303, 'P', word)?;
        let swings = block.get('C').unwrap_or(DEFAULT.1).clamp(3.0, 50.0) as u8;
        let target = Celsius(block.get('S').unwrap_or(DEFAULT.0) as f32);
        self.needs_heater(id)?;
        self.check_target(id, target)?;
        if !self.ports.supervisor(|supervisor| supervisor.fet_supply_on()) {
            return Err(Failure::alarm("heater supply is off (vfet below 6 V): switch it on, then M999"));
        }
        self.wait_idle().await?;
        let tunable = self.ports.heat(|heat| {
            let heater = heat.heater_mut(id)?;
            let is_pid = heater.settings.heats && matches!(heater.settings.law, LawSettings::Pid(_));
            is_pid.then(|| heater.start_tuning(swings))
        });
        if tunable.is_none() {
            return Err(Failure::Refused(message(format_args!("M303: P{word} is no heater with PID control"))));
        }
        let tuned = match self.set_temperature(id, target) {
            Ok(()) => self.watch_tuning(id).await,
            Err(refused) => Err(refused),
        };
        self.switch_heater_off(id);
        // Whatever happened, the heater gets a law that holds a temperature; a failure leaves the old gains.
        self.ports.heat(|heat| {
            if let Some(heater) = heat.heater_mut(id) {
                adopt(heater);
            }
        });
        tuned
    }

    async fn watch_tuning(&mut self, id: HeaterId) -> Outcome {
        let (since, mut report_due) = (self.ports.now(), self.ports.now());
        loop {
            let now = self.ports.now();
            let relay = self.ports.heat(|heat| heat.heater(id).and_then(|heater| heater.tuning().copied()));
            let relay = relay.ok_or_else(|| Failure::refused("M303: tuning was ended by another command"))?;
            if let Some(gains) = relay.gains() {
                let (p, i, d) = (gains.p, gains.i, gains.d);
                self.say(format_args!("PID tuned: p_factor = {p:.4} i_factor = {i:.4} d_factor = {d:.4}\n"));
                self.say(format_args!("They are in use until reset: keep them with M500 or in config.ini\n"));
                return Ok(Answer::Ok);
            }
            if now.since(since) > TIMEOUT {
                return Err(Failure::refused("M303: the temperature does not swing, heater left as it was"));
            }
            if now >= report_due {
                report_due = now.plus(REPORT_PERIOD);
                let (counted, wanted) = relay.progress();
                self.say(format_args!("// Autopid Status - {counted}/{wanted} "));
                let target = self.target;
                self.write_temperature(target, id);
                self.say(format_args!("\n"));
            }
            self.pause().await?;
        }
    }
}

/// Puts found gains into force, or the old ones back.
fn adopt(heater: &mut Heater) {
    let found = heater.tuning().and_then(crate::heat::Relay::gains);
    let mut law = heater.settings.law;
    if let (LawSettings::Pid(gains), Some(found)) = (&mut law, found) {
        (gains.p, gains.i, gains.d) = (found.p, found.i, found.d);
    }
    heater.set_law(law, heater.settings.max_duty);
}
