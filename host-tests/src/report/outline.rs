//! A ground drill -> drawings: plan, side view, and the error of its flank.

use super::ground::{GroundDrill, HEEL};
use crate::plot::{Chart, Drawing, PALETTE, Pen, number};

const LIP: Pen<'_> = Pen {
    colour: "#0b6fb8",
    width: 2.2,
    ..Pen::EDGE
};
const CHISEL: Pen<'_> = Pen {
    colour: "#c0182b",
    width: 2.2,
    ..Pen::EDGE
};
const CONTOUR: Pen<'_> = Pen {
    colour: "#c9d2dc",
    width: 0.7,
    ..Pen::THIN
};

impl GroundDrill {
    /// Half the web, the radius, the corner's x, and where the chisel edge ends [mm].
    fn frame(&self) -> (f64, f64, f64, f64) {
        let (r0, r) = self.simulation.dimensions();
        let corner = (r * r - r0 * r0).sqrt();
        let end = self.measured.chisel_end.unwrap_or(self.solution.chisel_end);
        (r0, r, corner, end)
    }

    /// Seen along the drill's axis onto the point: lips, chisel edge, heels, lines of equal height. The drill's z points
    /// away from the viewer, so that with x to the right y points down; lip 1 lies to the right, above the axis.
    pub fn plan(&self, width: f64) -> String {
        let (r0, r, corner, end) = self.frame();
        let seen = |x: f64, y: f64| (x, -y);
        let mut drawing = Drawing::new("Plan, seen onto the point", width);
        for line in self.contours(0.25) {
            drawing = drawing.line(line.into_iter().map(|(x, y)| seen(x, y)), CONTOUR);
        }
        let heel = HEEL - (r0 / r).asin();
        for side in [1.0, -1.0] {
            let heel_line = [
                seen(side * r * heel.cos(), side * r * heel.sin()),
                seen(-side * end, side * r0),
            ];
            let lip = [
                seen(side * end, -side * r0),
                seen(side * corner, -side * r0),
            ];
            drawing = drawing.line(heel_line, Pen::THIN).line(lip, LIP);
        }
        let edge = self.simulation.chisel_edge(41);
        let angle = self
            .wanted
            .ground()
            .map_or(0.0, |ground| ground.chisel_angle);
        // The tangent at the tip, in which the chisel angle is measured; the edge itself is slightly S-shaped.
        let tangent = seen(0.62 * r * angle.cos(), -0.62 * r * angle.sin());
        let web = self.web.unwrap_or(2.0 * r0);
        drawing
            .circle((0.0, 0.0), r, Pen::EDGE)
            .line([(-1.12 * r, 0.0), (1.12 * r, 0.0)], Pen::CENTRE)
            .line([(0.0, -1.12 * r), (0.0, 1.12 * r)], Pen::CENTRE)
            .line([(0.0, 0.0), tangent], Pen::THIN)
            .line([seen(-0.78 * r, -r0), seen(end, -r0)], Pen::THIN)
            .line(edge.iter().map(|p| seen(p[0], p[1])), CHISEL)
            .angle(
                (0.0, 0.0),
                0.52 * r,
                0.0,
                angle,
                &self.shown_angle("chisel edge angle"),
            )
            .dimension(seen(-0.72 * r, r0), seen(-0.72 * r, -r0), &number(web, 3))
            .text_right_of(seen(1.03 * r, -r0), "lip 1")
            .text_left_of(seen(-1.03 * r, r0), "lip 2")
            .text(seen(0.42 * r, 0.5 * r), "flank 1")
            .text(seen(-0.42 * r, -0.5 * r), "flank 2")
            .svg()
    }

    /// A measured angle as it stands in a drawing.
    fn shown_angle(&self, name: &str) -> String {
        let feature = self
            .geometry()
            .into_iter()
            .find(|feature| feature.name == name);
        match feature.and_then(|feature| feature.found) {
            Some(found) => format!("{}°", number(found, 2)),
            None => "?".into(),
        }
    }

    /// Seen at right angles to the lips: point angle, chisel edge, and the circumference of both flanks.
    pub fn side(&self, width: f64) -> String {
        let (r0, r, corner, end) = self.frame();
        let height = |x: f64, y: f64| self.simulation.height(x, y);
        let shank = height(corner, -r0) + 0.55 * r;
        // The point looks up.
        let up = |x: f64, z: f64| (x, -z);
        let mut drawing = Drawing::new("Side view, at right angles to the lips", width);
        for side in [1.0, -1.0] {
            let rim = (0..=60).map(|k| {
                let azimuth = HEEL * f64::from(k) / 60.0 - (r0 / r).asin();
                let (x, y) = (side * r * azimuth.cos(), side * r * azimuth.sin());
                up(x, height(x, y))
            });
            let lip = (0..=20).map(|k| {
                let x = end + (corner - end) * f64::from(k) / 20.0;
                up(side * x, height(side * x, -side * r0))
            });
            drawing = drawing
                .line(rim, Pen::THIN)
                .line(
                    [up(side * r, height(corner, -r0)), up(side * r, shank)],
                    Pen::EDGE,
                )
                .line(lip, LIP);
        }
        let edge = self.simulation.chisel_edge(41);
        let half = self.measured.point_angle / 2.0;
        // Where the two lips, drawn on, meet on the axis.
        let lip_height = height(corner, -r0);
        let meet = lip_height - corner / half.tan();
        let down = -std::f64::consts::FRAC_PI_2;
        // As wide as the plan beside it, so that both have one scale.
        let unseen = Pen {
            colour: "none",
            ..Pen::THIN
        };
        drawing
            .line([up(-1.12 * r, shank), up(1.12 * r, shank)], unseen)
            .line([up(0.0, meet - 0.06 * r), up(0.0, shank)], Pen::CENTRE)
            .line(
                [
                    up(-end, height(-end, r0)),
                    up(0.0, meet),
                    up(end, height(end, -r0)),
                ],
                Pen::THIN,
            )
            .line(edge.iter().map(|p| up(p[0], p[2])), CHISEL)
            .angle(
                up(0.0, meet),
                0.62 * r,
                down - half,
                down + half,
                &self.shown_angle("point angle"),
            )
            .dimension(
                up(-r, shank - 0.1 * r),
                up(r, shank - 0.1 * r),
                &number(2.0 * r, 3),
            )
            .svg()
    }

