//! The dictionary as a host fetches it, made by the build script.
include!(concat!(env!("OUT_DIR"), "/dictionary.rs"));
