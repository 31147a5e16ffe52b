//! `[temperature control]`: sensor, heater, control and safety.

use crate::names::Name;
use crate::pin::{Pin, ThermistorInput};
use crate::setting::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, number, numbers, pin, places, text, word};
use crate::setting::declare::{settings, words};
use crate::setting::field::word_field;
use crate::setting::{ByName, PinRole, Words};
use heapless::String;
use units::{Celsius, Duty, HeaterId, Micros, Ohms, Thermocouple, ToolId, Volts};

/// Greatest number of temperature controls.
pub const MAX_TEMPERATURES: usize = units::MAX_HEATERS;

word_field!(Thermocouple);

const THERMOCOUPLES: &Words = &Words(Thermocouple::WORDS);

settings! {
    /// Connection and settings of a converter chip.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct SpiSensorConfig {
        /// SPI bus of a max31855, max31856 or max31865: 0 is SPI1 (SCK PA5, MISO PA6, MOSI PB5), 1 is SPI4
        /// (SCK PE12, MISO PE5, MOSI PE6), which the motor drivers have as well. Any number of sensors may be
        /// on either.
        "spi_channel" channel: Option<u8> = integer("-1", &(-1, 1)) => |v: i64| u8::try_from(v).ok();
        /// Chip select of a max31855, max31856 or max31865, one of its own for each. It is low to select,
        /// with or without a `!`.
        "spi_select_pin" select_pin: Option<Pin> = pin("nc", PinRole::Output);
        /// Type of the thermocouple on a max31856. A max31855 is made for one type, which its name ends with.
        "tc_type" thermocouple: Thermocouple = word("K", THERMOCOUPLES).klipper("[extruder] tc_type").velvet();
        /// So many readings of a max31855, or so many samples of a max31856, make one temperature. More is
        /// calmer and later: the last readings of a max31855 come 0.1 s apart; each sample more of a max31856
        /// takes 0.02 s.
        "tc_averaging" averaging: u8 = word("4", AVERAGING)
            .klipper("[extruder] tc_averaging_count").velvet() => |v: usize| 1 << v;
        /// Frequency of the mains, which the filter of a max31856 or max31865 takes out.
        "mains_frequency" mains_60_hz: bool = word("50", &Words(&["50", "60"]))
            .klipper("[extruder] tc_use_50Hz_filter, rtd_use_50Hz_filter").unit("Hz").velvet();
        /// Wires of the platinum sensor on a max31865, as the bridges on its board are soldered.
        rtd_wires: u8 = word("2", &Words(&["2", "3", "4"]))
            .klipper("[extruder] rtd_num_of_wires").velvet() => |v: usize| v as u8 + 2;
        /// Resistance at 0 C of the platinum sensor on a max31865: 100 for a PT100, 1000 for a PT1000.
        rtd_nominal: Ohms = number("100", POSITIVE).klipper("[extruder] rtd_nominal_r").unit("Ohm").velvet();
        /// Reference resistor on the board of a max31865: 430 on most for a PT100, 4300 on most for a PT1000.
        rtd_reference: Ohms = number("430", POSITIVE).klipper("[extruder] rtd_reference_r").unit("Ohm").velvet();
    }
}

words! {
    /// Kind of temperature sensor.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[allow(missing_docs, reason = "the names are the meaning")]
    pub enum SensorKind {
        #[default]
        Thermistor = "thermistor",
        Pt100 = "pt100",
        Pt1000 = "pt1000",
        Ad849x = "ad849x",
        Voltage = "voltage",
        Max = "max",
        Min = "min",
        Mean = "mean",
        Difference = "difference",
        Chip = "chip",
        Max31855 = "max31855",
        Max31856 = "max31856",
        Max31865 = "max31865",
    }
}

impl SensorKind {
    /// Returns whether the board's analogue converter reads the sensor, at `thermistor_pin`.
    #[must_use]
    pub const fn is_analog(self) -> bool {
        matches!(self, Self::Thermistor | Self::Pt100 | Self::Pt1000 | Self::Ad849x | Self::Voltage)
    }

    /// Returns whether a converter chip on an SPI bus reads the sensor.
    #[must_use]
    pub const fn is_on_spi(self) -> bool {
        matches!(self, Self::Max31855 | Self::Max31856 | Self::Max31865)
    }

