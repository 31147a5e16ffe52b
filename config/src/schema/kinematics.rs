//! Geometry of the kinematics other than Cartesian and CoreXY.

use super::build::{ANY, POSITIVE, bool, number, numbers};
use super::{Docs, Form, Section, Setting};
use crate::machine::MachineConfig;

pub const LINEAR_DELTA: Section = Section {
    name: "linear delta",
    store: None,
    docs: Docs::new("Geometry of a delta with three towers."),
    form: Form::Plain,
    settings: &[
        number(
            "arm_length",
            "250",
            POSITIVE,
            |c, _, v| c.motion.arms.linear_delta.arm_length = v,
            "Diagonal rod length.",
        )
        .unit("mm")
        .klipper("[stepper_<axis>] arm_length")
        .v1("arm_length"),
        number(
            "arm_radius",
            "124",
            POSITIVE,
            |c, _, v| c.motion.arms.linear_delta.arm_radius = v,
            "Horizontal distance between rod joints when centred.",
        )
        .unit("mm")
        .klipper("[printer] delta_radius")
        .v1("arm_radius"),
        number(
            "delta_tower1_offset",
            "0",
            ANY,
            |c, _, v| c.motion.arms.linear_delta.tower_offset[0] = v,
            "Radial offset of tower 1 (X, at 210 degrees).",
        )
        .unit("mm")
        .v1("delta_tower1_offset"),
        number(
            "delta_tower2_offset",
            "0",
            ANY,
            |c, _, v| c.motion.arms.linear_delta.tower_offset[1] = v,
            "Radial offset of tower 2 (Y, at 330 degrees).",
        )
        .unit("mm")
        .v1("delta_tower2_offset"),
        number(
            "delta_tower3_offset",
            "0",
            ANY,
            |c, _, v| c.motion.arms.linear_delta.tower_offset[2] = v,
            "Radial offset of tower 3 (Z, at 90 degrees).",
        )
        .unit("mm")
        .v1("delta_tower3_offset"),
        number(
            "delta_tower1_angle",
            "0",
            ANY,
            |c, _, v| c.motion.arms.linear_delta.tower_angle[0] = v,
            "Angular offset of tower 1.",
        )
        .unit("deg")
        .v1("delta_tower1_angle"),
        number(
            "delta_tower2_angle",
            "0",
            ANY,
            |c, _, v| c.motion.arms.linear_delta.tower_angle[1] = v,
            "Angular offset of tower 2.",
        )
        .unit("deg")
        .v1("delta_tower2_angle"),
        number(
            "delta_tower3_angle",
            "0",
            ANY,
            |c, _, v| c.motion.arms.linear_delta.tower_angle[2] = v,
            "Angular offset of tower 3.",
        )
        .unit("deg")
        .v1("delta_tower3_angle"),
        number(
            "delta_arm1_offset",
            "0",
            ANY,
            |c, _, v| c.motion.arms.linear_delta.arm_offset[0] = v,
            "Added to arm_length for the rods of tower 1.",
        )
        .unit("mm")
        .klipper("[stepper_a] arm_length")
        .velvet(),
        number(
            "delta_arm2_offset",
            "0",
            ANY,
            |c, _, v| c.motion.arms.linear_delta.arm_offset[1] = v,
            "Added to arm_length for the rods of tower 2.",
        )
        .unit("mm")
        .klipper("[stepper_b] arm_length")
        .velvet(),
        number(
            "delta_arm3_offset",
            "0",
            ANY,
            |c, _, v| c.motion.arms.linear_delta.arm_offset[2] = v,
            "Added to arm_length for the rods of tower 3.",
        )
        .unit("mm")
        .klipper("[stepper_c] arm_length")
        .velvet(),
        bool(
            "halt_on_error",
            "true",
            |c, _, v| c.motion.arms.linear_delta.halt_on_error = v,
            "Halts on a position the arms cannot reach; otherwise the move is refused and the machine goes on.",
        ),
    ],
};

