//! From jobs on the virtual board to the ledger's numbers.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};

use super::board::{
    BYTES, Bench, ETHERNET, FEED, GUARD, HEAT, Job, LATE, Measured, NETWORK, PLANNER, Results, USB, WATCH,
};
use super::figures::Ledger;
use super::hold;
use super::jobs;
use super::laser;
use super::machines::{KINDS, Kind, Machines};

/// Instructions the core executes in a second of virtual time, and so what a second has room for.
const INSTRUCTIONS_PER_S: f64 = 400e6;
/// Rates of the fastest of three motors that are tried, best first: from what a configuration allows
/// downwards.
const RATES: [u32; 12] =
    [1_000_000, 950_000, 900_000, 850_000, 800_000, 750_000, 700_000, 650_000, 600_000, 550_000, 500_000, 450_000];
/// The rate of the fastest motor at which the budget looks at the feed: one that does not hang on how its
/// runs fall on the queue.
const HELD_RATE: u32 = 800_000;
/// Speed ratios of the three axes together, in the loaded job.
const LOADED_AXES: f64 = 1.0 + 0.975 + 0.95;
/// Endings of the names of jobs and keys whose ramps are limited in jerk, shaped, and extruders advanced.
const SMOOTH: &str = "_smooth";
/// Endings of the names of jobs and keys of arcs, and of GRBL's dialect.
const ARCS: &str = "_arcs";
const GRBL: &str = "_grbl";
/// Ending of the names of jobs that preflight reads first.
const AHEAD: &str = "_ahead";
/// Traffic on the network, in the board's words and as the ledger's rows call it.
const TRAFFIC: [&str; 2] = ["quiet", "flood"];
/// The kinds that are measured on an uneven bed.
const LEVELLED: [&str; 2] = ["cartesian", "linear_delta"];
/// A job of so many lines, or turns.
type Program = fn(usize) -> String;
/// Jobs of so many lines, or turns, of a program: their names are those of the ledger's rows.
const LANGUAGE: [(&str, Program); 3] =
    [("expression", jobs::lines_with_expressions), ("called_line", jobs::lines_called), ("turn", jobs::turns)];

fn machines(root: &Path) -> Result<Machines> {
    let read = |file: &str| {
        let path = root.join("bench").join(file);
        fs::read_to_string(&path).with_context(|| path.display().to_string())
    };
    Ok(Machines { printer: read("config.ini")?, fast: read("fast.ini")? })
}

/// Runs every job on the virtual board.
pub fn jobs(root: &Path, bench: &Bench<'_>) -> Result<Ledger> {
    let machines = machines(root)?;
    let results = bench.run(list(&machines))?;
    let mut ledger = Ledger::new();
    steps(&results, &mut ledger)?;
    kinematics(&results, &mut ledger)?;
    lines(&results, "", &mut ledger)?;
    lines(&results, SMOOTH, &mut ledger)?;
    dialects(&results, &mut ledger)?;
    language(&results, &mut ledger)?;
    let printer = results.of("printer-3")?;
    ledger.insert("start_ms".into(), round(printer.calls(HEAT, "first_ns")? * 1e-6));
    ledger.insert("feed_run_max_instructions".into(), printer.calls(FEED, "max")?);
    watch(results.of("watched")?, &mut ledger)?;
    usb(results.of("computer")?, &mut ledger)?;
    network(&results, &mut ledger)?;
    for (key, latency_us) in hold::latencies_us(bench, &machines)? {
        ledger.insert(key.into(), round(latency_us));
    }
    let (max, rms) = bench.step_error(results.of("hard")?)?;
    ledger.insert("step_error_max_ns".into(), max);
    ledger.insert("step_error_rms_ns".into(), rms);
    laser::measure(root, bench, &machines, &mut ledger)?;
    sustained(bench, &machines, &mut ledger)?;
    Ok(ledger)
}

