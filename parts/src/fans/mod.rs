//! `[fan]`: fans that follow a rule of their own, and tachometers.
//!
//! Here the power of each fan is chosen and its turning is watched; `crate::heat`, where outputs change,
//! shapes the power (least, most, kick start).

mod rule;
mod tachometer;

use config::{FanConfig, FanFollows, MAX_FANS, MachineConfig};
use heapless::Vec;
use units::{Micros, SwitchId};

pub use rule::Facts;
use rule::Rule;
pub use tachometer::Found;
use tachometer::Tachometer;

use base::sessions::Reply;

/// Time between two evaluations of the rules.
const PERIOD: Micros = Micros::from_millis(100);

/// Shares of full power for switches, 0 to 1.
pub type Shares = Vec<(SwitchId, f32), MAX_FANS>;

/// State of a single fan.
#[derive(Clone, Debug, Default)]
struct Fan {
    /// The switch that drives the fan; `None` if an error in the configuration keeps it off.
    switch: Option<SwitchId>,
    rule: Rule,
    tachometer: Tachometer,
}

/// The fans, in the configuration's order.
#[derive(Clone, Debug, Default)]
pub struct Fans {
    fans: Vec<Fan, MAX_FANS>,
    due: Micros,
}

impl Fans {
    /// Creates the fans' state before the first look.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        let fan = |fan: &FanConfig| Fan { switch: switch_of(config, fan), ..Fan::default() };
        Self { fans: config.fans.iter().map(fan).collect(), due: Micros(0) }
    }

    /// Returns the power for the fans that follow a rule; nothing when the next look is not due.
    pub fn look(&mut self, config: &MachineConfig, now: Micros, mut facts: impl FnMut(&FanConfig) -> Facts) -> Shares {
        let mut shares = Shares::new();
        if now < self.due {
            return shares;
        }
        self.due = now.plus(PERIOD);
        for (fan, settings) in self.fans.iter_mut().zip(&config.fans) {
            let Some(switch) = fan.switch.filter(|_| settings.follows != FanFollows::Codes) else { continue };
            let share = fan.rule.share(settings, facts(settings), now);
            // The list holds a share for every fan.
            let _ = shares.push((switch, share));
        }
        shares
    }

    /// Looks at the tachometers; returns the first fan of which there is news. `pulses` are counted by fan,
    /// and `driven` says whether a switch gives power.
    pub fn count(
        &mut self,
        config: &MachineConfig,
        now: Micros,
        pulses: [u16; MAX_FANS],
        driven: impl Fn(SwitchId) -> bool,
    ) -> Option<(usize, Found)> {
        for (place, (fan, settings)) in self.fans.iter_mut().zip(&config.fans).enumerate() {
            let (Some(switch), Some(_)) = (fan.switch, settings.tachometer.pin) else { continue };
            let pulses = pulses.get(place).copied().unwrap_or_default();
            let found = fan.tachometer.look(&settings.tachometer, now, pulses, driven(switch));
            if found != Found::Nothing {
                return Some((place, found));
            }
        }
        None
    }

    /// Returns the revolutions per minute of the fan at this place in the configuration.
    #[must_use]
    pub fn rpm(&self, place: usize) -> f32 {
        self.fans.get(place).map_or(0.0, |fan| fan.tachometer.rpm())
    }

    /// Returns the share of full power of each fan, 0 to 1. `given` is the share that a switch gives.
    pub fn powers(&self, given: impl Fn(SwitchId) -> f32) -> impl Iterator<Item = f32> {
        self.fans.iter().map(move |fan| fan.switch.map_or(0.0, &given))
    }

    /// M123: `fan 50% 2980 rpm` for each. `given` is the share of full power that a switch gives.
    pub fn report(&self, config: &MachineConfig, given: impl Fn(SwitchId) -> f32, reply: &mut Reply<'_>) {
        for (fan, settings) in self.fans.iter().zip(&config.fans) {
            let percent = fan.switch.map_or(0.0, &given) * 100.0;
            reply.say(format_args!("{} {percent:.0}%", settings.name));
            if settings.tachometer.pin.is_some() {
                let stopped = if fan.tachometer.is_stopped() { ", stopped" } else { "" };
                reply.say(format_args!(" {:.0} rpm{stopped}", fan.tachometer.rpm()));
            }
            reply.say(format_args!("\n"));
        }
        if config.fans.is_empty() {
            reply.say(format_args!("no fan is described: see [fan] in config.ini\n"));
        }
    }
}

fn switch_of(config: &MachineConfig, fan: &FanConfig) -> Option<SwitchId> {
    let place = config.switches.iter().position(|switch| switch.name == fan.name)?;
    Some(SwitchId(place as u8))
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::Desk;

    #[test]
    fn a_fan_is_reported_with_its_share_of_power() {
        let mut config = MachineConfig::default();
        for name in ["part", "back"] {
            let name = name.try_into().unwrap();
            config.switches.push(config::SwitchConfig { name, ..config::SwitchConfig::default() }).unwrap();
        }
        let fan = FanConfig { name: "back".try_into().unwrap(), ..FanConfig::default() };
        config.fans.push(fan).unwrap_or_else(|_| panic!("room"));
        let fans = Fans::new(&config);
        let given = |id: SwitchId| if id == SwitchId(1) { 0.4 } else { 0.9 };
        assert_eq!(Desk::new().hears(|reply| fans.report(&config, given, reply)), "back 40%\n");
        let none = MachineConfig::default();
        let said = Desk::new().hears(|reply| Fans::new(&none).report(&none, given, reply));
        assert_eq!(said, "no fan is described: see [fan] in config.ini\n");
    }
}
