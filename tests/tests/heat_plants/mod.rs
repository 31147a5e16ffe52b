//! Heat safety over many heaters, sound and broken: no sound one is stopped, whatever blows or flows; every
//! broken one is, and how soon, beside what the rules of others need on the same readings.
//!
//! `cargo test -p scenarios heat_plants:: -- --nocapture` prints the table of `docs/heat_safety.md`.

pub mod plants;
mod rules;

use std::collections::BTreeMap;
use std::thread;

use base::ports::{SensorReading, SensorReadings, heater_bit};
use plants::{Chance, KINDS, Kind};
use rules::{Klipper, Marlin, Prusa, Seen};
use sim::models::heater::{Heater, Plant};
use sim::models::thermistor::{Curve, Wiring, divider_volts};
use thermal::{HeatControl, HeatFault, HeaterSettings};
use units::{Celsius, HeaterId, Micros};

const AIR_C: f64 = 23.0;
/// Time at which the target is set, s.
const SET_S: f64 = 2.0;

/// Kind of fault in a heater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Broken {
    SensorOpen,
    SensorShorted,
    /// The sensor slides out: it comes to feel some of the air.
    SensorSlips,
    SensorJumps,
    /// The reading stays at its last value.
    SensorFreezes,
    HeaterOpen,
    /// The heater's MOSFET conducts all the time.
    HeaterOn,
    /// The sensors of two heaters are in each other's plugs.
    PlugsSwapped,
}

/// Phase of a heater's run in which the fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum During {
    Start,
    WarmingUp,
    Holding,
    Off,
}

struct Fault {
    broken: Broken,
    at_s: f64,
    /// Share of air that a slipping sensor feels, 0 to 1, and the time constant, s.
    slip: (f64, f64),
}

/// Gains that suit a plant of first order whose sensor lags, in the parallel form (S. Skogestad, "Simple
/// analytic rules for model reduction and PID controller tuning", J. Process Control 13, 2003).
fn gains(plant: &Plant) -> [f64; 3] {
    let (gain, slow) = (plant.power_w / plant.loss_w_per_k / 255.0, plant.capacity_j_per_k / plant.loss_w_per_k);
    let lag = plant.sensor_lag_s;
    let closed_loop = 2.0 * lag;
    let p = slow / (gain * closed_loop);
    [p, p / slow.min(4.0 * closed_loop), p * lag]
}

/// Highest temperature a person would allow.
fn max_c(kind: &Kind) -> f64 {
    if kind.is_bed { 120.0 } else { 300.0 }
}

/// Settings as a person would write them: of safety, `max_temp` and how long a slow heater may take.
fn settings(kind: &Kind) -> HeaterSettings {
    let name = if kind.is_bed { "bed" } else { "hotend" };
    let [p, i, d] = gains(&kind.plant);
    let text = format!(
        "[temperature control]\n{name}.enable = true\n{name}.thermistor_pin = ADC1_1\n{name}.thermistor = Semitec\n\
         {name}.heater_pin = PE0\n{name}.max_temp = {}\n{name}.runaway_heating_timeout = {:.0}\n\
         {name}.p_factor = {p:.4}\n{name}.i_factor = {i:.4}\n{name}.d_factor = {d:.4}\n",
        max_c(kind),
        60.0 + 2.0 * rise_s(kind),
    );
    let (machine, _) = config::parse(text.as_bytes(), config::BoardId::default(), &mut ());
    HeaterSettings::from(&machine.temperatures[0])
}

/// A heater of a kind, its disturbances, and its fault.
struct Body {
    kind: Kind,
    heater: Heater,
    /// Share of the sensor that feels the air.
    out: f64,
    frozen: Option<f64>,
    jump: f64,
    jump_until: f64,
    drive: f64,
}

impl Body {
    fn new(kind: Kind) -> Self {
        let heater = Heater::new(kind.plant, AIR_C);
        Self { kind, heater, out: 0.0, frozen: None, jump: 0.0, jump_until: 0.0, drive: 0.0 }
    }

