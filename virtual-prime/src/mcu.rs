//! The STM32H745 as the emulator runs it: the H743 part with our models in the places of its own.

use rigless::device::{Device, DeviceContext, ErasedDevice, ResetCause};
use rigless::edge::Pulse;
use rigless::mcu::{Mcu, Operate};
use rigless::soc::Layout;
use rigless::soc::stm32h743::Stm32h743;
use rigless::soc::stm32h743::generated::{flash, pwr, rcc, syscfg};
use rigless::soc::stm32h743::peripherals::flash::{Flash, OptionBytes};
use rigless::soc::stm32h743::peripherals::gpio::PORTS;
use rigless::soc::stm32h743::peripherals::tim::Channel;
use rigless::soc::{Bus, Error};
use rigless::time::VirtualNanos;

use sim::world::{PWM_TIMERS, Pin};

use crate::outputs::{PinChange, SharedWorld, TappedExti};
use crate::peripherals::ethernet::{Ethernet, Place as EthernetBlock, Surroundings, Wire};
use crate::peripherals::fmc::Fmc;
use crate::peripherals::iwdg::Iwdg;
use crate::peripherals::otg::core::{Core as UsbCore, Surroundings as UsbSurroundings};
use crate::peripherals::otg::{GLOBAL as USB_GLOBAL, Otg, Place};
use crate::peripherals::pwr::PrimePwr;
use crate::peripherals::rtc::Rtc;
use crate::peripherals::sdmmc::Sdmmc;
use crate::pin_state::{Drive, PinState};
use crate::pins::Wiring;
use crate::timer_outputs::TappedTimer;
use usb_host::controller::Controller;

/// Bits of FLASH_OPTSR in the H745 alone, RM0399 section 4.9.8: cores that start after reset.
const BCM4: u64 = 1 << 22;
const BCM7: u64 = 1 << 23;
/// Pins PA11 and PA12, the USB socket's lines, and the alternate function that connects them to OTG2.
const USB_PINS: [u8; 2] = [11, 12];
const USB_FUNCTION: u8 = 10;

/// Pins of RMII on the board, by port, in four groups: the PHY's clock, management, received data, data to be
/// sent; and the alternate function that connects them.
const ETHERNET_PINS: [&[(usize, &[u8])]; 4] =
    [&[(0, &[1])], &[(0, &[2]), (2, &[1])], &[(0, &[7]), (2, &[4, 5])], &[(6, &[11, 12, 13])]];
const ETHERNET_FUNCTION: u8 = 11;

/// The microcontroller with our models.
#[derive(Debug)]
pub struct PrimeMcu {
    /// Emulator's model of the part, with everything that it models itself.
    pub part: Stm32h743,
    /// EXTI controller, extended to hear the pins.
    exti: TappedExti,
    /// Timers TIM1 and TIM8, whose outputs are observed.
    pub(crate) pwm: [TappedTimer; PWM_TIMERS],
    pwr: PrimePwr,
    ethernet: Ethernet,
    /// Whether an access may have changed the Ethernet controller's surroundings.
    ethernet_is_stale: bool,
    fmc: Fmc,
    iwdg: Iwdg,
    otg: Otg,
    /// Whether an access may have changed the USB core's surroundings.
    usb_is_stale: bool,
    rtc: Rtc,
    /// Controller of the SD card, with its slot.
    pub sdmmc: Sdmmc,
    slots: Slots,
}

#[derive(Clone, Copy, Debug)]
struct Slots {
    adc1: usize,
    exti: usize,
    pwm: [usize; PWM_TIMERS],
    flash: usize,
    pwr: usize,
    rcc: usize,
    syscfg: usize,
    ethernet_dma: usize,
    ethernet_mac: usize,
    ethernet_mtl: usize,
    fmc: usize,
    iwdg: usize,
    otg: usize,
    otg_window: usize,
    rtc: usize,
    sdmmc: usize,
    ports: [usize; PORTS.len()],
    consoles: [usize; 3],
}