    /// Returns whether the temperature is combined from other controls instead of measured.
    #[must_use]
    pub const fn is_combined(self) -> bool {
        matches!(self, Self::Max | Self::Min | Self::Mean | Self::Difference)
    }
}

/// Most points of a sensor's curve of voltages.
pub const MAX_VOLTAGE_POINTS: usize = 6;

settings! {
    /// A thermistor and its divider. Where several conversions are given, the first of `rt_curve`,
    /// `coefficients`, `table` and `beta` applies.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct ThermistorConfig {
        /// Input of the thermistor or other analogue sensor. ADC1_1, ADC1_2, ADC1_3 are connectors T1, T2,
        /// T3, with a pull-up of 4.7 kOhm; ADC1_0 is on the board; ADC1_4, ADC1_5, ADC1_6 are on the header,
        /// without a pull-up.
        "thermistor_pin" input: Option<ThermistorInput> = pin("nc", PinRole::Thermistor)
            .klipper("[extruder] sensor_pin")
            .by_name(&ByName(&[("hotend", "ADC1_1"), ("hotend2", "ADC1_2"), ("bed", "ADC1_3"), ("board", "ADC1_0")]))
            .v1("temperature_control.<name>.thermistor_pin");
        /// A built-in thermistor by name, with its beta, r0, r1 and r2 where those are not written. Without
        /// one, rt_curve, coefficients or beta must describe it.
        "thermistor" table: Option<&'static str> = word("", THERMISTORS)
            .klipper("[extruder] sensor_type").v1("temperature_control.<name>.thermistor")
            => |v: usize| THERMISTORS.0.get(v).copied();
        /// Take the named thermistor's beta value instead of its Steinhart-Hart coefficients.
        use_beta_table: bool = bool("false").v1("temperature_control.<name>.use_beta_table");
        /// Beta of the thermistor.
        "beta" beta_k: f64 = number("4066", POSITIVE).unit("K").v1("temperature_control.<name>.beta");
        /// Resistance at t0. A reading above eight times this counts as a broken wire.
        r0: Ohms = number("100000", POSITIVE).unit("Ohm").v1("temperature_control.<name>.r0");
        /// Temperature at which the thermistor has r0.
        t0: Celsius = number("25", &(-273.0, 1_000.0)).unit("C").v1("temperature_control.<name>.t0");
        /// A resistor in parallel with the thermistor or platinum sensor; 0 for none.
        r1: Ohms = number("0", NOT_NEGATIVE).unit("Ohm").v1("temperature_control.<name>.r1");
        /// Pull-up resistor of the divider; on the board it is 4.7 kOhm.
        r2: Ohms = number("4700", POSITIVE)
            .klipper("[extruder] pullup_resistor").unit("Ohm").v1("temperature_control.<name>.r2");
        /// Steinhart-Hart coefficients c1,c2,c3 of the thermistor.
        coefficients: Option<[f64; 3]> = numbers(3).v1("temperature_control.<name>.coefficients");
        /// Three points temperature,resistance of the thermistor's curve. Stronger than coefficients.
        rt_curve: Option<[(f64, f64); 3]> = numbers(6)
            .unit("C,Ohm").v1("temperature_control.<name>.rt_curve") => three_points;
    }
}

/// The temperature sensor of a control.
#[derive(Clone, Copy, Debug, Default)]
pub struct SensorConfig {
    /// Kind of the sensor.
    pub kind: SensorKind,
    /// Thermistor data; input and divider serve every other analogue sensor too.
    pub thermistor: ThermistorConfig,
    /// Output of a thermocouple amplifier at 0 C.
    pub amplifier_offset: Volts,
    /// Points of the voltage curve, (temperature C, volts), as many as are written.
    pub voltage_points: [Option<[f64; 2]>; MAX_VOLTAGE_POINTS],
    /// Temperature controls that a combined sensor is made of, in the order written.
    pub parts: [Option<HeaterId>; units::MAX_HEATERS],
    /// Time constant of the filter between sensor and control, s; 0: none.
    pub filter_s: f32,
    /// Settings of the converter chip, for a sensor on an SPI bus.
    pub spi: SpiSensorConfig,
    /// Sampling and control rate.
    pub readings_per_second: u16,
}

