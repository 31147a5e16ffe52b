//! G29, G31 and G32: their meaning depends on the leveling strategy and on the machine.

use base::failure::{Answer, Failure, Outcome};
use config::{Leveling, MachineConfig};
use gcode::Code;
use program::Words;

use super::delta_calibration::{calibrate_delta, measure_delta};
use super::grids::{level_by_delta_grid, prepare_cartesian_grid, prepare_scan, scan_delta};
use super::plan::Plan;
use super::three_point::{level_by_three_points, measure_three_points, show_plane};
use crate::leveling;
use crate::probing::ProbeHands;

/// Returns the strategy that these words ask for: P1 means calibration alone, unless it is another
/// firmware's.
fn strategy_of(config: &MachineConfig, words: &Words<'_>, code: Code) -> Option<Leveling> {
    config.leveling.strategy.filter(|_| words.code() != code || words.get('P') != Some(1.0))
}

/// Homes, and finds the area, before the configured `before_probe_gcode` runs. `Some` when these words probe
/// a cartesian grid: then that script follows, [`super::touch_cartesian_grid`] with the plan, and, however
/// that ended, `after_probe_gcode`. `None`: nothing was done, and the code is [`strategy`]'s.
pub fn prepare<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>, code: Code) -> Result<Option<Plan>, Failure> {
    let config = hands.config();
    if !config.probe.enable || strategy_of(config, words, code) != Some(Leveling::CartesianGrid) {
        return Ok(None);
    }
    match (code.number, code.subcode) {
        (29, 0) => prepare_scan(hands, words).map(Some),
        (31 | 32, 0) => prepare_cartesian_grid(hands, words).map(Some),
        _ => Ok(None),
    }
}

/// Runs a measurement of the bare machine or bed, without leveling.
pub(super) fn uncompensated<'c, H: ProbeHands<'c>>(hands: &mut H, measure: impl FnOnce(&mut H) -> Outcome) -> Outcome {
    hands.standstill()?;
    leveling::set_compensation_aside(hands)?;
    let done = measure(hands);
    let put_back = leveling::put_compensation_back(hands);
    done.and_then(|answer| put_back.map(|()| answer))
}

/// Runs G29, G31 and G32: by the leveling strategy if it knows them, otherwise as calibration; P1 means the
/// latter alone. `code` is the meant code, which in other firmwares' dialects differs from the written. The
/// scripts around a cartesian grid are the caller's: see [`prepare`].
pub fn strategy<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>, code: Code) -> Outcome {
    let config = hands.config();
    if !config.probe.enable {
        return Ok(Answer::Unknown);
    }
    let (number, subcode) = (code.number, code.subcode);
    match (strategy_of(config, words, code), number, subcode) {
        (Some(Leveling::ThreePoint), 29, 0) => return measure_three_points(hands),
        (Some(Leveling::DeltaGrid), 29, 0 | 1) => return scan_delta(hands, words, subcode == 1),
        (Some(Leveling::ThreePoint), 31, 0) => return Ok(show_plane(hands)),
        (Some(Leveling::ThreePoint), 32, 0) => return level_by_three_points(hands),
        (Some(Leveling::DeltaGrid), 31, 0) => return level_by_delta_grid(hands, words),
        _ => {}
    }
    let calibrates = config.delta_calibration.enable && words.get('P') != Some(0.0);
    match (number, subcode) {
        (29, 0 | 1) if calibrates => uncompensated(hands, |hands| measure_delta(hands, words)),
        (32, 0) if calibrates => uncompensated(hands, |hands| calibrate_delta(hands, words)),
        _ => Err(hands.texts().refused(format_args!("No strategy found to handle G{number}"))),
    }
}
