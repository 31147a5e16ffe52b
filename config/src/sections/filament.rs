//! Filament: `[filament detector]`, `[filament width sensor]` and `[filament change]`.

use crate::names::Command;
use crate::pin::{Pin, ThermistorInput};
use crate::setting::PinRole;
use crate::setting::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, number, pin, text};
use crate::setting::declare::settings;
use units::{Micros, Mm, MmPerSecond, ToolId};

settings! {
    /// Notices that filament has run out or is stuck, and suspends the job.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct FilamentDetectorConfig {
        /// There is a detector.
        enable: bool = bool("false").v1("filament_detector.enable");
        /// Input that a wheel turned by the filament pulses. No pulse while the extruder pushes: it is stuck.
        encoder_pin: Option<Pin> = pin("nc", PinRole::Input)
            .klipper("[filament_motion_sensor] switch_pin").v1("filament_detector.encoder_pin");
        /// Input, logically high where filament is too thick.
        bulge_pin: Option<Pin> = pin("nc", PinRole::Input).v1("filament_detector.bulge_pin");
        /// Input, logically high where there is no filament. Only without bulge_pin.
        detector_pin: Option<Pin> = pin("nc", PinRole::Input).klipper("[filament_switch_sensor] switch_pin");
        /// Between two looks at the pulses. M404 S changes it.
        "seconds_per_check" check_every: Micros = integer("2", &(1, 3600))
            .unit("s").v1("filament_detector.seconds_per_check") => |v: i64| Micros::from_millis(v as u64 * 1000);
        /// Pulses of a millimetre of filament. M404 P changes it.
        pulses_per_mm: f64 = number("1", POSITIVE).unit("pulses/mm").v1("filament_detector.pulses_per_mm");
        /// Heaters stay on when it suspends the job. M404 H changes it.
        leave_heaters_on: bool = bool("false").v1("filament_detector.leave_heaters_on");
        /// Suspend the job where filament is missing or stuck; otherwise that is told, and runout_gcode acts.
        suspends: bool = bool("true").klipper("[filament_switch_sensor] pause_on_runout").velvet();
    }
}

/// Lines for filament that runs out, and for filament that is put in.
type FilamentLines = [Command; 2];

settings! {
    /// Lines that the detector sends.
    rows DetectorLines of FilamentLines {
        /// Line sent when filament runs out or is stuck in a job, once the job is suspended.
        "runout_gcode" [0] = text("", 96).klipper("[filament_switch_sensor] runout_gcode").velvet();
        /// Line sent when filament is put in, but for while a job runs.
        "insert_gcode" [1] = text("", 96).klipper("[filament_switch_sensor] insert_gcode").velvet();
    }
}

impl FilamentDetectorConfig {
    /// Returns the input for missing or too thick filament: `bulge_pin` where both are given.
    #[must_use]
    pub fn level_pin(&self) -> Option<Pin> {
        self.bulge_pin.or(self.detector_pin).filter(|_| self.enable)
    }

    /// Returns the pulse input of the wheel.
    #[must_use]
    pub fn wheel_pin(&self) -> Option<Pin> {
        self.encoder_pin.filter(|_| self.enable)
    }
}

/// Calibration gauge of known thickness, and the reading of the sensor with it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gauge {
    /// Reading of all inputs together, ten-thousandths of full scale.
    pub raw: f64,
    /// Diameter of the gauge.
    pub diameter: Mm,
}

