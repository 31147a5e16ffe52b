//! `[temperature control]`

use super::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, new_name, number, numbers, pin, places, text, word};
use super::heat_control as control;
use super::spi_sensors as spi;
use super::{ByName, CannotCreate, Docs, Form, Instances, PinRole, Section, Words};
use crate::machine::{MAX_TEMPERATURES, MAX_VOLTAGE_POINTS, SensorKind, TemperatureConfig, ToolId};
use crate::pin::PinName;
use units::{Celsius, Duty, Micros, Ohms, Volts};

/// Built-in thermistors: Steinhart-Hart entries first, then those that are known by their beta only. A name
/// in both tables means the first, unless `use_beta_table` is set.
pub const THERMISTORS: &Words = &Words(&[
    "EPCOS100K",
    "Vishay100K",
    "Honeywell100K",
    "Semitec",
    "Honeywell-QAD",
    "Semitec-104NT4",
    "RRRF100K",
    "RRRF10K",
    "HT100K",
]);

/// `|heater, value| ...` on the controller at the instance's place.
macro_rules! heater {
    (|$heater:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($heater) = c.temperatures.get_mut(i) {
                $body;
            }
        }
    };
}

pub(super) use heater;

fn positive_seconds(seconds: i64) -> Option<Micros> {
    (seconds > 0).then(|| Micros::from_seconds(seconds.unsigned_abs()))
}

fn three_points(v: &[f64]) -> Option<[(f64, f64); 3]> {
    match v {
        &[t1, r1, t2, r2, t3, r3] => Some([(t1, r1), (t2, r2), (t3, r3)]),
        _ => None,
    }
}

