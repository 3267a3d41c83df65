//! A pair of machines along a reference surface: joints of both sides, bounds, travel.

use hexstep::geometry::Vector;
use hexstep::joints::Joints;
use hexstep::kinematics::ClPoint;
use hexstep::kinematics::chord::{ChainSet, Paced};
use hexstep::kinematics::follow::{Block, Feed, Follower, Guide, Refusal, Refused, Tolerance};
use hexstep::machines::two_sided::{
    AtWall, Pair, PairError, PairGuide, SideError, m4, m4_1, m4_2, m5,
};
use hexstep::math::Real;
use hexstep_host::reference::matrix::{angle_deg, distance};
use hexstep_host::reference::serial::{ToolAt, tools_at, two_sided};

const WALL: f64 = 1.5;
const TIGHT: Tolerance<f64> = Tolerance {
    tip: 0.002,
    axis: 0.0005,
    subdivide: true,
};

fn guide(pair: Pair<4, 4, f64>) -> PairGuide<f64> {
    PairGuide {
        machine: AtWall { pair, wall: WALL },
        speeds: None,
    }
}

/// Section 8: point and normal of the cylinder of radius 4000 mm at x, y.
fn panel<R: Real>(x: f64, y: f64) -> ClPoint<R> {
    let height = (4000.0 * 4000.0 - x * x).sqrt();
    let point = [x, y, height - 4000.0].map(R::of);
    let normal = [x / 4000.0, 0.0, height / 4000.0].map(R::of);
    ClPoint::new(Vector::from_array(point), Vector::from_array(normal)).unwrap()
}

fn start<R: Real>(machine: &PairGuide<R>, at: ClPoint<R>) -> ChainSet<8, R> {
    let home = ChainSet {
        q: Joints::default(),
        at,
        singular: false,
    };
    machine.solve(&at, &home).unwrap()
}

type Blocks<R> = Vec<Block<8, R, ChainSet<8, R>>>;

fn follow<R: Real>(
    machine: &PairGuide<R>,
    ends: &[ClPoint<R>],
    tolerance: Tolerance<R>,
) -> Result<Blocks<R>, Refused<R, PairError<4, 4, R>>> {
    let set = start(machine, ends[0]);
    let mut follower = Follower::new(machine, tolerance, ends[0], set).unwrap();
    let mut blocks = Vec::new();
    for end in &ends[1..] {
        assert!(follower.push(*end, None, Feed::Tip(R::of(5.0)))?);
        blocks.extend(std::iter::from_fn(|| follower.next_block()));
    }
    Ok(blocks)
}

/// Both tools in the work frame of side 1 by the reference.
fn tools(q: &[f64; 8]) -> [ToolAt; 2] {
    let sides = ["m4-mill", "m4-support"].map(|name| two_sided(name).unwrap());
    tools_at([&sides[0], &sides[1]], &q[..4], &q[4..])
}

fn printed(q: &Joints<8, f64>) -> [f64; 8] {
    std::array::from_fn(|i| if i % 4 == 3 { q[i].to_degrees() } else { q[i] })
}

#[test]
fn the_guide_gives_the_joints_of_both_sides_that_the_specification_prints() {
    let machine = guide(m4().unwrap());
    let tilted = ClPoint::new(Vector::new(100.0, 50.0, -2.0), Vector::new(0.1, 0.05, 0.99));
    for (at, row) in [
        (
            panel(0.0, 100.0),
            [600.0, 550.0, -48.5, 0.0, -600.0, 550.0, -50.0, 0.0],
        ),
        (
            panel(-400.0, 100.0),
            [
                159.85,
                550.0,
                -70.562795575,
                -5.739170477,
                -238.0,
                550.0,
                -31.854522326,
                -5.739170477,
            ],
        ),
        (
            panel(500.0, 100.0),
            [
                1150.1875,
                550.0,
                -83.022101631,
                7.180755781,
                -1052.5,
                550.0,
                -21.607404770,
                7.180755781,
            ],
        ),
        (
            tilted.unwrap(),
            [
                740.350040484,
                500.075279050,
                -52.534599207,
                5.767888898,
                -661.810491734,
                500.0,
                -49.923868171,
                5.767888898,
            ],
        ),
    ] {
        let set = start(&machine, at);

        let found = printed(&machine.joints(&set));
        for (a, b) in found.iter().zip(row) {
            assert!((a - b).abs() < 0.51e-9, "{found:?}, printed {row:?}");
        }
        assert!(!machine.is_singular(&set), "one rotary has one solution");
    }
}

