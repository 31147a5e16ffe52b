//! Changes of the machine by codes, as far as they decide where and how fast a job may go: settings of the
//! job, and settings that the machine has saved (M500).

use base::failure::{Failure, ShortText, Texts, short};
use config::{Leveling, MachineConfig};
use motion::{GridShape, Motion};
use parts::heat_codes::named::maximum_of;
use procedures::leveling::{grid, words as leveling};
use program::Words;

use super::state::Preflight;

/// Difference below which a grid's size is the configured one, mm.
const SAME_SIZE: f64 = 1e-3;

/// Carries out M143: a heater's maximum temperature.
///
/// # Errors
/// When the machine would refuse it.
pub(super) fn set_maximum(preflight: &mut Preflight<'_>, words: &Words<'_>) -> Result<(), Failure> {
    if let Some((heater, most)) = maximum_of(preflight.texts, preflight.config, words)?
        && let Some(slot) = preflight.most_celsius.get_mut(heater.index())
    {
        *slot = most;
    }
    Ok(())
}

/// Carries out M852: the skew of the axes.
///
/// # Errors
/// When the machine would refuse it.
pub(super) fn set_skew(texts: &Texts, motion: &mut Motion, words: &Words<'_>) -> Result<(), Failure> {
    let Some(skew) = leveling::skew_of(texts, motion.compensation().skew(), words)? else { return Ok(()) };
    keeping_the_place(texts, motion, |motion| motion.set_skew(skew).map_err(|error| texts.refusal(error)))
}

/// Carries out M561: the plane of the bed.
///
/// # Errors
/// When the machine would refuse it.
pub(super) fn set_plane(texts: &Texts, motion: &mut Motion, words: &Words<'_>) -> Result<(), Failure> {
    let plane = leveling::plane_of(words)?;
    keeping_the_place(texts, motion, |motion| match plane {
        Some(plane) => motion.level_by_plane(plane).map_err(|error| texts.refusal(error)),
        None => motion.level_off().map_err(|error| texts.refusal(error)),
    })
}

/// Changes settings and keeps the coordinates: the tool follows the change.
fn keeping_the_place(
    texts: &Texts,
    motion: &mut Motion,
    change: impl FnOnce(&mut Motion) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let before = motion.commanded_position();
    change(motion)?;
    motion.set_position(before).map_err(|error| texts.refusal(error))
}

/// Levels by a mesh as the board keeps it.
///
/// # Errors
/// When the mesh does not fit this machine.
pub(super) fn level_by(
    preflight: &Preflight<'_>,
    motion: &mut Motion,
    shape: &GridShape,
    heights: &[f32],
    has_a_name: bool,
) -> Result<(), ShortText> {
    let (config, texts) = (preflight.config, preflight.texts);
    if !has_a_name {
        fits(config, shape)?;
    }
    motion.draft().iter_mut().zip(heights).for_each(|(to, height)| *to = *height);
    let (height, target) = preflight.fade;
    let fade = leveling::fade_up_to(&config.leveling, height, target);
    let between = config.leveling.mesh.interpolation;
    let levelled = keeping_the_place(texts, motion, |motion| {
        motion.level_by_draft(shape, between, fade).map_err(|error| texts.refusal(error))
    });
    levelled.map_err(|failure| texts.copy_of(failure))
}

/// Checks a grid of Smoothieware's, which does not say where it lies: it must be the configured one.
fn fits(config: &MachineConfig, shape: &GridShape) -> Result<(), ShortText> {
    let Some(wanted) = grid::configured(&config.leveling) else {
        return Err(short(format_args!("no grid is configured: write leveling = cartesian grid in [zprobe]")));
    };
    let ([nx, ny], [mx, my]) = (shape.count, wanted.count);
    if shape.count != wanted.count {
        let text = format_args!("it has {nx} x {ny} points, the configuration {mx} x {my}: measure the bed again");
        return Err(short(text));
    }
    let is_delta = config.leveling.strategy == Some(Leveling::DeltaGrid);
    let sizes = [0, 1].map(|axis: usize| {
        let of = |shape: &GridShape| shape.step.get(axis).copied().unwrap_or(0.0) * (nx.max(2) - 1) as f64;
        (of(shape), of(&wanted))
    });
    for (found, configured) in sizes {
        if !is_delta && libm::fabs(found - configured) > SAME_SIZE {
            let text = format_args!("it is {found:.3} mm long, in the configuration {configured:.3}: measure again");
            return Err(short(text));
        }
    }
    Ok(())
}
