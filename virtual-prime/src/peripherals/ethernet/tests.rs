//! Tests of the controller at its registers, from RM0399 chapter 61, with memory and a cable.

mod bench;
mod filters;
mod link;
mod offload;
mod registers;
mod rings;
mod trouble;
