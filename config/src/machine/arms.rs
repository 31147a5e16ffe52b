//! Geometry of the kinematics: `[linear delta]`, `[rotary delta]`, `[morgan scara]`, `[corexz]` and Velvet's
//! own. Lengths in mm, angles in degrees.

/// The geometry of every arm solution; only that of `arm_solution` counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arms {
    /// `[linear delta]`
    pub linear_delta: LinearDeltaArms,
    /// `[rotary delta]`
    pub rotary_delta: RotaryDeltaArms,
    /// `[morgan scara]`
    pub morgan: MorganArms,
    /// `[corexz]` `x_reduction` and `z_reduction`.
    pub corexz: [f64; 2],
    /// `[deltesian]`
    pub deltesian: DeltesianArms,
    /// `[generic cartesian]`: what a millimetre of X, Y and Z adds to alpha, beta and gamma.
    pub generic: [[f64; 3]; 3],
    /// `[winch]`: where the ropes of alpha and so on leave their winches.
    pub anchors: [Option<[f64; 3]>; units::MAX_ACTUATORS],
}

/// `[linear delta]`
#[derive(Clone, Copy, Debug, Default)]
pub struct LinearDeltaArms {
    /// Diagonal rod.
    pub arm_length: f64,
    /// Added to the length of each tower's rod.
    pub arm_offset: [f64; 3],
    /// Horizontal distance of a rod's joints with the tool in the middle.
    pub arm_radius: f64,
    /// Added to each tower's radius.
    pub tower_offset: [f64; 3],
    /// Added to each tower's angle.
    pub tower_angle: [f64; 3],
    /// A move out of reach halts; otherwise it is refused and the machine goes on.
    pub halt_on_error: bool,
}

/// `[rotary delta]`, by the names of the settings.
#[derive(Clone, Copy, Debug, Default)]
#[allow(missing_docs, reason = "the settings reference explains them")]
pub struct RotaryDeltaArms {
    pub e: f64,
    pub f: f64,
    pub re: f64,
    pub rf: f64,
    pub z_offset: f64,
    pub ee_offs: f64,
    pub tool_offset: f64,
    pub min_angle: f64,
    pub max_angle: f64,
    pub mirror_xy: bool,
    /// A move out of reach halts; otherwise it is refused and the machine goes on.
    pub halt_on_error: bool,
}

/// `[morgan scara]`
#[derive(Clone, Copy, Debug, Default)]
pub struct MorganArms {
    /// Inner and outer link.
    pub length: [f64; 2],
    /// From the bed's origin to the tower.
    pub offset: [f64; 2],
    /// Calibration of X and Y.
    pub scaling: [f64; 2],
    /// Limits of the elbow's cosine, folded and stretched.
    pub undefined: [f64; 2],
}

/// `[deltesian]`, left and right.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeltesianArms {
    /// Diagonal rods.
    pub arm_length: [f64; 2],
    /// Distance in X of tower and tool in the middle.
    pub arm_x_length: [f64; 2],
}
