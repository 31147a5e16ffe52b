//! Programs that call, branch and wait, played from the card by a whole machine.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta};

/// Plays a program to its end; returns everything heard.
fn play(name: &str, plan: Plan) -> (Bench, String) {
    let mut bench = plan.start();
    bench.hear(0.05);
    bench.type_in(&format!("M32 {name}\n"));
    let heard = bench.hear_until("Done printing file", 120.0);
    (bench, heard)
}

fn one(text: &str) -> (Bench, String) {
    play("a.g", Plan::new(CARTESIAN).file("a.g", text))
}

/// A machine without extruders.
fn mill() -> Plan {
    Plan::new(CARTESIAN).set("[extruder] hotend.enable = false")
}

/// Asserts the places of the carriages, relative to their start.
#[track_caller]
fn stands_at(bench: &Bench, x: f64, y: f64) {
    let begun = Plan::new(CARTESIAN).start();
    let here = [Alpha, Beta].map(|motor| bench.carriage(motor) - begun.carriage(motor));
    assert!((here[0] - x).abs() < 0.02 && (here[1] - y).abs() < 0.02, "{here:?}, not {x} {y}");
}

#[test]
fn a_loop_calls_a_subroutine_of_the_same_file() {
    let (bench, heard) = one("%\nO1001 (staircase)\nG91\nO100 sub\nG1 X#1 F3000\nG1 Y[#1/2]\nO100 endsub\n#2=0\n\
        O1 while [#2 LT 4]\n#2=[#2+1]\nO100 call [#2]\nO1 endwhile\n(PRINT, #2 steps)\n%\nG1 X50\n");
    stands_at(&bench, 10.0, 5.0);
    assert!(heard.contains("// 4.000000 steps\n"), "{heard}");
}

#[test]
fn a_subroutine_may_have_a_file_of_its_own_that_calls_another() {
    let plan = Plan::new(CARTESIAN)
        .file("a.g", "G91\no<outer> call [3]\no<outer> call [1]\nG1 Y1 F3000\n")
        .file("outer.ngc", "(comes before)\no<outer> sub\no<inner> call [#1*2]\no<outer> endsub\n")
        .file("inner.ngc", "o<inner> sub\nG1 X#1 F3000\no<inner> endsub\n");
    let (bench, _) = play("a.g", plan);
    stands_at(&bench, 8.0, 1.0);
}

#[test]
fn m98_calls_what_stands_behind_the_end_of_the_program() {
    let (bench, heard) = one("G91\nM98 P2000 L3\nG1 Y1 F3000\nM30\nO2000\nG1 X2 F3000\nM99\n");
    stands_at(&bench, 6.0, 1.0);
    assert!(!heard.contains("error"), "{heard}");
}

#[test]
fn a_subroutine_is_called_from_the_console_when_it_is_a_file() {
    let sub = "o<pocket> sub\nG91\nG1 X#1 F3000\nG90\no<pocket> endsub\nG1 X50\n";
    let mut bench = Plan::new(CARTESIAN).file("pocket.ngc", sub).start();
    assert_eq!(bench.say("o<pocket> call [2] "), "ok\n");
    bench.hear_until("Done printing file", 10.0);
    stands_at(&bench, 2.0, 0.0);
    let refused = bench.say("o1 while [1]");
    assert!(refused.starts_with("error:here only O<name> call works"), "{refused}");
    let refused = bench.say("o<nobody> call");
    assert!(refused.starts_with("error:"), "{refused}");
}

#[test]
fn what_is_wrong_pauses_the_job_and_is_named() {
    let mut bench = Plan::new(CARTESIAN).file("a.g", "G1 X1 F3000\nO1 endif\nG1 X2\n").start();
    bench.type_in("M32 a.g\n");
    let heard = bench.hear_until("paused", 10.0);
    assert!(heard.contains("O1 endif does not belong") && heard.contains("line 2 of /sd/a.g"), "{heard}");
    bench.hear(0.5);
    stands_at(&bench, 1.0, 0.0);
    let (_, heard) = one("G1 X1 F3000\nO7 call\nG1 X2\n");
    assert!(heard.contains("O7: there is no such subroutine"), "{heard}");
}

