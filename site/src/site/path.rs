//! The site's part in the path that the machine has made.

use super::Site;
use crate::calls::{Call, Quantity, codes};
use crate::path::Place;
use crate::reply::Content;

impl<const N: usize> Site<N> {
    /// Returns whether the path is to be followed, or just is not any more; none while nobody wants it.
    pub fn follows_path(&mut self) -> Option<bool> {
        let is_anybody_there = self.seats.iter().any(|seat| seat.client.is_some());
        self.path.follows(is_anybody_there)
    }

    /// Adds a place that the machine has come to: machine coordinates, mm, and whether material was laid or
    /// cut on the way there.
    pub fn add_to_path(&mut self, at: [f32; 3], lays: bool) {
        self.path.add(Place { at, lays });
    }

    /// Begins the path anew, as a job does.
    pub fn begin_path(&mut self) {
        self.path.begin();
    }

    /// Answers with the piece of the path from a number on.
    pub(crate) fn path_since(&mut self, call: &Call) -> Content {
        match call.number(Quantity::Seq) {
            Some(number) => Content::Path(self.path.since(number as u32)),
            None => Content::Error(codes::PARAMETERS, "seq is missing"),
        }
    }
}
