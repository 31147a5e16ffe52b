//! The Prime: the microcontroller and the parts soldered to it (board facts: schematic of the Prime,
//! proto9/10).

use std::collections::BTreeSet;
use std::num::{NonZeroU32, NonZeroU64};

use board_facts::wiring;
use rigless::cpu::armv7m as cpu;
use rigless::device::Level;
use rigless::emulator::Access;
use rigless::machine::{Board, Target, armv7m};
use rigless::mcu::Mcu;
use rigless::snapshot::Store;
use rigless::soc::Error;
use rigless::soc::stm32h743::generated::gpioa::Register as PortRegister;
use rigless::soc::stm32h743::peripherals::adc::Channel;
use rigless::soc::stm32h743::peripherals::gpio::Pin as PortPin;
use rigless::soc::stm32h743::peripherals::spi::Select;
use rigless::soc::stm32h743::peripherals::tim::Channel as TimerChannel;
use rigless::time::VirtualNanos;
use sim::models::sd_card::SdCard;
use sim::models::thermistor::{self, Curve, REFERENCE_VOLTS, divider_volts};
use sim::models::tmc26x::Chip;
use sim::world::{
    AnalogInput, OutsidePort, PWM_CHANNELS, PWM_TIMERS, Pin, VFET_INPUT, VMOTOR_INPUT, World, WorldConfig,
};

use crate::console::{Line, LineEnd};
use crate::drivers::{self, ConverterPort, DriverPort, WireEnd};
use crate::flash_journal::{FlashJournal, Operation};
use crate::mcu::PrimeMcu;
pub use crate::outputs::{PinChange, SharedWorld};
use crate::pin_state::Drive;
use crate::pins::{Wiring, driver_selects, pin, port_name};

/// Frequencies of the crystals: HSE 25 MHz, LSE 32.768 kHz.
const HSE_HZ: u64 = 25_000_000;
const LSE_HZ: u64 = 32_768;
/// Voltage of VDD, VDDA and VREF+.
const RAIL_MV: u32 = 3_300;
/// Temperature of the chip, hundredths of a degree Celsius.
const CHIP_CENTI_C: i32 = 4_600;
/// Clock of the core, and the instructions it retires a second: one per cycle, so that CYCCNT counts
/// instructions.
pub const CORE_HZ: u64 = 400_000_000;
/// Index of SPI4, to which the drivers are connected, in the emulator's array.
const DRIVER_SPI: usize = 3;
/// Index of SPI1, which is on a header.
const HEADER_SPI: usize = 0;
/// Indices of USART2 (debug header), USART3 (expansion) and UART4 (expansion) in the emulator's array.
const CONSOLE_PORTS: [usize; 3] = [1, 2, 3];

/// Indices among the thermistor inputs: the board's own thermistor, and the connectors T1 to T3.
const ON_BOARD: usize = 0;
const CONNECTORS: std::ops::Range<usize> = 1..4;
/// Assumed thermistor of the board, as the schematic gives no part for it: a 100 kOhm bead of B = 4066 K, as
/// in other firmwares.
const BOARD_THERMISTOR: Curve = Curve::Beta { r25_ohms: 100_000.0, t25_c: 25.0, beta_k: 4_066.0 };
/// Excess of the board's temperature over the air's.
const BOARD_WARMTH_K: f64 = 8.0;
/// Pins that rest high while nothing drives them: the buffer's enable with its pull-up, and the drivers' ENN.
const RESTS_HIGH: [Pin; 2] = [pin(wiring::OUTPUT_BUFFER_ENABLE), pin(wiring::MOTORS_ENABLE)];

/// The board with its machine.
#[derive(Debug)]
pub struct PrimeBoard {
    /// The microcontroller of the board.
    pub mcu: PrimeMcu,
    world: SharedWorld,
    consoles: [Line; 3],
    /// Journal of the image's flash operations.
    pub flash: FlashJournal,
    /// Thermistor and supply inputs that the machine drives.
    analog: Vec<AnalogInput>,
    /// Milliseconds since power-on, for [`Self::refresh_analog`].
    ticks: u64,
    /// Time that the processor has slept since power-on, nanoseconds.
    asleep_ns: u64,
    /// Frames that were sent to a chip with the wrong clock mode, each kind once.
    wrong_modes: BTreeSet<String>,
}

