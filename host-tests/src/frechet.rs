//! Two polylines -> how far they lie apart when both are run through from their beginnings to their ends, never backward.
//!
//! That is the Fréchet distance: the least leash with which one walks along one curve, and a dog along the other. A curve
//! that crosses itself, or runs back over itself, is thus compared with the stretch that is being run, and nothing has to
//! be known of speeds. Whether a leash d is long enough is read from the free-space diagram, where the place on the
//! motion grows to the right and that on the polyline upward; each cell is a segment of one against a chord of the
//! other, and its free part, where they are within d, is convex:
//!
//! ```text
//!   chord j+1  |       |   .===|=====  |        the stretch of an edge that can be reached from the lower left corner:
//!              +-------+--/----+-------+          right edge   all of its free part if the lower edge can be reached,
//!   chord j    | .====== /     |       |                       else what is not below what can be reached on the left
//!              |/      |       |       |          upper edge   the same with left and lower exchanged
//!              +-------+-------+-------+
//!               segment k  k+1
//! ```
//!
//! (Alt and Godau 1995.) Only cells that can be reached are looked at: a band along the diagonal, as wide as the leash is
//! longer than chords are. The least leash is found by halving. For a leash d both curves are thinned first, each by d/800
//! at most and never below the grain that is asked for, so that a curve of many points costs no more than its shape.

/// How two curves lie to each other.
#[derive(Clone, Debug, Default)]
pub struct Apart {
    /// The Fréchet distance, from above: at most a grain and a 200th of itself too large.
    pub distance: f64,
    /// Of points of the motion: its index, its distance from the polyline in order, the chord where it is nearest.
    pub aside: Vec<Aside>,
    /// Largest distance of a vertex of the polyline from the motion in order.
    pub cut: f64,
}

/// A point of the motion beside the polyline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aside {
    pub point: usize,
    pub distance: f64,
    pub chord: usize,
}

/// Cells that the last look, which notes every point, may take; beyond it thinned curves serve.
const MOST_CELLS: u64 = 200_000_000;
/// Points that one stretch of a thinned curve may leave out.
const MOST_LEFT_OUT: usize = 128;