    /// Returns the temperature that the sensor feels; none for an open or shorted sensor.
    fn felt(&mut self, second: f64, fault: Option<&Fault>, chance: &mut Chance) -> Option<f64> {
        let felt = self.heater.sensor_c() * (1.0 - self.out) + AIR_C * self.out;
        match fault.filter(|fault| second >= fault.at_s) {
            Some(Fault { broken: Broken::SensorOpen | Broken::SensorShorted, .. }) => return None,
            Some(Fault { broken: Broken::SensorSlips, slip: (share, seconds), .. }) => {
                self.out += (share - self.out) * STEP_S / seconds;
            }
            Some(Fault { broken: Broken::SensorFreezes, .. }) => return Some(*self.frozen.get_or_insert(felt)),
            Some(Fault { broken: Broken::SensorJumps, .. }) if second >= self.jump_until => {
                self.jump = if self.jump > 0.0 { 0.0 } else { chance.between(9.0, 25.0) };
                self.jump_until = second + chance.between(0.3, 1.0);
            }
            _ => {}
        }
        Some(felt - self.jump + chance.between(-0.05, 0.05))
    }

    fn pass(&mut self, second: f64, fault: Option<&Fault>, weather: &Weather) {
        let drive = match fault.filter(|fault| second >= fault.at_s).map(|fault| fault.broken) {
            Some(Broken::HeaterOpen) => 0.0,
            Some(Broken::HeaterOn) => 1.0,
            _ => self.drive,
        };
        // Filament takes heat only where it melts.
        let melts = !self.kind.is_bed && self.heater.body_c() > 170.0;
        let flow = if melts { weather.flow_w / self.kind.plant.power_w } else { 0.0 };
        self.heater.pass(STEP_S, drive * weather.supply - flow, weather.fan, AIR_C + weather.draft_c);
    }
}

/// Disturbances of a heater.
#[derive(Clone, Copy, Default)]
struct Weather {
    fan: f64,
    /// Heat taken by melting filament, watts.
    flow_w: f64,
    draft_c: f64,
    /// Share of nominal power.
    supply: f64,
    until: f64,
}

impl Weather {
    /// Changes the disturbances now and then.
    fn pass(&mut self, second: f64, chance: &mut Chance) {
        if second < self.until {
            return;
        }
        let fan = if chance.share() < 0.5 { 0.0 } else { chance.share() };
        let flow_w = if chance.share() < 0.5 { 0.0 } else { chance.between(1.0, 6.0) };
        let (draft_c, supply) = (chance.between(-8.0, 4.0), chance.between(0.92, 1.05));
        *self = Self { fan, flow_w, draft_c, supply, until: second + chance.between(5.0, 60.0) };
    }
}

const STEP_S: f64 = 0.01;
/// Runs of the modulators in a step.
const MODULATIONS: u32 = 20;

/// Results of one run: times of detection, and the fault reported.
struct Run {
    found: Option<(f64, HeatFault)>,
    marlin: Option<f64>,
    klipper: Option<f64>,
    prusa: Option<f64>,
    /// Temperature at the end, C.
    reading_c: f64,
    /// Greatest excess over the target from the fault until its detection, C.
    over_c: f64,
}

