//! Buttons of the configuration (`[button box]`): what their presses and releases send.

use base::ports::{Input, InputLevels};
use config::{ButtonConfig, ButtonWord, Command, MAX_BUTTONS, MachineConfig};
use heapless::{Deque, Vec};
use units::Micros;

/// Lines that can wait until the machine takes them. Without room for more, buttons are not looked at: their
/// presses are seen later.
const WAITING: usize = 8;

/// Action found at a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Act {
    Press,
    Release,
    LongPress,
}

/// Requests of buttons that cannot wait.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Urgent {
    /// Whether to halt the machine.
    pub kill: bool,
    /// Whether to end the jog that a button began.
    pub stop_jog: bool,
    /// Whether a further line waits.
    pub line: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Button {
    /// Time since which the button has been pressed, as of the last look.
    pressed: Option<Micros>,
    /// Whether the present press has been a long one.
    was_long: bool,
}

/// The buttons, in the configuration's order.
#[derive(Clone, Debug, Default)]
pub struct Buttons {
    buttons: Vec<Button, MAX_BUTTONS>,
    waiting: Deque<(u8, Act), WAITING>,
    due: Micros,
    /// Whether the buttons have been looked at since boot.
    known: bool,
}

impl Buttons {
    /// State before the first look. A button that is held then does nothing by that: a stuck or shorted
    /// button must not start a job. A button that halts does halt.
    #[must_use]
    pub fn new(config: &MachineConfig) -> Self {
        Self { buttons: config.buttons.iter().map(|_| Button::default()).collect(), ..Self::default() }
    }

    /// Looks at the buttons when due. Urgent requests are returned; lines wait for [`Self::take_line`].
    pub fn look(&mut self, levels: InputLevels, config: &MachineConfig, now: Micros) -> Urgent {
        let mut urgent = Urgent::default();
        if now < self.due {
            return urgent;
        }
        let is_first = !core::mem::replace(&mut self.known, true);
        self.due = now.plus(Micros(1_000_000 / u64::from(config.button_poll_hz.max(1))));
        for place in 0..self.buttons.len() {
            let Some(settings) = config.buttons.get(place) else { break };
            // Room is kept for a press and its release; urgent buttons are looked at all the same.
            if self.waiting.len() + 2 > WAITING && !is_urgent(settings) {
                continue;
            }
            let level = levels.is_active(Input::Button(place as u8));
            for act in self.acts(place, level, settings, now, is_first) {
                let line = line_of(config, place as u8, act);
                match line.and_then(|line| ButtonWord::of(line)) {
                    Some(ButtonWord::Kill) => urgent.kill = true,
                    Some(ButtonWord::StopJog) => {
                        urgent.stop_jog = true;
                        self.drop_jogs(config);
                    }
                    _ if line.is_some() => {
                        // Without room the press of an urgent button is lost: its jog does not begin.
                        urgent.line |= self.waiting.push_back((place as u8, act)).is_ok();
                    }
                    _ => {}
                }
            }
        }
        urgent
    }

    /// Drops jogs that have not begun: nobody holds their button any more.
    fn drop_jogs(&mut self, config: &MachineConfig) {
        for _ in 0..self.waiting.len() {
            let Some(next) = self.waiting.pop_front() else { return };
            if line_of(config, next.0, next.1).is_some_and(|line| !line.starts_with("$J")) {
                // The line fits, as it has just been taken from there.
                let _fits = self.waiting.push_back(next);
            }
        }
    }

    /// Returns what a button does, given its present level.
    fn acts(&mut self, place: usize, level: bool, settings: &ButtonConfig, now: Micros, is_first: bool) -> Vec<Act, 2> {
        let mut acts = Vec::new();
        let Some(button) = self.buttons.get_mut(place) else { return acts };
        let has_long = !settings.long_press.is_empty();
        let mut add = |act| {
            // A button does at most two things in a look.
            let _fits = acts.push(act);
        };
        match (button.pressed, level) {
            (None, true) => {
                *button = Button { pressed: Some(now), was_long: is_first };
                let halts = ButtonWord::of(&settings.press) == Some(ButtonWord::Kill);
                if !has_long && (!is_first || halts) {
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

    /// Returns the lines that wait, in order.
    pub fn lines<'c>(&self, config: &'c MachineConfig) -> impl Iterator<Item = &'c Command> {
        self.waiting.iter().filter_map(|&(place, act)| line_of(config, place, act))
    }

    /// Takes the next line that a button sends.
    pub fn take_line(&mut self, config: &MachineConfig) -> Option<Command> {
        let (place, act) = self.waiting.pop_front()?;
        line_of(config, place, act).cloned()
    }
}

/// Returns whether a line of this button cannot wait for others.
fn is_urgent(settings: &ButtonConfig) -> bool {
    let words = [&settings.press, &settings.release, &settings.long_press].map(|line| ButtonWord::of(line));
    words.contains(&Some(ButtonWord::Kill)) || words.contains(&Some(ButtonWord::StopJog))
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
        for (ms, levels, line) in [(0, InputLevels::default(), false), (50, pressed, true)] {
            let urgent = buttons.look(levels, &config, Micros::from_millis(ms));
            assert_eq!(urgent, Urgent { line, ..Urgent::default() });
        }
        assert!(buttons.look(InputLevels::default(), &config, Micros::from_millis(100)).stop_jog);
        assert_eq!(buttons.take_line(&config), None);
    }

    #[test]
    fn a_jog_ends_though_no_more_lines_fit() {
        let mut config = machine("M24", "M25", "");
        let jog = machine("$J -c X1", "$J STOP", "").buttons.remove(0);
        assert!(config.buttons.push(jog).is_ok());
        let mut buttons = Buttons::new(&config);
        let jogs = InputLevels::default().with(Input::Button(1));
        let mut ms = 0;
        let mut look = |buttons: &mut Buttons, levels| {
            ms += 50;
            buttons.look(levels, &config, Micros::from_millis(ms))
        };
        look(&mut buttons, InputLevels::default());
        look(&mut buttons, jogs);
        for _ in 0..10 {
            look(&mut buttons, jogs.with(Input::Button(0)));
            look(&mut buttons, jogs);
        }
        assert!(look(&mut buttons, InputLevels::default()).stop_jog);
    }

    #[test]
    fn a_button_that_is_held_at_boot_starts_nothing_but_halts() {
        assert_eq!(sent(&machine("M24", "", ""), &[(0, 500), (900, 1_000)]), ["M24"]);
        assert_eq!(sent(&machine("M24", "", "abort"), &[(0, 3_000), (3_500, 3_700)]), ["M24"]);
        assert_eq!(sent(&machine("KILL", "", ""), &[(0, 500)]), ["halted"]);
    }

    #[test]
    fn what_is_urgent_waits_for_no_line() {
        assert_eq!(sent(&machine("KILL", "$J STOP", ""), &[(100, 300)]), ["halted", "stopped"]);
    }
}
