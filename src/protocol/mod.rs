//! Bytes -> lines, and answers back: the Grbl 1.1 way of speaking, as far as it is needed here.
//!
//! | byte or line | effect | answer |
//! |---|---|---|
//! | `?` | | `<State\|MPos:d1,d2,d3,t1,t2,t3\|...>` (mm, deg), any time, even inside a line |
//! | 0x18 | motion stops at the next tick, everything queued is dropped | `ALARM:3` if it moved; banner |
//! | `$` | | `[HLP:...]`, `ok` |
//! | `$$` | | `$n=value` for each setting, `ok` |
//! | `$n=value` | stores a setting (in memory; nothing outlives a restart yet) | `ok` |
//! | `$I` | | `[VER:...]`, `[OPT:...]`, `[AXS:...]`, `ok` |
//! | `$X` | leaves the alarm state | `ok` |
//! | `$STAT` | | `[MSG:...]` with the counters that must be 0, `ok` |
//! | `$SEG=c0,c1,c2,c3,c4,c5,t` | six signed step counts in t seconds from rest to rest; `,CENTRED` or `,PUBLISHED` may follow | `ok` once queued |
//! | `$DRILL` | | `[DRILL:D..,W..,...]`, `ok` |
//! | `$DRILL=D..,W..,...` | sets drill parameters, all or nothing | `ok` |
//! | `$DRILL=RUN` | checks the whole cycle against the travel, then grinds | `ok` when accepted |
//! | empty line | | `ok` |
//!
//! Every line gets exactly one `ok` or `error:n`. A refused one is explained before that in `[MSG:name field: what was
//! expected]`, and has changed nothing.

pub mod line;
pub mod receiver;
pub mod report;
pub mod system;

pub use line::{Line, LineReader};
pub use receiver::{ByteQueue, RealTime, Receiver};
