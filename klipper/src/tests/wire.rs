//! Blocks and integers, by the vectors that Klipper's own encoder gives.

use proptest::prelude::*;

use crate::wire::{BLOCK_BYTES, Framer, Incoming, crc16, read_integer, write_block, write_integer};

#[test]
fn the_crc_is_the_catalogue_s() {
    assert_eq!(crc16(b"123456789"), 0x6F91);
}

#[test]
fn blocks_are_those_of_klipper_s_encoder() {
    let vectors: [(u8, &[u8], &[u8]); 6] = [
        (0, &[], &[0x05, 0x10, 0x9E, 0x81, 0x7E]),
        (1, &[], &[0x05, 0x11, 0x8F, 0x08, 0x7E]),
        (15, &[], &[0x05, 0x1F, 0x66, 0x76, 0x7E]),
        (0, &[1, 0, 40], &[0x08, 0x10, 0x01, 0x00, 0x28, 0x5E, 0x9F, 0x7E]),
        (1, &[1, 40, 40], &[0x08, 0x11, 0x01, 0x28, 0x28, 0xAF, 0xD7, 0x7E]),
        (5, &[1, 0x81, 0x48, 40], &[0x09, 0x15, 0x01, 0x81, 0x48, 0x28, 0xD0, 0x70, 0x7E]),
    ];
    for (sequence, content, expected) in vectors {
        let mut block = [0; BLOCK_BYTES];
        let length = write_block(content, sequence, &mut block);
        assert_eq!(&block[..length], expected);
        let mut framer = Framer::new();
        let mut blocks: Vec<_> = expected.iter().filter_map(|byte| framer.take(*byte)).collect();
        let Some(Incoming::Block(block)) = blocks.pop() else { panic!("no block of {expected:x?}") };
        assert_eq!((block.sequence(), block.content()), (sequence, content));
    }
}

#[test]
fn integers_are_those_of_klipper_s_encoder() {
    let vectors: [(i64, &[u8]); 24] = [
        (0, &[0x00]),
        (-1, &[0x7F]),
        (95, &[0x5F]),
        (-32, &[0x60]),
        (96, &[0x80, 0x60]),
        (-33, &[0xFF, 0x5F]),
        (127, &[0x80, 0x7F]),
        (-4096, &[0xE0, 0x00]),
        (128, &[0x81, 0x00]),
        (-4097, &[0xFF, 0xDF, 0x7F]),
        (12287, &[0xDF, 0x7F]),
        (-524_288, &[0xE0, 0x80, 0x00]),
        (12288, &[0x80, 0xE0, 0x00]),
        (-524_289, &[0xFF, 0xDF, 0xFF, 0x7F]),
        (1_572_863, &[0xDF, 0xFF, 0x7F]),
        (-67_108_864, &[0xE0, 0x80, 0x80, 0x00]),
        (1_572_864, &[0x80, 0xE0, 0x80, 0x00]),
        (-67_108_865, &[0xFF, 0xDF, 0xFF, 0xFF, 0x7F]),
        (201_326_591, &[0xDF, 0xFF, 0xFF, 0x7F]),
        (-2_147_483_648, &[0xF8, 0x80, 0x80, 0x80, 0x00]),
        (201_326_592, &[0x80, 0xE0, 0x80, 0x80, 0x00]),
        (2_147_483_647, &[0x87, 0xFF, 0xFF, 0xFF, 0x7F]),
        (400_000_000, &[0x81, 0xBE, 0xDE, 0x88, 0x00]),
        (7458, &[0xBA, 0x22]),
    ];
    for (value, expected) in vectors {
        let (bytes, length) = write_integer(value as u32);
        assert_eq!(&bytes[..length], expected, "{value}");
        assert_eq!(read_integer(expected), Some((value as u32, &[][..])), "{value}");
    }
    // A host writes a count of 2^32 - 1 with five bytes; it is read like -1.
    assert_eq!(read_integer(&[0x8F, 0xFF, 0xFF, 0xFF, 0x7F]), Some((u32::MAX, &[][..])));
}

proptest! {
    #[test]
    fn an_integer_reads_back(value: u32, behind in proptest::collection::vec(any::<u8>(), 0..4)) {
        let (bytes, length) = write_integer(value);
        let mut all = bytes[..length].to_vec();
        all.extend(&behind);
        prop_assert_eq!(read_integer(&all), Some((value, &behind[..])));
    }

    #[test]
    fn a_block_is_found_behind_any_noise(
        noise in proptest::collection::vec(any::<u8>(), 0..200),
        content in proptest::collection::vec(any::<u8>(), 0..59),
        sequence in 0_u8..16,
    ) {
        let mut block = [0; BLOCK_BYTES];
        let length = write_block(&content, sequence, &mut block);
        let mut framer = Framer::new();
        for byte in &noise {
            let _heard = framer.take(*byte);
        }
        // A block that seems to begin in the noise may swallow the next bytes; the host repeats, with a sync
        // ahead.
        let found = (0..4).any(|_| {
            framer.take(0x7E);
            block[..length].iter().any(|byte| match framer.take(*byte) {
                Some(Incoming::Block(found)) => found.sequence() == sequence && found.content() == content,
                _ => false,
            })
        });
        prop_assert!(found || length < 40);
    }

    #[test]
    fn damage_is_told_once(noise in proptest::collection::vec(0_u8..4, 1..200)) {
        let mut framer = Framer::new();
        let told = noise.iter().filter(|byte| framer.take(**byte).is_some()).count();
        prop_assert!(told == 1);
    }
}