impl PrimeBoard {
    /// Creates a board at power-on with this machine connected to it.
    ///
    /// # Errors
    /// When the emulator's tables lack a peripheral of ours.
    pub fn new(machine: WorldConfig) -> Result<Self, Error> {
        let wiring = Wiring::of(&machine);
        let chip = machine.chip;
        let mut analog = vec![VFET_INPUT, VMOTOR_INPUT];
        analog.extend(machine.heaters.iter().filter_map(|heater| heater.sensor));
        analog.extend(machine.filament_sensor.iter().flat_map(|sensor| sensor.inputs).flatten());
        let world = SharedWorld::new(World::new(machine));
        let mcu = PrimeMcu::new(wiring, world.clone())?;
        let mut board = Self {
            mcu,
            world,
            consoles: Default::default(),
            flash: FlashJournal::default(),
            analog,
            ticks: 0,
            asleep_ns: 0,
            wrong_modes: BTreeSet::new(),
        };
        board.solder(chip);
        Ok(board)
    }

    fn solder(&mut self, chip: Chip) {
        let part = &mut self.mcu.part;
        part.rcc.attach_crystals(HSE_HZ, LSE_HZ);
        for converter in &mut part.adc {
            converter.set_reference(RAIL_MV);
            converter.set_backup_battery(RAIL_MV);
            converter.set_temperature(CHIP_CENTI_C);
        }
        for (index, (port, number)) in driver_selects().into_iter().enumerate() {
            let select = Select { port, pin: port_pin(number), active: Level::Low };
            part.spi[DRIVER_SPI].attach_selected(DriverPort::new(self.world.clone(), index), select);
        }
        let converters: Vec<_> = self.world.lock().config().heaters.iter().map(|heater| heater.converter).collect();
        for (heater, converter) in converters.into_iter().enumerate() {
            let Some(converter) = converter else { continue };
            let Pin { port, number } = converter.select;
            let select = Select { port: port_name(port), pin: port_pin(number), active: Level::Low };
            let bus = if converter.channel == 0 { HEADER_SPI } else { DRIVER_SPI };
            part.spi[bus].attach_selected(ConverterPort::new(self.world.clone(), heater), select);
        }
        for (line, port) in self.consoles.iter().zip(CONSOLE_PORTS) {
            part.usart[port].attach(LineEnd(line.clone()));
        }
        let outside = self.world.lock().config().actuators.clone();
        for entry in outside {
            let sim::world::DriverConfig::Outside { port, .. } = entry.driver else { continue };
            match port {
                OutsidePort::Spi { select: Some(Pin { port, number }), channel } => {
                    let select = Select { port: port_name(port), pin: port_pin(number), active: Level::Low };
                    let bus = if channel == 0 { HEADER_SPI } else { DRIVER_SPI };
                    let chip = drivers::OutsidePort::new(self.world.clone(), entry.actuator);
                    part.spi[bus].attach_selected(chip, select);
                }
                OutsidePort::Spi { select: None, .. } => {}
                OutsidePort::Uart { channel, .. } => {
                    // All drivers of one wire share one end.
                    let Some(port) = CONSOLE_PORTS.get(usize::from(channel) + 1) else { continue };
                    part.usart[*port].attach(WireEnd::new(self.world.clone(), channel));
                }
            }
        }
        self.mcu.set_supply(RAIL_MV);
        let start = VirtualNanos(0);
        self.drive(start, pin(wiring::OUTPUT_BUFFER_ENABLE), true);
        // Strapped pins are grounded; the others float, and the firmware pulls them up.
        let id = match chip {
            Chip::Tmc2590 => 0,
            Chip::Tmc2660 => 1,
        };
        for (bit, name) in wiring::BOARD_ID.into_iter().enumerate() {
            if id >> bit & 1 == 1 {
                self.drive(start, pin(name), false);
            }
        }
        self.rest_analog();
        self.refresh_switches(start);
        self.take_switch_changes(start);
        self.refresh_analog();
    }

    /// Sets whether the 25 MHz crystal swings when it is started; a change during a run takes effect at the
    /// next reset.
    pub fn set_crystal(&mut self, swings: bool) {
        self.mcu.part.rcc.attach_crystals(if swings { HSE_HZ } else { 0 }, LSE_HZ);
    }

    /// Puts an SD card with this content into the slot, or takes the card out.
    pub fn insert_card(&mut self, content: Option<Vec<u8>>) {
        self.insert(content.map(SdCard::new));
    }

    /// Puts this card into the slot, or takes the present card out.
    pub fn insert(&mut self, card: Option<SdCard>) {
        self.mcu.sdmmc.insert(card);
    }

    /// Returns the simulated machine on the pins.
    #[must_use]
    pub const fn world(&self) -> &SharedWorld {
        &self.world
    }

    /// Returns our end of a console: 0 is USART2 (debug header), 1 is USART3, 2 is UART4.
    #[must_use]
    pub const fn console(&self, index: usize) -> &Line {
        &self.consoles[index]
    }

