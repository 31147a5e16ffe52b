//! The requests that do not wait for their turn, and the byte of each.

/// Ctrl-X: aborts and halts the machine.
pub const ABORT: u8 = 0x18;
/// Ctrl-Y: clears a halt, or stops this console's action.
pub const STOP: u8 = 0x19;

/// A request that does not wait for its turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Realtime {
    /// `?`: report the status.
    Status,
    /// `!`: feed hold.
    Hold,
    /// `~`: resume after a hold.
    Resume,
    /// Ctrl-X: abort and halt.
    Abort,
    /// Ctrl-Y: clear a halt, else stop what this console started (jog, listing).
    Stop,
    /// 0x87: report the status with all its fields (grblHAL).
    StatusInFull,
    /// 0x84: the safety door is open (GRBL).
    Door,
    /// 0x85: stop jogging (GRBL).
    JogCancel,
    /// A line `M112`: emergency stop. The line itself is carried out in its turn, too, and does no more.
    Emergency,
    /// A line `M410`: the motors brake, and what is queued is dropped.
    QuickStop,
    /// A line `M108`: a wait for a temperature, or for the operator, ends.
    EndWait,
    /// 0x90: feed rates as programmed (GRBL, as all that follow).
    FeedReset,
    /// 0x91: feed rates 10 % up.
    FeedUp10,
    /// 0x92: feed rates 10 % down.
    FeedDown10,
    /// 0x93: feed rates 1 % up.
    FeedUp1,
    /// 0x94: feed rates 1 % down.
    FeedDown1,
    /// 0x95: rapids at their full rate.
    RapidFull,
    /// 0x96: rapids at half their rate.
    RapidHalf,
    /// 0x97: rapids at a quarter of their rate.
    RapidQuarter,
    /// 0x99: spindle as programmed.
    SpindleReset,
    /// 0x9A: spindle 10 % up.
    SpindleUp10,
    /// 0x9B: spindle 10 % down.
    SpindleDown10,
    /// 0x9C: spindle 1 % up.
    SpindleUp1,
    /// 0x9D: spindle 1 % down.
    SpindleDown1,
    /// 0x9E: in a hold, stop the spindle, or start it again.
    SpindleStop,
    /// 0xA0: flood coolant the other way.
    Flood,
    /// 0xA1: mist coolant the other way.
    Mist,
}

impl Realtime {
    /// Every request, the most urgent first.
    pub const ALL: [Self; 27] = [
        Self::Emergency,
        Self::Abort,
        Self::Door,
        Self::QuickStop,
        Self::Hold,
        Self::Resume,
        Self::EndWait,
        Self::JogCancel,
        Self::Stop,
        Self::FeedReset,
        Self::FeedUp10,
        Self::FeedDown10,
        Self::FeedUp1,
        Self::FeedDown1,
        Self::RapidFull,
        Self::RapidHalf,
        Self::RapidQuarter,
        Self::SpindleReset,
        Self::SpindleUp10,
        Self::SpindleDown10,
        Self::SpindleUp1,
        Self::SpindleDown1,
        Self::SpindleStop,
        Self::Flood,
        Self::Mist,
        Self::StatusInFull,
        Self::Status,
    ];
}

/// The request that a line of M with this number makes.
pub const fn classify_line(code: u16, extended: bool) -> Option<Realtime> {
    match code {
        112 => Some(Realtime::Emergency),
        410 if !extended => Some(Realtime::QuickStop),
        108 if !extended => Some(Realtime::EndWait),
        _ => None,
    }
}

/// The request that a control character or a sign makes.
pub const fn classify(byte: u8) -> Option<Realtime> {
    Some(match byte {
        b'?' => Realtime::Status,
        b'!' => Realtime::Hold,
        b'~' => Realtime::Resume,
        ABORT => Realtime::Abort,
        STOP => Realtime::Stop,
        _ => return None,
    })
}

/// The request that a byte of GRBL 1.1's makes.
pub const fn classify_extended(byte: u8) -> Option<Realtime> {
    Some(match byte {
        0x87 => Realtime::StatusInFull,
        0x84 => Realtime::Door,
        0x85 => Realtime::JogCancel,
        0x90 => Realtime::FeedReset,
        0x91 => Realtime::FeedUp10,
        0x92 => Realtime::FeedDown10,
        0x93 => Realtime::FeedUp1,
        0x94 => Realtime::FeedDown1,
        0x95 => Realtime::RapidFull,
        0x96 => Realtime::RapidHalf,
        0x97 => Realtime::RapidQuarter,
        0x99 => Realtime::SpindleReset,
        0x9A => Realtime::SpindleUp10,
        0x9B => Realtime::SpindleDown10,
        0x9C => Realtime::SpindleUp1,
        0x9D => Realtime::SpindleDown1,
        0x9E => Realtime::SpindleStop,
        0xA0 => Realtime::Flood,
        0xA1 => Realtime::Mist,
        _ => return None,
    })
}
