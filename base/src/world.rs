//! The world as one machine sees it: all ports together.

use crate::ports::{
    Ahead, Board, Calendar, Clock, DriversPort, EventLog, HeatPort, Inputs, LightPort, MotionPort, PinPort, Rest,
    Storage, Updates, Usb,
};
use crate::sessions::Consoles;
use crate::supervisor::SupervisorPort;

/// All that one machine asks of the world.
pub trait Ports:
    Clock
    + Rest
    + MotionPort
    + Ahead
    + HeatPort
    + LightPort
    + DriversPort
    + SupervisorPort
    + Inputs
    + PinPort
    + Storage
    + Consoles
    + Board
    + Usb
    + Calendar
    + EventLog
    + Updates
{
}

impl<P> Ports for P where
    P: Clock
        + Rest
        + MotionPort
        + Ahead
        + HeatPort
        + LightPort
        + DriversPort
        + SupervisorPort
        + SupervisorPort
        + Inputs
        + PinPort
        + Storage
        + Consoles
        + Board
        + Usb
        + Calendar
        + EventLog
        + Updates
{
}
