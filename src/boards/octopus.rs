//! BTT Octopus v1.1: eight driver sockets, for a two-sided machine, with an STM32F407ZG.
//!
//! The Octopus is sold with three chips. This file is for the sister board with the STM32F407ZG, the chip whose start-up
//! code is in `stm32f407/`; the pins are the same on all of them, and nobody has tried the image on an STM32F446 or F429.
//! Look at the crystal: it is 12 MHz beside an STM32F446 and 8 MHz beside an F429. With another one than is stated here
//! the core clock, and with it every time and the serial line's speed, is off by the ratio of the two.
//!
//! Motor 7's direction is SWCLK (PA14): once the firmware runs, a debug probe gets through only while reset is held.
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

use Port::{A, C, D, E, F, G};

pub const BOARD: BoardPins<8> = BoardPins {
    name: "BTT Octopus v1.1",
    crystal_hz: 12_000_000,
    motors: [
        //    step         direction    enable      end stop        socket, joint of a two-sided machine
        motor(pin(F, 13), pin(F, 12), pin(F, 14), pin(G, 6)), // MOTOR0, X1
        motor(pin(G, 0), pin(G, 1), pin(F, 15), pin(G, 9)),   // MOTOR1, Y1
        motor(pin(F, 11), pin(G, 3), pin(G, 5), pin(G, 10)),  // MOTOR2, Z1
        motor(pin(G, 4), pin(C, 1), pin(A, 0), pin(G, 11)),   // MOTOR3, B1
        motor(pin(F, 9), pin(F, 10), pin(G, 2), pin(G, 12)),  // MOTOR4, X2
        motor(pin(C, 13), pin(F, 0), pin(F, 1), pin(G, 13)),  // MOTOR5, Y2
        motor(pin(E, 2), pin(E, 3), pin(D, 4), pin(G, 14)),   // MOTOR6, Z2
        motor(pin(E, 6), pin(A, 14), pin(E, 0), pin(G, 15)),  // MOTOR7, B2
    ],
    serial_transmit: pin(A, 9),
    serial_receive: pin(A, 10),
    // On the header for a single-board computer.
    log_transmit: pin(D, 5),
};
