//! A service over a card that is only what these tests need; the real model is tried in `sim`.

mod card;
mod order;
mod reading;
mod users;