/// A heater of this kind and an idle one of another beside it, on from [`SET_S`] to `off_s`.
fn run(kind: &Kind, beside: &Kind, seconds: f64, off_s: f64, fault: Option<&Fault>, chance: &mut Chance) -> Run {
    let mut control = HeatControl::new();
    let ids: Vec<HeaterId> = [kind, beside].map(|kind| control.add(settings(kind)).expect("room")).into();
    control.enable_outputs();
    let curve = Curve::of_part("Semitec").expect("a part");
    let counts = |felt: Option<f64>, shorted: bool| {
        let wiring = match (felt, shorted) {
            (Some(_), _) => Wiring::Sound,
            (None, true) => Wiring::Shorted,
            (None, false) => Wiring::Open,
        };
        let volts = divider_volts(&curve, felt.unwrap_or(AIR_C), wiring);
        SensorReading::Counts((volts / 3.3 * 65_535.0).round().clamp(0.0, 65_535.0) as u16)
    };
    let (mut body, mut other, mut weather) = (Body::new(*kind), Body::new(*beside), Weather::default());
    let (mut marlin, mut klipper) = (Marlin::new(kind.is_bed, max_c(kind)), Klipper::new(kind.is_bed, max_c(kind)));
    let mut prusa = Prusa::new(&kind.plant, kind.is_bed, AIR_C);
    let mut run = Run { found: None, marlin: None, klipper: None, prusa: None, reading_c: AIR_C, over_c: 0.0 };
    let is_shorted = fault.is_some_and(|fault| fault.broken == Broken::SensorShorted);
    let is_swapped = fault.is_some_and(|fault| fault.broken == Broken::PlugsSwapped);
    for step in 0..(seconds / STEP_S) as u32 {
        let second = f64::from(step) * STEP_S;
        let now = Micros((second * 1e6) as u64 + 1);
        let target = if (SET_S..off_s).contains(&second) { kind.target_c } else { 0.0 };
        control.executor_alive(now);
        // The others' rules are to see the heater as it would go on.
        if control.is_halted() {
            control.release();
        }
        control.set_target(ids[0], Celsius(target as f32)).expect("it is allowed");
        let (mut felt, mut felt_beside) = (body.felt(second, fault, chance), other.felt(second, None, chance));
        if is_swapped {
            std::mem::swap(&mut felt, &mut felt_beside);
        }
        let mut readings = SensorReadings::default();
        (readings[0], readings[1]) = (counts(felt, is_shorted), counts(felt_beside, false));
        control.tick(now, &readings);
        run.reading_c = felt.unwrap_or(run.reading_c);
        if run.found.is_none() {
            run.found = control.take_fault().map(|fault| (second, fault));
        }
        if run.found.is_none() && fault.is_some_and(|fault| second >= fault.at_s) {
            run.over_c = run.over_c.max(body.heater.body_c() - kind.target_c);
        }
        let seen = Seen { second, reading: felt, target, driven: body.drive, fan: weather.fan };
        if let Some(prusa) = &mut prusa {
            run.prusa = run.prusa.or_else(|| prusa.trips(seen).then_some(second));
        }
        if step % 10 == 0 {
            run.marlin = run.marlin.or_else(|| marlin.trips(seen).then_some(second));
            run.klipper = run.klipper.or_else(|| klipper.trips(seen).then_some(second));
        }
        let on: Vec<u32> = (0..MODULATIONS).map(|_| control.modulation_tick().on).collect();
        let share = |bit: u32| on.iter().filter(|on| **on & bit != 0).count() as f64 / f64::from(MODULATIONS);
        (body.drive, other.drive) = (share(heater_bit(0)), share(heater_bit(1)));
        weather.pass(second, chance);
        body.pass(second, fault, &weather);
        other.pass(second, None, &Weather { supply: 1.0, ..Weather::default() });
        let all = run.marlin.is_some() && run.klipper.is_some() && (run.prusa.is_some() || prusa.is_none());
        if run.found.is_some() && (all || fault.is_none()) {
            break;
        }
    }
    run
}

/// Returns a variant of a kind that can hold its target whatever the weather.
fn sound(kind: &Kind, chance: &mut Chance) -> Kind {
    loop {
        let one = chance.one_of(kind);
        let plant = &one.plant;
        let lost = (plant.loss_w_per_k + plant.fan_loss_w_per_k) * (one.target_c - AIR_C + 8.0) + 6.0;
        if lost < 0.8 * plant.power_w {
            return one;
        }
    }
}

/// Runs all cases on all processors.
fn all<T: Send>(cases: usize, one: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let one = &one;
    let mut done: Vec<(usize, T)> = thread::scope(|scope| {
        let share = |worker: usize| move || (worker..cases).step_by(workers).map(|case| (case, one(case))).collect();
        let running: Vec<_> = (0..workers).map(|worker| scope.spawn(share(worker))).collect();
        running.into_iter().flat_map(|worker| -> Vec<(usize, T)> { worker.join().expect("no panic") }).collect()
    });
    done.sort_by_key(|(case, _)| *case);
    done.into_iter().map(|(_, result)| result).collect()
}

fn beside(kind: &Kind) -> &'static Kind {
    if kind.is_bed { &KINDS[2] } else { &KINDS[8] }
}

/// To the target, held in bad weather, and off.
#[test]
fn no_sound_heater_is_stopped() {
    let stopped = all(200, |case| {
        let mut chance = Chance::new(case as u64 + 1);
        let kind = sound(&KINDS[case % KINDS.len()], &mut chance);
        let hold_s = if kind.is_bed { 500.0 } else { 300.0 };
        let run = run(&kind, beside(&kind), hold_s + 60.0, hold_s, None, &mut chance);
        let found = run.found.map(|found| format!("case {case}, {kind:?}: {found:?}"));
        (found, [run.marlin, run.klipper, run.prusa].map(|second| second.is_some()))
    });
    let others = |rule: usize| stopped.iter().filter(|(_, tripped)| tripped[rule]).count();
    println!(
        "stopped of 200 sound ones: Velvet {}, Marlin's rules {}, Klipper's {}, Prusa's {} (of 119 hot ends)",
        stopped.iter().filter(|(found, _)| found.is_some()).count(),
        others(0),
        others(1),
        others(2)
    );
    let found: Vec<&String> = stopped.iter().filter_map(|(found, ..)| found.as_ref()).collect();
    assert!(found.is_empty(), "{found:#?}");
}

