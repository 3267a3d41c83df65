//! Process parameters to poses and contacts.

use core::hint::black_box;

use hexstep::cycles::drill_point::{Drill, Solution};
use hexstep::cycles::precession::{Contact as Touch, Parameters, Precession, Reference, Stretch};
use hexstep::cycles::surface_grinding::{Contact, Grinding, Job};
use hexstep::geometry::nurbs::{Nurbs, Section};
use hexstep::geometry::{Vector, Waypoint};
use hexstep::math::Real;

use crate::{ROUNDS, share};

/// Grinding parameters from a drill's geometry.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_drill_solve(drill: &Drill<f32>, phi: f32) -> Option<Solution<f32>> {
    drill.solve(phi).ok()
}

/// A pose of the bonnet: phase, frame, far point, turn-free tool frame.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_precession_pose(stretch: &mut Stretch<f32>) -> Option<Waypoint<f32>> {
    stretch.next().map(|stance| stance.waypoint())
}

/// A point of a rational bicubic surface, its normal and its curvatures along a direction.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_nurbs_eval(surface: &Nurbs<f32, 8, 7>, u: f32, v: f32) -> Option<Section<f32>> {
    surface.shape(u, v).ok()?.along(1.0, 0.25)
}

/// The ellipse of contact.
#[inline(never)]
#[unsafe(no_mangle)] // SAFETY: no other symbol has this name.
fn bench_hertz(grinding: &Grinding<f32>, section: &Section<f32>) -> Option<Contact<f32>> {
    grinding.hertz.on(section).ok()
}

#[inline(never)]
pub fn drill_point() {
    for round in 0..ROUNDS {
        let small = round as f32 * 0.001;
        let drill = Drill {
            diameter: 9.9 + small,
            web: 1.63,
            point_angle: 118f32.to_radians(),
            chisel_angle: 50f32.to_radians(),
            clearance: 10f32.to_radians() + small,
        };
        let _ = black_box(bench_drill_solve(
            black_box(&drill),
            black_box(30f32.to_radians()),
        ));
    }
}

/// A winding path over a hill, with the reference carried along and locked to the feed.
#[inline(never)]
pub fn precession() {
    for reference in [Reference::Transport, Reference::FeedLocked] {
        let parameters = Parameters {
            reference,
            ..Parameters::default()
        };
        let Ok(mut precession) = Precession::new(&parameters) else {
            panic!("no such process");
        };
        for point in 0..8u8 {
            let s = f32::from(point);
            let (x, y) = (10.0 * s, 6.0 * s.sin());
            let touch = Touch {
                p: Vector::new(x, y, -0.002 * (x * x + y * y)),
                n: Vector::new(0.004 * x, 0.004 * y, 1.0),
            };
            let Ok(mut stretch) = precession.push(touch) else {
                panic!("a point was refused");
            };
            // Eight poses of each stretch, from its beginning on.
            for _ in 0..stretch.len().min(8) {
                let pose = bench_precession_pose(black_box(&mut stretch));
                let _ = black_box(pose);
            }
        }
    }
}

/// Places all over a wavy part of 210 x 180 mm, and the contacts there.
#[inline(never)]
pub fn surface() {
    let mut points = [Vector::ZERO; 56];
    let mut weights = [1.0; 56];
    for (i, (point, weight)) in (0u8..).zip(points.iter_mut().zip(&mut weights)) {
        let (along, across) = (f32::from(i / 7), f32::from(i % 7));
        let height = f32::from(i * 37 % 11);
        *point = Vector::new(30.0 * along, 30.0 * across, height);
        *weight = 1.0 + 0.02 * height;
    }
    let knots_u = [0.0, 0.0, 0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0, 1.0, 1.0];
    let knots_v = [0.0, 0.0, 0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0, 1.0];
    let surface = Nurbs::new([3, 3], [8, 7], [&knots_u, &knots_v], &points, &weights);
    let (Ok(surface), Ok(grinding)) = (surface, Grinding::new(&Job::hard())) else {
        panic!("no such surface");
    };
    for round in 0..ROUNDS {
        let (u, v) = (share(round, 8), share(round / 8, 8));
        let section = bench_nurbs_eval(&surface, black_box(u), black_box(v));
        let _ = black_box(section);
    }
    // Relative curvatures from 1 : 1.4 to 1 : 40, at all angles.
    for round in 0..ROUNDS {
        let (x, y) = (share(round, 8), share(round / 8, 8));
        let section = Section {
            feed: Vector::X,
            cross: Vector::Y,
            k_f: 0.02 * x - 0.01,
            k_c: 0.08 * y * y - 0.0175,
            tau: 0.008 * (x - y),
        };
        let _ = black_box(bench_hertz(black_box(&grinding), black_box(&section)));
    }
}
