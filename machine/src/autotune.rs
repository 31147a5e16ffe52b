//! M303: finds the PID gains of a heater, uses them and says them.

use config::{HeaterId, MachineConfig};
use program::{Part, Words};
use units::{Celsius, Micros};

use crate::executor::Hands;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::heat::{HeatControl, LawSettings, Relay};
use crate::heat_codes::{allow_target, change_target, check_supply, heater_named};
use crate::needs::needs;
use crate::ports::Ports;
use crate::sessions::Reply;

/// How often progress is said.
const REPORT_PERIOD: Micros = Micros::from_seconds(1);
/// Longest tuning: a slow bed takes minutes a swing.
const TIMEOUT: Micros = Micros::from_seconds(2 * 3_600);
/// Target and swings when the words are left out.
const DEFAULT: (f64, f64) = (150.0, 8.0);

/// `M303 P<tool_id> [S<target>] [C<swings>]`; without P it says which there are.
///
/// # Errors
/// When that is no heater with PID control, its target is not allowed, there is no supply, or it does not
/// swing.
pub(crate) async fn tune_pid<P: Ports>(hands: &mut Hands<'_, '_, P>, words: &Words<'_>) -> Outcome {
    let config = hands.config();
    let Some(word) = words.get('P') else {
        say_choice(config, &mut hands.reply());
        return Ok(Answer::Ok);
    };
    let heater = heater_named(config, 303, 'P', word)?;
    let swings = words.get('C').unwrap_or(DEFAULT.1) as u8;
    let target = Celsius(words.get('S').unwrap_or(DEFAULT.0) as f32);
    needs(config, Part::Heater(heater), hands.is_playing())?;
    let target = meant(config, heater, target);
    hands.heat(|heat| allow_target(heat, config, heater, target))?;
    check_supply(hands, target)?;
    hands.standstill().await?;
    let tunable = hands.heat(|heat| {
        let heater = heat.heater_mut(heater)?;
        let is_pid = heater.settings.heats && matches!(heater.settings.law, LawSettings::Pid(_));
        is_pid.then(|| heater.start_tuning(swings))
    });
    if tunable.is_none() {
        return Err(Failure::Refused(message(format_args!("M303: P{word} is no heater with PID control"))));
    }
    if let Some(described) = config.heater(heater) {
        let (label, name, id) = (&described.designator, &described.name, described.tool_id);
        hands.say(format_args!("// Running autopid on ({label}) {name}, toolid {id}, control X to abort\n"));
        hands.say(format_args!("Target: {:5.1}\n", target.0));
        hands.say(format_args!("{label}: Starting PID Autotune, {swings} max cycles, control X aborts\n"));
    }
    let tuned = match hands.heat(|heat| change_target(heat, config, heater, target)) {
        Ok(()) => watch_tuning(hands, heater).await,
        Err(refused) => Err(refused),
    };
    // Whatever happened, the heater gets a law that holds a temperature; a failure leaves the old gains.
    hands.heat(|heat| {
        // Off is never refused.
        let _ = heat.set_target(heater, Celsius(0.0));
        adopt(heat, heater);
    });
    tuned
}

/// What a target means: 1 and 2 stand for the presets.
fn meant(config: &MachineConfig, heater: HeaterId, target: Celsius) -> Celsius {
    match (target.0, config.heater(heater).map(|heater| heater.presets)) {
        (1.0, Some([first, _])) => first,
        (2.0, Some([_, second])) => second,
        _ => target,
    }
}

fn say_choice(config: &MachineConfig, reply: &mut Reply<'_>) {
    for (_, heater) in config.heaters().filter(|(_, heater)| heater.heater_pin.is_some()) {
        let (label, name, id) = (&heater.designator, &heater.name, heater.tool_id);
        reply.say(format_args!(
            "To run autopid for ({label}) {name}, select tool id with P{id}, use control X to abort\n"
        ));
    }
}

async fn watch_tuning<P: Ports>(hands: &mut Hands<'_, '_, P>, heater: HeaterId) -> Outcome {
    let (since, mut report_due) = (hands.now(), hands.now().plus(REPORT_PERIOD));
    loop {
        let now = hands.now();
        let relay = hands.heat(|heat| heat.heater(heater).and_then(|heater| heater.tuning().copied()));
        let relay = relay.ok_or_else(|| Failure::refused("M303: tuning was ended by another command"))?;
        if let Some(gains) = relay.gains() {
            let (p, i, d) = (gains.p, gains.i, gains.d);
            hands.say(format_args!("PID tuned: p_factor = {p:.4} i_factor = {i:.4} d_factor = {d:.4}\n"));
            hands.say(format_args!("They are in use until reset: keep them with M500 or in config.ini\n"));
            return Ok(Answer::Ok);
        }
        if now.since(since) > TIMEOUT {
            return Err(Failure::refused("M303: the temperature does not swing, heater left as it was"));
        }
        if now >= report_due {
            report_due = now.plus(REPORT_PERIOD);
            let (counted, wanted) = relay.progress();
            let now = hands.heat(|heat| {
                let heater = heat.heater(heater)?;
                Some((heater.reading()?.0, heater.target().0, heater.duty().0))
            });
            if let Some((reading, target, duty)) = now {
                let text = format_args!("// Autopid Status - {reading:5.1}/{target:5.1} @{duty} {counted}/{wanted}\n");
                hands.say(text);
            }
        }
        if let Err(failure) = hands.pause().await {
            hands.say(format_args!("Autopid aborted\n"));
            return Err(failure);
        }
    }
}

/// Puts found gains into force, or the old ones back.
fn adopt(heat: &mut HeatControl, id: HeaterId) {
    let Some(heater) = heat.heater(id) else { return };
    let found = heater.tuning().and_then(Relay::gains);
    let (mut law, max_duty) = (heater.settings.law, heater.settings.max_duty);
    if let (LawSettings::Pid(gains), Some(found)) = (&mut law, found) {
        (gains.p, gains.i, gains.d) = (found.p, found.i, found.d);
    }
    heat.set_law(id, law, max_duty);
}
