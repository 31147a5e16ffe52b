//! Without its crystal the board has no clocks that anything here is built on, no USB and no application. The
//! boot stage reports so on the debug console and with its LEDs, and tries again.

use bsp_prime::boot_stage::{self, Crippled};
use bsp_prime::clocks::ClockError;

/// Number of blinks between two tries.
const BLINKS: u32 = 8;
/// Time of each half of a blink, ms: LED1 and LED3, then LED2 and LED4.
const BLINK_MS: u32 = 250;

/// Reports the clock error, blinks, and resets the board.
pub fn run(mut board: Crippled) -> ! {
    board.say(match board.why {
        ClockError::NoCrystal => {
            "boot stage: the 25 MHz crystal does not start: nothing runs without; trying again\r\n"
        }
        ClockError::Wrong(_) | ClockError::FlashTiming => {
            "boot stage: the clocks do not come out as they should; trying again\r\n"
        }
    });
    for blink in 0..BLINKS {
        for (index, led) in board.leds.iter_mut().enumerate() {
            led.set(index as u32 % 2 == blink % 2);
        }
        board.pause(BLINK_MS);
    }
    boot_stage::reset()
}
