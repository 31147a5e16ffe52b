//! M303 and M306: measure how a heater answers to power, and set its control (PID or a model) accordingly.
//!
//! Both codes swing the temperature around a target, a few times (see [`thermal::StepTest`]). The heater
//! goes off whatever happens, and keeps its former control unless everything was found. Questions are
//! answered meanwhile, and heat safety watches as ever.

mod fan;

use base::failure::{Failure, Outcome, Texts};
use base::needs::needs;
use base::ports::Wake;
use base::sessions::Reply;
use config::{HeaterId, MachineConfig};
use parts::heat_codes::{allow_target, change_target, check_supply, heater_named, heater_of, wait_for_first_reading};
use program::{Part, Words};
use thermal::{AIR_C, Answer, LawSettings, ModelSettings, PidGains};
use units::{Celsius, Micros};

use base::hands::Hands;

/// Time between two progress reports.
const REPORT_PERIOD: Micros = Micros::from_seconds(1);
/// Longest tuning: a slow bed takes minutes a swing.
const TIMEOUT: Micros = Micros::from_seconds(3_600);
/// Target and swings when the words are left out.
const DEFAULT: (f64, f64) = (150.0, 3.0);
/// Greatest overshoot of a swing above the target, C, for which `max_temp` must leave room.
const HEADROOM: f32 = 15.0;
/// Least target above the air's temperature, C: nearer to the air, heat losses cannot be measured.
const LEAST_ABOVE_AIR: f32 = 20.0;
/// Below this reading a heater has been off for long, and is as warm as the air.
const COLD: Celsius = Celsius(45.0);
/// Share of the way from the air to the target below which the first rise begins: all lags are to have died
/// away at its end.
const RISES_FROM: f32 = 0.7;

/// Parameters of a tuning run.
#[derive(Clone, Copy, Debug)]
struct Ask {
    number: u16,
    heater: HeaterId,
    target: Celsius,
    swings: u8,
    air: Celsius,
}

/// `M303 P<tool_id> [S<target>] [C<swings>]`: tunes a PID control; without P lists the heaters to choose
/// from.
///
/// # Errors
/// When P is no heater with PID control, the target is not allowed or too near to the air, there is no
/// supply, or the heater's answer to power is not that of a heater.
pub fn tune_pid<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    let config = hands.config();
    let Some(heater) = heater_of(hands.texts(), config, words, 'P')? else {
        say_choice(config, &mut hands.reply());
        return Ok(base::failure::Answer::Ok);
    };
    let ask = asked(hands, words, heater)?;
    if let Some(described) = config.heater(ask.heater) {
        let (label, name, id) = (&described.designator, &described.name, described.tool_id);
        hands.say(format_args!("// Running autopid on ({label}) {name}, toolid {id}, control X to abort\n"));
        hands.say(format_args!("Target: {:5.1}\n", ask.target.0));
        hands.say(format_args!("{label}: Starting PID Autotune, {} max cycles, control X aborts\n", ask.swings));
    }
    let found = swing(hands, &ask);
    let law = match (&found, config.heater(ask.heater)) {
        (Ok(answer), Some(described)) => {
            let settings = hands.heat(|heat| heat.heater(ask.heater).map(|heater| heater.settings.clone()));
            let Some(settings) = settings else { return Ok(base::failure::Answer::Unknown) };
            let before = match settings.law {
                LawSettings::Pid(gains) => gains,
                _ => described.pid,
            };
            let gains = answer.gains(settings.max_duty);
            Some(LawSettings::Pid(PidGains { p: gains.p, i: gains.i, d: gains.d, ..before }))
        }
        _ => None,
    };
    end(hands, ask.heater, law);
    let answer = found?;
    explain(hands, &ask, &answer);
    if let Some(LawSettings::Pid(PidGains { p, i, d, .. })) = law {
        hands.report(format_args!("PID tuned: p_factor = {p:.4} i_factor = {i:.4} d_factor = {d:.4}\n"));
        hands.report(format_args!("They are in use until reset: keep them with M500 or in config.ini\n"));
    }
    Ok(base::failure::Answer::Ok)
}

