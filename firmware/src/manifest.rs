//! Manifest in front of the image, for the boot stage. The controller's image has this file as well.

use update::{MANIFEST_BYTES, Manifest, PRIME};

/// `make firmware` fills in length and digest, so code that needs those reads the flash and not this static.
#[used]
#[unsafe(link_section = ".manifest")]
static MANIFEST: [u8; MANIFEST_BYTES] = Manifest::draft(env!("VELVET_VERSION"), &PRIME);