/// The figures that `bench/budget.toml` holds, by the shortest jobs that give them.
pub fn held(root: &Path, bench: &Bench<'_>) -> Result<Ledger> {
    let machines = machines(root)?;
    let (printer, smooth) = (&machines.printer, machines.smooth_printer());
    let mut list = vec![
        Job::new("computer", &machines.with_two_ports(), jobs::watched()).with_computer(),
        Job::new("loaded", &machines.fastest(), jobs::loaded(HELD_RATE)).under_load(),
    ];
    for (count, which) in [(jobs::FEW, "few"), (jobs::MANY, "many")] {
        list.push(Job::new(format!("lines-{which}"), printer, jobs::lines(count)));
        list.push(Job::new(format!("lines-{which}{SMOOTH}"), &smooth, jobs::lines(count)));
        list.push(Job::new(format!("turn-{which}"), printer, jobs::turns(count)));
    }
    list.extend(dialect_jobs(&machines));
    list.extend(network_jobs(&machines));
    let results = bench.run(list)?;
    let mut ledger = Ledger::new();
    for with in ["", SMOOTH] {
        ledger.insert(format!("line_instructions{with}"), round(line_cost(&results, with)?));
    }
    dialects(&results, &mut ledger)?;
    ledger.insert("turn_instructions".into(), round(cost(&results, "turn", "")?));
    usb(results.of("computer")?, &mut ledger)?;
    network(&results, &mut ledger)?;
    let loaded = results.of("loaded")?;
    ensure!(keeps_up(loaded, HELD_RATE)?, "steps are late at {HELD_RATE} steps/s of the fastest motor");
    ledger.insert("masked_window_max_instructions".into(), masked(loaded)?);
    ledger.insert("feed_per_step_held".into(), round(loaded.moving(FEED)? / loaded.steps()?));
    ledger.insert("feed_run_max_held_instructions".into(), loaded.calls(FEED, "max")?);
    for (key, latency_us) in hold::latencies_us(bench, &machines)? {
        ledger.insert(key.into(), round(latency_us));
    }
    Ok(ledger)
}

/// The longest time in which a step has to wait.
fn masked(run: &Measured) -> Result<f64> {
    let seen = run.number(&["moving", "masked_windows_of_run"])?;
    ensure!(seen > 0.0, "no window with interrupts masked was seen at all");
    // There may be none while the machine moves.
    Ok(run.number(&["moving", "masked_max"]).unwrap_or(0.0))
}

/// All jobs but those that look for the highest rate.
fn list(machines: &Machines) -> Vec<Job> {
    let (fast, printer) = (&machines.fast, &machines.printer);
    let mut list: Vec<Job> = [1, 3, 4].map(|n| Job::new(format!("steps-{n}"), fast, jobs::steps(n, 1.0))).into();
    list.push(Job::new("steps-6", &machines.six_motors(), jobs::steps(6, 0.5)));
    list.push(Job::new("printer-3", printer, jobs::steps(3, 2.5)));
    list.push(Job::new("computer", &machines.with_two_ports(), jobs::watched()).with_computer());
    list.push(Job::new("watched", printer, jobs::watched()));
    list.push(Job::new("lines-few", printer, jobs::lines(jobs::FEW)));
    list.push(Job::new("lines-many", printer, jobs::lines(jobs::MANY)));
    list.extend(dialect_jobs(machines));
    list.extend(network_jobs(machines));
    for (name, job) in LANGUAGE {
        list.push(Job::new(format!("{name}-few"), printer, job(jobs::FEW)));
        list.push(Job::new(format!("{name}-many"), printer, job(jobs::MANY)));
    }
    let looking = machines.looking_ahead();
    list.push(Job::new(format!("lines-few{AHEAD}"), &looking, jobs::lines(jobs::FEW)));
    list.push(Job::new(format!("lines-many{AHEAD}"), &looking, jobs::lines(jobs::MANY)));
    let smooth = machines.smooth_printer();
    list.push(Job::new("lines-few_smooth", &smooth, jobs::lines(jobs::FEW)));
    list.push(Job::new("lines-many_smooth", &smooth, jobs::lines(jobs::MANY)));
    list.push(Job::new("hard_smooth", &smooth, jobs::hard()));
    if let Some(kind) = KINDS.iter().find(|kind| kind.word == "cartesian") {
        list.push(Job::new("cartesian_smooth", &machines.smooth(kind), kind.job(true)));
    }
    for kind in KINDS.iter().filter(|kind| LEVELLED.contains(&kind.word)) {
        list.push(Job::new(format!("{}-levelled", kind.word), &machines.levelled(kind), kind.levelled_job()));
    }
    list.push(Job::new("hard", &machines.shaped_printer(), jobs::hard()));
    for kind in &KINDS {
        for shaped in [false, true] {
            list.push(Job::new(name(kind, shaped), &machines.of(kind, shaped), kind.job(shaped)));
        }
    }
    list
}

