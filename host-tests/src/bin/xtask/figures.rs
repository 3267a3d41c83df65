//! The project's figures: name, unit, goal; the table and the file they are printed to.
//!
//! A new figure is one row of [`FIGURES`] and one `measured.set` where it is measured.

use super::run::Outcome;
use std::collections::BTreeMap;
use std::path::Path;

/// One figure to reach.
pub struct Figure {
    /// Name in `bench.json`.
    pub key: &'static str,
    pub unit: &'static str,
    pub goal: Goal,
    /// What it says, in one line.
    pub what: &'static str,
}

#[derive(Clone, Copy)]
pub enum Goal {
    None,
    AtMost(f64),
    AtLeast(f64),
}

impl Goal {
    fn is_met(self, value: f64) -> bool {
        match self {
            Goal::None => true,
            Goal::AtMost(goal) => value <= goal,
            Goal::AtLeast(goal) => value >= goal,
        }
    }
}

const fn figure(key: &'static str, unit: &'static str, goal: Goal, what: &'static str) -> Figure {
    Figure {
        key,
        unit,
        goal,
        what,
    }
}

use Goal::{AtLeast, AtMost, None};

/// All figures, in the order of the table.
#[rustfmt::skip]
pub const FIGURES: &[Figure] = &[
    figure("isr_w1_instructions", "instructions/tick", AtMost(60.0), "step interrupt, six motors stepping together, mean"),
    figure("isr_w1_worst_instructions", "instructions/tick", AtMost(160.0), "the same, worst tick"),
    figure("isr_w2_instructions", "instructions/tick", AtMost(60.0), "six motors in golden ratios, mean"),
    figure("isr_w2_worst_instructions", "instructions/tick", AtMost(160.0), "the same, worst tick"),
    figure("isr_w3_instructions", "instructions/tick", AtMost(60.0), "one motor, mean"),
    figure("isr_w3_worst_instructions", "instructions/tick", AtMost(160.0), "the same, worst tick"),
    figure("isr_w4_instructions", "instructions/tick", AtMost(60.0), "three motors, mean"),
    figure("isr_w4_worst_instructions", "instructions/tick", AtMost(160.0), "the same, worst tick"),
    figure("isr_turn_worst_instructions", "instructions/tick", AtMost(160.0), "six motors to and fro, all turning round together, worst tick"),
    figure("isr_turn_latch_worst_instructions", "instructions/tick", AtMost(160.0), "the same with a latch in that tick: the interrupt's work in the bench program"),
    figure("isr_turn_latch_worst_cycles_model", "cycles/tick", None, "model, without entry and exit; the shortest tick has 240"),
    figure("isr_w1_instructions_per_step_pulse", "instructions/step", AtMost(20.0), "all ticks over all steps, pulse mode"),
    figure("isr_w1_instructions_per_step_both_edge", "instructions/step", AtMost(10.0), "the same, both-edge mode"),
    figure("isr_w1_cycles_model", "cycles/tick", AtMost(110.0), "model, entry and exit included, mean"),
    figure("isr_w1_worst_cycles_model", "cycles/tick", None, "model, worst tick"),
    figure("isr_eight_w1_instructions", "instructions/tick", AtMost(90.0), "eight motors on four ports stepping together, mean"),
    figure("isr_eight_turn_worst_instructions", "instructions/tick", None, "eight motors to and fro, all turning round together, worst tick"),
    figure("isr_eight_w1_cycles_model", "cycles/tick", None, "model, entry and exit included, mean"),
    figure("isr_load_100khz_six", "of the processor", AtMost(0.14), "model: pulse mode, six motors at 100 kHz"),
    figure("segment_instructions", "instructions/segment", AtMost(2500.0), "preparing one segment of six motors"),
    figure("planner_instructions_per_block", "instructions/block", AtMost(30_000.0), "chords of 1 mm, six joints, full look-ahead: push and samples"),
    figure("planner_push_instructions", "instructions", None, "the push alone"),
    figure("planner_instructions_per_sample", "instructions/sample", None, "the sample alone, backward pass included"),
    figure("planner_samples_per_block", "samples/block", None, "how many of them come to a block"),
    figure("motion_velocity_share", "of the limit", AtMost(1.02), "largest joint velocity, 1000 random programs"),
    figure("motion_acceleration_share", "of the limit", AtMost(1.01), "largest joint acceleration, the same"),
    figure("motion_jerk_share_corners", "of the limit", AtMost(1.03), "largest joint jerk, the same, corners too"),
    figure("motion_jerk_share_smooth", "of the limit", AtMost(1.02), "largest joint jerk on circle and trochoid"),
    figure("motion_contour_over_tolerance_steps", "steps", AtMost(0.51), "contour error beyond the tolerance, 1000 random programs"),
    figure("motion_time_over_optimum_long", "of the optimum", AtMost(1.01), "rest to rest against rsruckig, from 2 a^3/j^2 on"),
    figure("motion_time_over_optimum_short", "of the optimum", AtMost(1.25), "the same, down to a tenth of that"),
    figure("motion_time_circle", "of length/feed and ramps", AtMost(1.05), "circle of 10 000 chords"),
    figure("motion_time_trochoid", "of length/feed and ramps", AtMost(1.05), "trochoid of precession polishing, 6000 chords"),
    figure("motion_zigzag_gain_least", "times", AtLeast(1.0), "zigzags against their blocks from rest to rest, worst"),
    figure("motion_zigzag_gain_mean", "times", None, "the same, mean over tolerances 0.003 to 0.3 mm"),
    figure("motion_hold_latency_ms", "ms", AtMost(10.0), "hold to deceleration, queue included, 1000 instants"),
    figure("motion_override_latency_ms", "ms", AtMost(50.0), "override to change of speed, queue included"),
    figure("trim_latency_ms", "ms", AtMost(7.0), "a reading's last byte to the first pulse it moves, Octopus in the emulator, worst of 20: queue and two segments"),
    figure("five_axis_solve_instructions", "instructions", AtMost(900.0), "tool direction to both pairs of angles"),
    figure("five_axis_full_instructions", "instructions", AtMost(2500.0), "the same with choice and linear part"),
    figure("arm_ik_instructions", "instructions", AtMost(8000.0), "flange pose to eight branches"),
    figure("mirror_pair_instructions", "instructions", AtMost(6000.0), "place of the panel to both five-axis sides"),
    figure("trim_tick_instructions", "instructions", AtMost(80.0), "measured shift to bounded offset"),
    figure("trim_full_tick_instructions", "instructions", AtMost(8000.0), "the same, both sides' joints, their trims and checks"),
    figure("drill_pose_instructions", "instructions", AtMost(1500.0), "pose to six joints"),
    figure("drill_solve_instructions", "instructions", None, "grinding parameters from a drill's geometry"),
    figure("precession_pose_instructions", "instructions", AtMost(1500.0), "one pose of the bonnet, tool frame included"),
    figure("nurbs_eval_instructions", "instructions", AtMost(3400.0), "rational bicubic: point, derivatives, normal, curvatures"),
    figure("hertz_instructions", "instructions", AtMost(5000.0), "curvatures to the ellipse of contact"),
    figure("precession_block_instructions", "instructions/block", AtMost(30_000.0), "a block of an arm under precession, looked at or on its way, mean"),
    figure("precession_block_worst_instructions", "instructions", AtMost(300_000.0), "the same, worst call: a stretch halved 12 times"),
    figure("grinding_block_instructions", "instructions/block", AtMost(34_000.0), "a block of an arm grinding rows, mean"),
    figure("grinding_block_worst_instructions", "instructions", AtMost(300_000.0), "the same, worst call"),
    figure("mirror_block_instructions", "instructions/block", AtMost(37_000.0), "a block of both sides of a panel, mean"),
    figure("mirror_block_worst_instructions", "instructions", AtMost(300_000.0), "the same, worst call"),
    figure("process_block_worst_cycles_model", "cycles", AtMost(672_000.0), "model, worst call of the three: the queue is 5 ms ahead, 4 of them are there"),
    figure("point_line_worst_instructions", "instructions", AtMost(300_000.0), "a line with a point, read and put in, worst of arm and pair"),
    figure("surface_rows_hard_seconds", "s", AtMost(1.0), "planning all rows of the hard job on Dune"),
    figure("surface_rows_soft_seconds", "s", AtMost(0.2), "the same, soft job"),
    figure("surface_residual_hard_seconds", "s", AtMost(2.0), "residual of the hard job at 60 stations"),
    figure("arm_against_peer_ratio", "of the peer's time", AtMost(1.0), "eight branches of the arm against rs-opw-kinematics, f64, this machine"),
    figure("firmware_flash_bytes", "bytes", AtMost(128.0 * 1024.0), "code and constants, of 1 MiB: corners rounded in time, targets between steps, shaping"),
    figure("firmware_ram_bytes", "bytes", AtMost(52_408.0), "statics, without the stack: at most a tenth above 47 644, with 64 blocks and a shaper's history"),
    figure("arm_flash_bytes", "bytes", AtMost(176.0 * 1024.0), "the same for the board in an arm: precession, surface grinding"),
    figure("arm_ram_bytes", "bytes", AtMost(56.0 * 1024.0), "of 128 KiB, 60 of them kept for the stack"),
    figure("octopus_flash_bytes", "bytes", AtMost(176.0 * 1024.0), "the same for the Octopus: eight motors, the two-sided machine"),
    figure("octopus_ram_bytes", "bytes", AtMost(72_666.0), "the same for eight motors: at most a tenth above 66 060"),
    figure("host_ticks_per_second", "ticks/s", AtLeast(20.0e6), "interpolator on this machine, one thread"),
];