pub const ROTARY_DELTA: Section = Section {
    name: "rotary delta",
    store: None,
    docs: Docs::new("Geometry of a delta with three shoulder motors."),
    form: Form::Plain,
    settings: &[
        number("delta_e", "131.636", POSITIVE, |c, _, v| c.motion.arms.rotary_delta.e = v, "End effector length.")
            .unit("mm")
            .v1("delta_e"),
        number("delta_f", "190.526", POSITIVE, |c, _, v| c.motion.arms.rotary_delta.f = v, "Base length.")
            .unit("mm")
            .v1("delta_f"),
        number("delta_re", "270", POSITIVE, |c, _, v| c.motion.arms.rotary_delta.re = v, "Rod length.")
            .unit("mm")
            .v1("delta_re"),
        number("delta_rf", "90", POSITIVE, |c, _, v| c.motion.arms.rotary_delta.rf = v, "Upper arm length.")
            .unit("mm")
            .v1("delta_rf"),
        number(
            "delta_z_offset",
            "290.7",
            ANY,
            |c, _, v| c.motion.arms.rotary_delta.z_offset = v,
            "Distance from the arm shafts to the bed.",
        )
        .unit("mm")
        .v1("delta_z_offset"),
        number(
            "delta_ee_offs",
            "15",
            ANY,
            |c, _, v| c.motion.arms.rotary_delta.ee_offs = v,
            "Joint plane to effector bottom.",
        )
        .unit("mm")
        .v1("delta_ee_offs"),
        number(
            "delta_tool_offset",
            "30.5",
            ANY,
            |c, _, v| c.motion.arms.rotary_delta.tool_offset = v,
            "Joint plane to tool tip.",
        )
        .unit("mm")
        .v1("delta_tool_offset"),
        number(
            "min_angle",
            "-45",
            ANY,
            |c, _, v| c.motion.arms.rotary_delta.min_angle = v,
            "Lowest allowed arm angle once homed.",
        )
        .unit("deg"),
        number(
            "max_angle",
            "70",
            ANY,
            |c, _, v| c.motion.arms.rotary_delta.max_angle = v,
            "Highest allowed arm angle once homed.",
        )
        .unit("deg"),
        bool("delta_mirror_xy", "true", |c, _, v| c.motion.arms.rotary_delta.mirror_xy = v, "Negates X and Y.")
            .v1("delta_mirror_xy"),
        bool(
            "halt_on_error",
            "true",
            |c, _, v| c.motion.arms.rotary_delta.halt_on_error = v,
            "Halts on a position or an angle the arms cannot reach; otherwise the move is refused.",
        ),
    ],
};

pub const MORGAN_SCARA: Section = Section {
    name: "morgan scara",
    store: None,
    docs: Docs::new("Geometry of a two-link arm."),
    form: Form::Plain,
    settings: &[
        number("arm1_length", "150", POSITIVE, |c, _, v| c.motion.arms.morgan.length[0] = v, "Inner arm length.")
            .unit("mm")
            .v1("arm1_length"),
        number("arm2_length", "150", POSITIVE, |c, _, v| c.motion.arms.morgan.length[1] = v, "Outer arm length.")
            .unit("mm")
            .v1("arm2_length"),
        number(
            "morgan_offset_x",
            "100",
            ANY,
            |c, _, v| c.motion.arms.morgan.offset[0] = v,
            "X from the bed origin to the tower.",
        )
        .unit("mm")
        .v1("morgan_offset_x"),
        number(
            "morgan_offset_y",
            "-60",
            ANY,
            |c, _, v| c.motion.arms.morgan.offset[1] = v,
            "Y from the bed origin to the tower.",
        )
        .unit("mm")
        .v1("morgan_offset_y"),
        number("morgan_scaling_x", "1", ANY, |c, _, v| c.motion.arms.morgan.scaling[0] = v, "X calibration scale.")
            .v1("axis_scaling_x"),
        number("morgan_scaling_y", "1", ANY, |c, _, v| c.motion.arms.morgan.scaling[1] = v, "Y calibration scale.")
            .v1("axis_scaling_y"),
        number(
            "morgan_undefined_min",
            "0.95",
            ANY,
            |c, _, v| c.motion.arms.morgan.undefined[0] = v,
            "Limit of the elbow cosine near the tower.",
        )
        .v1("morgan_undefined_min"),
        number(
            "morgan_undefined_max",
            "0.95",
            ANY,
            |c, _, v| c.motion.arms.morgan.undefined[1] = v,
            "Limit of the elbow cosine at full reach.",
        )
        .v1("morgan_undefined_max"),
    ],
};

