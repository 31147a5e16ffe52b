//! Table of every signal: the level of its pin in each state of the machine.
//!
//! The states are those of a machine that uses everything ([`Signal::idle`] and [`Signal::halted`]); `boot`
//! is the board with its image up and nothing wired yet, as it stays without a usable configuration. Pins
//! that no row names are left as they come out of reset, analog.

use crate::Proof;
use crate::wiring::{
    AnalogInput, BOARD_ID, DRIVERS, END_STOPS, HEATER_SUPPLY, LEDS, MOTOR_SUPPLY, MOTORS_ENABLE, OUTPUT_BUFFER_ENABLE,
    POWER_OUTPUTS, PROBE, SUPPLY_SWITCH, THERMISTORS, USB_HOST_POWER,
};

pub use crate::signal::{Level, Rest, Signal, Speed};

const fn conventions(test: &'static str, file: &'static str) -> Proof {
    Proof { test, file }
}

/// The tests that go through all rows: in reset, at boot, idle, halted, and for pins without a row.
pub const LEVELS: &[Proof] = &[
    conventions("in_reset_every_pin_is_released", "virtual-prime/tests/conventions/levels.rs"),
    conventions("at_boot_every_signal_has_its_level", "virtual-prime/tests/conventions/levels.rs"),
    conventions("idle_every_signal_has_its_level_and_speed", "virtual-prime/tests/conventions/levels.rs"),
    conventions("halted_every_signal_has_its_level", "virtual-prime/tests/conventions/levels.rs"),
];

const MOTORS: &str = "virtual-prime/tests/conventions/motors.rs";
const POWER: &str = "virtual-prime/tests/conventions/power.rs";
const INPUTS: &str = "virtual-prime/tests/conventions/inputs.rs";
const BUSES: &str = "virtual-prime/tests/conventions/buses.rs";
const DIRECTIONS: &str = "virtual-prime/tests/conventions/directions.rs";

/// Header pins that the tests' machine gives to an external driver, a button or a serial port. The choice of
/// the pin is the configuration's.
const EXTERNAL_STEP: &[&str] = &["PG0"];
const EXTERNAL_DIRECTION: &[&str] = &["PG1"];
const EXTERNAL_ENABLE: &[&str] = &["PJ2"];
const KILL: &[&str] = &["PJ6"];

/// Returns the pin of an input that has a pin.
const fn pin_of(input: &AnalogInput) -> &'static str {
    match input.pin {
        Some(pin) => pin,
        None => panic!("an input without a pin"),
    }
}

const BASE: Signal = Signal {
    name: "",
    pins: &[],
    rest: Rest::Floats,
    boot: Level::Released,
    idle: Level::Released,
    active: "",
    halted: Level::Released,
    speed: None,
    origin: "",
    proofs: &[],
};