/// Measured values by key.
#[derive(Default)]
pub struct Measured(BTreeMap<&'static str, f64>);

impl Measured {
    /// Notes a value; a key that no figure has is a mistake here and is named.
    pub fn set(&mut self, key: &'static str, value: f64) -> Outcome<()> {
        if !FIGURES.iter().any(|figure| figure.key == key) {
            return Err(format!("no figure is named {key}"));
        }
        if !value.is_finite() {
            return Err(format!("{key} could not be measured"));
        }
        self.0.insert(key, value);
        Ok(())
    }

    /// Prints the table, with `all` or without what was not measured; the names of the figures in it that miss their goal
    /// or were not measured.
    pub fn print(&self, all: bool) -> Vec<&'static str> {
        let mut missed = Vec::new();
        println!("{:42} {:>14} {:>14}  unit", "figure", "value", "goal");
        let is_shown = |figure: &&Figure| all || self.0.contains_key(figure.key);
        for figure in FIGURES.iter().filter(is_shown) {
            let Some(&value) = self.0.get(figure.key) else {
                println!(
                    "{:42} {:>14} {:>14}  {}",
                    figure.key,
                    "not measured",
                    goal(figure.goal),
                    figure.unit
                );
                missed.push(figure.key);
                continue;
            };
            let met = figure.goal.is_met(value);
            if !met {
                missed.push(figure.key);
            }
            let mark = if met { ' ' } else { '!' };
            println!(
                "{:42} {:>14}{mark}{:>14}  {}: {}",
                figure.key,
                number(value),
                goal(figure.goal),
                figure.unit,
                figure.what
            );
        }
        missed
    }

    /// Writes all values as one flat JSON object.
    pub fn write(&self, path: &Path) -> Outcome<()> {
        let text = serde_json::to_string_pretty(&self.0).map_err(|error| error.to_string())?;
        std::fs::write(path, text + "\n").map_err(|error| format!("{}: {error}", path.display()))
    }
}

fn goal(goal: Goal) -> String {
    match goal {
        Goal::None => String::from("-"),
        Goal::AtMost(value) => format!("<= {}", number(value)),
        Goal::AtLeast(value) => format!(">= {}", number(value)),
    }
}

/// Whole numbers as such, others with as many places as they need to be compared.
fn number(value: f64) -> String {
    if value.abs() >= 1000.0 {
        format!("{value:.0}")
    } else if value.abs() >= 1.0 {
        format!("{value:.1}")
    } else {
        format!("{value:.3}")
    }
}
