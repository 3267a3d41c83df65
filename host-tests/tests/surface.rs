//! Surface grinding at one place: NURBS, contact, removal, spacing, step, pose; and every refusal by its name.
//!
//! The printed figures of the specification stand in cases/calc/surface.jsonl. Here the same functions are held against
//! formulas that share nothing with them: knot insertion, exact bodies of revolution, quadrature, geometry by hand.

mod common;

use common::Random;
use hexstep::cycles::surface_grinding::{
    Grinding, Hertz, Job, Limit, Material, Model, Removal, Sense, StepLimits, Stripe, Wheel,
    effective_modulus, flange, pitch, tool_pose,
};
use hexstep::geometry::nurbs::{Nurbs, NurbsError};
use hexstep::geometry::{Pose, Rotation, Vector};
use hexstep_host::calc;
use hexstep_host::surface::dune;
use serde_json::{Value, json};
use std::f64::consts::PI;

fn ask(call: &str, request: &Value) -> Value {
    let mut output = Vec::new();
    calc::main(call, "f64", request.to_string().as_bytes(), &mut output).unwrap();
    serde_json::from_slice(&output).unwrap()
}

#[track_caller]
fn assert_close(found: f64, wanted: f64, within: f64) {
    assert!(
        (found - wanted).abs() <= within,
        "{found} instead of {wanted}, off by {:e}",
        found - wanted
    );
}

/// A rational surface of any degrees, as plain numbers.
struct Given {
    degrees: [usize; 2],
    knots: [Vec<f64>; 2],
    points: Vec<Vec<[f64; 4]>>,
}

impl Given {
    fn random(random: &mut Random) -> Self {
        let degrees = [1 + random.below(5), 1 + random.below(5)];
        let counts = degrees.map(|p| p + 1 + random.below(5));
        let mut knots = |p: usize, n: usize| {
            let mut inner: Vec<f64> = (0..n - p - 1).map(|_| random.between(0.1, 1.9)).collect();
            // Every other surface with a double knot, where the degree allows it.
            if p > 2 && inner.len() > 1 && random.below(2) == 0 {
                inner[1] = inner[0];
            }
            inner.sort_by(f64::total_cmp);
            [vec![0.0; p + 1], inner, vec![2.0; p + 1]].concat()
        };
        let knots = [knots(degrees[0], counts[0]), knots(degrees[1], counts[1])];
        let points = (0..counts[0])
            .map(|i| {
                (0..counts[1])
                    .map(|j| {
                        [
                            20.0 * i as f64 + random.between(-4.0, 4.0),
                            15.0 * j as f64 + random.between(-4.0, 4.0),
                            random.between(-9.0, 9.0),
                            random.between(0.5, 2.0),
                        ]
                    })
                    .collect()
            })
            .collect();
        Self {
            degrees,
            knots,
            points,
        }
    }

    fn build(&self) -> Nurbs<f64, 10, 10> {
        let flat: Vec<_> = self.points.iter().flatten().copied().collect();
        let points: Vec<_> = flat.iter().map(|p| Vector::new(p[0], p[1], p[2])).collect();
        let weights: Vec<_> = flat.iter().map(|p| p[3]).collect();
        let counts = [self.points.len(), self.points[0].len()];
        let knots = [&self.knots[0][..], &self.knots[1][..]];
        Nurbs::new(self.degrees, counts, knots, &points, &weights).unwrap()
    }

    /// By knot insertion until the parameter is a control point of its own, in u and then in v.
    fn point(&self, u: f64, v: f64) -> Vector<f64> {
        let lifted = |p: &[f64; 4]| [p[0] * p[3], p[1] * p[3], p[2] * p[3], p[3]];
        let along_v: Vec<[f64; 4]> = (0..self.points[0].len())
            .map(|j| {
                let column: Vec<_> = self.points.iter().map(|row| lifted(&row[j])).collect();
                inserted(self.degrees[0], &self.knots[0], column, u)
            })
            .collect();
        let [x, y, z, w] = inserted(self.degrees[1], &self.knots[1], along_v, v);
        Vector::new(x / w, y / w, z / w)
    }
}

/// The point of a homogeneous B-spline curve at `t`, by inserting `t` as a knot `degree` times.
fn inserted(degree: usize, knots: &[f64], mut points: Vec<[f64; 4]>, t: f64) -> [f64; 4] {
    let mut knots = knots.to_vec();
    if t >= knots[knots.len() - 1] {
        return points[points.len() - 1];
    }
    for _ in 0..degree {
        let span = knots.iter().rposition(|k| *k <= t).unwrap();
        let mut next = Vec::new();
        for i in 0..=points.len() {
            if i + degree <= span {
                next.push(points[i]);
            } else if i > span {
                next.push(points[i - 1]);
            } else {
                let width = knots[i + degree] - knots[i];
                let share = if width > 0.0 {
                    (t - knots[i]) / width
                } else {
                    0.0
                };
                let (a, b) = (points[i.saturating_sub(1)], points[i.min(points.len() - 1)]);
                next.push(std::array::from_fn(|k| (1.0 - share) * a[k] + share * b[k]));
            }
        }
        knots.insert(span + 1, t);
        points = next;
    }
    let span = knots.iter().rposition(|k| *k <= t).unwrap();
    points[span - degree]
}

