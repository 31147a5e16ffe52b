//! G28 and `$H`: homing, or the script of the configuration that stands for it.

use base::failure::{Answer, Outcome};
use base::sessions::Recipient;
use units::AxisSet;

use crate::machine::frames::Then;
use crate::machine::suspend;
use crate::machine::work_hands::JobHands;

/// Homes these axes, or all where none is named.
pub(crate) fn home<'c>(hands: &mut impl JobHands<'c>, named: AxisSet, to: Recipient) -> Outcome {
    let script = hands.world().config.homing.gcode.as_str();
    // Within the script G28 is homing itself.
    if named.is_empty() && !script.is_empty() && !hands.frames().run_script(script) {
        return suspend::start_script(hands.frames(), script, Then::Ended(Ok(())));
    }
    let homed = procedures::homing::home(&mut hands.sequence(to), named);
    hands.resynchronise_if_still();
    homed.map(|()| Answer::Ok)
}
