//! The safety door: an open one holds whatever moves, and is no halt.

use scenarios::{CARTESIAN, Plan};

use crate::operation::press;

/// An open door interrupts what moves, keeps it so, and is no halt.
#[test]
fn an_open_door_holds_until_it_is_closed_and_somebody_says_so() {
    let door = "\n[safety door]\nenable = true\npin = PB7^\n";
    let mut bench = Plan::new(CARTESIAN).adding(door).start();
    bench.run(&["M104 S60"]);
    bench.type_in("G1 X50 F600\n");
    bench.hear(0.5);
    press(&mut bench, "door", true);
    let said = bench.hear(0.5);
    assert_eq!(said.matches("// NOTE the door is open: close it, then ~ goes on").count(), 1, "{said}");
    assert!(bench.status().starts_with("<Door|"), "{}", bench.status());
    let place = bench.world(|world| world.carriage_mm(units::Actuator::Alpha));
    for _ in 0..2 {
        bench.type_in("~");
        let said = bench.hear(0.3);
        assert!(said.contains("the door is still open"), "{said}");
    }
    assert!(bench.heats(), "a heater is no business of the door's");
    press(&mut bench, "door", false);
    bench.hear(1.0);
    assert!(bench.status().starts_with("<Door|"), "{}", bench.status());
    assert_eq!(bench.world(|world| world.carriage_mm(units::Actuator::Alpha)), place, "it waits for somebody");
    bench.type_in("~");
    bench.hear(6.0);
    let x = bench.world(|world| world.carriage_mm(units::Actuator::Alpha)).expect("a motor");
    // X stands at 30 mm at power-on.
    assert!((x - 80.0).abs() < 1e-6, "{x}");
    // Opened while nothing moves, and while it is halted.
    press(&mut bench, "door", true);
    bench.hear(0.2);
    assert!(bench.status().starts_with("<Door|"), "{}", bench.status());
    bench.say("M112");
    bench.say("M999");
    bench.hear(0.2);
    assert!(bench.status().starts_with("<Door|"), "{}", bench.status());
}

#[test]
fn senders_of_grbl_see_the_open_door() {
    let door = "\n[safety door]\nenable = true\npin = PB7^\n";
    let mut bench = Plan::new(CARTESIAN).set("[general] grbl_mode = true").adding(door).start();
    for (open, state) in [(true, "<Door:1|"), (false, "<Door:0|")] {
        press(&mut bench, "door", open);
        bench.hear(0.2);
        let status = bench.status();
        assert!(status.starts_with(state) && status.contains("|Pn:D"), "{status}");
    }
}
