//! `[filament width sensor]`.

use super::build::{NOT_NEGATIVE, bool, integer, number, pin};
use super::{Docs, Form, PinRole, Section};
use crate::pin::PinName;
use units::{Mm, ToolId};

/// Range of a reading: ten-thousandths of full scale, of two inputs together.
const RAW: &(f64, f64) = &(-1e6, 1e6);
/// Filament, and what gauges it.
const DIAMETER: &(f64, f64) = &(0.1, 20.0);

pub const FILAMENT_WIDTH_SENSOR: Section = Section {
    name: "filament width sensor",
    store: None,
    docs: Docs::new("Measures how thick filament is, corrects the flow by it, and suspends the job where it is too thin or \
              too thick."),
    form: Form::Plain,
    settings: &[
        bool("enable", "false", |c, _, v| c.filament_width.enable = v, "There is such a sensor.")
            .klipper("[hall_filament_width_sensor] enable")
            .velvet(),
        pin(
            "adc_pin",
            "nc",
            PinRole::Thermistor,
            |c, _, v| c.filament_width.inputs[0] = v.and_then(PinName::thermistor),
            "Its analog input, 0 to 3.3 V: ADC1_4 to ADC1_6 on the header; ADC1_1 to ADC1_3 have a pull-up of 4.7 kOhm.",
        )
        .klipper("[hall_filament_width_sensor] adc1")
        .velvet(),
        pin(
            "second_adc_pin",
            "nc",
            PinRole::Thermistor,
            |c, _, v| c.filament_width.inputs[1] = v.and_then(PinName::thermistor),
            "Input of a second Hall sensor. The readings of both are added up.",
        )
        .klipper("[hall_filament_width_sensor] adc2")
        .velvet(),
        number(
            "first_raw",
            "9500",
            RAW,
            |c, _, v| c.filament_width.gauges[0].raw = v,
            "What M407.1 says with the first gauge in it: ten-thousandths of 3.3 V, of both inputs together.",
        )
        .klipper("[hall_filament_width_sensor] raw_dia1")
        .velvet(),
        number(
            "first_diameter",
            "1.5",
            DIAMETER,
            |c, _, v| c.filament_width.gauges[0].diameter = Mm(v),
            "How thick that gauge is.",
        )
        .unit("mm")
        .klipper("[hall_filament_width_sensor] cal_dia1")
        .velvet(),
        number(
            "second_raw",
            "10500",
            RAW,
            |c, _, v| c.filament_width.gauges[1].raw = v,
            "What M407.1 says with the second gauge in it.",
        )
        .klipper("[hall_filament_width_sensor] raw_dia2")
        .velvet(),
        number(
            "second_diameter",
            "2",
            DIAMETER,
            |c, _, v| c.filament_width.gauges[1].diameter = Mm(v),
            "How thick that gauge is.",
        )
        .unit("mm")
        .klipper("[hall_filament_width_sensor] cal_dia2")
        .velvet(),
        number(
            "mm_per_volt",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.filament_width.mm_per_volt = v,
            "Of a sensor whose voltage is the diameter (TSL1401CL): so much a volt. 0: the gauges say it.",
        )
        .unit("mm/V")
        .velvet(),
        number(
            "nominal_diameter",
            "1.75",
            DIAMETER,
            |c, _, v| c.filament_width.nominal = Mm(v),
            "What E in millimetres of filament is meant for. M404 W changes it. Where E counts volume, filament_diameter.",
        )
        .unit("mm")
        .klipper("[hall_filament_width_sensor] default_nominal_filament_diameter")
        .velvet(),
        number(
            "max_difference",
            "0.2",
            NOT_NEGATIVE,
            |c, _, v| c.filament_width.max_difference = Mm(v),
            "A piece that differs more from the nominal diameter is not believed, and fed as if it were nominal.",
        )
        .unit("mm")
        .klipper("[hall_filament_width_sensor] max_difference")
        .velvet(),
        number(
            "measurement_delay",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.filament_width.delay = Mm(v),
            "Filament from the sensor to the nozzle: a piece counts when it is there. It must be given. M406 D changes it, in cm.",
        )
        .unit("mm")
        .klipper("[hall_filament_width_sensor] measurement_delay")
        .velvet(),
        number(
            "min_diameter",
            "1",
            NOT_NEGATIVE,
            |c, _, v| c.filament_width.min_diameter = Mm(v),
            "Thinner at the sensor: it has run out, and the job is suspended. 0: never.",
        )
        .unit("mm")
        .klipper("[hall_filament_width_sensor] min_diameter")
        .velvet(),
        number(
            "max_diameter",
            "0",
            NOT_NEGATIVE,
            |c, _, v| c.filament_width.max_diameter = Mm(v),
            "Thicker at the sensor: the job is suspended before it jams. 0: never.",
        )
        .unit("mm")
        .klipper("[hall_filament_width_sensor] max_diameter")
        .velvet(),
        bool(
            "correct_flow",
            "true",
            |c, _, v| c.filament_width.correct_flow = v,
            "What is extruded along the path follows what was measured; else it only suspends.",
        )
        .velvet(),
        bool(
            "measured_at_once",
            "false",
            |c, _, v| c.filament_width.measured_at_once = v,
            "What lies between sensor and nozzle at the beginning is as thick as the first piece measured; else nominal.",
        )
        .klipper("[hall_filament_width_sensor] use_current_dia_while_delay")
        .velvet(),
        integer(
            "tool_id",
            "0",
            &(0, 2),
            |c, _, v| c.filament_width.tool = ToolId(v as u8),
            "The extruder whose filament it measures.",
        )
        .velvet(),
        bool(
            "log",
            "false",
            |c, _, v| c.filament_width.log = v,
            "Says what it measures on every console, each centimetre. M407.2 S changes it.",
        )
        .klipper("[hall_filament_width_sensor] logging")
        .velvet(),
    ],
};
