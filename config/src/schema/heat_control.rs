//! `[temperature control]`: the derivative's filter, control by a model of the heater, when a wait for a
//! temperature is over, and presets.

use super::build::{NOT_NEGATIVE, POSITIVE, number, text, word};
use super::heat::heater;
use super::{Setting, Words};
use units::{Celsius, Micros};

pub const D_FILTER: Setting = number(
    "d_filter",
    "0.5",
    &(0.0, 60.0),
    heater!(|h, v| h.pid.d_filter_s = v as f32),
    "Time constant of the derivative's filter; 0: none, and noise of a tenth of a degree switches the output \
     between its limits.",
)
.unit("s")
.velvet();
pub const CONTROL: Setting = word(
    "control",
    "pid",
    &Words(&["pid", "model"]),
    heater!(|h, v| h.by_model = v == 1),
    "pid, or model: by the figures below, which M306 finds and M500 keeps. A fan and filament are made up for \
     before the sensor tells of them.",
)
.velvet();
pub const HEATER_POWER: Setting = number(
    "heater_power",
    "40",
    POSITIVE,
    heater!(|h, v| h.model.power_w = v as f32),
    "Power of the heater at full output: for control = model, and for what M306 finds.",
)
.derived("40, or 200 when tool_id is 100 or more")
.unit("W")
.velvet();
pub const MODEL_CAPACITY: Setting = number(
    "model_capacity",
    "0",
    NOT_NEGATIVE,
    heater!(|h, v| h.model.capacity = v as f32),
    "With control = model: heat capacity of what is heated; M306 finds it, M307 C changes it.",
)
.unit("J/K")
.velvet();
pub const MODEL_LOSS: Setting = number(
    "model_loss",
    "0",
    NOT_NEGATIVE,
    heater!(|h, v| h.model.loss = v as f32),
    "With control = model: heat lost to still air; M306 finds it, M307 K changes it.",
)
.unit("W/K")
.velvet();
pub const MODEL_FAN_LOSS: Setting = number(
    "model_fan_loss",
    "0",
    NOT_NEGATIVE,
    heater!(|h, v| h.model.fan_loss = v as f32),
    "With control = model: what is lost more with the fan full on; M306 finds it, M307 F changes it.",
)
.unit("W/K")
.velvet();
pub const MODEL_LATE: Setting = number(
    "model_late",
    "0",
    NOT_NEGATIVE,
    heater!(|h, v| h.model.late_s = v as f32),
    "With control = model: how late the sensor tells; M306 finds it, M307 D changes it.",
)
.unit("s")
.velvet();
pub const FILAMENT_HEAT: Setting = number(
    "filament_heat",
    "0.0023",
    NOT_NEGATIVE,
    heater!(|h, v| h.model.filament_heat = v as f32),
    "With control = model, of a hot end: heat that melting filament takes; 0.0023 is PLA's, PETG takes 0.0021, ABS \
     0.0022. M307 H changes it.",
)
.unit("J/mm3/K")
.velvet();
pub const FAN: Setting = text(
    "fan",
    "",
    24,
    heater!(|h, v| h.model.fan_name = crate::Name::try_from(v).unwrap_or_default()),
    "With control = model: name of the [switch] of the fan that blows at it; its duty is made up for.",
)
.velvet();

pub const WAIT_WINDOW: Setting = number(
    "wait_window",
    "0",
    &(0.0, 100.0),
    heater!(|h, v| h.wait.window = Celsius(v as f32)),
    "M109 and its like are over this near below the target; with R, this near on either side, and never nearer \
     than 1 C.",
)
.unit("C")
.velvet();
pub const WAIT_DWELL: Setting = number(
    "wait_dwell",
    "0",
    &(0.0, 3_600.0),
    heater!(|h, v| h.wait.dwell = Micros((v * 1e6) as u64)),
    "For so long without a break the temperature must be there until M109 and its like are over.",
)
.unit("s")
.velvet();
pub const WAIT_TIMEOUT: Setting = number(
    "wait_timeout",
    "0",
    &(0.0, 86_400.0),
    heater!(|h, v| h.wait.timeout = Micros((v * 1e6) as u64)),
    "M109 and its like end with an error after heating so long, and the heater goes on; 0: never.",
)
.unit("s")
.velvet();
pub const PRESET_1: Setting =
    number("preset1", "0", NOT_NEGATIVE, heater!(|h, v| h.presets[0] = Celsius(v as f32)), "What S1 means; 0: off.")
        .unit("C")
        .v1("temperature_control.<name>.preset1");
pub const PRESET_2: Setting =
    number("preset2", "0", NOT_NEGATIVE, heater!(|h, v| h.presets[1] = Celsius(v as f32)), "What S2 means; 0: off.")
        .unit("C")
        .v1("temperature_control.<name>.preset2");
pub const PRESETS: Setting = text(
    "presets",
    "",
    96,
    heater!(|h, v| h.preset_names = heapless::String::try_from(v).unwrap_or_default()),
    "Presets with names, commas between: pla 205, petg 235. The command preheat pla sets every heater that has one.",
)
.velvet();
