//! Forty-odd broken configurations, each with everything `velvet check` says about it.
//!
//! The messages stand in `golden/broken.txt`, to be read like a text. `VELVET_WRITE=1 cargo test -p config`
//! writes it anew: read the difference before you keep it.

mod common;

use common::{SAMPLE, edited};
use config::{BoardId, Diagnostic};

/// The sample with one slip. Each stretch on the left is in the sample once.
const SLIPS: &[(&str, &str, &str)] = &[
    // Slips in names of keys and sections.
    ("a key with a slip", "junction_deviation = 0.02 ", "junction_devation = 0.02 "),
    ("a motor with a slip", "alpha.max_rate = 18000 ", "alhpa.max_rate = 18000 "),
    ("a section with a slip", "[planner]", "[planer]"),
    ("a section that never ends", "[planner]", "[planner"),
    ("a key of another section", "planner_queue_size = 32 ", "x_axis_max_speed = 18000 "),
    ("a name of the previous generation", "planner_queue_size = 32 ", "alpha_steps_per_mm = 80 "),
    ("a key without its instance", "minx.retract = 5 ", "retract = 5 "),
    ("a key no firmware has", "must_be_homed = false ", "colour = blue "),
    // Slips in values of settings.
    ("a value with its unit", "default_feed_rate = 3000 ", "default_feed_rate = 3000 mm/min "),
    ("a decimal comma", "junction_deviation = 0.02 ", "junction_deviation = 0,02 "),
    ("a comment of another language", "default_feed_rate = 3000 ", "default_feed_rate = 3000 ; mm/min "),
    ("a missing value", "default_seek_rate = 9000 ", "default_seek_rate = "),
    ("a line without =", "default_seek_rate = 9000 ", "default_seek_rate 9000 "),
    ("yes for true", "must_be_homed = false ", "must_be_homed = yes "),
    ("a word that does not exist", "arm_solution = cartesian", "arm_solution = cartesain"),
    ("a number beyond its range", "planner_queue_size = 32 ", "planner_queue_size = 10000 "),
    ("a whole number with two points", "delta.microsteps = 16", "delta.microsteps = 16.5.5"),
    ("an octal number", "planner_queue_size = 32 ", "planner_queue_size = 032 "),
    ("microsteps no driver has", "beta.microsteps = 16", "beta.microsteps = 10"),
    ("a code that is none", "fan.input_on_command = M106", "fan.input_on_command = 106"),
    ("a thermistor nobody knows", "hotend.thermistor = Semitec-104NT4", "hotend.thermistor = Semitek-104NT4"),
    // Values in a wrong unit.
    ("a homing speed in mm/min", "minx.fast_rate = 50 ", "minx.fast_rate = 3000 "),
    ("a motor speed in mm/s", "alpha.max_rate = 18000 ", "alpha.max_rate = 300 "),
    ("a driver current in amperes", "gamma.max_current = 3000", "gamma.max_current = 3"),
    ("a motor current in milliamperes", "alpha.current = 1.2 ", "alpha.current = 1200 "),
    ("a motor that asks for too many steps", "delta.max_rate = 3600", "delta.max_rate = 36000"),
    // Slips in names of pins.
    ("a pin without its P", "fan.output_pin = PE1 ", "fan.output_pin = E1 "),
    ("a pin with two owners", "fan.output_pin = PE1 ", "fan.output_pin = PE3 "),
    ("a pin of the SD card", "fan.output_pin = PE1 ", "fan.output_pin = PC8 "),
    ("a pin of a bus", "fan.output_pin = PE1 ", "fan.output_pin = PE12 "),
    ("a pin of the UART in use", "fan.output_pin = PE1 ", "fan.output_pin = PD8 "),
    ("a pin that must be open drain", "fets_enable_pin = PF14!o ", "fets_enable_pin = PF14! "),
    ("two sensors on one input", "bed.thermistor_pin = ADC1_3 ", "bed.thermistor_pin = ADC1_0 "),
    ("a sensor on a switch's pin", "minx.pin = PD0^ ", "minx.pin = PF11^ "),
    ("an output type its pin cannot do", "fan.output_type = sigmadeltapwm", "fan.output_type = hwpwm"),
    ("two homing switches on one interrupt line", "miny.pin = PI1^ ", "miny.pin = PJ0^ "),
    // Contradictions within the whole file.
    ("a setting written twice", "bed.max_temp = 120", "bed.max_temp = 120\nbed.max_temp = 110"),
    (
        "a slave with other steps",
        "[tmc2590]\n",
        "epsilon.steps_per_mm = 200\nepsilon.driver = tmc2590\nepsilon.microsteps = 16\nepsilon.step_pin = PJ1\nepsilon.dir_pin = PJ5\nepsilon.slaved_to = gamma\n\n[tmc2590]\nepsilon.spi_cs_pin = PJ6\n",
    ),
    ("travel that ends before it begins", "[switch]\n", "[soft endstop]\nx_min = 200\nx_max = 0\n\n[switch]\n"),
    ("travel without the place where the axis homes", "[switch]\n", "[soft endstop]\nx_min = 5\n\n[switch]\n"),
    ("a heater without a sensor", "bed.thermistor_pin = ADC1_3 ", "bed.thermistor_pin = nc "),
    ("a maximum below the minimum", "bed.max_temp = 120", "bed.max_temp = 4"),
    (
        "a runaway check switched off",
        "bed.runaway_range = 15\nbed.runaway_heating_timeout = 900",
        "bed.runaway_range = 0\nbed.runaway_heating_timeout = 0",
    ),
    ("a current the sense resistor cannot measure", "gamma.sense_resistor = 50", "gamma.sense_resistor = 500"),
    ("a driver without an entry", "delta.driver = tmc2590", "delta.driver = tmc2660"),
    ("a tool without a motor", "hotend.tool_id = 0                     # T0", "hotend.tool_id = 2 # T0"),
    ("an axis with two homing switches", "minx.axis = X", "minx.axis = Y"),
    ("a switch at the wrong end", "miny.homing_position = 0", "miny.homing_position = 200"),
    (
        "a switch that says the opposite of its name",
        "minz.axis = Z\nminz.homing_direction = home_to_min\nminz.homing_position = 0",
        "minz.axis = Z\nminz.homing_direction = home_to_max\nminz.homing_position = 180",
    ),
    ("an instance that nothing enables", "[temperature control]", "[temperature control]\nhotnd.max_temp = 250"),
    ("an enable that the board has elsewhere", "fets_power_enable_pin = PD7 ", "fets_power_enable_pin = PJ5 "),
    ("what needs no setting", "arm_solution = cartesian", "arm_solution = cartesian\narc_correction = 20"),
    ("a delta whose towers differ", "arm_solution = cartesian", "arm_solution = linear_delta"),
];

