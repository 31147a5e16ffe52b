//! Waiting for temperatures: M109, M190, M116.

use base::failure::Failure;
use base::hands::Hands;
use base::needs::needs;
use base::ports::Wake;
use config::{HeaterId, ToolId};
use program::{Part, Words};
use thermal::{HeatControl, Heater, OFF_BELOW, SensorFault};
use units::{Celsius, Micros};

use super::{allow_target, change_target, check_supply, temperature_text};

/// Period of temperature reports during a wait.
const WAIT_REPORT: Micros = Micros::from_millis(1_200);
/// Distance from the target, C, that counts as reached from above, and for a job that goes on, if
/// `wait_window` is less.
const NEAR: f32 = 1.0;
/// A heater that is no warmer than this and has not cooled by `COOLS` within `COOLS_WITHIN` is as cold as its
/// surroundings.
const SAFE: Celsius = Celsius(50.0);
const COOLS: f32 = 0.5;
const COOLS_WITHIN: Micros = Micros::from_seconds(300);
/// Time from power-on within which every sensor has been read, also by a converter chip of many samples.
const FIRST_READING_WITHIN: Micros = Micros::from_seconds(1);

/// Condition that ends a wait.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Until {
    /// The reading has come up to the target.
    Warm,
    /// The reading has come up to the target, or nearly.
    About,
    /// The reading has come to the target, from below or from above.
    Near,
    /// The reading lies between these two temperatures.
    Between(Celsius, Celsius),
}

/// Progress of a wait.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Progress {
    Arrived,
    /// The present reading, and the temperature to which it must come down.
    Above(Celsius, Celsius),
    NotYet,
}

/// M109 and M190: sets a target once nothing moves, and waits until the reading has come up to it; with
/// `cools`, also until it has come down to it.
///
/// # Errors
/// Before anything waits or changes: when the heater does not allow that target or stays off, or there is no
/// supply to heat with.
pub fn heat_and_wait<'c>(
    hands: &mut impl Hands<'c>,
    heater: HeaterId,
    target: Celsius,
    cools: bool,
) -> Result<(), Failure> {
    let texts = hands.texts();
    let config = hands.config();
    if target > OFF_BELOW {
        needs(texts, config, Part::Heater(heater), hands.is_playing())?;
    }
    hands.heat(|heat| allow_target(texts, heat, config, heater, target))?;
    check_supply(hands, target)?;
    hands.standstill()?;
    // The supply is checked again, since coming to a standstill may have taken minutes.
    check_supply(hands, target)?;
    hands.heat(|heat| change_target(texts, heat, config, heater, target))?;
    hands.begin_wait();
    wait_until(hands, heater, if cools { Until::Near } else { Until::Warm }, true)
}

/// Waits until a heater is again about as warm as before, reporting temperatures: the last tenth of a degree
/// takes a minute and longer, and no part needs it.
///
/// # Errors
/// When the machine halts meanwhile.
pub fn wait_for_temperature<'c>(hands: &mut impl Hands<'c>, heater: HeaterId) -> Result<(), Failure> {
    wait_until(hands, heater, Until::About, false)
}

/// Waits until a sensor has been read, or has said why it cannot be: in the first moments its reading is
/// unknown.
///
/// # Errors
/// When the machine halts meanwhile.
pub fn wait_for_first_reading<'c>(hands: &mut impl Hands<'c>, heater: HeaterId) -> Result<(), Failure> {
    let since = hands.now();
    let is_unread = |heat: &HeatControl| heat.heater(heater).and_then(Heater::fault) == Some(SensorFault::SILENT);
    while hands.heat(|heat| is_unread(heat)) && hands.now().since(since) < FIRST_READING_WITHIN {
        hands.wait(Wake::Time).unless_halted()?;
    }
    Ok(())
}

