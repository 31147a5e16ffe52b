//! `Z_OFFSET_APPLY_ENDSTOP` and `Z_OFFSET_APPLY_PROBE`: the shift of Z goes into where Z homes.

use core::fmt::Write as _;

use base::World;
use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands as _;
use base::sessions::Recipient;
use heapless::String;
use printer_cfg::Section;
use procedures::arms::homes_by_motor;
use units::Axis;

use super::calls::{self, Shares};
use super::hands::MacroHands;

/// Takes the shift into the probe's offset, or into the correction of the homing position. Nothing moves, and
/// the program's coordinates stay: where the changed offset is what Z homes by, the machine reads at once as
/// it will after homing, and the shift ends.
pub(super) fn apply<'c>(hands: &mut impl MacroHands<'c>, to_probe: bool, to: Recipient) -> Outcome {
    let [.., shift] = hands.program().modal().shift;
    if shift == 0.0 {
        hands.say(to, format_args!("Z is not shifted: nothing is to be done\n"));
        return Ok(Answer::Ok);
    }
    if hands.jobs().is_open() || hands.jobs().is_suspended() {
        return Err(Failure::refused(&"a job goes by the shift: when it has ended"));
    }
    let World { config, .. } = hands.world();
    let has_switch = config.homing_endstop(Axis::Z).is_some() || homes_by_motor(config);
    if to_probe && !config.probe.enable {
        return Err(Failure::refused(&"no probe is configured: [zprobe] enable"));
    }
    if !to_probe && !has_switch {
        return Err(Failure::refused(&"Z has no switch to home with: Z_OFFSET_APPLY_PROBE"));
    }
    hands.standstill()?;
    let mut lines = String::<128>::new();
    // Heights of a machine leave room.
    let _ = match to_probe {
        true => {
            let [.., height] = hands.sequence(to).bed().probe_offsets;
            writeln!(lines, "M565 Z{:.5}", height - shift)
        }
        false => writeln!(lines, "M206 Z{:.5}", hands.tuning().home_offset()[Axis::Z] - shift),
    };
    if to_probe != has_switch {
        let reads = hands.position()[Axis::Z] - shift;
        let _ = writeln!(lines, "G92.4 Z{reads:.5}\nM290 R0 Q0 Z0");
    }
    hands.say(to, format_args!("// Z's shift of {shift:.3} is in the offset: M500 saves it\n"));
    calls::run_text(hands, Section(u16::MAX), [&lines, ""], to, Shares::No)
}
