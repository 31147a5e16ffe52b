//! Geometry of arms and towers, as the configuration has it and the kinematics take it: lengths in mm,
//! angles in degrees.

/// Configured geometry of a linear delta.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDeltaGeometry {
    /// Length of the rods, mm.
    pub arm_length: f64,
    /// Added to the length of each tower's rod, mm.
    pub arm_offset: [f64; 3],
    /// Horizontal distance of a rod's joints with the tool in the middle, mm.
    pub arm_radius: f64,
    /// Added to the radius of each tower, mm.
    pub tower_offset: [f64; 3],
    /// Added to the angle of each tower, degrees.
    pub tower_angle: [f64; 3],
}

impl Default for LinearDeltaGeometry {
    fn default() -> Self {
        Self {
            arm_length: 250.0,
            arm_offset: [0.0; 3],
            arm_radius: 124.0,
            tower_offset: [0.0; 3],
            tower_angle: [0.0; 3],
        }
    }
}

/// Configured geometry of a rotary delta; lengths in mm, angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotaryDelta {
    /// Side of the effector's triangle (`delta_e`).
    pub effector: f64,
    /// Side of the base's triangle (`delta_f`).
    pub base: f64,
    /// Length of the rods (`delta_re`).
    pub rod: f64,
    /// Length of the upper arms (`delta_rf`).
    pub arm: f64,
    /// Distance from the shafts down to the bed (`delta_z_offset`).
    pub z_offset: f64,
    /// Distance from the plane of the effector's joints to its bottom (`delta_ee_offs`).
    pub effector_offset: f64,
    /// Distance from the plane of the effector's joints to the tip of the tool (`delta_tool_offset`).
    pub tool_offset: f64,
    /// Least and greatest angle of an arm.
    pub angles: [f64; 2],
    /// X and Y count the other way round.
    pub mirror_xy: bool,
}

impl Default for RotaryDelta {
    fn default() -> Self {
        Self {
            effector: 131.636,
            base: 190.526,
            rod: 270.0,
            arm: 90.0,
            z_offset: 290.7,
            effector_offset: 15.0,
            tool_offset: 30.5,
            angles: [-45.0, 70.0],
            mirror_xy: true,
        }
    }
}

/// Configured geometry of a Morgan SCARA; lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Morgan {
    /// Length of the inner link.
    pub arm1: f64,
    /// Length of the outer link.
    pub arm2: f64,
    /// The tower, from the bed's origin.
    pub tower: [f64; 2],
    /// Scale of X and Y.
    pub scaling: [f64; 2],
    /// The elbow's cosine stays above minus the first (folded) and below the second (stretched).
    pub cosine: [f64; 2],
}

impl Default for Morgan {
    fn default() -> Self {
        Self { arm1: 150.0, arm2: 150.0, tower: [100.0, -60.0], scaling: [1.0; 2], cosine: [0.95; 2] }
    }
}

/// Configured geometry, left and right, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deltesian {
    /// Length of the rods.
    pub arm_length: [f64; 2],
    /// Distance in X of tower and tool with the tool in the middle.
    pub arm_x_length: [f64; 2],
}

impl Default for Deltesian {
    fn default() -> Self {
        Self { arm_length: [250.0; 2], arm_x_length: [124.0; 2] }
    }
}
