//! The machine as its viewers see it.

use base::ports::Factors;
use base::snapshot::{JobEnd, Snapshot};
use program::{Spindle, State};
use scenarios::{Bench, CARTESIAN, Plan};
use units::{Axis, AxisSet, Celsius};

/// Returns the machine as somebody sees it who looks now.
fn look(bench: &mut Bench) -> Snapshot {
    bench.network(|network| (network.is_viewed, network.shown) = (true, None));
    bench.hear(0.05);
    bench.network(|network| network.is_viewed = false);
    bench.network(|network| network.shown.take()).expect("a machine that is looked at shows itself")
}

#[test]
fn nobody_is_shown_the_machine_who_does_not_look() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.hear(1.0);
    assert_eq!(bench.network(|network| network.shown.take()), None);
    assert_eq!(look(&mut bench).state, State::Idle);
}

#[test]
fn positions_and_speeds_are_those_of_the_motors_and_of_the_work() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.say("G28.3 X10 Y20 Z30");
    bench.say("G10 L2 P2 X1 Y2 Z3");
    bench.say("G55");
    bench.say("M220 S50");
    let at_rest = look(&mut bench);
    assert_eq!(at_rest.position.0[..3], [10.0, 20.0, 30.0]);
    assert_eq!((at_rest.work[Axis::X], at_rest.work[Axis::Z], at_rest.system), (9.0, 27.0, 1));
    assert_eq!(at_rest.homed, AxisSet::collect(Axis::PRIMARY));
    assert_eq!((at_rest.systems[1], at_rest.systems[0], at_rest.flow_factor), ([1.0, 2.0, 3.0], [0.0; 3], 1.0));
    assert_eq!(at_rest.absolute, [true, true]);
    bench.say("G1 X50 F3000");
    bench.hear(1.0);
    let moving = look(&mut bench);
    assert_eq!(moving.state, State::Run);
    assert!(moving.position[Axis::X] > 15.0 && moving.position[Axis::X] < 50.0, "{:?}", moving.position);
    assert!((moving.speed.0 - 25.0).abs() < 0.5, "{:?}: half of the feed rate", moving.speed);
    assert_eq!((moving.feed_factor, moving.feed_rate.per_minute()), (0.5, 3_000.0));
}

#[test]
fn ends_of_travel_factors_and_modes_follow_the_codes() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.say("M221 S90");
    bench.say("G91");
    bench.say("M83");
    bench.say("M290 Z0.2");
    let shown = look(&mut bench);
    assert_eq!((shown.flow_factor, shown.absolute, shown.shift), (0.9, [false, false], [0.0, 0.0, 0.2]));
    let [least, most] = shown.ends;
    assert!(least[Axis::X] < most[Axis::X], "{least:?} to {most:?}");
}

#[test]
fn heaters_and_fans_are_shown_by_their_names() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.say("M104 S200");
    bench.hear(3.0);
    let shown = look(&mut bench);
    let hotend = shown.heaters.iter().find(|heater| heater.designator == "T").expect("a hotend");
    assert_eq!((hotend.name.as_str(), hotend.target), ("hotend", Celsius(200.0)));
    assert!(hotend.power > 0.9, "it heats with all it has: {}", hotend.power);
    assert!(hotend.reading.is_some_and(|reading| reading.0 > 22.0), "{:?}", hotend.reading);
}

#[test]
fn a_job_is_shown_with_its_progress_and_its_layer() {
    let job: String = (0..200).map(|line| format!("G1 X{} F1200\n", 10 + line % 2 * 2)).collect();
    let file = format!(";LAYER_COUNT:7\n;LAYER:2\n{job}");
    let mut bench = Plan::new(CARTESIAN).file("part.g", &file).start();
    assert_eq!(look(&mut bench).job, None);
    bench.say("G28.3 X10 Y10 Z10");
    bench.say("M23 part.g");
    bench.say("M24");
    bench.hear(3.0);
    let job = look(&mut bench).job.expect("a job");
    assert_eq!((job.path.as_str(), job.size as usize), ("/sd/part.g", file.len()));
    assert!(job.done > 100 && job.done < job.size && job.line > 5, "{job:?}");
    assert_eq!((job.layer, job.layers), (3, Some(7)), "as people count, from one");
    assert!(!job.is_paused && (2..=4).contains(&job.elapsed_s), "{job:?}");
    bench.say("M25");
    bench.hear(1.0);
    assert!(look(&mut bench).job.is_some_and(|job| job.is_paused));
}

