//! Going on with a job on machines and with files of their own kind.

use std::collections::BTreeSet;

use units::Actuator;

use super::{CONFIG, Card, Laid, Machine, SECOND, covers, interrupted, part, part_at};

/// Z homes upwards, and the power goes again on the way there or at the end of it: it does not go up beyond
/// its switch then.
#[test]
fn a_cut_while_z_homes_upwards_is_gone_on_with() {
    let upwards = ["endstops.minz.homing_direction = home_to_max", "endstops.minz.homing_position = 150"];
    for cut_at in [20.0, 149.7] {
        let card = Card::of(CONFIG, &upwards, &part(false));
        let (mut second, _) = interrupted(&card);
        second.send("M1000");
        assert!(second.until("// homing Z, upwards"), "{}", second.said);
        while second.carriages()[2] < cut_at {
            assert!(second.step() && !second.said.contains("error"), "{}", second.said);
        }
        let mut third = Machine::start(&card, &second.carriages(), None);
        third.send("M1000");
        let mut highest = 0.0_f64;
        while !third.said.contains("the job goes on") {
            assert!(third.step() && !third.said.contains("error"), "{cut_at}: {}", third.said);
            highest = highest.max(third.carriages()[2]);
        }
        assert!(highest < 150.5, "{cut_at}: up to {highest}");
        assert!(third.until("Done printing file"), "{cut_at}: {}", third.said);
        let heights: BTreeSet<i64> = third.laid.iter().map(|[_, _, z]| (z * 100.0).round() as i64).collect();
        assert_eq!(heights, [60, 90].into(), "{cut_at}: {}", third.said);
    }
}

/// On a delta all three towers home upwards at once, and no Z is asked for.
#[test]
fn a_delta_goes_on_with_its_part() {
    let job = part_at(-45.0, false).replace("M107\n", "M107\nG4 S1\n");
    let card = Card::of(scenarios::DELTA, &[], &job);
    let mut whole = Machine::start(&card, &[], None);
    assert!(whole.print());
    let (mut second, carriages) = interrupted(&card);
    let again = Card::of(scenarios::DELTA, &[], &job);
    let mut first = Machine::start(&again, &[], None);
    first.send("play /sd/job.g");
    while !first.laid.last().is_some_and(|[_, _, z]| (0.59..0.61).contains(z)) {
        first.step();
    }
    first.run(5 * SECOND);
    assert_eq!(first.carriages(), carriages, "the same part, as far as it was made");
    second.send("M1000");
    assert!(second.until("the job goes on") && second.until("Done printing file"), "{}", second.said);
    for tower in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma] {
        assert!(second.runner.world(|world| world.lost_mm(tower)) < 1e-9, "not beyond the tower's end");
    }
    let all: Laid = first.laid.iter().chain(&second.laid).copied().collect();
    covers("missing", &whole.laid, &all);
    covers("too much", &all, &whole.laid);
}

#[test]
fn a_refused_recovery_leaves_limits_as_they_were() {
    let job = part(false).replace("; a part\n", "; a part\nM204 S1234\nM205 X0.31\n");
    let card = Card::new(&job);
    let (mut second, carriages) = interrupted(&card);
    // The offer is refused once the file has been read over.
    second.send("G91");
    second.send("G1 Z5 F600");
    second.send("G90");
    second.run(4 * SECOND);
    let mut third = Machine::start(&card, &second.carriages(), None);
    let settings = |machine: &mut Machine| {
        machine.said.clear();
        machine.send("M503");
        machine.run(SECOND);
        machine.said.clone()
    };
    let before = settings(&mut third);
    assert!(before.contains("M204 S"), "{before}");
    third.send("M1000");
    assert!(third.until("measure it, then M1000 Z"), "{}", third.said);
    assert_eq!(settings(&mut third), before);
    // And by a halt on the way.
    third.send(&format!("M1000 Z{:.3}", carriages[2] + 5.0));
    assert!(third.until(" heats to "));
    third.send("M112");
    third.run(3 * SECOND);
    third.send("M999");
    third.run(SECOND);
    assert_eq!(settings(&mut third), before);
}

