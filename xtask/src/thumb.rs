//! Decodes the Thumb instructions that move the stack pointer, branch, or load a constant: some two dozen
//! patterns of ARM DDI 0403E (section A7.7). A
//! disassembler would be a large dependency, and the small ones do not know the floating point unit's.

/// A decoded Thumb-2 instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// Length in bytes: 2 or 4.
    pub length: u64,
    /// Effect on stack and control flow.
    pub effect: Effect,
}

/// Effects of instructions that the reports look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// The stack pointer moves down by so many bytes, or up.
    Stack(i64),
    /// The stack pointer moves up, and the function returns.
    Return,
    /// The stack pointer moves down by a register.
    StackBy(u8),
    /// A register becomes the stack pointer less so many bytes.
    BelowStack(u8, i64),
    /// The stack pointer becomes a register.
    StackFrom(u8),
    /// A register becomes a constant.
    Constant(u8, u32),
    /// The upper half of a register becomes a constant.
    Upper(u8, u16),
    /// A register becomes the word at an address.
    Literal(u8, u64),
    /// A call of an address.
    Call(u64),
    /// A call of the address in a register.
    CallRegister(u8),
    /// An unconditional branch to an address.
    Jump(u64),
    /// A conditional branch to an address.
    Branch(u64),
    /// A branch to the address in a register.
    JumpRegister(u8),
    /// A branch by a table of offsets.
    Table,
    /// Anything else; it may write the registers whose bits are set.
    Other(u16),
}

/// Numbers of registers that are named.
const SP: u16 = 13;
const LR: u8 = 14;
const PC: u16 = 15;

/// The instruction at `address`, of its first half word and the one behind it.
pub fn decode(address: u64, first: u16, second: u16) -> Instruction {
    // 32-bit instructions begin with 0b11101, 0b11110 or 0b11111 (section A5.1).
    if first >> 11 >= 0b11101 {
        Instruction { length: 4, effect: wide(address + 4, first, second) }
    } else {
        Instruction { length: 2, effect: narrow(address + 4, first) }
    }
}

fn narrow(pc: u64, word: u16) -> Effect {
    let low = i64::from(word & 0xFF);
    match word {
        0xB400..=0xB5FF => Effect::Stack(4 * i64::from((word & 0x1FF).count_ones())),
        0xBC00..=0xBCFF => Effect::Stack(-4 * i64::from((word & 0xFF).count_ones())),
        0xBD00..=0xBDFF => Effect::Return,
        0xB000..=0xB07F => Effect::Stack(-4 * (low & 0x7F)),
        0xB080..=0xB0FF => Effect::Stack(4 * (low & 0x7F)),
        0x4800..=0x4FFF => Effect::Literal((word >> 8 & 7) as u8, (pc & !3) + 4 * u64::from(word & 0xFF)),
        0x2000..=0x27FF => Effect::Constant((word >> 8 & 7) as u8, u32::from(word & 0xFF)),
        _ if word & 0xFF87 == 0x4685 => Effect::StackFrom((word >> 3 & 15) as u8),
        _ if word & 0xFF87 == 0x4780 => Effect::CallRegister((word >> 3 & 15) as u8),
        _ if word & 0xFF87 == 0x4700 => match (word >> 3 & 15) as u8 {
            LR => Effect::Return,
            register => Effect::JumpRegister(register),
        },
        // B<c> T1; conditions 14 and 15 are UDF and SVC.
        0xD000..=0xDDFF => Effect::Branch(pc.wrapping_add_signed(signed(u32::from(word & 0xFF) << 1, 9))),
        0xE000..=0xE7FF => Effect::Jump(pc.wrapping_add_signed(signed(u32::from(word & 0x7FF) << 1, 12))),
        // Decodes CBZ and CBNZ.
        _ if word & 0xF500 == 0xB100 => Effect::Branch(pc + u64::from((word >> 9 & 1) << 6 | (word >> 3 & 31) << 1)),
        _ => Effect::Other(1 << narrow_target(word)),
    }
}

/// The register that an instruction of 16 bits may write, whether it does or not.
fn narrow_target(word: u16) -> u16 {
    match word {
        // ADD, CMP and MOV of high registers.
        0x4400..=0x46FF => word >> 4 & 8 | word & 7,
        // MOV, CMP, ADD and SUB of a byte; loads and addresses beside the stack pointer; LDM.
        0x2000..=0x3FFF | 0x9000..=0xAFFF | 0xC000..=0xCFFF => word >> 8 & 7,
        _ => word & 7,
    }
}

