//! Several CL points: `five_axis.bound` and `five_axis.path`.

use super::machine::{cl_point, fault, machine, outer, previous};
use super::pose::angle;
use super::{Answer, Fault, Request, answer, request};
use hexstep::joints::Joints;
use hexstep::kinematics::follow::{Block, Feed, Flags, Follower, Guide, Refusal, Tolerance};
use hexstep::kinematics::{ClPoint, Way};
use hexstep::machines::five_axis::{Axis, Error, FiveAxis, Layer, PathChoice, Solution, Turned};
use hexstep::math::Real;
use serde_json::{Value, json};

/// States that the path choice keeps for a point: several turns of both axes and both solutions.
const STATES: usize = 64;
const MOST_SAMPLES: i128 = 1_000_000;

pub fn bound<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let machine = machine::<R>(request)?;
    let samples = request.integer("samples");
    if !(1..=MOST_SAMPLES).contains(&samples) {
        let detail = format!("samples must be 1 to {MOST_SAMPLES}");
        return Err(Fault::new("BadLimit", detail).field("samples"));
    }
    let cl = cl_points::<R>(request)?;
    let [from, to] = cl.as_slice() else {
        return Err(Fault::new("WrongType", "cl must hold two points").field("cl"));
    };
    let solve = |at: &ClPoint<R>, near: &[Turned<R>; 2], index: usize| {
        machine
            .inverse(at.p(), at.v(), near)
            .map_err(|e| fault(&e).with("index", index))
    };
    let first = solve(from, &previous(request), 0)?;
    let second = solve(to, &first.rotary, 1)?;
    let way = Way::new(*from, *to).ok_or_else(|| anti_parallel(1))?;
    let chord = (to.v() - from.v()).norm();
    let bounds = machine.bounds(&first, &second, way.length(), chord);

    let (mut tip, mut axis) = (R::ZERO, R::ZERO);
    let change = machine.change(&first, &second);
    let start = first.joints();
    for i in 1..samples {
        let u = R::of(i as f64 / samples as f64);
        let q = Joints(std::array::from_fn(|j| start[j] + change[j] * u));
        let (p, v) = machine.forward(&q).map_err(|e| fault(&e))?;
        let wanted = way.at(u);
        tip = tip.max((p - wanted.p()).norm());
        axis = axis.max(angle(v, wanted.v()));
    }
    Ok(Answer::new()
        .numbers("q0", outer(&first.joints()))
        .numbers("q1", outer(&second.joints()))
        .number("tip_bound", bounds.tip)
        .maybe_degrees("axis_bound", bounds.axis)
        .number("tip_error", tip)
        .degrees("axis_error", axis))
}

pub fn path<R: Real>(request: &Request) -> Result<Answer, Fault> {
    let feed: R = request.number("feed");
    let machine = match machine::<R>(request) {
        // In the table of errors the feed stands between the travel limits and the weights.
        Err(fault) if fault.error == "BadLimit" && feed <= R::ZERO && !is_about_limits(&fault) => {
            return Err(bad_feed(None));
        }
        machine => machine?,
    };
    if feed <= R::ZERO {
        return Err(bad_feed(None));
    }
    let tolerance = Tolerance {
        tip: request.number("tol"),
        axis: request.degrees("tau"),
        subdivide: request.flag("subdivide"),
    };
    for (name, value) in [("tol", tolerance.tip), ("tau", tolerance.axis)] {
        if value <= R::ZERO {
            return Err(Fault::new("BadLimit", format!("{name} must be above 0")).field(name));
        }
    }
    let window = usize::try_from(request.integer("window")).map_err(|_| {
        Fault::new("BadLimit", "window must be 0, for the whole path, or more").field("window")
    })?;
    let cl = cl_points::<R>(request)?;
    let start = previous(request);
    let chosen = match request.word("choice") {
        "best" => Some(choose(&machine, &cl, window, start)?),
        _ => None,
    };
    let walked = walk(&machine, &cl, start, chosen.as_deref(), tolerance, feed)?;

    let mut per_segment = vec![0u32; cl.len().saturating_sub(1)];
    let (mut total, mut cost, mut before) = (R::ZERO, R::ZERO, start);
    let mut blocks = Vec::with_capacity(walked.len());
    for (i, block) in walked.iter().enumerate() {
        if i > 0
            && let Some(count) = per_segment.get_mut(block.segment as usize)
        {
            *count += 1;
        }
        total += block.duration;
        cost += machine.cost(&before, &block.set.rotary);
        before = block.set.rotary;
        blocks.push(shown(block));
    }
    Ok(Answer::new()
        .put("count", &walked.len())
        .put("per_segment", &per_segment)
        .number("total_time", total)
        .degrees("cost", cost)
        .value("blocks", Value::Array(blocks)))
}

type Walked<R> = Vec<Block<5, R, Solution<R>>>;

