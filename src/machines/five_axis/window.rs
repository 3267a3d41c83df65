//! The choice of solutions over a whole path: least summed cost by dynamic programming, in bounded memory.
//!
//! The greedy choice of [`FiveAxis::inverse`] can be trapped by travel limits; here every solution and every turn
//! within travel is a state, and the cheapest chain of states through a window of points is kept.
//!
//! ```text
//!   point   0      1      2     ...    newest        a layer holds for each state the state before it: one byte
//!   state   o------o      o------o------o cost
//!           o      \--o---o   \--o------o cost       window full: the cheapest chain commits its oldest point,
//!                                                    chains that start elsewhere are dropped
//! ```
//!
//! A window as long as the path gives the exact minimum. An axis without limits adds no states: its turn nearest to
//! the state before is always the best, since a whole turn more or less changes nothing afterwards. At a pole the
//! free axis stays where the state before had it, at no cost.

use super::travel::{Travel, Turned};
use super::{Branches, Chosen, Error, FiveAxis, Kind, Solution};
use crate::geometry::Vector;
use crate::math::Real;

/// One state as a layer remembers it.
#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    /// Index of the state before in the layer before.
    back: u8,
    number: u8,
    turns: [i32; 2],
}

/// One point of the window, with room for `S` <= 255 states; 8 are enough for most machines.
#[derive(Clone, Copy, Debug)]
pub struct Layer<R, const S: usize> {
    p: Vector<R>,
    branches: Branches<R>,
    marks: [Mark; S],
}

impl<R: Real, const S: usize> Layer<R, S> {
    /// What an unused window is filled with.
    pub const fn empty() -> Self {
        Self {
            p: Vector::ZERO,
            branches: Branches {
                kind: Kind::None,
                gap: R::ZERO,
                s: R::ZERO,
                angles: [[R::ZERO; 2]; 2],
                tilt: [R::ZERO; 2],
            },
            marks: [Mark {
                back: 0,
                number: 0,
                turns: [0; 2],
            }; S],
        }
    }
}

/// A state of the newest point: the end of one chain.
#[derive(Clone, Copy, Debug)]
struct End<R> {
    mark: Mark,
    rotary: [Turned<R>; 2],
    /// Summed cost of its chain [rad].
    cost: R,
}

/// Chooses joints for points pushed one after the other; the window is the slice it is given.
#[derive(Debug)]
pub struct PathChoice<'a, R, const S: usize> {
    machine: &'a FiveAxis<R>,
    layers: &'a mut [Layer<R, S>],
    /// Index of the oldest layer, and how many are in use.
    oldest: usize,
    len: usize,
    /// Rotaries of the last committed point.
    committed: [Turned<R>; 2],
    ends: [Option<End<R>>; S],
    is_exact: bool,
}

impl<'a, R: Real, const S: usize> PathChoice<'a, R, S> {
    /// `layers`: the window, at least one point, 32 to 128 usual. `previous`: the rotaries before the first point.
    pub fn new(
        machine: &'a FiveAxis<R>,
        layers: &'a mut [Layer<R, S>],
        previous: [Turned<R>; 2],
    ) -> Self {
        Self {
            machine,
            layers,
            oldest: 0,
            len: 0,
            committed: previous,
            ends: [None; S],
            is_exact: true,
        }
    }

    /// Whether [`pop`](Self::pop) must be called before the next push.
    pub fn is_full(&self) -> bool {
        self.len >= self.layers.len()
    }

    /// False once a point had more states than `S`; the cheapest `S` were kept then.
    pub fn is_exact(&self) -> bool {
        self.is_exact
    }