fn wide(pc: u64, first: u16, second: u16) -> Effect {
    let (rn, rd) = (first & 15, second >> 8 & 15);
    let byte = i64::from(second & 0xFF);
    let plain = u32::from(first >> 10 & 1) << 11 | u32::from(second >> 12 & 7) << 8 | u32::from(second & 0xFF);
    match (first, second) {
        // PUSH.W, POP.W, and their forms of one and of two registers.
        (0xE92D, _) => Effect::Stack(4 * i64::from(second.count_ones())),
        (0xE8BD, _) if second >> PC == 1 => Effect::Return,
        (0xE8BD, _) => Effect::Stack(-4 * i64::from(second.count_ones())),
        (0xF84D, _) if second & 0x0F00 == 0x0D00 => Effect::Stack(byte),
        (0xF85D, _) if second & 0xFF00 == 0xFB00 => Effect::Return,
        (0xF85D, _) if second & 0x0F00 == 0x0B00 => Effect::Stack(-byte),
        (0xE96D, _) => Effect::Stack(4 * byte),
        (0xE8FD, _) => Effect::Stack(-4 * byte),
        // Decodes VPUSH and VPOP.
        (_, _) if first & 0xFFBF == 0xED2D && second & 0x0E00 == 0x0A00 => Effect::Stack(4 * byte),
        (_, _) if first & 0xFFBF == 0xECBD && second & 0x0E00 == 0x0A00 => Effect::Stack(-4 * byte),
        // SUB and ADD of a constant.
        _ if first & 0xFBE0 == 0xF1A0 && rn == SP && second >> 15 == 0 => below(rd, i64::from(expanded(plain))),
        _ if first & 0xFBF0 == 0xF2A0 && rn == SP && second >> 15 == 0 => below(rd, i64::from(plain)),
        _ if first & 0xFBE0 == 0xF100 && rn == SP && rd == SP => Effect::Stack(-i64::from(expanded(plain))),
        _ if first & 0xFBF0 == 0xF200 && rn == SP && rd == SP => Effect::Stack(-i64::from(plain)),
        // SUB of a register; ADD of one is a way back.
        (0xEBAD, _) if second & 0xFFF0 == 0x0D00 => Effect::StackBy((second & 15) as u8),
        // MOVW, MOV.W, MOVT.
        _ if first & 0xFBF0 == 0xF240 && second >> 15 == 0 => Effect::Constant(rd as u8, u32::from(rn) << 12 | plain),
        _ if first & 0xFBEF == 0xF04F && second >> 15 == 0 => Effect::Constant(rd as u8, expanded(plain)),
        _ if first & 0xFBF0 == 0xF2C0 && second >> 15 == 0 => Effect::Upper(rd as u8, rn << 12 | plain as u16),
        // TBB, TBH, and LDR of the PC.
        _ if first & 0xFFF0 == 0xE8D0 && second & 0xFFE0 == 0xF000 => Effect::Table,
        _ if matches!(first & 0xFFF0, 0xF850 | 0xF8D0) && second >> 12 == PC => Effect::Table,
        // LDR of a literal, before or behind.
        (0xF85F, _) => Effect::Literal((second >> 12) as u8, (pc & !3) - u64::from(second & 0xFFF)),
        (0xF8DF, _) => Effect::Literal((second >> 12) as u8, (pc & !3) + u64::from(second & 0xFFF)),
        _ if first & 0xF800 == 0xF000 && second >> 15 == 1 => branch(pc, first, second),
        // LDM; and all others, which write one of two, or none.
        _ if first & 0xFE50 == 0xE810 => Effect::Other(second),
        _ => Effect::Other(1 << (second >> 12) | 1 << rd),
    }
}

/// Branches of 32 bits (sections A7.7.12 and A7.7.18).
fn branch(pc: u64, first: u16, second: u16) -> Effect {
    let sign = u32::from(first >> 10 & 1);
    let (j1, j2) = (u32::from(second >> 13 & 1), u32::from(second >> 11 & 1));
    let low = u32::from(second & 0x7FF) << 1;
    let (i1, i2) = (!(j1 ^ sign) & 1, !(j2 ^ sign) & 1);
    let far = sign << 24 | i1 << 23 | i2 << 22 | u32::from(first & 0x3FF) << 12 | low;
    let near = sign << 20 | j2 << 19 | j1 << 18 | u32::from(first & 0x3F) << 12 | low;
    let at = |offset: i64| pc.wrapping_add_signed(offset) & 0xFFFF_FFFF;
    match second & 0xD000 {
        0xD000 => Effect::Call(at(signed(far, 25))),
        0x9000 => Effect::Jump(at(signed(far, 25))),
        // B<c>.W T3; with conditions 14 and 15 these are MSR, barriers and hints.
        0x8000 if first >> 7 & 7 != 7 => Effect::Branch(at(signed(near, 21))),
        _ => Effect::Other(0xFF),
    }
}

fn below(register: u16, bytes: i64) -> Effect {
    if register == SP { Effect::Stack(bytes) } else { Effect::BelowStack(register as u8, bytes) }
}

/// Sign-extends so many bits.
fn signed(value: u32, bits: u32) -> i64 {
    i64::from((value << (32 - bits)).cast_signed() >> (32 - bits))
}