#[test]
fn along_the_panel_both_tools_stay_within_the_tolerances_everywhere_between_the_blocks() {
    let machine = guide(m4().unwrap());
    let ends: Vec<ClPoint<f64>> = (-5..=5)
        .map(|k| panel(f64::from(k) * 90.0, 200.0))
        .collect();

    let blocks = follow(&machine, &ends, TIGHT).unwrap();

    let mut from = (0, 0.0, machine.joints(&start(&machine, ends[0])));
    let mut largest = [0.0f64; 3];
    for block in &blocks {
        assert!(!block.flags.coarse && !block.flags.singular && !block.flags.reconfigure);
        let index = block.segment as usize;
        let begin = if from.0 == index { from.1 } else { 0.0 };
        for part in 0..=16 {
            let share = f64::from(part) / 16.0;
            let q = std::array::from_fn(|i| {
                let (a, b) = (from.2.0[i], block.joints.0[i]);
                a + (b - a) * share
            });
            // The point on the straight line, the normal on the great circle, written down once more.
            let u = begin + (block.u - begin) * share;
            let (a, b) = (ends[index], ends[index + 1]);
            let p = (a.p() + (b.p() - a.p()) * u).to_array();
            let angle = angle_deg(a.v().to_array(), b.v().to_array()).to_radians();
            let n: [f64; 3] = std::array::from_fn(|i| {
                let (a, b) = (a.v().to_array()[i], b.v().to_array()[i]);
                (a * (angle * (1.0 - u)).sin() + b * (angle * u).sin()) / angle.sin()
            });
            let [mill, support] = tools(&q);
            let tip = std::array::from_fn(|i| p[i] + WALL * n[i]);
            let off = distance(mill.tip, tip).max(distance(support.tip, p));
            let turned = angle_deg(mill.axis, n).max(angle_deg(support.axis, n.map(|x| -x)));
            let wall: f64 = (0..3).map(|i| n[i] * (mill.tip[i] - support.tip[i])).sum();
            for (most, found) in largest.iter_mut().zip([off, turned, (wall - WALL).abs()]) {
                *most = most.max(found);
            }
        }
        from = (index, block.u, block.joints);
    }
    assert!(blocks.len() > 10, "{} blocks", blocks.len());
    assert!(largest[0] <= TIGHT.tip, "{largest:?}");
    assert!(largest[1] <= TIGHT.axis.to_degrees(), "{largest:?}");
    assert!(largest[2] <= TIGHT.tip, "{largest:?}");
    assert!(largest[0] > 0.1 * TIGHT.tip, "{largest:?}: not tested");
}

#[test]
fn a_tilt_that_four_axes_cannot_follow_does_not_stop_the_pair() {
    let machine = guide(m4().unwrap());
    let end = |x| ClPoint::new(Vector::new(x, 50.0, -2.0), Vector::new(0.1, 0.05, 0.99)).unwrap();

    let blocks = follow(&machine, &[end(100.0), end(140.0)], TIGHT).unwrap();

    assert_eq!(blocks.len(), 1);
    assert!(!blocks[0].flags.coarse);
    let [mill, support] = tools(&blocks[0].joints.0);
    let n = end(140.0).v().to_array();
    let wall: f64 = (0..3).map(|i| n[i] * (mill.tip[i] - support.tip[i])).sum();
    assert!((wall - WALL).abs() < 1e-9, "{wall}");
    assert!((angle_deg(mill.axis, n) - 2.876656294).abs() < 1e-9);
}

#[test]
fn travel_that_ends_on_either_side_is_named_and_nothing_is_emitted() {
    // X2 leaves its travel before x = 300 of the panel; then X1 does.
    let wide = m4_2::<f64>().with_travel(0, [-800.0, 0.0]).unwrap();
    let narrow = m4_1::<f64>().with_travel(0, [0.0, 700.0]).unwrap();
    for (pair, why) in [
        (
            Pair::new(m4_1(), wide).unwrap(),
            PairError::Support(SideError::OutOfTravel { joint: 0 }),
        ),
        (
            Pair::new(narrow, m4_2()).unwrap(),
            PairError::Mill(SideError::OutOfTravel { joint: 0 }),
        ),
    ] {
        let machine = guide(pair);
        let set = start(&machine, panel(0.0, 0.0));
        let mut follower = Follower::new(&machine, TIGHT, panel(0.0, 0.0), set).unwrap();

        let refused = follower.push(panel(300.0, 0.0), None, Feed::Tip(5.0));

        let refused = refused.expect_err("beyond the travel");
        assert_eq!(refused.why, Refusal::Machine(why));
        assert!(refused.u > 0.0, "{}", refused.u);
        assert_eq!(follower.next_block(), None);
        assert_eq!(follower.set(), &set, "neither side has moved on");
    }
}

#[test]
fn a_wall_that_is_none_is_refused_by_name() {
    for wall in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let pair = m4().unwrap();
        let machine = PairGuide {
            machine: AtWall { pair, wall },
            speeds: None,
        };
        let at = panel(0.0, 0.0);
        let home = ChainSet {
            q: Joints::default(),
            at,
            singular: false,
        };

        assert_eq!(machine.solve(&at, &home), Err(PairError::BadWall));
    }
}

