//! Requests of a program to switches and to the operator's overrides: M48 to M51, M66, M226.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands;
use base::ports::{Input, InputLevels, MotionPort as _, Wake};
use base::safety::Event;
use base::sessions::Recipient;
use base::{Ports, World};
use jobs::player::Jobs;
use parts::outputs::{self, Outputs};
use program::{AwaitInput, InputEvent, Interpreter, Words};
use thermal::Output;
use units::SwitchId;

use crate::machine::Machine;
use crate::machine::hold::Hold;
use crate::machine::work_hands::MoveHands;

/// The operator's overrides, and what they act on.
pub(crate) struct Overrides<'m, 'c, P> {
    pub world: &'m mut World<'c, P>,
    pub program: &'m mut Interpreter,
    pub outputs: &'m mut Outputs,
    /// Delay of feed holds.
    pub hold: &'m mut Hold,
    /// Operator's factor of feed rates, while the program does not let it count.
    pub feed_waits: &'m mut Option<f64>,
}

/// The machine for the operator's overrides.
pub(crate) trait OverrideHands<'c>: MoveHands<'c> {
    /// Returns the overrides.
    fn overrides(&mut self) -> Overrides<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> OverrideHands<'c> for Machine<'c, P> {
    fn overrides(&mut self) -> Overrides<'_, 'c, P> {
        let Self { world, program, outputs, hold, feed_waits, .. } = self;
        Overrides { world, program, outputs, hold, feed_waits }
    }
}

/// Sets whether the operator's overrides count and a feed hold acts, once nothing moves (M48 to M51, taps).
/// Override values that were set stay known.
///
/// # Errors
/// When the machine halts meanwhile.
pub(crate) fn enable_overrides<'c>(
    hands: &mut impl OverrideHands<'c>,
    feed: bool,
    spindle: bool,
    hold: bool,
) -> Result<(), Failure> {
    hands.standstill()?;
    let Overrides { feed_waits, outputs, world, .. } = hands.overrides();
    match (feed, *feed_waits) {
        (true, Some(factor)) => {
            *feed_waits = None;
            set_feed(&mut world.ports, feed_waits, factor);
        }
        (false, None) => {
            let factors = world.ports.motion(|motion| motion.overrides());
            world.ports.motion(|motion| motion.set_overrides(1.0, factors.rapid));
            *feed_waits = Some(factors.feed);
        }
        _ => {}
    }
    outputs.let_override_count(spindle);
    say_spindle(world, outputs);
    // Holding from standstill acts before the next move; a session that aborts then is heard.
    if hands.overrides().hold.let_act(hold) && hands.apply(Event::Started) && hands.apply(Event::Hold) {
        hands.world().ports.motion(motion::Motion::hold);
    }
    Ok(())
}

/// Returns the operator's factor of feed rates, whether it counts or not.
pub(crate) fn feed<P: Ports>(ports: &mut P, waits: Option<f64>) -> f64 {
    waits.unwrap_or_else(|| ports.motion(|motion| motion.overrides().feed))
}

/// Sets the operator's factor of feed rates.
pub(crate) fn set_feed<P: Ports>(ports: &mut P, waits: &mut Option<f64>, factor: f64) {
    if waits.is_some() {
        *waits = Some(factor);
        return;
    }
    ports.motion(|motion| {
        let rapid = motion.overrides().rapid;
        motion.set_overrides(factor, rapid);
    });
}