#[test]
fn points_of_rational_surfaces_of_all_degrees_agree_with_knot_insertion() {
    for seed in 0..60 {
        let mut random = Random(seed);
        let given = Given::random(&mut random);
        let surface = given.build();
        for _ in 0..20 {
            let (u, v) = (random.between(0.0, 2.0), random.between(0.0, 2.0));

            let found = surface.jet(u, v).unwrap().s;

            let off = (found - given.point(u, v)).norm();
            assert!(off < 1e-9, "seed {seed} at ({u}, {v}): {off:e} mm");
        }
    }
}

#[test]
fn the_corners_belong_to_the_surface_and_are_its_corner_points() {
    let given = Given::random(&mut Random(7));
    let surface = given.build();
    let (last_u, last_v) = (given.points.len() - 1, given.points[0].len() - 1);
    for (u, v, i, j) in [
        (0.0, 0.0, 0, 0),
        (2.0, 0.0, last_u, 0),
        (0.0, 2.0, 0, last_v),
        (2.0, 2.0, last_u, last_v),
    ] {
        let [x, y, z, _] = given.points[i][j];

        let found = surface.jet(u, v).unwrap().s;

        assert!((found - Vector::new(x, y, z)).norm() < 1e-10);
    }
}

#[test]
fn derivatives_agree_with_differences_of_points() {
    // Central differences of this width: truncation and rounding both below 1e-6 of the scale.
    const H: f64 = 1e-4;
    for seed in 100..140 {
        let mut random = Random(seed);
        let given = Given::random(&mut random);
        let surface = given.build();
        let s = |u: f64, v: f64| given.point(u, v);
        for _ in 0..5 {
            let (u, v) = (random.between(0.01, 1.99), random.between(0.01, 1.99));
            // A knot within the stencil would show its jump of a derivative.
            let near = |knots: &[f64], t: f64| knots.iter().any(|k| (k - t).abs() < 2.0 * H);
            if near(&given.knots[0], u) || near(&given.knots[1], v) {
                continue;
            }

            let jet = surface.jet(u, v).unwrap();

            let half = 0.5 / H;
            let per_square = 1.0 / (H * H);
            let middle = s(u, v) * 2.0;
            let cross = s(u + H, v + H) - s(u + H, v - H) - s(u - H, v + H) + s(u - H, v - H);
            for (name, found, wanted, within) in [
                ("s_u", jet.s_u, (s(u + H, v) - s(u - H, v)) * half, 1e-3),
                ("s_v", jet.s_v, (s(u, v + H) - s(u, v - H)) * half, 1e-3),
                (
                    "s_uu",
                    jet.s_uu,
                    (s(u + H, v) - middle + s(u - H, v)) * per_square,
                    0.02,
                ),
                ("s_uv", jet.s_uv, cross * (0.25 * per_square), 0.02),
                (
                    "s_vv",
                    jet.s_vv,
                    (s(u, v + H) - middle + s(u, v - H)) * per_square,
                    0.02,
                ),
            ] {
                let scale = 1.0 + wanted.norm() / 100.0;
                let off = (found - wanted).norm();
                assert!(
                    off < within * scale,
                    "seed {seed} {name} at ({u}, {v}): {off:e}"
                );
            }
        }
    }
}

/// Quarter of a cylinder of radius `r` about the x axis, 100 mm long, seen from outside.
fn cylinder(r: f64) -> Nurbs<f64, 2, 3> {
    let arc = [(0.0, r, 1.0), (r, r, 0.5f64.sqrt()), (r, 0.0, 1.0)];
    let mut points = Vec::new();
    let mut weights = Vec::new();
    for x in [0.0, 100.0] {
        for (y, z, w) in arc {
            points.push(Vector::new(x, y, z));
            weights.push(w);
        }
    }
    let knots_u = [0.0, 0.0, 1.0, 1.0];
    let knots_v = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    Nurbs::new([1, 2], [2, 3], [&knots_u, &knots_v], &points, &weights).unwrap()
}

#[test]
fn a_cylinder_has_the_curvatures_of_a_cylinder_in_every_direction() {
    let surface = cylinder(80.0);
    let mut random = Random(3);
    for _ in 0..200 {
        let (u, v) = (random.between(0.0, 1.0), random.between(0.0, 1.0));
        let shape = surface.shape(u, v).unwrap();
        let (du, dv) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));

        let section = shape.along(du, dv).unwrap();

        // Euler: the feed stands at an angle to the axis.
        let (sin, cos) = (
            section.feed.dot(shape.normal.cross(Vector::X)),
            section.feed.x,
        );
        assert_close(section.k_f, sin * sin / 80.0, 1e-12);
        assert_close(section.k_c, cos * cos / 80.0, 1e-12);
        assert_close(
            section.tau,
            sin * section.cross.dot(shape.normal.cross(Vector::X)) / 80.0,
            1e-12,
        );
        assert_close(shape.principal()[0], 1.0 / 80.0, 1e-9);
        assert_close(shape.principal()[1], 0.0, 1e-9);
        assert_close(shape.normal.dot(shape.jet.s), 80.0, 1e-10);
    }
}

