//! An image's manifest, its first 256 bytes: what it is, for which board, how long, and what its bytes hash
//! to. The vector table follows at byte 1024.
//!
//! | bytes | what |
//! |--:|---|
//! | 0 | `VELVET` and format 1 as two bytes |
//! | 8 | board magic, [`BOARD_MAGIC`], little-endian like all numbers |
//! | 16 | length of the image with its manifest, a multiple of 32 |
//! | 20 | the address it is linked for |
//! | 24 | version, UTF-8 with zeros behind it, 40 bytes |
//! | 64 | SHA-256 of bytes 0 to 63 and of all bytes from 256 on |
//! | 96 | Ed25519 signature of `velvet firmware` and these 32 bytes, or zeros |
//! | 160 | zeros |
//! | 256 | nothing, up to the vector table |

use crate::flash::Layout;
use core::fmt;

/// Length of a manifest, bytes.
pub const MANIFEST_BYTES: usize = 256;

/// Offset of the vector table in an image. VTOR asks for a multiple of the table's size, rounded up to a
/// power of two (ARMv7-M ARM B3.2.5): 16 and 150 vectors (RM0399 section 20.1.2) take 664 bytes.
pub const VECTOR_TABLE: u32 = 1024;

/// The Prime's magic number, as in the images of Smoothieware v2.
pub const BOARD_MAGIC: u64 = 0x1234_5678_9876_5403;

pub(crate) const MARK: [u8; 8] = *b"VELVET\x01\x00";
/// The part of a manifest that is hashed.
pub(crate) const HASHED: usize = 64;
const VERSION: core::ops::Range<usize> = 24..64;
pub(crate) const LENGTH: usize = 16;
pub(crate) const DIGEST: usize = 64;
pub(crate) const SIGNATURE: usize = 96;

/// Manifest of an image: its description of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Manifest {
    /// Bytes of the image, the manifest among them.
    pub length: u32,
    /// SHA-256 of the image; all ones where nothing has sealed it, as the linker leaves it.
    pub digest: [u8; 32],
    /// Ed25519 over the digest.
    pub signature: Option<[u8; 64]>,
    version: [u8; 40],
}

/// Reason for which an image may not be installed, or may not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flaw {
    /// The image does not begin with a manifest.
    NoManifest,
    /// Smoothieware v2, or anything else that takes the flash from its beginning and has no image of ours
    /// behind.
    FromTheBeginning,
    /// The board magic is another one.
    OtherBoard,
    /// The image is linked for another address.
    OtherAddress(u32),
    /// The manifest gives this length, for which there is no room, or which no image can have.
    Length(u32),
    /// The file ends before the image does.
    Truncated {
        /// Bytes of the file.
        is: u32,
        /// Bytes of the image.
        says: u32,
    },
    /// The bytes behind the image are no trailer of Smoothieware v2.
    Trailer,
    /// The trailer's MD5 is another one.
    Md5,
    /// The image's bytes do not hash to its digest.
    Digest,
    /// The image was linked, but never sealed.
    Unsealed,
    /// The image has no signature, and the machine's owner has locked the board.
    Unsigned,
    /// The signature is not by the owner's key.
    Signature,
    /// A part could not be read.
    Unreadable,
}

impl fmt::Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoManifest => f.write_str("this is no Velvet firmware"),
            Self::FromTheBeginning => f.write_str(
                "this firmware takes the place of the boot stage (install it with BOOT0 and dfu-util), or its file ends too soon",
            ),
            Self::OtherBoard => f.write_str("this firmware is for another board"),
            Self::OtherAddress(address) => write!(f, "this firmware is linked for 0x{address:08x}"),
            Self::Length(bytes) => write!(f, "an image of {bytes} bytes has no room in flash"),
            Self::Truncated { is, says } => write!(f, "the file has {is} of {says} bytes; copy it again"),
            Self::Trailer => f.write_str("what follows the image is no trailer with magic number and MD5"),
            Self::Md5 => f.write_str("MD5 does not match; copy the file again"),
            Self::Digest => f.write_str("SHA-256 does not match; copy the file again"),
            Self::Unsealed => f.write_str("this image was linked but not sealed; `make firmware` makes one that is"),
            Self::Unsigned => f.write_str("this board is locked, and the image is not signed"),
            Self::Signature => f.write_str("the image is not signed with this board's key"),
            Self::Unreadable => f.write_str("it cannot be read"),
        }
    }
}

