//! The accelerometer: no sample is lost while the chip's FIFO holds them.

use crate::desk::{Bench, Said};
use crate::{Command, Response};

/// 4 samples at 3200 a second, as hosts have it.
const REST: u32 = 250_000;

fn bench() -> Bench {
    let mut bench = Bench::with_oids(2);
    bench.tell(Command::ConfigSpi, &[0, 100, 0]);
    bench.tell(Command::SpiSetBus, &[0, 0, 3, 5_000_000]);
    bench.tell(Command::ConfigAdxl345, &[1, 0]);
    bench.finalize();
    bench
}

fn status(bench: &mut Bench) -> Said {
    let said = bench.tell(Command::QueryAdxl345Status, &[1]);
    said.into_iter().find(|(kind, ..)| *kind == Response::SensorBulkStatus).expect("a state")
}

/// Samples as a host reads them: thirteen bits of each axis.
fn unpacked(samples: &[u8]) -> Vec<[i16; 3]> {
    let signed = |value: u16| ((value << 3) as i16) >> 3;
    samples
        .chunks_exact(5)
        .map(|sample| {
            let [x, y, z, xz, yz] = [0, 1, 2, 3, 4].map(|place| u16::from(sample[place]));
            assert!(yz & 0x80 == 0, "a sample that is none");
            [x | (xz & 0x1F) << 8, y | (yz & 0x1F) << 8, z | (xz & 0xE0) << 3 | (yz & 0x60) << 6].map(signed)
        })
        .collect()
}

#[test]
fn samples_come_in_order_and_the_count_tells_their_times() {
    let mut bench = bench();
    bench.tell(Command::QueryAdxl345, &[1, REST]);
    let sent: Vec<[i16; 3]> = (0..400).map(|n: i16| [n * 10 - 2000, 4095 - n, -4096 + 20 * n]).collect();
    let (mut heard, mut messages) = (Vec::new(), 0);
    for four in sent.chunks(4) {
        bench.wires.accelerations.borrow_mut().extend(four);
        bench.pass(REST);
        for (kind, words, samples) in bench.heard() {
            if kind == Response::SensorBulkData {
                assert_eq!(words, [1, messages]);
                messages += 1;
                heard.extend(unpacked(&samples));
            }
        }
    }
    let state = status(&mut bench);
    let known = state.1[3] * 10 + state.1[4] / 5;
    // The sample in the data registers is read with the next ones.
    assert!(known >= 399 && state.1[5] == 0, "{state:?}");
    assert_eq!(heard, sent[..heard.len()]);
    assert!(heard.len() >= 390);
    bench.tell(Command::QueryAdxl345, &[1, 0]);
    bench.wires.accelerations.borrow_mut().extend(&sent);
    bench.pass(10 * REST);
    assert!(bench.heard().iter().all(|(kind, ..)| *kind != Response::SensorBulkData));
}

#[test]
fn a_full_fifo_is_told() {
    let mut bench = bench();
    bench.tell(Command::QueryAdxl345, &[1, REST]);
    bench.wires.accelerations.borrow_mut().extend([[1, 2, 3]; 33]);
    bench.pass(2 * REST);
    let state = status(&mut bench);
    assert!(state.1[5] >= 1, "{state:?}");
}

#[test]
fn a_chip_that_is_not_there_gives_samples_that_are_none() {
    let mut bench = bench();
    bench.tell(Command::QueryAdxl345, &[1, REST]);
    bench.pass(12 * REST);
    let said = bench.heard();
    let (_, _, samples) = said.iter().find(|(kind, ..)| *kind == Response::SensorBulkData).expect("a message");
    assert!(samples.chunks_exact(5).all(|sample| sample[4] & 0x80 != 0));
}