#[test]
fn a_reversed_normal_turns_bulges_into_hollows() {
    let outside = cylinder(80.0).shape(0.4, 0.3).unwrap();
    let inside = cylinder(80.0).reversed().shape(0.4, 0.3).unwrap();

    let (a, b) = (
        outside.along(0.2, 1.0).unwrap(),
        inside.along(0.2, 1.0).unwrap(),
    );

    assert!((outside.normal + inside.normal).norm() < 1e-15);
    assert!((a.cross + b.cross).norm() < 1e-15, "C = n x T turns with n");
    assert!((a.feed - b.feed).norm() < 1e-15);
    assert_close(b.k_f, -a.k_f, 1e-15);
    assert_close(b.k_c, -a.k_c, 1e-15);
    // Twist changes sign with the normal and once more with C.
    assert_close(b.tau, a.tau, 1e-15);
}

#[test]
fn the_slice_of_a_surface_has_its_points_and_normals() {
    let surface = Given::random(&mut Random(11)).build();
    let slice = surface.slice(0.7).unwrap();
    for k in 0..=20 {
        let v = 0.1 * f64::from(k);
        let shape = surface.shape(0.7, v).unwrap();

        let (s, n) = slice.place(v).unwrap();

        assert!((s - shape.jet.s).norm() < 1e-11);
        assert!((n - shape.normal).norm() < 1e-12);
    }
}

#[test]
fn beyond_its_edge_a_surface_is_continued_for_tool_centres_and_not_offered_as_surface() {
    let part = dune::<f64>().unwrap();
    let edge = part.jet(0.3, 1.0).unwrap();

    // Within 3 % the parabola, beyond it its tangent.
    for (beyond, bend) in [(0.02, 0.02), (0.03, 0.03), (0.1, 0.03)] {
        let shape = part.tool_shape(0.3, 1.0 + beyond).unwrap();
        let slope = edge.s_v + edge.s_vv * bend;
        let place =
            edge.s + edge.s_v * bend + edge.s_vv * (0.5 * bend * bend) + slope * (beyond - bend);
        assert!((shape.jet.s - place).norm() < 1e-10);
        assert!((shape.jet.s_v - slope).norm() < 1e-10);
        assert_eq!(shape.jet.s_vv, edge.s_vv);
    }
    assert_eq!(part.jet(0.3, 1.000_001), Err(NurbsError::OutOfDomain));
    assert_eq!(part.jet(f64::NAN, 0.5), Err(NurbsError::OutOfDomain));
}

#[test]
fn in_f32_points_normals_and_curvatures_keep_their_tolerances() {
    let (exact, single) = (dune::<f64>().unwrap(), dune::<f32>().unwrap());
    let mut random = Random(5);
    let mut worst = [0f64; 3];
    for _ in 0..4000 {
        let (u, v) = (
            random.between(0.0, 1.0) as f32,
            random.between(0.0, 1.0) as f32,
        );
        let (du, dv) = (
            random.between(-1.0, 1.0) as f32,
            random.between(-1.0, 1.0) as f32,
        );
        let wanted = exact.shape(u.into(), v.into()).unwrap();
        let found = single.shape(u, v).unwrap();
        let wide = |v: Vector<f32>| Vector::new(v.x.into(), v.y.into(), v.z.into());
        worst[0] = worst[0].max((wide(found.jet.s) - wanted.jet.s).norm());
        worst[1] = worst[1].max((wide(found.normal) - wanted.normal).norm());
        let (w, f) = (
            wanted.along(du.into(), dv.into()).unwrap(),
            found.along(du, dv).unwrap(),
        );
        for (w, f) in [(w.k_f, f.k_f), (w.k_c, f.k_c), (w.tau, f.tau)] {
            worst[2] = worst[2].max((f64::from(f) - w).abs() / (1e-3 * w.abs() + 1e-6));
        }
    }
    println!(
        "f32: S {:e} mm, normal {:e}, curvature {:.3} of its tolerance",
        worst[0], worst[1], worst[2]
    );
    assert!(
        worst[0] < 1e-4 && worst[1] < 1e-5 && worst[2] < 1.0,
        "{worst:?}"
    );
}

const STEEL: Material<f64> = Material {
    modulus: 206_000.0,
    poisson: 0.3,
};

/// Complete elliptic integrals K and E of the parameter m, by the trapezoid rule over a period: it converges as fast as
/// any series here.
fn elliptic(m: f64) -> (f64, f64) {
    let n = 20_000;
    let (mut k, mut e) = (0.0, 0.0);
    for i in 0..n {
        let sine = (PI * (f64::from(i) + 0.5) / f64::from(n)).sin();
        let root = (1.0 - m * sine * sine).sqrt();
        k += 1.0 / root;
        e += root;
    }
    let width = 0.5 * PI / f64::from(n);
    (k * width, e * width)
}