/// Faults, and the phase of a heater's run in which each begins.
const CASES: [(Broken, During); 17] = [
    (Broken::SensorOpen, During::WarmingUp),
    (Broken::SensorOpen, During::Holding),
    (Broken::SensorShorted, During::WarmingUp),
    (Broken::SensorShorted, During::Holding),
    (Broken::SensorSlips, During::WarmingUp),
    (Broken::SensorSlips, During::Holding),
    (Broken::SensorJumps, During::WarmingUp),
    (Broken::SensorJumps, During::Holding),
    (Broken::SensorFreezes, During::Start),
    (Broken::SensorFreezes, During::WarmingUp),
    (Broken::SensorFreezes, During::Holding),
    (Broken::HeaterOpen, During::Start),
    (Broken::HeaterOpen, During::WarmingUp),
    (Broken::HeaterOpen, During::Holding),
    (Broken::HeaterOn, During::Holding),
    (Broken::HeaterOn, During::Off),
    (Broken::PlugsSwapped, During::Start),
];

/// Returns the time a heater of this kind takes to its target at full power.
fn rise_s(kind: &Kind) -> f64 {
    let plant = &kind.plant;
    let (slow, top) = (plant.capacity_j_per_k / plant.loss_w_per_k, plant.power_w / plant.loss_w_per_k);
    -slow * (1.0 - (kind.target_c - AIR_C) / top).ln()
}

/// A broken heater, and the results of its run.
struct Outcome {
    is_bed: bool,
    broken: Broken,
    during: During,
    /// Time of detection, seconds after the fault or switching on; and times by the rules of other firmwares.
    found: Option<f64>,
    others: [Option<f64>; 3],
    over_c: f64,
    told: String,
}

fn broken(case: usize) -> Outcome {
    let (broken, during) = CASES[case % CASES.len()];
    let mut chance = Chance::new(10_000 + case as u64);
    let kind = sound(&KINDS[(case / CASES.len()) % KINDS.len()], &mut chance);
    let arrives_s = SET_S + rise_s(&kind) * 1.2 + 30.0;
    let (at_s, off_s) = match during {
        During::Start => (0.0, f64::MAX),
        During::WarmingUp => (SET_S + rise_s(&kind) * chance.between(0.2, 0.6), f64::MAX),
        During::Holding => (arrives_s + chance.between(30.0, 60.0), f64::MAX),
        During::Off => (arrives_s + chance.between(60.0, 120.0), arrives_s),
    };
    let fault = Fault { broken, at_s, slip: (chance.between(0.4, 1.0), chance.between(1.0, 8.0)) };
    let began_s = at_s.max(SET_S);
    let run = run(&kind, beside(&kind), began_s + 400.0, off_s, Some(&fault), &mut chance);
    let after = |second: Option<f64>| second.filter(|second| *second >= began_s - 0.01).map(|second| second - began_s);
    Outcome {
        is_bed: kind.is_bed,
        broken,
        during,
        found: after(run.found.map(|(second, _)| second)),
        others: [run.marlin, run.klipper, run.prusa].map(after),
        over_c: run.over_c,
        told: format!(
            "case {case}, {broken:?} {during:?}, {}: {:?}, ends at {:.1} C",
            kind.name, run.found, run.reading_c
        ),
    }
}

/// Returns the seconds within which a fault must be found: hot ends, and beds, whose heat comes and goes
/// slowly.
const fn limit_s(broken: Broken, during: During, is_bed: bool) -> f64 {
    match (broken, during, is_bed) {
        (Broken::SensorOpen | Broken::SensorShorted, ..) => 0.5,
        (Broken::PlugsSwapped, _, false) => 12.0,
        (Broken::PlugsSwapped, _, true) => 60.0,
        (_, _, false) => 60.0,
        // Cooling by 2 C takes a minute, and a minute at full output follows.
        (_, _, true) => 240.0,
    }
}