pub const TEMPERATURE_CONTROL: Section = Section {
    name: "temperature control",
    store: None,
    docs: Docs::new("Heaters and temperature sensors. The names hotend, hotend2, bed and board have the Prime's pins, labels \
              and tool numbers as defaults."),
    form: Form::Named(Instances {
        noun: "temperature control",
        find: |c, name| c.temperatures.iter().position(|heater| heater.name == name),
        create: |c, name| {
            let heater = TemperatureConfig { name: new_name(name)?, ..TemperatureConfig::default() };
            c.temperatures.push(heater).map_err(|_| CannotCreate::Full(MAX_TEMPERATURES))?;
            Ok(c.temperatures.len() - 1)
        },
        name: |c, i| c.temperatures.get(i).map_or("", |heater| heater.name.as_str()),
        is_live: |c, i| c.temperatures.get(i).is_some_and(|heater| heater.enable),
    }),
    settings: &[
        bool("enable", "false", heater!(|h, v| h.enable = v), "There is such a heater or sensor.")
            .v1("temperature_control.<name>.enable"),
        integer(
            "tool_id",
            "255",
            &(0, 255),
            heater!(|h, v| h.tool_id = ToolId(v as u8)),
            "Number of the heater in M-codes. 250 and above stay active whatever tool is selected; below 100 the \
             M-codes are those of a hotend, else those of a bed.",
        )
        .by_name(&ByName(&[("hotend", "0"), ("hotend2", "1"), ("bed", "254"), ("board", "253")]))
        .derived("hotend 0, hotend2 1, bed 254, board 253; another one, or one with 255: 253 less the enabled ones before it in the order of names"),
        text(
            "designator",
            "?",
            8,
            heater!(|h, v| h.designator = heapless::String::try_from(v).unwrap_or_default()),
            "Label in temperature reports. Hosts expect T for the hotend and B for the bed.",
        )
        .by_name(&ByName(&[("hotend", "T"), ("hotend2", "T2"), ("bed", "B"), ("board", "P")]))
        .v1("temperature_control.<name>.designator"),
        word(
            "sensor",
            "thermistor",
            &Words(&SensorKind::WORDS),
            heater!(|h, v| h.sensor.kind = SensorKind::ALL.get(v).copied().unwrap_or_default()),
            "Kind of sensor: a thermistor; platinum of 100 or 1000 Ohm straight on the input, r2 its pull-up; a \
             thermocouple with an AD8494 to AD8497; or anything else that gives a voltage, by its voltage_curve. On SPI, \
             thermocouples with a MAX31855 or MAX31856, platinum with a MAX31865. The converter of the board may be off by 0.2 % of 3.3 V: 3.4 C for a pt1000, 26 C for a \
             pt100, 1.3 C for an ad849x. max, min, mean and difference combine the sensors of other temperature controls; \
             chip is the microcontroller's own, for reports and fans.",
        ),
        text(
            "sensors",
            "",
            96,
            heater!(|h, v| h.combines = heapless::String::try_from(v).unwrap_or_default()),
            "Of max, min, mean and difference: the names of the temperature controls to combine, commas between; \
             difference is the first less the second. When one of them fails, it fails.",
        )
        .velvet(),
        number(
            "sensor_filter",
            "0",
            &(0.0, 60.0),
            heater!(|h, v| h.sensor.filter_s = v as f32),
            "Time constant of a low-pass filter between sensor and control; 0: none. Readings are that much late: a \
             steady rise is seen so many seconds later, a jump to 63 % after it and to 95 % after three times it. \
             Heat safety sees the sensor unfiltered.",
        )
        .unit("s")
        .velvet(),
        pin(
            "thermistor_pin",
            "nc",
            PinRole::Thermistor,
            heater!(|h, v| h.sensor.thermistor.input = v.and_then(PinName::thermistor)),
            "Input of the thermistor or other analogue sensor. ADC1_1, ADC1_2, ADC1_3 are connectors T1, T2, T3, with a \
             pull-up of 4.7 kOhm; ADC1_0 is on the board; ADC1_4, ADC1_5, ADC1_6 are on the header, without a pull-up.",
        )
        .klipper("[extruder] sensor_pin")
        .by_name(&ByName(&[("hotend", "ADC1_1"), ("hotend2", "ADC1_2"), ("bed", "ADC1_3"), ("board", "ADC1_0")]))
        .v1("temperature_control.<name>.thermistor_pin"),
        word(
            "thermistor",
            "",
            THERMISTORS,
            heater!(|h, v| h.sensor.thermistor.table = THERMISTORS.0.get(v).copied()),
            "A built-in thermistor by name, with its beta, r0, r1 and r2 where those are not written. Without one, rt_curve, \
             coefficients or beta must describe it.",
        )
        .klipper("[extruder] sensor_type")
        .v1("temperature_control.<name>.thermistor"),
        bool(
            "use_beta_table",
            "false",
            heater!(|h, v| h.sensor.thermistor.use_beta_table = v),
            "Take the named thermistor's beta value instead of its Steinhart-Hart coefficients.",
        )
        .v1("temperature_control.<name>.use_beta_table"),
        number("beta", "4066", POSITIVE, heater!(|h, v| h.sensor.thermistor.beta_k = v), "Beta of the thermistor.")
            .unit("K")
            .v1("temperature_control.<name>.beta"),
        number(
            "r0",
            "100000",
            POSITIVE,
            heater!(|h, v| h.sensor.thermistor.r0 = Ohms(v as f32)),
            "Resistance at t0. A reading above eight times this counts as a broken wire.",
        )
        .unit("Ohm")
        .v1("temperature_control.<name>.r0"),
        number(
            "t0",
            "25",
            &(-273.0, 1_000.0),
            heater!(|h, v| h.sensor.thermistor.t0 = Celsius(v as f32)),
            "Temperature at which the thermistor has r0.",
        )
        .unit("C")
        .v1("temperature_control.<name>.t0"),
        number(
            "r1",
            "0",
            NOT_NEGATIVE,
            heater!(|h, v| h.sensor.thermistor.r1 = Ohms(v as f32)),
            "A resistor in parallel with the thermistor or platinum sensor; 0 for none.",
        )
        .unit("Ohm")
        .v1("temperature_control.<name>.r1"),
        number(
            "r2",
            "4700",
            POSITIVE,
            heater!(|h, v| h.sensor.thermistor.r2 = Ohms(v as f32)),
            "Pull-up resistor of the divider; on the board it is 4.7 kOhm.",
        )
        .klipper("[extruder] pullup_resistor")
        .unit("Ohm")
        .v1("temperature_control.<name>.r2"),
        numbers(
            "coefficients",
            3,
            heater!(|h, v| h.sensor.thermistor.coefficients = <[f64; 3]>::try_from(v).ok()),
            "Steinhart-Hart coefficients c1,c2,c3 of the thermistor.",
        )
        .v1("temperature_control.<name>.coefficients"),
        numbers(
            "rt_curve",
            6,
            heater!(|h, v| h.sensor.thermistor.rt_curve = three_points(v)),
            "Three points temperature,resistance of the thermistor's curve. Stronger than coefficients.",
        )
        .unit("C,Ohm")
        .v1("temperature_control.<name>.rt_curve"),
        number(
            "amplifier_offset",
            "0",
            &(0.0, 3.3),
            heater!(|h, v| h.sensor.amplifier_offset = Volts(v as f32)),
            "Output of an ad849x at 0 C: the voltage of its REF pin, 1.25 on many breakout boards. With 0 it reads \
             nothing below 1.4 C.",
        )
        .unit("V")
        .velvet(),
        places(
            "voltage_curve",
            MAX_VOLTAGE_POINTS,
            |c, i, v| {
                if let Some(heater) = c.temperatures.get_mut(i) {
                    heater.sensor.voltage_points = core::array::from_fn(|point| v.get(point).copied());
                }
            },
            "Two points or more temperature,voltage of a sensor = voltage: straight between them, and on beyond the outer \
             ones. Below 7 mV and above 3.293 V is a broken wire.",
        )
        .unit("C,V")
        .velvet(),
        spi::SPI_CHANNEL,
        spi::SPI_SELECT_PIN,
        spi::TC_TYPE,
        spi::TC_AVERAGING,
        spi::MAINS_FREQUENCY,
        spi::RTD_WIRES,
        spi::RTD_NOMINAL,
        spi::RTD_REFERENCE,
        pin(
            "heater_pin",
            "nc",
            PinRole::Output,
            heater!(|h, v| h.heater_pin = v.and_then(PinName::digital)),
            "Heater output. nc makes this a sensor only.",
        )
        .klipper("[extruder] heater_pin")
        .by_name(&ByName(&[("hotend", "PE0"), ("hotend2", "PB8"), ("bed", "PE3")]))
        .v1("temperature_control.<name>.heater_pin"),
        integer(
            "max_pwm",
            "255",
            &(0, 255),
            heater!(|h, v| h.max_pwm = Duty(v as u8)),
            "Ceiling of the heater's power, of 255. M301 Y changes it.",
        )
        .klipper("[extruder] max_power")
        .v1("temperature_control.<name>.max_pwm"),
        number(
            "cycle_time",
            "0",
            &(0.0, 10.0),
            heater!(|h, v| h.cycle = Micros((v * 1e6) as u64)),
            "The heater is on once in so long, for its share of it, as a relay on mains needs: 0.2 and more. 0: as often as \
             can be.",
        )
        .unit("s")
        .klipper("[extruder] pwm_cycle_time")
        .velvet(),
        number("p_factor", "10", ANY, heater!(|h, v| h.pid.p = v as f32), "Proportional gain. M301 P changes it.")
            .klipper("[extruder] pid_Kp")
            .v1("temperature_control.<name>.p_factor"),
        number("i_factor", "0.3", ANY, heater!(|h, v| h.pid.i = v as f32), "Integral gain. M301 I changes it.")
            .klipper("[extruder] pid_Ki")
            .unit("1/s")
            .v1("temperature_control.<name>.i_factor"),
        number("d_factor", "200", ANY, heater!(|h, v| h.pid.d = v as f32), "Derivative gain. M301 D changes it.")
            .klipper("[extruder] pid_Kd")
            .unit("s")
            .v1("temperature_control.<name>.d_factor"),
        control::D_FILTER,
        bool(
            "use_ponm",
            "false",
            heater!(|h, v| h.pid.on_measurement = v),
            "Proportional on measurement instead of on error: slower, without overshoot.",
        ),
        number(
            "i_max",
            "255",
            &(0.0, 255.0),
            heater!(|h, v| h.pid.i_max = v as f32),
            "Limit of the integral part, of 255. M301 X changes it.",
        )
        .derived("max_pwm")
        .v1("temperature_control.<name>.i_max"),
        bool(
            "windup",
            "true",
            heater!(|h, v| h.pid.windup = v),
            "At a limit of the output the integral does not move further towards it: no overshoot after a heat-up. false \
             updates it always.",
        )
        .v1("temperature_control.<name>.windup"),
        control::CONTROL,
        control::HEATER_POWER,
        control::MODEL_CAPACITY,
        control::MODEL_LOSS,
        control::MODEL_FAN_LOSS,
        control::MODEL_LATE,
        control::FILAMENT_HEAT,
        control::FAN,
        bool("bang_bang", "false", heater!(|h, v| h.bang_bang = v), "Switch fully on and off instead of PID.")
            .klipper("[extruder] control")
            .v1("temperature_control.<name>.bang_bang"),
        number(
            "hysteresis",
            "2",
            NOT_NEGATIVE,
            heater!(|h, v| h.hysteresis = Celsius(v as f32)),
            "With bang_bang: on this far below, off this far above the target.",
        )
        .klipper("[extruder] max_delta")
        .unit("C")
        .v1("temperature_control.<name>.hysteresis"),
        number(
            "min_temp",
            "0",
            &(-273.0, 2_000.0),
            heater!(|h, v| h.min_temp = Celsius(v as f32)),
            "A reading below this while heating means a broken sensor: heater off, halt.",
        )
        .klipper("[extruder] min_temp")
        .unit("C")
        .v1("temperature_control.<name>.min_temp"),
        number(
            "max_temp",
            "300",
            &(-273.0, 2_000.0),
            heater!(|h, v| h.max_temp = Celsius(v as f32)),
            "Highest target; a reading above it while heating means heater off, halt. M143 changes it.",
        )
        .klipper("[extruder] max_temp")
        .unit("C")
        .typical(&(1.0, 700.0))
        .v1("temperature_control.<name>.max_temp"),
        integer(
            "runaway_range",
            "20",
            &(0, 500),
            heater!(|h, v| h.runaway.range = (v > 0).then_some(Celsius(v as f32))),
            "Once at the target, further than this from it for more than 5 s halts; 0 switches that off.",
        )
        .unit("C")
        .v1("temperature_control.<name>.runaway_range"),
        integer(
            "runaway_heating_timeout",
            "300",
            &(0, 86_400),
            heater!(|h, v| h.runaway.heating_timeout = positive_seconds(v)),
            "Longer than this to the target halts; 0 switches that off.",
        )
        .unit("s")
        .v1("temperature_control.<name>.runaway_heating_timeout"),
        integer(
            "runaway_cooling_timeout",
            "300",
            &(0, 86_400),
            heater!(|h, v| h.runaway.cooling_timeout = positive_seconds(v)),
            "Above a lower target and 60 C it must cool by 0.5 C in this, or it halts; 0: off.",
        )
        .derived("runaway_heating_timeout")
        .unit("s")
        .v1("temperature_control.<name>.runaway_cooling_timeout"),
        number(
            "runaway_error_range",
            "1",
            NOT_NEGATIVE,
            heater!(|h, v| h.runaway.error_range = Celsius(v as f32)),
            "This close to the target counts as reached.",
        )
        .unit("C"),
        number(
            "verify_band",
            "5",
            NOT_NEGATIVE,
            heater!(|h, v| h.verify.band = Celsius(v as f32)),
            "Further than this below its target a heater must warm by verify_gain, and may sink by verify_max_error.",
        )
        .klipper("[verify_heater] hysteresis")
        .unit("C"),
        number(
            "verify_gain",
            "2",
            POSITIVE,
            heater!(|h, v| h.verify.gain = Celsius(v as f32)),
            "What a heater must warm by within verify_gain_time of full output.",
        )
        .klipper("[verify_heater] heating_gain")
        .unit("C"),
        integer(
            "verify_gain_time",
            "20",
            &(0, 86_400),
            heater!(|h, v| h.verify.gain_time = positive_seconds(v)),
            "A heater that was given full output for so long (half output counts half) and has not warmed by \
             verify_gain halts: no heater, no supply, or the sensor is not on it. 0 switches that off.",
        )
        .derived("20, or 60 when tool_id is 100 or more")
        .klipper("[verify_heater] check_gain_time")
        .unit("s"),
        number(
            "verify_max_error",
            "120",
            NOT_NEGATIVE,
            heater!(|h, v| h.verify.max_error = v as f32),
            "Once at the target: degrees below verify_band times seconds until it halts, 10 C for 12 s as well as 2 C \
             for a minute. 0 switches that off.",
        )
        .klipper("[verify_heater] max_error")
        .unit("C s"),
        number(
            "max_rise",
            "30",
            NOT_NEGATIVE,
            heater!(|h, v| h.verify.max_rise = Celsius(v as f32)),
            "A reading that rises by more than this in a second while heating is no temperature: halt. 0 switches \
             that off.",
        )
        .unit("C/s"),
        number(
            "max_fall",
            "15",
            NOT_NEGATIVE,
            heater!(|h, v| h.verify.max_fall = Celsius(v as f32)),
            "A reading that falls by more than this in a second while heating means that the sensor has come off: \
             halt. 0 switches that off.",
        )
        .unit("C/s"),
        integer(
            "full_power_timeout",
            "0",
            &(0, 604_800),
            heater!(|h, v| h.verify.full_power_timeout = positive_seconds(v)),
            "At full output for longer than this without a pause halts; 0: no limit.",
        )
        .unit("s"),
        integer(
            "hold_timeout",
            "0",
            &(0, 604_800),
            heater!(|h, v| h.verify.hold_timeout = positive_seconds(v)),
            "On at one target for longer than this halts; 0: no limit. Longer than the longest job.",
        )
        .unit("s"),
        integer(
            "readings_per_second",
            "20",
            &(0, 65_535),
            heater!(|h, v| h.sensor.readings_per_second = v as u16),
            "How often the sensor is read and the heater adjusted.",
        )
        .limited(&(1.0, 100.0))
        .unit("Hz")
        .v1("temperature_control.<name>.readings_per_second"),
        control::WAIT_WINDOW,
        control::WAIT_DWELL,
        control::WAIT_TIMEOUT,
        integer(
            "set_m_code",
            "104",
            &(0, 65_535),
            heater!(|h, v| h.set_m_code = v as u16),
            "M-code that sets the target.",
        )
        .derived("104, or 140 when tool_id is 100 or more, or 141 of the name chamber")
        .v1("temperature_control.<name>.set_m_code"),
        integer(
            "set_and_wait_m_code",
            "109",
            &(0, 65_535),
            heater!(|h, v| h.set_and_wait_m_code = v as u16),
            "M-code that sets the target and waits for it.",
        )
        .derived("109, or 190 when tool_id is 100 or more, or 191 of the name chamber")
        .v1("temperature_control.<name>.set_and_wait_m_code"),
        integer(
            "get_m_code",
            "105",
            &(0, 65_535),
            heater!(|h, v| h.get_m_code = v as u16),
            "M-code that reports the temperature.",
        )
        .v1("temperature_control.<name>.get_m_code"),
        control::PRESET_1,
        control::PRESET_2,
        control::PRESETS,
    ],
};