settings! {
    /// PID gains in Smoothieware's units: duty steps (of 255) per degree, per degree-second, and duty-seconds
    /// per degree.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct PidGains {
        /// Proportional gain. M301 P changes it.
        "p_factor" p: f32 = number("10", ANY).klipper("[extruder] pid_Kp").v1("temperature_control.<name>.p_factor");
        /// Integral gain. M301 I changes it.
        "i_factor" i: f32 = number("0.3", ANY)
            .klipper("[extruder] pid_Ki").unit("1/s").v1("temperature_control.<name>.i_factor");
        /// Derivative gain. M301 D changes it.
        "d_factor" d: f32 = number("200", ANY)
            .klipper("[extruder] pid_Kd").unit("s").v1("temperature_control.<name>.d_factor");
        /// Time constant of the derivative's filter; 0: none, and noise of a tenth of a degree switches the
        /// output between its limits.
        "d_filter" d_filter_s: f32 = number("0.5", &(0.0, 60.0)).unit("s").velvet();
        /// Proportional on measurement instead of on error: slower, without overshoot.
        "use_ponm" on_measurement: bool = bool("false");
        /// Limit of the integral part, of 255. M301 X changes it.
        i_max: f32 = number("255", &(0.0, 255.0)).derived("max_pwm").v1("temperature_control.<name>.i_max");
        /// At a limit of the output the integral does not move further towards it: no overshoot after a
        /// heat-up. false updates it always.
        "windup" conditional_integral: bool = bool("true").v1("temperature_control.<name>.windup");
    }
}

settings! {
    /// Thermal model of a heater, for model-based control.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct ModelSettings {
        /// Power of the heater at full output: for control = model, and for what M306 finds.
        "heater_power" power_w: f32 = number("40", POSITIVE)
            .derived("40, or 200 when tool_id is 100 or more").unit("W").velvet();
        /// With control = model: heat capacity of what is heated; M306 finds it, M307 C changes it.
        "model_capacity" capacity: f32 = number("0", NOT_NEGATIVE).unit("J/K").velvet();
        /// With control = model: heat lost to still air; M306 finds it, M307 K changes it.
        "model_loss" loss: f32 = number("0", NOT_NEGATIVE).unit("W/K").velvet();
        /// With control = model: what is lost more with the fan full on; M306 finds it, M307 F changes it.
        "model_fan_loss" fan_loss: f32 = number("0", NOT_NEGATIVE).unit("W/K").velvet();
        /// With control = model: how late the sensor tells; M306 finds it, M307 D changes it.
        "model_late" late_s: f32 = number("0", NOT_NEGATIVE).unit("s").velvet();
        /// With control = model, of a hot end: heat that melting filament takes; 0.0023 is PLA's, PETG takes
        /// 0.0021, ABS 0.0022. M307 H changes it.
        filament_heat: f32 = number("0.0023", NOT_NEGATIVE).unit("J/mm3/K").velvet();
    }
}

impl ModelSettings {
    /// Returns whether a heater may be controlled by the model: every figure that divides is above zero.
    #[must_use]
    pub fn is_usable(&self) -> bool {
        [self.power_w, self.capacity, self.late_s].into_iter().all(|figure| figure.is_finite() && figure > 0.0)
            && [self.loss, self.fan_loss, self.filament_heat].into_iter().all(|figure| figure >= 0.0)
    }
}

/// Control law by which a heater follows its target, with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LawSettings {
    /// PID control with these gains.
    Pid(PidGains),
    /// Control by a model of the heater.
    Model(ModelSettings),
    /// Bang-bang control: on below the target, off above.
    BangBang {
        /// Half width of the dead band.
        hysteresis: Celsius,
    },
}

settings! {
    /// Settings of the runaway detection.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct Runaway {
        /// Once at the target, further than this from it for more than 5 s halts; 0 switches that off.
        "runaway_range" range: Option<Celsius> = integer("20", &(0, 500))
            .unit("C").v1("temperature_control.<name>.runaway_range") => |v: i64| (v > 0).then_some(Celsius(v as f32));
        /// Longer than this to the target halts; 0 switches that off.
        "runaway_heating_timeout" heating_timeout: Option<Micros> = integer("300", &(0, 86_400))
            .unit("s").v1("temperature_control.<name>.runaway_heating_timeout") => positive_seconds;
        /// Above a lower target and 60 C it must cool by 0.5 C in this, or it halts; 0: off.
        "runaway_cooling_timeout" cooling_timeout: Option<Micros> = integer("300", &(0, 86_400))
            .derived("runaway_heating_timeout").unit("s").v1("temperature_control.<name>.runaway_cooling_timeout")
            => positive_seconds;
        /// This close to the target counts as reached.
        "runaway_error_range" error_range: Celsius = number("1", NOT_NEGATIVE).unit("C");
    }
}