/// Excess over the target, C, beyond which an undetected fault counts as missed. A reading that freezes at
/// the target is detected by the response of the control, which depends on its distance from the target:
/// until then the heater must not become much hotter.
const FROZEN_OVER_C: f64 = 30.0;

impl Outcome {
    fn is_missed(&self) -> bool {
        if (self.broken, self.during) == (Broken::SensorFreezes, During::Holding) {
            return self.over_c > FROZEN_OVER_C;
        }
        self.found.is_none_or(|second| second > limit_s(self.broken, self.during, self.is_bed))
    }
}

#[test]
fn every_broken_heater_is_found() {
    let runs = all(CASES.len() * KINDS.len() + 8, broken);
    let mut table = BTreeMap::<_, Vec<&Outcome>>::new();
    for run in &runs {
        table.entry((run.broken, run.during, run.is_bed)).or_default().push(run);
    }
    println!("| broken | while | heater | runs | Velvet | Marlin's rules | Klipper's rules | Prusa's model |");
    println!("|---|---|---|--:|--:|--:|--:|--:|");
    for ((broken, during, is_bed), runs) in table {
        let velvet = shown(runs.iter().map(|run| run.found).collect());
        let others = [0, 1, 2].map(|rule| shown(runs.iter().map(|run| run.others[rule]).collect()));
        let [marlin, klipper, prusa] = &others;
        let (heater, prusa) = if is_bed { ("bed", "&ndash;") } else { ("hot end", prusa.as_str()) };
        println!("| {broken:?} | {during:?} | {heater} | {} | {velvet} | {marlin} | {klipper} | {prusa} |", runs.len());
    }
    let frozen = runs.iter().filter(|run| (run.broken, run.during) == (Broken::SensorFreezes, During::Holding));
    let most_c = frozen.map(|run| run.over_c).fold(0.0, f64::max);
    println!("held at a frozen reading: at most {most_c:.1} C above the target");
    let missed: Vec<_> = runs.iter().filter(|run| run.is_missed()).collect();
    let words = missed.iter().map(|run| format!("{}: after {:?} s, {:.1} C over", run.told, run.found, run.over_c));
    assert!(missed.is_empty(), "{:#?}", words.collect::<Vec<_>>());
}

/// The one fault that no other rule tells of: a bed whose sensor comes half out while it warms reaches its
/// target, and is far hotter.
#[test]
fn a_bed_whose_sensor_slides_out_while_it_warms_is_told_by_its_stall() {
    let runs = all(100, |case| {
        let mut chance = Chance::new(777_000 + case as u64);
        let kind = sound(&KINDS[7 + case % 5], &mut chance);
        let at_s = SET_S + rise_s(&kind) * chance.between(0.2, 0.6);
        let slip = (chance.between(0.4, 1.0), chance.between(1.0, 8.0));
        let fault = Fault { broken: Broken::SensorSlips, at_s, slip };
        let run = run(&kind, beside(&kind), at_s + 300.0, f64::MAX, Some(&fault), &mut chance);
        let found = run.found.map(|(second, _)| second - at_s);
        (
            found,
            format!(
                "case {case}, {} of {:.0} s, at {at_s:.1} s, {slip:?}: {:.1} C over",
                kind.name,
                rise_s(&kind),
                run.over_c
            ),
        )
    });
    let missed: Vec<_> = runs.iter().filter(|(found, _)| found.is_none()).collect();
    println!(
        "{} of 100 missed: {missed:#?}; the others {}",
        missed.len(),
        shown(runs.iter().map(|run| run.0).collect())
    );
    assert!(missed.len() <= 2, "{missed:#?}");
}

/// Returns median and worst of the times, and how many faults were never found.
fn shown(mut times: Vec<Option<f64>>) -> String {
    times.sort_by(|a, b| a.unwrap_or(f64::MAX).total_cmp(&b.unwrap_or(f64::MAX)));
    let found: Vec<f64> = times.iter().flatten().copied().collect();
    let missed = times.len() - found.len();
    let missed = if missed > 0 { format!(", {missed} never") } else { String::new() };
    match (found.get(found.len() / 2), found.last()) {
        (Some(median), Some(worst)) => format!("{median:.1} s, {worst:.1} s{missed}"),
        _ => "never".to_string(),
    }
}
