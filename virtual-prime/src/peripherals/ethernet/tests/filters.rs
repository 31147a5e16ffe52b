//! The address filter, 61.5.3.

use rigless::soc::stm32h743::generated::ethernet_mac::Register;

use super::super::bits::macpfr;
use super::super::checksum::frame_check;
use super::super::descriptor::receive;
use super::bench::*;

const MDNS: [u8; 6] = [0x01, 0x00, 0x5E, 0x00, 0x00, 0xFB];
const OTHER: [u8; 6] = [0x02, 0x11, 0x22, 0x33, 0x44, 0x56];
const EVERYBODY: [u8; 6] = [0xFF; 6];

/// Sends a frame to each address. Returns which of them were received.
fn received(bench: &mut Bench, addresses: &[[u8; 6]]) -> Vec<bool> {
    let taken = |bench: &mut Bench| bench.wire(|wire| wire.counters().received);
    let mut list = Vec::new();
    for &address in addresses {
        let before = taken(bench);
        bench.arrive(&frame(address, PARTNER, 0x88B5, &[0; 46]));
        list.push(taken(bench) > before);
        for place in 0..RING {
            bench.release(place);
        }
        bench.dma(rigless::soc::stm32h743::generated::ethernet_dma::Register::Dmacrxdtpr, RX_RING);
    }
    list
}

#[test]
fn own_address_and_broadcasts_pass_and_nothing_else() {
    let all = [BOARD, OTHER, EVERYBODY, MDNS];
    for (options, expected) in [
        (0, [true, false, true, false]),
        (macpfr::DBF, [true, false, false, false]),
        (macpfr::PM, [true, false, true, true]),
        (macpfr::PR, [true, true, true, true]),
        (macpfr::RA, [true, true, true, true]),
        (macpfr::DAIF, [false, true, true, true]),
    ] {
        let mut bench = Bench::running();
        bench.mac(Register::Macpfr, options);
        assert_eq!(received(&mut bench, &all), expected, "{options:#x}");
    }
}

#[test]
fn frames_that_pass_by_ra_are_marked() {
    let mut bench = Bench::running();
    bench.mac(Register::Macpfr, macpfr::RA);
    bench.arrive(&frame(OTHER, PARTNER, 0x88B5, &[0; 46]));
    assert_eq!(bench.peek(RX_RING + 8), receive::DAF);
}

/// Examples of RM0399, ETH_MACHT0R: 1F52419CB6AF gives 0x2C, A00A98000045 gives 0x07.
#[test]
fn the_hash_of_an_address_is_that_of_the_manual() {
    let hash = |address: [u8; 6]| frame_check(&address).reverse_bits() >> 26;
    assert_eq!(hash([0x1F, 0x52, 0x41, 0x9C, 0xB6, 0xAF]), 0x2C);
    assert_eq!(hash([0xA0, 0x0A, 0x98, 0x00, 0x00, 0x45]), 0x07);
}

#[test]
fn the_hash_table_lets_groups_through() {
    let mut bench = Bench::running();
    let place = frame_check(&MDNS).reverse_bits() >> 26;
    let table = if place < 32 { Register::Macht0r } else { Register::Macht1r };
    bench.mac(table, 1 << (place & 31));
    assert_eq!(received(&mut bench, &[MDNS]), [false], "HMC is missing");
    bench.mac(Register::Macpfr, macpfr::HMC);
    assert_eq!(received(&mut bench, &[MDNS, BOARD, OTHER, [1, 0, 0x5E, 0, 0, 1]]), [true, true, false, false]);
    bench.mac(Register::Macpfr, macpfr::HMC | macpfr::HUC);
    assert_eq!(received(&mut bench, &[BOARD]), [false], "unicasts by the table alone");
    bench.mac(Register::Macpfr, macpfr::HMC | macpfr::HUC | macpfr::HPF);
    assert_eq!(received(&mut bench, &[BOARD, MDNS]), [true, true]);
}

#[test]
fn further_addresses_count_when_they_are_enabled() {
    let mut bench = Bench::running();
    bench.mac(Register::Maca1hr, 0xFB00);
    bench.mac(Register::Maca1lr, 0x005E_0001);
    assert_eq!(received(&mut bench, &[MDNS]), [false]);
    bench.mac(Register::Maca1hr, 1 << 31 | 0xFB00);
    assert_eq!(received(&mut bench, &[MDNS, [1, 0, 0x5E, 0, 0, 1]]), [true, false]);
    // MBC leaves the last byte out.
    bench.mac(Register::Maca1hr, 1 << 31 | 1 << 29 | 0xFB00);
    assert_eq!(received(&mut bench, &[MDNS, [1, 0, 0x5E, 0, 0, 1]]), [true, true]);
}

#[test]
fn the_station_address_counts_with_the_write_of_its_low_register() {
    let mut bench = Bench::running();
    bench.mac(Register::Maca0hr, 0x5644);
    assert_eq!(received(&mut bench, &[BOARD, OTHER]), [true, false]);
    bench.mac(Register::Maca0lr, 0x3322_1102);
    assert_eq!(received(&mut bench, &[BOARD, OTHER]), [false, true]);
}
