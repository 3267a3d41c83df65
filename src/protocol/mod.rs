//! Bytes -> lines, and answers back: the Grbl 1.1 way of speaking, as far as it is needed here.
//!
//! | byte or line | effect | answer |
//! |---|---|---|
//! | `?` | | `<State\|MPos:d1,d2,d3,t1,t2,t3\|...>` (mm, deg), any time, even inside a line |
//! | `!` | feed hold: slows down on the path and waits there; a jog is dropped | |
//! | `~` | goes on after a hold; starts a stream that waits for more | |
//! | 0x85 | drops a jog within its braking distance | |
//! | 0x90, 0x91 0x92, 0x93 0x94 | feed override 100 %, +10 -10, +1 -1 (10 to 200) | |
//! | 0x95 0x96 0x97 | rapid override 100, 50, 25 % | |
//! | 0xA8 0xA9, 0xAA 0xAB | trim of the selected motor +1 -1, +10 -10 um or 0.001 deg | `[MSG:Trim Z 0.0030]` |
//! | 0xAC 0xAD | selects the next, the previous motor for that | `[MSG:Trim ...]` |
//! | 0xAE, 0xAF | all trims stay where they are, go to zero; a stream of readings ends | `[MSG:Trim ...]` |
//! | 0xA6, 8 of 0xB8 to 0xBF | a sensor's reading, see [`reading`] | |
//! | 0x18 | motion stops at the next tick, everything queued is dropped; at rest, in a hold too, the position is kept | `ALARM:3` if it moved; banner |
//! | `$` | | `[HLP:...]`, `ok` |
//! | `$$` | | `$n=value` for each setting, `ok` |
//! | `$n=value` | stores a setting (in memory; nothing outlives a restart yet) | `ok` |
//! | `$I` | | `[VER:...]`, `[OPT:...]`, `[AXS:...]`, `ok` |
//! | `$X` | leaves the alarm state | `ok` |
//! | `$STAT` | | `[MSG:...]` with the counters that must be 0, `ok` |
//! | `$SEG=c0,c1,c2,c3,c4,c5,t` | a signed step count for each motor, six or eight, in t seconds from rest to rest; `,CENTRED` or `,PUBLISHED` may follow | `ok` once queued |
//! | `$MOVE=s0,s1,s2,s3,s4,s5,t` | next target of a joint path [steps, up to nine digits behind the point], no sooner than t seconds after the one before; without t, or with 0, a rapid: as fast as the motors may, its corners with other rapids within `$1005`, but for the one right behind a move with a time | `ok` once queued |
//! | `$MOVE=END` | the path is complete; it starts then, when the look-ahead is full, or on `~` | `ok` |
//! | `$CUE=ms,action` | at this millisecond of the next motion: `HOLD`, `RESUME`, `STOP`, `FEED,percent`, `RAPID,percent`, `TRIM,motor,steps` | `ok` |
//! | `$TRIM=<axis><value>` | offset of a motor [mm, deg], reached at its own rate while programs run, within `$1030`, and `$1013` of its limits | `ok` |
//! | `$TRIM=0` | all offsets go to zero, a stream of readings ends | `ok` |
//! | `$TRIM` | | `[TRIM:x,y,...]`, `ok` |
//! | `$TRIM=ON,period,tau,amount,rate,gate,misses` | two-sided machine: readings trim both sides, every `period` ms; s, mm, mm/s, mm; more misses in a row than that: feed hold | `ok` |
//! | `$TRIM=OFF` | readings trim no more, offsets stay | `ok` |
//! | `$DRILL` | | `[DRILL:D..,W..,...]`, `ok` |
//! | `$DRILL=D..,W..,...` | sets drill parameters, all or nothing | `ok` |
//! | `$DRILL=RUN` | checks the whole cycle against the travel, then grinds | `ok` when accepted |
//! | `$DRILL=SIM` | checks it and no more | `[MSG:Simulated: ...]`, `ok` |
//! | `$KIN`, `$KIN=name`, `$KIN.par=v,...` | shows, chooses, sets the machine of a process | `[KIN:...]`, `ok` |
//! | `$PRECESS`, `$SURF`, `$MIRROR`, `=words`, `=RUN`, `=SIM`, `=STOP` | a process: shows, sets, begins, looks only, stops | `[name:...]`, `ok` |
//! | `$POINT=x,y,z,i,j,k,...`, `=ROW`, `=END` | a point of the process; see [`processes`](crate::program::processes) | `ok` when all of it can be run |
//! | empty line | | `ok` |
//!
//! Every line gets exactly one `ok` or `error:n`. A refused one is explained before that in `[MSG:name field: what was
//! expected]`, and has changed nothing.

pub mod cue;
pub mod line;
pub mod reading;
pub mod receiver;
pub mod report;
pub mod system;

pub use line::{Line, LineReader};
pub use receiver::{ByteQueue, RealTime, Receiver};