/// Waits for a reading; ended by the heater's `wait_timeout`, or by M108 if `may_end`.
fn wait_until<'c>(hands: &mut impl Hands<'c>, heater: HeaterId, until: Until, may_end: bool) -> Result<(), Failure> {
    let config = hands.config();
    let Some(described) = config.heater(heater) else { return Ok(()) };
    let (wait, name) = (described.wait, &described.name);
    let (mut warms_since, mut arrived) = (hands.now(), None);
    // Reading from which the heater has cooled, and the time of that reading.
    let mut cools = (Celsius(f32::MAX), warms_since);
    let mut report_due = warms_since.plus(WAIT_REPORT);
    loop {
        let now = hands.now();
        match hands.heat(|heat| progress(heat, heater, until, wait.window)) {
            Progress::Arrived => {
                let is_off = hands.heat(|heat| heat.heater(heater).is_none_or(|heater| !heater.is_on()));
                if is_off || now.since(*arrived.get_or_insert(now)) >= wait.dwell {
                    return Ok(());
                }
            }
            Progress::Above(reading, most) => {
                (warms_since, arrived) = (now, None);
                if reading > SAFE || reading.0 <= cools.0.0 - COOLS {
                    cools = (reading, now);
                }
                if now.since(cools.1) > COOLS_WITHIN {
                    let text = format_args!(
                        "// NOTE {name} is at {reading:.1} and cools no more: not waiting for {most:.1}\n"
                    );
                    hands.announce(text);
                    return Ok(());
                }
            }
            Progress::NotYet => arrived = None,
        }
        if wait.timeout > Micros(0) && now.since(warms_since) > wait.timeout {
            let seconds = wait.timeout.seconds();
            let text =
                format_args!("{name} is not at its target after {seconds} s, its wait_timeout; it goes on heating");
            return Err(hands.texts().refused(text));
        }
        if now >= report_due {
            report_due = report_due.plus(WAIT_REPORT);
            if let Some(text) = hands.heat(|heat| temperature_text(heat, config, heater)) {
                hands.say(format_args!("{text}\n"));
            }
        }
        if let Err(failure) = hands.wait(Wake::Time).unless_halted() {
            if !hands.is_ended() {
                hands.say(format_args!("Wait on temperature aborted by kill\n"));
            }
            return Err(failure);
        }
        if may_end && hands.wait_is_over() {
            hands.announce(format_args!("// NOTE {name} is not waited for any more (M108)\n"));
            return Ok(());
        }
        if hands.leaves_wait() {
            return Err(Failure::HALTED);
        }
    }
}

/// M116: waits for every heater that has a target, or for the heater with the id P; with A and B until its
/// reading is between these; with `cools`, until heaters that are too warm have come down too.
///
/// # Errors
/// When no heater has that id, a heater must not become so warm, or the machine halts meanwhile.
pub fn wait_for_all<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>, cools: bool) -> Result<(), Failure> {
    let (config, wanted) = (hands.config(), words.get('P').map(ToolId::from_word));
    let is_meant = |id: ToolId| wanted.is_none_or(|wanted| wanted == Some(id));
    if !config.heaters().any(|(_, heater)| is_meant(heater.tool_id)) {
        return Err(Failure::refused(&"M116: no heater has that id"));
    }
    let bound = |letter: char| words.get(letter).map(|celsius| celsius as f32);
    let (least, most) = (bound('A'), bound('B'));
    let until = match (least, most) {
        _ if cools => Until::Near,
        (None, None) => Until::Warm,
        _ => Until::Between(Celsius(least.unwrap_or(f32::MIN)), Celsius(most.unwrap_or(f32::MAX))),
    };
    hands.standstill()?;
    hands.begin_wait();
    for (heater, _) in config.heaters().filter(|(_, heater)| is_meant(heater.tool_id)) {
        wait_for_first_reading(hands, heater)?;
        let state = hands.heat(|heat| heat.heater(heater).map(|heater| (heater.reading(), heater.target())));
        if let (Until::Between(least, _), Some((reading, target))) = (until, state)
            && reading.is_none_or(|reading| reading < least)
            && target < least
        {
            return Err(Failure::refused(&"M116: that heater is not set to become so warm"));
        }
        wait_until(hands, heater, until, true)?;
    }
    Ok(())
}

/// Returns the progress of a wait for a heater.
fn progress(heat: &HeatControl, heater: HeaterId, until: Until, window: Celsius) -> Progress {
    let Some((reading, target)) = heat.heater(heater).map(|heater| (heater.reading(), heater.target())) else {
        return Progress::Arrived;
    };
    let (least, most) = match until {
        // A fault has taken the target away. The machine halts at one of the next waiting points; going on to
        // the next line before that would move a machine that must stand.
        _ if heat.is_halted() => return Progress::NotYet,
        Until::Between(least, most) => (least, most),
        // A target of zero was turned off meanwhile, so there is nothing to wait for.
        _ if target <= Celsius(0.0) => return Progress::Arrived,
        Until::Warm => (target - window, Celsius(f32::MAX)),
        Until::About => (Celsius(target.0 - window.0.max(NEAR)), Celsius(f32::MAX)),
        Until::Near => (target - window, Celsius(target.0 + window.0.max(NEAR))),
    };
    match reading {
        Some(reading) if reading > most => Progress::Above(reading, most),
        Some(reading) if reading >= least => Progress::Arrived,
        _ => Progress::NotYet,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::TemperatureConfig;

    #[test]
    fn a_wait_is_over_when_the_heater_was_switched_off_but_not_while_halted() {
        let mut control = HeatControl::new();
        let heater = control.add((&TemperatureConfig::default()).into()).unwrap();
        let progress = |control: &HeatControl| super::progress(control, heater, Until::Warm, Celsius(0.0));
        assert_eq!(progress(&control), Progress::Arrived);
        control.halt();
        assert_eq!(progress(&control), Progress::NotYet);
    }
}
