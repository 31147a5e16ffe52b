//! Geometry of the kinematics: `[linear delta]`, `[rotary delta]`, `[morgan scara]`, `[corexz]` and Velvet's
//! own. Lengths in mm, angles in degrees.

use crate::setting::build::{ANY, POSITIVE, bool, number, numbers};
use crate::setting::declare::settings;
use units::{Deltesian, LinearDeltaGeometry, Morgan, RotaryDelta};

/// The geometry of every arm solution; only that of `arm_solution` counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arms {
    /// Section `[linear delta]`: rods and towers.
    pub linear_delta: LinearDeltaGeometry,
    /// Whether a linear delta halts on a place out of reach; otherwise the move is refused.
    pub linear_delta_halts: bool,
    /// Section `[rotary delta]`: arms and plates.
    pub rotary_delta: RotaryDelta,
    /// Whether a rotary delta halts on a place out of reach; otherwise the move is refused.
    pub rotary_delta_halts: bool,
    /// Section `[morgan scara]`: links and tower.
    pub morgan: Morgan,
    /// Reductions `x_reduction` and `z_reduction` of `[corexz]`.
    pub corexz: [f64; 2],
    /// Section `[deltesian]`: rods and towers.
    pub deltesian: Deltesian,
    /// Section `[generic cartesian]`: contribution of a millimetre of X, Y and Z to alpha, beta and gamma.
    pub generic: [[f64; 3]; 3],
    /// Section `[winch]`: exit points of the ropes of alpha and so on.
    pub anchors: [Option<[f64; 3]>; units::MAX_ACTUATORS],
}

settings! {
    /// Geometry of a delta with three towers.
    rows LinearDeltaArms of LinearDeltaGeometry {
        /// Diagonal rod length.
        "arm_length" arm_length = number("250", POSITIVE).unit("mm").klipper("[stepper_<axis>] arm_length").v1("arm_length");
        /// Horizontal distance between rod joints when centred.
        "arm_radius" arm_radius = number("124", POSITIVE).unit("mm").klipper("[printer] delta_radius").v1("arm_radius");
        /// Radial offset of tower 1 (X, at 210 degrees).
        "delta_tower1_offset" tower_offset[0] = number("0", ANY).unit("mm").v1("delta_tower1_offset");
        /// Radial offset of tower 2 (Y, at 330 degrees).
        "delta_tower2_offset" tower_offset[1] = number("0", ANY).unit("mm").v1("delta_tower2_offset");
        /// Radial offset of tower 3 (Z, at 90 degrees).
        "delta_tower3_offset" tower_offset[2] = number("0", ANY).unit("mm").v1("delta_tower3_offset");
        /// Angular offset of tower 1.
        "delta_tower1_angle" tower_angle[0] = number("0", ANY).unit("deg").v1("delta_tower1_angle");
        /// Angular offset of tower 2.
        "delta_tower2_angle" tower_angle[1] = number("0", ANY).unit("deg").v1("delta_tower2_angle");
        /// Angular offset of tower 3.
        "delta_tower3_angle" tower_angle[2] = number("0", ANY).unit("deg").v1("delta_tower3_angle");
        /// Added to arm_length for the rods of tower 1.
        "delta_arm1_offset" arm_offset[0] = number("0", ANY).unit("mm").klipper("[stepper_a] arm_length").velvet();
        /// Added to arm_length for the rods of tower 2.
        "delta_arm2_offset" arm_offset[1] = number("0", ANY).unit("mm").klipper("[stepper_b] arm_length").velvet();
        /// Added to arm_length for the rods of tower 3.
        "delta_arm3_offset" arm_offset[2] = number("0", ANY).unit("mm").klipper("[stepper_c] arm_length").velvet();
    }
}

settings! {
    /// Places that a delta with three towers cannot reach.
    rows LinearDeltaHalt of Arms {
        /// Halts on a position the arms cannot reach; otherwise the move is refused and the machine goes on.
        "halt_on_error" linear_delta_halts = bool("true");
    }
}

settings! {
    /// Geometry of a delta with three shoulder motors.
    rows RotaryDeltaArms of RotaryDelta {
        /// End effector length.
        "delta_e" effector = number("131.636", POSITIVE).unit("mm").v1("delta_e");
        /// Base length.
        "delta_f" base = number("190.526", POSITIVE).unit("mm").v1("delta_f");
        /// Rod length.
        "delta_re" rod = number("270", POSITIVE).unit("mm").v1("delta_re");
        /// Upper arm length.
        "delta_rf" arm = number("90", POSITIVE).unit("mm").v1("delta_rf");
        /// Distance from the arm shafts to the bed.
        "delta_z_offset" z_offset = number("290.7", ANY).unit("mm").v1("delta_z_offset");
        /// Joint plane to effector bottom.
        "delta_ee_offs" effector_offset = number("15", ANY).unit("mm").v1("delta_ee_offs");
        /// Joint plane to tool tip.
        "delta_tool_offset" tool_offset = number("30.5", ANY).unit("mm").v1("delta_tool_offset");
        /// Lowest allowed arm angle once homed.
        "min_angle" angles[0] = number("-45", ANY).unit("deg");
        /// Highest allowed arm angle once homed.
        "max_angle" angles[1] = number("70", ANY).unit("deg");
        /// Negates X and Y.
        "delta_mirror_xy" mirror_xy = bool("true").v1("delta_mirror_xy");
    }
}

