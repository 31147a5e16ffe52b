//! Places of large data: beside the object that uses the data, not within it.
//!
//! A board has a static for each; where there is a heap, the data is there, as tests make thousands of
//! machines.

/// Reference to data that lies elsewhere.
#[cfg(not(any(test, feature = "oracle")))]
pub(crate) type Elsewhere<T> = &'static mut T;
/// Reference to data that lies elsewhere.
#[cfg(any(test, feature = "oracle"))]
pub(crate) type Elsewhere<T> = std::boxed::Box<T>;
