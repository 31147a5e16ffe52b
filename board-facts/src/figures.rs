//! Table of every figure: of buses, converters, timers, supplies.

use crate::Proof;

/// A convention that is a number rather than a level.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Name of the figure.
    pub name: &'static str,
    /// Value with its unit.
    pub value: &'static str,
    /// Source of the figure.
    pub origin: &'static str,
    /// Tests that look for the figure.
    pub proofs: &'static [Proof],
}

/// Clock of the drivers' bus, hertz: 100 MHz / 256.
pub const DRIVER_BUS_HZ: u64 = 390_625;
/// Number of clocks of a frame to a driver.
pub const DRIVER_FRAME_BITS: u64 = 24;
/// Time for which DIR must be stable before an active edge of STEP (TMC2590 and TMC2660 data sheets, STEP and
/// DIR timing), nanoseconds.
pub const DRIVER_DIRECTION_SETUP_NS: u64 = 20;
/// Number of counts of a period of hardware PWM.
pub const PWM_COUNTS: u64 = 1_000;
/// Time between two decisions of the outputs' modulators, nanoseconds.
pub const MODULATION_NS: u64 = 500_000;
/// Clocks of the card's bus, hertz: while it is identified, before it is asked for high speed, and with it.
pub const CARD_HZ: [u64; 3] = [400_000, 25_000_000, 50_000_000];
/// Rate of the debug console, baud.
pub const DEBUG_BAUD: u64 = 115_200;

const fn proof(test: &'static str, file: &'static str) -> Proof {
    Proof { test, file }
}

const MOTORS: &str = "virtual-prime/tests/conventions/motors.rs";
const POWER: &str = "virtual-prime/tests/conventions/power.rs";
const INPUTS: &str = "virtual-prime/tests/conventions/inputs.rs";
const BUSES: &str = "virtual-prime/tests/conventions/buses.rs";
const GOLDEN: &str = "virtual-prime/tests/golden/mod.rs";
/// Test of every register, each value with its reason.
const REGISTERS: Proof = proof("ready_every_register_has_the_value_of_the_table", GOLDEN);