#[test]
fn the_ellipse_fulfils_the_classical_equations_with_elliptic_integrals() {
    // A flat wheel, so that the part's curvatures are the relative ones.
    let e_star = effective_modulus(STEEL, STEEL).unwrap();
    let flat = Wheel {
        rim: None,
        crown: None,
    };
    let hertz = Hertz::new(30.0, e_star, &flat).unwrap();
    for ratio in [1.0005, 1.02, 1.5, 3.0, 10.0, 100.0, 2e3, 1e5] {
        let (k_max, k_min) = (0.1, 0.1 / ratio);

        let c = hertz.at(k_max, k_min, 0.0).unwrap();

        let kappa = c.a / c.b;
        let (k, e) = elliptic(1.0 - 1.0 / (kappa * kappa));
        // (kappa^2 E - K)/(K - E) cancels near the circle: there the tolerance is wider.
        let found = (kappa * kappa * e - k) / (k - e);
        let within = 1e-9 + 1e-12 / (ratio - 1.0).powi(2);
        assert!(
            (found / ratio - 1.0).abs() < within,
            "ratio {ratio}: {found}"
        );
        // Load under the ellipsoid; approach 3 F K/(2 pi a E*); pressure E* b (k_max + k_min)/(2 E).
        assert_close(2.0 / 3.0 * PI * c.a * c.b * c.p0, 30.0, 1e-9);
        assert_close(
            c.approach / (1.5 * 30.0 * k / (PI * c.a * e_star)),
            1.0,
            1e-9,
        );
        assert_close(c.p0 / (e_star * c.b * 0.5 * (k_max + k_min) / e), 1.0, 1e-9);
    }
}

#[test]
fn two_balls_touch_in_the_circle_of_the_textbook() {
    let e_star = effective_modulus(STEEL, STEEL).unwrap();
    let ball = Wheel {
        rim: Some(20.0),
        crown: Some(20.0),
    };
    let hertz = Hertz::new(50.0, e_star, &ball).unwrap();

    let c = hertz.at(1.0 / 30.0, 1.0 / 30.0, 0.0).unwrap();

    let radius = 1.0 / (1.0 / 20.0 + 1.0 / 30.0);
    assert_close(c.a.powi(3), 3.0 * 50.0 * radius / (4.0 * e_star), 1e-12);
    assert_close(c.b, c.a, 1e-12);
    assert_close(c.approach, c.a * c.a / radius, 1e-12);
}

#[test]
fn turning_the_part_under_a_ball_turns_the_ellipse_and_nothing_else() {
    let e_star = effective_modulus(STEEL, STEEL).unwrap();
    let ball = Wheel {
        rim: Some(15.0),
        crown: Some(15.0),
    };
    let hertz = Hertz::new(30.0, e_star, &ball).unwrap();
    let (k1, k2) = (0.02, -0.03);
    let straight = hertz.at(k1, k2, 0.0).unwrap();
    for degrees in -89..=90 {
        let angle = f64::from(degrees).to_radians();
        let (sin, cos) = angle.sin_cos();

        let c = hertz
            .at(
                k1 * cos * cos + k2 * sin * sin,
                k1 * sin * sin + k2 * cos * cos,
                (k1 - k2) * sin * cos,
            )
            .unwrap();

        assert_close(c.a, straight.a, 1e-10);
        assert_close(c.b, straight.b, 1e-10);
        assert_close(c.psi(), angle, 1e-9);
        // Extent of x^2/a^2 + y^2/b^2 = 1 across and along, by looking for it.
        let extent = |across: bool| {
            (0..36_000)
                .map(|i| {
                    let t = f64::from(i) * PI / 18_000.0;
                    // b along k_max, which stands at the angle from the feed.
                    let (p, q) = (c.b * t.cos(), c.a * t.sin());
                    let (feed, cross) = (p * cos - q * sin, p * sin + q * cos);
                    if across { cross } else { feed }
                })
                .fold(0f64, f64::max)
        };
        assert_close(c.b_c / extent(true), 1.0, 2e-8);
        assert_close(c.a_f / extent(false), 1.0, 2e-8);
    }
}

#[test]
fn in_f32_the_ellipse_is_within_a_part_in_ten_thousand() {
    let exact = Grinding::new(&Job::<f64>::hard()).unwrap();
    let single = Grinding::new(&Job::<f32>::hard()).unwrap();
    let mut random = Random(9);
    let mut worst = 0f64;
    for _ in 0..5000 {
        let k: [f32; 3] = std::array::from_fn(|_| random.between(-0.015, 0.03) as f32);
        let Ok(w) = exact.hertz.at(k[0].into(), k[1].into(), k[2].into()) else {
            continue;
        };
        let f = single.hertz.at(k[0], k[1], k[2]).unwrap();
        for (w, f) in [
            (w.a, f.a),
            (w.b, f.b),
            (w.b_c, f.b_c),
            (w.a_f, f.a_f),
            (w.p0, f.p0),
            (w.approach, f.approach),
        ] {
            worst = worst.max((f64::from(f) / w - 1.0).abs());
        }
    }
    println!("f32: Hertz within {worst:e}");
    assert!(worst < 1e-4, "{worst:e}");
}