settings! {
    /// Heater verification: the response to power that a working heater must show.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct Verify {
        /// Further than this below its target a heater must warm by verify_gain, and may sink by
        /// verify_max_error.
        "verify_band" band: Celsius = number("5", NOT_NEGATIVE).klipper("[verify_heater] hysteresis").unit("C");
        /// What a heater must warm by within verify_gain_time of full output.
        "verify_gain" gain: Celsius = number("2", POSITIVE).klipper("[verify_heater] heating_gain").unit("C");
        /// A heater that was given full output for so long (half output counts half) and has not warmed by
        /// verify_gain halts: no heater, no supply, or the sensor is not on it. 0 switches that off.
        "verify_gain_time" gain_time: Option<Micros> = integer("20", &(0, 86_400))
            .derived("20, or 60 when tool_id is 100 or more").klipper("[verify_heater] check_gain_time").unit("s")
            => positive_seconds;
        /// Once at the target: degrees below verify_band times seconds until it halts, 10 C for 12 s as well
        /// as 2 C for a minute. 0 switches that off.
        "verify_max_error" max_error: f32 = number("120", NOT_NEGATIVE)
            .klipper("[verify_heater] max_error").unit("C s");
        /// A reading that rises by more than this in a second while heating is no temperature: halt. 0
        /// switches that off.
        max_rise: Celsius = number("30", NOT_NEGATIVE).unit("C/s");
        /// A reading that falls by more than this in a second while heating means that the sensor has come
        /// off: halt. 0 switches that off.
        max_fall: Celsius = number("15", NOT_NEGATIVE).unit("C/s");
        /// At full output for longer than this without a pause halts; 0: no limit.
        full_power_timeout: Option<Micros> = integer("0", &(0, 604_800)).unit("s") => positive_seconds;
        /// On at one target for longer than this halts; 0: no limit. Longer than the longest job.
        hold_timeout: Option<Micros> = integer("0", &(0, 604_800)).unit("s") => positive_seconds;
    }
}

settings! {
    /// Conditions that end the wait of M109 and similar codes.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct TemperatureWait {
        /// M109 and its like are over this near below the target; with R, this near on either side, and never
        /// nearer than 1 C.
        "wait_window" window: Celsius = number("0", &(0.0, 100.0)).unit("C").velvet();
        /// For so long without a break the temperature must be there until M109 and its like are over.
        "wait_dwell" dwell: Micros = number("0", &(0.0, 3_600.0)).unit("s").velvet();
        /// M109 and its like end with an error after heating so long, and the heater goes on; 0: never.
        "wait_timeout" timeout: Micros = number("0", &(0.0, 86_400.0)).unit("s").velvet();
    }
}