#[test]
fn a_long_loop_starves_neither_console_nor_motion() {
    let program = "#1=0\nO1 while [#1 LT 100000]\n#1=[#1+1]\nO1 endwhile\nG1 X1 F3000\n";
    let mut bench = Plan::new(CARTESIAN).file("a.g", program).start();
    bench.type_in("M32 a.g\n");
    bench.hear_until("File selected", 1.0);
    let begun = bench.now_s();
    let mut heard = String::new();
    while !heard.contains("Done printing file") {
        bench.type_in("M114\n");
        heard = bench.hear(0.02);
        assert!(heard.contains("C: X:"), "a question waits for the loop: {heard}");
        assert!(bench.now_s() - begun < 120.0, "it does not end");
    }
    stands_at(&bench, 1.0, 0.0);
}

#[test]
fn a_program_waits_for_the_operator() {
    for go_on in ["~", "M24\n"] {
        let plan = mill().file("a.g", "G1 X1 F3000\n(MSG, turn the part)\nM0\nT2 M6\nG1 X2\n");
        let mut bench = plan.start();
        bench.type_in("M32 a.g\n");
        let heard = bench.hear_until("(M0)", 10.0);
        assert!(heard.contains("// turn the part\n"), "{heard}");
        bench.hear(1.0);
        stands_at(&bench, 1.0, 0.0);
        bench.type_in(go_on);
        let heard = bench.hear_until("(M6)", 10.0);
        assert!(heard.contains("put in tool 2"), "{heard}");
        bench.hear(1.0);
        stands_at(&bench, 1.0, 0.0);
        bench.type_in(go_on);
        bench.hear_until("Done printing file", 10.0);
        stands_at(&bench, 2.0, 0.0);
    }
}

#[test]
fn a_session_that_sends_m0_waits_too() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.hear(0.05);
    bench.type_in("G1 X1 F3000\nM0\nG1 X2\n");
    let heard = bench.hear_until("(M0)", 10.0);
    assert!(heard.contains("~ goes on"), "{heard}");
    bench.hear(1.0);
    stands_at(&bench, 1.0, 0.0);
    assert!(bench.status().starts_with("<Hold"));
    bench.type_in("~");
    bench.hear(1.0);
    stands_at(&bench, 2.0, 0.0);
}

#[test]
fn a_halt_ends_what_was_called_and_opened() {
    let program = "O1 sub\nO2 repeat [100]\nG91\nG1 X1 F60\nO2 endrepeat\nO1 endsub\nO1 call\n";
    let mut bench = Plan::new(CARTESIAN).file("a.g", program).file("b.g", "G90\nG1 Y1 F3000\n").start();
    bench.type_in("M32 a.g\n");
    bench.hear(0.5);
    bench.type_in("M112\n");
    bench.hear(0.5);
    bench.type_in("M999\n");
    bench.hear(0.5);
    bench.type_in("M32 b.g\n");
    let heard = bench.hear_until("Done printing file", 10.0);
    assert!(!heard.contains("error"), "{heard}");
}

#[test]
fn a_program_knows_its_line() {
    let files = Plan::new(CARTESIAN).file("f.ngc", "o<f> sub\n\n(PRINT, f #<_line>)\no<f> endsub\n");
    let job = "(PRINT, a #<_line>)\nO1 repeat [2]\n#31=#<_line>\nO1 endrepeat\n(PRINT, b #31 #<_line>)\nO<f> call\n\
               (PRINT, c #<_line>)\n";
    let mut bench = files.file("a.g", job).start();
    bench.type_in("M32 a.g\n");
    let heard = bench.hear_until("Done printing file", 10.0);
    for said in ["a 1.000000", "b 3.000000 5.000000", "f 3.000000", "c 7.000000"] {
        assert!(heard.contains(said), "{said}: {heard}");
    }
    let at_the_console = bench.say("(PRINT, d #<_line>)");
    assert!(at_the_console.contains("d 0.000000"), "{at_the_console}");
}

#[test]
fn parameters_outlast_a_power_cycle() {
    let (bench, _) = one("#5=1 #31=[1/3] #4000=-7 #32=1\n#32=0\nM2\n");
    let kept = bench.read_card("parameters.var").unwrap();
    assert_eq!(kept, "31\t0.3333333333333333\n4000\t-7\n");
    let again = Plan::new(CARTESIAN).file("parameters.var", &format!("{kept}12\t1\nnonsense\n"));
    let mut bench = again.file("a.g", "(PRINT, #31 #4000 #12)\n").start();
    assert!(bench.greeting().contains("/sd/parameters.var: 2 lines are no parameters"), "{}", bench.greeting());
    bench.type_in("M32 a.g\n");
    let heard = bench.hear_until("Done printing file", 10.0);
    assert!(heard.contains("// 0.333333 -7.000000 0.000000\n"), "{heard}");
}