#[test]
fn a_flat_wheel_in_a_hollow_is_refused_and_never_clamped() {
    let flat = json!({"r_rim": null, "r_crown": null});
    let cylinder = json!({"r_crown": null});
    for (job, k_f, k_c, tau, error) in [
        (&flat, -0.01, -0.01, 0.0, "NoHertzContact"),
        (&flat, 0.0, 0.0, 0.0, "NoHertzContact"),
        (&flat, 0.01, 0.0, 0.0, "NoHertzContact"),
        (&flat, 0.01, -0.01, 0.0, "NoHertzContact"),
        (&cylinder, 0.0, 0.0, 0.0, "NoHertzContact"),
        (&cylinder, 0.0, -0.001, 0.0, "NoHertzContact"),
        (&json!("a"), 0.0, -0.02, 0.0, "NoHertzContact"),
        (&json!("a"), 0.0, 0.0, 0.05, "NoHertzContact"),
        (&cylinder, 0.0, 0.99e-7, 0.0, "LineContact"),
    ] {
        let request = json!({"job": job, "k_f": k_f, "k_c": k_c, "tau": tau});
        assert_eq!(ask("surface.hertz", &request)["error"], error, "{request}");
    }
    assert_eq!(
        ask("surface.hertz", &json!({"half_width": 0.2}))["error"],
        "FootprintTooLarge"
    );
    assert!(ask("surface.hertz", &json!({"half_width": 0.23}))["error"].is_null());
    // Just above the ratio of a line.
    assert!(ask("surface.hertz", &json!({"job": cylinder, "k_c": 1.01e-7}))["error"].is_null());
}

#[test]
fn the_stripe_is_what_the_moving_pressure_takes_away_at_any_angle() {
    let grinding = Grinding::new(&Job::<f64>::hard()).unwrap();
    for tau in [0.0, 0.01, -0.03] {
        let c = grinding.hertz.at(0.004, 0.001, tau).unwrap();
        let stripe = grinding.stripe(&c);
        let (sin, cos) = c.psi().sin_cos();
        for share in [0.0, 0.3, 0.8, 0.99] {
            let y = share * c.b_c;

            // dh = K p dx along the feed, with p the half ellipsoid, by midpoints.
            let n = 400_000;
            let width = 2.0 * c.a_f / f64::from(n);
            let removed: f64 = (0..n)
                .map(|i| {
                    let x = -c.a_f + (f64::from(i) + 0.5) * width;
                    let (p, q) = (x * cos + y * sin, y * cos - x * sin);
                    let inside = 1.0 - (p / c.b).powi(2) - (q / c.a).powi(2);
                    c.p0 * inside.max(0.0).sqrt() * width
                })
                .sum::<f64>()
                * grinding.removal.k_mpa;

            assert_close(stripe.depth(y) / removed, 1.0, 1e-5);
        }
        assert_eq!(stripe.depth(c.b_c), 0.0);
        assert_eq!(stripe.depth(-2.0 * c.b_c), 0.0);
    }
}

#[test]
fn a_feed_for_a_depth_grinds_that_depth_in_every_sense() {
    for sense in [Sense::Against, Sense::With, Sense::Neglected] {
        let removal = |feed| Removal::new(30.0, 5e-12, 10.0, 2800.0, feed, sense).unwrap();
        let (b_c, depth) = (0.2284, 0.1);

        let feed = removal(20.0).feed_for(b_c, depth).unwrap();
        let (passes, each) = removal(20.0).passes(b_c, depth).unwrap();

        assert_close(removal(feed).stripe(b_c).h0, depth, 1e-12);
        assert_close(
            removal(each).stripe(b_c).h0 * f64::from(passes),
            depth,
            1e-12,
        );
        assert_eq!(passes, (depth / removal(20.0).stripe(b_c).h0).ceil() as i32);
        let near = if sense == Sense::Neglected { 0.0 } else { 0.01 };
        assert_close(removal(20.0).speed / removal(20.0).rim_speed, 1.0, near);
    }
}

/// Largest height of the ground over the line through two groove centres, on a parabola of curvature `k`, looked for.
fn scallop(model: Model, stripe: Stripe<f64>, k: f64, d: f64) -> f64 {
    let n = 100_000;
    let end = stripe.h0 - heights(model, stripe, d, 0.0);
    (0..=n)
        .map(|i| {
            let y = d * f64::from(i) / f64::from(n);
            stripe.h0 - heights(model, stripe, d, y) + k * y * (d - y) / 2.0 - end
        })
        .fold(0.0, f64::max)
}

fn heights(model: Model, stripe: Stripe<f64>, d: f64, y: f64) -> f64 {
    let (a, b) = (stripe.depth(y), stripe.depth(y - d));
    match model {
        Model::Envelope => a.max(b),
        Model::Additive => a + b,
    }
}