/// Sections at the end of the sample.
const ADDITIONS: &[(&str, &str)] = &[
    ("a section written twice", "[player]\nafter_suspend_gcode = M5\n"),
    ("a probe without a pin", "[zprobe]\nenable = true\n"),
    (
        "a probe that is pressed too far",
        "[zprobe]\nenable = true\nprobe_pin = PB10^\nslow_feedrate = 45\nfast_feedrate = 40\n",
    ),
    (
        "a probe that is not lifted",
        "[zprobe]\nenable = true\nprobe_pin = PB10^\nprobe_height = 0\nleveling = three point\n",
    ),
    (
        "a mesh that its interpolation does not take",
        "[zprobe]\nenable = true\nprobe_pin = PB10^\nleveling = cartesian grid\n[cartesian grid leveling strategy]\nx_size = 100\ny_size = 80\n\n[bed mesh]\ninterpolation = lagrange\n",
    ),
    ("half a faulty region", "[bed mesh]\nfaulty_regions = 10,10 30,25 50,60\n"),
    ("a faulty region without a width", "[bed mesh]\nfaulty_regions = 10,10 10,25\n"),
    ("a height zero that must not be touched", "[bed mesh]\nfaulty_regions = 30,25 10,10\nzero_reference = 20,20\n"),
    ("a key that is none", "[update]\nkey = 0123456789abcdef\n"),
    ("a lock without a key", "[update]\nlocked = true\n"),
    ("a kill button without a pin", "[kill button]\nenable = true\n"),
    ("a section of another firmware", "[stepper_x]\nstep_pin = PD3\nrotation_distance = 40\n"),
    (
        "two switches on one timer channel",
        "[pwm1]\nfrequency = 5000\n\n[switch]\na.enable = true\na.output_pin = PWM1_1\na.output_type = hwpwm\na.input_on_command = M3\nb.enable = true\nb.output_pin = PE9\nb.output_type = digital\nb.input_on_command = M8\n",
    ),
    ("a part that nothing reads yet", "[st7920]\nenable = true\n"),
    ("file transfer, which is not there yet", "[network]\nenable = true\nftp_enable = true\n"),
    (
        "texts that are no addresses",
        "[network]\nenable = true\nip_address = 192.168.1\nip_gateway = 192.168.1.256\ndns_server = router\n",
    ),
    ("a netmask with a hole", "[network]\nenable = true\nip_address = 192.168.1.5\nip_mask = 255.0.255.0\n"),
    ("an address for all", "[network]\nenable = true\nip_address = 192.168.1.255\n"),
    ("a gateway elsewhere", "[network]\nenable = true\nip_address = 10.0.0.5\n"),
    ("a name with a blank", "[network]\nenable = true\nhostname = my machine\n"),
    (
        "a console at the page's port",
        "[network]\nenable = true\nshell_enable = true\nwebserver_enable = true\nwebserver_port = 23\n",
    ),
    ("two consoles at one port", "[network]\nenable = true\nshell_enable = true\ngrbl_enable = true\ngrbl_port = 23\n"),
    ("a rule without anything to watch or to do", "[temperature switch]\nhotend.enable = true\n"),
    (
        "two rules that contend for a switch",
        "[temperature switch]\na.enable = true\na.designator = T\na.switch = fan\nb.enable = true\nb.designator = B\nb.switch = fan\n",
    ),
    ("a fan that codes switch too", "[fan]\nfan.enable = true\nfan.follows = heaters\nfan.sensors = hotnd\n"),
    (
        "a fan without a switch",
        "[fan]\npump.enable = true\npump.stopped_after = 3\npump.max_power = 10\npump.min_power = 20\n",
    ),
    ("a button without a pin", "[button box]\none.press = M24\n"),
    ("a button that halts too late", "[button box]\none.pin = PB7^\none.press = KILL\none.long_press = M24\n"),
    (
        "a spindle that only turns the other way, with a least speed above the greatest",
        "[pwm1]\nfrequency = 5000\n\n[switch]\nspindle.enable = true\nspindle.output_pin = PWM1_1\nspindle.output_type = hwpwm\nspindle.input_reverse_command = M4\nspindle.input_off_command = M5\nspindle.max_rpm = 6000\nspindle.min_rpm = 8000\n",
    ),
    (
        "a spindle with speeds on an output without",
        "[switch]\nspindle.enable = true\nspindle.output_pin = PI4\nspindle.output_type = digital\nspindle.input_on_command = M3\nspindle.max_rpm = 6000\n",
    ),
    (
        "a servo whose pulses do not fit",
        "[pwm1]\nfrequency = 5000\n\n[switch]\narm.enable = true\narm.output_pin = PWM1_1\narm.output_type = hwpwm\narm.input_on_command = M280\narm.servo_max_angle = 180\n",
    ),
    ("a function that is still to come", "[lathe]\nenable = true\nindex_pin = PD15\n"),
    ("a laser without a pin", "[laser]\nenable = true\n"),
    (
        "a laser on a timer that a switch is on",
        "[pwm1]\nfrequency = 20000\n\n[switch]\nspindle.enable = true\nspindle.output_pin = PWM1_2\nspindle.output_type = hwpwm\nspindle.input_on_command = M3\n\n[laser]\nenable = true\npwm_pin = PWM1_1\npwm_frequency = 5000\n",
    ),
    (
        "a laser on a timer that sends to lights",
        "[led strip]\nbed.enable = true\nbed.pin = PWM2_1\n\n[laser]\nenable = true\npwm_pin = PWM2_3\n",
    ),
    (
        "a laser whose powers contradict each other",
        "[laser]\nenable = true\npwm_pin = PWM2_1\nmaximum_power = 0.2\nminimum_power = 0.3\ndefault_power = 5\npower_table = 0,0 0.5,0.6 0.4,1\n",
    ),
    (
        "a laser that is too fast",
        "[pwm2]\nfrequency = 80000\n\n[laser]\nenable = true\npwm_pin = PWM2_1\npower_table = 0.5,0.5\n",
    ),
    (
        "a laser that names switches which are none",
        "[laser]\nenable = true\npwm_pin = PWM2_1\ninterlock_switches = lid, fan\nair_switch = compressor\n",
    ),
    (
        "an external driver that steps faster than its pulses",
        "[system]\nstep_pulse_us = 20\n[actuator]\nepsilon.driver = external\nepsilon.steps_per_mm = 400\nepsilon.max_rate = 6000\nepsilon.step_pin = PJ5\nepsilon.dir_pin = PJ1\n",
    ),
];

