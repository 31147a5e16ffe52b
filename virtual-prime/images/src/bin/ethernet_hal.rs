//! A TCP echo made of other people's crates, unchanged: the HAL's Ethernet driver and the release of smoltcp
//! that it is tied to. The address comes from DHCP, port 7 echoes, and a full stop after an exclamation mark
//! ends the run.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m_rt::entry;
use images::pass;
use smoltcp::iface::{Config, Interface, SocketSet, SocketStorage};
use smoltcp::socket::{dhcpv4, tcp};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, IpCidr};
use stm32h7xx_hal::ethernet::phy::LAN8742A;
use stm32h7xx_hal::ethernet::{self, DesRing, PHY};
use stm32h7xx_hal::pac;
use stm32h7xx_hal::prelude::*;

/// Core clock, which counts the time.
const HZ: u64 = 200_000_000;
const ADDRESS: EthernetAddress = EthernetAddress([0x02, 0x00, 0x11, 0x22, 0x33, 0x44]);
const PORT: u16 = 7;

static mut RINGS: MaybeUninit<DesRing<4, 4>> = MaybeUninit::uninit();
static mut BUFFERS: [[u8; 4_096]; 2] = [[0; 4_096]; 2];

/// Time since the start, from the cycle counter that runs over every 21 s.
struct Time {
    last: u32,
    cycles: u64,
}

impl Time {
    fn now(&mut self) -> Instant {
        let count = cortex_m::peripheral::DWT::cycle_count();
        self.cycles += u64::from(count.wrapping_sub(self.last));
        self.last = count;
        Instant::from_micros((self.cycles * 1_000_000 / HZ) as i64)
    }
}

/// Echoes as much as there is room for. Returns whether the end was asked for.
fn echo(socket: &mut tcp::Socket<'_>, last: &mut u8) -> bool {
    if !socket.is_open() {
        socket.listen(PORT).unwrap();
    }
    if socket.may_send() && !socket.may_recv() && socket.recv_queue() == 0 {
        socket.close();
    }
    let mut piece = [0; 512];
    let room = (socket.send_capacity() - socket.send_queue()).min(piece.len());
    let Ok(count) = socket.recv_slice(&mut piece[..room]) else { return false };
    for byte in &piece[..count] {
        if (*last, *byte) == (b'!', b'.') {
            return true;
        }
        *last = *byte;
    }
    if count > 0 {
        socket.send_slice(&piece[..count]).unwrap();
    }
    false
}

#[entry]
fn main() -> ! {
    let dp = pac::Peripherals::take().unwrap();
    let mut core = cortex_m::Peripherals::take().unwrap();
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    let pwrcfg = dp.PWR.constrain().smps().freeze();
    let rcc = dp.RCC.constrain().use_hse(25.MHz()).sys_ck(200.MHz()).hclk(200.MHz());
    let ccdr = rcc.freeze(pwrcfg, &dp.SYSCFG);
    let gpioa = dp.GPIOA.split(ccdr.peripheral.GPIOA);
    let gpioc = dp.GPIOC.split(ccdr.peripheral.GPIOC);
    let gpiog = dp.GPIOG.split(ccdr.peripheral.GPIOG);
    let pins = (
        gpioa.pa1.into_alternate(),
        gpioa.pa2.into_alternate(),
        gpioc.pc1.into_alternate(),
        gpioa.pa7.into_alternate(),
        gpioc.pc4.into_alternate(),
        gpioc.pc5.into_alternate(),
        gpiog.pg11.into_alternate(),
        gpiog.pg13.into_alternate(),
        gpiog.pg12.into_alternate(),
    );
    // SAFETY: these are the only references, made once.
    #[allow(static_mut_refs, reason = "the memory is the driver's for good")]
    let (rings, [receiving, sending]) = unsafe { (RINGS.write(DesRing::new()), &mut BUFFERS) };
    let (mut device, mac) = ethernet::new(
        dp.ETHERNET_MAC,
        dp.ETHERNET_MTL,
        dp.ETHERNET_DMA,
        pins,
        rings,
        ADDRESS,
        ccdr.peripheral.ETH1MAC,
        &ccdr.clocks,
    );
    let mut phy = LAN8742A::new(mac.set_phy_addr(0));
    phy.phy_reset();
    phy.phy_init();
    phy.block_until_link();

    let mut time = Time { last: cortex_m::peripheral::DWT::cycle_count(), cycles: 0 };
    let mut interface = Interface::new(Config::new(ADDRESS.into()), &mut device, time.now());
    let mut storage = [SocketStorage::EMPTY; 2];
    let mut sockets = SocketSet::new(&mut storage[..]);
    let dhcp = sockets.add(dhcpv4::Socket::new());
    let buffer = |bytes: &'static mut [u8; 4_096]| tcp::SocketBuffer::new(&mut bytes[..]);
    let tcp = sockets.add(tcp::Socket::new(buffer(receiving), buffer(sending)));
    let mut last = 0;
    loop {
        interface.poll(time.now(), &mut device, &mut sockets);
        if let Some(dhcpv4::Event::Configured(lease)) = sockets.get_mut::<dhcpv4::Socket<'_>>(dhcp).poll() {
            interface.update_ip_addrs(|addresses| {
                addresses.clear();
                addresses.push(IpCidr::Ipv4(lease.address)).unwrap();
            });
        }
        if echo(sockets.get_mut(tcp), &mut last) {
            pass();
        }
    }
}
