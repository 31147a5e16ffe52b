//! The board as the machine sees it: every port of `machine`, each a few lines onto the board package or an
//! RTIC lock.

use core::fmt::Write;

use base::ports::{
    Ahead, Board, BoardInfo, DriversPort, FilesPort, HeatPort, InputLevels, Inputs, MemoryReport, MotionPort, PinPort,
    PinTaken, Start, StepTimes, Storage, Workspace,
};
use base::sessions::{Consoles, SessionProfile};
use base::sessions::{Inbox, SessionId};
use base::supervisor::{Supervisor, SupervisorPort};
use base::watchdog::Reporter;
use bsp_prime::laser::Laser;
use bsp_prime::led_strip::LedSender;
use bsp_prime::pins::{Input, Output, PinError, Pins};
use bsp_prime::rtc::Rtc;
use bsp_prime::sd::CardService;
use bsp_prime::spi::SpiBuses;
use bsp_prime::uart::{Frame, Parity, UartPort};
use bsp_prime::usb::UsbSocket;
use bsp_prime::{memory, thread_stack, time, wait};
use config::{MachineConfig, OutputPin, Pin};
use heapless::Vec;
use motion::{Latch, Motion};
use rtic::Mutex;
use thermal::HeatControl;
use units::{Celsius, Micros, Ticks, Volts};

use crate::consoles::Console;
use crate::drivers::DriverBank;
use crate::heat_io::{Heat, HeatIo};
use crate::lock_free::{LATCH, REPORTS};
use crate::log::Told;
use crate::network::BoardNetwork;
use crate::rtt_console::Said;
use crate::slow::Slow;
use crate::storage::{CardStorage, card_storage};
use crate::triggers::TriggerInputs;
use crate::update::Updates;
use crate::wiring::{self, Report};
use crate::{executor, usb, workspace};

mod calendar;
mod computer;
mod lights;
mod network;
mod rest;
mod updates;

/// Number of inputs: twelve endstops, sixteen switches, the probe closed, open and deployed, kill button,
/// door, filament and its wheel; the stall outputs of the on-board drivers; buttons.
const MAX_INPUTS: usize = 35 + 4 + config::MAX_BUTTONS;
/// Time for the last replies to leave before a reset that was asked for.
const RESET_DELAY: Micros = Micros::from_seconds(1);
/// Longest wait for the card before a reset.
const LAST_WRITES: Micros = Micros::from_seconds(5);

/// Index of the LED that is on while something moves: LED 2.
const PLAY_LED: u8 = 1;

/// Peripherals that only the executor uses.
pub struct Owned {
    pub pins: &'static mut Pins,
    pub spi: SpiBuses,
    pub motors_enable: Output,
    pub leds: [Output; 4],
    pub led_sender: LedSender,
    /// Output that follows LED 2.
    pub second_lamp: Option<Output>,
    pub debug: UartPort,
    pub uarts: [UartPort; 2],
    pub board_id: u8,
    pub start: Start,
    pub second_core_starts: bool,
    pub rtc: Rtc,
    pub rtt: Said,
    /// USB socket until it is connected, with the chip's unique id.
    pub usb: Option<(UsbSocket, [u32; 3])>,
    pub network: BoardNetwork,
    /// Lamp that shows that the computer at the USB socket has the card.
    pub disk_lamp: Option<Output>,
}

/// Data that the executor shares with tasks, each behind its RTIC lock.
pub trait Locks {
    /// Lock of motion.
    type Motion: Mutex<T = &'static mut Motion>;
    /// Lock of heat control and its pins.
    type Heat: Mutex<T = Heat>;
    /// Lock of the drivers and their watch.
    type Slow: Mutex<T = Slow>;
    /// Lock of the inputs that stop motion.
    type Triggers: Mutex<T = TriggerInputs>;
    /// Lock of the card.
    type Card: Mutex<T = &'static mut CardService>;
}

/// The locks of all but the card, whose lock is the storage's.
#[allow(missing_docs, reason = "the locks say what each is")]
pub struct Shared<L: Locks> {
    pub motion: L::Motion,
    pub heat: L::Heat,
    pub slow: L::Slow,
    pub triggers: L::Triggers,
}

/// All ports of the machine.
pub struct BoardPorts<L: Locks> {
    owned: &'static mut Owned,
    storage: CardStorage<L::Card>,
    updates: &'static mut Updates,
    shared: Shared<L>,
    /// Whether each auxiliary port is a console. A port that is none swallows its output.
    open: [bool; 2],
    inputs: Vec<(u8, Input), MAX_INPUTS>,
    /// Timer and channel of each strip of lights.
    strips: [Option<(usize, usize)>; config::MAX_STRIPS],
    laser: Option<Laser>,
    reset_at: Option<Micros>,
    /// Time since which the bus is silent while a computer has the card.
    silent_since: Option<Micros>,
    plan: fn(),
    /// Position of the log in the ring of events.
    told: Told,
}

