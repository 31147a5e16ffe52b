//! Kill button: a press halts; holding or releasing it may clear a halt.
//!
//! A press counts at the first look, for nothing is lost by halting once too often. Letting go counts when
//! the button has been up for [`BOUNCE`]: contacts bounce, and a bounce of a latching button must not clear
//! the halt that its press has just made.

use config::KillButton as Settings;
use units::Micros;

/// Time for which the button must be held to clear a halt.
const UNKILL_HOLD: Micros = Micros::from_seconds(2);

/// Time to wait out bounces, which take 1 to 10 ms.
const BOUNCE: Micros = Micros::from_millis(20);

/// Meaning of a look at the button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Press {
    /// No change of the button.
    Nothing,
    /// The machine must halt.
    Kill,
    /// The halt was cleared while a latching button is still down: halt again.
    StillLatched,
    /// The halt is to be cleared.
    Clear,
}

/// State of the button.
#[derive(Clone, Copy, Debug, Default)]
pub struct KillButton {
    /// Time since which the button has been down.
    down_since: Option<Micros>,
    /// Time since which the button has been up, which may be a bounce.
    up_since: Option<Micros>,
    /// Whether this press has already had its effect.
    used: bool,
}

impl KillButton {
    /// Takes a look at the button.
    pub fn look(&mut self, settings: &Settings, pressed: bool, is_halted: bool, now: Micros) -> Press {
        if !pressed {
            if now.since(*self.up_since.get_or_insert(now)) < BOUNCE {
                return Press::Nothing;
            }
            let was_down = self.down_since.take().is_some();
            self.used = false;
            let clears = was_down && settings.toggle && settings.unkill && is_halted;
            return if clears { Press::Clear } else { Press::Nothing };
        }
        self.up_since = None;
        let since = *self.down_since.get_or_insert(now);
        match (is_halted, self.used) {
            (true, used) if settings.toggle || !settings.unkill || used => Press::Nothing,
            (true, _) if now.since(since) < UNKILL_HOLD => Press::Nothing,
            (true, _) => {
                self.used = true;
                Press::Clear
            }
            (false, true) if settings.toggle => Press::StillLatched,
            (false, true) => Press::Nothing,
            (false, false) => {
                // The press has halted; only a new press, or a press held on a halted machine, may clear.
                self.used = true;
                Press::Kill
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks at the button each 100 ms; returns the results.
    fn course(settings: Settings, looks: &[(bool, bool)]) -> Vec<(usize, Press)> {
        let mut button = KillButton::default();
        let look = |(index, (pressed, halted)): (usize, &(bool, bool))| {
            (index, button.look(&settings, *pressed, *halted, Micros::from_millis(100 * index as u64)))
        };
        looks.iter().enumerate().map(look).filter(|(_, press)| *press != Press::Nothing).collect()
    }

    fn settings(toggle: bool, unkill: bool) -> Settings {
        Settings { enable: true, pin: None, toggle, unkill }
    }

    #[test]
    fn a_press_halts_once_and_a_new_one_that_is_held_clears() {
        let mut looks = vec![(true, false)];
        looks.extend([(true, true); 30]);
        looks.extend([(false, true); 2]);
        looks.extend([(true, true); 22]);
        assert_eq!(course(settings(false, true), &looks), [(0, Press::Kill), (53, Press::Clear)]);
        assert_eq!(course(settings(false, false), &looks), [(0, Press::Kill)]);
    }

    #[test]
    fn a_latching_button_clears_when_it_is_released_and_halts_while_it_is_not() {
        let looks = [(true, false), (true, true), (true, false), (true, true), (false, true), (false, true)];
        let expected = [(0, Press::Kill), (2, Press::StillLatched), (5, Press::Clear)];
        assert_eq!(course(settings(true, true), &looks), expected);
    }

    #[test]
    fn a_bounce_is_no_release() {
        for toggle in [false, true] {
            let mut button = KillButton::default();
            let mut halted = false;
            for at_us in (0..40_000).step_by(500) {
                // The button is down but for every third look of the first 5 ms.
                let pressed = at_us >= 5_000 || at_us % 1_500 != 500;
                let press = button.look(&settings(toggle, true), pressed, halted, Micros(at_us));
                assert_eq!(press, if at_us == 0 { Press::Kill } else { Press::Nothing }, "after {at_us} us");
                halted = true;
            }
        }
    }
}
