//! A USB serial port made of other people's crates, unchanged: the HAL's OTG2, `synopsys-usb-otg`,
//! `usb-device` and `usbd-serial`. The image echoes its input, letters in upper case, and ends with a full
//! stop that comes after an exclamation mark.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m_rt::entry;
use images::pass;
use stm32h7xx_hal::pac;
use stm32h7xx_hal::prelude::*;
use stm32h7xx_hal::rcc::rec::UsbClkSel;
use stm32h7xx_hal::usb_hs::{USB2, UsbBus};
use usb_device::prelude::*;
use usbd_serial::SerialPort;

/// Memory for packets of the OUT endpoints.
static mut MEMORY: MaybeUninit<[u32; 1024]> = MaybeUninit::uninit();

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    let pwrcfg = dp.PWR.constrain().smps().freeze();
    let rcc = dp.RCC.constrain().use_hse(25.MHz()).sys_ck(200.MHz());
    let mut ccdr = rcc.freeze(pwrcfg, &dp.SYSCFG);
    let _ = ccdr.clocks.hsi48_ck().expect("HSI48 runs");
    ccdr.peripheral.kernel_usb_clk_mux(UsbClkSel::Hsi48);
    let gpioa = dp.GPIOA.split(ccdr.peripheral.GPIOA);
    let (dm, dp_pin) = (gpioa.pa11.into_alternate(), gpioa.pa12.into_alternate());
    let usb = USB2::new(
        dp.OTG2_HS_GLOBAL,
        dp.OTG2_HS_DEVICE,
        dp.OTG2_HS_PWRCLK,
        dm,
        dp_pin,
        ccdr.peripheral.USB2OTG,
        &ccdr.clocks,
    );
    // SAFETY: this is the only reference, made once, and any content is as good as zeros.
    #[allow(static_mut_refs, reason = "the memory is the bus's for good")]
    let memory = unsafe { MEMORY.write([0; 1024]) };
    let bus = UsbBus::new(usb, memory);
    let mut serial = SerialPort::new(&bus);
    let mut device = UsbDeviceBuilder::new(&bus, UsbVidPid(0x16C0, 0x27DD))
        .strings(&[StringDescriptors::default().manufacturer("Somebody else").product("Echo").serial_number("1")])
        .unwrap()
        .device_class(usbd_serial::USB_CLASS_CDC)
        .build();
    let (mut held, mut from, mut to) = ([0_u8; 512], 0, 0);
    let mut last = 0;
    loop {
        let stirred = device.poll(&mut [&mut serial]);
        if from == to {
            (from, to) = (0, 0);
            if stirred && let Ok(count) = serial.read(&mut held) {
                to = count;
                for byte in &mut held[..count] {
                    if (last, *byte) == (b'!', b'.') {
                        pass();
                    }
                    last = *byte;
                    byte.make_ascii_uppercase();
                }
            }
        }
        if from < to
            && let Ok(count) = serial.write(&held[from..to])
        {
            from += count;
        }
    }
}