#[test]
fn the_pitch_leaves_the_wanted_scallop_and_not_a_hair_more() {
    let mut random = Random(21);
    let mut looked_at = [0; 2];
    for _ in 0..400 {
        let stripe = Stripe {
            b_c: random.between(0.2, 2.0),
            h0: random.between(0.06, 0.2),
        };
        let (k, wanted) = (random.between(-0.015, 0.015), random.between(0.02, 0.05));
        for (i, model) in [Model::Envelope, Model::Additive].into_iter().enumerate() {
            let Ok(pitch) = pitch(model, stripe, k, wanted) else {
                continue;
            };
            if pitch.touching {
                assert!(scallop(model, stripe, k, pitch.d) <= wanted + 1e-9);
                continue;
            }
            assert_close(scallop(model, stripe, k, pitch.d), wanted, 2e-6);
            looked_at[i] += 1;
        }
    }
    assert!(looked_at[0] > 300 && looked_at[1] > 50, "{looked_at:?}");
}

#[test]
fn spacing_refuses_what_no_pitch_can_reach() {
    for (request, error) in [
        (json!({"b_c": 0.2, "h0": 0.04}), "TooShallow"),
        (json!({"b_c": 0.2, "h0": 0.03}), "TooShallow"),
        (
            json!({"b_c": 0.2, "h0": 0.24, "model": "additive"}),
            "AdditiveBranch",
        ),
        (json!({"b_c": 0.0, "h0": 0.1}), "BadParameter"),
        (json!({"b_c": 0.2, "h0": "inf"}), "BadParameter"),
        (json!({"b_c": 0.2, "h0": 0.1, "k_c": "nan"}), "BadParameter"),
        (
            json!({"b_c": 0.2, "h0": 0.1, "scallop": -1}),
            "BadParameter",
        ),
        (json!({"b_c": 0.2, "h0": 0.1, "margin": 1}), "BadParameter"),
    ] {
        assert_eq!(
            ask("surface.spacing", &request)["error"],
            error,
            "{request}"
        );
    }
    // 0.1716 of the depth is the limit on a flat.
    let at =
        |share: f64| json!({"b_c": 0.2, "h0": 0.2, "scallop": 0.2 * share, "model": "additive"});
    assert_eq!(
        ask("surface.spacing", &at(0.1715))["error"],
        "AdditiveBranch"
    );
    assert!(ask("surface.spacing", &at(0.1717))["error"].is_null());
    // A hollow so deep that stripes only touch.
    let touching = ask(
        "surface.spacing",
        &json!({"b_c": 1.4, "h0": 0.09, "k_c": -0.06}),
    );
    assert_eq!(touching["pitch"], 2.8);
    assert_eq!(touching["touching"], true);
    assert_eq!(touching["exact"], Value::Null);
}

#[test]
fn a_step_keeps_every_limit_and_names_the_one_that_binds() {
    let limits = StepLimits {
        eps: 0.1,
        l_max: 20.0,
        turn: 10f64.to_radians(),
        e_lat: Some(0.003),
    };
    let mut seen = Vec::new();
    let mut random = Random(4);
    for _ in 0..2000 {
        let size = 10f64.powf(random.between(-5.0, 0.5));
        let (k_n, k_g) = (
            size * random.between(-1.0, 1.0),
            0.1 * size * random.between(-1.0, 1.0),
        );

        let step = limits.step(k_n, k_g).unwrap();

        // Sag of a chord L on a circle: R - sqrt(R^2 - L^2/4), stretched to its stable form.
        let sag = |k: f64| {
            let x = k.abs() * step.length / 2.0;
            step.length * x / 2.0 / (1.0 + (1.0 - x * x).max(0.0).sqrt())
        };
        let figures = [
            (Limit::LMax, step.length / 20.0),
            (Limit::Chord, sag(k_n.hypot(k_g)) / 0.1),
            (
                Limit::Turn,
                2.0 * (k_n.abs() * step.length / 2.0).min(1.0).asin() / limits.turn,
            ),
            (Limit::Lateral, sag(k_g) / 0.003),
        ];
        for (limit, used) in figures {
            assert!(
                used < 1.0 + 1e-6,
                "{limit:?} exceeded at {k_n} {k_g}: {used}"
            );
            if limit == step.limit {
                assert!(
                    used > 1.0 - 1e-6,
                    "{limit:?} does not bind at {k_n} {k_g}: {used}"
                );
            }
        }
        if !seen.contains(&step.limit) {
            seen.push(step.limit);
        }
    }
    assert_eq!(seen.len(), 4, "{seen:?}");
    assert_eq!(ask("surface.step", &json!({}))["limited_by"], "l_max");
    assert_eq!(
        ask(
            "surface.step",
            &json!({"k_n": 100, "eps": 0.01, "turn": 300})
        )["step"],
        0.02
    );
    for (field, value) in [
        ("eps", json!(0)),
        ("l_max", json!("nan")),
        ("turn", json!(-1)),
        ("k_n", json!("inf")),
        ("e_lat", json!(0)),
    ] {
        let fault = ask("surface.step", &json!({field: value}));
        assert_eq!(fault["error"], "BadParameter");
        assert_eq!(fault["field"], field);
    }
}

