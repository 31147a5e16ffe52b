//! `[temperature switch]`: rules that operate a switch when a temperature passes a threshold.

use config::{MAX_TEMPERATURE_SWITCHES, MachineConfig, TemperatureSwitchConfig, Trigger};
use heapless::Vec;
use units::{Celsius, Micros, SwitchId};

/// Switches to operate, with their new state.
pub type Orders = Vec<(SwitchId, bool), MAX_TEMPERATURE_SWITCHES>;

/// State of a single rule.
#[derive(Clone, Copy, Debug, Default)]
struct Rule {
    armed: bool,
    /// Result of the last look; `None` since boot, or since the rule was armed.
    hot: Option<bool>,
    /// Time of the next look.
    due: Micros,
}

/// The rules, in the configuration's order.
#[derive(Clone, Debug, Default)]
pub struct TemperatureSwitches {
    rules: Vec<Rule, MAX_TEMPERATURE_SWITCHES>,
}

impl TemperatureSwitches {
    /// Creates the rules' state before the first look.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        let rule = |rule: &TemperatureSwitchConfig| Rule {
            armed: rule.start_armed || rule.arm_mcode.is_none(),
            ..Rule::default()
        };
        Self { rules: config.temperature_switches.iter().map(rule).collect() }
    }

    /// Arms or disarms a rule (its M-code). An armed rule looks at once.
    pub fn arm(&mut self, rule: u8, armed: bool) {
        if let Some(rule) = self.rules.get_mut(usize::from(rule)) {
            *rule = Rule { armed, ..Rule::default() };
        }
    }

    /// Resets rules after a halt, which has set the switches: a rule that follows the level must find its
    /// sensor hot anew, so that a cooling fan goes on.
    pub fn halted(&mut self, config: &MachineConfig) {
        for (rule, settings) in self.rules.iter_mut().zip(&config.temperature_switches) {
            if settings.trigger == Trigger::Level && rule.hot == Some(true) {
                *rule = Rule { hot: Some(false), due: Micros(0), ..*rule };
            }
        }
    }

    /// Looks at the rules that are due. `hottest` gives the highest reading of a rule's sensors; `None` while
    /// none of them gives a reading: then everything stays.
    pub fn look(
        &mut self,
        config: &MachineConfig,
        now: Micros,
        mut hottest: impl FnMut(&TemperatureSwitchConfig) -> Option<Celsius>,
    ) -> Orders {
        let mut orders = Orders::new();
        for (rule, settings) in self.rules.iter_mut().zip(&config.temperature_switches) {
            if now < rule.due {
                continue;
            }
            let hot = hottest(settings).map(|reading| reading >= settings.threshold);
            let is_hot = hot.or(rule.hot).unwrap_or(false);
            rule.due = now.plus(if is_hot { settings.cooldown_poll } else { settings.heatup_poll });
            let Some(hot) = hot else { continue };
            let before = rule.hot.replace(hot);
            let acts = match settings.trigger {
                Trigger::Level => before != Some(hot),
                Trigger::Rising => before == Some(false) && hot,
                Trigger::Falling => before == Some(true) && !hot,
            };
            if !acts || !rule.armed {
                continue;
            }
            if settings.trigger != Trigger::Level && settings.arm_mcode.is_some() {
                rule.armed = false;
            }
            let place = config.switches.iter().position(|switch| switch.name == settings.switch);
            if let Some(place) = place {
                // The list holds an order for every rule.
                let _ = orders.push((SwitchId(place as u8), hot != settings.inverted));
            }
        }
        orders
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::SwitchConfig;

    const FAN: SwitchId = SwitchId(0);

    fn machine(trigger: Trigger, arm_mcode: Option<u16>) -> MachineConfig {
        let mut config = MachineConfig::default();
        let fan = SwitchConfig { name: "fan".try_into().unwrap(), ..SwitchConfig::default() };
        assert!(config.switches.push(fan).is_ok());
        let rule = TemperatureSwitchConfig {
            switch: "fan".try_into().unwrap(),
            trigger,
            arm_mcode,
            threshold: Celsius(50.0),
            heatup_poll: Micros::from_seconds(15),
            cooldown_poll: Micros::from_seconds(60),
            ..TemperatureSwitchConfig::default()
        };
        assert!(config.temperature_switches.push(rule).is_ok());
        config
    }

    /// Returns the orders for these readings, with a reading each second.
    fn ordered(
        config: &MachineConfig,
        rules: &mut TemperatureSwitches,
        from_s: u64,
        readings: &[Option<f32>],
    ) -> std::vec::Vec<(u64, bool)> {
        let mut ordered = std::vec::Vec::new();
        for (second, reading) in (from_s..).zip(readings) {
            for (switch, on) in rules.look(config, Micros::from_seconds(second), |_| reading.map(Celsius)) {
                assert_eq!(switch, FAN);
                ordered.push((second, on));
            }
        }
        ordered
    }

    #[test]
    fn a_level_drives_both_ways_and_is_looked_at_as_often_as_configured() {
        let config = machine(Trigger::Level, None);
        let mut rules = TemperatureSwitches::new(&config);
        let mut readings = [Some(20.0); 200];
        readings[1..20].fill(Some(50.0));
        // Cold at once, hot at the look 15 s later; that look sets the period of a hot rule.
        assert_eq!(ordered(&config, &mut rules, 0, &readings), [(0, false), (15, true), (75, false)]);
    }

    #[test]
    fn a_sensor_that_says_nothing_changes_nothing() {
        let config = machine(Trigger::Level, None);
        let mut rules = TemperatureSwitches::new(&config);
        let mut readings = [Some(90.0); 200];
        readings[1..150].fill(None);
        assert_eq!(ordered(&config, &mut rules, 0, &readings), [(0, true)]);
    }

    #[test]
    fn edges_act_once_and_are_armed_anew() {
        let mut config = machine(Trigger::Falling, Some(1001));
        config.temperature_switches[0].inverted = true;
        let mut rules = TemperatureSwitches::new(&config);
        let course: std::vec::Vec<_> = (0..400).map(|s| Some(if s / 100 % 2 == 0 { 80.0 } else { 20.0 })).collect();
        assert_eq!(ordered(&config, &mut rules, 0, &course), [], "it is not armed");
        rules.arm(0, true);
        // Hot for 100 s, with a look each 60 s; then cold, and the inverted rule switches on, once.
        assert_eq!(ordered(&config, &mut rules, 400, &course), [(520, true)]);
        rules.arm(0, true);
        rules.arm(0, false);
        assert_eq!(ordered(&config, &mut rules, 800, &course), []);
    }

    #[test]
    fn a_halt_has_what_is_hot_cooled_on_and_leaves_the_rest() {
        let config = machine(Trigger::Level, None);
        let mut rules = TemperatureSwitches::new(&config);
        assert_eq!(ordered(&config, &mut rules, 0, &[Some(80.0)]), [(0, true)]);
        rules.halted(&config);
        assert_eq!(ordered(&config, &mut rules, 1, &[Some(80.0), Some(80.0)]), [(1, true)]);
        let mut cold = TemperatureSwitches::new(&config);
        assert_eq!(ordered(&config, &mut cold, 0, &[Some(20.0)]), [(0, false)]);
        cold.halted(&config);
        assert_eq!(ordered(&config, &mut cold, 1, &[Some(20.0); 60]), []);
    }
}