settings! {
    /// Measures how thick filament is, corrects the flow by it, and suspends the job where it is too thin or
    /// too thick.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct FilamentWidthConfig {
        /// There is such a sensor.
        enable: bool = bool("false").klipper("[hall_filament_width_sensor] enable").velvet();
        /// Inputs of the sensor: one, or those of two Hall sensors, whose readings are added up.
        inputs: [Option<ThermistorInput>; 2];
        /// Its analog input, 0 to 3.3 V: ADC1_4 to ADC1_6 on the header; ADC1_1 to ADC1_3 have a pull-up of
        /// 4.7 kOhm.
        "adc_pin" inputs[0] = pin("nc", PinRole::Thermistor).klipper("[hall_filament_width_sensor] adc1").velvet();
        /// Input of a second Hall sensor. The readings of both are added up.
        "second_adc_pin" inputs[1] = pin("nc", PinRole::Thermistor)
            .klipper("[hall_filament_width_sensor] adc2").velvet();
        /// Gauges used for the calibration.
        gauges: [Gauge; 2];
        /// What M407.1 says with the first gauge in it: ten-thousandths of 3.3 V, of both inputs together.
        "first_raw" gauges[0].raw = number("9500", RAW).klipper("[hall_filament_width_sensor] raw_dia1").velvet();
        /// How thick that gauge is.
        "first_diameter" gauges[0].diameter = number("1.5", DIAMETER)
            .unit("mm").klipper("[hall_filament_width_sensor] cal_dia1").velvet();
        /// What M407.1 says with the second gauge in it.
        "second_raw" gauges[1].raw = number("10500", RAW).klipper("[hall_filament_width_sensor] raw_dia2").velvet();
        /// How thick that gauge is.
        "second_diameter" gauges[1].diameter = number("2", DIAMETER)
            .unit("mm").klipper("[hall_filament_width_sensor] cal_dia2").velvet();
        /// Of a sensor whose voltage is the diameter (TSL1401CL): so much a volt. 0: the gauges say it.
        mm_per_volt: f64 = number("0", NOT_NEGATIVE).unit("mm/V").velvet();
        /// What E in millimetres of filament is meant for. M404 W changes it. Where E counts volume,
        /// filament_diameter.
        "nominal_diameter" nominal: Mm = number("1.75", DIAMETER)
            .unit("mm").klipper("[hall_filament_width_sensor] default_nominal_filament_diameter").velvet();
        /// A piece that differs more from the nominal diameter is not believed, and fed as if it were
        /// nominal.
        max_difference: Mm = number("0.2", NOT_NEGATIVE)
            .unit("mm").klipper("[hall_filament_width_sensor] max_difference").velvet();
        /// Filament from the sensor to the nozzle: a piece counts when it is there. It must be given. M406 D
        /// changes it, in cm.
        "measurement_delay" delay: Mm = number("0", NOT_NEGATIVE)
            .unit("mm").klipper("[hall_filament_width_sensor] measurement_delay").velvet();
        /// Thinner at the sensor: it has run out, and the job is suspended. 0: never.
        min_diameter: Mm = number("1", NOT_NEGATIVE)
            .unit("mm").klipper("[hall_filament_width_sensor] min_diameter").velvet();
        /// Thicker at the sensor: the job is suspended before it jams. 0: never.
        max_diameter: Mm = number("0", NOT_NEGATIVE)
            .unit("mm").klipper("[hall_filament_width_sensor] max_diameter").velvet();
        /// What is extruded along the path follows what was measured; else it only suspends.
        correct_flow: bool = bool("true").velvet();
        /// What lies between sensor and nozzle at the beginning is as thick as the first piece measured; else
        /// nominal.
        measured_at_once: bool = bool("false")
            .klipper("[hall_filament_width_sensor] use_current_dia_while_delay").velvet();
        /// The extruder whose filament it measures.
        "tool_id" tool: ToolId = integer("0", &(0, 2)).velvet();
        /// Says what it measures on every console, each centimetre. M407.2 S changes it.
        log: bool = bool("false").klipper("[hall_filament_width_sensor] logging").velvet();
    }
}

impl FilamentWidthConfig {
    /// Returns the inputs in use, each with its place in the list.
    pub fn live_inputs(&self) -> impl Iterator<Item = (usize, ThermistorInput)> + use<> {
        let inputs = if self.enable { self.inputs } else { [None; 2] };
        inputs.into_iter().enumerate().filter_map(|(place, input)| Some((place, input?)))
    }
}

settings! {
    /// How M600, M701 and M702 move filament and the tool. Lengths of 0 leave it to a person.
    #[derive(Clone, Copy, Debug, Default)]
    pub struct FilamentChangeConfig {
        /// Pulled back when M600 has suspended the job, so that nothing oozes on the way.
        retract: Mm = number("0", NOT_NEGATIVE).unit("mm").velvet();
        /// How far the tool rises then.
        lift: Mm = number("0", NOT_NEGATIVE).unit("mm").velvet();
        /// Parking position, machine X and Y; `None`: where the job stopped.
        park: [Option<Mm>; 2];
        /// Where it waits, X of the machine.
        "park_x" park[0] = number("", ANY).derived("where the job stopped").unit("mm").velvet();
        /// Where it waits, Y of the machine.
        "park_y" park[1] = number("", ANY).derived("where the job stopped").unit("mm").velvet();
        /// How fast it goes there.
        "park_feedrate" park_rate: MmPerSecond = number("100", POSITIVE).unit("mm/s").typical(&(0.5, 300.0)).velvet();
        /// Pulled out of the machine. M603 U changes it.
        "unload_length" unload: Mm = number("0", NOT_NEGATIVE).unit("mm").velvet();
        /// How fast.
        "unload_feedrate" unload_rate: MmPerSecond = number("25", POSITIVE)
            .unit("mm/s").typical(&(0.5, 300.0)).velvet();
        /// Pushed in up to the nozzle. M603 L changes it.
        "load_length" load: Mm = number("0", NOT_NEGATIVE).unit("mm").velvet();
        /// How fast.
        "load_feedrate" load_rate: MmPerSecond = number("25", POSITIVE).unit("mm/s").typical(&(0.5, 300.0)).velvet();
        /// Pressed through the nozzle after that.
        "purge_length" purge: Mm = number("0", NOT_NEGATIVE).unit("mm").velvet();
        /// How fast.
        "purge_feedrate" purge_rate: MmPerSecond = number("3", POSITIVE).unit("mm/s").typical(&(0.5, 300.0)).velvet();
    }
}

/// Range of a reading: ten-thousandths of full scale, of two inputs together.
const RAW: &(f64, f64) = &(-1e6, 1e6);
/// Range of diameters of filament and of its gauges, mm.
const DIAMETER: &(f64, f64) = &(0.1, 20.0);