#[test]
fn the_path_is_told_in_ends_of_moves_while_somebody_draws_it() {
    let job = "G92 E0\nG1 X20 Y10 E1 F6000\nG0 X20 Y20\nG1 X30 E2\nG1 X31 E1.5\nG3 X31 Y40 I0 J10 E4\n";
    let mut bench = Plan::new(CARTESIAN).file("part.g", job).start();
    bench.say("G28.3 X10 Y10 Z10");
    bench.network(|network| network.draws = Some(true));
    bench.hear(0.1);
    bench.say("G0 X15");
    bench.hear(1.0);
    assert!(bench.network(|network| network.path.contains(&([15.0, 10.0, 10.0], false))));
    bench.say("G0 X10");
    bench.hear(1.0);
    bench.say("M23 part.g");
    bench.say("M24");
    bench.hear(5.0);
    let path = bench.network(|network| network.path.clone());
    assert_eq!(path[0], ([10.0, 10.0, 10.0], false), "where it begins");
    let path = &path[1..];
    let straight: Vec<_> = path.iter().take(4).map(|(at, lays)| (at[0], at[1], *lays)).collect();
    // A retraction on the way lays nothing.
    assert_eq!(straight, [(20.0, 10.0, true), (20.0, 20.0, false), (30.0, 20.0, true), (31.0, 20.0, false)]);
    assert!(path.len() > 10, "an arc is told by more than its end: {path:?}");
    for (at, lays) in &path[4..] {
        assert!(((at[0] - 31.0).hypot(at[1] - 30.0) - 10.0).abs() < 0.02 && *lays, "on the arc: {at:?}");
    }
    assert_eq!(path.last().map(|(at, _)| *at), Some([31.0, 40.0, 10.0]));
    bench.network(|network| network.draws = Some(false));
    bench.say("G1 X50 F6000");
    bench.hear(1.0);
    assert_eq!(bench.network(|network| network.path.len()), path.len() + 1, "nobody draws it any more");
}

#[test]
fn a_job_is_shown_with_its_end_until_the_next_one() {
    let job = "G1 X11 E2 F1200\nG1 X12 E4\n";
    let mut bench = Plan::new(CARTESIAN).file("part.g", job).start();
    bench.say("G28.3 X10 Y10 Z10");
    let end = |bench: &mut Bench| look(bench).job.and_then(|job| job.end);
    bench.say("M23 part.g");
    bench.say("M24");
    bench.hear(2.0);
    let done = look(&mut bench).job.expect("the last job");
    assert_eq!((done.path.as_str(), done.end), ("/sd/part.g", Some(JobEnd::Complete)));
    // The place is sampled each 10 ms, which misses the last of it.
    assert!((3.5..4.01).contains(&done.filament), "{} mm of filament", done.filament);
    for (ends, how) in [("abort", JobEnd::Cancelled), ("M112", JobEnd::Halted)] {
        bench.say("M23 part.g");
        bench.say("M24");
        bench.hear(0.03);
        assert_eq!(end(&mut bench), None, "it is played");
        bench.say(ends);
        bench.hear(1.0);
        assert_eq!(end(&mut bench), Some(how), "{ends}");
    }
}

#[test]
fn spindle_coolant_and_tool_of_a_mill_are_shown() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[pwm1] frequency = 5000")
        .set("[switch] tool.enable = true")
        .set("[switch] tool.input_on_command = M3")
        .set("[switch] tool.input_off_command = M5")
        .set("[switch] tool.output_pin = PWM1_1")
        .set("[switch] tool.output_type = hwpwm")
        .set("[switch] tool.max_rpm = 12000")
        .set("[switch] flood.enable = true")
        .set("[switch] flood.input_on_command = M8")
        .set("[switch] flood.input_off_command = M9")
        .set("[switch] flood.output_pin = PI4")
        .set("[switch] flood.output_type = digital")
        .start();
    let shown = look(&mut bench);
    assert_eq!(
        (shown.spindle.map(|spindle| spindle.direction), shown.coolant),
        (Some(Spindle::Stopped), Some([false; 2]))
    );
    bench.say("M3 S1000");
    bench.say("M8");
    let shown = look(&mut bench);
    let spindle = shown.spindle.expect("a spindle");
    assert_eq!((spindle.direction, spindle.asked, spindle.set), (Spindle::Clockwise, 1_000.0, 1_000.0));
    assert_eq!((spindle.most, spindle.factor), (12_000.0, 1.0));
    assert_eq!((shown.coolant, shown.tool), (Some([true, false]), None), "tools are extruders here");
}