fn name(kind: &Kind, shaped: bool) -> String {
    format!("{}-{}", kind.word, if shaped { "shaped" } else { "plain" })
}

/// The slow watch: four drivers on the board are asked once a second, the supplies are looked at ten times.
fn watch(run: &Measured, ledger: &mut Ledger) -> Result<()> {
    ensure!(run.seconds_moving()? > 3.0, "too short for the drivers to be asked three times");
    let late = run.number(&["functions", LATE, "calls"])?;
    ensure!(late == 0.0, "{late} steps were late while the drivers were asked");
    let share = run.moving(WATCH)? / run.seconds_moving()? / INSTRUCTIONS_PER_S;
    ledger.insert("driver_watch_percent".into(), (share * 10_000.0).round() / 100.0);
    ledger.insert("driver_watch_max_instructions".into(), run.calls(WATCH, "max")?);
    Ok(())
}

/// Instructions of the interrupt and the feed for each step, by motors.
fn steps(results: &Results, ledger: &mut Ledger) -> Result<()> {
    for (job, key) in
        [("steps-1", "1"), ("steps-3", "3"), ("steps-4", "4"), ("steps-6", "6"), ("printer-3", "printer_3")]
    {
        let run = results.of(job)?;
        let (emit, feed) = (run.emitting()? / run.steps()?, run.moving(FEED)? / run.steps()?);
        ledger.insert(format!("emit_per_step_{key}"), round(emit));
        ledger.insert(format!("feed_per_step_{key}"), round(feed));
        if key == "3" {
            ledger.insert("per_step_total".into(), round(emit + feed));
            for statistic in ["min", "median", "p99", "max"] {
                ledger.insert(format!("step_interrupt_{statistic}"), run.calls("TIM2", statistic)?);
            }
        }
    }
    Ok(())
}

fn kinematics(results: &Results, ledger: &mut Ledger) -> Result<()> {
    for kind in &KINDS {
        for shaped in [false, true] {
            let run = results.of(&name(kind, shaped))?;
            let key = format!("solve_per_step_{}_{}", kind.word, if shaped { "shaped" } else { "plain" });
            ledger.insert(key, round(run.moving(FEED)? / run.steps()?));
        }
    }
    for word in LEVELLED {
        let run = results.of(&format!("{word}-levelled"))?;
        ledger.insert(format!("solve_per_step_{word}_levelled"), round(run.moving(FEED)? / run.steps()?));
    }
    let smooth = results.of("cartesian_smooth")?;
    ledger.insert("solve_per_step_cartesian_smooth".into(), round(smooth.moving(FEED)? / smooth.steps()?));
    Ok(())
}

