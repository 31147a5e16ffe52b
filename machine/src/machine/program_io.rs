//! Requests of a program to switches and to the operator's overrides: M48 to M51, M66, M226.

use base::Ports;
use base::failure::{Answer, Failure, Outcome};
use base::ports::{Input, Wake};
use base::safety::Event;
use base::sessions::Recipient;
use parts::outputs;
use program::{AwaitInput, InputEvent, Words};
use thermal::Output;
use units::SwitchId;

use crate::machine::Machine;
use crate::machine::hold::Hold;

/// Sets whether the operator's overrides count and a feed hold acts, once nothing moves (M48 to M51, taps).
/// Override values that were set stay known.
///
/// # Errors
/// When the machine halts meanwhile.
pub(crate) fn enable_overrides<P: Ports>(
    machine: &mut Machine<'_, P>,
    feed: bool,
    spindle: bool,
    hold: bool,
) -> Result<(), Failure> {
    machine.standstill()?;
    match (feed, machine.feed_waits) {
        (true, Some(factor)) => {
            machine.feed_waits = None;
            set_feed(machine, factor);
        }
        (false, None) => {
            let factors = machine.world.ports.motion(|motion| motion.overrides());
            machine.world.ports.motion(|motion| motion.set_overrides(1.0, factors.rapid));
            machine.feed_waits = Some(factors.feed);
        }
        _ => {}
    }
    machine.outputs.let_override_count(spindle);
    say_spindle(machine);
    // Holding from standstill acts before the next move; a session that aborts then is heard.
    if machine.hold.let_act(hold) && machine.safety.apply(Event::Started) && machine.safety.apply(Event::Hold) {
        machine.world.ports.motion(motion::Motion::hold);
    }
    Ok(())
}

/// Returns the operator's factor of feed rates, whether it counts or not.
pub(crate) fn feed<P: Ports>(machine: &mut Machine<'_, P>) -> f64 {
    machine.feed_waits.unwrap_or_else(|| machine.world.ports.motion(|motion| motion.overrides().feed))
}

/// Sets the operator's factor of feed rates.
pub(crate) fn set_feed<P: Ports>(machine: &mut Machine<'_, P>, factor: f64) {
    if machine.feed_waits.is_some() {
        machine.feed_waits = Some(factor);
        return;
    }
    machine.world.ports.motion(|motion| {
        let rapid = motion.overrides().rapid;
        motion.set_overrides(factor, rapid);
    });
}

/// Reports the speed factor (M220 without words); sets it from a console beside a job that is played, at once
/// for all that the job still makes. False: it is the program's, for lines read from now on.
pub(crate) fn speed_factor<P: Ports>(machine: &mut Machine<'_, P>, words: &Words<'_>, to: Recipient) -> bool {
    let is_beside = machine.jobs.is_open() && machine.jobs.made(machine.tag).is_none();
    match words.get('S') {
        _ if words.is_bare() => {
            let percent = machine.program.modal().speed_factor * feed(machine) * 100.0;
            machine.say(to, format_args!("Speed factor at {percent:6.2} %\n"));
        }
        Some(factor) if is_beside => {
            let own = factor.clamp(0.1, 10.0) / machine.program.modal().speed_factor;
            set_feed(machine, own);
            if !machine.world.config.motion.compliant_seek_rate {
                let feed = machine.world.ports.motion(|motion| motion.overrides().feed);
                machine.world.ports.motion(|motion| motion.set_overrides(feed, own));
            }
        }
        _ => return false,
    }
    true
}

/// Lets holds act again after a tap that does not go on: a hold that has waited for it comes too late.
pub(crate) fn let_hold_act_again<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.hold != Hold::Acts {
        overrides_count_again(machine);
    }
}

/// Lets overrides count again that a job has put aside: it does not go on.
pub(crate) fn overrides_count_again<P: Ports>(machine: &mut Machine<'_, P>) {
    machine.hold = Hold::Acts;
    machine.program.let_overrides_count();
    machine.outputs.let_override_count(true);
    if let Some(factor) = machine.feed_waits.take() {
        set_feed(machine, factor);
    }
}

/// Resets overrides: the program has ended, or the machine was reset.
pub(crate) fn reset_overrides<P: Ports>(machine: &mut Machine<'_, P>) {
    machine.feed_waits = None;
    machine.hold = Hold::Acts;
    machine.world.ports.motion(|motion| motion.set_overrides(1.0, 1.0));
    program::speed_factor::set(&mut machine.program, 1.0);
    machine.outputs.let_override_count(true);
    machine.outputs.override_spindle(100.0);
}

/// Reads an input once nothing moves, or waits for it (M66, M226). The result is `#5399`.
pub(crate) fn await_input<P: Ports>(machine: &mut Machine<'_, P>, wait: AwaitInput) -> Outcome {
    machine.standstill()?;
    let found = match wait.event {
        None => Some(is_on(machine, wait)),
        Some(event) => await_event(machine, wait, event)?,
    };
    machine.program.set_input_result(found.map_or(-1.0, |on| f64::from(u8::from(on))));
    Ok(Answer::Ok)
}

fn is_on<P: Ports>(machine: &Machine<'_, P>, wait: AwaitInput) -> bool {
    machine.world.ports.inputs().is_active(Input::Switch(wait.input.0))
}

/// Waits for the level of an input; none when it did not come in time.
fn await_event<P: Ports>(
    machine: &mut Machine<'_, P>,
    wait: AwaitInput,
    event: InputEvent,
) -> Result<Option<bool>, Failure> {
    let (since, mut before) = (machine.world.ports.now(), is_on(machine, wait));
    loop {
        let now = is_on(machine, wait);
        let came = match event {
            InputEvent::Rise => now && !before,
            InputEvent::Fall => !now && before,
            InputEvent::High => now,
            InputEvent::Low => !now,
            InputEvent::Change => now != before,
        };
        if came {
            return Ok(Some(now));
        }
        if machine.world.ports.now().since(since) >= wait.patience {
            return Ok(None);
        }
        before = now;
        machine.wait(Wake::Any).unless_halted()?;
    }
}

/// Has the spindle turn as the operator wants it. Changes that ride on motion come first.
pub(crate) fn say_spindle<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.world.ports.heat(|heat| heat.has_effects()) {
        return;
    }
    let change = machine.outputs.take_override(machine.world.config);
    apply(machine, change);
}

/// Tells of an S that the spindle cannot turn with: once in a job, and otherwise not the same twice.
pub(crate) fn tell_beyond<P: Ports>(machine: &mut Machine<'_, P>, switch: SwitchId, s: Option<f32>) {
    let Some(beyond) = outputs::beyond(machine.world.config, switch, s) else { return };
    let is_news = match machine.jobs.noted() {
        Some(noted) => !core::mem::replace(&mut noted.told_speed, true),
        None => machine.outputs.is_news(&beyond),
    };
    if is_news {
        machine.announce(format_args!("WARNING: {beyond}\n"));
    }
}

/// Changes an output at once.
pub(crate) fn apply<P: Ports>(machine: &mut Machine<'_, P>, change: Option<Output>) {
    if let Some(output) = change {
        // A switch takes any value.
        let _ = machine.world.ports.heat(|heat| heat.apply(output));
    }
}