impl Slots {
    /// Whether a slot is one of the Ethernet controller's.
    const fn is_ethernet(&self, slot: usize) -> bool {
        slot == self.ethernet_mac || slot == self.ethernet_mtl || slot == self.ethernet_dma
    }

    /// Returns the Ethernet controller's block at one of its slots.
    const fn ethernet_block(&self, slot: usize) -> EthernetBlock {
        if slot == self.ethernet_mac {
            EthernetBlock::Mac
        } else if slot == self.ethernet_mtl {
            EthernetBlock::Mtl
        } else {
            EthernetBlock::Dma
        }
    }

    /// Whether a slot is of a block that lies between the Ethernet controller and its pins: their ports, of
    /// which every access of the image asks this, and SYSCFG.
    const fn is_way_of_ethernet(&self, slot: usize) -> bool {
        slot == self.ports[0] || slot == self.ports[2] || slot == self.ports[6] || slot == self.syscfg
    }
}

impl PrimeMcu {
    /// Creates the part out of power-on reset.
    ///
    /// # Errors
    /// When the emulator's tables lack a peripheral of ours.
    pub fn new(wiring: Wiring, world: SharedWorld) -> Result<Self, Error> {
        let mut part = Stm32h743::new()?;
        let otg_window = part.bus_mut().add_window(Otg::window())?;
        let slot = |name| Mcu::bus(&part).slot(name);
        let mut ports = [0; PORTS.len()];
        for (port, name) in ports.iter_mut().zip(PORTS) {
            *port = slot(name)?;
        }
        let slots = Slots {
            ports,
            consoles: [slot("USART2")?, slot("USART3")?, slot("UART4")?],
            adc1: slot("ADC1")?,
            exti: slot("EXTI")?,
            pwm: [slot("TIM1")?, slot("TIM8")?],
            flash: slot("Flash")?,
            pwr: slot("PWR")?,
            rcc: slot("RCC")?,
            syscfg: slot("SYSCFG")?,
            ethernet_dma: slot("Ethernet_DMA")?,
            ethernet_mac: slot("Ethernet_MAC")?,
            ethernet_mtl: slot("Ethernet_MTL")?,
            fmc: slot("FMC")?,
            iwdg: slot("IWDG")?,
            otg: slot(USB_GLOBAL)?,
            otg_window,
            rtc: slot("RTC")?,
            sdmmc: slot("SDMMC1")?,
        };
        let mut mcu = Self {
            pwm: std::array::from_fn(|timer| TappedTimer::new(timer, world.clone())),
            exti: TappedExti::new(wiring, world),
            pwr: PrimePwr::default(),
            ethernet: Ethernet::new(),
            ethernet_is_stale: true,
            fmc: Fmc,
            iwdg: Iwdg::default(),
            otg: Otg::default(),
            usb_is_stale: true,
            rtc: Rtc::default(),
            sdmmc: Sdmmc::new(None),
            slots,
            part,
        };
        mcu.otg.sit_in(Mcu::bus(&mcu.part).slots()[otg_window].peripheral().registers);
        mcu.set_second_core(false);
        // Each of our models has to sit on the registers it was written for.
        mcu.check()?;
        Ok(mcu)
    }

    /// Sets the rail of VDD and VDDA, millivolts.
    pub fn set_supply(&mut self, millivolts: u32) {
        let registers = self.part.bus_mut().slot_mut(self.slots.pwr).registers_mut();
        self.pwr.inner.set_supply(millivolts, registers);
        self.pwr.inner.set_analog_supply(millivolts, registers);
    }