/// Compares a motion with a polyline. With `ends_early` the motion may end anywhere on it. `grain` is the accuracy, and
/// greater than 0. Curves without points are as far apart as nothing: 0.
pub fn apart<const D: usize>(
    motion: &[[f64; D]],
    polyline: &[[f64; D]],
    ends_early: bool,
    grain: f64,
) -> Apart {
    let (Some(first), Some(last)) = (motion.first(), motion.last()) else {
        return Apart::default();
    };
    let (Some(begin), Some(end)) = (polyline.first(), polyline.last()) else {
        return Apart::default();
    };
    let ends = match ends_early {
        true => 0.0,
        false => distance(last, end),
    };
    let finest = Thinned::of(motion, polyline, grain / 4.0);
    let mut levels = vec![finest];
    let mut reaches = |leash: f64| {
        // Errors of all levels add to less than twice that of the coarsest.
        let level = (leash / 800.0 / grain).log2().floor().clamp(0.0, 30.0) as usize;
        while levels.len() <= level {
            let before = &levels[levels.len() - 1];
            let coarser = before.thinned(motion, polyline, grain * f64::from(1u32 << levels.len()));
            levels.push(coarser);
        }
        let Thinned {
            motion: m,
            polyline: p,
            ..
        } = &levels[level];
        let (m, p) = (pick(motion, m), pick(polyline, p));
        sweep(&m, &p, leash, ends_early, u64::MAX, None) == Some(true)
    };
    let mut low = distance(first, begin).max(ends);
    let mut high = low.max(8.0 * grain);
    while !reaches(high) {
        low = high;
        high *= 1.5;
    }
    while high - low > grain.max(high / 400.0) {
        let middle = 0.5 * (low + high);
        if reaches(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }

    // Every vertex and every point; where that is too much, what was looked at last.
    let mut found = Apart {
        distance: high,
        ..Apart::default()
    };
    let leash = high + 2.0 * grain.max(high / 200.0);
    let mut notes = Notes::new(polyline.len());
    let done = sweep(
        motion,
        polyline,
        leash,
        ends_early,
        MOST_CELLS,
        Some(&mut notes),
    );
    let thinned = levels.last().filter(|_| done != Some(true));
    if let Some(Thinned {
        motion: m,
        polyline: p,
    }) = thinned
    {
        notes = Notes::new(p.len());
        let (m, p) = (pick(motion, m), pick(polyline, p));
        sweep(&m, &p, leash, ends_early, u64::MAX, Some(&mut notes));
    }
    found.cut = notes.largest_cut().min(high);
    found.aside = notes.aside;
    for aside in &mut found.aside {
        if let Some(thinned) = thinned {
            aside.point = thinned.motion[aside.point.min(thinned.motion.len() - 1)];
            aside.chord = thinned.polyline[aside.chord];
        }
        // A motion of one point has been doubled.
        aside.point = aside.point.min(motion.len() - 1);
        aside.distance = aside.distance.min(high);
    }
    found
}

/// Both curves with fewer points: the indices of those that are kept.
struct Thinned {
    motion: Vec<usize>,
    polyline: Vec<usize>,
}

impl Thinned {
    fn of<const D: usize>(motion: &[[f64; D]], polyline: &[[f64; D]], by: f64) -> Self {
        Self {
            motion: thin(motion, &(0..motion.len()).collect::<Vec<_>>(), by),
            polyline: thin(polyline, &(0..polyline.len()).collect::<Vec<_>>(), by),
        }
    }

    fn thinned<const D: usize>(&self, motion: &[[f64; D]], polyline: &[[f64; D]], by: f64) -> Self {
        Self {
            motion: thin(motion, &self.motion, by),
            polyline: thin(polyline, &self.polyline, by),
        }
    }
}

fn pick<const D: usize>(points: &[[f64; D]], kept: &[usize]) -> Vec<[f64; D]> {
    kept.iter().map(|index| points[*index]).collect()
}

/// Of the points `kept` those that leave the curve within `by` of itself, in order.
fn thin<const D: usize>(points: &[[f64; D]], kept: &[usize], by: f64) -> Vec<usize> {
    let mut thinned = Vec::new();
    let mut from = 0;
    while from < kept.len() {
        thinned.push(kept[from]);
        let most = (kept.len() - 1 - from).min(MOST_LEFT_OUT);
        let covers = |way: usize| is_straight(points, &kept[from..=from + way], by);
        // Doubled while it covers, then halved back.
        let (mut good, mut bad) = (1, 2);
        while bad <= most && covers(bad) {
            (good, bad) = (bad, bad * 2);
        }
        bad = bad.min(most + 1);
        while bad > good + 1 {
            let middle = (good + bad) / 2;
            if covers(middle) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        from += good;
    }
    thinned
}

/// Whether the straight line from the first of the points to the last passes all others in order within `by`.
fn is_straight<const D: usize>(points: &[[f64; D]], kept: &[usize], by: f64) -> bool {
    let (Some(first), Some(last)) = (kept.first(), kept.last()) else {
        return true;
    };
    let (a, b) = (&points[*first], &points[*last]);
    let mut place = 0.0f64;
    kept.iter()
        .all(|index| match free(&points[*index], a, b, by) {
            Some((lo, hi)) if hi >= place => {
                place = place.max(lo);
                true
            }
            _ => false,
        })
}

/// What a sweep that reaches the end has passed.
struct Notes {
    aside: Vec<Aside>,
    cuts: Vec<f64>,
}

impl Notes {
    fn new(vertices: usize) -> Self {
        Self {
            aside: Vec::new(),
            cuts: vec![f64::INFINITY; vertices],
        }
    }

    /// The last vertex that was passed lies behind all others that were.
    fn largest_cut(&self) -> f64 {
        let passed = self.cuts.iter().filter(|cut| cut.is_finite());
        passed.fold(0.0, |largest, cut| largest.max(*cut))
    }
}

/// Whether the end can be reached with this leash; `None` if that takes more cells than there may be.
fn sweep<const D: usize>(
    motion: &[[f64; D]],
    polyline: &[[f64; D]],
    leash: f64,
    ends_early: bool,
    mut cells: u64,
    mut notes: Option<&mut Notes>,
) -> Option<bool> {
    // A curve of one point stands still on it.
    let twice = |points: &[[f64; D]]| match points {
        [only] => vec![*only, *only],
        _ => Vec::new(),
    };
    let (still, only) = (twice(motion), twice(polyline));
    let motion = if still.is_empty() { motion } else { &still };
    let polyline = if only.is_empty() { polyline } else { &only };
    let chords = polyline.len() - 1;

    // What can be reached at the point of the motion that the sweep has come to: chord, and the stretch of it.
    let mut front: Vec<(usize, f64, f64)> = Vec::new();
    for j in 0..chords {
        match free(&motion[0], &polyline[j], &polyline[j + 1], leash) {
            Some((0.0, hi)) => {
                front.push((j, 0.0, hi));
                if hi < 1.0 {
                    break;
                }
            }
            _ => break,
        }
    }
    if front.is_empty() {
        return Some(false);
    }
    if let Some(notes) = notes.as_deref_mut() {
        notes.cuts[0] = distance(&motion[0], &polyline[0]);
        note_point(notes, 0, &motion[0], polyline, &front);
    }
    // Whether the motion can still be where it began with the polyline at its first vertex.
    let mut begins = true;
    let mut next: Vec<(usize, f64, f64)> = Vec::new();
    for k in 0..motion.len() - 1 {
        next.clear();
        let (from, to) = (&motion[k], &motion[k + 1]);
        let mut at_left = front.iter().copied().peekable();
        let mut lower: Option<f64> = None;
        let mut j = at_left.peek().map_or(0, |entry| entry.0);
        if begins {
            j = 0;
            match free(&polyline[0], from, to, leash) {
                Some((0.0, hi)) => {
                    lower = Some(0.0);
                    begins = hi >= 1.0;
                    if let Some(notes) = notes.as_deref_mut() {
                        note_vertex(notes, 0, &polyline[0], from, to, (0.0, hi));
                    }
                }
                _ => begins = false,
            }
        }
        while j < chords {
            let left = at_left.next_if(|entry| entry.0 == j);
            if left.is_none() && lower.is_none() {
                match at_left.peek() {
                    Some(entry) => {
                        j = entry.0;
                        continue;
                    }
                    None => break,
                }
            }
            cells = cells.checked_sub(1)?;
            if let Some((lo, hi)) = free(to, &polyline[j], &polyline[j + 1], leash) {
                let lo = match (lower, left) {
                    (None, Some((_, least, _))) => lo.max(least),
                    _ => lo,
                };
                if lo <= hi {
                    next.push((j, lo, hi));
                }
            }
            lower = match free(&polyline[j + 1], from, to, leash) {
                Some((lo, hi)) => {
                    let lo = match (left, lower) {
                        (None, Some(least)) => lo.max(least),
                        _ => lo,
                    };
                    if let (true, Some(notes)) = (lo <= hi, notes.as_deref_mut()) {
                        note_vertex(notes, j + 1, &polyline[j + 1], from, to, (lo, hi));
                    }
                    (lo <= hi).then_some(lo)
                }
                None => None,
            };
            j += 1;
        }
        std::mem::swap(&mut front, &mut next);
        if front.is_empty() {
            return Some(false);
        }
        if let Some(notes) = notes.as_deref_mut() {
            note_point(notes, k + 1, to, polyline, &front);
        }
    }
    let ends = front
        .last()
        .is_some_and(|(j, _, hi)| j + 1 == chords && *hi >= 1.0);
    Some(ends || ends_early)
}

fn note_point<const D: usize>(
    notes: &mut Notes,
    point: usize,
    at: &[f64; D],
    polyline: &[[f64; D]],
    front: &[(usize, f64, f64)],
) {
    let off = |(j, lo, hi): &(usize, f64, f64)| {
        let (a, b) = (&polyline[*j], &polyline[*j + 1]);
        (
            distance(at, &between(a, b, nearest(at, a, b).clamp(*lo, *hi))),
            *j,
        )
    };
    // The last of those that are as near: a repeated point belongs to the chord that leaves it.
    let least = front
        .iter()
        .map(off)
        .min_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    if let Some((distance, chord)) = least {
        notes.aside.push(Aside {
            point,
            distance,
            chord,
        });
    }
}

fn note_vertex<const D: usize>(
    notes: &mut Notes,
    vertex: usize,
    at: &[f64; D],
    from: &[f64; D],
    to: &[f64; D],
    (lo, hi): (f64, f64),
) {
    let off = distance(at, &between(from, to, nearest(at, from, to).clamp(lo, hi)));
    // A polyline of one point has been doubled.
    if let Some(cut) = notes.cuts.get_mut(vertex) {
        *cut = cut.min(off);
    }
}

/// The stretch of the line from `a` (0) to `b` (1) that is within `leash` of `c`.
fn free<const D: usize>(
    c: &[f64; D],
    a: &[f64; D],
    b: &[f64; D],
    leash: f64,
) -> Option<(f64, f64)> {
    // |a + t d - c|^2 = leash^2: square t^2 + 2 half t + rest = 0.
    let (mut square, mut half, mut rest, mut end) = (0.0, 0.0, 0.0, 0.0);
    for i in 0..D {
        let (d, f, g) = (b[i] - a[i], a[i] - c[i], b[i] - c[i]);
        square += d * d;
        half += d * f;
        rest += f * f;
        end += g * g;
    }
    // Both ends are decided by their own distances, so that cells agree on the corners that they share.
    let most = leash * leash * (1.0 + 1e-12);
    let (begins, ends) = (rest <= most, end <= most);
    if begins && ends {
        return Some((0.0, 1.0));
    }
    let under = half * half - square * (rest - most);
    if under < 0.0 || square == 0.0 {
        return None;
    }
    let root = under.sqrt();
    let lo = if begins { 0.0 } else { (-half - root) / square };
    let hi = if ends { 1.0 } else { (-half + root) / square };
    // An open end is not reached by rounding.
    let (least, most) = (
        if begins { 0.0 } else { 1e-15 },
        if ends { 1.0 } else { 1.0 - 1e-15 },
    );
    (hi >= 0.0 && lo <= 1.0 && lo <= hi).then(|| (lo.max(least), hi.min(most)))
}

/// Where the line from `a` (0) to `b` (1) is nearest to `c`, on it or beyond its ends.
fn nearest<const D: usize>(c: &[f64; D], a: &[f64; D], b: &[f64; D]) -> f64 {
    let (mut along, mut square) = (0.0, 0.0);
    for i in 0..D {
        along += (c[i] - a[i]) * (b[i] - a[i]);
        square += (b[i] - a[i]).powi(2);
    }
    if square > 0.0 { along / square } else { 0.0 }
}

fn between<const D: usize>(a: &[f64; D], b: &[f64; D], share: f64) -> [f64; D] {
    std::array::from_fn(|i| a[i] + share * (b[i] - a[i]))
}

fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt()
}
