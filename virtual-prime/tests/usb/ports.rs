//! The machine's consoles at the USB socket.

use usb_host::transfer::{Outcome, Request};
use virtual_prime::factory::UNIQUE_ID;
use virtual_prime::sd_image;
use virtual_prime::usb_desk::cdc::LineCoding;

use super::velvet::{GREETING, plug, two_ports};
use crate::common::MS;
use crate::common::velvet::Plan;

#[test]
fn the_machine_enumerates_under_its_names() {
    let mut plugged = plug(two_ports());
    let descriptor = plugged.device.descriptor.clone();
    assert_eq!((descriptor.vendor, descriptor.product), (0x1D50, 0x6015));
    let [manufacturer, product, serial] = plugged.device.strings.clone().map(Option::unwrap);
    assert_eq!((manufacturer.as_str(), product.as_str()), ("Velvet", "Smoothieboard v2 Prime"));
    assert_eq!(serial, UNIQUE_ID.map(|word| format!("{word:08X}")).concat());
    assert_eq!(plugged.ports.len(), 2);
    plugged.assert_clean();
}

/// The second port exists only with `second_usb_serial_enable`.
#[test]
fn without_the_setting_there_is_one_port() {
    let mut plugged = plug(Plan::new());
    assert_eq!(plugged.ports.len(), 1);
    plugged.open(0);
    assert!(plugged.say(0, "M105").starts_with("ok "));
    plugged.assert_clean();
}

#[test]
fn both_ports_are_consoles_of_their_own() {
    let mut plugged = plug(two_ports());
    plugged.open(0);
    plugged.open(1);
    plugged.say(0, "G91");
    assert!(plugged.say(1, "M114").contains("X:0.0000"));
    plugged.say(0, "G1 X5 F6000");
    plugged.say(1, "M400");
    assert!(plugged.say(1, "M114").contains("X:5.0000"));
    let line = LineCoding { rate: 250_000, stop: 2, parity: 1, bits: 7 };
    let port = plugged.ports[0];
    let mut desk = plugged.desk();
    port.set_line_coding(&mut desk, line).unwrap();
    assert_eq!(port.line_coding(&mut desk), Ok(line));
    assert_eq!(port.serial_state(&mut desk), Ok(3));
    plugged.assert_clean();
}

#[test]
fn a_full_inbox_holds_the_computer_back_and_nothing_else() {
    let mut plugged = plug(two_ports());
    plugged.open(0);
    plugged.open(1);
    // The line takes two seconds, and far more lines follow than there is room for.
    let lines = "G4 P2000\n".to_owned() + &"G91\n".repeat(3_000);
    plugged.send(0, lines.as_bytes());
    let mut answers = String::new();
    plugged.desk().pass_ms(500).unwrap();
    // The other port and endpoint 0 go on.
    assert!(plugged.say(1, "M105").starts_with("ok "));
    assert_eq!(plugged.desk().descriptor(1, 0, 18).unwrap().len(), 18);
    while answers.matches("ok\n").count() < 3_001 {
        answers += &plugged.hear_until(0, "ok\n");
    }
    assert_eq!(answers.replace("ok\n", ""), "", "and no line was lost");
    plugged.assert_clean();
}

#[test]
fn a_computer_that_does_not_read_holds_its_own_lines_alone() {
    let mut plugged = plug(two_ports());
    plugged.open(0);
    plugged.open(1);
    // The answers are more than fits between the machine and the computer.
    let lines = "help\n".repeat(30) + "G91\nG1 X3 F6000\n";
    plugged.send(0, lines.as_bytes());
    plugged.desk().pass_ms(5_000).unwrap();
    let place = plugged.say(1, "M114");
    assert!(place.contains("X:0.0000"), "it waits for its answers to be read: {place}");
    let mut said = String::new();
    while said.lines().filter(|line| *line == "ok").count() < 32 {
        said += &plugged.hear_until(0, "ok\n");
    }
    assert_eq!(said.matches("$SLP").count(), 30, "nothing of the answers is missing");
    plugged.say(1, "M400");
    assert!(plugged.say(1, "M114").contains("X:3.0000"));
    plugged.assert_clean();
}

#[test]
fn the_cable_may_be_pulled_out_at_any_moment() {
    let mut plugged = plug(two_ports());
    for moment in 0..12_u64 {
        plugged.open(0);
        plugged.send(0, b"G91\nG1 X1 F6000\nG1 X-1\nM105\n");
        let mut desk = plugged.desk();
        desk.pass(moment * 700_000).unwrap();
        desk.unplug();
        desk.pass_ms(40 + moment).unwrap();
        desk.plug();
        desk.enumerate().unwrap();
    }
    plugged.open(0);
    plugged.say(0, "M400");
    assert!(plugged.say(0, "M114").contains("X:0.0000"), "each pair of moves was made whole, or not at all");
    plugged.assert_clean();
}

