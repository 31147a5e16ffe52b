//! Cables that go out in the middle of a line: what was answered is done, what was not whole is not.

use virtual_prime::net_desk::peer::Connection;

use super::{Net, plan};
use crate::common::velvet::SECOND;

/// Length of each whole line's move, micrometres, and of the line that is cut off, which would be seen.
const STEP_UM: i64 = 10;
const WHOLE: &str = "G1 X0.01 F3000\n";
const CUT: &str = "G1 X5";
/// Lines of a round.
const LINES: usize = 20;

/// Returns the position of X in micrometres, as M114 says it.
fn position_um(net: &mut Net) -> i64 {
    let before = net.velvet.said().len();
    net.velvet.type_in("M114");
    net.hear_until(" E:", 5 * SECOND);
    let said = &net.velvet.said()[before..];
    let at = said.find(" X:").expect("a position of X");
    let digits: String = said[at + 3..].chars().take_while(|c| "-.0123456789".contains(*c)).collect();
    (digits.parse::<f64>().expect("a number") * 1e3).round() as i64
}

/// Sends lines, and half a line behind them, and pulls the cable out so many rounds of the computer later.
/// Returns how many lines were answered.
fn cut_off(net: &mut Net, visitor: Connection, after_ms: u64) -> i64 {
    net.send(visitor, WHOLE.repeat(LINES).as_bytes());
    net.send(visitor, CUT.as_bytes());
    net.run(after_ms);
    let heard = String::from_utf8_lossy(&net.peer.receive(visitor)).into_owned();
    net.peer.unplug(&mut net.velvet.bench.vm);
    assert!(!heard.contains("rror"), "{heard}");
    heard.matches("ok\n").count() as i64
}

/// Has the cable out so many times, each time at another byte.
fn pull_out(times: u64) {
    let mut net = Net::with_address(plan(&["[network] password_required = false"]));
    net.ask("G28.3 X10 Y10 Z10");
    net.ask("G91");
    let mut at_um = position_um(&mut net);
    let (mut before_the_end, mut answered_all) = (0, 0);
    for turn in 0..times {
        let visitor = net.connect(23);
        net.expect(visitor, "Welcome to Smoothie\nok\n", 2 * SECOND);
        let answered = cut_off(&mut net, visitor, turn * 7 % 20);
        net.run(60 + turn % 5 * 30);
        net.peer.plug(&mut net.velvet.bench.vm);
        net.hear_until("// network: 10.0.2.15 (from DHCP)", 15 * SECOND);
        net.peer.forget(visitor);
        let moved = position_um(&mut net) - at_um;
        at_um += moved;
        let sent = STEP_UM * LINES as i64;
        assert!(
            (STEP_UM * answered..=sent).contains(&moved),
            "{answered} lines were answered, and it moved {moved} um"
        );
        before_the_end += u32::from(moved < sent);
        answered_all += u32::from(answered == LINES as i64);
    }
    assert!(before_the_end > 0 && answered_all < times as u32, "the cable is out too late for this test");
    assert!(net.ask("net").contains("Telnet: port 23, 0 connected"), "a console is kept");
    let visitors = [net.connect(23), net.connect(23)];
    for visitor in visitors {
        net.expect(visitor, "Welcome to Smoothie\nok\n", 2 * SECOND);
        net.say(visitor, "M105", "T:");
    }
}

#[test]
fn a_cable_that_is_pulled_out_cuts_off_no_line_that_was_answered() {
    pull_out(3);
}

#[test]
#[ignore = "half an hour: make net"]
fn it_does_so_200_times() {
    pull_out(200);
}