settings! {
    /// Heaters and temperature sensors. The names hotend, hotend2, bed and board have the Prime's pins,
    /// labels and tool numbers as defaults.
    #[derive(Clone, Debug, Default)]
    pub struct TemperatureConfig {
        /// Name of the control in the file.
        name: Name;
        /// There is such a heater or sensor.
        enable: bool = bool("false").v1("temperature_control.<name>.enable");
        /// Number of the heater in M-codes. 250 and above stay active whatever tool is selected; below 100
        /// the M-codes are those of a hotend, else those of a bed.
        tool_id: ToolId = integer("255", &(0, 255))
            .by_name(&ByName(&[("hotend", "0"), ("hotend2", "1"), ("bed", "254"), ("board", "253")]))
            .derived(
                "hotend 0, hotend2 1, bed 254, board 253; another one, or one with 255: 253 less the enabled ones before it \
                 in the order of names",
            );
        /// Label in temperature reports. Hosts expect T for the hotend and B for the bed.
        designator: String<8> = text("?", 8)
            .by_name(&ByName(&[("hotend", "T"), ("hotend2", "T2"), ("bed", "B"), ("board", "P")]))
            .v1("temperature_control.<name>.designator");
        /// Sensor that measures the temperature.
        sensor: SensorConfig;
        /// Kind of sensor: a thermistor; platinum of 100 or 1000 Ohm straight on the input, r2 its pull-up; a
        /// thermocouple with an AD8494 to AD8497; or anything else that gives a voltage, by its
        /// voltage_curve. On SPI, thermocouples with a MAX31855 or MAX31856, platinum with a MAX31865. The
        /// converter of the board may be off by 0.2 % of 3.3 V: 3.4 C for a pt1000, 26 C for a pt100, 1.3 C
        /// for an ad849x. max, min, mean and difference combine the sensors of other temperature controls;
        /// chip is the microcontroller's own, for reports and fans.
        "sensor" sensor.kind = word("thermistor", SensorKind::WORDS);
        /// Of max, min, mean and difference: the names of the temperature controls to combine, commas
        /// between; difference is the first less the second. When one of them fails, it fails.
        "sensors" combines: String<96> = text("", 96).velvet();
        /// Time constant of a low-pass filter between sensor and control; 0: none. Readings are that much
        /// late: a steady rise is seen so many seconds later, a jump to 63 % after it and to 95 % after three
        /// times it. Heat safety sees the sensor unfiltered.
        "sensor_filter" sensor.filter_s = number("0", &(0.0, 60.0)).unit("s").velvet();
        rows TemperatureCurve:
        /// Output of an ad849x at 0 C: the voltage of its REF pin, 1.25 on many breakout boards. With 0 it
        /// reads nothing below 1.4 C.
        "amplifier_offset" sensor.amplifier_offset = number("0", &(0.0, 3.3)).unit("V").velvet();
        /// Two points or more temperature,voltage of a sensor = voltage: straight between them, and on beyond
        /// the outer ones. Below 7 mV and above 3.293 V is a broken wire.
        "voltage_curve" sensor.voltage_points = places(MAX_VOLTAGE_POINTS)
            .unit("C,V").velvet() => |points: &[[f64; 2]]| core::array::from_fn(|point| points.get(point).copied());
        rows TemperatureOutput:
        /// Heater output. nc makes this a sensor only.
        heater_pin: Option<Pin> = pin("nc", PinRole::Output)
            .klipper("[extruder] heater_pin")
            .by_name(&ByName(&[("hotend", "PE0"), ("hotend2", "PB8"), ("bed", "PE3")]))
            .v1("temperature_control.<name>.heater_pin");
        /// Ceiling of the heater's power, of 255. M301 Y changes it.
        max_pwm: Duty = integer("255", &(0, 255))
            .klipper("[extruder] max_power").v1("temperature_control.<name>.max_pwm");
        /// The heater is on once in so long, for its share of it, as a relay on mains needs: 0.2 and more. 0:
        /// as often as can be.
        "cycle_time" cycle: Micros = number("0", &(0.0, 10.0)).unit("s").klipper("[extruder] pwm_cycle_time").velvet();
        rows TemperatureLaw:
        /// pid, or model: by the figures below, which M306 finds and M500 keeps. A fan and filament are made
        /// up for before the sensor tells of them.
        "control" by_model: bool = word("pid", &Words(&["pid", "model"])).velvet();
        rows TemperatureLimits:
        /// With control = model: name of the [switch] of the fan that blows at it; its duty is made up for.
        "fan" fan_name: Name = text("", 24).velvet();
        /// Place of the switch `fan_name` in the list of switches.
        fan: Option<u8>;
        /// Switch fully on and off instead of PID.
        bang_bang: bool = bool("false").klipper("[extruder] control").v1("temperature_control.<name>.bang_bang");
        /// With bang_bang: on this far below, off this far above the target.
        hysteresis: Celsius = number("2", NOT_NEGATIVE)
            .klipper("[extruder] max_delta").unit("C").v1("temperature_control.<name>.hysteresis");
        /// A reading below this while heating means a broken sensor: heater off, halt.
        min_temp: Celsius = number("0", &(-273.0, 2_000.0))
            .klipper("[extruder] min_temp").unit("C").v1("temperature_control.<name>.min_temp");
        /// Highest target; a reading above it while heating means heater off, halt. M143 changes it.
        max_temp: Celsius = number("300", &(-273.0, 2_000.0))
            .klipper("[extruder] max_temp").unit("C").typical(&(1.0, 700.0))
            .v1("temperature_control.<name>.max_temp");
        rows TemperatureReadings:
        /// How often the sensor is read and the heater adjusted.
        "readings_per_second" sensor.readings_per_second = integer("20", &(0, 65_535))
            .limited(&(1.0, 100.0)).unit("Hz").v1("temperature_control.<name>.readings_per_second");
        /// Conditions that end a wait for the target.
        wait: TemperatureWait;
        rows TemperatureCodes:
        /// M-code that sets the target.
        set_m_code: u16 = integer("104", &(0, 65_535))
            .derived("104, or 140 when tool_id is 100 or more, or 141 of the name chamber")
            .v1("temperature_control.<name>.set_m_code");
        /// M-code that sets the target and waits for it.
        set_and_wait_m_code: u16 = integer("109", &(0, 65_535))
            .derived("109, or 190 when tool_id is 100 or more, or 191 of the name chamber")
            .v1("temperature_control.<name>.set_and_wait_m_code");
        /// M-code that reports the temperature.
        get_m_code: u16 = integer("105", &(0, 65_535)).v1("temperature_control.<name>.get_m_code");
        /// Meaning of S1 and S2; zero: off.
        presets: [Celsius; 2];
        /// What S1 means; 0: off.
        "preset1" presets[0] = number("0", NOT_NEGATIVE).unit("C").v1("temperature_control.<name>.preset1");
        /// What S2 means; 0: off.
        "preset2" presets[1] = number("0", NOT_NEGATIVE).unit("C").v1("temperature_control.<name>.preset2");
        /// Presets with names, commas between: pla 205, petg 235. The command preheat pla sets every heater
        /// that has one.
        "presets" preset_names: String<96> = text("", 96).velvet();
        /// Gains of the PID control.
        pid: PidGains;
        /// Parameters of the thermal model.
        model: ModelSettings;
        /// Settings of the runaway detection.
        runaway: Runaway;
        /// Limits of the heater verification.
        verify: Verify;
    }
}

