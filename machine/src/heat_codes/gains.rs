//! M143 and M301: the highest temperature of a heater, and its gains.

use config::{HeaterId, MachineConfig, ToolId};
use program::Words;
use units::{Celsius, Duty};

use super::heater_named;
use crate::failure::{Answer, Failure, Outcome};
use crate::heat::{HeatControl, HeaterSettings, LawSettings};
use crate::ports::HeatPort;
use crate::sessions::Reply;

/// M143: the highest temperature of a heater, or of all; S is the `tool_id`.
///
/// # Errors
/// When nobody has that id, or its maximum cannot be set so.
pub(crate) fn maximum_temperature(
    ports: &mut impl HeatPort,
    config: &MachineConfig,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Outcome {
    change_or_report(ports, config, words, reply, set_maximum, |settings, name, tool_id, reply| {
        let max = settings.max.0;
        reply.say(format_args!("Maximum temperature for {name}({tool_id}) is {max:.6}\u{b0}C\n"));
    })
}

/// M301: the PID gains of a heater, or of all; S is the `tool_id`.
///
/// # Errors
/// When nobody has that id, or it has no gains.
pub(crate) fn pid_gains(
    ports: &mut impl HeatPort,
    config: &MachineConfig,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
) -> Outcome {
    change_or_report(ports, config, words, reply, set_gains, |settings, name, tool_id, reply| {
        let max_duty = settings.max_duty.0;
        match settings.law {
            LawSettings::Pid(g) => reply.say(format_args!(
                "{name}(S{tool_id}): PonM: {} P: {:.6} I: {:.6} D: {:.6} X(I_max):{:.6} max pwm: {max_duty} O:0\n",
                u8::from(g.on_measurement),
                g.p,
                g.i,
                g.d,
                g.i_max,
            )),
            LawSettings::BangBang { hysteresis } => reply.say(format_args!(
                "{name}(S{tool_id}): bang bang, hysteresis: {:.6} max pwm: {max_duty}\n",
                hysteresis.0
            )),
        }
    })
}

/// Without S says the setting of every heater, with S alone that of one, and with more words changes it.
fn change_or_report(
    ports: &mut impl HeatPort,
    config: &MachineConfig,
    words: &Words<'_>,
    reply: &mut Reply<'_>,
    change: fn(&mut HeatControl, HeaterId, &Words<'_>) -> bool,
    report: fn(&HeaterSettings, &str, ToolId, &mut Reply<'_>),
) -> Outcome {
    let number = words.code().number;
    let named = words.get('S').map(|word| heater_named(config, number, 'S', word)).transpose()?;
    if let Some(id) = named.filter(|_| words.count() > 1) {
        let changed = ports.heat(|heat| change(heat, id, words));
        return if changed {
            Ok(Answer::Ok)
        } else {
            Err(Failure::refused("that cannot be set on this temperature control"))
        };
    }
    for (id, controller) in config.heaters().filter(|(id, _)| named.is_none_or(|named| named == *id)) {
        let settings = ports.heat(|heat| heat.heater(id).map(|heater| heater.settings.clone()));
        // Only what heats: a sensor has no gains and no limits.
        if let Some(settings) = settings.filter(|settings| settings.heats) {
            report(&settings, &controller.designator, controller.tool_id, reply);
        }
    }
    Ok(Answer::Ok)
}

fn set_maximum(heat: &mut HeatControl, id: HeaterId, words: &Words<'_>) -> bool {
    let celsius = words.get('P').filter(|celsius| *celsius > 0.0);
    celsius.is_some_and(|celsius| heat.set_maximum(id, Celsius(celsius as f32)))
}

fn set_gains(heat: &mut HeatControl, id: HeaterId, words: &Words<'_>) -> bool {
    let Some(settings) = heat.heater(id).map(|heater| &heater.settings) else { return false };
    let LawSettings::Pid(mut gains) = settings.law else { return false };
    let places = [('P', &mut gains.p), ('I', &mut gains.i), ('D', &mut gains.d), ('X', &mut gains.i_max)];
    for (letter, place) in places {
        *place = words.get(letter).map_or(*place, |value| value as f32);
    }
    gains.on_measurement = words.get('Z').map_or(gains.on_measurement, |value| value == 1.0);
    let max_duty = words.get('Y').map_or(settings.max_duty, |value| Duty(value.clamp(0.0, 255.0) as u8));
    heat.set_law(id, LawSettings::Pid(gains), max_duty)
}
