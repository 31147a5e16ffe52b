//! The periodic tasks of the board, run by hand: heat and modulation, step feed, slow watch; and the player
//! of step events that stands in for the step interrupt.

use base::ports::{
    Input, InputLevels, OutputLevels, SensorReading, SensorReadings, SupplyVoltages, heater_bit, switch_bit,
};
use base::tasks::{FeedTask, HEAT_PERIOD_US, HeatIo, HeatTask};
use config::{MachineConfig, SensorKind};
use units::{Actuator, Direction, Micros, TICK_NANOSECONDS, Ticks};

use super::shared::Shared;
use super::verify::{Watch, Watched};
use crate::world::World;

/// The period of the board's fastest periodic tasks.
pub const SLOT_NS: u64 = HEAT_PERIOD_US as u64 * 1_000;
/// ADC3 inputs behind the board's names ADC3_0 to ADC3_5.
const VOLTAGE_CHANNELS: [u8; 6] = [10, 6, 7, 8, 9, 16];
/// Temperature of a chip that has little to do, degrees Celsius.
pub const CHIP_C: f32 = 30.0;
/// Reference of the converters, volts.
const REFERENCE_V: f32 = 3.3;
/// Voltage of the clock's cell.
const CELL_V: f32 = 3.0;

/// Mapping of the world's switches to the machine's inputs, and further settings that the tasks need.
pub struct Inputs {
    /// Machine inputs, by the world's index of the switch.
    inputs: Vec<Option<Input>>,
    /// World's index of the fan that a switch drives, by the place of the switch in the configuration.
    fans: Vec<Option<usize>>,
}

impl Inputs {
    /// Returns the mapping for a machine and the world around it.
    pub fn of(machine: &MachineConfig, world: &World) -> Self {
        let input = |name: &str| {
            let endstop = machine.endstops.iter().position(|stop| stop.name == name).map(|n| Input::Endstop(n as u8));
            let switch = machine.switches.iter().position(|switch| switch.name == name);
            let button = machine.buttons.iter().position(|button| button.name == name);
            if let Some(motor) = name.strip_prefix("stall ").and_then(Actuator::from_name) {
                return Some(Input::Stall(motor as u8));
            }
            match name {
                "probe" => Some(Input::Probe),
                "probe deployed" => Some(Input::ProbeDeployed),
                "kill" => Some(Input::Kill),
                "door" => Some(Input::Door),
                "filament" => Some(Input::Filament),
                "filament wheel" => Some(Input::FilamentWheel),
                _ => endstop.or(switch.map(|n| Input::Switch(n as u8))).or(button.map(|n| Input::Button(n as u8))),
            }
        };
        let world_config = world.config();
        let fan = |name: &str| world_config.fans.iter().position(|fan| fan.name == name);
        Self {
            inputs: world_config.switches.iter().map(|switch| input(&switch.name)).collect(),
            fans: machine.switches.iter().map(|switch| fan(&switch.name)).collect(),
        }
    }

    /// Returns the number of the input that fires when a switch of the world changes so.
    fn fired(&self, switch: usize, operated: bool) -> Option<u8> {
        let input = match self.inputs.get(switch).copied().flatten()? {
            Input::Probe if !operated => Input::ProbeOpen,
            input if operated => input,
            _ => return None,
        };
        Some(input.number())
    }
}

/// Phase of the feed's runs while a switch is searched for.
///
/// The feed sees a switch that fires within microseconds of its run in that run or in the next one; a
/// segment that ends within microseconds of the end of writing is taken or left. The brake begins
/// accordingly, a segment sooner or later. Here the feed runs exactly on its grid; on the board interrupts
/// have their entry and jitter, so all of that may happen there and is right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FeedPhase {
    /// Feed on the grid.
    #[default]
    Exact,
    /// Feed [`PHASE_NS`] before the grid.
    Before,
    /// Feed [`PHASE_NS`] after the grid.
    After,
}

/// Shift of the phases of [`FeedPhase`].
const PHASE_NS: u64 = 20_000;

/// Time from an edge of an input to its interrupt: steps that are due by then are still played, also if the
/// motors have to stop at once. On the board such steps share the step interrupt with the step that closed
/// the switch.
const REACTION_NS: u64 = 1_000;

/// Input that has fired, and whose interrupt is about to run.
#[derive(Clone, Copy, Debug)]
struct Firing {
    input: u8,
    /// Tick of the clock stamped on the event.
    tick: u32,
    at_ns: u64,
}