/// `M306 T<tool_id> [S<target>] [C<swings>] [R<air>]`: measures the model of a heater, and that of the fan
/// that blows at it.
///
/// # Errors
/// As of [`tune_pid`]; and when the heater is warm and R does not say how warm the air is.
pub fn tune_model<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    let config = hands.config();
    let heater = heater_named(hands.texts(), config, 306, 'T', words.get('T').unwrap_or(0.0))?;
    let ask = asked(hands, words, heater)?;
    let reading = hands.heat(|heat| heat.heater(ask.heater).and_then(|heater| heater.reading()));
    if !words.has('R') && reading.is_none_or(|reading| reading > COLD) {
        return Err(Failure::refused(&"M306: it is warm: let it cool below 45 C, or say how warm the air is with R"));
    }
    let Some(described) = config.heater(ask.heater) else { return Ok(base::failure::Answer::Unknown) };
    hands.say(format_args!("// Finding the model of {}, control X to abort\n", described.name));
    let blower = fan::Blower::stop(hands, described.fan);
    let found = match swing(hands, &ask) {
        Ok(answer) => {
            explain(hands, &ask, &answer);
            let model = model(hands, &ask, &answer);
            fan::measure(hands, &ask, model, blower)
        }
        Err(failure) => Err(failure),
    };
    blower.restore(hands);
    end(hands, ask.heater, found.as_ref().ok().map(|model| LawSettings::Model(*model)));
    let model = found?;
    let ModelSettings { power_w, capacity, loss, fan_loss, late_s, .. } = model;
    hands.report(format_args!(
        "Model found, of {power_w} W: model_capacity = {capacity:.3} model_loss = {loss:.4} model_fan_loss = {fan_loss:.4} \
         model_late = {late_s:.2}\n"
    ));
    hands.report(format_args!("It is in use until reset: keep it with M500, or with control = model in config.ini\n"));
    Ok(base::failure::Answer::Ok)
}

/// Reads the words of M303 and M306.
///
/// # Errors
/// When the heater is not to be tuned so.
fn asked<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>, heater: HeaterId) -> Result<Ask, Failure> {
    let texts = hands.texts();
    let config = hands.config();
    let number = words.code().number;
    let name = config.heater(heater).map_or("", |heater| heater.name.as_str());
    let swings = words.get('C').unwrap_or(DEFAULT.1) as u8;
    let target = Celsius(words.get('S').unwrap_or(DEFAULT.0) as f32);
    needs(texts, config, Part::Heater(heater), hands.is_playing())?;
    let target = meant(config, heater, target);
    hands.heat(|heat| allow_target(texts, heat, config, heater, target))?;
    check_supply(hands, target)?;
    wait_for_first_reading(hands, heater)?;
    let state = hands.heat(|heat| {
        let heater = heat.heater(heater)?;
        let is_tunable = heater.settings.heats && !matches!(heater.settings.law, LawSettings::BangBang { .. });
        is_tunable.then(|| (heater.settings.max, heater.reading(), heater.is_on()))
    });
    let Some((max, reading, is_on)) = state else {
        let text = format_args!("M{number}: {name} is no heater with PID control");
        return Err(texts.refused(text));
    };
    if reading.is_none() {
        let text = format_args!("M{number}: {name} gives no temperature: check its sensor");
        return Err(texts.refused(text));
    }
    let read = reading.filter(|reading| !is_on && *reading < COLD);
    let air = words.get('R').map(|air| Celsius(air as f32)).or(read).unwrap_or(Celsius(AIR_C));
    if target.0 > max.0 - HEADROOM {
        let most = max.0 - HEADROOM;
        let text =
            format_args!("M{number} swings {HEADROOM} C above its target, and max_temp is {max}: S{most} at most");
        return Err(texts.refused(text));
    }
    if target.0 < air.0 + LEAST_ABOVE_AIR {
        let least = air.0 + LEAST_ABOVE_AIR;
        let text = format_args!("M{number}: so near to the air's {air:.0} nothing is found: S{least:.0} at least");
        return Err(texts.refused(text));
    }
    Ok(Ask { number, heater, target, swings, air })
}

/// Returns the temperature of a target word: 1 and 2 stand for the presets.
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

/// Prints the heater's measured answer in words.
fn explain<'c>(hands: &mut impl Hands<'c>, ask: &Ask, answer: &Answer) {
    let Answer { rise, late_s, holds, .. } = answer;
    let percent = holds * 100.0;
    hands.say(format_args!(
        "Full output warms it by {rise:.2} C/s less what it loses, its sensor tells {late_s:.1} s late, {percent:.0} % of \
         the output holds {:.0} C\n",
        ask.target.0
    ));
}

/// Returns the model that matches the measured answer.
fn model<'c>(hands: &mut impl Hands<'c>, ask: &Ask, answer: &Answer) -> ModelSettings {
    let configured = hands.config().heater(ask.heater).map(|heater| heater.model).unwrap_or_default();
    let settings =
        hands.heat(|heat| heat.heater(ask.heater).map(|heater| (heater.settings.law, heater.settings.max_duty)));
    let (before, share) = match settings {
        Some((LawSettings::Model(model), max)) => (model, f32::from(max.0) / 255.0),
        Some((_, max)) => (configured, f32::from(max.0) / 255.0),
        None => (configured, 1.0),
    };
    let capacity = before.power_w * share / answer.rise;
    ModelSettings { capacity, loss: answer.loss * capacity, late_s: answer.late_s, ..before }
}

