//! The mutator that the engines share: half of the mutations know the language of the inputs, the other
//! half bytes.
#![forbid(unsafe_code)]

use fuzz::Target;
use fuzz::dice::Dice;

/// Changes `data`, which holds `size` bytes of an input and has room for `most`; returns the new size.
pub fn mutate(target: &Target, data: &mut [u8], size: usize, most: usize, seed: u32) -> usize {
    let mut dice = Dice::new(u64::from(seed));
    if dice.once_in(3) {
        return libfuzzer_sys::fuzzer_mutate(data, size, most);
    }
    let mut input = data.get(..size).unwrap_or_default().to_vec();
    for _ in 0..=dice.below(3) {
        target.mutate(&mut input, &mut dice, most.min(data.len()));
    }
    let (place, _) = data.split_at_mut(input.len());
    place.copy_from_slice(&input);
    input.len()
}