    /// Drives a pin from outside.
    pub fn drive(&mut self, at: VirtualNanos, pin: Pin, high: bool) {
        let level = Some(Level::from(high));
        self.mcu.part.drive_port(at, usize::from(pin.port), |port, file, context| {
            port.drive(port_pin(pin.number), level, file, context);
        });
    }

    /// Returns the level that a pin last had.
    #[must_use]
    pub fn level(&self, pin: Pin) -> bool {
        self.mcu.level(usize::from(pin.port), usize::from(pin.number))
    }

    /// Drives every switch's present level on its pin.
    fn refresh_switches(&mut self, at: VirtualNanos) {
        let levels: Vec<(Pin, bool)> = {
            let world = self.world.lock();
            let switches = &world.config().switches;
            switches.iter().enumerate().map(|(index, switch)| (switch.pin, world.switch_high(index))).collect()
        };
        for (pin, high) in levels {
            self.drive(at, pin, high);
        }
    }

    /// Drives on the pins the changes of the machine's switches since the last call. Returns whether there
    /// were any.
    pub fn take_switch_changes(&mut self, at: VirtualNanos) -> bool {
        let changes = {
            let mut world = self.world.lock();
            if !world.has_switch_changes() {
                return false;
            }
            world.take_switch_changes()
        };
        for change in changes {
            let pin = self.world.lock().config().switches[change.switch].pin;
            self.drive(at, pin, change.high);
        }
        true
    }

    /// Follows a write of the image to this address. To the emulator, a pin in analog mode is low, so a pin
    /// that rests high on the board and is made a low output does not change; the machine has to be told.
    pub fn notice_modes(&mut self, at: VirtualNanos, address: u64) {
        for Pin { port, number } in RESTS_HIGH {
            let slot = self.mcu.port_slot(usize::from(port));
            let (base, registers) = {
                let slot = &self.mcu.bus().slots()[slot];
                (slot.peripheral().base, slot.registers())
            };
            if address & !3 != base {
                continue;
            }
            let mode = registers.get(PortRegister::Moder) >> (2 * number) & 3;
            let driven = mode == 1 || mode == 2;
            let high =
                !driven || self.mcu.part.gpio[usize::from(port)].level(port_pin(number), registers) == Level::High;
            self.mcu.tell(at.0, usize::from(port), usize::from(number), high);
        }
    }

    /// Checks the clock mode of a frame that a write to this address may begin.
    pub fn notice_frame(&mut self, address: u64) {
        if let Some(wrong) = crate::clock_modes::wrong(self, address) {
            self.wrong_modes.insert(wrong);
        }
    }

    /// Takes note of an access of the image that may have begun an operation of the flash.
    pub(crate) fn notice_flash(&mut self, access: &Access) -> Option<Operation> {
        self.flash.notice(access, &self.mcu)
    }

    /// Returns the frames that were sent with the wrong clock mode.
    pub fn wrong_modes(&self) -> impl Iterator<Item = &String> {
        self.wrong_modes.iter()
    }

    /// Brings the machine up to this instant and its voltages to the converters. Called every millisecond,
    /// with the instructions executed so far.
    pub fn tick(&mut self, at: VirtualNanos, instructions: u64) {
        let awake_ns = instructions * 1_000_000_000 / CORE_HZ;
        let asleep_ns = at.0.saturating_sub(awake_ns);
        let slept = std::mem::replace(&mut self.asleep_ns, asleep_ns) < asleep_ns;
        self.mcu.tick_usb(at, slept);
        self.world.lock().advance(at.0);
        self.take_switch_changes(at);
        self.refresh_tachometers(at);
        self.ticks += 1;
        self.refresh_analog();
        self.refresh_pwm();
    }

    /// Drives the fans' tachometer lines: pulled to ground, or let go.
    fn refresh_tachometers(&mut self, at: VirtualNanos) {
        let lines: Vec<(Pin, bool)> = {
            let world = self.world.lock();
            let fans = world.config().fans.iter().enumerate();
            fans.filter_map(|(index, fan)| Some((fan.tachometer?, world.fan_tachometer(index)))).collect()
        };
        for (Pin { port, number }, closed) in lines {
            let level = closed.then_some(Level::Low);
            self.mcu.part.drive_port(at, usize::from(port), |port, file, context| {
                port.drive(port_pin(number), level, file, context);
            });
        }
    }

