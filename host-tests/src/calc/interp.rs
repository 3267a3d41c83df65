//! `interp.pulses`: the ratio-integral rule, step by step, for any counts up to 2^62.
//!
//! Source: Li & Chen, Research on kinematic synthesis of a robot manipulator for drill grinding, section 3.1, with
//! the test corrected to (R + R')/MAX >= 1.

use super::{Answer, Fault, Field, Function, Kind, Length, Request};

pub const FUNCTIONS: &[Function] = &[Function {
    name: "interp.pulses",
    summary: "The iterations, from 1, in which each motor of one move steps.",
    fields: &[&[
        Field::new(
            "counts",
            Kind::List(&Kind::Integer, Length::Between(1, 8)),
            "steps",
            "|count| <= 2^62, the largest at most 1000000",
        ),
        Field::new("preset", Kind::Word(&["published", "centred"]), "", "").or("\"published\""),
    ]],
    f64: pulses,
    // Integers throughout: the scalar makes no difference.
    f32: Some(pulses),
}];

/// Longer lists than this are refused.
const LONGEST: u64 = 1_000_000;
const LARGEST: u128 = 1 << 62;

fn pulses(request: &Request) -> Result<Answer, Fault> {
    let counts = request.integers("counts");
    let beyond = |index: usize, what: String| {
        Fault::new("OutOfRange", what)
            .field("counts")
            .with("index", index)
    };
    if let Some(i) = counts.iter().position(|m| m.unsigned_abs() > LARGEST) {
        return Err(beyond(
            i,
            format!("counts[{i}] is beyond 2^62; divide the move"),
        ));
    }
    let ratios: Vec<u64> = counts.iter().map(|m| m.unsigned_abs() as u64).collect();
    let max = ratios.iter().copied().max().unwrap_or(0);
    if max > LONGEST {
        let i = ratios.iter().position(|r| *r == max).unwrap_or(0);
        return Err(beyond(
            i,
            format!(
                "the largest count is {max}: more than {LONGEST} iterations are too long to list; divide the move"
            ),
        ));
    }
    let centred = request.word("preset") == "centred";
    let pulses: Vec<Vec<u32>> = ratios.iter().map(|r| steps(*r, max, centred)).collect();
    let directions: Vec<i128> = counts.iter().map(|m| m.signum()).collect();
    Ok(Answer::new()
        .put("max", &max)
        .put("directions", &directions)
        .put("pulses", &pulses))
}

/// The rule itself, one iteration at a time: add the ratio, step when the sum reaches MAX.
fn steps(ratio: u64, max: u64, centred: bool) -> Vec<u32> {
    let mut accumulator = if centred { max / 2 } else { ratio };
    let mut steps = Vec::new();
    // At most LONGEST iterations, so the number of one fits in a u32, and sums stay below 2 LONGEST.
    for iteration in 1..=max as u32 {
        accumulator += ratio;
        if accumulator >= max {
            accumulator -= max;
            steps.push(iteration);
        }
    }
    steps
}
