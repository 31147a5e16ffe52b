//! Changing the compensation while the machine stands, and suspending it for a while.

use config::{Leveling, LevelingConfig};
use motion::{CompensationError, Fade, GridShape, Mode, Motion};
use units::{Axis, AxisSet, Micros, MmPerSecond, PerAxis};

use crate::executor::Hands;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::Ports;

/// The tool follows a change of compensation at this speed at most.
const FOLLOWING: MmPerSecond = MmPerSecond(5.0);
/// Less than this, mm, is no change.
const NOTHING: f64 = 1e-6;
/// After a halt the motors' places are known within a millisecond or two; much more is a fault.
const SETTLING_TIME: Micros = Micros::from_millis(100);

fn refuse(error: CompensationError) -> Failure {
    Failure::Refused(message(format_args!("{error}")))
}

/// A number to so many parts of one: so it is saved exactly.
pub(super) fn rounded(value: f64, parts: f64) -> f64 {
    libm::floor(value * parts + 0.5) / parts
}

/// Changes the compensation: coordinates stay, and the motors follow where the machine knows where it is.
pub(crate) async fn recompensate<P: Ports>(
    hands: &mut Hands<'_, '_, P>,
    change: impl FnOnce(&mut Motion) -> Result<(), CompensationError>,
) -> Outcome {
    hands.standstill().await?;
    let before = hands.position();
    hands.motion(change).map_err(refuse)?;
    return_to(hands, before).await
}

/// The machine reads as before again: by moving where it is homed, else by taking its word for it.
async fn return_to<P: Ports>(hands: &mut Hands<'_, '_, P>, before: PerAxis<f64>) -> Outcome {
    let now = hands.position();
    let has_changed = |axis: &Axis| libm::fabs(now[*axis] - before[*axis]) > NOTHING;
    let changed = AxisSet::collect(Axis::PRIMARY.into_iter().filter(has_changed));
    if !changed.is_empty() && hands.axes().homed().has_all(changed) {
        hands.go(before, FOLLOWING, Mode::Feed).await?;
        hands.standstill().await?;
    } else {
        hands.set_position(before)?;
    }
    Ok(Answer::Ok)
}

/// M370: no leveling.
pub(crate) async fn level_off<P: Ports>(hands: &mut Hands<'_, '_, P>) -> Outcome {
    let off = recompensate(hands, Motion::level_off).await?;
    match hands.config().leveling.strategy {
        Some(Leveling::ThreePoint) => hands.say(format_args!("saved plane cleared\n")),
        Some(_) => hands.say(format_args!("grid cleared and disabled\n")),
        None => {}
    }
    Ok(off)
}

/// Levels by the heights in the motion object's draft.
pub(crate) async fn adopt_grid<P: Ports>(hands: &mut Hands<'_, '_, P>, shape: &GridShape) -> Outcome {
    let fade = fade(&hands.config().leveling);
    recompensate(hands, |motion| motion.level_by_draft(shape, fade)).await
}

fn fade(leveling: &LevelingConfig) -> Option<Fade> {
    let is_meant = leveling.strategy == Some(Leveling::CartesianGrid);
    let fade = Fade { start: leveling.grid.fade_start.0, end: leveling.grid.fade_end.0 };
    (is_meant && fade.end > fade.start).then_some(fade)
}

/// Suspends compensation: until [`put_compensation_back`] coordinates are the motors' own. Only while idle.
///
/// # Errors
/// When something moves.
pub(crate) fn set_compensation_aside<P: Ports>(hands: &mut Hands<'_, '_, P>) -> Result<(), Failure> {
    hands.motion(|motion| motion.suspend_compensation(true)).map_err(refuse)
}

/// Puts compensation in force again; nothing moves. Waits for the end of a stop or a halt.
///
/// # Errors
/// An alarm when the motors do not come to rest: coordinates would stay the motors' own, unnoticed.
pub(crate) async fn put_compensation_back<P: Ports>(hands: &mut Hands<'_, '_, P>) -> Result<(), Failure> {
    let since = hands.now();
    loop {
        match hands.motion(|motion| motion.suspend_compensation(false)) {
            Ok(()) => return Ok(()),
            Err(_) if hands.now().since(since) < SETTLING_TIME => hands.pause_anyway().await,
            Err(error) => return Err(Failure::Alarm(message(format_args!("leveling is still off: {error}")))),
        }
    }
}
