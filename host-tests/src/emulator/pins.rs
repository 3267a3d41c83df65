//! Stores to GPIO -> what the step and direction pins did, tick by tick.
//!
//! A tick begins with the store that writes all step pins of the first step port: only the step interrupt does that,
//! once a tick. What counts is the state of the pins at the end of each tick.

use super::counter::{Cost, Counter, Tally};
use crate::trace::{self, Trace};
use std::ops::Range;

/// A pin as its port's letter and its number there, e.g. `('E', 9)`.
pub type Pin = (char, u8);

/// Most motors a board has.
pub const MOTORS: usize = 8;

/// Which pins are whose. Written down here once more, from the board's documents and not from the firmware.
#[derive(Clone, Copy, Debug)]
pub struct PinMap {
    pub step: &'static [Pin],
    pub direction: &'static [Pin],
    /// Active low.
    pub enable: &'static [Pin],
}

/// BTT SKR Pro v1.2, sockets X Y Z E0 E1 E2.
pub const SKR_PRO: PinMap = PinMap {
    step: &[
        ('E', 9),
        ('E', 11),
        ('E', 13),
        ('E', 14),
        ('D', 15),
        ('D', 13),
    ],
    direction: &[('F', 1), ('E', 8), ('C', 2), ('A', 0), ('E', 7), ('G', 9)],
    enable: &[('F', 2), ('D', 7), ('C', 0), ('C', 3), ('A', 3), ('F', 0)],
};

/// BTT Octopus v1.1, sockets MOTOR0 to MOTOR7.
pub const OCTOPUS: PinMap = PinMap {
    step: &[
        ('F', 13),
        ('G', 0),
        ('F', 11),
        ('G', 4),
        ('F', 9),
        ('C', 13),
        ('E', 2),
        ('E', 6),
    ],
    direction: &[
        ('F', 12),
        ('G', 1),
        ('G', 3),
        ('C', 1),
        ('F', 10),
        ('F', 0),
        ('E', 3),
        ('A', 14),
    ],
    enable: &[
        ('F', 14),
        ('F', 15),
        ('G', 5),
        ('A', 0),
        ('G', 2),
        ('F', 1),
        ('D', 4),
        ('E', 0),
    ],
};

/// State of all pins at the end of a tick in which one of them changed. Bit i is motor i.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// Number of the tick, from the start of the recording.
    pub tick: u64,
    /// Levels of the step pins.
    pub levels: u8,
    /// Levels of the direction pins.
    pub directions: u8,
    /// Drivers that are switched on.
    pub enabled: u8,
}

const PORTS: usize = 9;
/// Offset of the set/reset register in a GPIO block.
const SET_RESET: u32 = 0x18;

/// What the pins did, and what the watched functions cost.
#[derive(Clone, Debug)]
pub struct Recording {
    pins: PinMap,
    /// Step pins on each port.
    step_masks: [u16; PORTS],
    /// The port whose store begins a tick.
    first_port: usize,
    levels: [u16; PORTS],
    /// The pins when the recording began, and as last recorded.
    start: Change,
    last: Change,
    tick: u64,
    /// Stores to step pins in the tick under way, and the most there were in one tick on one port.
    stores: [u32; PORTS],
    most_stores: u32,
    changes: Vec<Change>,
    /// Cost of the step interrupt in each tick.
    costs: Vec<Cost>,
    tallies: Vec<Tally>,
    /// Ticks in which calls of the watched functions have ended; none for the step interrupt, which has one in each.
    ends: Vec<Vec<u64>>,
}

impl Recording {
    pub(super) fn new(pins: PinMap) -> Self {
        let mut step_masks = [0; PORTS];
        for &(port, number) in pins.step {
            if let Some(mask) = step_masks.get_mut(index(port)) {
                *mask |= 1 << number;
            }
        }
        let first_port = pins.step.first().map_or(0, |&(port, _)| index(port));
        Self {
            pins,
            step_masks,
            first_port,
            levels: [0; PORTS],
            start: Change::default(),
            last: Change::default(),
            tick: 0,
            stores: [0; PORTS],
            most_stores: 0,
            changes: Vec::new(),
            costs: Vec::new(),
            tallies: Vec::new(),
            ends: Vec::new(),
        }
    }

    pub(super) fn watch(&mut self, counter: Option<&Counter>) {
        let watched = counter.map_or(0, |counter| counter.functions.len());
        self.tallies = vec![Tally::default(); watched];
        self.ends = vec![Vec::new(); watched];
    }

    /// Ticks so far.
    pub fn ticks(&self) -> u64 {
        self.tick
    }

