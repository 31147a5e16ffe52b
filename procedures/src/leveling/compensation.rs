//! Changes of the compensation while the machine stands, and its suspension for a while.

use base::bed::{Bed, MeshName};
use base::failure::{Answer, Failure, Outcome, Texts};
use base::ports::Wake;
use config::{Leveling, LevelingConfig};
use motion::{CompensationError, Fade, GridShape, Mode, Motion};
use program::Words;
use units::{Axis, AxisSet, Micros, MmPerSecond, PerAxis};

use super::words::fade_up_to;
use base::hands::Hands;

/// Greatest speed at which the tool follows a change of compensation.
const FOLLOWING: MmPerSecond = MmPerSecond(5.0);
/// Least change of a height, mm.
const NOTHING: f64 = 1e-6;
/// Time in which the motors' places are known after a halt: usually a millisecond or two; much more is a
/// fault.
const SETTLING_TIME: Micros = Micros::from_millis(100);

fn refuse(texts: &Texts, error: CompensationError) -> Failure {
    texts.refused(format_args!("{error}"))
}

/// Changes the compensation: coordinates stay, and the motors follow if the machine is homed.
pub(super) fn recompensate<'c>(
    hands: &mut impl Hands<'c>,
    change: impl FnOnce(&mut Motion) -> Result<(), CompensationError>,
) -> Outcome {
    hands.standstill()?;
    let before = hands.position();
    hands.motion(change).map_err(|error| refuse(hands.texts(), error))?;
    return_to(hands, before)
}

/// Takes leveling off for a command that measures the bed, or moves it. The tool stays and its coordinates
/// change: it may stand at the bed, and its former coordinates may now lie below.
pub fn take_off<'c>(hands: &mut impl Hands<'c>) -> Result<(), Failure> {
    hands.standstill()?;
    hands.motion(Motion::level_off).map_err(|error| refuse(hands.texts(), error))
}

/// Takes leveling off, or puts the same back: the tool stays, and its coordinates change. Over a high spot a
/// move would go down into the bed otherwise. On axes that are not homed the coordinates stay.
fn recompensate_in_place<'c>(
    hands: &mut impl Hands<'c>,
    change: impl FnOnce(&mut Motion) -> Result<(), CompensationError>,
) -> Outcome {
    hands.standstill()?;
    let before = hands.position();
    hands.motion(change).map_err(|error| refuse(hands.texts(), error))?;
    let changed = changed(&hands.position(), &before);
    if !hands.axes().homed().has_all(changed) {
        hands.set_position(before)?;
    }
    Ok(Answer::Ok)
}

/// Returns the axes whose coordinates have changed.
fn changed(now: &PerAxis<f64>, before: &PerAxis<f64>) -> AxisSet {
    let has_changed = |axis: &Axis| libm::fabs(now[*axis] - before[*axis]) > NOTHING;
    AxisSet::collect(Axis::PRIMARY.into_iter().filter(has_changed))
}

/// Restores the coordinates: by moving if the machine is homed, otherwise by declaring the position.
fn return_to<'c>(hands: &mut impl Hands<'c>, before: PerAxis<f64>) -> Outcome {
    let changed = changed(&hands.position(), &before);
    if !changed.is_empty() && hands.axes().homed().has_all(changed) {
        hands.go(before, FOLLOWING, Mode::Feed)?;
        hands.standstill()?;
    } else {
        hands.set_position(before)?;
    }
    Ok(Answer::Ok)
}

/// M370: switches leveling off.
pub fn level_off<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    let off = recompensate_in_place(hands, Motion::level_off)?;
    (hands.bed().mesh_name, hands.bed().mesh_waits) = (MeshName::default(), None);
    match hands.config().leveling.strategy {
        Some(Leveling::ThreePoint) => hands.say(format_args!("saved plane cleared\n")),
        Some(_) => hands.say(format_args!("grid cleared and disabled\n")),
        None => {}
    }
    Ok(off)
}

/// Levels by the heights in the motion object's draft, which were measured at the points of `shape`.
pub fn adopt_grid<'c>(hands: &mut impl Hands<'c>, shape: &GridShape) -> Outcome {
    let (leveling, bed) = (&hands.config().leveling, *hands.bed());
    let (fade, between) = (fade(leveling, &bed), leveling.mesh.interpolation);
    let there = moved(shape, bed.mesh_offset, -1.0);
    let adopted = recompensate(hands, |motion| motion.level_by_draft(&there, between, fade))?;
    (hands.bed().mesh_name, hands.bed().mesh_waits) = (MeshName::default(), None);
    Ok(adopted)
}

/// Levels by the grid in force once more, with changed settings; restores the settings when it is refused.
fn adopt_again<'c>(hands: &mut impl Hands<'c>, before: Bed) -> Outcome {
    // The grid's shape includes the offset before.
    let lies = hands.motion(|motion| motion.compensation().grid().map(|grid| *grid.shape()));
    let Some(lies) = lies else { return Ok(Answer::Ok) };
    hands.standstill()?;
    hands.motion(Motion::copy_to_draft);
    let changes = hands.motion(|motion| motion.compensation().changes());
    let adopted = adopt_grid(hands, &moved(&lies, before.mesh_offset, 1.0));
    if hands.motion(|motion| motion.compensation().changes()) == changes {
        *hands.bed() = before;
    } else {
        // The change is in force, also if a halt ended the tool's way after it.
        hands.bed().mesh_name = before.mesh_name;
    }
    adopted
}

