//! Consoles over the network: whom they let in, what they answer.

use super::{Net, plan};
use crate::common::velvet::SECOND;

const OPEN: &str = "[network] password_required = false";

#[test]
fn a_console_without_a_password_has_the_machine_work_and_no_more() {
    let mut net = Net::with_address(plan(&[OPEN]));
    let far = net.connect(23);
    net.expect(far, "Welcome to Smoothie\nok\n", 2 * SECOND);
    let said = net.say(far, "M105", "ok");
    assert!(said.contains("T:"), "{said}");
    net.say(far, "?", "<Idle|");
    net.say(far, "rm a.g", "error:this is for who has the machine's password");
    net.say(far, "M104 S50", "ok\n");
    assert!(net.ask("net").contains("Telnet: port 23, 1 connected\n"));
    // A half line goes with its sender, and the next visitor is greeted.
    net.send(far, b"G1 X1");
    net.run(50);
    net.peer.close(far);
    net.run(500);
    let next = net.connect(23);
    net.expect(next, "Welcome to Smoothie\nok\n", 2 * SECOND);
    net.say(next, "M114", "ok");
}

#[test]
fn a_password_lets_the_owner_in_and_nobody_else() {
    let mut net = Net::with_address(plan(&[]));
    let far = net.connect(23);
    net.expect(far, "No password is set", 2 * SECOND);
    net.ask("password correct-horse");
    let far = net.connect(23);
    net.expect(far, "Password: ", 2 * SECOND);
    net.say(far, "wrong-horse", "Wrong password.");
    net.run(100);
    assert!(net.velvet.said().contains("// network: a wrong password came from 10.0.2.2\n"), "{}", net.velvet.said());
    net.say(far, "correct-horse", "Welcome to Smoothie\nok\n");
    net.say(far, "mkdir folder", "ok\n");
    net.say(far, "ls", "folder");
}

#[test]
fn senders_speak_grbls_dialect_at_a_port_of_their_own() {
    let mut net = Net::with_address(plan(&[OPEN, "[network] grbl_enable = true"]));
    let far = net.connect(2323);
    net.expect(far, "Grbl 1.1f ['$' for help]", 2 * SECOND);
    net.say(far, "$I", ",1023]");
    net.send(far, b"?");
    net.expect(far, "<Idle|", SECOND);
    net.say(far, "G99999", "error:");
}

/// A stop acts although the lines before it fill the look-ahead queue and the inbox, and wait with TCP.
#[test]
fn a_stop_overtakes_the_lines_that_wait() {
    let mut net = Net::with_address(plan(&[OPEN]));
    let far = net.connect(23);
    net.expect(far, "ok\n", 2 * SECOND);
    net.say(far, "G28.3 X10 Y10 Z10", "ok\n");
    let lines: String = (0..150).map(|line| format!("G1 X{} F60\n", 10.0 + f64::from(line % 2) * 5.0)).collect();
    net.send(far, lines.as_bytes());
    net.run(2 * SECOND);
    net.send(far, b"!");
    net.run(200);
    net.send(far, b"?");
    net.expect(far, "<Hold|", SECOND);
}