impl Manifest {
    /// Reads a manifest from its bytes.
    ///
    /// # Errors
    /// The bytes are no manifest, or have impossible values.
    pub fn parse(bytes: &[u8; MANIFEST_BYTES], layout: &Layout) -> Result<Self, Flaw> {
        if bytes[..8] != MARK {
            return Err(no_manifest(bytes, layout));
        }
        if u64::from_le_bytes(part(bytes, 8)) != BOARD_MAGIC {
            return Err(Flaw::OtherBoard);
        }
        let address = number(bytes, 20);
        if address != layout.image_address() {
            return Err(Flaw::OtherAddress(address));
        }
        let digest = part(bytes, DIGEST);
        if digest == [0xff; 32] {
            return Err(Flaw::Unsealed);
        }
        let length = number(bytes, LENGTH);
        // A vector table of 16 system exceptions is the least that can run.
        let least = VECTOR_TABLE + 64;
        if length < least || length > layout.image_bytes() || !length.is_multiple_of(32) {
            return Err(Flaw::Length(length));
        }
        let signature = part(bytes, SIGNATURE);
        let signature = (signature != [0; 64]).then_some(signature);
        Ok(Self { length, digest, signature, version: part(bytes, VERSION.start) })
    }

    /// A manifest for the linker to place: of this version, its first 40 bytes that is, and not sealed.
    #[must_use]
    pub const fn draft(version: &str, layout: &Layout) -> [u8; MANIFEST_BYTES] {
        let mut bytes = [0; MANIFEST_BYTES];
        put(&mut bytes, 0, &MARK);
        put(&mut bytes, 8, &BOARD_MAGIC.to_le_bytes());
        put(&mut bytes, 20, &layout.image_address().to_le_bytes());
        let (version, _) = version.as_bytes().split_at(if version.len() < 40 { version.len() } else { 40 });
        put(&mut bytes, VERSION.start, version);
        put(&mut bytes, DIGEST, &[0xff; 32]);
        bytes
    }

    /// The version, as `make firmware` has written it.
    #[must_use]
    pub fn version(&self) -> &str {
        let text = self.version.split(|byte| *byte == 0).next().unwrap_or_default();
        core::str::from_utf8(text).unwrap_or("?")
    }
}

/// Returns the flaw of bytes without a manifest: images that begin with a vector table for the beginning of
/// the flash are told apart.
fn no_manifest(bytes: &[u8; MANIFEST_BYTES], layout: &Layout) -> Flaw {
    let (stack, reset) = (number(bytes, 0), number(bytes, 4));
    let is_ram = (0x2000_0000..=0x2408_0000).contains(&stack);
    let is_flash = (layout.address..layout.address + 0x20_0000).contains(&reset) && reset % 2 == 1;
    if is_ram && is_flash { Flaw::FromTheBeginning } else { Flaw::NoManifest }
}

/// Puts a part where it belongs; what has no room is left out.
pub(crate) const fn put(bytes: &mut [u8; MANIFEST_BYTES], at: usize, part: &[u8]) {
    let mut index = 0;
    while index < part.len() && at + index < MANIFEST_BYTES {
        bytes[at + index] = part[index];
        index += 1;
    }
}

fn number(bytes: &[u8; MANIFEST_BYTES], at: usize) -> u32 {
    u32::from_le_bytes(part(bytes, at))
}

/// Returns `N` bytes from a place on; zeros beyond the manifest, which no caller asks for.
fn part<const N: usize>(bytes: &[u8; MANIFEST_BYTES], at: usize) -> [u8; N] {
    bytes.get(at..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; N])
}