#[test]
fn switches_and_limits_are_shown() {
    let mut bench = Plan::new(CARTESIAN).start();
    let shown = look(&mut bench);
    let names: Vec<_> = shown.limits.iter().map(|limit| (limit.axis, limit.end)).collect();
    assert_eq!(names, [(Axis::X, Some(false)), (Axis::Y, Some(false)), (Axis::Z, Some(false))]);
    assert!(shown.limits.iter().all(|limit| !limit.is_pressed));
    assert_eq!(shown.most, (None, 2_000.0));
    let hotend = shown.heaters.iter().find(|heater| heater.designator == "T").expect("a hotend");
    assert!(hotend.heats && hotend.max.0 > 200.0, "{hotend:?}");
}

#[test]
fn factors_of_rapids_and_of_the_spindle_act_at_once() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.say("G28.3 X10 Y10 Z10");
    bench.say("G0 X200 F12000");
    bench.hear(0.3);
    bench.network(|network| network.factors = Some(Factors { rapid: Some(0.25), spindle: Some(1.1) }));
    bench.hear(0.5);
    let shown = look(&mut bench);
    assert_eq!(shown.rapid_factor, 0.25);
    assert!((40.0..80.0).contains(&shown.speed.0), "the move under way is slower, too: {:?}", shown.speed);
    bench.say("M112");
    bench.network(|network| network.factors = Some(Factors { rapid: Some(0.5), spindle: None }));
    bench.hear(0.5);
    assert_ne!(look(&mut bench).rapid_factor, 0.5, "not while it is halted");
}

#[test]
fn the_mesh_is_shown_from_the_front_left_once_for_each_change() {
    let mesh = |origin: &str, step: &str| {
        format!(
            "; Velvet bed mesh\nmesh 1\npoints 3 2\norigin {origin}\nstep {step}\nheights\n0.1 0.2 0.3\n-0.1 -0.2 -0.3\n"
        )
    };
    let mut bench = Plan::new(CARTESIAN)
        .set("[zprobe] leveling = cartesian grid")
        .file("ahead.mesh", &mesh("10 20", "40 30"))
        .file("back.mesh", &mesh("90 50", "-40 -30"))
        .start();
    assert_eq!(look(&mut bench).mesh, None);
    let said = bench.say("BED_MESH_PROFILE LOAD=ahead");
    let shown = look(&mut bench).mesh.expect(&said);
    assert_eq!((shown.name.as_str(), shown.count, shown.ends), ("ahead", [3, 2], [[10.0, 20.0], [90.0, 50.0]]));
    let (number, heights) = bench.network(|network| network.heights.clone());
    assert_eq!((number, heights), (shown.number, vec![vec![0.1, 0.2, 0.3], vec![-0.1, -0.2, -0.3]]));
    bench.network(|network| network.heights.1.clear());
    assert_eq!(look(&mut bench).mesh, Some(shown));
    assert!(bench.network(|network| network.heights.1.is_empty()), "they are known");
    bench.say("BED_MESH_PROFILE LOAD=back");
    let back = look(&mut bench).mesh.expect("a mesh");
    assert_eq!((back.count, back.ends), (shown.count, shown.ends));
    let (number, heights) = bench.network(|network| network.heights.clone());
    assert_eq!((number, heights), (back.number, vec![vec![-0.3, -0.2, -0.1], vec![0.3, 0.2, 0.1]]));
    assert_ne!(back.number, shown.number);
    bench.say("BED_MESH_CLEAR");
    assert_eq!(look(&mut bench).mesh, None);
}
