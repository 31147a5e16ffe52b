//! Geometry of the kinematics: `[linear delta]`, `[rotary delta]`, `[morgan scara]`, `[corexz]` and Velvet's
//! own. Lengths in mm, angles in degrees.

/// The geometry of every arm solution; only that of `arm_solution` counts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Arms {
    /// Section `[linear delta]`: rods and towers.
    pub linear_delta: LinearDeltaArms,
    /// Section `[rotary delta]`: arms and plates.
    pub rotary_delta: RotaryDeltaArms,
    /// Section `[morgan scara]`: links and tower.
    pub morgan: MorganArms,
    /// Reductions `x_reduction` and `z_reduction` of `[corexz]`.
    pub corexz: [f64; 2],
    /// Section `[deltesian]`: rods and towers.
    pub deltesian: DeltesianArms,
    /// Section `[generic cartesian]`: contribution of a millimetre of X, Y and Z to alpha, beta and gamma.
    pub generic: [[f64; 3]; 3],
    /// Section `[winch]`: exit points of the ropes of alpha and so on.
    pub anchors: [Option<[f64; 3]>; units::MAX_ACTUATORS],
}

/// Section `[linear delta]`: rods and towers.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinearDeltaArms {
    /// Length of a diagonal rod.
    pub arm_length: f64,
    /// Added to the length of each tower's rod.
    pub arm_offset: [f64; 3],
    /// Horizontal distance of a rod's joints with the tool in the middle.
    pub arm_radius: f64,
    /// Added to each tower's radius.
    pub tower_offset: [f64; 3],
    /// Added to each tower's angle.
    pub tower_angle: [f64; 3],
    /// Whether a move out of reach halts; otherwise it is refused and the machine goes on.
    pub halt_on_error: bool,
}

/// Section `[rotary delta]`, with the names of the settings.
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
    /// Whether a move out of reach halts; otherwise it is refused and the machine goes on.
    pub halt_on_error: bool,
}

/// Section `[morgan scara]`: links and tower.
#[derive(Clone, Copy, Debug, Default)]
pub struct MorganArms {
    /// Lengths of inner and outer link.
    pub length: [f64; 2],
    /// Position of the tower relative to the bed's origin.
    pub offset: [f64; 2],
    /// Scale corrections of X and Y.
    pub scaling: [f64; 2],
    /// Limits of the elbow's cosine, folded and stretched.
    pub undefined: [f64; 2],
}

/// Section `[deltesian]`, left and right.
#[derive(Clone, Copy, Debug, Default)]
pub struct DeltesianArms {
    /// Lengths of the diagonal rods.
    pub arm_length: [f64; 2],
    /// Distance in X between tower and tool in the middle.
    pub arm_x_length: [f64; 2],
}