    /// Changes the rail while the part runs: the detector of VDD tells EXTI (RM0399 sections 7.5.3 and 21.4),
    /// which the emulator does not wire. Only changes are told: a detector that is switched on later tells
    /// nothing.
    pub fn change_supply(&mut self, at: VirtualNanos, millivolts: u32) {
        let below = |mcu: &Self| pwr::csr1::PVDO.is_set(mcu.register(mcu.slots.pwr, pwr::Register::Csr1));
        let before = below(self);
        self.set_supply(millivolts);
        let after = below(self);
        if before != after {
            let (registers, mut context) = self.part.bus_mut().drive(at, self.slots.exti);
            self.exti.detector(after, registers, &mut context);
        }
    }

    /// Programs the option bytes of an H745: the M7 starts after reset, and the M4 or not.
    pub fn set_second_core(&mut self, starts: bool) {
        let bits = BCM7 | if starts { BCM4 } else { 0 };
        let options = OptionBytes { optsr: OptionBytes::FACTORY.optsr | bits, ..OptionBytes::FACTORY };
        let mut flash = std::mem::replace(&mut self.part.flash, Flash::new());
        flash.keep_options(options, self.part.bus_mut().slot_mut(self.slots.flash).registers_mut());
        self.part.flash = flash;
    }

    /// Stops the crystal. Returns whether the clock security system noticed: it switches to the internal
    /// oscillator and sets HSECSSF (RM0399 section 9.5.3). The system's wire to the NMI is not modelled.
    pub fn stop_crystal(&mut self, at: VirtualNanos) -> bool {
        let Ok(spare) = Stm32h743::new() else { return false };
        let mut clocks = std::mem::replace(&mut self.part.rcc, spare.rcc);
        let (registers, mut context) = self.part.bus_mut().drive(at, self.slots.rcc);
        clocks.fail_hse(registers, &mut context);
        self.part.rcc = clocks;
        rcc::cifr::HSECSSF.is_set(self.register(self.slots.rcc, rcc::Register::Cifr))
    }

    /// Stops ADC1: the present conversion never ends, as without a clock, and the results stay as they are.
    pub fn stop_converter(&mut self, at: VirtualNanos) {
        if let (bus, Some(converter)) = self.part.split(self.slots.adc1) {
            let (registers, mut context) = bus.drive(at, self.slots.adc1);
            converter.on_clock(0, registers, &mut context);
        }
    }

    /// Returns a register of the flash interface.
    pub(crate) fn flash_register(&self, register: flash::Register) -> u64 {
        self.register(self.slots.flash, register)
    }

    fn register<R: Layout>(&self, slot: usize, register: R) -> u64 {
        Mcu::bus(&self.part).slots()[slot].registers().get(register)
    }

    /// Whether these pins of a port are connected to the Ethernet controller.
    fn are_ethernet(&self, port: usize, pins: &[u8]) -> bool {
        let registers = self.bus().slots()[self.slots.ports[port]].registers();
        pins.iter().all(|&pin| PinState::of(registers, pin).drive == Drive::Function(ETHERNET_FUNCTION))
    }

    /// Whether these pins of a port are driven faster than at low speed.
    fn are_fast(&self, port: usize, pins: &[u8]) -> bool {
        let registers = self.bus().slots()[self.slots.ports[port]].registers();
        pins.iter().all(|&pin| PinState::of(registers, pin).speed > 0)
    }

    /// Tells the Ethernet controller what it depends on outside of its own registers.
    fn look_around_ethernet(&mut self) {
        if !std::mem::take(&mut self.ethernet_is_stale) {
            return;
        }
        let clocks = rcc::ahb1enr::ETH1MACEN.mask() | rcc::ahb1enr::ETH1TXEN.mask() | rcc::ahb1enr::ETH1RXEN.mask();
        let enabled = self.register(self.slots.rcc, rcc::Register::Ahb1enr) & clocks == clocks;
        // EPIS = 100 selects RMII.
        let rmii = self.register(self.slots.syscfg, syscfg::Register::Pmcr) >> 21 & 7 == 4;
        let [reference, management, receiving, sending] =
            ETHERNET_PINS.map(|group| group.iter().all(|&(port, pins)| self.are_ethernet(port, pins)));
        self.ethernet.look_around(Surroundings {
            clocked: enabled && rmii && reference,
            managed: management,
            hears: receiving,
            speaks: sending,
            speaks_fast: ETHERNET_PINS[3].iter().all(|&(port, pins)| self.are_fast(port, pins)),
            hclk_hz: self.part.rcc.hclk(Mcu::bus(&self.part).slots()[self.slots.rcc].registers()),
        });
    }