/// Swings the heater around the target until its answer to power is known. The heater is left on.
///
/// # Errors
/// When the answer is not that of a heater, the test takes too long, or the machine halts.
fn swing<'c>(hands: &mut impl Hands<'c>, ask: &Ask) -> Result<Answer, Failure> {
    let texts = hands.texts();
    let config = hands.config();
    hands.standstill()?;
    check_supply(hands, ask.target)?;
    let began = hands.now();
    cool(hands, ask, began)?;
    hands.heat(|heat| {
        if let Some(heater) = heat.heater_mut(ask.heater) {
            heater.start_tuning(ask.swings, ask.air);
        }
        change_target(texts, heat, config, ask.heater, ask.target)
    })?;
    let mut report_due = hands.now().plus(REPORT_PERIOD);
    loop {
        let test = hands.heat(|heat| heat.heater(ask.heater).and_then(|heater| heater.tuning().copied()));
        let Some(test) = test else { return Err(refused(texts, ask, "it was ended by another command")) };
        match test.answer(ask.target) {
            Some(Ok(answer)) => return Ok(answer),
            Some(Err(why)) => return Err(refused(texts, ask, why.text())),
            None => {}
        }
        let is_off = hands.heat(|heat| heat.heater(ask.heater).is_none_or(|heater| !heater.is_on()));
        if is_off && !hands.heat(|heat| heat.is_halted()) {
            return Err(refused(texts, ask, "the heater was switched off"));
        }
        turn(hands, ask, began, test.progress(), &mut report_due)?;
    }
}

/// Returns the reading of the heater under test.
fn reading<'c>(hands: &mut impl Hands<'c>, ask: &Ask) -> Option<Celsius> {
    hands.heat(|heat| heat.heater(ask.heater).and_then(|heater| heater.reading()))
}

/// Waits with the heater off until it is far enough below the target for the first rise to tell all.
fn cool<'c>(hands: &mut impl Hands<'c>, ask: &Ask, began: Micros) -> Result<(), Failure> {
    let below = ask.air.0 + (ask.target.0 - ask.air.0) * RISES_FROM;
    if reading(hands, ask).is_some_and(|reading| reading.0 > below) {
        hands.say(format_args!("It cools to {below:.0} C first\n"));
        // A target of zero is never refused.
        let _ = hands.heat(|heat| heat.set_target(ask.heater, Celsius(0.0)));
    }
    let mut report_due = hands.now().plus(REPORT_PERIOD);
    while reading(hands, ask).is_none_or(|reading| reading.0 > below) {
        turn(hands, ask, began, (0, ask.swings), &mut report_due)?;
    }
    Ok(())
}

/// Does one turn of a wait, and reports progress.
fn turn<'c>(
    hands: &mut impl Hands<'c>,
    ask: &Ask,
    began: Micros,
    (counted, wanted): (u8, u8),
    report_due: &mut Micros,
) -> Result<(), Failure> {
    let now = hands.now();
    if now.since(began) > TIMEOUT {
        return Err(refused(
            hands.texts(),
            ask,
            "it has taken an hour and is not done: the heater is too weak, or air moves",
        ));
    }
    if now >= *report_due {
        *report_due = now.plus(REPORT_PERIOD);
        let state = hands.heat(|heat| {
            let heater = heat.heater(ask.heater)?;
            Some((heater.reading()?.0, heater.target().0, heater.duty().0))
        });
        if let Some((reading, target, duty)) = state {
            let text = format_args!("// Autopid Status - {reading:5.1}/{target:5.1} @{duty} {counted}/{wanted}\n");
            hands.say(text);
        }
    }
    if let Err(failure) = hands.wait(Wake::Time).unless_halted() {
        hands.say(format_args!("Autopid aborted\n"));
        return Err(failure);
    }
    Ok(())
}

fn refused(texts: &Texts, ask: &Ask, why: &str) -> Failure {
    texts.refused(format_args!("M{}: {why}", ask.number))
}

/// Switches the heater off, whatever happened, and gives it a control law that holds a temperature: the one
/// found, or its former one.
fn end<'c>(hands: &mut impl Hands<'c>, id: HeaterId, found: Option<LawSettings>) {
    hands.heat(|heat| {
        // A target of zero is never refused.
        let _ = heat.set_target(id, Celsius(0.0));
        let before = heat.heater(id).map(|heater| (heater.settings.law, heater.settings.max_duty));
        if let Some((law, max_duty)) = before {
            heat.set_law(id, found.unwrap_or(law), max_duty);
        }
    });
}