#[test]
fn a_sleeping_computer_is_greeted_when_it_wakes() {
    let mut plugged = plug(Plan::new());
    plugged.open(0);
    let mut desk = plugged.desk();
    desk.suspend();
    desk.pass_ms(500).unwrap();
    desk.resume().unwrap();
    assert_eq!(plugged.hear_until(0, "ok\n"), GREETING);
    assert!(plugged.say(0, "M105").starts_with("ok "));
    plugged.assert_clean();
}

#[test]
fn a_computer_that_falls_asleep_in_the_middle_of_a_line_has_that_line_refused() {
    let mut plugged = plug(Plan::new());
    plugged.open(0);
    plugged.say(0, "G91");
    let port = plugged.ports[0];
    port.write(&mut plugged.desk(), b"G1 X1 F6000\nG1 Y").unwrap();
    let mut desk = plugged.desk();
    desk.pass_ms(5).unwrap();
    desk.suspend();
    desk.pass_ms(200).unwrap();
    desk.resume().unwrap();
    port.write(&mut desk, b"10 X2\nG1 X4\n").unwrap();
    // The first answer had left for the controller before the bus fell silent.
    let mut heard = plugged.hear_until(0, "more\n");
    if !heard.ends_with("ok\n") {
        heard += &plugged.hear_until(0, "ok\n");
    }
    assert_eq!(heard, format!("ok\n{GREETING}error:line lost, wait for ok before sending more\nok\n"));
    plugged.say(0, "M400");
    assert!(plugged.say(0, "M114").contains("X:5.0000 Y:0.0000"), "the half line has moved nothing");
}

#[test]
fn a_file_comes_while_the_machine_moves() {
    let mut plugged = plug(Plan::new());
    plugged.open(0);
    plugged.say(0, "G91");
    (0..20).for_each(|_| {
        plugged.say(0, "G1 X20 F9000");
        plugged.say(0, "G1 X-20");
    });
    let bytes: Vec<u8> = (0..200_000_u32).map(|at| (at * 31 >> 3) as u8).collect();
    let port = plugged.ports[0];
    port.write(&mut plugged.desk(), format!("dl a.bin {}\n", bytes.len()).as_bytes()).unwrap();
    plugged.hear_until(0, "READY");
    let began = plugged.velvet.bench.vm.now_ns();
    let id = plugged.desk().submit(port.output, Request::Out { data: bytes.clone(), zero: false });
    let ended = plugged.desk().wait(id).unwrap();
    assert_eq!(ended.outcome, Outcome::Done);
    let took_ms = (plugged.velvet.bench.vm.now_ns() - began) / MS;
    assert!(plugged.hear_until(0, "ok\n").contains("SUCCESS"));
    // The rate is that of the card, which takes a block at a time.
    let rate = bytes.len() as u64 / took_ms.max(1);
    println!("{rate} kB/s to the card");
    assert!(rate >= 200, "{rate} kB/s");
    plugged.assert_clean();
}

/// After SUCCESS the file is on the card, even if the card or the plug is pulled out at once.
#[test]
fn what_has_been_sent_is_on_the_card_when_that_is_said() {
    let mut plugged = plug(Plan::new());
    plugged.open(0);
    for every in [2, 3] {
        plugged.velvet.bench.vm.with(move |stopped| {
            let card = stopped.session.board_mut().mcu.sdmmc.card_mut().expect("a card in the slot");
            card.trouble().slow_writes = (250 * MS, every);
        });
        let bytes: Vec<u8> = (0..3_000_u32).map(|at| (at * 31 >> 3) as u8).collect();
        let port = plugged.ports[0];
        port.write(&mut plugged.desk(), format!("dl a{every}.bin {}\n", bytes.len()).as_bytes()).unwrap();
        plugged.hear_until(0, "READY");
        plugged.send(0, &bytes);
        assert!(plugged.hear_until(0, "ok\n").contains("SUCCESS"));
        let content = plugged.velvet.bench.vm.with(|stopped| {
            let card = stopped.session.board().mcu.sdmmc.card();
            card.map(|card| card.content().to_vec())
        });
        let content = content.flatten().expect("a card in the slot");
        assert_eq!(sd_image::read(&content, &format!("a{every}.bin")), Ok(bytes), "every {every}");
    }
    plugged.assert_clean();
}