impl TemperatureConfig {
    /// Returns the names of the controls that a combined sensor is made of.
    pub fn part_names(&self) -> impl Iterator<Item = &str> {
        self.combines.split([',', ' ', '\t']).filter(|name| !name.is_empty())
    }

    /// Returns the named presets; the temperature is `None` where none is written.
    pub fn named_presets(&self) -> impl Iterator<Item = (&str, Option<Celsius>)> {
        self.preset_names.split(',').map(str::trim).filter(|preset| !preset.is_empty()).map(|preset| {
            let (name, celsius) = preset.split_once([' ', '\t']).unwrap_or((preset, ""));
            (name, gcode::read_f32(celsius.trim()).filter(|celsius| *celsius > 0.0).map(Celsius))
        })
    }

    /// Returns the temperature of a named preset.
    #[must_use]
    pub fn preset(&self, name: &str) -> Option<Celsius> {
        let mut presets = self.named_presets();
        presets.find(|(preset, _)| preset.eq_ignore_ascii_case(name)).and_then(|(_, celsius)| celsius)
    }

    /// Returns the control law chosen.
    #[must_use]
    pub const fn law(&self) -> LawSettings {
        match (self.bang_bang, self.by_model) {
            (true, _) => LawSettings::BangBang { hysteresis: self.hysteresis },
            (false, true) => LawSettings::Model(self.model),
            (false, false) => LawSettings::Pid(self.pid),
        }
    }

    /// Returns whether the heater melts filament: its `tool_id` is a tool's, not a bed's or a chamber's.
    #[must_use]
    pub fn is_hot_end(&self) -> bool {
        self.heater_pin.is_some() && self.tool_id < ToolId::FIRST_BED
    }
}

/// Built-in thermistors: Steinhart-Hart entries first, then those that are known by their beta only. A name
/// in both tables means the first, unless `use_beta_table` is set.
const THERMISTORS: &Words = &Words(&[
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

const AVERAGING: &Words = &Words(&["1", "2", "4", "8", "16"]);

fn positive_seconds(seconds: i64) -> Option<Micros> {
    (seconds > 0).then(|| Micros::from_seconds(seconds.unsigned_abs()))
}

fn three_points(v: &[f64]) -> Option<[(f64, f64); 3]> {
    match v {
        &[t1, r1, t2, r2, t3, r3] => Some([(t1, r1), (t2, r2), (t3, r3)]),
        _ => None,
    }
}