/// Cost of a line and of a block: the difference of two jobs that differ in lines and in nothing else; `with`
/// ends the names of these jobs and keys.
fn lines(results: &Results, with: &str, ledger: &mut Ledger) -> Result<()> {
    let of = |job: &str| results.of(&format!("{job}{with}"));
    let (few, many, hard) = (of("lines-few")?, of("lines-many")?, of("hard")?);
    let each = |cost: &dyn Fn(&Measured) -> Result<f64>| -> Result<f64> {
        Ok((cost(many)? - cost(few)?) / (many.lines()? - few.lines()?))
    };
    let line = each(&Measured::executor)?;
    let plan = each(&|run| run.number(&["functions", PLANNER, "total"]))?;
    let solve = each(&|run| run.number(&["functions", FEED, "total"]))?;
    let passes = [many.calls(PLANNER, "max")?, hard.calls(PLANNER, "max")?];
    let runs = [many.calls(FEED, "max")?, hard.calls(FEED, "max")?];
    // Everything that ran while the machine moved, its steps included.
    let lines_per_s = (INSTRUCTIONS_PER_S * many.lines()? / many.while_moving()?).round();
    let mut enter = |key: &str, number: f64| ledger.insert(format!("{key}{with}"), number);
    enter("line_instructions", round(line));
    enter("plan_instructions_per_block", round(plan));
    enter("block_instructions", round(plan + solve));
    enter("plan_pass_max_instructions", passes.into_iter().fold(0.0, f64::max));
    enter("feed_run_max_lines_instructions", runs.into_iter().fold(0.0, f64::max));
    enter("lines_per_s", lines_per_s);
    Ok(())
}

/// The lines of a mill: arcs, and GRBL's dialect.
fn dialect_jobs(machines: &Machines) -> Vec<Job> {
    let mill = machines.in_grbl();
    [jobs::FEW, jobs::MANY]
        .into_iter()
        .zip(["few", "many"])
        .flat_map(|(count, which)| {
            let arcs = Job::new(format!("lines-{which}{ARCS}"), &machines.printer, jobs::arcs(count));
            [arcs, Job::new(format!("lines-{which}{GRBL}"), &mill, jobs::lines_of_grbl(count))]
        })
        .collect()
}

fn dialects(results: &Results, ledger: &mut Ledger) -> Result<()> {
    for with in [ARCS, GRBL] {
        ledger.insert(format!("line_instructions{with}"), round(line_cost(results, with)?));
    }
    Ok(())
}

/// Instructions of the executor for a line.
fn line_cost(results: &Results, with: &str) -> Result<f64> {
    let of = |which: &str| results.of(&format!("lines-{which}{with}"));
    let (few, many) = (of("few")?, of("many")?);
    Ok((many.executor()? - few.executor()?) / (many.lines()? - few.lines()?))
}

/// Cost of expressions, subroutines, loops and preflight: an expression, a called line and a line that
/// is looked at beyond the same line without, a turn of a loop in all.
fn language(results: &Results, ledger: &mut Ledger) -> Result<()> {
    let plain = cost(results, "lines", "")?;
    for (name, _) in LANGUAGE {
        let without = if name == "turn" { 0.0 } else { plain };
        ledger.insert(format!("{name}_instructions"), round(cost(results, name, "")? - without));
    }
    ledger.insert("look_ahead_instructions".into(), round(cost(results, "lines", AHEAD)? - plain));
    Ok(())
}

/// Instructions of the executor for each turn or line of a job.
fn cost(results: &Results, job: &str, with: &str) -> Result<f64> {
    let of = |which: &str| results.of(&format!("{job}-{which}{with}"))?.executor();
    Ok((of("many")? - of("few")?) / (jobs::MANY - jobs::FEW) as f64)
}

/// The USB interrupt, which is all of the device's task, while a computer says and hears all it can on both
/// ports and three motors run.
fn usb(run: &Measured, ledger: &mut Ledger) -> Result<()> {
    ensure!(run.calls(USB, "calls")? > 1_000.0, "the computer was not heard");
    for (key, statistic) in [("median", "median"), ("p99", "p99"), ("max", "max")] {
        ledger.insert(format!("usb_interrupt_{key}_instructions"), run.calls(USB, statistic)?);
    }
    let share = run.moving(USB)? / run.seconds_moving()? / INSTRUCTIONS_PER_S;
    ledger.insert("usb_percent".into(), (share * 10_000.0).round() / 100.0);
    Ok(())
}

