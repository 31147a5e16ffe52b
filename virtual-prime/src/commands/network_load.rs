//! A computer at the Ethernet socket that keeps quiet, or sends all that the cable carries.

use clap::ValueEnum;
use virtual_prime::net_desk::frames::{self, EVERYBODY, End};
use virtual_prime::net_desk::peer::{Connection, Peer};
use virtual_prime::vm::Vm;

/// Traffic of the computer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Load {
    /// A DHCP server that is there, and a cable without traffic.
    Quiet,
    /// A visitor who asks all the time, pings of every length, and questions to everybody: a cable of
    /// 100 Mbit/s without a gap.
    Flood,
}

/// Pings and ARP questions of a slice of 10 ms. A ping takes 64 us on average, and a question 7 us: more
/// would only pile up before the cable.
const PINGS: usize = 130;
const QUESTIONS: usize = 150;
/// Lengths of a ping's payload, bytes; a step that has no divisor in common reaches all of them.
const LENGTHS: usize = 1_473;
const LENGTH_STEP: usize = 37;
/// Port of the board's console, and the words of its visitor.
const CONSOLE: u16 = 23;
const WORDS: &[u8] = b"M105\n?";

/// The computer, plugged in.
pub struct NetworkLoad {
    load: Load,
    peer: Peer,
    visitor: Option<Connection>,
    pings: usize,
}

impl NetworkLoad {
    /// Plugs the computer in.
    pub fn plug(load: Load, vm: &mut Vm) -> Self {
        let peer = Peer::new(1);
        peer.plug(vm);
        Self { load, peer, visitor: None, pings: 0 }
    }

    /// Whether the board has said something from an address.
    pub fn knows_the_board(&self) -> bool {
        self.peer.board_end().is_some()
    }

    /// Has a turn of the computer, with traffic if the machine moves.
    pub fn serve(&mut self, vm: &mut Vm, moves: bool) {
        if self.load == Load::Flood && moves {
            self.talk();
            self.flood();
        }
        self.peer.serve(vm);
    }

    fn talk(&mut self) {
        let Some(visitor) = self.visitor else {
            self.visitor = self.peer.connect(CONSOLE);
            return;
        };
        if self.peer.unsent(visitor) == 0 {
            self.peer.send(visitor, WORDS);
        }
        self.peer.receive(visitor);
    }

    fn flood(&mut self) {
        // The board has sent something when it took its address.
        let Some(board) = self.peer.board_end() else { return };
        let own = self.peer.own_end();
        for _ in 0..PINGS {
            let payload = vec![0x55; self.pings * LENGTH_STEP % LENGTHS];
            self.peer.put(&frames::ping(own, board, 1, self.pings as u16, &payload));
            self.pings += 1;
        }
        let everybody = End { hardware: EVERYBODY, address: own.address };
        (0..QUESTIONS).for_each(|_| self.peer.put(&frames::arp(own, everybody, false)));
    }
}