    /// Takes in the next point, tip [mm] and unit tool axis in the work frame. Returns false, and does nothing, when
    /// the window is full. Fails with Unreachable or OutOfTravel (rotary axes); the window is then as before.
    pub fn push(&mut self, p: Vector<R>, v: Vector<R>) -> Result<bool, Error<R>> {
        if self.is_full() {
            return Ok(false);
        }
        let near = self.best().map_or(self.committed, |(_, end)| end.rotary);
        let branches = self.machine.branches(v, &near);
        if branches.kind == Kind::None {
            return Err(self.machine.unreachable(p, &branches, &near));
        }
        let mut layer = Layer {
            p,
            branches,
            ..Layer::empty()
        };
        let mut ends = [None; S];
        if self.len == 0 {
            let start = End {
                mark: Mark::default(),
                rotary: self.committed,
                cost: R::ZERO,
            };
            self.extend(&branches, 0, &start, &mut ends);
        } else {
            let before = self.ends;
            for (back, end) in before.iter().enumerate() {
                if let (Some(end), Ok(back)) = (end, u8::try_from(back)) {
                    self.extend(&branches, back, end, &mut ends);
                }
            }
        }
        if ends.iter().all(Option::is_none) {
            // No solution has a representative: the greedy choice says which axis stops it.
            self.machine.choose(&branches, &near)?;
        }
        for (mark, end) in layer.marks.iter_mut().zip(&ends) {
            *mark = end.map_or(Mark::default(), |end| end.mark);
        }
        let at = self.index(self.len);
        if let Some(place) = self.layers.get_mut(at) {
            *place = layer;
            self.len += 1;
            self.ends = ends;
        }
        Ok(true)
    }

    /// Commits the oldest point of the window; `None` when it is empty. Its cost is that of its own step.
    /// Fails with OutOfTravel (linear axes).
    pub fn pop(&mut self) -> Option<Result<Solution<R>, Error<R>>> {
        let (best, _) = self.best()?;
        let root = self.root(best)?;
        let layer = self.layers.get(self.oldest)?;
        let mark = layer.marks.get(usize::from(root))?;
        let rotary = self.rotary(&layer.branches, mark)?;
        let chosen = Chosen {
            rotary,
            number: mark.number,
            cost: self.machine.cost(&self.committed, &rotary),
        };
        let solution = self.machine.place(layer.p, &layer.branches, chosen);

        if self.len > 1 {
            for i in 0..S {
                if self.root(i) != Some(root)
                    && let Some(end) = self.ends.get_mut(i)
                {
                    *end = None;
                }
            }
        } else {
            self.ends = [None; S];
        }
        self.committed = rotary;
        self.oldest = self.index(1);
        self.len -= 1;
        Some(solution)
    }

    /// Place of the i-th oldest layer in the ring.
    fn index(&self, i: usize) -> usize {
        let i = self.oldest + i;
        if i >= self.layers.len() {
            i - self.layers.len()
        } else {
            i
        }
    }

    /// The cheapest chain; of equal ones that which ends in solution 1, then the first.
    fn best(&self) -> Option<(usize, End<R>)> {
        let mut best: Option<(usize, End<R>)> = None;
        for (i, end) in self.ends.iter().enumerate() {
            let Some(end) = *end else { continue };
            let is_better = best.is_none_or(|(_, best)| {
                let lead = best.cost - end.cost;
                lead > self.machine.tie
                    || (lead >= -self.machine.tie && end.mark.number < best.mark.number)
            });
            if is_better {
                best = Some((i, end));
            }
        }
        best
    }

    /// The state of the oldest layer that the chain ending in state `i` of the newest begins with.
    fn root(&self, i: usize) -> Option<u8> {
        (*self.ends.get(i)?)?;
        let mut state = u8::try_from(i).ok()?;
        for i in (1..self.len).rev() {
            let layer = self.layers.get(self.index(i))?;
            state = layer.marks.get(usize::from(state))?.back;
        }
        Some(state)
    }