#[test]
fn the_wheel_stands_on_the_part_with_its_axle_across() {
    let part = dune::<f64>().unwrap();
    let work = Pose {
        rotation: Rotation::about(Vector::Z, 0.3),
        p: Vector::new(340.0, -75.0, 300.0),
    };
    let shape = part.shape(0.33, 0.66).unwrap();
    let section = shape.along(1.0, 0.25).unwrap();

    let tool = tool_pose(&shape, &section).unwrap();
    let hand = flange(&work, &tool, 110.0).unwrap();

    let r = tool.rotation;
    assert!((r.n - section.feed).norm() < 1e-15);
    assert!((r.a + shape.normal).norm() < 1e-15);
    assert!((r.s - r.a.cross(r.n)).norm() < 1e-12);
    assert!((r.s + section.cross).norm() < 1e-12);
    // The wheel's contact point seen from the hand.
    assert!((hand.apply(Vector::new(0.0, 0.0, 110.0)) - work.apply(shape.jet.s)).norm() < 1e-12);
    let sheared = Pose {
        rotation: Rotation {
            s: r.n,
            ..tool.rotation
        },
        ..tool
    };
    assert_eq!(
        flange(&work, &sheared, 110.0).unwrap_err().name(),
        "BadPose"
    );
}

fn plane() -> Value {
    json!({
        "degree_u": 1, "degree_v": 1, "knots_u": [0, 0, 1, 1], "knots_v": [0, 0, 1, 1],
        "points": [[[0, 0, 0], [0, 3, 0]], [[10, 0, 0], [10, 3, 0]]],
    })
}

#[test]
fn a_surface_that_is_none_is_refused_by_name_and_field() {
    let cases = [
        ("degree_u", json!(0), "BadDegree", "degree_u"),
        ("degree_v", json!(6), "BadDegree", "degree_v"),
        ("degree_u", json!(-1), "BadDegree", "degree_u"),
        ("degree_u", json!(2), "BadNet", "points"),
        ("points", json!([]), "BadNet", "points"),
        ("points", json!([[], []]), "BadNet", "points"),
        (
            "points",
            json!([[[0, 0, 0]], [[1, 0, 0]]]),
            "BadNet",
            "points",
        ),
        (
            "points",
            json!([[[0, 0, 0], [0, 3, 0]], [[10, 0, 0]]]),
            "BadNet",
            "points",
        ),
        // As many points as a rectangle would have.
        (
            "points",
            json!([
                [[0, 0, 0], [0, 3, 0]],
                [[10, 0, 0], [9, 0, 0], [8, 0, 0]],
                [[10, 3, 0]]
            ]),
            "BadNet",
            "points",
        ),
        (
            "points",
            json!([[[0, 0, "nan"], [0, 3, 0]], [[10, 0, 0], [10, 3, 0]]]),
            "BadNet",
            "points",
        ),
        (
            "points",
            json!([[[0, 0, 0], [0, 3, 0]], [[10, 0, 0], [10, "inf", 0]]]),
            "BadNet",
            "points",
        ),
        ("weights", json!([[1, 1]]), "BadNet", "points"),
        ("knots_u", json!([0, 0, 1]), "BadKnots", "knots_u"),
        ("knots_v", json!([0, 0, 1, 1, 1]), "BadKnots", "knots_v"),
        ("knots_u", json!([0, 0.5, 1, 1]), "BadKnots", "knots_u"),
        ("knots_u", json!([0, 0, 1, 2]), "BadKnots", "knots_u"),
        ("knots_u", json!([0, 0, 0, 0]), "BadKnots", "knots_u"),
        ("knots_u", json!([1, 1, 0, 0]), "BadKnots", "knots_u"),
        (
            "knots_u",
            json!([0, 0, "inf", "inf"]),
            "BadKnots",
            "knots_u",
        ),
        ("weights", json!([[1, 0], [1, 1]]), "BadWeight", "weights"),
        ("weights", json!([[1, 1], [-2, 1]]), "BadWeight", "weights"),
        (
            "weights",
            json!([[1, 1], [1, "nan"]]),
            "BadWeight",
            "weights",
        ),
    ];
    for (key, value, error, field) in cases {
        let mut surface = plane();
        surface[key] = value;
        for call in ["surface.nurbs", "surface.plan"] {
            let mut request = json!({"surface": surface});
            if call == "surface.nurbs" {
                request["uv"] = json!([[0.5, 0.5]]);
            }
            let fault = ask(call, &request);
            assert_eq!(
                (&fault["error"], &fault["field"]),
                (&json!(error), &json!(field)),
                "{call} {request}"
            );
        }
    }
    let many: Vec<_> = (0..33).map(|j| json!([0, j, 0])).collect();
    let wide = json!({
        "degree_u": 1, "degree_v": 1, "knots_u": [0, 0, 1, 1], "knots_v": (0..35).collect::<Vec<_>>(),
        "points": [many, many],
    });
    assert_eq!(
        ask("surface.nurbs", &json!({"surface": wide, "uv": []}))["error"],
        "BadNet"
    );
    // Three equal knots inside a quadric, which may have two.
    let knots = json!([0, 0, 0, 0.5, 0.5, 0.5, 1, 1, 1]);
    let row: Vec<_> = (0..6).map(|j| json!([0, j, 0])).collect();
    let other: Vec<_> = (0..6).map(|j| json!([1, j, 0])).collect();
    let torn = json!({"degree_u": 1, "degree_v": 2, "knots_u": [0, 0, 1, 1], "knots_v": knots, "points": [row, other]});
    assert_eq!(
        ask("surface.nurbs", &json!({"surface": torn, "uv": []}))["error"],
        "BadKnots"
    );
}

