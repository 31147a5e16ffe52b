//! Jobs that get over stalls of motors. Motors of the sample: a full step of 0.2 mm.

use scenarios::{Bench, CARTESIAN, COREXY, Plan};
use units::Actuator::{Alpha, Beta, Delta, Gamma};

const FREE: [f64; 2] = [-3.0, 205.0];
/// Nothing of the part lies beyond a bead's width of where it belongs, mm.
const BEAD: f64 = 0.4;

/// Four layers of a square of 100 mm, at 60 mm/s: long enough at one speed for a stall to be seen.
fn part(modes: &str) -> String {
    let relative = modes.contains("M83");
    let mut text = format!("M190 S50\nM109 S180\nG28\nG90\nG21\nM82\n{modes}G92 E0\n");
    let mut e = 0.0;
    for layer in 1..=4 {
        text += &format!("G1 Z{:.2} F600\nG0 X30 Y30 F9000\n", 0.3 * f64::from(layer));
        for (x, y) in [(130, 30), (130, 130), (30, 130), (30, 30)] {
            e += 4.0;
            let push = if relative { 4.0 } else { e };
            text += &format!("G1 X{x} Y{y} E{push:.3} F3600\n");
        }
    }
    text + "M104 S0\nM140 S0\nG1 Z20 F600\nG0 X10 Y10 F9000\n"
}

fn plan(base: &str, what: &str, modes: &str) -> Plan {
    let plan = Plan::new(base).file("job.g", &part(modes));
    ["alpha", "beta"].into_iter().fold(plan, |plan, motor| {
        plan.set(&format!("[tmc2590] {motor}.stall_watch = true"))
            .set(&format!("[tmc2590] {motor}.stall_threshold = 2"))
            .set(&format!("[tmc2590] {motor}.stall_filter = false"))
            .set(&format!("[actuator] {motor}.on_stall = {what}"))
    })
}

fn until(bench: &mut Bench, said: &mut String, is_there: impl Fn(&Bench) -> bool) {
    let end = bench.now_s() + 900.0;
    while !is_there(bench) {
        assert!(bench.now_s() < end, "it does not come there: {said}");
        *said += &bench.hear(0.002);
    }
}

/// Returns the job in its third layer, X on its way out at 60 mm/s.
fn printing(plan: Plan) -> (Bench, String) {
    let mut bench = plan.start();
    bench.type_in("play /sd/job.g -t\n");
    let mut said = String::new();
    until(&mut bench, &mut said, |bench| bench.carriage(Gamma) > 0.89 && bench.carriage(Delta) > 32.5);
    until(&mut bench, &mut said, |bench| (50.0..90.0).contains(&bench.carriage(Alpha)));
    (bench, said)
}

/// Something stands in the way of X, until its motor is seen to stall.
fn blow(bench: &mut Bench, said: &mut String) {
    let here = bench.carriage(Alpha);
    bench.world(|world| world.obstruct(Alpha, [-3.0, here + 5.0]));
    *said += &bench.hear_until("motor X stalls", 3.0);
    bench.world(|world| world.obstruct(Alpha, FREE));
}

/// Returns the places of the tool while the part is printed, each quarter of a millimetre, until the job is
/// over.
fn traced(bench: &mut Bench, said: &mut String) -> Vec<[f64; 4]> {
    let (mut all, end, pauses) = (Vec::new(), bench.now_s() + 300.0, said.matches("paused").count());
    while !said.contains("Done printing") {
        assert!(bench.now_s() < end && said.matches("paused").count() == pauses, "{said}");
        *said += &bench.hear(0.004);
        all.push([Alpha, Beta, Gamma, Delta].map(|motor| bench.carriage(motor)));
    }
    all
}

/// Returns the distance of a place from the square.
fn off([x, y, ..]: [f64; 4]) -> f64 {
    let (dx, dy) = ((x - 80.0).abs(), (y - 80.0).abs());
    (dx.max(dy) - 50.0).abs()
}

/// Returns the printed places: those at a height of the part where filament is pushed.
fn printed(trace: &[[f64; 4]]) -> impl Iterator<Item = [f64; 4]> {
    let lays = |pair: &[[f64; 4]]| {
        let [before, now] = [pair[0], pair[1]];
        now[3] > before[3] + 1e-4 && now[2] < 1.3
    };
    trace.windows(2).filter(move |pair| lays(pair)).map(|pair| pair[1])
}