    /// Every state of the new point that follows `from`, put among `ends`.
    fn extend(
        &mut self,
        branches: &Branches<R>,
        back: u8,
        from: &End<R>,
        ends: &mut [Option<End<R>>; S],
    ) {
        let [_, _, _, travel1, travel2] = &self.machine.travel;
        let [from1, from2] = from.rotary;
        let free = (branches.kind == Kind::Infinite).then(|| self.machine.direction.free());
        let most = S as i32;
        for ([angle1, angle2], number) in branches.solutions().iter().zip(1u8..) {
            let held1 = (free == Some(0)).then(|| travel1.clamp(from1));
            let many1 = held1
                .is_none()
                .then(|| travel1.all(*angle1, from1, most))
                .into_iter();
            for th1 in held1.into_iter().chain(many1.flatten()) {
                let held2 = (free == Some(1)).then(|| travel2.clamp(from2));
                let many2 = held2
                    .is_none()
                    .then(|| travel2.all(*angle2, from2, most))
                    .into_iter();
                for th2 in held2.into_iter().chain(many2.flatten()) {
                    let rotary = [th1, th2];
                    // What the free axis would have cost is nothing: it stays.
                    let step = self.machine.cost(&from.rotary, &rotary);
                    let end = End {
                        mark: Mark {
                            back,
                            number,
                            turns: [th1.turns, th2.turns],
                        },
                        rotary,
                        cost: from.cost + step,
                    };
                    self.is_exact &= insert(ends, end, |other| self.is_same(free, other, &end));
                }
            }
        }
    }

    /// Whether two chains that end so have the same future.
    fn is_same(&self, free: Option<usize>, a: &End<R>, b: &End<R>) -> bool {
        let [_, _, _, travel1, travel2] = &self.machine.travel;
        let is_axis_same = |axis, travel: &Travel<R>, a: Turned<R>, b: Turned<R>| {
            let are_turns_same = !travel.is_limited() || a.turns == b.turns;
            let is_held = free == Some(axis);
            are_turns_same && (!is_held || (a.angle - b.angle).abs() <= self.machine.tie)
        };
        let ([a1, a2], [b1, b2]) = (a.rotary, b.rotary);
        a.mark.number == b.mark.number
            && is_axis_same(0, travel1, a1, b1)
            && is_axis_same(1, travel2, a2, b2)
    }

    /// Rebuilds the angles of a state of the oldest layer from the point committed before it.
    fn rotary(&self, branches: &Branches<R>, mark: &Mark) -> Option<[Turned<R>; 2]> {
        let [_, _, _, travel1, travel2] = &self.machine.travel;
        let [before1, before2] = self.committed;
        let [turns1, turns2] = mark.turns;
        let angles = match mark.number {
            2 => branches.angles.last(),
            _ => branches.angles.first(),
        };
        let [angle1, angle2] = *angles?;
        let free = (branches.kind == Kind::Infinite).then(|| self.machine.direction.free());
        let axis = |axis, travel: &Travel<R>, before, turns, angle| {
            if free == Some(axis) {
                Some(travel.clamp(before))
            } else if travel.is_limited() {
                Some(travel.clamp(Turned { turns, angle }))
            } else {
                travel.nearest(angle, before)
            }
        };
        Some([
            axis(0, travel1, before1, turns1, angle1)?,
            axis(1, travel2, before2, turns2, angle2)?,
        ])
    }
}

/// Puts `end` among `ends` unless a cheaper one has the same future. Returns false when one had to be dropped.
fn insert<R: Real, const S: usize>(
    ends: &mut [Option<End<R>>; S],
    end: End<R>,
    is_same: impl Fn(&End<R>) -> bool,
) -> bool {
    if let Some(place) = ends.iter_mut().flatten().find(|other| is_same(other)) {
        if end.cost < place.cost {
            *place = end;
        }
        return true;
    }
    if let Some(place) = ends.iter_mut().find(|place| place.is_none()) {
        *place = Some(end);
        return true;
    }
    let dearest = ends
        .iter_mut()
        .flatten()
        .reduce(|a, b| if b.cost > a.cost { b } else { a });
    if let Some(place) = dearest
        && end.cost < place.cost
    {
        *place = end;
    }
    false
}