/// Table of all figures.
pub const FIGURES: &[Figure] = &[
    Figure {
        name: "supply of the core",
        value: "SMPS direct, LDO off, scale 1",
        origin: "schematic, L2 and VDDLDO; RM0399 section 7.4.1; known good",
        proofs: &[REGISTERS],
    },
    Figure {
        name: "clocks",
        value: "25 MHz crystal; core 400 MHz, buses 200 MHz, peripherals 100 MHz",
        origin: "known good; DS12923, operating conditions",
        proofs: &[REGISTERS],
    },
    Figure {
        name: "flash",
        value: "4 wait states, programming delay 3; the manual asks for 2 and 2",
        origin: "RM0399 section 4.3.8; known good",
        proofs: &[
            REGISTERS,
            proof("the_flash_has_time_and_oscillators_that_nothing_uses_are_off", "virtual-prime/tests/firmware.rs"),
        ],
    },
    Figure {
        name: "memory protection",
        value: "flash read-only but for the log of updates, data never executed, the DMA arena never cached, a guard below each stack",
        origin: "ARMv7-M ARM B3.5; PM0253 section 4.6",
        proofs: &[Proof { test: "the_mpu_has_the_regions_of_its_table", file: "tests/on-target/tests/board.rs" }],
    },
    Figure {
        name: "watchdog",
        value: "from the first microseconds on: 10 s in the boot stage, 0.9 s afterwards",
        origin: "RM0399 section 49",
        proofs: &[REGISTERS],
    },
    Figure {
        name: "drivers' bus",
        value: "391 kHz, mode 3, frames of 24 bits of which the chip takes the last 20",
        origin: "TMC2590 data sheet 7.2 and 7.3; known good",
        proofs: &[
            proof("the_drivers_bus_is_mode_3_at_391_khz", MOTORS),
            proof("each_frame_has_24_clocks_within_one_chip_select", MOTORS),
        ],
    },
    Figure {
        name: "words to a TMC2590",
        value: "CHOPCONF 981C0 off, 981C5 on; DRVCONF with SLP2 0, SLPH 3, SLPL 3, passive fast decay, both short detectors, all detectors read",
        origin: "known good; TMC2590 data sheet sections 7.11 and 12.1 for slopes and short detectors",
        proofs: &[proof("a_tmc2590_is_sent_the_words_of_its_table", GOLDEN)],
    },
    Figure {
        name: "words to a TMC2660",
        value: "CHOPCONF 981C0 off, 981C5 on; DRVCONF with SLPH 0, SLPL 0, stallGuard2 read",
        origin: "known good",
        proofs: &[proof("a_tmc2660_is_sent_the_words_of_its_table", GOLDEN)],
    },
    Figure {
        name: "DIR before STEP",
        value: "at least `dir_setup_ns`, 500 ns unless it is written; the chips need 20 ns",
        origin: "TMC2590 and TMC2660 data sheets, STEP and DIR timing",
        proofs: &[proof("dir_is_stable_before_each_step", MOTORS)],
    },
    Figure {
        name: "pulse to an external driver",
        value: "`step_pulse_us`, and as long a pause at least",
        origin: "configuration; known good",
        proofs: &[
            proof("each_pulse_of_an_external_step_pin_is_a_step", MOTORS),
            proof("pulses_of_several_motors_keep_their_length_and_their_pause", "virtual-prime/tests/settings.rs"),
        ],
    },
    Figure {
        name: "heaters and fans",
        value: "sigma-delta, decided every 0.5 ms",
        origin: "known good",
        proofs: &[proof("each_heater_drives_its_own_output_and_no_other", POWER)],
    },
    Figure {
        name: "hardware PWM",
        value: "mode 1, active high, 1000 counts, 10 kHz unless `frequency` is written",
        origin: "RM0399 section 42.4.7; known good",
        proofs: &[proof("hardware_pwm_has_1000_counts_and_is_on_while_high", BUSES)],
    },
    Figure {
        name: "thermistors",
        value: "R / (R + 4.7 kOhm) of full scale, 16 bit, mean of 32",
        origin: "schematic, RN3; VREF+ is the dividers' supply",
        proofs: &[proof("each_thermistor_is_read_at_its_own_input", INPUTS), REGISTERS],
    },
    Figure {
        name: "supply monitors",
        value: "11 times the pin's voltage; `vfet` is measured before the load switch",
        origin: "schematic, R69 to R71, R60 to R62",
        proofs: &[proof("the_supplies_are_read_at_their_own_inputs", INPUTS)],
    },
    Figure {
        name: "converters",
        value: "64 MHz / 6 / 2, 810.5 cycles of sampling, calibrated for offset and linearity",
        origin: "RM0399 section 26; known good (v2 calibrates the offset alone)",
        proofs: &[
            REGISTERS,
            proof("the_converters_are_calibrated_for_linearity_too", "virtual-prime/tests/firmware.rs"),
        ],
    },
    Figure {
        name: "SD card's bus",
        value: "400 kHz, one line, to identify; 25 MHz, four lines, afterwards; 50 MHz where the card has high speed",
        origin: "SD physical layer 9.0, sections 4.2.1 and 6.6.1; known good",
        proofs: &[
            proof("the_card_is_identified_at_400_khz_and_read_at_50_mhz", BUSES),
            proof("every_identification_resets_the_controller_and_powers_the_card_anew", "virtual-prime/tests/card.rs"),
        ],
    },
    Figure {
        name: "serial ports",
        value: "debug console 115200 baud, 8 bits, no parity, 1 stop bit",
        origin: "known good",
        proofs: &[proof("the_consoles_are_8n1_at_their_rates", BUSES)],
    },
];
