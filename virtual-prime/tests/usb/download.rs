//! The way into the firmware download: a computer's DFU_DETACH, and the command `dfu`.

use usb_host::controller::Port;
use virtual_prime::usb_desk::dfu::{Dfu, state};

use super::velvet::{Plugged, plug};
use crate::common::velvet::{Plan, SECOND};

const LEAVES: &str = "the board waits for firmware over USB in a second; RESET starts this one again";
/// Time in which the running firmware is copied to the card.
const COPY_MS: u64 = 60 * SECOND;

fn with_download() -> Plan {
    Plan::new().set("[system] dfu_enable = true")
}

/// Asserts that the board leaves the bus, and is reset.
#[track_caller]
fn assert_leaves(plugged: &mut Plugged) {
    let is_gone = |port| matches!(port, Port::Unplugged | Port::Empty);
    plugged.desk().wait_for_port(is_gone, 2 * SECOND).expect("it leaves the bus");
}

/// The interface exists only with `dfu_enable`.
#[test]
fn a_computer_may_have_the_machine_leave_for_the_download() {
    assert!(Dfu::of(&plug(Plan::new()).device).is_none());
    let mut plugged = plug(with_download());
    let dfu = Dfu::of(&plugged.device).expect("an interface for it");
    assert_eq!((dfu.protocol, dfu.functional.attributes, dfu.functional.version), (1, 0b1011, 0x0110));
    assert_eq!(dfu.state(&mut plugged.desk()), Ok(state::APP_IDLE));
    dfu.detach(&mut plugged.desk(), 1_000).unwrap();
    assert_eq!(dfu.state(&mut plugged.desk()), Ok(state::APP_DETACH));
    let asked_ms = plugged.velvet.now_ms();
    plugged.velvet.hear_until(LEAVES, COPY_MS);
    println!("kept on the card after {} ms", plugged.velvet.now_ms() - asked_ms);
    assert_leaves(&mut plugged);
}

#[test]
fn a_machine_that_works_is_not_left() {
    let mut plugged = plug(with_download().file("long.g", &"G4 P100\n".repeat(40)));
    let dfu = Dfu::of(&plugged.device).expect("an interface for it");
    let works = [
        ("G91\nG1 X20 F600", "M400", None),
        ("M104 S60", "M104 S0", Some("a heater is on: switch heaters off first")),
        ("play long.g", "abort", Some("a job is under way: abort it first")),
    ];
    for (begin, end, why) in works {
        begin.lines().for_each(|line| drop(plugged.velvet.ask(line, SECOND)));
        plugged.velvet.hear(200);
        let refused = dfu.detach(&mut plugged.desk(), 1_000);
        assert!(refused.is_err_and(|error| error.is_stall()), "{begin}");
        assert_eq!(dfu.state(&mut plugged.desk()), Ok(state::APP_IDLE));
        // The command waits for a move's end.
        if let Some(why) = why {
            let said = plugged.velvet.ask("dfu", SECOND);
            assert!(said.contains(why), "{begin}: {said}");
        }
        plugged.velvet.ask(end, 4 * SECOND);
        plugged.velvet.hear(SECOND);
    }
    plugged.velvet.type_in("dfu");
    plugged.velvet.hear_until(LEAVES, COPY_MS);
    assert_leaves(&mut plugged);
}