/// `cargo test -p machine stalls::recovery:: -- --nocapture` prints the figures.
#[test]
fn after_a_blow_the_part_goes_on_where_it_was() {
    for modes in ["", "M83\n"] {
        let (mut bench, mut said) = printing(plan(CARTESIAN, "recover", modes));
        blow(&mut bench, &mut said);
        let hit = bench.now_s();
        said += &bench.hear_until("Resuming print", 120.0);
        let (back, seam) = (bench.now_s() - hit, bench.carriage(Alpha));
        assert!(said.contains("homing what has lost its place"), "{said}");
        assert!((bench.carriage(Beta) - 30.0).abs() < 0.01 && (bench.carriage(Gamma) - 0.9).abs() < 0.01, "{said}");
        let trace = traced(&mut bench, &mut said);
        let worst = printed(&trace).map(off).fold(0.0, f64::max);
        println!(
            "after a blow it goes on {back:.1} s later at X {seam:.2}, and no place of the part is off by more than {worst:.3} mm"
        );
        assert!(worst < BEAD, "{worst}");
        // Nothing is pushed twice, and nothing is missing: sixteen sides of 4 mm of filament.
        let pushed = bench.carriage(Delta);
        assert!((pushed - 64.0).abs() < 0.3, "{pushed}: {said}");
        // Nor is a side left out behind the seam.
        let reached = printed(&trace).map(|place| place[0]).fold(0.0, f64::max);
        assert!((reached - 130.0).abs() < 0.1, "{reached}");
        assert_eq!(bench.say("G28.6"), "X:1 Y:1 Z:1 \nok\n");
    }
}

#[test]
fn a_curve_is_made_again_from_its_beginning() {
    let text = part("").replace("G1 X130 Y30 E36.000", "G2 X130 Y30 I50 J50 E36.000");
    assert!(text.contains("G2"));
    let (mut bench, mut said) = printing(plan(CARTESIAN, "recover", "").file("job.g", &text));
    blow(&mut bench, &mut said);
    said += &bench.hear_until("Resuming print", 120.0);
    assert!((bench.carriage(Alpha) - 30.0).abs() < 0.01 && (bench.carriage(Beta) - 30.0).abs() < 0.01, "{said}");
    let trace = traced(&mut bench, &mut said);
    let arc = |[x, y, ..]: [f64; 4]| ((x - 80.0).hypot(y - 80.0) - 50.0_f64.hypot(50.0)).abs();
    assert!(printed(&trace).map(|place| off(place).min(arc(place))).fold(0.0, f64::max) < BEAD);
    assert!(printed(&trace).any(|[x, ..]| x > 150.0), "it comes to the far side");
}

#[test]
fn a_blockage_that_stays_pauses_and_heaters_are_as_in_suspend() {
    let (mut bench, mut said) = printing(plan(CARTESIAN, "recover", ""));
    bench.world(|world| world.obstruct(Alpha, [-3.0, 100.0]));
    said += &bench.hear_until("the job is paused", 600.0);
    assert_eq!(said.matches("the job stops").count(), 4, "{said}");
    assert!(said.contains("3 stalls within 10 minutes are enough"), "{said}");
    said += &bench.hear(1.0);
    assert!(!bench.heats() && bench.carriage(Gamma) > 5.0, "cold and clear of the part: {said}");
    assert!(bench.say("get mode").contains("suspended"));
    // The obstacle is taken away.
    bench.world(|world| world.obstruct(Alpha, FREE));
    bench.type_in("resume\n");
    said += &bench.hear_until("Resuming print", 600.0);
    let trace = traced(&mut bench, &mut said);
    let worst = printed(&trace).map(off).fold(0.0, f64::max);
    assert!(worst < BEAD, "{worst}");
}

#[test]
fn what_blocks_homing_too_pauses() {
    let (mut bench, mut said) = printing(plan(CARTESIAN, "recover", ""));
    let here = bench.carriage(Alpha);
    bench.world(|world| world.obstruct(Alpha, [here - 30.0, here + 5.0]));
    said += &bench.hear_until("the job is paused", 600.0);
    assert!(!bench.status().contains("Alarm"), "{said}");
    assert_eq!(bench.say("G28.6"), "X:0 Y:1 Z:1 \nok\n", "the others are where they were");
    bench.world(|world| world.obstruct(Alpha, FREE));
    // Homing by hand does not give the job up.
    assert!(bench.say("G28 X").ends_with("ok\n"));
    bench.type_in("resume\n");
    said += &bench.hear_until("Resuming print", 600.0);
    let trace = traced(&mut bench, &mut said);
    assert!(printed(&trace).map(off).fold(0.0, f64::max) < BEAD);
}

