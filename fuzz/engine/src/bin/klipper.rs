//! The target `klipper` under libFuzzer.
#![no_main]

use fuzz::{TARGETS, Target};

const TARGET: &Target = &TARGETS[7];

libfuzzer_sys::fuzz_target!(|data: &[u8]| (TARGET.run)(data));
libfuzzer_sys::fuzz_mutator!(|data: &mut [u8], size: usize, most: usize, seed: u32| {
    let target = TARGET;
    fuzz_engine::mutate(target, data, size, most, seed)
});