pub const COREXZ: Section = Section {
    name: "corexz",
    store: None,
    docs: Docs::new("Gearing of CoreXZ."),
    form: Form::Plain,
    settings: &[
        number("x_reduction", "1", POSITIVE, |c, _, v| c.motion.arms.corexz[0] = v, "X gearing factor.")
            .v1("x_reduction"),
        number("z_reduction", "3", POSITIVE, |c, _, v| c.motion.arms.corexz[1] = v, "Z gearing factor.")
            .v1("z_reduction"),
    ],
};

pub const DELTESIAN: Section = Section {
    name: "deltesian",
    store: None,
    docs: Docs::new(
        "Geometry of two vertical towers, left (alpha) and right (beta), over a bed that gamma moves in Y.",
    ),
    form: Form::Plain,
    settings: &[
        number(
            "left_arm_length",
            "250",
            POSITIVE,
            |c, _, v| c.motion.arms.deltesian.arm_length[0] = v,
            "Diagonal rod on the left.",
        )
        .unit("mm")
        .velvet(),
        number(
            "right_arm_length",
            "250",
            POSITIVE,
            |c, _, v| c.motion.arms.deltesian.arm_length[1] = v,
            "Diagonal rod on the right.",
        )
        .unit("mm")
        .velvet(),
        number(
            "left_arm_x_length",
            "124",
            POSITIVE,
            |c, _, v| c.motion.arms.deltesian.arm_x_length[0] = v,
            "Distance in X of the left rod's joints at X 0.",
        )
        .unit("mm")
        .velvet(),
        number(
            "right_arm_x_length",
            "124",
            POSITIVE,
            |c, _, v| c.motion.arms.deltesian.arm_x_length[1] = v,
            "Distance in X of the right rod's joints at X 0.",
        )
        .unit("mm")
        .velvet(),
    ],
};

pub const GENERIC_CARTESIAN: Section = Section {
    name: "generic cartesian",
    store: None,
    docs: Docs::new("Which axes a motor moves with, as three factors."),
    form: Form::Plain,
    settings: &[
        row("alpha", |c, _, v| c.motion.arms.generic[0] = three(v).unwrap_or_default()),
        row("beta", |c, _, v| c.motion.arms.generic[1] = three(v).unwrap_or_default()),
        row("gamma", |c, _, v| c.motion.arms.generic[2] = three(v).unwrap_or_default()),
    ],
};

pub const WINCH: Section = Section {
    name: "winch",
    store: None,
    docs: Docs::new("Where the ropes leave their winches; 3 to 6 of them, without a gap."),
    form: Form::Plain,
    settings: &[
        anchor("alpha", |c, _, v| c.motion.arms.anchors[0] = three(v)),
        anchor("beta", |c, _, v| c.motion.arms.anchors[1] = three(v)),
        anchor("gamma", |c, _, v| c.motion.arms.anchors[2] = three(v)),
        anchor("delta", |c, _, v| c.motion.arms.anchors[3] = three(v)),
        anchor("epsilon", |c, _, v| c.motion.arms.anchors[4] = three(v)),
        anchor("zeta", |c, _, v| c.motion.arms.anchors[5] = three(v)),
    ],
};

type SetThree = for<'v> fn(&mut MachineConfig, usize, &'v [f64]);

fn three(values: &[f64]) -> Option<[f64; 3]> {
    <[f64; 3]>::try_from(values).ok()
}

const fn row(key: &'static str, set: SetThree) -> Setting {
    numbers(key, 3, set, "What a millimetre of X, of Y and of Z adds to this motor, as in 1,-0.5,0.").velvet()
}

const fn anchor(key: &'static str, set: SetThree) -> Setting {
    numbers(key, 3, set, "X,Y,Z of this motor's winch.").unit("mm").velvet()
}
