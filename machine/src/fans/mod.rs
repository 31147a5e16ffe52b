//! `[fan]`: fans that run by themselves, and tachometers.
//!
//! How a fan is given its power (least, most, kick start) is in `crate::heat`, where outputs change; what is
//! to be given, and whether it turns, is known here.

mod rule;
mod tachometer;

use config::{FanConfig, FanFollows, MAX_FANS, MachineConfig};
use heapless::Vec;
use units::{Micros, SwitchId};

pub(crate) use rule::Facts;
use rule::Rule;
pub(crate) use tachometer::Found;
use tachometer::Tachometer;

use crate::sessions::Reply;

/// Rules are followed so often.
const PERIOD: Micros = Micros::from_millis(100);

/// Shares of full power for switches, 0 to 1.
pub(crate) type Shares = Vec<(SwitchId, f32), MAX_FANS>;

/// What one fan is doing.
#[derive(Clone, Debug, Default)]
struct Fan {
    /// The switch that drives it; none: an error in the configuration keeps it off.
    switch: Option<SwitchId>,
    rule: Rule,
    tachometer: Tachometer,
}

/// The fans, in the configuration's order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fans {
    fans: Vec<Fan, MAX_FANS>,
    due: Micros,
}

impl Fans {
    /// Before the first look.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        let fan = |fan: &FanConfig| Fan { switch: switch_of(config, fan), ..Fan::default() };
        Self { fans: config.fans.iter().map(fan).collect(), due: Micros(0) }
    }

    /// What the fans that run by themselves are to have now; nothing when it is not yet time to look.
    pub fn look(&mut self, config: &MachineConfig, now: Micros, mut facts: impl FnMut(&FanConfig) -> Facts) -> Shares {
        let mut shares = Shares::new();
        if now < self.due {
            return shares;
        }
        self.due = now.plus(PERIOD);
        for (fan, settings) in self.fans.iter_mut().zip(&config.fans) {
            let Some(switch) = fan.switch.filter(|_| settings.follows != FanFollows::Codes) else { continue };
            let share = fan.rule.share(settings, facts(settings), now);
            // There are as many places as fans.
            let _ = shares.push((switch, share));
        }
        shares
    }

    /// Looks at the tachometers; the first fan of which there is news. `pulses` are counted by fan, and
    /// `driven` says whether a switch gives power.
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

    /// Turns a minute of the fan at this place in the configuration.
    #[must_use]
    pub fn rpm(&self, place: usize) -> f32 {
        self.fans.get(place).map_or(0.0, |fan| fan.tachometer.rpm())
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