    /// The circumference unrolled from the corner to the heel: height over arc, wanted and ground.
    pub fn rim_chart(&self) -> String {
        let (r0, r, corner, _) = self.frame();
        let start = -(r0 / r).asin();
        let place = |k: i32| {
            let angle = HEEL * f64::from(k) / 240.0;
            (
                angle.to_degrees(),
                r * (start + angle).cos(),
                r * (start + angle).sin(),
            )
        };
        let wanted_at = |x: f64, y: f64| self.wanted.surface(x, y).map_or(f64::NAN, |s| s.z);
        let zero = wanted_at(corner, -r0);
        let tip = self.solution.cone.tip.z;
        let wanted = (0..=240).map(|k| {
            let (angle, x, y) = place(k);
            (angle, wanted_at(x, y) - zero)
        });
        let ground = (0..=240).map(|k| {
            let (angle, x, y) = place(k);
            (angle, self.simulation.flank(0, x, y) + tip - zero)
        });
        Chart::new(
            "Flank 1 on the circumference, from the corner to the heel",
            "plan angle behind the corner [deg]",
            "towards the shank [mm]",
        )
        .size(860.0, 220.0)
        .line("wanted", "#aab2bb", wanted)
        .line("ground", PALETTE[0], ground)
        .svg()
    }

    /// The flank's error along the lip and along the circumference.
    pub fn error_chart(&self) -> String {
        let (r0, r, corner, end) = self.frame();
        let start = -(r0 / r).asin();
        let micrometres = |x: f64, y: f64| self.flank_error(x, y).map_or(f64::NAN, |e| e * 1e3);
        let lip = (0..=400).map(|k| {
            let share = f64::from(k) / 400.0;
            (share, micrometres(end + share * (corner - end), -r0))
        });
        let rim = (0..=400).map(|k| {
            let share = f64::from(k) / 400.0;
            let angle = start + share * HEEL;
            (share, micrometres(r * angle.cos(), r * angle.sin()))
        });
        let middle = (0..=400).map(|k| {
            let share = f64::from(k) / 400.0;
            let angle = start + share * HEEL;
            let half = 0.5 * r;
            (share, micrometres(half * angle.cos(), half * angle.sin()))
        });
        Chart::new(
            "Error of flank 1, ground less wanted",
            "share of the way: lip from chisel edge to corner, arcs from lip to heel",
            "towards the shank [µm]",
        )
        .size(860.0, 220.0)
        .line("along the lip", PALETTE[0], lip)
        .line("on half the radius", PALETTE[2], middle)
        .line("on the circumference", PALETTE[1], rim)
        .svg()
    }

    /// Lines of equal height of both flanks inside the circumference, `step` mm apart.
    fn contours(&self, step: f64) -> Vec<Vec<(f64, f64)>> {
        let (_, r) = self.simulation.dimensions();
        const CELLS: i32 = 72;
        let place = |i: i32| (2.0 * f64::from(i) / f64::from(CELLS) - 1.0) * r;
        let heights: Vec<Vec<f64>> = (0..=CELLS)
            .map(|j| {
                (0..=CELLS)
                    .map(|i| self.simulation.height(place(i), place(j)))
                    .collect()
            })
            .collect();
        let mut lines = Vec::new();
        for j in 0..CELLS as usize {
            for i in 0..CELLS as usize {
                let corner = |di: usize, dj: usize| {
                    let (x, y) = (place((i + di) as i32), place((j + dj) as i32));
                    (x, y, heights[j + dj][i + di])
                };
                // Two triangles a cell: each is cut by a level along one straight line.
                for triangle in [
                    [corner(0, 0), corner(1, 0), corner(1, 1)],
                    [corner(0, 0), corner(1, 1), corner(0, 1)],
                ] {
                    if triangle.iter().all(|p| p.0.hypot(p.1) <= r) {
                        cut_triangle(&triangle, step, &mut lines);
                    }
                }
            }
        }
        lines
    }
}

/// The pieces of level lines inside a triangle of points (x, y, height).
fn cut_triangle(triangle: &[(f64, f64, f64); 3], step: f64, lines: &mut Vec<Vec<(f64, f64)>>) {
    let heights = triangle.map(|p| p.2);
    let lo = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let hi = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !lo.is_finite() || !hi.is_finite() {
        return;
    }
    for level in (lo / step).ceil() as i64..=(hi / step).floor() as i64 {
        let z = level as f64 * step;
        let mut ends = Vec::with_capacity(2);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (p, q) = (triangle[a], triangle[b]);
            if (p.2 < z) != (q.2 < z) {
                let share = (z - p.2) / (q.2 - p.2);
                ends.push((p.0 + share * (q.0 - p.0), p.1 + share * (q.1 - p.1)));
            }
        }
        if ends.len() == 2 {
            lines.push(ends);
        }
    }
}