    /// All changes in order.
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// The most stores to one port's step pins in one tick; 1 if all motors of a port always changed together.
    pub fn most_stores_in_a_tick(&self) -> u32 {
        self.most_stores
    }

    /// Ticks from the first change of a step pin to the last one, that one included; empty if nothing stepped.
    pub fn motion(&self) -> Range<u64> {
        let mut levels = self.start.levels;
        let mut range = 0..0;
        for change in &self.changes {
            if change.levels != levels {
                if range.is_empty() {
                    range.start = change.tick;
                }
                range.end = change.tick + 1;
            }
            levels = change.levels;
        }
        range
    }

    /// The pulses, to be compared with others.
    pub fn pulses(&self) -> Pulses {
        Pulses::new(self.start, self.changes.iter().copied())
    }

    /// What the step interrupt cost in each tick of `ticks`; needs the counter.
    pub fn costs(&self, ticks: Range<u64>) -> &[Cost] {
        let end = (ticks.end as usize).min(self.costs.len());
        let start = (ticks.start as usize).min(end);
        self.costs.get(start..end).unwrap_or(&[])
    }

    /// What each call of watched function `function` has cost.
    pub fn tally(&self, function: usize) -> Tally {
        self.tallies.get(function).copied().unwrap_or_default()
    }

    /// Ticks in which the calls of watched function `function` have ended, in order: each call ended after the stores of
    /// its tick and before those of the next. None for the step interrupt.
    pub fn ends(&self, function: usize) -> &[u64] {
        self.ends.get(function).map_or(&[], Vec::as_slice)
    }

    /// Steps of each motor from start to end, forward positive; `both_edges` counts falling edges as steps too.
    pub fn positions(&self, both_edges: bool) -> [i64; MOTORS] {
        let mut positions = [0; MOTORS];
        let mut before = self.start.levels;
        for change in &self.changes {
            let mut stepping = change.levels & !before;
            if both_edges {
                stepping = change.levels ^ before;
            }
            before = change.levels;
            for (motor, position) in positions.iter_mut().enumerate() {
                if stepping >> motor & 1 != 0 {
                    *position += if change.directions >> motor & 1 == 0 {
                        1
                    } else {
                        -1
                    };
                }
            }
        }
        positions
    }

    /// Takes everything so far out; the recording goes on at tick 0 with the pins as they are.
    pub(super) fn take(&mut self) -> Self {
        self.end_tick();
        let mut next = self.clone_without_history();
        std::mem::swap(self, &mut next);
        next
    }

    fn clone_without_history(&self) -> Self {
        Self {
            tick: 0,
            start: Change {
                tick: 0,
                ..self.last
            },
            last: Change {
                tick: 0,
                ..self.last
            },
            most_stores: 0,
            changes: Vec::new(),
            costs: Vec::new(),
            tallies: vec![Tally::default(); self.tallies.len()],
            ends: vec![Vec::new(); self.ends.len()],
            ..*self
        }
    }

    /// Takes in one line of QEMU's log; `false` if it is neither a store nor a count.
    pub(super) fn read_line(&mut self, line: &[u8]) -> bool {
        if let Some(rest) = line.strip_prefix(b"GPIO") {
            if let (Some(&port), Some((SET_RESET, value))) = (rest.first(), store(rest)) {
                self.store(index(port as char), value);
            }
            return true;
        }
        if let Some(rest) = line.strip_prefix(b"cost ") {
            self.count(rest);
            return true;
        }
        line.windows(UNIMPLEMENTED.len())
            .any(|part| part == UNIMPLEMENTED)
    }

    fn store(&mut self, port: usize, value: u32) {
        let (set, reset) = (value as u16, (value >> 16) as u16);
        let step_mask = self.step_masks.get(port).copied().unwrap_or(0);
        if step_mask != 0 && (set | reset) & step_mask == step_mask {
            if port == self.first_port {
                self.end_tick();
                self.tick += 1;
                self.stores = [0; PORTS];
            }
            if let Some(stores) = self.stores.get_mut(port) {
                *stores += 1;
                self.most_stores = self.most_stores.max(*stores);
            }
        }
        if let Some(levels) = self.levels.get_mut(port) {
            // The chip lets set win over reset.
            *levels = *levels & !reset | set;
        }
    }

    fn end_tick(&mut self) {
        let now = Change {
            tick: self.tick,
            levels: self.gather(self.pins.step),
            directions: self.gather(self.pins.direction),
            enabled: !self.gather(self.pins.enable) & ((1u16 << self.pins.enable.len()) - 1) as u8,
        };
        if (Change {
            tick: self.last.tick,
            ..now
        }) != self.last
        {
            self.changes.push(now);
            self.last = now;
        }
    }

