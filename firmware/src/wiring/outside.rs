//! External drivers, from the configuration to their pins and buses.

use bsp_prime::pins::{Output, PinSpec, Pins};
use bsp_prime::uart::UartPort;
use config::MachineConfig;
use driver_bank::{SpiRegisters, WireRegisters};
use units::Actuator;

use super::report::{Report, owner, spec};
use crate::drivers::{Line, MotorDriver, OutsideBus};

/// Makes an external driver. As with those on the board, it need not answer yet.
pub fn outside(
    config: &MachineConfig,
    actuator: Actuator,
    bus: OutsideBus,
    enable: Option<Output>,
    report: &mut Report<'_>,
) -> MotorDriver {
    match driver_bank::set_up_outside(bus, enable, config, actuator) {
        Ok(driver) => driver,
        Err(error) => {
            report.trouble(format_args!("driver {}: {error}", actuator.name()));
            MotorDriver::None
        }
    }
}

/// Returns an external driver's chip on an SPI bus.
pub fn spi(
    config: &MachineConfig,
    actuator: Actuator,
    pins: &mut Pins,
    buses: &mut bsp_prime::spi::SpiBuses,
    report: &mut Report<'_>,
) -> Option<OutsideBus> {
    let kind = config.actuators[actuator].driver;
    let channel = config.stealth_family(kind)?.channel;
    // The configuration checker reports a missing select; without one the motor has no driver.
    let select = config.stealth_driver(actuator)?.spi_cs_pin?;
    let select = PinSpec { inverted: true, ..spec(select) };
    let claimed = pins.output(select, &owner("driver", actuator.name(), "spi_cs_pin"));
    let select = report.take(claimed)?;
    let owner = owner(kind.name(), "common", "spi_channel");
    let chip = buses.chip(channel, driver_bank::OUTSIDE_CLOCK, Some(select), pins, &owner);
    Some(OutsideBus::Spi(SpiRegisters(report.take(chip).flatten()?)))
}

/// Returns an external driver's chip on an auxiliary UART, which the first chip claims and opens.
pub fn wire(
    config: &MachineConfig,
    actuator: Actuator,
    channel: u8,
    (uarts, open): (&mut [UartPort; 2], &mut [bool; 2]),
    pins: &mut Pins,
    report: &mut Report<'_>,
) -> Option<OutsideBus> {
    let (port, open) = (uarts.get_mut(usize::from(channel))?, open.get_mut(usize::from(channel))?);
    if !*open {
        let owner = owner(config.actuators[actuator].driver.name(), "common", "uart_channel");
        for pin in port.pins() {
            report.take(pins.claim(pin, &owner))?;
        }
        port.open_single_wire();
        *open = true;
    }
    let address = config.stealth_driver(actuator)?.uart_address;
    Some(OutsideBus::Wire(WireRegisters::new(Line(port.line()), address)))
}
