//! Joint values -> the ground drill: simulated grinding.
//!
//! The wheel is a plane, fixed in the machine. At every joint vector the drill stands somewhere, and what lies behind
//! the plane is gone. In the drill's own frame each joint vector is thus one cut, a half-space `z >= h0 + hx x + hy y`,
//! and the ground point is the upper envelope of all cuts. Geometry is measured on that envelope by differences of
//! heights, as one would measure a drill, and not by the formulas that made it.
//!
//! Drill frame: tip-centred, z from tip to shank, lip 1 along +x at y = -r0. Lengths in mm, angles in rad. Joints
//! `d1, d2, d3, theta1, theta2, theta3` in mm and rad.

type Matrix = [[f64; 3]; 3];
type Vec3 = [f64; 3];

/// The arm, as the joint values mean it.
#[derive(Clone, Copy, Debug)]
pub struct Arm {
    /// Full point angle to which the table is swivelled [rad].
    pub point_angle: f64,
    pub l1: f64,
    pub l2: f64,
}

/// The wheel's plane, in the machine frame; material survives on the side to which the normal points.
#[derive(Clone, Copy, Debug)]
pub struct Wheel {
    pub normal: Vec3,
    pub point: Vec3,
}

/// One half-space of the drill's frame, `z >= h0 + hx x + hy y`.
#[derive(Clone, Copy, Debug)]
struct Cut {
    h0: f64,
    hx: f64,
    hy: f64,
}

/// The drill under the wheel.
#[derive(Clone, Debug)]
pub struct Simulation {
    arm: Arm,
    wheel: Wheel,
    radius: f64,
    half_web: f64,
    /// Cuts of flank 1 and of flank 2.
    cuts: [Vec<Cut>; 2],
    /// Joint vectors at which the wheel would have come from the shank's side.
    reversed: usize,
}

/// What the ground drill measures; lengths in mm, angles in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Full point angle, from the slope of the lip at the corner.
    pub point_angle: f64,
    pub chisel_angle: f64,
    /// Lip clearance at the outer corner.
    pub clearance: f64,
    /// Circumferential clearance 60 deg behind the corner.
    pub heel_clearance: f64,
    /// The tip above where it should be; positive means ground too far.
    pub tip_height: f64,
    /// Half the chisel edge's length along the lip; `None` if the flanks do not meet on the lips.
    pub chisel_end: Option<f64>,
    pub chisel_length: Option<f64>,
    /// Height of lip 1 less that of lip 2 at the corner.
    pub lip_height_difference: f64,
}

impl Arm {
    /// Rotation and tip at a joint vector, by products of elementary matrices.
    pub fn forward(&self, joints: &[f64; 6]) -> (Matrix, Vec3) {
        let [d1, d2, d3, t1, t2, t3] = *joints;
        let z = [
            [t1.cos(), -t1.sin(), 0.0],
            [t1.sin(), t1.cos(), 0.0],
            [0.0, 0.0, 1.0],
        ];
        let y = [
            [t2.cos(), 0.0, t2.sin()],
            [0.0, 1.0, 0.0],
            [-t2.sin(), 0.0, t2.cos()],
        ];
        let x = [
            [1.0, 0.0, 0.0],
            [0.0, t3.cos(), -t3.sin()],
            [0.0, t3.sin(), t3.cos()],
        ];
        let rotation = product(&product(&z, &y), &x);
        let half = self.point_angle / 2.0;
        let slides = [
            half.sin() * d2 - half.cos() * d3,
            half.cos() * d2 + half.sin() * d3,
            d1,
        ];
        let offset = apply(&z, &[0.0, -self.l2, 0.0]);
        let drill = apply(&rotation, &[-self.l1, 0.0, 0.0]);
        let tip = std::array::from_fn(|i| slides[i] + offset[i] + drill[i]);
        (rotation, tip)
    }
}

impl Wheel {
    /// The plane that holds the lip of a drill at home: through the apex, its slope across the lip `m`.
    /// `from_apex` is the tip from the apex in the lip frame, (X, Y, Z) [mm].
    pub fn set_up(arm: &Arm, m: f64, from_apex: Vec3) -> Self {
        let half = arm.point_angle / 2.0;
        let (s, c) = half.sin_cos();
        let q = (1.0 + m * m * s * s).sqrt();
        let (_, home) = arm.forward(&[0.0; 6]);
        let apex = machine_axes([-from_apex[0], -from_apex[1], -from_apex[2]]);
        Self {
            normal: machine_axes([-c / q, -m * s / q, s / q]),
            point: std::array::from_fn(|i| home[i] + apex[i]),
        }
    }
}

impl Simulation {
    pub fn new(arm: Arm, wheel: Wheel, diameter: f64, web: f64) -> Self {
        Self {
            arm,
            wheel,
            radius: diameter / 2.0,
            half_web: web / 2.0,
            cuts: [Vec::new(), Vec::new()],
            reversed: 0,
        }
    }