#[test]
fn pause_waits_for_a_person_and_resume_homes() {
    let (mut bench, mut said) = printing(plan(CARTESIAN, "pause", "").set("[player] leave_heaters_on_suspend = true"));
    blow(&mut bench, &mut said);
    said += &bench.hear_until("the job is paused at line 22, where motor X stalled", 60.0);
    said += &bench.hear(2.0);
    assert!(bench.heats() && !bench.moves() && !said.contains("homing what"), "{said}");
    bench.type_in("resume\n");
    said += &bench.hear_until("Resuming print", 600.0);
    let trace = traced(&mut bench, &mut said);
    assert!(printed(&trace).map(off).fold(0.0, f64::max) < BEAD);
    assert!((bench.carriage(Delta) - 64.0).abs() < 0.3);
}

#[test]
fn an_axis_that_is_not_homed_is_not_recovered() {
    // The part is printed without Z being homed.
    let text = part("").replace("G28\n", "G28 X Y\n");
    let (mut bench, mut said) = printing(plan(CARTESIAN, "recover", "").file("job.g", &text));
    blow(&mut bench, &mut said);
    said += &bench.hear_until("the job is paused", 60.0);
    assert!(said.contains("Z is not homed, and is not homed onto a part"), "{said}");
    assert!(!said.contains("homing what"), "{said}");
    let before = bench.carriage(Gamma);
    let told = bench.say("resume");
    assert!(told.contains("Z is not homed"), "{told}");
    assert!((bench.carriage(Gamma) - before).abs() < 1e-6, "and nothing moves");
}

#[test]
fn a_halt_at_any_moment_of_it_leaves_a_defined_state() {
    for seconds in [0.0, 0.004, 0.02, 0.1, 0.4, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0] {
        let (mut bench, mut said) = printing(plan(CARTESIAN, "recover", ""));
        blow(&mut bench, &mut said);
        said += &bench.hear(seconds);
        bench.type_in("M112\n");
        said += &bench.hear(1.5);
        assert!(bench.status().contains("<Alarm") && !bench.heats() && !bench.moves(), "{seconds}: {said}");
        bench.say("M999");
        bench.hear(1.0);
        assert!(bench.status().contains("<Idle"), "{seconds}");
        let said = bench.say("progress");
        assert!(said.contains("Not currently playing"), "{seconds}: {said}");
        assert_eq!(bench.say("resume"), "Not suspended\nok\n", "{seconds}");
        assert!(bench.say("G28").ends_with("ok\n"), "{seconds}");
        bench.run(&["G1 X50 Y50 F6000", "M400"]);
        assert!((bench.carriage(Alpha) - 50.0).abs() < 0.02, "{seconds}");
    }
}

#[test]
fn an_end_asked_for_while_it_brakes_leaves_nothing_to_recover() {
    for (asked, seconds) in [("abort", 0.0), ("abort", 0.008), ("M410", 0.0), ("M410", 0.004), ("M410", 0.016)] {
        let (mut bench, mut said) = printing(plan(CARTESIAN, "recover", ""));
        blow(&mut bench, &mut said);
        said += &bench.hear(seconds);
        bench.type_in(&format!("{asked}\n"));
        let after = bench.hear(6.0);
        assert!(!after.contains("goes on by itself") && !after.contains("homing what"), "{asked} {seconds}: {after}");
        assert!(!bench.moves() && bench.carriage(Gamma) < 1.3, "{asked} {seconds}: the tool was lifted: {after}");
        assert_eq!(bench.say("resume"), "Not suspended\nok\n", "{asked} {seconds}");
    }
}