/// State of all tasks.
pub struct Tasks {
    feed: FeedTask,
    inputs: Inputs,
    heat: HeatTask,
    present: OutputLevels,
    /// Observer of every piece of trajectory and every edge, when asked for.
    pub watch: Option<Watch>,
    /// Phase of the feed by the number of the search for a switch.
    pub phases: Vec<FeedPhase>,
    /// Number of searches begun so far, and whether one is under way.
    searches: (usize, bool),
    /// Trigger that stops the motors at once, as soon as its interrupt has run.
    firing: Option<Firing>,
    /// Triggers that the next run of the feed has yet to miss: input and tick.
    withheld: Vec<(u8, u32)>,
    /// Number of runs that the feed misses, as if something kept it from running.
    pub missed_runs: u32,
}

impl Tasks {
    /// Creates the tasks at power-on.
    pub fn new(inputs: Inputs) -> Self {
        let present = OutputLevels::default();
        Self {
            feed: FeedTask::default(),
            inputs,
            heat: HeatTask::new(),
            present,
            watch: None,
            phases: Vec::new(),
            searches: (0, false),
            firing: None,
            withheld: Vec::new(),
            missed_runs: 0,
        }
    }

    /// Runs a slot's tasks, in the order of their priorities.
    pub fn periodic(&mut self, shared: &Shared) {
        self.heat(shared);
        self.count_searches(shared);
        let now_ns = shared.simulation.now_ns.get();
        // A motion begins on the grid: only the time between its beginning and the present matters.
        let moving = shared.motion.borrow().current_block().is_some();
        match self.phase() {
            FeedPhase::After if moving => {
                self.play_events(shared, now_ns + PHASE_NS);
                self.step_feed(shared, now_ns + PHASE_NS);
            }
            FeedPhase::Before if moving => self.step_feed(shared, now_ns - PHASE_NS),
            _ => self.step_feed(shared, now_ns),
        }
        for (input, tick) in std::mem::take(&mut self.withheld) {
            shared.latch.report(input, tick, &shared.queue);
        }
    }

    fn count_searches(&mut self, shared: &Shared) {
        let armed = shared.latch.armed() != 0;
        if armed && !self.searches.1 {
            self.searches.0 += 1;
            if let Some(watch) = &mut self.watch {
                watch.search_begins();
            }
        }
        self.searches.1 = armed;
    }

    /// Returns the phase of the search under way, or of the last one: its brake belongs to it.
    fn phase(&self) -> FeedPhase {
        let search = self.searches.0.checked_sub(1);
        search.and_then(|search| self.phases.get(search)).copied().unwrap_or_default()
    }

    fn heat(&mut self, shared: &Shared) {
        let now = Micros(shared.simulation.now_ns.get() / 1_000);
        let mut io = HeatPins { inputs: &self.inputs, present: &mut self.present, shared };
        let due = self.heat.run(now, &shared.reached, &mut shared.heat.borrow_mut(), &mut io);
        if due.slow {
            slow(shared);
        }
        if due.controlled {
            shared.sensors.borrow_mut().run(now);
        }
    }

    fn step_feed(&mut self, shared: &Shared, now_ns: u64) {
        if self.missed_runs > 0 {
            self.missed_runs -= 1;
            return;
        }
        let now = ticks(now_ns);
        let armed = shared.latch.armed();
        if armed != 0 {
            let levels = self.levels(shared).mask();
            for number in 0..u32::BITS {
                if armed & levels & (1 << number) != 0 {
                    shared.latch.report(number as u8, now.0 as u32, &shared.queue);
                }
            }
        }
        let mut motion = shared.motion.borrow_mut();
        if let Some(watch) = &mut self.watch {
            watch.look(&motion);
        }
        let mut watched = Watched { motion: &mut motion, watch: self.watch.as_mut() };
        self.feed.run(now, &mut watched, &shared.queue, &shared.latch, &shared.reached);
        if let Some(watch) = &mut self.watch {
            watch.look(&motion);
        }
    }

    /// Returns the levels of the inputs, in the machine's numbering.
    fn levels(&self, shared: &Shared) -> InputLevels {
        let world = shared.simulation.world.borrow();
        let mut levels = InputLevels::default();
        for (index, input) in self.inputs.inputs.iter().enumerate() {
            let operated = world.switch_high(index) == world.config().switches[index].operated_high;
            levels = match *input {
                Some(input) if operated => levels.with(input),
                Some(Input::Probe) => levels.with(Input::ProbeOpen),
                _ => levels,
            };
        }
        levels
    }