impl<L: Locks> BoardPorts<L> {
    /// Creates the ports; `plan` wakes the planner task.
    pub fn new(
        owned: &'static mut Owned,
        updates: &'static mut Updates,
        card: L::Card,
        shared: Shared<L>,
        plan: fn(),
    ) -> Self {
        let storage = card_storage(card);
        usb::begin();
        crate::network::begin();
        Self {
            owned,
            storage,
            updates,
            shared,
            open: [false; 2],
            inputs: Vec::new(),
            strips: Default::default(),
            laser: None,
            reset_at: None,
            silent_since: None,
            plan,
            told: Told::from_here(),
        }
    }

    /// Returns the port of a console; `None` if it has none.
    fn port(&mut self, console: Console) -> Option<&mut UartPort> {
        let [uart0, uart1] = &mut self.owned.uarts;
        let [uart0_open, uart1_open] = self.open;
        match console {
            Console::Debug => Some(&mut self.owned.debug),
            Console::Uart0 => uart0_open.then_some(uart0),
            Console::Uart1 => uart1_open.then_some(uart1),
            Console::Usb0 | Console::Usb1 | Console::Rtt | Console::Network(_) | Console::Page => None,
        }
    }

    fn wire_consoles(&mut self, config: &MachineConfig, report: &mut Report<'_>) {
        let uart = config.uart;
        if !uart.enable {
            return;
        }
        let parity = match uart.parity {
            config::Parity::None => Parity::None,
            config::Parity::Odd => Parity::Odd,
            config::Parity::Even => Parity::Even,
        };
        let Some(frame) = Frame::new(uart.bits, parity, uart.stop_bits) else {
            report.trouble("uart console.bits: words of 7 or 8 bits and their parity bit, or of 7 or 8 bits without");
            return;
        };
        let Some(port) = self.owned.uarts.get_mut(usize::from(uart.channel)) else {
            report.trouble(format_args!("uart console.channel = {}: this board has 0 and 1", uart.channel));
            return;
        };
        for pin in port.pins() {
            if report.take(self.owned.pins.claim(pin, "uart console")).is_none() {
                return;
            }
        }
        port.open(uart.baudrate, frame);
        if let Some(open) = self.open.get_mut(usize::from(uart.channel)) {
            *open = uart.console;
        }
    }

    fn wire_inputs(&mut self, config: &MachineConfig, report: &mut Report<'_>) {
        let inputs = &mut self.inputs;
        let triggers = &mut self.shared.triggers;
        let place = |number, spec, pin: Input, stops| {
            // Both lists hold every input a configuration can name.
            let _fits = inputs.push((number, pin.clone()));
            if stops {
                let _fits = triggers.lock(|triggers| triggers.add(number, spec, pin));
            }
        };
        wiring::inputs(config, self.owned.pins, place, report);
    }

    fn wire_heat(&mut self, config: &MachineConfig, report: &mut Report<'_>) {
        let (owned, heat, strips, laser) = (&mut self.owned, &mut self.shared.heat, &mut self.strips, &mut self.laser);
        // A longer lock than others, and still some microseconds only: the calibration begun at power-on is
        // over. No heater is on yet.
        heat.lock(|heat| wiring::temperatures(config, owned.pins, &mut heat.io, report));
        heat.lock(|heat| wiring::tachometers(config, owned.pins, &mut heat.io, report));
        heat.lock(|heat| {
            let HeatIo { switches, pwm, pwm_switches, .. } = &mut heat.io;
            let place = |index: usize, output| {
                if let Some(slot) = switches.get_mut(index) {
                    *slot = Some(output);
                }
            };
            wiring::switch_outputs(config, owned.pins, pwm, place, report);
            for (slot, switch) in pwm_switches.iter_mut().zip(&config.switches) {
                if let Some(OutputPin::Pwm(output)) = switch.output_pin {
                    let (timer, channel) = (usize::from(output.timer), usize::from(output.channel));
                    *slot = Some((timer.wrapping_sub(1), channel.wrapping_sub(1)));
                }
            }
            *laser = wiring::laser(config, owned.pins, pwm, report);
            *strips = wiring::led_strips(config, owned.pins, pwm, &mut owned.led_sender, report);
        });
    }
}

impl<L: Locks> FilesPort for BoardPorts<L> {
    type Files = CardStorage<L::Card>;

