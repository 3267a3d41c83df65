//! BTT SKR Pro v1.2: STM32F407ZG, six driver sockets, crystal 8 MHz.
//!
//! Read from two independent public pin maps; check against the schematic before power is applied. The bootloader
//! fills the first 32 KiB of flash and starts the image at 0x08008000.

use super::stm32f407::pins::{BoardPins, MotorPins, Pin, Port};

const fn motor(step: Pin, direction: Pin, enable: Pin, end_stop: Pin) -> MotorPins {
    MotorPins {
        step,
        direction,
        enable,
        end_stop,
    }
}

const fn pin(port: Port, number: u8) -> Pin {
    Pin::new(port, number)
}

use Port::{A, B, C, D, E, F, G};

pub const BOARD: BoardPins<6> = BoardPins {
    name: "BTT SKR Pro v1.2",
    crystal_hz: 8_000_000,
    motors: [
        //    step         direction   enable     end stop       socket
        motor(pin(E, 9), pin(F, 1), pin(F, 2), pin(B, 10)), // X
        motor(pin(E, 11), pin(E, 8), pin(D, 7), pin(E, 12)), // Y
        motor(pin(E, 13), pin(C, 2), pin(C, 0), pin(G, 8)), // Z
        motor(pin(E, 14), pin(A, 0), pin(C, 3), pin(E, 15)), // E0
        motor(pin(D, 15), pin(E, 7), pin(A, 3), pin(E, 10)), // E1
        motor(pin(D, 13), pin(G, 9), pin(F, 0), pin(G, 5)), // E2
    ],
    serial_transmit: pin(A, 9),
    serial_receive: pin(A, 10),
    // In no use on the board according to its pin maps.
    log_transmit: pin(D, 5),
};
