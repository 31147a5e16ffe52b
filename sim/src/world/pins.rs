//! Pins and buses on which time passes first: switched outputs, SPI of the drivers.

use units::Actuator;

use super::World;

impl World {
    /// Sets the level of the output buffer's enable (PF14): low enables, and it floats high.
    pub fn fet_buffer_pin(&mut self, at_ns: u64, high: bool) {
        self.advance(at_ns);
        self.fet_buffer_on = !high;
    }

    /// Sets the level of the load switch of heaters and fans (PD7): high switches on.
    pub fn fet_power_pin(&mut self, at_ns: u64, high: bool) {
        self.advance(at_ns);
        self.fet_power_on = high;
    }

    /// The level of a heater's output pin, by index in the configuration.
    pub fn heater_pin(&mut self, at_ns: u64, index: usize, high: bool) {
        let on = high == self.config.heaters[index].on_high;
        self.heater_duty(at_ns, index, f64::from(u8::from(on)));
    }

    /// A heater driven with this share of full power, 0 to 1, from now on (a modulated output as its mean).
    pub fn heater_duty(&mut self, at_ns: u64, index: usize, duty: f64) {
        self.advance(at_ns);
        self.heaters[index].load.set(at_ns, duty);
    }

    /// The level of a fan's output pin, by index in the configuration.
    pub fn fan_pin(&mut self, at_ns: u64, index: usize, high: bool) {
        let on = high == self.config.fans[index].on_high;
        self.fan_duty(at_ns, index, f64::from(u8::from(on)));
    }

    /// A fan driven with this share of full speed, 0 to 1, from now on.
    pub fn fan_duty(&mut self, at_ns: u64, index: usize, duty: f64) {
        self.advance(at_ns);
        self.fans[index].load.set(at_ns, duty);
    }

    /// Exchanges a 20-bit SPI frame with an on-board driver; returns the 20 bits it shifts out.
    pub fn driver_spi(&mut self, at_ns: u64, index: usize, frame: u32) -> u32 {
        self.advance(at_ns);
        self.drivers[index].transfer(at_ns, frame)
    }

    /// Exchanges an SPI datagram with the chip of a driver outside; returns the bits shifted out. A line
    /// that nobody drives is pulled up.
    pub fn outside_spi(&mut self, at_ns: u64, motor: Actuator, datagram: [u8; 5]) -> [u8; 5] {
        self.advance(at_ns);
        self.outside[motor as usize].as_mut().map_or([0xFF; 5], |chip| chip.transfer(at_ns, datagram))
    }
}
