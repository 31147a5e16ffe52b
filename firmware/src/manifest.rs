//! The manifest in front of the image: what the boot stage reads of it.

use update::{MANIFEST_BYTES, Manifest, PRIME};

/// `make firmware` fills in length and digest, so whoever wants to know those reads the flash and not this.
#[used]
#[unsafe(link_section = ".manifest")]
static MANIFEST: [u8; MANIFEST_BYTES] = Manifest::draft(env!("VELVET_VERSION"), &PRIME);
