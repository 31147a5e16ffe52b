//! `preheat`: named presets, each with a temperature of its own for every heater.

use base::failure::{Answer, Outcome};
use base::hands::Hands;
use base::needs::needs;
use base::sessions::Reply;
use config::{MachineConfig, TemperatureConfig};
use program::Part;
use units::Celsius;

use super::{allow_target, change_target, check_supply};

/// Sets every heater that has a preset of this name, all or none of them, and waits for nothing; `off` is a
/// preset that every heater has. Without a name, lists the presets.
///
/// # Errors
/// When no heater has the preset, a heater does not allow its temperature or stays off, or there is no
/// supply.
pub fn preheat<'c>(hands: &mut impl Hands<'c>, name: &str) -> Outcome {
    let texts = hands.texts();
    let config = hands.config();
    if name.is_empty() {
        list(config, &mut hands.reply());
        return Ok(Answer::Ok);
    }
    let is_off = name.eq_ignore_ascii_case("off");
    let target = |heater: &TemperatureConfig| if is_off { Some(Celsius(0.0)) } else { heater.preset(name) };
    let meant = || config.heaters().filter_map(|(id, heater)| Some((id, target(heater)?)));
    if meant().next().is_none() {
        return Err(texts.refused(format_args!("no heater has a preset {name}: write preheat to see them")));
    }
    if !is_off {
        for (id, target) in meant() {
            needs(texts, config, Part::Heater(id), hands.is_playing())?;
            hands.heat(|heat| allow_target(texts, heat, config, id, target))?;
            check_supply(hands, target)?;
        }
    }
    for (id, target) in meant() {
        hands.heat(|heat| change_target(texts, heat, config, id, target))?;
    }
    Ok(Answer::Ok)
}

fn list(config: &MachineConfig, reply: &mut Reply<'_>) {
    let mut any = false;
    for (_, heater) in config.heaters() {
        for (name, celsius) in heater.named_presets() {
            any = true;
            reply.say(format_args!("{name}: {} {:.1} C\n", heater.name, celsius.map_or(0.0, |celsius| celsius.0)));
        }
    }
    if !any {
        reply.say(format_args!("there are none: [temperature control] hotend.presets = pla 205, petg 235\n"));
    }
}