/// A pause that the file has asked for is one after a power cut too, once.
#[test]
fn a_pause_that_the_file_asks_for_outlives_a_cut() {
    let mut layers = 0;
    let job: String = part(false)
        .lines()
        .map(|line| match line {
            _ if line.starts_with("G1 Z") && line != "G1 Z20 F600" => {
                layers += 1;
                let asks = if layers < 3 { "SET_PAUSE_NEXT_LAYER\n" } else { "" };
                format!(";LAYER_CHANGE\n{asks}{line}\n")
            }
            _ => format!("{line}\n"),
        })
        .collect();
    let card = Card::new(&job);
    let mut first = Machine::start(&card, &[], None);
    first.send("play /sd/job.g");
    assert!(first.until("the job pauses at layer 2: suspend h") && first.until("Print Suspended"), "{}", first.said);
    first.send("resume");
    while !first.laid.last().is_some_and(|[_, _, z]| (0.59..0.61).contains(z)) {
        first.step();
    }
    first.run(3 * SECOND);
    let mut second = Machine::start(&card, &first.carriages(), None);
    second.send("M1000");
    assert!(second.until("Print Suspended"), "{}", second.said);
    assert!(second.said.contains("pauses at layer 3") && !second.said.contains("pauses at layer 2"), "{}", second.said);
    second.send("resume");
    assert!(second.until("Done printing file"), "{}", second.said);
    assert_eq!(second.said.matches("the job pauses at").count(), 1, "{}", second.said);
}

/// Compensation for a frame that has grown counts from where Z was homed, before the cut: a bed that has
/// cooled down and is hot again is as far from the tool as before.
#[test]
fn z_by_temperature_goes_on_from_where_it_was() {
    // Here the bed's sensor is taken for one on the frame.
    let settings = ["z thermal adjust.sensor = bed", "z thermal adjust.coefficient = 0.004"];
    // The machine homes while cold.
    let job = part(false).replacen("M190 S50\nM109 S180\nG28\n", "G28\nM190 S60\nM109 S180\n", 1);
    let card = Card::of(CONFIG, &settings, &job);
    let mut first = Machine::start(&card, &[], None);
    first.send("play /sd/job.g");
    while !first.laid.last().is_some_and(|[_, _, z]| (0.42..0.46).contains(z)) {
        assert!(first.step() && !first.said.contains("Done"), "{}", first.said);
    }
    first.run(3 * SECOND);
    let made = first.carriages()[2];
    assert!((0.42..0.46).contains(&made), "0.16 below the 0.6 of the file: {made}");
    let mut second = Machine::start(&card, &first.carriages(), None);
    second.send("M1000");
    assert!(second.until("the job goes on"), "{}", second.said);
    second.run(SECOND);
    assert!((second.carriages()[2] - made).abs() < 0.015, "{made} {}", second.carriages()[2]);
    let mut highest = 0.0_f64;
    while !second.said.contains("Done printing file") {
        assert!(second.step());
        highest = second.laid.last().map_or(0.0, |[_, _, z]| highest.max(*z));
    }
    assert!((highest - (made + 0.3)).abs() < 0.015, "the next layer: {made} {highest}");
}

/// A vase rises all the time: Z is known to a fiftieth of a millimetre all the same.
#[test]
fn a_vase_is_gone_on_with_without_asking_for_z() {
    let mut job = String::from("M109 S180\nG28\nG90\nM83\nG1 X50 Y50 Z0.2 F6000\n");
    // Ten seconds and 0.2 mm a turn.
    for step in 1..=400 {
        let angle = f64::from(step) * std::f64::consts::TAU / 40.0;
        let (x, y, z) = (40.0 + 10.0 * angle.cos(), 50.0 + 10.0 * angle.sin(), 0.2 + 0.005 * f64::from(step));
        job += &format!("G1 X{x:.3} Y{y:.3} Z{z:.3} E0.05 F377\n");
    }
    for cut_s in [11, 13, 17, 22] {
        let card = Card::new(&job);
        let mut first = Machine::start(&card, &[], None);
        first.send("play /sd/job.g");
        while first.laid.is_empty() {
            first.step();
        }
        first.run(cut_s * SECOND);
        let z = first.carriages()[2];
        assert!(z > 0.3, "{z}");
        let mut second = Machine::start(&card, &first.carriages(), None);
        second.send("M1000");
        assert!(second.until("// homing X and Y"), "{cut_s}: {}", second.said);
        let believed = second.runner.motion(|motion| motion.live_position())[units::Axis::Z];
        let off = believed - second.carriages()[2];
        assert!(off.abs() < 0.022, "{cut_s}: {off}");
        assert!(second.until("the job goes on"), "{cut_s}: {}", second.said);
    }
}
