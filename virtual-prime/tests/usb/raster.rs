//! A picture for the laser, sent over USB without waiting for answers.

use usb_host::transfer::{Request, TransferId};

use super::velvet::plug;
use crate::common::MS;
use crate::common::velvet::SECOND;
use crate::laser::{Noise, fast_laser};

/// Bytes that are on their way at a time.
const AT_A_TIME: usize = 4_096;

#[test]
fn ten_thousand_pixels_a_second_burn_over_usb() {
    let noise = Noise { rows: 6, pixels: 1_200, pixel_mm: 0.05 };
    let mut plugged = plug(fast_laser());
    plugged.open(0);
    plugged.say(0, "G28.3 X10 Y0 Z0");
    plugged.velvet.world(|world| world.trace_mut().take_power());
    let job = noise.job();
    let mut pieces = job.as_bytes().chunks(AT_A_TIME);
    let serial = plugged.ports[0];
    let (mut sending, mut listening): (Option<TransferId>, Option<TransferId>) = (None, None);
    let (mut is_sent, mut answers) = (false, 0);
    let end_ms = plugged.velvet.now_ms() + 60 * SECOND;
    while answers < job.lines().count() {
        assert!(plugged.velvet.now_ms() < end_ms, "only {answers} lines were answered");
        plugged.velvet.hear_for(MS / 2);
        let mut desk = plugged.desk();
        if !is_sent && sending.is_none_or(|id| desk.ended(id).is_some()) {
            sending = pieces
                .next()
                .and_then(|piece| desk.submit(serial.output, Request::Out { data: piece.to_vec(), zero: false }));
            is_sent = sending.is_none();
        }
        let heard = listening.map_or(Some(Vec::new()), |id| desk.ended(id).map(|ended| ended.data));
        if let Some(heard) = heard {
            let heard = String::from_utf8_lossy(&heard).into_owned();
            assert!(!heard.contains("rror"), "{heard}");
            answers += heard.matches("ok").count();
            listening = serial.listen(&mut desk, 4_096);
        }
    }
    // Rows that wait.
    plugged.velvet.hear(3 * SECOND);
    plugged.assert_clean();
    noise.check(&plugged.velvet.world(|world| world.trace_mut().take_power()));
}
