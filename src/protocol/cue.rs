//! What an operator would do, at a given millisecond of the next motion: holds, overrides and trims that come at the
//! same sample on every machine, for rehearsals and for tests.

use heapless::Deque;

/// Cues that can wait.
pub const CUES: usize = 16;

/// One thing that an operator can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    Hold,
    Resume,
    /// Feed override, 0.1 ..= 2.
    Feed(f32),
    /// Rapid override, 0.05 ..= 1.
    Rapid(f32),
    /// Offset of a motor [steps].
    Trim {
        motor: usize,
        steps: i32,
    },
    /// Controlled stop: the rest of the motion is dropped.
    Stop,
}

/// An action, and how many milliseconds of the motion come before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cue {
    pub at: u32,
    pub action: Action,
}

/// Why a cue was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CueError {
    /// [`CUES`] wait already.
    Full,
    /// Earlier than the cue before.
    Order,
    /// Outside the action's range.
    Range,
}

/// The cues to come for N motors, by time.
#[derive(Debug, Default)]
pub struct Cues<const N: usize> {
    waiting: Deque<Cue, CUES>,
    /// Milliseconds of motion so far.
    elapsed: u32,
}

impl<const N: usize> Cues<N> {
    pub const fn new() -> Self {
        Self {
            waiting: Deque::new(),
            elapsed: 0,
        }
    }

    pub fn add(&mut self, cue: Cue) -> Result<(), CueError> {
        let fits = match cue.action {
            Action::Feed(factor) => (0.1..=2.0).contains(&factor),
            Action::Rapid(factor) => (0.05..=1.0).contains(&factor),
            Action::Trim { motor, .. } => motor < N,
            Action::Hold | Action::Resume | Action::Stop => true,
        };
        if !fits {
            return Err(CueError::Range);
        }
        if self.waiting.back().is_some_and(|last| last.at > cue.at) {
            return Err(CueError::Order);
        }
        self.waiting.push_back(cue).map_err(|_| CueError::Full)
    }

    /// The next action that is due before the next sample.
    pub fn due(&mut self) -> Option<Action> {
        let due = self
            .waiting
            .front()
            .is_some_and(|cue| cue.at <= self.elapsed);
        if due {
            self.waiting.pop_front().map(|cue| cue.action)
        } else {
            None
        }
    }

    /// A sample has been taken.
    pub fn tick(&mut self) {
        self.elapsed = self.elapsed.wrapping_add(1);
    }

    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Whether time runs.
    pub fn has_begun(&self) -> bool {
        self.elapsed > 0
    }

    /// The motion is over: time begins anew with the next, and what has not come does not come.
    pub fn clear(&mut self) {
        self.waiting.clear();
        self.elapsed = 0;
    }
}
