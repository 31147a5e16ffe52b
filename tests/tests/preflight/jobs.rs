//! Jobs that are found to stop before they do, and jobs that are looked at before they begin.

use base::sessions::SessionId;
use scenarios::{CARTESIAN, Plan};

use super::{repeated, vase, with};

const LEAVES: &str = "G28\nG1 X10 Y10 F6000\nG4 P2000\nG1 X999\nG1 X20\n";

#[test]
fn a_job_pauses_before_the_line_that_would_halt_it() {
    let mut bench = Plan::new(&with(CARTESIAN, "[player] preflight_wait = 0")).file("job.g", LEAVES).start();
    bench.type_in("play /sd/job.g -t\n");
    let said = bench.hear_until("the job pauses before it\n", 5.0);
    assert!(said.contains("// WARNING line 4: stops: machine X 999.000 is out of travel"), "{said}");
    bench.hear_until("Print Suspended", 30.0);
    assert!(bench.say("get state").contains("Suspended") || bench.say("progress").contains("Suspended"));
    assert!(bench.say("abort").contains("Suspend cleared"));
    assert!(bench.say("G1 X20 F6000").ends_with("ok\n"), "nothing has halted");
}

#[test]
fn a_job_that_leaves_the_travel_is_not_begun_unless_told() {
    let mut bench = Plan::new(CARTESIAN).file("job.g", LEAVES).file("good.g", "G28\nG1 X10 F6000\n").start();
    bench.type_in("play /sd/job.g -t\n");
    let said = bench.hear_until("play --force file begins it all the same\n", 5.0);
    assert!(said.contains("// WARNING line 4: stops: machine X 999.000 is out of travel"), "{said}");
    assert!(said.contains("error:the job was not begun: it would leave the travel"), "{said}");
    assert!(bench.say("progress").contains("Not currently playing"), "nothing is open");
    assert!(!bench.say("M114").contains("X:10"), "nothing has moved");
    bench.type_in("play /sd/good.g -t\n");
    let said = bench.hear_until("Done printing file", 60.0);
    assert!(!said.contains("//"), "nothing is said of a good one: {said}");
    bench.type_in("play --force /sd/job.g -t\n");
    let _ = bench.hear_until("was not carried out", 60.0);
    assert!(bench.say("M114").contains("X:10"), "it was begun");
}

/// A file that takes longer to look at than the job waits is begun, and what is found later pauses it.
#[test]
fn a_long_file_is_begun_after_a_while() {
    let text = format!("G28\nM302\n{}G1 X999\n", vase(600, 120));
    let plan = Plan::new(&with(CARTESIAN, "[player] preflight_wait = 0.5"));
    let mut bench = plan.file("big.g", &text).start();
    bench.type_in("play /sd/big.g\n");
    let said = bench.hear(0.4);
    assert!(bench.status().contains("Idle"), "it waits: {said}");
    let said = said + &bench.hear_until("the job pauses before it\n", 200.0);
    println!("the look ended after {:.1} s", bench.now_s());
    assert!(!said.contains("not begun") && !bench.say("progress").contains("Not currently"), "{said}");
}

#[test]
fn a_job_is_refused_where_the_whole_file_is_looked_at_first() {
    let plan = || Plan::new(&with(CARTESIAN, "[player] preflight = refuse"));
    let mut bench = plan().file("job.g", LEAVES).file("good.g", "G28\nG1 X10 F6000\n").start();
    bench.type_in("play /sd/job.g -t\n");
    let said = bench.hear_until("play --force file begins it all the same\n", 5.0);
    assert!(said.contains("line 4: stops: machine X 999.000") && said.contains("1 of its lines"), "{said}");
    assert!(bench.say("progress").contains("Not currently playing"), "nothing is open");
    assert!(!bench.say("M114").contains("X:10"), "nothing has moved");
    bench.type_in("play /sd/good.g -t\n");
    let said = bench.hear_until("Done printing file", 60.0);
    assert!(said.contains("// nothing in it stops the job"), "{said}");
    bench.type_in("play --force /sd/job.g -t\n");
    let said = bench.hear_until("was not carried out", 60.0);
    assert!(!said.contains("looked at") && !said.contains("the job pauses before"), "{said}");
}