    fn files<R>(&mut self, action: impl FnOnce(&mut Self::Files) -> R) -> R {
        action(&mut self.storage)
    }
}

impl<L: Locks> Ahead for BoardPorts<L> {
    type Workspace = &'static mut Workspace;

    fn workspace(&mut self) -> Option<&'static mut Workspace> {
        workspace::take()
    }
}

impl<L: Locks> MotionPort for BoardPorts<L> {
    fn motion<R>(&mut self, f: impl FnOnce(&mut Motion) -> R) -> R {
        let (result, waiting) = self.shared.motion.lock(|motion| {
            let result = f(motion);
            (result, motion.queue_level().0 > 0)
        });
        if waiting {
            (self.plan)();
        }
        result
    }

    fn latch(&self) -> &Latch {
        &LATCH
    }
}

impl<L: Locks> HeatPort for BoardPorts<L> {
    fn heat<R>(&mut self, f: impl FnOnce(&mut HeatControl) -> R) -> R {
        self.shared.heat.lock(|heat| f(heat.control))
    }

    fn run_heat_now(&mut self) {
        bsp_prime::time::pend_heat_tick();
    }
}

impl<L: Locks> DriversPort for BoardPorts<L> {
    type Drivers = DriverBank;

    fn drivers<R>(&mut self, f: impl FnOnce(&mut DriverBank) -> R) -> R {
        self.shared.slow.lock(|slow| f(&mut slow.drivers))
    }

    fn set_motor_power(&mut self, on: bool) {
        self.owned.motors_enable.set(on);
    }
}

impl<L: Locks> SupervisorPort for BoardPorts<L> {
    fn supervisor<R>(&mut self, f: impl FnOnce(&mut Supervisor) -> R) -> R {
        self.shared.slow.lock(|slow| f(&mut slow.supervisor))
    }
}

impl<L: Locks> Inputs for BoardPorts<L> {
    fn inputs(&self) -> InputLevels {
        let active = self.inputs.iter().filter(|(_, pin)| pin.is_on());
        active.fold(InputLevels::default(), |levels, (number, _)| levels.with_number(*number))
    }
}

impl<L: Locks> Consoles for BoardPorts<L> {
    fn sessions(&self) -> u8 {
        Console::ALL.len() as u8
    }

    #[inline]
    fn inbox(&self, session: SessionId) -> &Inbox {
        Console::of(session).unwrap_or(Console::Debug).inbox()
    }

    fn have_news(&self) -> bool {
        executor::take_news()
    }

    fn profile(&self, session: SessionId) -> SessionProfile {
        let console = Console::of(session).unwrap_or(Console::Debug);
        match console {
            Console::Network(place) => SessionProfile { rights: self.owned.network.rights(place), ..console.profile() },
            Console::Page => SessionProfile { rights: self.owned.network.page_rights(), ..console.profile() },
            _ => console.profile(),
        }
    }

    fn write(&mut self, session: SessionId, bytes: &[u8]) -> usize {
        let Some(console) = Console::of(session) else { return bytes.len() };
        if console == Console::Rtt {
            return self.owned.rtt.write(Console::Rtt.inbox(), bytes);
        }
        if let Console::Network(place) = console {
            return if console.inbox().is_open() { self.owned.network.write(place, bytes) } else { bytes.len() };
        }
        if console == Console::Page {
            return self.owned.network.tell_page(bytes);
        }
        if let Some(count) = usb::write(console, bytes) {
            return count;
        }
        self.port(console).map_or(bytes.len(), |port| port.write(bytes))
    }
}

/// Owner of a pin under test.
const BORROWER: &str = "the command gpio";

impl<L: Locks> PinPort for BoardPorts<L> {
    fn borrow_pin(&mut self, pin: Pin, drive: Option<bool>) -> Result<bool, PinTaken> {
        let pins = &mut *self.owned.pins;
        let level = match drive {
            None => pins.input(wiring::spec(pin), BORROWER).map(|input| {
                // The pull resistor needs time: 40 kOhm on some 100 pF.
                wait::pause(50);
                input.is_on()
            }),
            Some(on) => pins.output(wiring::spec(pin), BORROWER).map(|mut output| {
                output.set(on);
                output.is_on()
            }),
        };
        level.map_err(|error| {
            let mut why = PinTaken::new();
            // Text without room is cut.
            let _cut = match error {
                PinError::Taken { pin, owner, .. } => write!(why, "{pin} is used by {owner}"),
                PinError::Reserved { pin, usage, .. } => write!(why, "{pin} belongs to {usage}"),
                PinError::TableFull => write!(why, "{error}"),
            };
            why
        })
    }