fn cases() -> Vec<(&'static str, String)> {
    let slips = SLIPS.iter().map(|&(title, from, to)| (title, edited(from, to)));
    let additions = ADDITIONS.iter().map(|&(title, text)| (title, format!("{SAMPLE}\n{text}")));
    slips.chain(additions).collect()
}

fn checked(text: &str) -> String {
    let mut findings: Vec<Diagnostic> = Vec::new();
    let (_, summary) = config::parse(text.as_bytes(), BoardId::Prime2590, &mut findings);
    config::render_all(&findings, summary, "config.ini", text)
}

fn book() -> String {
    let head = "What velvet check says about broken configurations: the Cartesian sample with one slip each.\n";
    cases().iter().fold(head.to_owned(), |book, (title, text)| format!("{book}\n=== {title}\n\n{}", checked(text)))
}

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/broken.txt");

#[test]
fn every_broken_file_is_told_about_as_the_book_says() {
    let fresh = book();
    if std::env::var_os("VELVET_WRITE").is_some() {
        std::fs::write(GOLDEN, &fresh).unwrap();
    }
    let golden = std::fs::read_to_string(GOLDEN).unwrap();
    let chapters = |text: &str| text.split("\n=== ").map(str::to_owned).collect::<Vec<_>>();
    for (golden, fresh) in chapters(&golden).into_iter().zip(chapters(&fresh)) {
        assert_eq!(fresh, golden);
    }
    assert_eq!(fresh.len(), golden.len());
}

/// A message is for a person: it has a place to look at, a reason, and a fix.
#[test]
fn every_broken_file_gets_a_message_with_a_place_and_a_fix() {
    assert!(cases().len() >= 40);
    for (title, text) in cases() {
        let mut findings: Vec<Diagnostic> = Vec::new();
        config::parse(text.as_bytes(), BoardId::Prime2590, &mut findings);
        assert!(!findings.is_empty() && findings.len() <= 3, "{title}: {findings:#?}");
        for finding in findings {
            assert!(finding.line > 0 && !finding.reason.is_empty() && !finding.fix.is_empty(), "{title}: {finding}");
            assert!(finding.reason.len() < finding.reason.capacity(), "{title}: cut: {finding}");
            assert!(finding.fix.len() < finding.fix.capacity(), "{title}: cut: {finding}");
        }
    }
}