#[test]
fn a_job_from_its_middle_is_refused_alike() {
    let plan = || Plan::new(&with(CARTESIAN, "[player] preflight = refuse"));
    let mut bench = plan().file("job.g", LEAVES).file("good.g", "G28\nG1 X10 F6000\nG1 X20\nG1 X30\n").start();
    bench.run(&["G28"]);
    bench.type_in("play /sd/job.g --from line 2\n");
    let said = bench.hear_until("play --force file begins it all the same\n", 5.0) + &bench.hear(1.0);
    assert!(said.contains("line 4: stops: machine X 999.000") && !said.contains("the job begins with"), "{said}");
    assert!(
        !said.contains("the file ends before") && bench.say("progress").contains("Not currently playing"),
        "{said}"
    );
    assert!(bench.say("G1 X15 F6000").ends_with("ok\n"), "the machine is as before");
    bench.say("M400");
    bench.type_in("play /sd/good.g --from line 3\n");
    let said = bench.hear_until("the job begins with line 3", 60.0);
    assert!(said.contains("// the whole file is looked at before it is begun"), "{said}");
    assert!(said.contains("// nothing in it stops the job: 0 warnings, 00:00:"), "{said}");
    let _ = bench.hear(20.0);
    assert!(bench.say("M114").contains("X:30"), "{}", bench.say("M114"));
    bench.type_in("play --force /sd/job.g --from line 2\n");
    let said = bench.hear_until("was not carried out", 60.0);
    assert!(!said.contains("looked at"), "{said}");
}

#[test]
fn a_long_look_says_how_far_it_is() {
    let plan = Plan::new(&with(CARTESIAN, "[player] preflight = refuse"));
    let mut bench = plan.file("big.g", &format!("G28\nM302\n{}", vase(600, 120))).start();
    bench.type_in("play /sd/big.g\n");
    let said = bench.hear_until("// nothing in it stops the job", 200.0);
    let told: Vec<_> = said.lines().filter(|line| line.starts_with("// looked at ")).collect();
    println!("{told:?} until {:.1} s", bench.now_s());
    assert!(!told.is_empty() && told[0].contains(" % of the file, about "), "{said}");
}

#[test]
fn m73_says_how_far_the_job_is_as_hosts_read_it() {
    let text = repeated(30, "G1 X40 F600\nG1 X10\n");
    let mut bench = Plan::new(CARTESIAN).file("job.g", &text).start();
    bench.run(&["G28"]);
    assert_eq!(bench.say("M73"), "Not currently playing\nok\n");
    bench.type_in("play /sd/job.g\n");
    let _ = bench.hear(60.0);
    // 181 s in all.
    let said = bench.say("M73");
    assert_eq!(said, "NORMAL MODE: Percent done: 33; print time remaining in mins: 3; Change in mins: -1\nok\n");
    assert_eq!(bench.say("M73 P10 R5"), "ok\n", "what a slicer writes is no question");
}

#[test]
fn a_file_that_is_not_looked_at_is_said_nothing_of() {
    let mut bench = Plan::new(&with(CARTESIAN, "[player] preflight = off")).file("job.g", LEAVES).start();
    bench.type_in("play /sd/job.g -t\n");
    let said = bench.hear_until("was not carried out", 60.0);
    assert!(!said.contains("WARNING line 4"), "{said}");
}

/// `check` beside a job that moves: the job's steps are the same.
#[test]
fn a_look_beside_a_job_changes_no_step() {
    let job = repeated(6, "G1 X40 F4800\nG1 Y40\nG1 X10\nG1 Y10\n");
    let run = |looks: bool| {
        let config = with(CARTESIAN, "[player] preflight = off");
        let mut bench = Plan::new(&config).file("job.g", &job).file("other.g", &vase(12, 120)).start();
        bench.run(&["G28"]);
        bench.type_in("play /sd/job.g -t\n");
        let mut said = bench.hear(0.5);
        if looks {
            bench.type_in("check /sd/other.g\n");
        }
        said += &bench.hear_until("Done printing file", 60.0);
        assert_eq!(said.contains("0 stop the job"), looks, "{said}");
        bench.world(|world| format!("{:?}", world.trace_mut().take()))
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn a_file_that_changes_meanwhile_is_looked_at_no_more() {
    let mut bench = Plan::new(CARTESIAN).file("big.g", &vase(200, 120)).start();
    // Beside: whoever types on the other console.
    bench.type_on(SessionId(1), "check /sd/big.g\n");
    let _ = bench.hear_on(SessionId(1), 0.01);
    let _ = bench.say("rm /sd/big.g");
    let said = bench.hear_on(SessionId(1), 1.0);
    assert!(said.contains("error:the file has changed meanwhile"), "{said}");
}