/// Returns a grid moved by a multiple of an offset.
fn moved(shape: &GridShape, [x, y]: [f64; 2], times: f64) -> GridShape {
    let [ox, oy] = shape.origin;
    GridShape { origin: [ox + times * x, oy + times * y], ..*shape }
}

/// Returns the shape of the grid in force, as it was measured.
pub(super) fn shape_in_force<'c>(hands: &mut impl Hands<'c>) -> Option<GridShape> {
    let offset = hands.bed().mesh_offset;
    let lies = hands.motion(|motion| motion.compensation().grid().map(|grid| *grid.shape()));
    lies.map(|lies| moved(&lies, offset, 1.0))
}

/// M376 H, and M420 Z: sets the height above Z0 at which the mesh has faded; 0: no fading. M376 T: sets the
/// correction that is left there. Without words reports both.
pub fn fade_height<'c>(hands: &mut impl Hands<'c>, height: Option<f64>, target: Option<f64>) -> Outcome {
    if height.is_some_and(|height| height < 0.0) {
        return Err(Failure::refused(&"the height at which the mesh has faded is 0 or more"));
    }
    if height.is_some() || target.is_some() {
        let before = *hands.bed();
        let bed = hands.bed();
        (bed.fade_height, bed.fade_target) = (height.or(bed.fade_height), target.or(bed.fade_target));
        adopt_again(hands, before)?;
    }
    let (leveling, bed) = (&hands.config().leveling, *hands.bed());
    match fade(leveling, &bed) {
        Some(Fade { start, end, target: 0.0 }) => {
            hands.say(format_args!("the mesh fades from Z{start:.2} to Z{end:.2}\n"));
        }
        Some(Fade { start, end, target }) => {
            hands.say(format_args!("the mesh fades from Z{start:.2} to Z{end:.2}, where {target:.3} mm are left\n"));
        }
        None => hands.say(format_args!("the mesh does not fade\n")),
    }
    Ok(Answer::Ok)
}

/// M420.1: with the tool at X and Y, looks the mesh up at this distance from there; for a second tool.
pub fn mesh_offset<'c>(hands: &mut impl Hands<'c>, words: &Words<'_>) -> Outcome {
    let before = *hands.bed();
    for (offset, letter) in hands.bed().mesh_offset.iter_mut().zip(['X', 'Y']) {
        *offset = words.get(letter).unwrap_or(*offset);
    }
    if hands.bed().mesh_offset != before.mesh_offset {
        adopt_again(hands, before)?;
    }
    let [x, y] = hands.bed().mesh_offset;
    hands.say(format_args!("Mesh offset: X:{x:.4} Y:{y:.4}\n"));
    Ok(Answer::Ok)
}

/// Returns the fade of the mesh: as M376 says, or as configured.
fn fade(leveling: &LevelingConfig, bed: &Bed) -> Option<Fade> {
    fade_up_to(leveling, bed.fade_height, bed.fade_target)
}

/// M420 S0: switches leveling off, until S1 puts the same grid in force again.
pub(super) fn level_aside<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    let (has_grid, name) = (hands.motion(|motion| motion.compensation().grid().is_some()), hands.bed().mesh_name);
    let waited = hands.bed().mesh_waits;
    let offset = hands.bed().mesh_offset;
    recompensate_in_place(hands, Motion::level_off)?;
    hands.bed().mesh_waits = if has_grid { Some(offset) } else { waited };
    hands.bed().mesh_name = name;
    Ok(Answer::Ok)
}

/// M420 S1 after S0. Returns false if no grid waits.
pub(super) fn level_again<'c>(hands: &mut impl Hands<'c>) -> Result<bool, Failure> {
    let (leveling, bed) = (&hands.config().leveling, *hands.bed());
    let Some(before) = bed.mesh_waits else { return Ok(false) };
    let fade = fade(leveling, &bed);
    // M420.1 may have set another offset meanwhile.
    let by = [before[0] - bed.mesh_offset[0], before[1] - bed.mesh_offset[1]];
    recompensate_in_place(hands, |motion| motion.level_by_last_grid(by, fade))?;
    hands.bed().mesh_waits = None;
    Ok(true)
}

/// Suspends compensation: until [`put_compensation_back`] coordinates are the motors' own. Only while idle.
///
/// # Errors
/// When something moves.
pub fn set_compensation_aside<'c>(hands: &mut impl Hands<'c>) -> Result<(), Failure> {
    hands.motion(|motion| motion.suspend_compensation(true)).map_err(|error| refuse(hands.texts(), error))
}

/// Puts compensation in force again; nothing moves. Waits for the end of a stop or a halt.
///
/// # Errors
/// An alarm when the motors do not come to rest: coordinates would stay the motors' own, unnoticed.
pub fn put_compensation_back<'c>(hands: &mut impl Hands<'c>) -> Result<(), Failure> {
    let since = hands.now();
    loop {
        match hands.motion(|motion| motion.suspend_compensation(false)) {
            Ok(()) => return Ok(()),
            Err(_) if hands.now().since(since) < SETTLING_TIME => hands.wait(Wake::Any).whatever_happens(),
            Err(error) => return Err(hands.texts().alarm(format_args!("leveling is still off: {error}"))),
        }
    }
}