/// Reports the speed factor (M220 without words); sets it from a console beside a job that is played, at once
/// for all that the job still makes. False: it is the program's, for lines read from now on.
pub(crate) fn speed_factor<P: Ports>(
    world: &mut World<'_, P>,
    program: &Interpreter,
    feed_waits: &mut Option<f64>,
    is_beside: bool,
    words: &Words<'_>,
    to: Recipient,
) -> bool {
    match words.get('S') {
        _ if words.is_bare() => {
            let percent = program.modal().speed_factor * feed(&mut world.ports, *feed_waits) * 100.0;
            world.say(to, format_args!("Speed factor at {percent:6.2} %\n"));
        }
        Some(factor) if is_beside => {
            let own = units::within(factor, 0.1, 10.0) / program.modal().speed_factor;
            set_feed(&mut world.ports, feed_waits, own);
            if !world.config.motion.compliant_seek_rate {
                world.ports.motion(|motion| motion.set_overrides(motion.overrides().feed, own));
            }
        }
        _ => return false,
    }
    true
}

/// Lets overrides count again that a job has put aside: it does not go on.
pub(crate) fn overrides_count_again<P: Ports>(overrides: Overrides<'_, '_, P>) {
    let Overrides { world, program, outputs, hold, feed_waits } = overrides;
    *hold = Hold::Acts;
    program.let_overrides_count();
    outputs.let_override_count(true);
    if let Some(factor) = feed_waits.take() {
        set_feed(&mut world.ports, feed_waits, factor);
    }
}

/// Resets overrides: the program has ended, or the machine was reset.
pub(crate) fn reset_overrides<P: Ports>(overrides: Overrides<'_, '_, P>) {
    let Overrides { world, program, outputs, hold, feed_waits } = overrides;
    *feed_waits = None;
    *hold = Hold::Acts;
    world.ports.motion(|motion| motion.set_overrides(1.0, 1.0));
    program::speed_factor::set(program, 1.0);
    outputs.let_override_count(true);
    outputs.override_spindle(100.0);
}

/// Reads an input once nothing moves, or waits for it (M66, M226). The result is `#5399`.
pub(crate) fn await_input<'c>(hands: &mut impl Hands<'c>, wait: AwaitInput) -> Outcome {
    hands.standstill()?;
    let found = await_event(hands, wait)?;
    hands.set_input_result(found.map_or(-1.0, |on| f64::from(u8::from(on))));
    Ok(Answer::Ok)
}

/// Waits for the level of an input, where there is one to wait for; none when it did not come in time.
fn await_event<'c>(hands: &mut impl Hands<'c>, wait: AwaitInput) -> Result<Option<bool>, Failure> {
    let is_on = |levels: InputLevels| levels.is_active(Input::Switch(wait.input.0));
    let (since, mut before) = (hands.now(), is_on(hands.inputs()));
    let Some(event) = wait.event else { return Ok(Some(before)) };
    loop {
        let now = is_on(hands.inputs());
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
        if hands.now().since(since) >= wait.patience {
            return Ok(None);
        }
        before = now;
        hands.wait(Wake::Any).unless_halted()?;
    }
}

/// Has the spindle turn as the operator wants it. Changes that ride on motion come first.
pub(crate) fn say_spindle<P: Ports>(World { ports, config, .. }: &mut World<'_, P>, outputs: &mut Outputs) {
    if !ports.heat(|heat| heat.has_effects()) {
        apply(ports, outputs.take_override(config));
    }
}

/// Tells of an S that the spindle cannot turn with: once in a job, and otherwise not the same twice.
pub(crate) fn tell_beyond<P: Ports>(
    world: &mut World<'_, P>,
    jobs: &mut Jobs,
    outputs: &mut Outputs,
    switch: SwitchId,
    s: Option<f32>,
) {
    let Some(beyond) = outputs::beyond(world.config, switch, s) else { return };
    let is_news = match jobs.noted() {
        Some(noted) => !core::mem::replace(&mut noted.told_speed, true),
        None => outputs.is_news(&beyond),
    };
    if is_news {
        world.announce(format_args!("WARNING: {beyond}\n"));
    }
}

/// Changes an output at once.
pub(crate) fn apply<P: Ports>(ports: &mut P, change: Option<Output>) {
    if let Some(output) = change {
        // A switch takes any value.
        let _ = ports.heat(|heat| heat.apply(output));
    }
}
