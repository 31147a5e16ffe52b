//! Points in machine space and in motor space, and how near they may come to an edge of the reachable space:
//! common to all families of kinematics.

/// X, Y and Z.
pub(super) type Axes = [f64; 3];
/// Alpha, beta and gamma.
pub(super) type Motors = [f64; 3];

/// Square of a nanometre: a floor that keeps roots and divisions sound at the edges.
pub(super) const TINY: f64 = 1e-12;
/// A place this near to an edge of the reachable space, mm, is refused: motors would have to be infinitely
/// fast there.
pub(super) const LEAST_CLEARANCE: f64 = 0.01;
