//! Effect of a fan on a heater: the output that holds a temperature with the fan off and on.

use base::failure::Failure;
use base::ports::Wake;
use config::{HeaterId, OutputKind};
use parts::heat_codes::change_target;
use thermal::{AIR_C, LawSettings, ModelSettings, Output};
use units::{Duty, Micros};

use super::Ask;
use base::hands::Hands;

/// Time over which the output is averaged...
const AVERAGED: Micros = Micros::from_seconds(30);
/// ...after a settling time: this multiple of the sensor's delay, and at least this time.
const SETTLES: (f32, Micros) = (10.0, Micros::from_seconds(20));

/// The fan that blows at a heater, and its output before the test.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blower {
    place: Option<u8>,
    before: f32,
}

impl Blower {
    /// Stops the fan with this place among the switches; does nothing if there is none.
    pub(super) fn stop<'c>(hands: &mut impl Hands<'c>, place: Option<u8>) -> Self {
        let before = place.map_or(0.0, |place| hands.heat(|heat| heat.switch_duty(place)));
        let blower = Self { place, before };
        blower.blow(hands, 0.0);
        blower
    }

    /// Gives the fan its former output, unless a halt has put it where the configuration says.
    pub(super) fn restore<'c>(self, hands: &mut impl Hands<'c>) {
        if !hands.heat(|heat| heat.is_halted()) {
            self.blow(hands, self.before);
        }
    }

    /// Returns the fan's greatest output, 0 to 1.
    fn most<'c>(self, hands: &mut impl Hands<'c>) -> f32 {
        let switch = self.place.and_then(|place| hands.config().switches.get(usize::from(place)));
        switch.map_or(0.0, |switch| match switch.output_kind {
            OutputKind::SigmaDelta => f32::from(switch.max_pwm.0) / 255.0,
            _ => 1.0,
        })
    }

    fn blow<'c>(self, hands: &mut impl Hands<'c>, share: f32) {
        let Some(place) = self.place else { return };
        let kind = hands.config().switches.get(usize::from(place)).map(|switch| switch.output_kind);
        let output = match kind {
            Some(OutputKind::HardwarePwm) => Output::Pwm(place, share),
            _ => Output::Switch(place, Duty(libm::roundf(share * 255.0) as u8)),
        };
        // Switch outputs accept every value, so the result says nothing.
        let _ = hands.heat(|heat| heat.apply(output));
    }
}

/// Puts the model in force and adds the fan's effect to it, if there is a fan.
///
/// # Errors
/// When the machine halts.
pub(super) fn measure<'c>(
    hands: &mut impl Hands<'c>,
    ask: &Ask,
    model: ModelSettings,
    blower: Blower,
) -> Result<ModelSettings, Failure> {
    let texts = hands.texts();
    let most = blower.most(hands);
    if most <= 0.0 {
        return Ok(model);
    }
    let config = hands.config();
    hands.heat(|heat| {
        let max = heat.heater(ask.heater).map_or(Duty::FULL, |heater| heater.settings.max_duty);
        heat.set_trial_law(ask.heater, LawSettings::Model(model), max);
        change_target(texts, heat, config, ask.heater, ask.target)
    })?;
    hands.say(format_args!("What its fan takes: without it\n"));
    let still = held_with(hands, ask.heater, &model)?;
    hands.say(format_args!("What its fan takes: with it\n"));
    blower.blow(hands, most);
    let blown = held_with(hands, ask.heater, &model)?;
    blower.blow(hands, 0.0);
    let watts = (blown - still) / 255.0 * model.power_w;
    let fan_loss = (watts / (ask.target.0 - AIR_C) / most).max(0.0);
    Ok(ModelSettings { fan_loss, ..model })
}

/// Returns the mean output that holds the target, once the temperature has settled.
fn held_with<'c>(hands: &mut impl Hands<'c>, id: HeaterId, model: &ModelSettings) -> Result<f32, Failure> {
    let (times, least) = SETTLES;
    let settled = hands.now().plus(least).plus(Micros((model.late_s * times * 1e6) as u64));
    while hands.now() < settled {
        hands.wait(Wake::Time).unless_halted()?;
    }
    let (mut sum, mut count) = (0.0_f64, 0_u32);
    let end = hands.now().plus(AVERAGED);
    while hands.now() < end {
        let duty = hands.heat(|heat| heat.heater(id).map_or(Duty::OFF, |heater| heater.duty()));
        sum += f64::from(duty.0);
        count += 1;
        hands.wait(Wake::Time).unless_halted()?;
    }
    Ok((sum / f64::from(count.max(1))) as f32)
}
