//! Settings that only the board can test: pins, timers, serial ports, and the cost of loading the
//! configuration. The rows of `tests/tests/every_setting` that say `Board` point here.

use crate::common::velvet::{CONFIG, Plan, SECOND, Velvet};
use rigless::mcu::Mcu;
use rigless::soc::stm32h743::generated::usart1;
use units::Actuator::{Alpha, Delta};

/// Plans the sample with every movable function on another connector.
fn moved() -> Plan {
    [
        "[extruder] hotend.enable = false",
        "[actuator] delta.driver = external",
        "[actuator] delta.step_pin = PJ5",
        "[actuator] delta.dir_pin = PJ1!",
        "[actuator] delta.en_pin = PJ3",
        "[actuator] delta.steps_per_mm = 100",
        "[current control] delta.current",
        "[temperature control] hotend.heater_pin = PB8",
        "[temperature control] hotend.thermistor_pin = ADC1_2",
        "[endstops] minx.pin = PJ9^",
        "[switch] fan.output_pin = PB9",
        "[switch] button.enable = true",
        "[switch] button.input_pin = PB7^",
        "[switch] button.output_on_command = M106 S255",
        "[kill button] enable = true",
        "[kill button] pin = PJ6^",
        "[filament detector] enable = true",
        "[filament detector] detector_pin = PD14^",
        "[filament detector] encoder_pin = PD12^",
    ]
    .into_iter()
    .fold(Plan::new(), Plan::set)
}

fn press(velvet: &mut Velvet, name: &str, pressed: bool) {
    let at_ns = velvet.bench.vm.now_ns();
    velvet.world(|world| world.press(at_ns, name, pressed)).expect("a button of this machine");
    velvet.hear(100);
}

fn position(velvet: &mut Velvet, motor: units::Actuator) -> f64 {
    velvet.world(|world| world.carriage_mm(motor)).expect("a motor of this machine")
}

#[test]
fn every_pin_is_the_one_that_the_configuration_names() {
    let mut velvet = moved().start();
    velvet.ask("M104 S60", SECOND);
    velvet.ask("G28 X", 60 * SECOND);
    let homed = position(&mut velvet, Alpha);
    assert!(homed.abs() < 0.05, "the switch of X is at PJ9: {homed}");
    velvet.ask("G91", SECOND);
    let before = position(&mut velvet, Delta);
    velvet.ask("G1 A5 F600", SECOND);
    velvet.ask("M400", 10 * SECOND);
    let way = position(&mut velvet, Delta) - before;
    assert!((way - 5.0).abs() < 0.02, "step_pin, dir_pin and en_pin of an external driver: {way}");
    let hotend = velvet.world(|world| world.heater_index("hotend")).expect("a hotend");
    assert!(velvet.world(|world| world.heater_c(hotend)) > 25.0, "heater_pin and thermistor_pin of the hotend");
    press(&mut velvet, "button", true);
    velvet.hear(SECOND);
    assert!(velvet.world(|world| world.fan_speed(0)) > 0.9, "input_pin of the button, output_pin of the fan");
    press(&mut velvet, "filament", true);
    velvet.hear(SECOND);
    assert!(velvet.said().contains("// NOTE the filament has run out"), "detector_pin: {}", velvet.said());
    press(&mut velvet, "filament wheel", true);
    let said = velvet.ask("M407", SECOND);
    assert!(said.contains("Encoder pulses: 1"), "encoder_pin: {said}");
    press(&mut velvet, "kill", true);
    assert!(velvet.said().contains("ALARM: Kill button pressed"), "pin of the kill button: {}", velvet.said());
}

#[test]
fn a_reversed_motor_turns_the_other_way() {
    for line in ["[actuator] alpha.reversed = true", "[actuator] alpha.dir_pin = PD4!"] {
        let mut velvet = Plan::new().built().set(line).start();
        let before = position(&mut velvet, Alpha);
        velvet.ask("G91", SECOND);
        velvet.ask("G1 X2 F600", SECOND);
        velvet.ask("M400", 10 * SECOND);
        let way = position(&mut velvet, Alpha) - before;
        assert!((way + 2.0).abs() < 0.02, "{line}: {way}");
    }
}

/// Setting `reset_pin`: the reset line is raised before the first word to a driver, and for good.
#[test]
fn the_reset_line_of_a_driver_board_is_raised_at_boot() {
    for (pin, level) in [("PJ9", true), ("PJ9!", false)] {
        let mut velvet = Plan::new().set(&format!("[tmc2590] common.reset_pin = {pin}")).start();
        assert_eq!(velvet.level("PJ9"), level, "{pin}");
        velvet.ask("M112", SECOND);
        velvet.hear(SECOND);
        assert_eq!(velvet.level("PJ9"), level, "{pin}, halted");
    }
}

#[test]
fn a_driver_is_asked_at_its_spi_cs_pin() {
    let mut velvet = Plan::new().set("[tmc2590] alpha.spi_cs_pin = PJ12").start();
    velvet.hear(SECOND);
    assert!(velvet.said().contains("motor driver alpha does not answer"), "{}", velvet.said());
}

