//! Jobs that go on after a power cut: the journal of a job, and the way back from it.

pub(crate) mod job_recovery;
pub(crate) mod journal;
pub(crate) mod standing;

use base::sessions::Recipient;
use units::Micros;

use self::job_recovery::RecoveryHands;
use self::journal::JournalHands;
use crate::machine::moments::{JobBegins, Moments};

/// The journal and the way back from it, at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: JournalHands<'c> + RecoveryHands<'c>> Moments<M> for Feature {
    fn started(hands: &mut M, is_usable: bool) {
        if is_usable {
            job_recovery::say_offer(hands);
        }
    }

    fn each_10_ms(hands: &mut M, now: Micros) {
        journal::tick(&mut hands.noted(), now);
    }

    fn session_line_begins(hands: &mut M) {
        journal::before_session(hands.beside());
    }

    fn session_line_ends(hands: &mut M) {
        journal::after_session(hands.beside());
    }

    fn job_begins(hands: &mut M, from: JobBegins) {
        match from {
            JobBegins::Whole => journal::begin(hands),
            // A journal that began in the middle of the file would lead nowhere.
            JobBegins::FurtherOn | JobBegins::Again => {}
            JobBegins::Elsewhere => journal::give_up_offer(&mut hands.noted()),
        }
    }

    fn job_is_unreadable(hands: &mut M) {
        hands.journal().0.lose();
    }

    fn job_ends(hands: &mut M, _is_done: bool, _to: Recipient) {
        let (journal, world) = hands.journal();
        journal.end(&mut world.ports);
    }

    fn leaves_for_heights(hands: &mut M, heights: [f64; 2]) {
        journal::leaves_height(&mut hands.noted(), heights);
    }

    fn keeps_thermal_z(hands: &M) -> bool {
        hands.comes_back()
    }

    fn objects_change(hands: &mut M) {
        journal::objects_change(&mut hands.noted());
    }

    fn job_is_dropped(hands: &mut M) {
        journal::halts(&mut hands.noted());
    }

    fn rests(hands: &mut M) {
        journal::stands(&mut hands.noted());
        hands.put_back();
    }

    fn work_was_ended(hands: &mut M) {
        if hands.comes_back() {
            job_recovery::give_up(hands);
        }
    }
}