settings! {
    /// Places that a delta with three shoulders cannot reach.
    rows RotaryDeltaHalt of Arms {
        /// Halts on a position or an angle the arms cannot reach; otherwise the move is refused.
        "halt_on_error" rotary_delta_halts = bool("true");
    }
}

settings! {
    /// Geometry of a two-link arm.
    rows MorganArms of Morgan {
        /// Inner arm length.
        "arm1_length" arm1 = number("150", POSITIVE).unit("mm").v1("arm1_length");
        /// Outer arm length.
        "arm2_length" arm2 = number("150", POSITIVE).unit("mm").v1("arm2_length");
        /// X from the bed origin to the tower.
        "morgan_offset_x" tower[0] = number("100", ANY).unit("mm").v1("morgan_offset_x");
        /// Y from the bed origin to the tower.
        "morgan_offset_y" tower[1] = number("-60", ANY).unit("mm").v1("morgan_offset_y");
        /// X calibration scale.
        "morgan_scaling_x" scaling[0] = number("1", ANY).v1("axis_scaling_x");
        /// Y calibration scale.
        "morgan_scaling_y" scaling[1] = number("1", ANY).v1("axis_scaling_y");
        /// Limit of the elbow cosine near the tower.
        "morgan_undefined_min" cosine[0] = number("0.95", ANY).v1("morgan_undefined_min");
        /// Limit of the elbow cosine at full reach.
        "morgan_undefined_max" cosine[1] = number("0.95", ANY).v1("morgan_undefined_max");
    }
}

settings! {
    /// Geometry of two vertical towers, left (alpha) and right (beta), over a bed that gamma moves in Y.
    rows DeltesianArms of Deltesian {
        /// Diagonal rod on the left.
        "left_arm_length" arm_length[0] = number("250", POSITIVE).unit("mm").velvet();
        /// Diagonal rod on the right.
        "right_arm_length" arm_length[1] = number("250", POSITIVE).unit("mm").velvet();
        /// Distance in X of the left rod's joints at X 0.
        "left_arm_x_length" arm_x_length[0] = number("124", POSITIVE).unit("mm").velvet();
        /// Distance in X of the right rod's joints at X 0.
        "right_arm_x_length" arm_x_length[1] = number("124", POSITIVE).unit("mm").velvet();
    }
}

settings! {
    /// Gearing of CoreXZ.
    rows CoreXz of Arms {
        /// X gearing factor.
        "x_reduction" corexz[0] = number("1", POSITIVE).v1("x_reduction");
        /// Z gearing factor.
        "z_reduction" corexz[1] = number("3", POSITIVE).v1("z_reduction");
    }
}

settings! {
    /// Which axes a motor moves with, as three factors.
    rows GenericCartesian of Arms {
        /// What a millimetre of X, of Y and of Z adds to this motor, as in 1,-0.5,0.
        "alpha" generic[0] = numbers(3).velvet();
        /// What a millimetre of X, of Y and of Z adds to this motor, as in 1,-0.5,0.
        "beta" generic[1] = numbers(3).velvet();
        /// What a millimetre of X, of Y and of Z adds to this motor, as in 1,-0.5,0.
        "gamma" generic[2] = numbers(3).velvet();
    }
}

settings! {
    /// Where the ropes leave their winches; 3 to 6 of them, without a gap.
    rows Winch of Arms {
        /// X,Y,Z of this motor's winch.
        "alpha" anchors[0] = numbers(3).unit("mm").velvet();
        /// X,Y,Z of this motor's winch.
        "beta" anchors[1] = numbers(3).unit("mm").velvet();
        /// X,Y,Z of this motor's winch.
        "gamma" anchors[2] = numbers(3).unit("mm").velvet();
        /// X,Y,Z of this motor's winch.
        "delta" anchors[3] = numbers(3).unit("mm").velvet();
        /// X,Y,Z of this motor's winch.
        "epsilon" anchors[4] = numbers(3).unit("mm").velvet();
        /// X,Y,Z of this motor's winch.
        "zeta" anchors[5] = numbers(3).unit("mm").velvet();
    }
}
