//! The way into the firmware download: a computer's DFU_DETACH, and the command `dfu`.

use virtual_prime::usb_host::controller::Port;
use virtual_prime::usb_host::dfu::{Dfu, state};

use super::velvet::{Plugged, plug};
use crate::common::velvet::{Plan, SECOND};

const WORKS: &str = "the machine moves, heats or plays a file: end that first";

fn with_download() -> Plan {
    Plan::new().set("[system] dfu_enable = true")
}

/// The board leaves the bus: it is reset.
#[track_caller]
fn assert_leaves(plugged: &mut Plugged) {
    let is_gone = |port| matches!(port, Port::Unplugged | Port::Empty);
    plugged.desk().wait_for_port(is_gone, 2 * SECOND).expect("it leaves the bus");
}

/// `dfu_enable` is what makes the interface.
#[test]
fn a_computer_may_have_the_machine_leave_for_the_download() {
    assert!(Dfu::of(&plug(Plan::new()).device).is_none());
    let mut plugged = plug(with_download());
    let dfu = Dfu::of(&plugged.device).expect("an interface for it");
    assert_eq!((dfu.protocol, dfu.functional.attributes, dfu.functional.version), (1, 0b1011, 0x0110));
    assert_eq!(dfu.state(&mut plugged.desk()), Ok(state::APP_IDLE));
    dfu.detach(&mut plugged.desk(), 1_000).unwrap();
    assert_eq!(dfu.state(&mut plugged.desk()), Ok(state::APP_DETACH));
    plugged.velvet.hear_until("// NOTICE a computer asks for the firmware download", SECOND);
    assert_leaves(&mut plugged);
}

#[test]
fn a_machine_that_works_is_not_left() {
    let mut plugged = plug(with_download().file("long.g", &"G4 P100\n".repeat(40)));
    let dfu = Dfu::of(&plugged.device).expect("an interface for it");
    for (begin, end) in [("G91\nG1 X20 F600", "M400"), ("M104 S60", "M104 S0"), ("play long.g", "abort")] {
        begin.lines().for_each(|line| drop(plugged.velvet.ask(line, SECOND)));
        plugged.velvet.hear(200);
        let refused = dfu.detach(&mut plugged.desk(), 1_000);
        assert!(refused.is_err_and(|error| error.is_stall()), "{begin}");
        assert_eq!(dfu.state(&mut plugged.desk()), Ok(state::APP_IDLE));
        if begin != "G91\nG1 X20 F600" {
            let said = plugged.velvet.ask("dfu", SECOND);
            assert!(said.contains(WORKS), "{begin}: {said}");
        }
        plugged.velvet.ask(end, 4 * SECOND);
        plugged.velvet.hear(SECOND);
    }
    let said = plugged.velvet.ask("dfu", SECOND);
    assert!(said.contains("NOTE: A reset will be required to resume if dfu-util is not run"), "{said}");
    assert_leaves(&mut plugged);
}