/// Setting `frequency` of `[pwm1]` and `[pwm2]`.
#[test]
fn timers_run_at_their_frequency() {
    for (timer, section, pin, hertz) in [(0, "pwm1", "PWM1_1", 500.0), (1, "pwm2", "PWM2_2", 4_000.0)] {
        let lines = [
            format!("[{section}] frequency = {hertz}"),
            "[switch] spindle.enable = true".into(),
            format!("[switch] spindle.output_pin = {pin}"),
            "[switch] spindle.output_type = hwpwm".into(),
            "[switch] spindle.input_on_command = M3".into(),
            "[switch] spindle.input_off_command = M5".into(),
        ];
        let mut velvet = lines.iter().fold(Plan::new(), |plan, line| plan.set(line)).start();
        velvet.ask("M3 S25", SECOND);
        velvet.hear(50);
        let channel = usize::from(timer == 1);
        let (rate, duty) = velvet.world(|world| (world.pwm_hz(timer), world.pwm_duty(timer, channel)));
        assert!((rate - hertz).abs() < hertz * 0.01 && (duty - 0.25).abs() < 0.01, "{section}: {rate} Hz at {duty}");
    }
}

/// Settings of `[uart console]`: `enable`, `console`, `channel`, `baudrate`, `bits`, `stop_bits`, `parity`.
#[test]
fn the_auxiliary_uart_is_what_the_configuration_says() {
    // Bytes at USART3 after 50 ms, at it and at UART4 after 200 ms; and how USART3 is set up.
    let seen = |lines: &[&str]| {
        let mut velvet = lines.iter().fold(Plan::new(), |plan, line| plan.set(line)).start();
        let ports = [1, 2].map(|port| {
            let look = velvet.bench.vm.with(move |stopped| stopped.session.board().console(port).clone());
            look.expect("the run goes on")
        });
        for port in &ports {
            port.receive();
            port.send(b"help\n");
        }
        velvet.hear(50);
        let early = ports[0].receive().len();
        velvet.hear(150);
        (early, early + ports[0].receive().len(), ports[1].receive().len(), frame(&mut velvet))
    };
    let on = |more: &[&'static str]| [&["[uart console] enable = true"], more].concat();
    let (fast, usart3, uart4, plain) = seen(&on(&[]));
    assert!(usart3 > 100, "channel 0 is USART3");
    assert_eq!(uart4, 0, "and not UART4");
    assert_eq!(plain, (8, 0, 0, 0));
    assert!(seen(&on(&["[uart console] channel = 1"])).2 > 100, "channel 1 is UART4");
    assert_eq!(seen(&["[uart console] enable = false"]).1, 0);
    let slow = seen(&on(&["[uart console] baudrate = 9600"])).0;
    assert!(slow > 10 && slow < 60 && fast > 3 * slow, "{fast} bytes at 115200 baud, {slow} at 9600");
    let sends =
        seen(&on(&["[uart console] console = false", "[uart console] bits = 7", "[uart console] stop_bits = 2"]));
    assert_eq!(sends.1, 0, "it only sends");
    assert_eq!(sends.3, (7, 0, 0, 2));
    assert_eq!(seen(&on(&["[uart console] bits = 9", "[uart console] parity = odd"])).3, (9, 1, 1, 0));
    assert_eq!(seen(&on(&["[uart console] parity = even"])).3, (8, 1, 0, 0));
}

/// Reads the frame format of USART3 from the port's registers (RM0399 section 51.8), M1 and M0, PCE, PS in
/// CR1, STOP in CR2: number of bits, whether one is of parity and whether that is odd, and stop bits.
fn frame(velvet: &mut Velvet) -> (u8, u64, u64, u64) {
    let registers = velvet.bench.vm.with(|stopped| {
        let bus = stopped.session.board().mcu.bus();
        bus.registers("USART3").map(|file| (file.get(usart1::Register::Cr1), file.get(usart1::Register::Cr2)))
    });
    let (cr1, cr2) = registers.flatten().expect("a port of the chip");
    let length = match (cr1 >> 28 & 1, cr1 >> 12 & 1) {
        (0, 0) => 8,
        (0, 1) => 9,
        _ => 7,
    };
    (length, cr1 >> 10 & 1, cr1 >> 9 & 1, cr2 >> 12 & 3)
}

/// An error in the bed's settings disables only the bed: its output is not driven, and the rest of the
/// machine works.
#[test]
fn a_broken_bed_stays_off_and_the_machine_moves() {
    let mut velvet = Plan::new().set("[temperature control] bed.max_temp = hot").start();
    assert!(velvet.said().contains("these stay off: temperature control bed\n"), "{}", velvet.said());
    let said = velvet.ask("M140 S60", SECOND);
    assert!(said.starts_with("error:temperature control bed is off: see [temperature control] bed.max_temp"), "{said}");
    velvet.ask("M104 S60", SECOND);
    velvet.ask("G28 X", 60 * SECOND);
    assert!(position(&mut velvet, Alpha).abs() < 0.05);
    let of = |velvet: &mut Velvet, name: &str| {
        velvet
            .world(|world| world.heater_index(name).map(|index| (world.heater_c(index), world.heater_mean_duty(index))))
    };
    let (bed, hotend) = (of(&mut velvet, "bed").expect("a bed"), of(&mut velvet, "hotend").expect("a hotend"));
    assert!(bed.1 == 0.0 && hotend.0 > 25.0, "bed {bed:?}, hotend {hotend:?}");
}

/// Returns the milliseconds and bytes in the answer to `mem`.
fn cost(velvet: &mut Velvet) -> (f64, f64) {
    velvet.type_in("mem");
    let said = velvet.hear_until(" bytes\n", SECOND) + &velvet.hear(100);
    let line = said.lines().find_map(|line| line.strip_prefix("configuration: read in ")).expect("what it cost");
    let mut numbers = line.split(' ').filter_map(|word| word.parse().ok());
    (numbers.next().expect("milliseconds"), numbers.next().expect("bytes"))
}

/// Returns the sample with other settings appended up to 300 lines.
fn three_hundred_lines() -> String {
    let switches: String = (0..14)
        .flat_map(|n| {
            ["enable = false", "output_pin = PJ1", "output_type = digital", "input_on_command = M106"]
                .map(|line| format!("s{n}.{line}\n"))
        })
        .collect();
    let text = CONFIG.replace("[endstops]", &format!("{switches}[endstops]"));
    let missing = 300_usize.saturating_sub(text.lines().count());
    (0..missing).fold(text, |text, n| format!("{text}# comment {n}\n"))
}

#[test]
fn three_hundred_lines_load_within_200_ms() {
    let text = three_hundred_lines();
    assert!(text.lines().count() >= 300);
    let mut velvet = Plan::new().config(&text).start();
    let (ms, bytes) = cost(&mut velvet);
    println!("{} lines: {ms} ms, {bytes} bytes", text.lines().count());
    assert!(ms < 200.0, "{ms} ms");
    assert!(bytes < 48.0 * 1_024.0, "{bytes} bytes");
    velvet.ask("G28 X", 60 * SECOND);
}

/// The largest possible configuration file takes no more memory, and the machine works.
#[test]
fn a_file_of_64_kib_loads_within_the_same_memory() {
    let comments = "# what somebody wanted to remember about this machine, at length\n".repeat(2_000);
    let text = format!("{CONFIG}{comments}").chars().take(64 * 1_024).collect::<String>();
    let mut velvet = Plan::new().config(&text).start();
    let (ms, bytes) = cost(&mut velvet);
    println!("64 KiB: {ms} ms, {bytes} bytes");
    assert!(bytes < 48.0 * 1_024.0, "{bytes} bytes");
    velvet.ask("G28 X", 60 * SECOND);
    assert_eq!(velvet.bench.vm.complaints(), Vec::<String>::new());
}

#[test]
fn pulses_of_several_motors_keep_their_length_and_their_pause() {
    // Pulses are 10 us high and 10.5 us low at least: 45,000 steps/s leave 1.7 us. The pulses of both drift
    // through one another.
    let external = "\n[actuator]\nepsilon.steps_per_mm = 1000\nepsilon.max_rate = 2700\nepsilon.acceleration = 3000\nepsilon.step_pin = PG0\nepsilon.dir_pin = PG1\n\
        zeta.steps_per_mm = 997\nzeta.max_rate = 2700\nzeta.acceleration = 3000\nzeta.step_pin = PA4\nzeta.dir_pin = PJ3\n[system]\nstep_pulse_us = 10\n";
    let mut velvet = Plan::new().config(&format!("{}{external}", crate::common::velvet::CONFIG)).start();
    velvet.ask("G28.3 X0 Y0 Z0 B0 C0", SECOND);
    let answer = velvet.ask("G1 B45 C45 F3818", SECOND);
    assert_eq!(answer, "ok\n");
    velvet.hear(2_000);
    for (motor, steps) in [(units::Actuator::Epsilon, 45_000), (units::Actuator::Zeta, 44_865)] {
        assert_eq!(velvet.world(|world| world.trace().tally(motor).net_steps), steps, "{}", motor.name());
    }
    assert_eq!(velvet.world(|world| world.timing_faults()), 0, "pulses or pauses that are too short");
    let said = velvet.ask("get steps", SECOND);
    let fastest = velvet.world(|world| world.trace().tally(units::Actuator::Epsilon).max_steps_per_s);
    assert!(fastest > 44_000.0, "only {fastest} steps/s");
    assert!(said.contains("delayed: 0\n"), "{said}");
}

/// The chip's temperature is computed from the factory's readings at 30 and at 110 degrees; the sensor's
/// millivolt is half a degree.
#[test]
fn the_chip_s_temperature_is_what_it_is() {
    let mut velvet = Plan::new().start();
    let answer = velvet.ask("get temp chip", 500);
    let celsius = answer.trim().strip_prefix("chip temp: ").and_then(|rest| rest.split_whitespace().next());
    let celsius: f64 = celsius.and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{answer}"));
    assert!((celsius - 46.0).abs() < 0.6, "{answer}");
}
