//! Every message of the protocol that this board knows: the one table that dictionary, parser and answers are
//! made from.
//!
//! A host compares whole formats, so a parameter's name or width must be Klipper's own (Klipper,
//! `docs/MCU_Commands.md`, and the formats in its `src`, as facts). Widths do not change the encoding.
//!
//! The build script includes this file as well, to make the dictionary.

macro_rules! messages {
    ($(#[$meta:meta])* $name:ident { $($variant:ident = $format:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        #[allow(missing_docs, reason = "the formats say it")]
        pub enum $name {
            $($variant),*
        }

        impl $name {
            /// All messages, in the order of their numbers.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// Returns name and parameters as the dictionary has them.
            #[must_use]
            pub const fn format(self) -> &'static str {
                match self {
                    $(Self::$variant => $format),*
                }
            }
        }
    };
}

messages! {
    /// Message of the host.
    Command {
        Identify = "identify offset=%u count=%c",
        GetUptime = "get_uptime",
        GetClock = "get_clock",
        GetConfig = "get_config",
        AllocateOids = "allocate_oids count=%c",
        FinalizeConfig = "finalize_config crc=%u",
        EmergencyStop = "emergency_stop",
        ClearShutdown = "clear_shutdown",
        Reset = "reset",
        DebugNop = "debug_nop",
        DebugPing = "debug_ping data=%*s",
        DebugRead = "debug_read order=%c addr=%u",
        ConfigDigitalOut = "config_digital_out oid=%c pin=%u value=%c default_value=%c max_duration=%u",
        SetDigitalOutPwmCycle = "set_digital_out_pwm_cycle oid=%c cycle_ticks=%u",
        QueueDigitalOut = "queue_digital_out oid=%c clock=%u on_ticks=%u",
        UpdateDigitalOut = "update_digital_out oid=%c value=%c",
        SetDigitalOut = "set_digital_out pin=%u value=%c",
        ConfigPwmOut = "config_pwm_out oid=%c pin=%u cycle_ticks=%u value=%hu default_value=%hu max_duration=%u",
        QueuePwmOut = "queue_pwm_out oid=%c clock=%u value=%hu",
        SetPwmOut = "set_pwm_out pin=%u cycle_ticks=%u value=%hu",
        ConfigAnalogIn = "config_analog_in oid=%c pin=%u",
        QueryAnalogIn = "query_analog_in oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u bytes_per_report=%c min_value=%hu max_value=%hu range_check_count=%c",
        ConfigStepper = "config_stepper oid=%c step_pin=%c dir_pin=%c invert_step=%c step_pulse_ticks=%u",
        QueueStep = "queue_step oid=%c interval=%u count=%hu add=%hi",
        SetNextStepDir = "set_next_step_dir oid=%c dir=%c",
        ResetStepClock = "reset_step_clock oid=%c clock=%u",
        StepperGetPosition = "stepper_get_position oid=%c",
        StepperStopOnTrigger = "stepper_stop_on_trigger oid=%c trsync_oid=%c",
        ConfigEndstop = "config_endstop oid=%c pin=%c pull_up=%c",
        EndstopHome = "endstop_home oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u pin_value=%c trsync_oid=%c trigger_reason=%c",
        EndstopQueryState = "endstop_query_state oid=%c",
        ConfigTrsync = "config_trsync oid=%c",
        TrsyncStart = "trsync_start oid=%c report_clock=%u report_ticks=%u expire_reason=%c",
        TrsyncSetTimeout = "trsync_set_timeout oid=%c clock=%u",
        TrsyncTrigger = "trsync_trigger oid=%c reason=%c",
        ConfigSpi = "config_spi oid=%c pin=%u cs_active_high=%c",
        ConfigSpiWithoutCs = "config_spi_without_cs oid=%c",
        SpiSetBus = "spi_set_bus oid=%c spi_bus=%u mode=%u rate=%u",
        SpiTransfer = "spi_transfer oid=%c data=%*s",
        SpiSend = "spi_send oid=%c data=%*s",
        ConfigSpiShutdown = "config_spi_shutdown oid=%c spi_oid=%c shutdown_msg=%*s",
        SpiSetSwBus = "spi_set_sw_bus oid=%c miso_pin=%u mosi_pin=%u sclk_pin=%u mode=%u pulse_ticks=%u",
        ConfigI2c = "config_i2c oid=%c",
        I2cSetSwBus = "i2c_set_sw_bus oid=%c scl_pin=%u sda_pin=%u pulse_ticks=%u address=%u",
        I2cTransfer = "i2c_transfer oid=%c write=%*s read_len=%u",
        ConfigTmcuart = "config_tmcuart oid=%c rx_pin=%u pull_up=%c tx_pin=%u bit_time=%u",
        TmcuartSend = "tmcuart_send oid=%c write=%*s read=%c",
        ConfigNeopixel = "config_neopixel oid=%c pin=%u data_size=%hu bit_max_ticks=%u reset_min_ticks=%u",
        NeopixelUpdate = "neopixel_update oid=%c pos=%hu data=%*s",
        NeopixelSend = "neopixel_send oid=%c",
        ConfigAdxl345 = "config_adxl345 oid=%c spi_oid=%c",
        QueryAdxl345 = "query_adxl345 oid=%c rest_ticks=%u",
        QueryAdxl345Status = "query_adxl345_status oid=%c",
        ConfigButtons = "config_buttons oid=%c button_count=%c",
        ButtonsAdd = "buttons_add oid=%c pos=%c pin=%u pull_up=%c",
        ButtonsQuery = "buttons_query oid=%c clock=%u rest_ticks=%u retransmit_count=%c invert=%c",
        ButtonsAck = "buttons_ack oid=%c count=%c",
        ConfigCounter = "config_counter oid=%c pin=%u pull_up=%c",
        QueryCounter = "query_counter oid=%c clock=%u poll_ticks=%u sample_ticks=%u",
    }
}

