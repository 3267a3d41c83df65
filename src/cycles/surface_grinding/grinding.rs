//! A checked grinding job: curvature in, stripe and pitch out.

use super::{
    Contact, Field, GrindingError, Hertz, Material, Model, Pitch, Removal, Sense, Stripe, Wheel,
    effective_modulus, pitch,
};
use crate::geometry::nurbs::Section;
use crate::math::Real;

/// How deep a row grinds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depth<R> {
    /// The feed is constant and the depth follows from the contact (the paper).
    ConstantFeed,
    /// Every row is this deep [mm]; the feed follows from the contact.
    Constant(R),
}

/// What a process is asked to do, unchecked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Job<R> {
    pub wheel: Wheel<R>,
    pub wheel_material: Material<R>,
    pub part_material: Material<R>,
    /// Normal force [N].
    pub force: R,
    /// Preston's coefficient [1/Pa].
    pub k: R,
    /// Turns a minute.
    pub rpm: R,
    /// [mm/s]
    pub feed: R,
    pub sense: Sense,
    /// Largest height left between two rows [mm].
    pub scallop: R,
    /// The share of it that is kept in reserve, 0 <= margin < 1.
    pub margin: R,
    pub model: Model,
    pub depth: Depth<R>,
}

/// Rim radius whose speed is taken where the wheel is flat along the feed [mm].
pub const FLAT_RIM: f64 = 10.0;

impl<R: Real> Job<R> {
    /// The job of the paper's table: a wheel as stiff as diamond on steel.
    pub fn hard() -> Self {
        Self {
            wheel: Wheel {
                rim: Some(R::of(10.0)),
                crown: Some(R::of(50.0)),
            },
            wheel_material: Material {
                modulus: R::of(1_050_000.0),
                poisson: R::of(0.2),
            },
            part_material: Material {
                modulus: R::of(206_000.0),
                poisson: R::of(0.3),
            },
            force: R::of(30.0),
            k: R::of(5e-12),
            rpm: R::of(2800.0),
            feed: R::of(20.0),
            sense: Sense::Neglected,
            scallop: R::of(0.04),
            margin: R::of(0.02),
            model: Model::Envelope,
            depth: Depth::ConstantFeed,
        }
    }

    /// The same with a wheel a thousand times softer that grinds eight times faster.
    pub fn soft() -> Self {
        let hard = Self::hard();
        Self {
            wheel_material: Material {
                modulus: R::of(1050.0),
                ..hard.wheel_material
            },
            k: R::of(4e-11),
            ..hard
        }
    }
}

/// A job that can be carried out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grinding<R> {
    pub hertz: Hertz<R>,
    pub removal: Removal<R>,
    pub model: Model,
    pub depth: Depth<R>,
    /// The scallop that rows are planned for, (1 - margin) times the wanted one [mm].
    scallop: R,
}

impl<R: Real> Grinding<R> {
    /// Checks materials first, then every parameter.
    pub fn new(job: &Job<R>) -> Result<Self, GrindingError<R>> {
        let e_star = effective_modulus(job.wheel_material, job.part_material)?;
        let hertz = Hertz::new(job.force, e_star, &job.wheel)?;
        let rim = job.wheel.rim.unwrap_or(R::of(FLAT_RIM));
        let removal = Removal::new(job.force, job.k, rim, job.rpm, job.feed, job.sense)?;
        let positive = |x: R| x > R::ZERO && x.is_finite();
        if !positive(job.scallop) {
            return Err(GrindingError::BadParameter(Field::Scallop));
        }
        if !(job.margin >= R::ZERO && job.margin < R::ONE) {
            return Err(GrindingError::BadParameter(Field::Margin));
        }
        if let Depth::Constant(depth) = job.depth
            && !positive(depth)
        {
            return Err(GrindingError::BadParameter(Field::Depth));
        }
        Ok(Self {
            hertz,
            removal,
            model: job.model,
            depth: job.depth,
            scallop: job.scallop * (R::ONE - job.margin),
        })
    }

    /// The stripe of a contact.
    pub fn stripe(&self, contact: &Contact<R>) -> Stripe<R> {
        let stripe = self.removal.stripe(contact.b_c);
        match self.depth {
            Depth::ConstantFeed => stripe,
            Depth::Constant(h0) => Stripe { h0, ..stripe },
        }
    }

    /// The stripe where the part has these curvatures.
    pub fn stripe_on(&self, section: &Section<R>) -> Result<Stripe<R>, GrindingError<R>> {
        Ok(self.stripe(&self.hertz.on(section)?))
    }

    /// The pitch of rows where the part has these curvatures.
    pub fn pitch_on(&self, section: &Section<R>) -> Result<Pitch<R>, GrindingError<R>> {
        let stripe = self.stripe_on(section)?;
        pitch(self.model, stripe, section.k_c, self.scallop)
    }

    /// The feed [mm/s] of a contact in which the row has its depth; `given` where the feed is constant.
    pub fn feed(&self, contact: &Contact<R>, given: R) -> Result<R, GrindingError<R>> {
        match self.depth {
            Depth::ConstantFeed => Ok(given),
            Depth::Constant(depth) => self
                .removal
                .feed_for(contact.b_c, depth)
                .map_err(|_| GrindingError::BadParameter(Field::Depth)),
        }
    }
}
