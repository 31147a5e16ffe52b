//! `[button box]`: what buttons ask for.

use config::{ButtonWord, Command, MAX_BUTTONS, MachineConfig};
use heapless::{Deque, Vec};
use units::Micros;

use crate::ports::{Input, InputLevels};

/// Lines that can wait until the machine takes them. While none more fits, buttons are not looked at: what is
/// pressed is seen later.
const WAITING: usize = 8;

/// What a button has been found to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Act {
    Press,
    Release,
    LongPress,
}

/// What is to be done at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Urgent {
    /// Halt.
    pub kill: bool,
    /// End the jog that a button began.
    pub stop_jog: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Button {
    /// It was pressed at the last look, since then.
    pressed: Option<Micros>,
    /// This press has been a long one.
    was_long: bool,
}

/// The buttons, in the configuration's order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Buttons {
    buttons: Vec<Button, MAX_BUTTONS>,
    waiting: Deque<(u8, Act), WAITING>,
    due: Micros,
}

impl Buttons {
    /// None pressed: one that is held at boot counts as pressed then.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        Self { buttons: config.buttons.iter().map(|_| Button::default()).collect(), ..Self::default() }
    }

    /// Looks at the buttons when that is due. What is urgent is told; lines wait for [`Self::take_line`].
    pub fn look(&mut self, levels: InputLevels, config: &MachineConfig, now: Micros) -> Urgent {
        let mut urgent = Urgent::default();
        if now < self.due {
            return urgent;
        }
        self.due = now.plus(Micros(1_000_000 / u64::from(config.button_poll_hz.max(1))));
        for place in 0..self.buttons.len() {
            // A press and its release fit, of each.
            if self.waiting.len() + 2 > WAITING {
                break;
            }
            for act in self.acts(place, levels.is_active(Input::Button(place as u8)), config, now) {
                let line = line_of(config, place as u8, act);
                match line.and_then(|line| ButtonWord::of(line)) {
                    Some(ButtonWord::Kill) => urgent.kill = true,
                    Some(ButtonWord::StopJog) => {
                        urgent.stop_jog = true;
                        self.drop_jogs(config);
                    }
                    _ if line.is_some() => {
                        let _fits = self.waiting.push_back((place as u8, act));
                    }
                    _ => {}
                }
            }
        }
        urgent
    }

    /// A jog that has not begun must not: nobody holds its button any more.
    fn drop_jogs(&mut self, config: &MachineConfig) {
        for _ in 0..self.waiting.len() {
            let Some(next) = self.waiting.pop_front() else { return };
            if line_of(config, next.0, next.1).is_some_and(|line| !line.starts_with("$J")) {
                // It came from there.
                let _fits = self.waiting.push_back(next);
            }
        }
    }

    /// What a button does that has this level now.
    fn acts(&mut self, place: usize, level: bool, config: &MachineConfig, now: Micros) -> Vec<Act, 2> {
        let mut acts = Vec::new();
        let (Some(button), Some(settings)) = (self.buttons.get_mut(place), config.buttons.get(place)) else {
            return acts;
        };
        let has_long = !settings.long_press.is_empty();
        let mut add = |act| {
            // Two are the most there can be.
            let _fits = acts.push(act);
        };
        match (button.pressed, level) {
            (None, true) => {
                *button = Button { pressed: Some(now), was_long: false };
                if !has_long {
                    add(Act::Press);
                }
            }
            (Some(since), true) if has_long && !button.was_long && now.since(since) >= settings.long_press_time => {
                button.was_long = true;
                add(Act::LongPress);
            }
            (Some(_), false) => {
                button.pressed = None;
                if has_long && !button.was_long {
                    add(Act::Press);
                }
                add(Act::Release);
            }
            _ => {}
        }
        acts
    }

    /// The next line that a button sends, once.
    pub fn take_line(&mut self, config: &MachineConfig) -> Option<Command> {
        let (place, act) = self.waiting.pop_front()?;
        line_of(config, place, act).cloned()
    }
}

fn line_of(config: &MachineConfig, place: u8, act: Act) -> Option<&Command> {
    let settings = config.buttons.get(usize::from(place))?;
    let line = match act {
        Act::Press => &settings.press,
        Act::Release => &settings.release,
        Act::LongPress => &settings.long_press,
    };
    Some(line).filter(|line| !line.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::ButtonConfig;

    fn machine(press: &str, release: &str, long_press: &str) -> MachineConfig {
        let mut config = MachineConfig { button_poll_hz: 20, ..MachineConfig::default() };
        let button = ButtonConfig {
            press: press.try_into().unwrap(),
            release: release.try_into().unwrap(),
            long_press: long_press.try_into().unwrap(),
            long_press_time: Micros::from_seconds(1),
            ..ButtonConfig::default()
        };
        assert!(config.buttons.push(button).is_ok());
        config
    }

    /// Lines that it sends while it is pressed at these times, in ms, and looked at every 10 ms.
    fn sent(config: &MachineConfig, pressed: &[(u64, u64)]) -> std::vec::Vec<String> {
        let mut buttons = Buttons::new(config);
        let mut sent = std::vec::Vec::new();
        for ms in (0..5_000).step_by(10) {
            let down = pressed.iter().any(|(from, to)| (*from..*to).contains(&ms));
            let levels = InputLevels::default();
            let levels = if down { levels.with(Input::Button(0)) } else { levels };
            let urgent = buttons.look(levels, config, Micros::from_millis(ms));
            if urgent.kill {
                sent.push("halted".into());
            }
            if urgent.stop_jog {
                sent.push("stopped".into());
            }
            sent.extend(buttons.take_line(config).map(|line| line.as_str().into()));
        }
        sent
    }

    #[test]
    fn a_press_and_its_release_send_a_line_each() {
        let config = machine("M24", "M25", "");
        assert_eq!(sent(&config, &[(100, 300), (900, 1_000)]), ["M24", "M25", "M24", "M25"]);
    }

    #[test]
    fn contacts_that_bounce_between_two_looks_are_one_press() {
        let config = machine("M24", "M25", "");
        let bouncing = [(95, 110), (120, 130), (135, 600), (610, 620), (625, 640)];
        assert_eq!(sent(&config, &bouncing), ["M24", "M25"]);
    }

    #[test]
    fn a_long_press_is_no_short_one() {
        let config = machine("M24", "", "abort");
        assert_eq!(sent(&config, &[(100, 500), (1_000, 3_500), (4_000, 4_200)]), ["M24", "abort", "M24"]);
    }

    #[test]
    fn a_jog_that_has_not_begun_when_its_button_is_let_go_does_not_begin() {
        let config = machine("$J -c X1", "$J STOP", "");
        let mut buttons = Buttons::new(&config);
        let pressed = InputLevels::default().with(Input::Button(0));
        assert_eq!(buttons.look(pressed, &config, Micros(0)), Urgent::default());
        assert!(buttons.look(InputLevels::default(), &config, Micros::from_millis(50)).stop_jog);
        assert_eq!(buttons.take_line(&config), None);
    }

    #[test]
    fn what_is_urgent_waits_for_no_line() {
        assert_eq!(sent(&machine("KILL", "$J STOP", ""), &[(100, 300)]), ["halted", "stopped"]);
    }
}