fn network_jobs(machines: &Machines) -> Vec<Job> {
    let job = |traffic| {
        Job::new(format!("network-{traffic}"), &machines.with_network(), jobs::watched()).with_network(traffic)
    };
    TRAFFIC.into_iter().map(job).collect()
}

/// The network's share of the processor while three motors run: its interrupt, and the executor's work for it
/// with consoles' bytes, but without what the visitors' lines do.
fn network(results: &Results, ledger: &mut Ledger) -> Result<()> {
    for traffic in TRAFFIC {
        let run = results.of(&format!("network-{traffic}"))?;
        let late = run.number(&["functions", LATE, "calls"])?;
        ensure!(late == 0.0, "{late} steps were late with a network: {traffic}");
        let instructions = run.moving(ETHERNET)? + run.moving(NETWORK)?;
        ensure!(instructions > 0.0, "the network was never looked at");
        let share = instructions / run.seconds_moving()? / INSTRUCTIONS_PER_S;
        ledger.insert(format!("network_{traffic}_percent"), (share * 10_000.0).round() / 100.0);
        if traffic == "flood" {
            ledger.insert("network_turn_max_instructions".into(), run.calls(NETWORK, "max")?);
        }
    }
    Ok(())
}

/// The highest rate at which no step comes late and none is put off, with everything else running; and what
/// happens then.
fn sustained(bench: &Bench<'_>, machines: &Machines, ledger: &mut Ledger) -> Result<()> {
    let name = |rate: u32| format!("loaded-{rate}");
    let job = |rate: u32| Job::new(name(rate), &machines.fastest(), jobs::loaded(rate)).under_load();
    // Two at a time: there are two processors nearly everywhere.
    for rates in RATES.chunks(2) {
        let results = bench.run(rates.iter().map(|&rate| job(rate)).collect())?;
        let mut fast_enough = None;
        for &rate in rates.iter().rev() {
            let Ok(run) = results.of(&name(rate)) else { continue };
            if keeps_up(run, rate)? {
                fast_enough = Some((rate, run));
            }
        }
        let Some((rate, run)) = fast_enough else { continue };
        ledger.insert("sustained_steps_per_s".into(), (f64::from(rate) * LOADED_AXES).round());
        let load = run.while_moving()? / run.seconds_moving()? / INSTRUCTIONS_PER_S;
        ledger.insert("sustained_load_percent".into(), round(load * 100.0));
        ledger.insert("queue_depth_ms".into(), run.number(&["moving", "ahead_ns_min"])?.round() / 1e6);
        ledger.insert("masked_window_max_instructions".into(), masked(run)?);
        ledger.insert("feed_run_max_loaded_instructions".into(), run.calls(FEED, "max")?);
        ledger.insert("heat_tick_max_instructions".into(), run.calls(HEAT, "max")?);
        let heat = run.moving(HEAT)? / run.seconds_moving()? / INSTRUCTIONS_PER_S;
        ledger.insert("heat_percent".into(), (heat * 10_000.0).round() / 100.0);
        ledger.insert("heat_guard_max_instructions".into(), run.calls(GUARD, "max")?);
        ledger.insert("console_byte_max_instructions".into(), run.calls(BYTES, "max")?);
        return Ok(());
    }
    bail!("late steps even at {} steps/s a motor", RATES[RATES.len() - 1])
}

/// No step was late, the queue never ran dry, and the stroke took no longer than it must.
fn keeps_up(run: &Measured, rate: u32) -> Result<bool> {
    let late = run.number(&["functions", LATE, "calls"])?;
    let least_s = jobs::loaded_seconds(rate);
    // Work of the feed ahead of the first step counts as moving.
    let in_time = run.seconds_moving()? - 0.002 <= least_s * 1.005;
    Ok(late == 0.0 && in_time && run.number(&["moving", "ahead_ns_min"])? > 0.0)
}

fn round(number: f64) -> f64 {
    (number * 10.0).round() / 10.0
}
