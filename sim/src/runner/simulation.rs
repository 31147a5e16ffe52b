//! The simulated machine and its time, as the chips on its buses reach them.

use std::cell::{Cell, RefCell};

use crate::world::World;

/// Value that the executor and the runner use in turns; neither holds it while the other runs.
pub type Turns<T> = RefCell<T>;
/// Plain value that both may set.
pub type Flag<T> = Cell<T>;

/// The simulated machine, and what time it is there.
pub struct Simulation {
    /// Virtual time since power-on, nanoseconds.
    pub now_ns: Flag<u64>,
    /// Time at which the last bit on each auxiliary UART is over.
    pub wires_ns: [Flag<u64>; 2],
    pub world: Turns<World>,
}

impl Simulation {
    /// Makes a machine at power-on.
    pub const fn new(world: World) -> Self {
        Self { now_ns: Flag::new(0), wires_ns: [const { Flag::new(0) }; 2], world: Turns::new(world) }
    }
}