    /// Plays every step event due up to `until_ns`, each at its tick.
    pub fn play_until(&mut self, shared: &Shared, until_ns: u64) {
        self.play_events(shared, until_ns);
        let mut world = shared.simulation.world.borrow_mut();
        world.advance(until_ns);
        drop(world);
        self.report_other_changes(shared);
        shared.levels.set(self.levels(shared));
    }

    fn play_events(&mut self, shared: &Shared, until_ns: u64) {
        let start = ticks(shared.simulation.now_ns.get());
        // Motors that stand at once stand whether or not the feed has seen the reason.
        let stands = |tasks: &Self| shared.latch.is_hard() && !tasks.withheld.is_empty();
        while let Some(event) = shared.queue.front().filter(|_| !stands(self)) {
            // The queue holds the low half of the clock; a due event lies at most a horizon away from now.
            let ahead = event.at.wrapping_sub(start.0 as u32) as i32;
            let at = start.0.saturating_add_signed(i64::from(ahead)).max(start.0);
            let at_ns = at * u64::from(TICK_NANOSECONDS);
            if at_ns > until_ns || self.firing.is_some_and(|firing| at_ns > firing.at_ns + REACTION_NS) {
                break;
            }
            if let Some(watch) = &mut self.watch {
                watch.played(event, at_ns);
            }
            self.play(shared, event, at_ns);
            shared.queue.advance();
        }
        if let Some(Firing { input, tick, at_ns }) = self.firing.take() {
            self.report(shared, input, tick, at_ns);
        }
    }

    /// Reports an input's interrupt: at once, or after the run of the feed that has to miss it.
    fn report(&mut self, shared: &Shared, input: u8, tick: u32, at_ns: u64) {
        if self.phase() == FeedPhase::Before && SLOT_NS - at_ns % SLOT_NS < PHASE_NS {
            self.withheld.push((input, tick));
        } else {
            shared.latch.report(input, tick, &shared.queue);
        }
    }

    fn play(&mut self, shared: &Shared, event: motion::queue::StepEvent, at_ns: u64) {
        let mut world = shared.simulation.world.borrow_mut();
        if let Some(duty) = event.laser_duty() {
            return world.set_laser(at_ns, duty);
        }
        for actuator in Actuator::ALL {
            if event.turning_forward() & actuator.bit() != 0 {
                world.turn(at_ns, actuator, Direction::Forward);
            }
            if event.turning_backward() & actuator.bit() != 0 {
                world.turn(at_ns, actuator, Direction::Backward);
            }
            if event.stepping() & actuator.bit() != 0 {
                world.step(at_ns, actuator);
            }
        }
        if world.has_switch_changes() {
            for change in world.take_switch_changes() {
                let operated = change.high == world.config().switches[change.switch].operated_high;
                let Some(input) = self.inputs.fired(change.switch, operated) else { continue };
                // Not every input can be armed: a filament detector cannot.
                let bit = 1_u32.checked_shl(u32::from(input)).unwrap_or(0);
                if shared.latch.is_hard() && shared.latch.armed() & bit != 0 {
                    self.firing.get_or_insert(Firing { input, tick: event.at, at_ns });
                } else {
                    self.report(shared, input, event.at, at_ns);
                }
            }
        }
    }

    /// Reports changes of switches that no step caused: contacts that bounce, buttons that are pressed.
    fn report_other_changes(&self, shared: &Shared) {
        let mut world = shared.simulation.world.borrow_mut();
        for change in world.take_switch_changes() {
            let operated = change.high == world.config().switches[change.switch].operated_high;
            if let Some(number) = self.inputs.fired(change.switch, operated) {
                shared.latch.report(number, ticks(change.at_ns).0 as u32, &shared.queue);
            }
        }
    }
}

/// Returns the step clock at a time.
const fn ticks(now_ns: u64) -> Ticks {
    Ticks(now_ns / TICK_NANOSECONDS as u64)
}

fn readings(shared: &Shared) -> SensorReadings {
    let mut readings = SensorReadings::default();
    let wired = shared.wired.borrow();
    let Some(config) = wired.as_ref() else { return readings };
    let (world, sensors) = (shared.simulation.world.borrow(), shared.sensors.borrow());
    let now = Micros(shared.simulation.now_ns.get() / 1_000);
    for (place, (reading, (sensor, controller))) in
        readings.iter_mut().zip(world.config().heaters.iter().zip(&config.temperatures)).enumerate()
    {
        *reading = match (sensor.sensor, controller.sensor.kind) {
            (_, SensorKind::Chip) => SensorReading::MilliDegrees((CHIP_C * 1e3) as i32),
            (_, kind) if kind.is_on_spi() => sensors.reading(place, now),
            (Some(input), kind) if kind.is_analog() => SensorReading::Counts(world.adc_counts(input)),
            _ => SensorReading::Missing,
        };
    }
    readings
}

