//! BED_SCREWS_ADJUST: the tool goes to each screw in turn, and a person turns it until paper drags.

use base::failure::Failure;

use super::moves::go_over;
use super::state::Walk;
use crate::alignment::Corner;
use crate::leveling;
use crate::paper::PaperHands;

impl Walk {
    /// Begins with the first screw.
    ///
    /// # Errors
    /// When the machine cannot go there.
    pub fn begin<'c>(hands: &mut impl PaperHands<'c>) -> Result<Self, Failure> {
        if hands.config().bed_screws.screws.is_empty() {
            return Err(Failure::refused(
                &"BED_SCREWS_ADJUST needs to know where the screws are: write screws in [bed screws]",
            ));
        }
        // A mesh would lift the tool along with the error that the screws are to mend.
        leveling::take_off(hands)?;
        let walk = Self { screw: 0, accepted: 0 };
        walk.go(hands)?;
        Ok(walk)
    }

    /// Goes on to the next screw; `None` after the last one.
    ///
    /// # Errors
    /// When the machine cannot go there.
    pub fn next<'c>(self, hands: &mut impl PaperHands<'c>, turned: bool) -> Result<Option<Self>, Failure> {
        let count = hands.config().bed_screws.screws.len();
        let next = self.after(turned, count);
        match next {
            Some(walk) => walk.go(hands)?,
            None => hands.say(format_args!("every screw was left as it is: the bed is level\n")),
        }
        Ok(next)
    }

    fn go<'c>(self, hands: &mut impl PaperHands<'c>) -> Result<(), Failure> {
        let screws = &hands.config().bed_screws;
        let place = screws.screws.get(self.screw).copied().unwrap_or_default();
        go_over(hands, place, screws.initial_height.0, screws.paper_height.0)?;
        let (corner, number, count) = (Corner::among(place, &screws.screws), self.screw + 1, screws.screws.len());
        hands.say(format_args!(
            "Screw {number} of {count}, {corner}: does paper just drag? ACCEPT. Else turn it until it does, and say ADJUSTED\n"
        ));
        Ok(())
    }
}