/// A constant of 12 bits as an instruction carries it: ThumbExpandImm (section A5.3.2).
fn expanded(plain: u32) -> u32 {
    let byte = plain & 0xFF;
    match plain >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte * 0x0101_0101,
        _ => (0x80 | plain & 0x7F).rotate_right(plain >> 7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Encodings as LLVM assembles them.
    #[test]
    fn what_moves_the_stack_pointer_says_by_how_much() {
        for (first, second, bytes) in [
            (0xB5F0, 0, 20),           // push {r4-r7, lr}
            (0xBCF0, 0, -16),          // pop {r4-r7}
            (0xB082, 0, 8),            // sub sp, #8
            (0xB002, 0, -8),           // add sp, #8
            (0xE92D, 0x4FF0, 36),      // push.w {r4-r11, lr}
            (0xF84D, 0xED08, 8),       // str lr, [sp, #-8]!
            (0xF85D, 0xEB08, -8),      // ldr lr, [sp], #8
            (0xED2D, 0x8B10, 64),      // vpush {d8-d15}
            (0xECBD, 0x8B10, -64),     // vpop {d8-d15}
            (0xF5AD, 0x5D80, 0x1000),  // sub.w sp, sp, #4096
            (0xF50D, 0x5D80, -0x1000), // add.w sp, sp, #4096
            (0xF6AD, 0x7D04, 3844),    // subw sp, sp, #3844
        ] {
            assert_eq!(decode(0, first, second).effect, Effect::Stack(bytes), "{first:04X} {second:04X}");
        }
        assert_eq!(decode(0, 0xEBAD, 0x0D0C).effect, Effect::StackBy(12));
        assert_eq!(decode(0, 0xF5AD, 0x5480).effect, Effect::BelowStack(4, 0x1000));
        assert_eq!(decode(0, 0x46A5, 0).effect, Effect::StackFrom(4));
    }

    #[test]
    fn what_comes_back_is_a_return() {
        for (first, second) in [(0xBDF0, 0), (0xE8BD, 0x8FF0), (0x4770, 0), (0xF85D, 0xFB08)] {
            assert_eq!(decode(0, first, second).effect, Effect::Return, "{first:04X} {second:04X}");
        }
    }

    #[test]
    fn constants_are_put_together() {
        assert_eq!(decode(0, 0xF241, 0x2C34).effect, Effect::Constant(12, 0x1234)); // movw r12, #0x1234
        assert_eq!(decode(0, 0xF6C0, 0x0C02).effect, Effect::Upper(12, 0x0802)); // movt r12, #0x802
        assert_eq!(decode(0, 0xF44F, 0x5380).effect, Effect::Constant(3, 0x1000)); // mov.w r3, #4096
        assert_eq!(decode(0x102, 0x4D02, 0).effect, Effect::Literal(5, 0x10C)); // ldr r5, [pc, #8]
        assert_eq!(decode(0x100, 0xF85F, 0x6040).effect, Effect::Literal(6, 0xC4)); // ldr.w r6, [pc, #-64]
        assert_eq!(decode(0x100, 0xF8DF, 0x6040).effect, Effect::Literal(6, 0x144)); // ldr.w r6, [pc, #64]
    }

    #[test]
    fn branches_say_where_to() {
        assert_eq!(decode(0, 0xF000, 0xF880).effect, Effect::Call(0x104)); // bl
        assert_eq!(decode(0x100, 0xF7FF, 0xBFFE).effect, Effect::Jump(0x100)); // b.w
        assert_eq!(decode(0x100, 0xF43F, 0xAFFE).effect, Effect::Branch(0x100)); // beq.w
        assert_eq!(decode(0x100, 0xE7FE, 0).effect, Effect::Jump(0x100)); // b
        assert_eq!(decode(0x100, 0xD0FE, 0).effect, Effect::Branch(0x100)); // beq
        assert_eq!(decode(0x100, 0xB108, 0).effect, Effect::Branch(0x106)); // cbz r0
        assert_eq!(decode(0, 0x4798, 0).effect, Effect::CallRegister(3)); // blx r3
        assert_eq!(decode(0, 0xE8DF, 0xF010).effect, Effect::Table); // tbh [pc, r0]
        // dmb sy and msr primask, r0.
        assert!(matches!(decode(0, 0xF3BF, 0x8F5F).effect, Effect::Other(_)));
        assert!(matches!(decode(0, 0xF380, 0x8810).effect, Effect::Other(_)));
    }

    #[test]
    fn what_is_written_is_known() {
        for (first, second, register) in [
            (0x4613, 0, 3),      // mov r3, r2
            (0x46C4, 0, 12),     // mov r12, r8
            (0x9E03, 0, 6),      // ldr r6, [sp, #12]
            (0x6823, 0, 3),      // ldr r3, [r4]
            (0x1C62, 0, 2),      // adds r2, r4, #1
            (0xF8D4, 0x9008, 9), // ldr.w r9, [r4, #8]
            (0xEB04, 0x0805, 8), // add.w r8, r4, r5
            (0xE9D4, 0x6702, 6), // ldrd r6, r7, [r4, #8]
            (0xE9D4, 0x6702, 7),
        ] {
            let Effect::Other(written) = decode(0, first, second).effect else { panic!("{first:04X} {second:04X}") };
            assert!(written >> register & 1 == 1, "{first:04X} {second:04X}: {written:04X}");
        }
    }
}