/// Returns a named voltage monitor of the wired configuration.
pub fn voltage(shared: &Shared, name: &str) -> Option<units::Volts> {
    match name {
        "vref" => return Some(units::Volts(REFERENCE_V)),
        "vbat" => return Some(units::Volts(CELL_V)),
        _ => {}
    }
    let wired = shared.wired.borrow();
    let monitor = wired.as_ref()?.voltages.iter().find(|monitor| monitor.name == name)?;
    let channel = *VOLTAGE_CHANNELS.get(usize::from(monitor.input.0))?;
    let counts = shared.simulation.world.borrow().adc_counts(crate::world::AnalogInput { converter: 3, channel });
    Some(units::Volts(f32::from(counts) / 65_535.0 * REFERENCE_V * monitor.scale))
}

fn slow(shared: &Shared) {
    let supply = SupplyVoltages { motor: voltage(shared, "vmotor"), fets: voltage(shared, "vfet") };
    let mut bank = shared.bank.borrow_mut();
    shared.supervisor.borrow_mut().tick(
        Micros(shared.simulation.now_ns.get() / 1_000),
        &mut *bank,
        supply,
        shared.events(),
    );
}

/// Pins of the heat task.
struct HeatPins<'a> {
    inputs: &'a Inputs,
    present: &'a mut OutputLevels,
    shared: &'a Shared,
}

impl HeatIo for HeatPins<'_> {
    fn readings(&mut self) -> SensorReadings {
        readings(self.shared)
    }

    fn scan_position(&mut self) -> u32 {
        self.shared.simulation.world.borrow().conversions()
    }

    fn filament_width(&mut self) -> [SensorReading; 2] {
        let world = self.shared.simulation.world.borrow();
        let inputs = world.config().filament_sensor.as_ref().map(|sensor| sensor.inputs).unwrap_or_default();
        inputs.map(|input| match input {
            Some(input) => SensorReading::Counts(world.adc_counts(input)),
            None => SensorReading::Missing,
        })
    }

    fn tachometers(&mut self) -> u8 {
        let wired = self.shared.wired.borrow();
        let Some(config) = wired.as_ref().filter(|config| !config.fans.is_empty()) else { return 0 };
        let world = self.shared.simulation.world.borrow();
        let closed = |fan: &config::FanConfig| {
            let switch = config.switches.iter().position(|switch| switch.name == fan.name);
            let driven = switch.and_then(|switch| self.inputs.fans.get(switch).copied().flatten());
            fan.tachometer.pin.is_some() && driven.is_some_and(|index| world.fan_tachometer(index))
        };
        config.fans.iter().rev().fold(0, |levels, fan| levels << 1 | u8::from(closed(fan)))
    }

    fn apply(&mut self, levels: OutputLevels) {
        if levels == *self.present {
            return;
        }
        let now_ns = self.shared.simulation.now_ns.get();
        let mut world = self.shared.simulation.world.borrow_mut();
        let changed = levels.on ^ self.present.on;
        for index in 0..world.config().heaters.len() {
            if changed & heater_bit(index) != 0 {
                let drive = if levels.on & heater_bit(index) != 0 { 1.0 } else { 0.0 };
                world.heater_duty(now_ns, index, drive);
            }
        }
        for (switch, fan) in self.inputs.fans.iter().enumerate() {
            if let Some(fan) = fan
                && changed & switch_bit(switch) != 0
            {
                let drive = if levels.on & switch_bit(switch) != 0 { 1.0 } else { 0.0 };
                world.fan_duty(now_ns, *fan, drive);
            }
        }
        if levels.fets_enabled != self.present.fets_enabled {
            world.fet_power_pin(now_ns, levels.fets_enabled);
            world.fet_buffer_pin(now_ns, !levels.fets_enabled);
        }
        *self.present = levels;
    }

    fn set_pwm(&mut self, switch: usize, duty: f32) {
        let wired = self.shared.wired.borrow();
        let config = wired.as_ref().and_then(|config| config.switches.get(switch));
        if let Some(config::OutputPin::Pwm(pin)) = config.and_then(|switch| switch.output_pin) {
            let (timer, channel) = (usize::from(pin.timer) - 1, usize::from(pin.channel) - 1);
            self.shared.simulation.world.borrow_mut().pwm(timer, channel, f64::from(duty));
        }
    }
}