    /// Levels of `pins`, the first in bit 0.
    fn gather(&self, pins: &[Pin]) -> u8 {
        pins.iter()
            .enumerate()
            .fold(0, |mask, (i, &(port, number))| {
                let levels = self.levels.get(index(port)).copied().unwrap_or(0);
                mask | ((levels >> number & 1) as u8) << i
            })
    }

    /// `<function> <instructions> <cycles>`.
    fn count(&mut self, text: &[u8]) {
        let mut numbers = text.split(|byte| *byte == b' ').map(decimal);
        let (Some(function), Some(instructions), Some(cycles)) =
            (numbers.next(), numbers.next(), numbers.next())
        else {
            return;
        };
        let cost = Cost {
            instructions: instructions as u32,
            cycles: cycles as u32,
        };
        if function == 0 {
            self.costs.resize(self.tick as usize + 1, Cost::default());
            if let Some(last) = self.costs.last_mut() {
                *last = cost;
            }
        } else if let Some(ends) = self.ends.get_mut(function as usize) {
            ends.push(self.tick);
        }
        if let Some(tally) = self.tallies.get_mut(function as usize) {
            tally.add(cost);
        }
    }
}

const UNIMPLEMENTED: &[u8] = b"unimplemented device";

fn index(port: char) -> usize {
    (port as usize).wrapping_sub('A' as usize)
}

/// Offset and value of a logged store, `... write (size 4, offset 0x018, value 0x02000000)`; `None` for a load.
fn store(line: &[u8]) -> Option<(u32, u32)> {
    let mut numbers = line.split(|byte| *byte == b'x').skip(1).map(hexadecimal);
    let offset = numbers.next()?;
    Some((offset, numbers.next()?))
}

/// The number at the start of `text`.
fn hexadecimal(text: &[u8]) -> u32 {
    text.iter()
        .map_while(|byte| (*byte as char).to_digit(16))
        .fold(0, |number, digit| number << 4 | digit)
}

fn decimal(text: &[u8]) -> u64 {
    text.iter()
        .map_while(|byte| (*byte as char).to_digit(10))
        .fold(0, |number, digit| {
            number.wrapping_mul(10).wrapping_add(digit.into())
        })
}

/// Every change of step and direction pins from the first step on, ticks counted from there. Two runs are equal tick
/// for tick if these are equal; how long a machine rested before cannot matter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pulses(Vec<Pulse>);

/// The pins at the end of a tick in which one of them changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pulse {
    /// Ticks since the first step.
    pub tick: u64,
    pub levels: u8,
    pub directions: u8,
}

impl Pulses {
    fn new(start: Change, changes: impl Iterator<Item = Change>) -> Self {
        let mut pulses = Vec::new();
        let mut first = None;
        let mut before = (start.levels, start.directions);
        for change in changes {
            if first.is_none() && change.levels != before.0 {
                first = Some(change.tick);
            }
            let now = (change.levels, change.directions);
            if let (Some(first), true) = (first, now != before) {
                pulses.push(Pulse {
                    tick: change.tick - first,
                    levels: now.0,
                    directions: now.1,
                });
            }
            before = now;
        }
        Self(pulses)
    }

    /// The pulses that a machine in memory has made.
    pub fn of_trace<const N: usize>(trace: &Trace<N>) -> Self {
        let mut now = Change::default();
        let mut start = now;
        let mut changes: Vec<Change> = Vec::new();
        for event in trace.events() {
            now.tick = event.tick;
            match event.change {
                trace::Change::Levels(levels) => now.levels = levels,
                trace::Change::Directions(directions) => now.directions = directions,
                trace::Change::Enable(_) => {}
            }
            // Tick 0 is how the pins stood before.
            if event.tick == 0 {
                start = now;
                continue;
            }
            match changes.last_mut() {
                Some(last) if last.tick == now.tick => *last = now,
                _ => changes.push(now),
            }
        }
        Self::new(start, changes.into_iter())
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All of them in order.
    pub fn iter(&self) -> impl Iterator<Item = &Pulse> {
        self.0.iter()
    }

    /// Where the two part, with what each shows there; `None` if they are equal.
    pub fn first_difference(&self, other: &Self) -> Option<(usize, Option<Pulse>, Option<Pulse>)> {
        let longest = self.0.len().max(other.0.len());
        (0..longest)
            .map(|i| (i, self.0.get(i).copied(), other.0.get(i).copied()))
            .find(|(_, ours, theirs)| ours != theirs)
    }
}