#[test]
fn a_power_cut_during_it_or_behind_it_is_gone_on_after() {
    for seconds in [0.3, 1.5, 3.0, 6.0] {
        let plan =
            plan(CARTESIAN, "recover", "").set("[player] power_loss = true").set("[player] power_loss_period = 1");
        let (mut bench, mut said) = printing(plan);
        blow(&mut bench, &mut said);
        bench.hear(seconds);
        bench.cycle_power();
        assert!(bench.greeting().contains("a job was interrupted"), "{seconds}: {}", bench.greeting());
        let here = bench.carriage(Gamma);
        bench.type_in(&format!("M1000 Z{here:.2}\n"));
        said = bench.hear_until("the job goes on with line", 600.0);
        let mut lowest = f64::INFINITY;
        let end = bench.now_s() + 300.0;
        while bench.moves() || bench.carriage(Gamma) < 19.0 {
            assert!(bench.now_s() < end, "{seconds}: {said}");
            said += &bench.hear(0.02);
            lowest = lowest.min(bench.carriage(Gamma));
        }
        assert!(lowest > 0.85 && (bench.carriage(Gamma) - 20.0).abs() < 0.02, "{seconds}: {lowest}");
    }
}

#[test]
fn where_the_program_is_not_the_file_s_the_job_ends_and_says_how_to_go_on() {
    let (mut bench, mut said) = printing(plan(CARTESIAN, "recover", ""));
    bench.say("G54");
    bench.say("G10 L2 P1 X0.5");
    blow(&mut bench, &mut said);
    said += &bench.hear_until("the job ends at line 22", 60.0);
    assert!(said.contains("play its file --from line 22"), "{said}");
    said += &bench.hear(0.5);
    assert!(!bench.heats() && bench.say("progress").contains("Not currently playing"), "{said}");
}

#[test]
fn on_corexy_both_axes_of_a_belt_home() {
    let mut bench = plan(COREXY, "recover", "").start();
    let place = |bench: &Bench| {
        let (alpha, beta) = (bench.carriage(Alpha), bench.carriage(Beta));
        [(alpha + beta) / 2.0, (alpha - beta) / 2.0]
    };
    bench.type_in("play /sd/job.g -t\n");
    let mut said = String::new();
    until(&mut bench, &mut said, |bench| bench.carriage(Gamma) > 0.89 && bench.carriage(Delta) > 32.5);
    until(&mut bench, &mut said, |bench| (50.0..90.0).contains(&place(bench)[0]));
    let here = bench.carriage(Alpha);
    bench.world(|world| world.obstruct(Alpha, [-1_000.0, here + 5.0]));
    said += &bench.hear_until("motor X stalls", 3.0);
    bench.world(|world| world.obstruct(Alpha, [-1_000.0, 1_000.0]));
    said += &bench.hear_until("homing what has lost its place", 120.0);
    assert!(bench.ask("G28.6").contains("X:0 Y:0 Z:1"), "{said}");
    said += &bench.hear_until("Resuming print", 120.0);
    let mut worst = 0.0_f64;
    let (mut before, end) = (bench.carriage(Delta), bench.now_s() + 300.0);
    while !said.contains("Done printing") {
        assert!(bench.now_s() < end, "{said}");
        said += &bench.hear(0.004);
        let pushed = bench.carriage(Delta);
        if pushed > before + 1e-4 && bench.carriage(Gamma) < 1.3 {
            let [x, y] = place(&bench);
            worst = worst.max(off([x, y, 0.0, 0.0]));
        }
        before = pushed;
    }
    assert!(worst < BEAD, "{worst}");
}

#[test]
fn without_a_job_it_halts() {
    let mut bench = plan(CARTESIAN, "recover", "").start_homed();
    bench.run(&["G1 X20 F6000", "M400"]);
    bench.world(|world| world.obstruct(Alpha, [-3.0, 100.0]));
    bench.type_in("G1 X180 F3600\n");
    bench.hear_until("ERROR: motor X stalls", 10.0);
    assert!(bench.status().contains("<Alarm"));
}

#[test]
fn what_cannot_be_done_is_an_error_of_the_configuration() {
    for (line, word) in [
        ("[actuator] gamma.on_stall = recover", "Z is not homed onto a part"),
        ("[actuator] delta.on_stall = recover", "nobody looks for stalls of this motor"),
        ("[motion control] arm_solution = linear_delta", "home together, Z among them"),
    ] {
        let plan = plan(CARTESIAN, "recover", "").set("[tmc2590] gamma.stall_watch = true").set(line);
        let bench = plan.start();
        assert!(bench.greeting().contains(word), "{line}: {}", bench.greeting());
    }
}