#[test]
fn a_place_without_surface_or_normal_is_refused_with_its_index() {
    let fault = ask("surface.nurbs", &json!({"uv": [[0.5, 0.5], [0.5, 1.001]]}));
    assert_eq!(
        (&fault["error"], &fault["index"]),
        (&json!("OutOfDomain"), &json!(1))
    );
    let fault = ask("surface.nurbs", &json!({"uv": [["nan", 0.5]]}));
    assert_eq!(
        (&fault["error"], &fault["index"]),
        (&json!("OutOfDomain"), &json!(0))
    );
    let mut cone = plane();
    cone["points"] = json!([[[0, 0, 0], [0, 0, 0]], [[10, 0, 0], [10, 3, 0]]]);
    let fault = ask(
        "surface.nurbs",
        &json!({"surface": cone, "uv": [[0.5, 0.5], [0, 0.5]]}),
    );
    assert_eq!(
        (&fault["error"], &fault["index"]),
        (&json!("DegenerateNormal"), &json!(1))
    );
    let fault = ask(
        "surface.nurbs",
        &json!({"uv": [[0.5, 0.5]], "direction": [0, 1e-7]}),
    );
    assert_eq!(
        (&fault["error"], &fault["field"]),
        (&json!("BadParameter"), &json!("direction"))
    );
}

#[test]
fn a_bad_job_is_refused_by_name_and_field_before_anything_is_computed() {
    let cases = [
        ("e1", json!(0), "BadMaterial"),
        ("e2", json!("inf"), "BadMaterial"),
        ("nu1", json!(0.51), "BadMaterial"),
        ("nu2", json!(-0.1), "BadMaterial"),
        ("nu2", json!("nan"), "BadMaterial"),
        ("force", json!(0), "BadParameter"),
        ("k", json!(-1), "BadParameter"),
        ("rpm", json!("nan"), "BadParameter"),
        ("feed", json!(0), "BadParameter"),
        ("scallop", json!(0), "BadParameter"),
        ("margin", json!(1), "BadParameter"),
        ("margin", json!(-0.1), "BadParameter"),
        ("eps", json!(0), "BadParameter"),
        ("e_lat", json!(0), "BadParameter"),
        ("e_gap", json!("inf"), "BadParameter"),
        ("l_max", json!(-20), "BadParameter"),
        ("turn", json!(0), "BadParameter"),
        ("r_rim", json!(0), "BadParameter"),
        ("r_crown", json!("nan"), "BadParameter"),
        ("depth", json!(0), "BadParameter"),
        ("sense", json!(2), "BadParameter"),
        ("model", json!("sum"), "BadParameter"),
        ("depth_mode", json!("deep"), "BadParameter"),
        ("strategy", json!("spiral"), "BadParameter"),
        ("step_mode", json!("none"), "BadParameter"),
        ("nodes", json!(4), "BadParameter"),
        ("nodes", json!(4002), "BadParameter"),
        ("seed", json!(1.01), "BadParameter"),
        ("seed", json!("nan"), "BadParameter"),
        ("rows", json!(1), "BadParameter"),
        ("rows", json!(20_001), "BadParameter"),
        ("colour", json!(1), "BadParameter"),
    ];
    for (field, value, error) in cases {
        for call in ["surface.hertz", "surface.plan"] {
            let request = json!({"job": {field: value}});
            let fault = ask(call, &request);
            assert_eq!(
                (&fault["error"], &fault["field"]),
                (&json!(error), &json!(field)),
                "{call} {request}"
            );
        }
    }
    let fault = |job: Value| ask("surface.plan", &json!({"job": job}));
    assert_eq!(fault(json!({"strategy": "iso"}))["field"], "rows");
    // Materials come first in the table; wrong types and unknown presets before it.
    assert_eq!(fault(json!({"colour": 1, "e1": 0}))["error"], "BadMaterial");
    assert_eq!(
        fault(json!({"e1": 0, "force": "much"}))["error"],
        "WrongType"
    );
    assert_eq!(fault(json!("c"))["error"], "UnknownName");
    assert_eq!(fault(json!({"preset": "c"}))["error"], "UnknownName");
    assert_eq!(fault(json!(7))["error"], "WrongType");
}

#[test]
fn a_null_radius_is_a_flat_wheel_and_its_rim_that_of_10_mm() {
    let flat = ask(
        "surface.removal",
        &json!({"job": {"r_rim": null}, "k_f": 0.1}),
    );
    let round = ask("surface.removal", &json!({"job": "a"}));

    assert_eq!(flat["v_s"], round["v_s"]);
    assert_eq!(flat["b_c"], round["b_c"]);
    let bare = ask(
        "surface.hertz",
        &json!({"job": {"preset": null, "r_crown": null}, "k_c": 0.02}),
    );
    assert_eq!(bare["b_c"], round["b_c"]);
}
