//! M143, M301, M304 and M307: a heater's highest temperature, its PID gains, and its model.

use base::CodeContext;
use base::failure::{Answer, Failure, Outcome};
use base::ports::HeatPort;
use base::sessions::Reply;
use config::{HeaterId, MachineConfig, ToolId};
use program::Words;
use thermal::{HeatControl, HeaterSettings, LawSettings, ModelSettings};
use units::{Celsius, Duty};

use super::named::{bed, heater_of};

/// M143: the highest temperature of a heater, or of all; S is the `tool_id`.
///
/// # Errors
/// When no heater has that id, or its maximum cannot be this.
pub fn maximum_temperature(code: CodeContext<'_, impl HeatPort>) -> Outcome {
    change_or_report(code, set_maximum, |settings, name, tool_id, reply| {
        let max = settings.max.0;
        reply.say(format_args!("Maximum temperature for {name}({tool_id}) is {max:.6}\u{b0}C\n"));
    })
}

/// M301: the PID gains of a heater, or of all; S is the `tool_id`. M304 does the same for the bed, without S.
///
/// # Errors
/// When no heater has that id, or it has no gains.
pub fn pid_gains(code: CodeContext<'_, impl HeatPort>) -> Outcome {
    change_or_report(code, set_gains, |settings, name, tool_id, reply| {
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
            LawSettings::Model(_) => {
                reply.say(format_args!("{name}(S{tool_id}): model, see M307; max pwm: {max_duty}\n"));
            }
            LawSettings::BangBang { hysteresis } => reply.say(format_args!(
                "{name}(S{tool_id}): bang bang, hysteresis: {:.6} max pwm: {max_duty}\n",
                hysteresis.0
            )),
        }
    })
}

/// M307: the parameters of a heater's model; S is the `tool_id`.
///
/// # Errors
/// When no heater has that id, or nothing can be controlled with these figures.
pub fn heater_model(code: CodeContext<'_, impl HeatPort>) -> Outcome {
    change_or_report(code, set_model, |settings, name, tool_id, reply| match settings.law {
        LawSettings::Model(ModelSettings { power_w, capacity, loss, fan_loss, late_s, filament_heat }) => {
            reply.say(format_args!(
                "{name}(S{tool_id}): P: {power_w:.2} C: {capacity:.4} K: {loss:.5} F: {fan_loss:.5} D: {late_s:.3} H: \
                 {filament_heat:.6}\n"
            ));
        }
        _ => reply.say(format_args!("{name}(S{tool_id}): not controlled by a model, see M306\n")),
    })
}

/// Reports the setting of every heater without S, that of a single heater with S alone, and changes it with
/// more words.
fn change_or_report(
    CodeContext { texts, ports, config, words, reply }: CodeContext<'_, impl HeatPort>,
    change: fn(&mut HeatControl, &MachineConfig, HeaterId, &Words<'_>) -> bool,
    report: fn(&HeaterSettings, &str, ToolId, &mut Reply<'_>),
) -> Outcome {
    let number = words.code().number;
    let (named, selects) = match number {
        304 => (Some(bed(config)?), 0),
        _ => (heater_of(texts, config, words, 'S')?, usize::from(words.has('S') || words.has('E'))),
    };
    if let Some(id) = named.filter(|_| words.count() > selects) {
        let changed = ports.heat(|heat| change(heat, config, id, words));
        return if changed {
            Ok(Answer::Ok)
        } else {
            Err(Failure::refused(&"that cannot be set on this temperature control"))
        };
    }
    for (id, controller) in config.heaters().filter(|(id, _)| named.is_none_or(|named| named == *id)) {
        let settings = ports.heat(|heat| heat.heater(id).map(|heater| heater.settings.clone()));
        // Sensors are left out, since they have no gains and no limits.
        if let Some(settings) = settings.filter(|settings| settings.heats) {
            report(&settings, &controller.designator, controller.tool_id, reply);
        }
    }
    Ok(Answer::Ok)
}

fn set_maximum(heat: &mut HeatControl, _: &MachineConfig, id: HeaterId, words: &Words<'_>) -> bool {
    let celsius = words.get('P').filter(|celsius| *celsius > 0.0);
    celsius.is_some_and(|celsius| heat.set_maximum(id, Celsius(celsius as f32)))
}

/// Sets PID gains. For a heater that a model controls, the rest comes from the configuration: PID controls it
/// from now on.
fn set_gains(heat: &mut HeatControl, config: &MachineConfig, id: HeaterId, words: &Words<'_>) -> bool {
    let Some(settings) = heat.heater(id).map(|heater| &heater.settings) else { return false };
    let configured = config.heater(id).map(|heater| heater.pid);
    let (mut gains, max_duty) = match (settings.law, configured) {
        (LawSettings::Pid(gains), _) | (LawSettings::Model(_), Some(gains)) => (gains, settings.max_duty),
        _ => return false,
    };
    let places = [('P', &mut gains.p), ('I', &mut gains.i), ('D', &mut gains.d), ('X', &mut gains.i_max)];
    for (letter, place) in places {
        *place = words.get(letter).map_or(*place, |value| value as f32);
    }
    gains.on_measurement = words.get('Z').map_or(gains.on_measurement, |value| value == 1.0);
    let max_duty = words.get('Y').map_or(max_duty, |value| Duty(units::within(value, 0.0, 255.0) as u8));
    heat.set_law(id, LawSettings::Pid(gains), max_duty)
}

/// Sets a heater's model; parameters without a word stay as they are, or as the configuration has them.
fn set_model(heat: &mut HeatControl, config: &MachineConfig, id: HeaterId, words: &Words<'_>) -> bool {
    let Some(settings) = heat.heater(id).map(|heater| &heater.settings).filter(|settings| settings.heats) else {
        return false;
    };
    let configured = config.heater(id).map(|heater| heater.model);
    let (mut model, max_duty) = match (settings.law, configured) {
        (LawSettings::Model(model), _) | (LawSettings::Pid(_), Some(model)) => (model, settings.max_duty),
        _ => return false,
    };
    let places = [
        ('P', &mut model.power_w),
        ('C', &mut model.capacity),
        ('K', &mut model.loss),
        ('F', &mut model.fan_loss),
        ('D', &mut model.late_s),
        ('H', &mut model.filament_heat),
    ];
    for (letter, place) in places {
        *place = words.get(letter).map_or(*place, |value| value as f32);
    }
    model.is_usable() && heat.set_law(id, LawSettings::Model(model), max_duty)
}
