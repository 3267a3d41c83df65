//! `cases/duel/peers.csv` -> what other controllers did on the same paths.

/// One of them on one path.
#[derive(Clone, Debug)]
pub struct Peer {
    pub contest: &'static str,
    /// `grblHAL-trap`, `klipper`, ...
    pub name: &'static str,
    /// Steps per mm; `None` where its planner alone was asked.
    pub steps: Option<f64>,
    /// Time [s], largest speed, acceleration and jerk [mm, s], distance and cut [um], ripple [%] where there is one.
    pub time: f64,
    pub velocity: f64,
    pub acceleration: f64,
    pub jerk: f64,
    pub aside: f64,
    pub cut: f64,
    pub ripple: Option<f64>,
}

/// What was compared with what.
pub const REVISIONS: &str =
    "grblHAL core f80fc34, Klipper 84104bb, LinuxCNC 5c41560 (its planner alone)";

const TABLE: &str = include_str!("../../cases/duel/peers.csv");

/// All rows of the table; a row that cannot be read is not there, and a test counts them.
pub fn peers() -> Vec<Peer> {
    TABLE.lines().filter_map(row).collect()
}

fn row(line: &'static str) -> Option<Peer> {
    let cells: Vec<&str> = line.split(',').collect();
    let [contest, name, steps, time, v, a, j, aside, cut, ripple] = cells[..] else {
        return None;
    };
    Some(Peer {
        contest,
        name,
        steps: steps.parse().ok(),
        time: time.parse().ok()?,
        velocity: v.parse().ok()?,
        acceleration: a.parse().ok()?,
        jerk: j.parse().ok()?,
        aside: aside.parse().ok()?,
        cut: cut.parse().ok()?,
        ripple: ripple.parse().ok(),
    })
}