    /// Lets the wheel cut at one joint vector [mm, rad].
    pub fn cut(&mut self, joints: &[f64; 6]) {
        let (rotation, tip) = self.arm.forward(joints);
        let n = self.wheel.normal;
        // The plane's normal seen from the drill, and the tip's distance from the plane.
        let seen: Vec3 = std::array::from_fn(|i| (0..3).map(|j| n[j] * rotation[j][i]).sum());
        let distance: f64 = (0..3).map(|i| n[i] * (tip[i] - self.wheel.point[i])).sum();
        if seen[0] <= 0.0 {
            self.reversed += 1;
            return;
        }
        // A drill point (x, y, z) is (z, -x, -y) in machine axes.
        let cut = Cut {
            h0: -distance / seen[0],
            hx: seen[1] / seen[0],
            hy: seen[2] / seen[0],
        };
        // Flank 1 rises from its lip at azimuth 0 to its heel at less than 140 deg; flank 2 the other way.
        let (sin, cos) = 50f64.to_radians().sin_cos();
        let second = cut.hx * cos + cut.hy * sin < 0.0;
        self.cuts[usize::from(second)].push(cut);
    }

    /// Height of one flank over (x, y): flank 0 is the first [mm]. Minus infinity where nothing has cut yet.
    pub fn flank(&self, flank: usize, x: f64, y: f64) -> f64 {
        let heights = self.cuts[flank]
            .iter()
            .map(|cut| cut.h0 + cut.hx * x + cut.hy * y);
        heights.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Height of the ground point over (x, y) [mm].
    pub fn height(&self, x: f64, y: f64) -> f64 {
        self.flank(0, x, y).max(self.flank(1, x, y))
    }

    /// How many joint vectors brought the wheel from the shank's side; 0 in any sane motion.
    pub fn reversed(&self) -> usize {
        self.reversed
    }

    /// Half the web, and half the diameter [mm].
    pub fn dimensions(&self) -> (f64, f64) {
        (self.half_web, self.radius)
    }

    /// Slopes of flank 1 at (x, y), from heights `reach` apart on either side.
    fn slopes(&self, x: f64, y: f64) -> (f64, f64) {
        // Wide enough that the facets of samples 0.1 deg apart do not show, narrow enough for the flank's curvature.
        let reach = self.radius / 100.0;
        let difference = |dx: f64, dy: f64| {
            (self.flank(0, x + dx, y + dy) - self.flank(0, x - dx, y - dy)) / (2.0 * reach)
        };
        (difference(reach, 0.0), difference(0.0, reach))
    }

    pub fn measure(&self) -> Measured {
        let (r, r0) = (self.radius, self.half_web);
        let corner = (r * r - r0 * r0).sqrt();
        let (lip, across) = self.slopes(corner, -r0);
        let (tip_x, tip_y) = self.slopes(0.0, 0.0);
        let azimuth = 60f64.to_radians() - (r0 / r).asin();
        let (sin, cos) = azimuth.sin_cos();
        let (heel_x, heel_y) = self.slopes(r * cos, r * sin);
        let chisel_end = self.chisel_point(-r0);
        Measured {
            point_angle: 2.0 * 1f64.atan2(lip),
            chisel_angle: tip_x.atan2(tip_y),
            clearance: ((lip * r0 + across * corner) / r).atan(),
            heel_clearance: (heel_y * cos - heel_x * sin).atan(),
            tip_height: self.flank(0, 0.0, 0.0),
            chisel_end,
            chisel_length: chisel_end.map(|x| 2.0 * x.hypot(r0)),
            lip_height_difference: self.flank(0, corner, -r0) - self.flank(1, -corner, r0),
        }
    }

    /// The chisel edge in plan view, from lip 1 to lip 2: points (x, y, z) where both flanks are equally high [mm].
    pub fn chisel_edge(&self, points: usize) -> Vec<Vec3> {
        let last = points.saturating_sub(1).max(1) as f64;
        let rows = (0..points).map(|i| self.half_web * (2.0 * i as f64 / last - 1.0));
        rows.filter_map(|y| {
            let x = self.chisel_point(y)?;
            Some([x, y, self.flank(0, x, y)])
        })
        .collect()
    }

    /// Where the flanks are equally high on the line of this y: between the lips, nearest to the middle.
    fn chisel_point(&self, y: f64) -> Option<f64> {
        let difference = |x: f64| self.flank(0, x, y) - self.flank(1, x, y);
        let reach = (self.radius * self.radius - self.half_web * self.half_web).sqrt();
        // Flank 1 falls towards -x and rises towards +x.
        let (mut lo, mut hi) = (-reach, reach);
        let brackets = difference(lo) < 0.0 && difference(hi) > 0.0;
        if !brackets {
            return None;
        }
        for _ in 0..60 {
            let mid = (lo + hi) / 2.0;
            if difference(mid) < 0.0 {
                lo = mid;
            } else {
                hi = mid;
            }
        }
        Some(hi)
    }
}

/// A vector of the lip frame in machine axes at home.
fn machine_axes([x, y, z]: Vec3) -> Vec3 {
    [z, -x, -y]
}

fn apply(m: &Matrix, v: &Vec3) -> Vec3 {
    std::array::from_fn(|i| (0..3).map(|j| m[i][j] * v[j]).sum())
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}