/// Table of all signals.
pub const SIGNALS: &[Signal] = &[
    Signal {
        name: "enable of all motor drivers (ENN)",
        pins: &[MOTORS_ENABLE],
        boot: Level::High,
        idle: Level::Low,
        active: "low: bridges may be on; a chip's own are on only while its TOFF is not 0",
        halted: Level::High,
        speed: Some(Speed::Low),
        origin: "schematic, MOT_EN; TMC2590 data sheet, ENN. Nothing pulls it, so it is driven first of all",
        proofs: &[
            conventions("the_drivers_are_enabled_by_a_low_line_and_a_halt_lets_them_go", MOTORS),
            conventions("no_output_is_on_before_its_time", POWER),
        ],
        ..BASE
    },
    Signal {
        name: "STEP, on-board drivers",
        pins: &[DRIVERS[0].step, DRIVERS[1].step, DRIVERS[2].step, DRIVERS[3].step],
        idle: Level::Either,
        active: "each edge is a step (DEDGE)",
        halted: Level::Either,
        speed: Some(Speed::Medium),
        origin: "schematic, STEP_A to STEP_D; TMC2590 data sheet 7.5.2, TMC2660 6.5.2, DEDGE",
        proofs: &[conventions("each_edge_of_an_on_board_step_pin_is_a_step", MOTORS)],
        ..BASE
    },
    Signal {
        name: "DIR, on-board drivers",
        pins: &[DRIVERS[0].direction, DRIVERS[1].direction, DRIVERS[2].direction, DRIVERS[3].direction],
        idle: Level::Low,
        active: "low counts up, high counts down; `!` or `reversed` turns it round",
        halted: Level::Either,
        speed: Some(Speed::Medium),
        origin: "known good: running boards, and the machines wired to them",
        proofs: &[
            conventions("direction_pins_are_low_for_positive_motion", DIRECTIONS),
            conventions("direction_pins_with_an_exclamation_mark_are_high_for_positive_motion", DIRECTIONS),
            conventions("reversed_motors_have_their_direction_pins_high_for_positive_motion", DIRECTIONS),
            conventions("slaves_have_their_direction_pins_low_for_positive_motion", DIRECTIONS),
        ],
        ..BASE
    },
    Signal {
        name: "chip select, on-board drivers",
        pins: &[DRIVERS[0].select, DRIVERS[1].select, DRIVERS[2].select, DRIVERS[3].select],
        rest: Rest::High("10 kOhm, RN6"),
        idle: Level::High,
        active: "low for one frame",
        halted: Level::High,
        speed: Some(Speed::Low),
        origin: "schematic, CS_A to CS_D; TMC2590 data sheet 7.2",
        proofs: &[
            conventions("each_frame_has_24_clocks_within_one_chip_select", MOTORS),
            conventions("a_driver_that_no_motor_uses_is_switched_off", MOTORS),
        ],
        ..BASE
    },
    Signal {
        name: "SPI4 of the drivers: SCK, MISO, MOSI",
        pins: &["PE12", "PE5", "PE6"],
        boot: Level::Function(5),
        idle: Level::Function(5),
        active: "mode 3: SCK rests high, data is taken at its rising edge",
        halted: Level::Function(5),
        speed: Some(Speed::Low),
        origin: "schematic, MOTSPI; TMC2590 data sheet 7.2",
        proofs: &[conventions("the_drivers_bus_is_mode_3_at_391_khz", MOTORS)],
        ..BASE
    },
    Signal {
        name: "stallGuard outputs",
        pins: &[DRIVERS[0].stall, DRIVERS[1].stall, DRIVERS[2].stall, DRIVERS[3].stall],
        rest: Rest::Driven("the driver chip"),
        active: "high is a stall; an input where `stall_homing` or `stall_watch` asks for it",
        origin: "schematic, SG_A to SG_D",
        proofs: &[conventions("stall_outputs_lead_where_the_schematic_has_them", "sim/src/world/tests.rs")],
        ..BASE
    },
    Signal {
        name: "STEP, external driver",
        pins: EXTERNAL_STEP,
        idle: Level::Low,
        active: "a high pulse of `step_pulse_us` is a step; `!` turns it round",
        halted: Level::Low,
        speed: Some(Speed::Medium),
        origin: "configuration; known good",
        proofs: &[
            conventions("each_pulse_of_an_external_step_pin_is_a_step", MOTORS),
            conventions("an_inverted_external_step_pin_rests_high", MOTORS),
        ],
        ..BASE
    },
    Signal {
        name: "DIR, external driver",
        pins: EXTERNAL_DIRECTION,
        idle: Level::Low,
        active: "low counts up, high counts down; `!` or `reversed` turns it round",
        halted: Level::Either,
        speed: Some(Speed::Medium),
        origin: "known good",
        proofs: &[
            conventions("direction_pins_are_low_for_positive_motion", DIRECTIONS),
            conventions("direction_pins_with_an_exclamation_mark_are_high_for_positive_motion", DIRECTIONS),
        ],
        ..BASE
    },
    Signal {
        name: "enable, external driver (`!`)",
        pins: EXTERNAL_ENABLE,
        idle: Level::High,
        active: "low while the motor is on; without `!` high",
        halted: Level::High,
        speed: Some(Speed::Low),
        origin: "configuration; known good",
        proofs: &[conventions("an_external_driver_is_enabled_while_its_motor_is_on", MOTORS)],
        ..BASE
    },
    Signal {
        name: "enable of the output buffer (74HCT541)",
        pins: &[OUTPUT_BUFFER_ENABLE],
        rest: Rest::High("4.7 kOhm to 5 V, R80"),
        idle: Level::Low,
        active: "low: the buffer drives gates and relays. Open drain: never driven high",
        speed: Some(Speed::Low),
        origin: "schematic, OUTPUTENABLE",
        proofs: &[conventions("a_halt_closes_the_buffer_and_opens_the_load_switch", POWER)],
        ..BASE
    },
    Signal {
        name: "load switch of hot ends and fans (Q25)",
        pins: &[SUPPLY_SWITCH],
        rest: Rest::Low("10 kOhm, R93"),
        boot: Level::Low,
        idle: Level::High,
        active: "high: hot ends and fans have their supply. The bed has it always",
        halted: Level::Low,
        speed: Some(Speed::Low),
        origin: "schematic, EXTRAFET, Q26 and Q25; the bed's connectors lie before Q25",
        proofs: &[conventions("a_halt_closes_the_buffer_and_opens_the_load_switch", POWER)],
    },
    Signal {
        name: "hot end A, hot end B, bed",
        pins: &[POWER_OUTPUTS[0].pin, POWER_OUTPUTS[1].pin, POWER_OUTPUTS[2].pin],
        rest: Rest::Low("10 kOhm, RN8, RN2"),
        boot: Level::Low,
        idle: Level::Low,
        active: "high heats, modulated at 2 kHz",
        halted: Level::Low,
        speed: Some(Speed::Low),
        origin: "schematic, sheet mosfets: gates 10 kOhm to ground behind the buffer; known good",
        proofs: &[
            conventions("each_heater_drives_its_own_output_and_no_other", POWER),
            conventions("no_output_is_on_before_its_time", POWER),
        ],
    },
    Signal {
        name: "fan 1, fan 2",
        pins: &[POWER_OUTPUTS[3].pin, POWER_OUTPUTS[4].pin],
        rest: Rest::Low("10 kOhm, RN8"),
        boot: Level::Low,
        idle: Level::Low,
        active: "high runs",
        halted: Level::Low,
        speed: Some(Speed::Low),
        origin: "schematic, sheet mosfets; known good",
        proofs: &[conventions("each_switch_drives_its_own_output_and_no_other", POWER)],
    },
    Signal {
        name: "SSR 1, SSR 2 (`!`)",
        pins: &[POWER_OUTPUTS[5].pin, POWER_OUTPUTS[6].pin],
        rest: Rest::High("10 kOhm, R101, R102"),
        boot: Level::High,
        idle: Level::High,
        active: "low: 5 V at J44 or J45",
        halted: Level::High,
        speed: Some(Speed::Low),
        origin: "schematic, Q23 and Q24, P channel, gates 10 kOhm to 5 V behind the buffer",
        proofs: &[conventions("each_switch_drives_its_own_output_and_no_other", POWER)],
    },
    Signal {
        name: "end stops X, Y, Z, min and max (`^`)",
        pins: &[END_STOPS[0].1, END_STOPS[1].1, END_STOPS[2].1, END_STOPS[3].1, END_STOPS[4].1, END_STOPS[5].1],
        rest: Rest::Driven("74LCX07, which only pulls low"),
        idle: Level::PulledUp,
        active: "high is hit, as with a switch to ground that opens; `!` for one that closes",
        halted: Level::PulledUp,
        origin: "schematic, sheet inputs: not inverted; the chip's pull-up is the only one",
        proofs: &[
            conventions("a_plain_end_stop_is_hit_while_its_pin_is_high", INPUTS),
            conventions("an_inverted_end_stop_is_hit_while_its_pin_is_low", INPUTS),
        ],
        ..BASE
    },
    Signal {
        name: "probe (`^`)",
        pins: &[PROBE],
        rest: Rest::Driven("LMV331, which only pulls low"),
        idle: Level::PulledUp,
        active: "high is touching, 2.9 V and more at the connector; `!` for a probe that pulls to ground",
        halted: Level::PulledUp,
        origin: "schematic, U24: threshold 0.359 V behind 7.1 kOhm over 1 kOhm",
        proofs: &[conventions("a_plain_probe_touches_while_its_pin_is_high", INPUTS)],
        ..BASE
    },
    Signal {
        name: "kill button (`^`)",
        pins: KILL,
        idle: Level::PulledUp,
        active: "low is pressed",
        halted: Level::PulledUp,
        origin: "configuration; known good",
        proofs: &[conventions("the_kill_button_is_pressed_while_its_pin_is_low", INPUTS)],
        ..BASE
    },
    Signal {
        name: "BOOT0 button's sense",
        pins: &["PJ14"],
        rest: Rest::Low("10 kOhm and 10 kOhm, R90, R32"),
        active: "high is pressed; not used",
        origin: "schematic, SW2",
        ..BASE
    },
    Signal {
        name: "LED 1 to 4, mass-storage LED",
        pins: &LEDS,
        boot: Level::Either,
        idle: Level::Either,
        active: "high lights",
        halted: Level::Either,
        speed: Some(Speed::Low),
        origin: "schematic, 1 kOhm and a LED to ground",
        proofs: &[
            conventions("a_high_led_pin_is_what_shows_life", INPUTS),
            conventions("the_third_led_says_hot_and_the_fourth_that_a_file_is_played", INPUTS),
        ],
        ..BASE
    },
    Signal {
        name: "identity straps",
        pins: &BOARD_ID,
        active: "read with the pull-up at boot: ground is a one; 0 is TMC2590, 1 is TMC2660",
        origin: "schematic: none fitted on proto10, PF7 to ground on proto9; known good",
        proofs: &[conventions("the_straps_say_which_drivers_there_are", INPUTS)],
        ..BASE
    },
    Signal {
        name: "thermistors T1, T2, T3",
        pins: &[pin_of(&THERMISTORS[1]), pin_of(&THERMISTORS[2]), pin_of(&THERMISTORS[3])],
        rest: Rest::Driven("LMV324 followers"),
        active: "analog",
        origin: "schematic, sheet inputs; the net names T1 and T4 are swapped against the connectors",
        proofs: &[conventions("each_thermistor_is_read_at_its_own_input", INPUTS)],
        ..BASE
    },
    Signal {
        name: "supply monitors",
        pins: &[pin_of(&HEATER_SUPPLY), pin_of(&MOTOR_SUPPLY)],
        rest: Rest::Driven("100 kOhm over 10 kOhm"),
        active: "analog",
        origin: "schematic, FETSENSE and VMOTSENSE",
        proofs: &[conventions("the_supplies_are_read_at_their_own_inputs", INPUTS)],
        ..BASE
    },
    Signal {
        name: "SD card D0 to D3, CMD",
        pins: &["PC8", "PC9", "PC10", "PC11", "PD2"],
        rest: Rest::High("10 kOhm, RN7, R95"),
        boot: Level::Function(12),
        idle: Level::Function(12),
        active: "driven by SDMMC1",
        halted: Level::Function(12),
        speed: Some(Speed::High),
        origin: "schematic, sheet 1, MICROSD; known good",
        proofs: &[conventions("the_card_is_identified_at_400_khz_and_read_at_50_mhz", BUSES)],
    },
    Signal {
        name: "SD card CK",
        pins: &["PC12"],
        boot: Level::Function(12),
        idle: Level::Function(12),
        active: "driven by SDMMC1",
        halted: Level::Function(12),
        speed: Some(Speed::High),
        origin: "schematic, sheet 1, MICROSD; known good",
        proofs: &[conventions("the_card_is_identified_at_400_khz_and_read_at_50_mhz", BUSES)],
        ..BASE
    },
    Signal {
        name: "SD card detect",
        pins: &["PG10"],
        rest: Rest::High("10 kOhm, R94"),
        active: "not used: which way round the contact works is not known",
        origin: "schematic, CARD_DET",
        ..BASE
    },
    Signal {
        name: "debug console, TX and RX",
        pins: &["PD5", "PD6"],
        boot: Level::Function(7),
        idle: Level::Function(7),
        active: "rests high; RX has the chip's pull-up",
        halted: Level::Function(7),
        speed: Some(Speed::Low),
        origin: "schematic, J30, through 100 Ohm",
        proofs: &[conventions("the_consoles_are_8n1_at_their_rates", BUSES)],
        ..BASE
    },
    Signal {
        name: "UART 0, TX and RX",
        pins: &["PD8", "PB11"],
        idle: Level::Function(7),
        active: "rests high; RX has the chip's pull-up",
        halted: Level::Function(7),
        speed: Some(Speed::Low),
        origin: "schematic, header GD",
        proofs: &[conventions("the_consoles_are_8n1_at_their_rates", BUSES)],
        ..BASE
    },
    Signal {
        name: "hardware PWM, PWM1_1",
        pins: &["PE9"],
        idle: Level::Function(1),
        active: "high is on",
        halted: Level::Function(1),
        speed: Some(Speed::Low),
        origin: "schematic, header GD; DS12923: TIM1 is AF1",
        proofs: &[conventions("hardware_pwm_has_1000_counts_and_is_on_while_high", BUSES)],
        ..BASE
    },
    Signal {
        name: "hardware PWM, PWM2_2",
        pins: &["PI6"],
        idle: Level::Function(3),
        active: "high is on",
        halted: Level::Function(3),
        speed: Some(Speed::Low),
        origin: "schematic, header GC; DS12923: TIM8 is AF3",
        proofs: &[conventions("hardware_pwm_has_1000_counts_and_is_on_while_high", BUSES)],
        ..BASE
    },
    Signal {
        name: "power of the USB-A socket",
        pins: &[USB_HOST_POWER],
        boot: Level::Low,
        idle: Level::Low,
        active: "high: 5 V. Not used",
        halted: Level::Low,
        speed: Some(Speed::Low),
        origin: "schematic, U16 (MT9700): nothing pulls it, so it is driven",
        proofs: &[conventions("no_output_is_on_before_its_time", POWER)],
        ..BASE
    },
    Signal {
        name: "USB data of the USB-B socket",
        pins: &["PA11", "PA12"],
        boot: Level::Function(10),
        idle: Level::Function(10),
        active: "OTG2 pulls D+ (PA12) up by itself",
        halted: Level::Function(10),
        speed: Some(Speed::VeryHigh),
        origin: "schematic, J1; known good; DS12923: OTG2_FS is AF10",
        proofs: &[conventions("the_usb_socket_is_otg2_at_48_mhz", BUSES)],
        ..BASE
    },
    Signal {
        name: "USB data of the USB-A socket",
        pins: &["PB14", "PB15"],
        active: "not used",
        origin: "schematic, J2",
        ..BASE
    },
    Signal {
        name: "Ethernet (RMII)",
        pins: &["PA1", "PA2", "PA7", "PC1", "PC4", "PC5", "PG11", "PG12", "PG13"],
        rest: Rest::Driven("LAN8720A, whose inputs have pull-downs of their own"),
        active: "the network, when [network] enable says so",
        origin: "schematic, sheet ethernet",
        proofs: &[Proof {
            test: "an_address_comes_from_dhcp_and_goes_with_the_cable",
            file: "virtual-prime/tests/network/addresses.rs",
        }],
        ..BASE
    },
    Signal {
        name: "QSPI flash",
        pins: &["PB2", "PB6", "PD11", "PD13", "PE2", "PF9"],
        active: "not used",
        origin: "schematic, U4: its select has no pull-up",
        ..BASE
    },
];
