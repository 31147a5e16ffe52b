//! Path of pin levels to the machine: every level change of every pin passes here, at its instant.
//!
//! Ports announce each change as a request, and the EXTI controller hears all of them; so the EXTI's place on
//! the bus is taken by [`TappedExti`], which hands the change on to the machine and then to the real EXTI.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rigless::device::{Device, DeviceContext, Level, RegisterFile, RequestChange};
use rigless::soc::stm32h743::generated::{self, exti::Register};
use rigless::soc::stm32h743::peripherals::exti::Exti;
use sim::world::{Pin, World};

use crate::pins::{PINS, PORTS, Role, Wiring};

/// The machine, shared by the parts of the board that touch it. All of them run on the emulator's thread, so
/// the lock is never contended; the emulator's `Send` bound requires it.
#[derive(Clone, Debug)]
pub struct SharedWorld(Arc<Mutex<World>>);

impl SharedWorld {
    /// Wraps a machine for sharing.
    pub fn new(world: World) -> Self {
        Self(Arc::new(Mutex::new(world)))
    }

    /// Locks the shared machine.
    pub fn lock(&self) -> MutexGuard<'_, World> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A level that a watched pin took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PinChange {
    /// Instant of the change, nanoseconds since power-on.
    pub at_ns: u64,
    /// Pin that has changed.
    pub pin: Pin,
    /// Level after the change.
    pub high: bool,
}

/// The EXTI controller, extended to hear all pins.
#[derive(Debug)]
pub struct TappedExti {
    inner: Exti,
    wiring: Wiring,
    world: SharedWorld,
    /// Last announced level of every pin.
    levels: [[bool; PINS]; PORTS],
    /// Pins whose changes are kept.
    watched: [[bool; PINS]; PORTS],
    changes: Vec<PinChange>,
}

impl TappedExti {
    /// Creates the block with every pin released.
    pub fn new(wiring: Wiring, world: SharedWorld) -> Self {
        let none = [[false; PINS]; PORTS];
        let inner = Exti::new(generated::SYSCFG.base);
        let mut tapped = Self { inner, wiring, world, levels: none, watched: none, changes: Vec::new() };
        tapped.release_all(0);
        tapped
    }

    /// Returns the last announced level of a pin.
    pub fn level(&self, port: usize, number: usize) -> bool {
        self.levels[port][number]
    }

    /// Keeps every change of this pin from now on.
    pub fn watch(&mut self, pin: Pin) {
        self.watched[usize::from(pin.port)][usize::from(pin.number)] = true;
    }

    /// Takes the changes of watched pins since the last call, oldest first.
    pub fn take_changes(&mut self) -> Vec<PinChange> {
        std::mem::take(&mut self.changes)
    }

    /// Follows the detector of the chip's supply (event input 16): where the image listens for such an edge,
    /// it becomes pending, as if by software.
    pub fn detector(&mut self, below: bool, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        const EVENT: u64 = 1 << 16;
        let edges = if below { Register::Rtsr1 } else { Register::Ftsr1 };
        if file.get(edges) & EVENT != 0 {
            self.inner.write(Register::Swier1, EVENT, file, context);
        }
    }

    /// Releases all pins, as a reset does: pull resistors decide. The buffer's enable is pulled up (off); ENN
    /// floats, and the drivers' inputs read a floating ENN as high; everything else is pulled or leaks low.
    pub fn release_all(&mut self, at_ns: u64) {
        self.levels = [[false; PINS]; PORTS];
        let roles: Vec<_> = self.wiring.all().collect();
        for (_, role) in roles {
            self.drive(at_ns, role, matches!(role, Role::FetBuffer | Role::MotorsDisable));
        }
    }

    fn drive(&self, at_ns: u64, role: Role, high: bool) {
        let mut world = self.world.lock();
        match role {
            Role::Step(actuator) => world.step_pin(at_ns, actuator, high),
            Role::Direction(actuator) => world.direction_pin(at_ns, actuator, high),
            Role::Enable(actuator) => world.enable_pin(at_ns, actuator, high),
            Role::MotorsDisable => world.motors_disable_pin(at_ns, high),
            Role::FetBuffer => world.fet_buffer_pin(at_ns, high),
            Role::FetPower => world.fet_power_pin(at_ns, high),
            Role::Heater(index) => world.heater_pin(at_ns, index, high),
            Role::Fan(index) => world.fan_pin(at_ns, index, high),
        }
    }

    fn hear(&mut self, at_ns: u64, change: RequestChange) {
        let Some(&[letter]) = change.instance.strip_prefix("GPIO").map(str::as_bytes) else { return };
        self.set(at_ns, usize::from(letter - b'A'), change.request, change.level == Level::High);
    }

    /// Sets the level of a pin.
    pub fn set(&mut self, at_ns: u64, port: usize, number: usize, high: bool) {
        let before = std::mem::replace(&mut self.levels[port][number], high);
        if self.watched[port][number] && before != high {
            self.changes.push(PinChange { at_ns, pin: Pin { port: port as u8, number: number as u8 }, high });
        }
        if let Some(role) = self.wiring.role(port, number) {
            self.drive(at_ns, role, high);
        }
    }
}

impl Device for TappedExti {
    type Register = Register;

    fn read(&mut self, register: Register, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        self.inner.read(register, file, context)
    }

    fn steady(&self, register: Register, file: &RegisterFile) -> bool {
        self.inner.steady(register, file)
    }

    fn write(&mut self, register: Register, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.inner.write(register, value, file, context);
    }

    fn on_request(&mut self, change: RequestChange, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.hear(context.now().0, change);
        self.inner.on_request(change, file, context);
    }

    /// Hears every pin, whose levels are the machine's.
    fn hears(&self, instance: &'static str, _request: usize) -> bool {
        instance.starts_with("GPIO")
    }

    fn on_access(&mut self, token: u64, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.inner.on_access(token, value, file, context);
    }

    fn on_refused(&mut self, token: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.inner.on_refused(token, file, context);
    }

    fn reset(&mut self) {
        Device::reset(&mut self.inner);
    }
}
