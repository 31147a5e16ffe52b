//! Access to the laser.

/// The laser beside the path: the power of moves comes to it with their steps, as events of the step queue.
/// Until it is first unlocked it is off. On a machine without one nothing happens.
pub trait LaserPort {
    /// Locks the laser off, whatever the path says, or lets what comes from now on through to it.
    fn lock_laser(&mut self, is_locked: bool);

    /// Keeps the output off while the machine holds, or lets the power that the path has by now come out
    /// again, unless the laser is locked.
    fn darken_laser(&mut self, is_dark: bool);

    /// Gives the laser a duty, 1/65535, until the path changes it. Only while nothing moves.
    fn set_laser(&mut self, duty: u16);

    /// Keeps the power at rest up: on the board it goes off 100 ms after the last look. Returns whether the
    /// laser has locked itself since the last look, lit or dark: at rest because there was none for so long,
    /// in motion because the steps came late. True once; it stays locked.
    fn look_at_laser(&mut self) -> bool;

    /// Sets the frequency of the duty, hertz; the duty becomes 0. Only while nothing moves.
    fn set_laser_frequency(&mut self, hertz: u32);
}