#[test]
fn in_single_precision_the_pair_takes_the_same_blocks_within_a_micrometre() {
    let fine = guide(m4().unwrap());
    let single = PairGuide::<f32> {
        machine: AtWall {
            pair: m4().unwrap(),
            wall: WALL as f32,
        },
        speeds: None,
    };
    let tolerance = Tolerance {
        tip: 0.01f32,
        axis: 0.001,
        subdivide: true,
    };
    let wide = Tolerance {
        tip: 0.01,
        axis: 0.001,
        subdivide: true,
    };
    let places: Vec<f64> = (-4..=4).map(|k| 100.0 * f64::from(k)).collect();
    let ends = |y| places.iter().map(move |x| panel(*x, y));

    let a = follow(&fine, &ends(100.0).collect::<Vec<_>>(), wide).unwrap();
    let places: Vec<ClPoint<f32>> = places.iter().map(|x| panel(*x, 100.0)).collect();
    let b = follow(&single, &places, tolerance).unwrap();

    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        for (a, b) in tools(&a.joints.0)
            .iter()
            .zip(tools(&b.joints.0.map(f64::from)))
        {
            assert!(distance(a.tip, b.tip) < 1e-3, "{a:?} {b:?}");
        }
    }
}

/// The dual five-axis pair has ten joints, more than a controller has motors, but a trajectory like any other: on a surface
/// that leans both ways both tools stay square to it, and the wall stays.
#[test]
fn the_dual_five_axis_pair_keeps_its_wall_and_its_tools_square_where_the_surface_leans_both_ways() {
    let machine = Paced {
        machine: AtWall {
            pair: m5().unwrap(),
            wall: WALL,
        },
        speeds: None,
    };
    // z = x^2 / 4000 - y^2 / 5000 + x y / 9000, and its gradient.
    let at = |x: f64, y: f64| {
        let slope = [x / 2000.0 + y / 9000.0, -y / 2500.0 + x / 9000.0];
        let p = Vector::new(x, y, x * x / 4000.0 - y * y / 5000.0 + x * y / 9000.0);
        ClPoint::new(p, Vector::new(-slope[0], -slope[1], 1.0)).unwrap()
    };
    let ends: Vec<ClPoint<f64>> = (0..=12)
        .map(|k| f64::from(k) / 12.0)
        .map(|u| at(-300.0 + 600.0 * u, 250.0 * (2.0 * u - 1.0)))
        .collect();
    let home = ChainSet {
        q: Joints::<10, f64>::default(),
        at: ends[0],
        singular: false,
    };
    let set = machine.solve(&ends[0], &home).unwrap();
    let mut joints = vec![machine.joints(&set)];
    let mut follower = Follower::new(&machine, TIGHT, ends[0], set).unwrap();
    for end in &ends[1..] {
        assert!(follower.push(*end, None, Feed::Tip(5.0)).unwrap());
        joints.extend(std::iter::from_fn(|| follower.next_block()).map(|block| block.joints));
    }

    let sides = ["m5-mill", "m5-support"].map(|name| two_sided(name).unwrap());
    let mut worst = [0.0f64; 3];
    let mut leans = [0.0f64; 2];
    for pair in joints.windows(2) {
        for share in [0.0, 0.3, 0.5, 0.8, 1.0] {
            let q = pair[0].zip_map(&pair[1], |a, b| a + (b - a) * share).0;
            let [mill, support] = tools_at([&sides[0], &sides[1]], &q[..5], &q[5..]);
            let n = mill.axis;
            let e: [f64; 3] = std::array::from_fn(|i| mill.tip[i] - support.tip[i]);
            let along: f64 = (0..3).map(|i| e[i] * n[i]).sum();
            let now = [
                (along - WALL).abs(),
                distance(e, n.map(|x| x * along)),
                angle_deg(n, support.axis.map(|x| -x)).to_radians(),
            ];
            for (worst, now) in worst.iter_mut().zip(now) {
                *worst = worst.max(now);
            }
            leans = [leans[0].max(n[0].abs()), leans[1].max(n[1].abs())];
        }
    }
    assert!(joints.len() > 40, "{} places", joints.len());
    assert!(
        leans[0] > 0.1 && leans[1] > 0.05,
        "both angles are used: {leans:?}"
    );
    // Each tip and each tool may leave its way by the tolerance.
    assert!(
        worst[0] <= 2.0 * TIGHT.tip && worst[1] <= 2.0 * TIGHT.tip,
        "{worst:?}"
    );
    assert!(worst[2] <= 2.0 * TIGHT.axis, "{worst:?}");
}
