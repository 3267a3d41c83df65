//! Points in, segments out, one at a time: what is kept between them is the last point, its frame and the phase.

use super::error::{Field, PrecessionError};
use super::frame::first_reference;
use super::parameters::{Parameters, Process};
use super::stretch::{Carried, Stretch, check_neighbours};
use crate::geometry::Vector;
use crate::math::Real;

/// A point of the path: where the bonnet touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<R> {
    /// On the surface [mm].
    pub p: Vector<R>,
    /// Outward normal, any length from 1e-6.
    pub n: Vector<R>,
}

/// A precession fed point by point.
///
/// ```
/// use hexstep::cycles::precession::{Contact, Parameters, Precession};
/// use hexstep::geometry::Vector;
///
/// let mut precession = Precession::new(&Parameters::<f32>::default())?;
/// let at = |x| Contact { p: Vector::new(x, 0.0, 0.0), n: Vector::Z };
/// assert_eq!(precession.push(at(0.0))?.steps(), 0);
/// let mut poses = 0;
/// for stance in precession.push(at(60.0))? {
///     assert!((stance.centre.z - 39.5).abs() < 1e-4);
///     poses += 1;
/// }
/// assert_eq!(poses, 148); // the first pose and 147 steps
/// # Ok::<(), hexstep::cycles::precession::PrecessionError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Precession<R> {
    process: Process<R>,
    /// The first move of the path, where it is known beforehand.
    first_move: Option<Vector<R>>,
    /// The last point kept; its reference direction is there once a segment has begun.
    last: Option<Carried<R>>,
    begun: bool,
    points: u32,
}

impl<R: Real> Precession<R> {
    /// Fails as [`Process::new`] does.
    pub fn new(parameters: &Parameters<R>) -> Result<Self, PrecessionError> {
        Ok(Self {
            process: Process::new(parameters)?,
            first_move: None,
            last: None,
            begun: false,
            points: 0,
        })
    }

    /// A precession for a whole path that lies ready: checks everything in the order of the validation table, and
    /// looks for the first move beyond points that only turn the normal. Pushing these contacts cannot fail afterwards.
    pub fn for_path(
        parameters: &Parameters<R>,
        contacts: &[Contact<R>],
    ) -> Result<Self, PrecessionError> {
        parameters.check_ranges()?;
        let Some(first) = contacts.first() else {
            return Err(PrecessionError::BadPath);
        };
        for (contact, index) in contacts.iter().zip(0..) {
            unit_normal(contact, index)?;
        }
        for (pair, index) in contacts.windows(2).zip(1..) {
            if let [a, b] = pair {
                let (a, b) = (unit_normal(a, index)?, unit_normal(b, index)?);
                check_neighbours(a, b, index)?;
            }
        }
        check_dwell(parameters.dwell, contacts.len() == 1)?;
        let mut precession = Self::new(parameters)?;
        for (contact, index) in contacts.iter().zip(0..) {
            check_point(contact, index)?;
        }
        precession.first_move = contacts
            .iter()
            .find_map(|contact| move_of(contact.p - first.p));
        // What is left is the size of the steps: a walk over the segments, not over their poses.
        let mut trial = precession.clone();
        for contact in contacts {
            trial.push(*contact)?;
        }
        trial.finish()?;
        Ok(precession)
    }

    /// The segment that leads to this point, empty for the first one and for one that repeats the one before. If it is
    /// refused, nothing has changed.
    ///
    /// The first pose of the path comes with the first segment, because its reference direction may depend on it. Where
    /// the first segments only turn the normal, their stream cannot know the first move and takes a coordinate axis.
    pub fn push(&mut self, contact: Contact<R>) -> Result<Stretch<R>, PrecessionError> {
        let index = self.points;
        let n = unit_normal(&contact, index)?;
        check_point(&contact, index)?;
        let p = contact.p;
        let Some(last) = self.last else {
            let first = Carried {
                p,
                n,
                a: Vector::ZERO,
                phase: self.process.phase,
                time: R::ZERO,
            };
            self.last = Some(first);
            self.points = 1;
            return Ok(Stretch::standing(&self.process, &first));
        };
        let from = if self.begun {
            last
        } else {
            self.first(&last, move_of(p - last.p))
        };
        let found = Stretch::between(&self.process, &from, p, n, index)?;
        self.points = index.saturating_add(1);
        let Some((stretch, carried)) = found else {
            let standing = Stretch::standing(&self.process, &last);
            return Ok(standing.skipping(index.saturating_sub(1)));
        };
        self.last = Some(carried);
        let begun = core::mem::replace(&mut self.begun, true);
        Ok(if begun { stretch } else { stretch.led(&from) })
    }

    /// What is left when no more points come: for a path of a single point its dwell, else nothing, unless all points
    /// were the same: then the one pose there.
    pub fn finish(&self) -> Result<Stretch<R>, PrecessionError> {
        let last = self.last.as_ref().ok_or(PrecessionError::BadPath)?;
        if self.begun {
            return Ok(Stretch::standing(&self.process, last));
        }
        let first = self.first(last, None);
        let stretch = if self.points == 1 {
            check_dwell(self.process.dwell, true)?;
            Stretch::dwell(&self.process, &first, self.process.dwell)?
        } else {
            let segment = self.points.saturating_sub(2);
            Stretch::standing(&self.process, &first).skipping(segment)
        };
        Ok(stretch.led(&first))
    }

    /// The checked parameters.
    pub fn process(&self) -> &Process<R> {
        &self.process
    }

    /// Whether a point has been taken.
    pub fn has_point(&self) -> bool {
        self.last.is_some()
    }

    pub(super) fn has_begun(&self) -> bool {
        self.begun
    }

    fn first(&self, at: &Carried<R>, next_move: Option<Vector<R>>) -> Carried<R> {
        let candidates = [self.process.first_reference, self.first_move.or(next_move)];
        Carried {
            a: first_reference(candidates, at.n),
            ..*at
        }
    }
}

/// A move that is one.
fn move_of<R: Real>(d: Vector<R>) -> Option<Vector<R>> {
    (d.norm() > R::of(1e-6)).then_some(d)
}

fn unit_normal<R: Real>(contact: &Contact<R>, index: u32) -> Result<Vector<R>, PrecessionError> {
    let unit = contact.n.unit(R::of(1e-6));
    unit.ok_or(PrecessionError::BadNormal { index })
}

fn check_point<R: Real>(contact: &Contact<R>, index: u32) -> Result<(), PrecessionError> {
    if contact.p.is_finite() {
        return Ok(());
    }
    Err(PrecessionError::NonFinite {
        field: Field::Points,
        index: Some(index),
    })
}

fn check_dwell<R: Real>(dwell: R, single: bool) -> Result<(), PrecessionError> {
    // The comparison is false for a NaN; an infinite dwell is told as such elsewhere.
    let good = !single || dwell > R::ZERO;
    if good {
        Ok(())
    } else {
        Err(PrecessionError::BadDwell)
    }
}
