//! Cards that fill up.

use std::format;

use base::ports::{OpenMode, Storage, StorageError};

use super::card::{clean, content, fat16, fat32, mounted};
use super::contents::{load, save};

#[test]
fn a_card_that_fills_up_keeps_what_fitted() {
    for card in [fat16(), fat32()] {
        let mut storage = mounted(&card);
        save(&mut storage, "/sd/early", &content(1, 100_000)).unwrap();
        let big = storage.open("/sd/big.gcode", OpenMode::Write).unwrap();
        let bytes = content(2, 65_536);
        let refused = loop {
            if let Err(error) = storage.write(big, &bytes) {
                break error;
            }
        };
        assert_eq!(refused, StorageError::Full);
        storage.close(big).unwrap();
        let found = clean(&card);
        assert!(found.tree["big.gcode"].content.as_ref().unwrap().chunks(65_536).all(|chunk| bytes.starts_with(chunk)));
        // At the end of the card, what is free lies at its beginning. The same again, over the end.
        storage.remove("/sd/early").unwrap();
        for number in 0..3 {
            save(&mut storage, &format!("/sd/late {number}"), &content(number, 30_000)).unwrap();
            assert_eq!(load(&mut storage, &format!("/sd/late {number}")), Ok(content(number, 30_000)));
        }
        clean(&card);
        for size in [20_000, 511, 1] {
            let _until_full = save(&mut storage, &format!("/sd/rest {size}"), &content(size, size));
        }
        for number in 0..5 {
            let written = save(&mut storage, &format!("/sd/none{number}"), b"1");
            assert_eq!(written, Err(StorageError::Full), "one cluster always stays free");
        }
        clean(&card);
        storage.remove("/sd/big.gcode").unwrap();
        save(&mut storage, "/sd/none1", b"1").unwrap();
        clean(&card);
    }
}
