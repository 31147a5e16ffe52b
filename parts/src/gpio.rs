//! `gpio`: reads an unused pin or drives it for a while, to find out what is wired where.

use base::failure::{Answer, Failure, Outcome, Texts};
use base::hands::Hands;
use base::ports::{PinPort, Wake};
use config::{Pin, PinName, Pull, parse_pin};
use units::Micros;

/// Time for which a pin is driven without a duration, ms.
const DRIVEN_MS: u32 = 2_000;
/// Longest time for which a pin is driven, ms: for longer there is `[switch]`.
const MOST_MS: u32 = 60_000;

/// Request for a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Request {
    Read,
    /// Level (on or off), and for how many milliseconds.
    Drive(bool, u32),
}

/// Parses `PJ1^ in` and `PJ1! out on 500`.
fn parse(texts: &Texts, arguments: &str) -> Result<(Pin, Request), Failure> {
    let mut words = arguments.split_ascii_whitespace();
    let name = words.next().ok_or_else(usage)?;
    let pin = match parse_pin(name) {
        Ok(Some(PinName::Digital(pin))) => pin,
        Ok(_) => return Err(illegal(texts, name)),
        Err(flaw) => return Err(texts.refused(format_args!("Illegal pin name: {name} {flaw}"))),
    };
    let request = match words.next() {
        None | Some("in" | "i") => return Ok((pulled(pin), ended(words, Request::Read)?)),
        Some("out" | "o") => {
            let on = match words.next() {
                Some("on" | "1") => true,
                Some("off" | "0") => false,
                _ => return Err(Failure::refused(&"on|off required")),
            };
            Request::Drive(on, duration(texts, words.next())?)
        }
        Some(_) => return Err(usage()),
    };
    Ok((pin, ended(words, request)?))
}

/// Checks that no further word follows.
fn ended<'t>(mut words: impl Iterator<Item = &'t str>, request: Request) -> Result<Request, Failure> {
    if words.next().is_none() { Ok(request) } else { Err(usage()) }
}

/// Gives an input a pull-up without another choice, as in `config.ini`.
fn pulled(pin: Pin) -> Pin {
    if pin.pull == Pull::Default { Pin { pull: Pull::Up, ..pin } } else { pin }
}

fn usage() -> Failure {
    Failure::refused(&"incorrect usage: gpio PA6 [in | out on|off [milliseconds]]")
}

fn illegal(texts: &Texts, name: &str) -> Failure {
    texts.refused(format_args!("Illegal pin name: {name} is no pin that is on or off"))
}

fn duration(texts: &Texts, word: Option<&str>) -> Result<u32, Failure> {
    let Some(word) = word else { return Ok(DRIVEN_MS) };
    let ms = word.parse().ok().filter(|ms| (1..=MOST_MS).contains(ms));
    ms.ok_or_else(|| texts.refused(format_args!("a pin is driven for 1 to {MOST_MS} milliseconds")))
}

/// Carries out `gpio pin [in | out on|off [ms]]`. A driven pin is as after a reset at the end, however it
/// ends: by time, by Ctrl-Y or by a halt.
///
/// # Errors
/// When the pin is used, or driven by the board itself, and for a command that is not understood.
pub fn command<'c>(hands: &mut impl Hands<'c>, arguments: &str) -> Outcome {
    let (pin, request) = parse(hands.texts(), arguments)?;
    let drives = match request {
        Request::Read => None,
        Request::Drive(on, _) => Some(on),
    };
    if let Some(purpose) = config::reserved_for(pin) {
        return Err(hands.texts().refused(format_args!("{} belongs to {purpose}", bare(pin))));
    }
    if drives.is_some()
        && let Some(driver) = config::driven_by(pin)
    {
        return Err(hands
            .texts()
            .refused(format_args!("{}: {driver} drives it, so it cannot be an output", bare(pin))));
    }
    let level = hands.storage().borrow_pin(pin, drives).map_err(|why| hands.texts().refused(format_args!("{why}")))?;
    match request {
        Request::Read => {
            hands.storage().return_pin(pin);
            hands.say(format_args!("{pin}:{}\n", u8::from(level)));
        }
        Request::Drive(on, ms) => {
            hands.say(format_args!("{pin}:{}: was set to {}\n", u8::from(level), if on { "on" } else { "off" }));
            let ended = wait(hands, Micros(u64::from(ms) * 1_000));
            hands.storage().return_pin(pin);
            ended?;
        }
    }
    Ok(Answer::Ok)
}

/// Returns the pin without inversion, open drain and pull.
fn bare(pin: Pin) -> Pin {
    Pin { inverted: false, open_drain: false, pull: Pull::Default, ..pin }
}

/// Waits for the time to pass, for Ctrl-Y, or until the asking session has gone.
fn wait<'c>(hands: &mut impl Hands<'c>, time: Micros) -> Result<(), Failure> {
    let ends = hands.now().plus(time);
    while hands.now() < ends && !hands.is_let_go() {
        hands.wait(Wake::Any).unless_halted()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_levels_and_times_are_read() {
        let pin = Pin::new('J', 1);
        assert_eq!(parse(&Texts::new(), "PJ1"), Ok((Pin { pull: Pull::Up, ..pin }, Request::Read)));
        assert_eq!(parse(&Texts::new(), "pj_1v in"), Ok((Pin { pull: Pull::Down, ..pin }, Request::Read)));
        assert_eq!(parse(&Texts::new(), "PJ1 out on"), Ok((pin, Request::Drive(true, DRIVEN_MS))));
        assert_eq!(
            parse(&Texts::new(), "PJ1! o 0 100"),
            Ok((Pin { inverted: true, ..pin }, Request::Drive(false, 100)))
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (arguments, part) in [
            ("", "incorrect usage"),
            ("PJ1 sideways", "incorrect usage"),
            ("PJ1 in 5", "incorrect usage"),
            ("PJ1 out on 5 5", "incorrect usage"),
            ("PJ1 out", "on|off required"),
            ("PJ1 out on 0", "1 to 60000"),
            ("PJ1 out on x", "1 to 60000"),
            ("XX", "Illegal pin name: XX"),
            ("nc", "Illegal pin name: nc"),
            ("ADC1_1", "Illegal pin name: ADC1_1"),
        ] {
            let texts = Texts::new();
            let refused = parse(&texts, arguments).unwrap_err();
            let text = texts.of(refused).to_string();
            assert!(refused.is_refusal() && text.contains(part), "{arguments}: {text}");
        }
    }
}