messages! {
    /// Message of the board.
    Response {
        Identified = "identify_response offset=%u data=%.*s",
        Uptime = "uptime high=%u clock=%u",
        Clock = "clock clock=%u",
        Config = "config is_config=%c crc=%u is_shutdown=%c move_count=%hu",
        Starting = "starting",
        Stats = "stats count=%u sum=%u sumsq=%u",
        Shutdown = "shutdown clock=%u static_string_id=%hu",
        IsShutdown = "is_shutdown static_string_id=%hu",
        Pong = "pong data=%*s",
        DebugResult = "debug_result val=%u",
        AnalogInState = "analog_in_state oid=%c next_clock=%u values=%*s",
        StepperPosition = "stepper_position oid=%c pos=%i",
        EndstopState = "endstop_state oid=%c homing=%c next_clock=%u pin_value=%c",
        TrsyncState = "trsync_state oid=%c can_trigger=%c trigger_reason=%c clock=%u",
        SpiTransferred = "spi_transfer_response oid=%c response=%*s",
        I2cOutcome = "i2c_response oid=%c i2c_bus_status=%c response=%*s",
        TmcuartAnswer = "tmcuart_response oid=%c read=%*s",
        NeopixelResult = "neopixel_result oid=%c success=%c",
        SensorBulkData = "sensor_bulk_data oid=%c sequence=%hu data=%*s",
        SensorBulkStatus = "sensor_bulk_status oid=%c clock=%u query_ticks=%u next_sequence=%hu buffered=%u possible_overflows=%hu",
        ButtonsState = "buttons_state oid=%c ack_count=%c state=%*s",
        CounterState = "counter_state oid=%c next_clock=%u count=%u count_clock=%u",
    }
}

impl Command {
    /// Number on the wire: `identify` is 1, as every host knows, and the others follow.
    #[must_use]
    pub const fn number(self) -> i32 {
        self as i32 + 1
    }

    /// Returns the command of a number.
    #[must_use]
    pub fn of(number: u32) -> Option<Self> {
        Self::ALL.get((number as usize).wrapping_sub(1)).copied()
    }
}

impl Response {
    /// Number on the wire: `identify_response` is 0, as every host knows, and the others go down from there,
    /// so that each takes one byte.
    #[must_use]
    pub const fn number(self) -> i32 {
        -(self as i32)
    }
}

// Each number takes one byte, which holds -32 to 95.
const _: () = assert!(Command::ALL.len() <= 95 && Response::ALL.len() <= 33);

/// Parameters of a command: how many there are, and which one is a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Number of parameters, the buffer among them.
    pub count: u8,
    /// Place of the buffer among them; beyond the count when there is none.
    pub buffer: u8,
}

impl Shape {
    /// Reads a format: each `%` begins a parameter, and `%*s` or `%.*s` is a buffer.
    #[must_use]
    pub const fn of(format: &str) -> Self {
        let bytes = format.as_bytes();
        let mut shape = Self { count: 0, buffer: u8::MAX };
        let mut at = 0;
        while at < bytes.len() {
            if bytes[at] == b'%' {
                if bytes[at + 1] == b'*' || bytes[at + 1] == b'.' {
                    shape.buffer = shape.count;
                }
                shape.count += 1;
            }
            at += 1;
        }
        shape
    }
}