/// Every block of the path, the first point included as a block of no duration.
fn walk<R: Real>(
    machine: &FiveAxis<R>,
    cl: &[ClPoint<R>],
    start: [Turned<R>; 2],
    chosen: Option<&[Solution<R>]>,
    tolerance: Tolerance<R>,
    feed: R,
) -> Result<Walked<R>, Fault> {
    let Some((first, rest)) = cl.split_first() else {
        return Ok(Vec::new());
    };
    let set = match chosen.and_then(<[_]>::first) {
        Some(set) => *set,
        None => machine
            .inverse(first.p(), first.v(), &start)
            .map_err(|e| fault(&e).with("index", 0))?,
    };
    let mut blocks = vec![Block {
        segment: 0,
        u: R::ZERO,
        joints: set.joints(),
        set,
        duration: R::ZERO,
        limited_by: None,
        flags: Flags {
            singular: machine.is_singular(&set),
            ..Flags::default()
        },
    }];
    let mut follower =
        Follower::new(machine, tolerance, *first, set).map_err(|why| refusal(&why, 0))?;
    for (index, to) in rest.iter().enumerate().map(|(i, to)| (i + 1, to)) {
        let end = chosen.and_then(|sets| sets.get(index)).copied();
        follower
            .push(*to, end, Feed::Tip(feed))
            .map_err(|refused| refusal(&refused.why, index).with("u", answer::number(refused.u)))?;
        blocks.extend(std::iter::from_fn(|| follower.next_block()));
    }
    Ok(blocks)
}

/// The joints of every CL point by the windowed choice.
fn choose<R: Real>(
    machine: &FiveAxis<R>,
    cl: &[ClPoint<R>],
    window: usize,
    start: [Turned<R>; 2],
) -> Result<Vec<Solution<R>>, Fault> {
    let size = match window {
        0 => cl.len(),
        window => window.min(cl.len()),
    };
    let mut layers = vec![Layer::<R, STATES>::empty(); size];
    let mut choice = PathChoice::new(machine, &mut layers, start);
    let mut chosen: Vec<Solution<R>> = Vec::with_capacity(cl.len());
    let commit = |choice: &mut PathChoice<R, STATES>, chosen: &mut Vec<Solution<R>>| {
        let Some(committed) = choice.pop() else {
            return Ok::<_, Fault>(false);
        };
        chosen.push(committed.map_err(|e| fault(&e).with("index", chosen.len()))?);
        Ok(true)
    };
    for (index, at) in cl.iter().enumerate() {
        if choice.is_full() {
            commit(&mut choice, &mut chosen)?;
        }
        choice
            .push(at.p(), at.v())
            .map_err(|e| fault(&e).with("index", index))?;
    }
    while commit(&mut choice, &mut chosen)? {}
    Ok(chosen)
}

fn cl_points<R: Real>(request: &Request) -> Result<Vec<ClPoint<R>>, Fault> {
    let vector = |point: &Value, name| point.get(name).and_then(request::read_vector::<R>);
    let points = request.list("cl").iter().enumerate();
    points
        .map(
            |(index, point)| match (vector(point, "p"), vector(point, "v")) {
                (Some(p), Some(v)) => cl_point(p, v).map_err(|fault| fault.with("index", index)),
                // The schema has checked both.
                _ => Err(Fault::new("WrongType", "a CL point holds p and v").field("cl")),
            },
        )
        .collect()
}

fn shown<R: Real>(block: &Block<5, R, Solution<R>>) -> Value {
    let Flags {
        singular,
        coarse,
        reconfigure,
    } = block.flags;
    let names = [
        (singular, "Singular"),
        (coarse, "Coarse"),
        (reconfigure, "Reconfigure"),
    ];
    let flags: Vec<_> = names.iter().filter(|f| f.0).map(|f| f.1).collect();
    let axis = block.limited_by.and_then(|joint| Axis::ALL.get(joint));
    let inverse_time = match block.duration > R::ZERO {
        true => R::of(60.0) / block.duration,
        false => R::ZERO,
    };
    json!({
        "segment": block.segment,
        "u": answer::number(block.u),
        "q": outer(&block.joints).map(answer::number),
        "dt": answer::number(block.duration),
        "inverse_time": answer::number(inverse_time),
        "flags": flags,
        "limited_by": axis.map_or("feed", |axis| axis.name()),
    })
}

fn refusal<R: Real>(why: &Refusal<Error<R>>, index: usize) -> Fault {
    match why {
        Refusal::AntiParallel => anti_parallel(index),
        Refusal::BadFeed => bad_feed(Some(index)),
        Refusal::BadLimit => Fault::new("BadLimit", "tol and tau must be above 0").field("tol"),
        Refusal::Machine(error) => fault(error).with("index", index),
    }
}

fn anti_parallel(index: usize) -> Fault {
    let detail = "the tool axis is opposite to the one before; give a point between them";
    Fault::new("AntiParallel", detail).with("index", index)
}

/// With an index: the feed itself is good, but the tip stands still before that CL point.
fn bad_feed(index: Option<usize>) -> Fault {
    match index {
        Some(index) => Fault::new(
            "BadFeed",
            "the tip stands still, so its feed gives no time; give the machine's speeds",
        )
        .field("feed")
        .with("index", index),
        None => Fault::new("BadFeed", "feed must be above 0").field("feed"),
    }
}

fn is_about_limits(fault: &Fault) -> bool {
    fault.detail.starts_with("limits")
}