    /// Hands the duty of every timer output to the machine: compare over period, as in the timer's registers.
    /// Also tells the timers which of their outputs reach their pins.
    fn refresh_pwm(&mut self) {
        for timer in 0..PWM_TIMERS {
            for channel in 0..PWM_CHANNELS {
                let Some(output) = TimerChannel::new(channel as u8 + 1) else { continue };
                let pulse = self.mcu.pulse(timer, output);
                let duty = pulse.map_or(0.0, |p| p.width.0 as f64 / p.period.0.max(1) as f64);
                let state = self.mcu.pin_state(pin(wiring::PWM[timer][channel]));
                self.mcu.pwm[timer].reaches_pin[channel] = state.drive == Drive::Function(wiring::PWM_FUNCTIONS[timer]);
                let mut world = self.world.lock();
                world.pwm(timer, channel, duty);
                if let Some(pulse) = pulse {
                    world.pwm_rate(timer, 1e9 / pulse.period.0.max(1) as f64);
                }
            }
        }
    }

    /// Sets the analog inputs as they read without the machine: the board's own thermistor at the temperature
    /// of its surroundings, and the pull-ups of the empty connectors. The raw header inputs float, and read
    /// zero.
    fn rest_analog(&mut self) {
        let air_c = self.world.lock().config().air_c;
        let board_volts = divider_volts(&BOARD_THERMISTOR, air_c + BOARD_WARMTH_K, thermistor::Wiring::Sound);
        let inputs = wiring::THERMISTORS;
        let connectors = inputs[CONNECTORS].iter().map(|input| (input.channel, REFERENCE_VOLTS));
        for (channel, volts) in [(inputs[ON_BOARD].channel, board_volts)].into_iter().chain(connectors) {
            if let Some(channel) = Channel::new(channel) {
                self.mcu.part.adc[0].set_input(channel, (volts * 1e3) as u32);
            }
        }
    }

    /// Sets the converters' inputs, whole millivolts of 20 counts of 16 bits. The fraction is carried as a
    /// dither over 16 milliseconds, so that a mean over that time is right to a count, as the noise of a real
    /// input makes it.
    fn refresh_analog(&mut self) {
        let dither = f64::from((self.ticks as u8 & 0xF).reverse_bits() >> 4) / 16.0;
        for input in self.analog.clone() {
            let volts = self.world.lock().analog_volts(input).unwrap_or(0.0);
            let converter = usize::from(input.converter) - 1;
            if let Some(channel) = Channel::new(input.channel) {
                self.mcu.part.adc[converter].set_input(channel, (volts * 1e3 + dither) as u32);
            }
        }
    }

    fn core(&self) -> armv7m::Config {
        let clock_hz = NonZeroU64::new(CORE_HZ).expect("a running clock");
        let core = armv7m::Core {
            variant: armv7m::Variant::M7,
            clock_hz,
            interrupt_lines: NonZeroU32::new(150).expect("a part with interrupts"),
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8).expect("a divider"),
            instructions_per_second: clock_hz,
            boot: "flash",
        };
        let mut config = armv7m::Config::new(core, &cpu::windows(self.mcu.bus()));
        config.fpu = armv7m::Fpu::FpV5Dp;
        config.mpu_regions = armv7m::MpuRegions::Sixteen;
        // CPUID of a Cortex-M7 r1p1.
        config.cpuid = 0x411F_C271;
        // 16 KiB caches: CLIDR, CTR and CCSIDR of PM0253 tables 77 and 81.
        config.caches =
            Some(armv7m::Caches { clidr: 0x0900_0003, ctr: 0x8303_C003, ccsidr: &[0xF00F_E019, 0xF01F_E009] });
        config.branch_prediction = armv7m::BranchPrediction::Always;
        // TCM, AHBP, cache and AHBS control, PM0253 table 104: offset, reset value, writable bits. The TCMs'
        // sizes are 64 KiB and 128 KiB.
        config.implementation_registers = [
            (0xF90, 0b0111 << 3, 0b111),
            (0xF94, 0b1000 << 3, 0b111),
            (0xF98, 0, 1),
            (0xF9C, 0, 0b111),
            (0xFA0, 1 << 11, 0xFFFF),
            (0xFA8, 0, 0),
        ]
        .map(|(offset, reset, writable)| armv7m::ImplementationRegister { offset, reset, writable })
        .to_vec();
        // Value of BOOT_CM7_ADD0 as ST programs it.
        config.vector_table = Some(0x0800_0000);
        config
    }
}

fn port_pin(number: u8) -> PortPin {
    PortPin::new(number).expect("a port has sixteen pins")
}

/// The board stores no state: a run is repeated from its start, never from the middle.
impl Store for PrimeBoard {}

impl Board for PrimeBoard {
    fn name(&self) -> &'static str {
        "smoothieboard-v2-prime"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec!["cm7"]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.mcu)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let core = self.core().spec();
        vec![Target::new("cm7", &mut self.mcu, core)]
    }
}