    fn with_ethernet<R>(
        &mut self,
        at: VirtualNanos,
        work: impl FnOnce(&mut Ethernet, &mut DeviceContext<'_>) -> R,
    ) -> R {
        self.look_around_ethernet();
        let (_, mut context) = self.part.bus_mut().drive(at, self.slots.ethernet_mac);
        work(self.ethernet.face(EthernetBlock::Mac), &mut context)
    }

    /// Runs `work` with the Ethernet cable and its far end, at this instant.
    pub fn wire<R>(&mut self, at: VirtualNanos, work: impl FnOnce(&mut Wire) -> R) -> R {
        self.with_ethernet(at, |ethernet, context| ethernet.with_wire(context, work))
    }

    /// Returns the state of other blocks that the USB core depends on.
    fn usb_surroundings(&self) -> UsbSurroundings {
        let connected = |&pin: &u8| {
            let port = Mcu::bus(&self.part).slots()[self.slots.ports[0]].registers();
            PinState::of(port, pin).drive == Drive::Function(USB_FUNCTION)
        };
        let clocks = |register| self.register(self.slots.rcc, register);
        UsbSurroundings {
            pins: USB_PINS.iter().all(connected),
            supply: pwr::cr3::USB33DEN.is_set(self.register(self.slots.pwr, pwr::Register::Cr3)),
            ulpi: rcc::ahb1enr::USB2OTGHSULPIEN.is_set(clocks(rcc::Register::Ahb1enr)),
            ulpi_asleep: rcc::ahb1lpenr::USB2OTGHSULPILPEN.is_set(clocks(rcc::Register::Ahb1lpenr)),
            // The emulator tells the core its clock.
            kernel_hz: 0,
        }
    }

    fn look_around_usb(&mut self) {
        if std::mem::take(&mut self.usb_is_stale) {
            let around = self.usb_surroundings();
            self.otg.look_around(around);
        }
    }

    fn with_otg<R>(&mut self, at: VirtualNanos, work: impl FnOnce(&mut Otg, &mut DeviceContext<'_>) -> R) -> R {
        let (_, mut context) = self.part.bus_mut().drive(at, self.slots.otg);
        work(&mut self.otg, &mut context)
    }

    /// Runs `work` with the USB host and the core at the other end of the cable, at this instant.
    pub fn usb<R>(&mut self, at: VirtualNanos, work: impl FnOnce(&mut Controller, &mut UsbCore, u64) -> R) -> R {
        self.look_around_usb();
        self.with_otg(at, |otg, context| otg.with_host(context, work))
    }

    /// Runs the USB core's millisecond. `slept`: the processor has slept in it.
    pub(crate) fn tick_usb(&mut self, at: VirtualNanos, slept: bool) {
        if !self.otg.is_plugged() {
            return;
        }
        if self.usb_is_stale {
            self.look_around_usb();
            self.with_otg(at, Otg::follow);
        }
        if slept {
            self.with_otg(at, Otg::processor_slept);
        }
    }

    /// Tells the machine the level of a pin that the emulator does not announce.
    pub(crate) fn tell(&mut self, at_ns: u64, port: usize, number: usize, high: bool) {
        self.exti.set(at_ns, port, number, high);
    }

    /// Returns the slot of a port's registers on the bus.
    pub(crate) const fn port_slot(&self, port: usize) -> usize {
        self.slots.ports[port]
    }

    /// Returns the pulse that an output of TIM1 (0) or TIM8 (1) repeats, if any.
    #[must_use]
    pub fn pulse(&self, timer: usize, channel: Channel) -> Option<Pulse> {
        self.pwm[timer].inner.pulse(channel, self.bus().slots()[self.slots.pwm[timer]].registers())
    }

    /// Keeps all changes of this pin from now on, for [`Self::take_pin_changes`].
    pub fn watch_pin(&mut self, pin: Pin) {
        self.exti.watch(pin);
    }

    /// Takes the changes of watched pins since the last call, oldest first.
    pub fn take_pin_changes(&mut self) -> Vec<PinChange> {
        self.exti.take_changes()
    }

    /// Returns the state of a pin as the part's registers set it.
    #[must_use]
    pub fn pin_state(&self, pin: Pin) -> PinState {
        PinState::of(self.bus().slots()[self.port_slot(usize::from(pin.port))].registers(), pin.number)
    }

    /// Returns the level that a pin last announced: driven by the part, driven from outside, or pulled.
    #[must_use]
    pub fn level(&self, port: usize, number: usize) -> bool {
        self.exti.level(port, number)
    }
}

impl Mcu for PrimeMcu {
    fn bus(&self) -> &Bus {
        Mcu::bus(&self.part)
    }

    fn bus_mut(&mut self) -> &mut Bus {
        self.part.bus_mut()
    }

    fn reset(&mut self, at: VirtualNanos, cause: ResetCause) {
        self.part.reset(at, cause);
        Device::reset(&mut self.exti);
        self.pwm.iter_mut().for_each(Device::reset);
        Device::reset(&mut self.pwr);
        ErasedDevice::reset(&mut self.ethernet);
        Device::reset(&mut self.fmc);
        Device::reset(&mut self.iwdg);
        Device::reset(&mut self.rtc);
        Device::reset(&mut self.sdmmc);
        ErasedDevice::reset(&mut self.otg);
        self.usb_is_stale = true;
        self.with_otg(at, Otg::restarted);
        self.ethernet_is_stale = true;
        self.with_ethernet(at, Ethernet::restarted);
        self.exti.release_all(at.0);
    }

    /// Polls the serial ports at every stop. Only serial ports have a far end, so the emulator's round of
    /// every model is spared.
    fn poll(&mut self, now: VirtualNanos) {
        for slot in self.slots.consoles {
            let (bus, Some(port)) = self.part.split(slot) else { continue };
            let (registers, mut context) = bus.drive(now, slot);
            port.poll(registers, &mut context);
        }
    }

    fn split(&mut self, slot: usize) -> (&mut Bus, Option<&mut dyn ErasedDevice>) {
        let ours: &mut dyn ErasedDevice = match slot {
            slot if slot == self.slots.exti => &mut self.exti,
            slot if slot == self.slots.pwr => {
                self.usb_is_stale = true;
                &mut self.pwr
            }
            slot if slot == self.slots.pwm[0] => &mut self.pwm[0],
            slot if slot == self.slots.pwm[1] => &mut self.pwm[1],
            slot if self.slots.is_ethernet(slot) => {
                self.look_around_ethernet();
                self.ethernet.face(self.slots.ethernet_block(slot))
            }
            slot if slot == self.slots.fmc => &mut self.fmc,
            slot if slot == self.slots.iwdg => &mut self.iwdg,
            slot if slot == self.slots.otg || slot == self.slots.otg_window => {
                self.look_around_usb();
                self.otg.face(if slot == self.slots.otg { Place::Global } else { Place::Rest })
            }
            slot if slot == self.slots.rtc => &mut self.rtc,
            slot if slot == self.slots.sdmmc => &mut self.sdmmc,
            _ => {
                self.usb_is_stale |= slot == self.slots.rcc || slot == self.slots.ports[0];
                self.ethernet_is_stale |= slot == self.slots.rcc || self.slots.is_way_of_ethernet(slot);
                return self.part.split(slot);
            }
        };
        (self.part.bus_mut(), Some(ours))
    }
}