    fn return_pin(&mut self, pin: Pin) {
        self.owned.pins.give_back(wiring::spec(pin).pin, BORROWER);
    }
}

impl<L: Locks> Board for BoardPorts<L> {
    fn wire(&mut self, config: &MachineConfig, report: &mut dyn FnMut(&str)) -> bool {
        let mut report = Report::new(report);
        wiring::guards(config, &mut report);
        // Sensor selects come first, so that no sensor's chip listens to messages for drivers.
        let sensors = wiring::sensors(config, self.owned.pins, &mut self.owned.spi, &mut report);
        let reads_chips = !sensors.is_empty();
        let bank = wiring::motors(config, self.owned.pins, &mut self.owned.spi, &mut self.owned.uarts, &mut report);
        wiring::voltages(config, self.owned.pins, &mut report);
        self.shared.slow.lock(|slow| {
            slow.drivers = bank;
            slow.sensors = sensors;
            if slow.monitor(config).is_err() {
                report.trouble("the voltage converter (ADC3) does not start; supply voltages are unknown");
            }
        });
        self.shared.heat.lock(|heat| heat.io.reads_chips = reads_chips);
        self.wire_heat(config, &mut report);
        self.wire_inputs(config, &mut report);
        if let Some(pin) = config.system.aux_play_led {
            self.owned.second_lamp = report.take(self.owned.pins.output(wiring::spec(pin), "system.aux_play_led"));
        }
        if let Some(pin) = config.system.msc_led.filter(|_| config.system.msc_enable) {
            self.owned.disk_lamp = report.take(self.owned.pins.output(wiring::spec(pin), "system.msc_led"));
        }
        self.wire_consoles(config, &mut report);
        report.clean
    }

    fn voltage(&mut self, name: &str) -> Option<Volts> {
        self.shared.slow.lock(|slow| slow.voltage(name))
    }

    fn voltage_now(&mut self, name: &str) -> Option<Volts> {
        self.shared.slow.lock(|slow| slow.voltage_now(name))
    }

    fn chip_celsius(&mut self) -> Option<Celsius> {
        self.shared.slow.lock(|slow| slow.chip_celsius())
    }

    fn set_led(&mut self, index: u8, on: bool) {
        if let Some(led) = self.owned.leds.get_mut(usize::from(index)) {
            led.set(on);
        }
        if let Some(lamp) = self.owned.second_lamp.as_mut().filter(|_| index == PLAY_LED) {
            lamp.set(on);
        }
    }

    fn board(&self) -> BoardInfo {
        BoardInfo {
            mcu: "STM32H745",
            board_id: self.owned.board_id,
            core_mhz: bsp_prime::clocks::CORE_HZ / 1_000_000,
            version: env!("VELVET_VERSION"),
            build_date: env!("VELVET_BUILD_DATE"),
            start: self.owned.start.clone(),
            second_core_starts: self.owned.second_core_starts,
        }
    }

    fn memory(&self) -> MemoryReport {
        MemoryReport {
            static_bytes: memory::static_bytes(),
            stack_unused_bytes: Some(thread_stack::unused_bytes()),
            interrupt_stack_unused_bytes: Some(memory::main_stack_unused_bytes()),
        }
    }

    fn step_times(&self) -> StepTimes {
        let told = &bsp_prime::step_engine::STATISTICS;
        StepTimes {
            late: told.late_events(),
            delayed: told.delayed_events(),
            worst: Ticks(u64::from(told.worst_ticks())),
        }
    }

    fn report_alive(&mut self) {
        REPORTS.report(Reporter::Executor);
        // Work on files has had its turn, so writes may go to the card. The card's commands have time limits,
        // and cards come and go.
        self.storage.card(|slot| {
            slot.with(|card| {
                card.hold(false);
                card.advance(time::now().0);
                usb::tell_disk(card);
            });
        });
        // Pending writes go to the card before a reset, unless that takes too long.
        let waits = !matches!(self.storage.is_kept(), Ok(true) | Err(_));
        let is_due = |at: Micros| time::now() >= if waits { at.plus(LAST_WRITES) } else { at };
        if self.reset_at.is_some_and(is_due) {
            crate::fault::reset_as_asked();
        }
    }

    fn stop_for_debugger(&mut self) -> bool {
        let is_attached = cortex_m::peripheral::DCB::is_debugger_attached();
        if is_attached {
            cortex_m::asm::bkpt();
        }
        is_attached
    }

    fn request_reset(&mut self) {
        self.owned.network.leave();
        self.reset_at.get_or_insert(time::now().plus(RESET_DELAY));
    }
}
