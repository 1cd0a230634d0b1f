//! Convex pieces of what a point looks at, and what cones leave of them.

use super::cone::{ConeSide, Piece, RoundCone, SIDE_ROUNDOFF};
use super::{Cone, Cones};
use glam::DVec3;
use smallvec::SmallVec;
use std::ops::Range;

/// A piece that more cones than this may touch is halved first: each half is touched by fewer, and what those leave of it is not
/// held against the others.
const MANY_CONES: usize = 128;

/// A half that more than this share of them touch has not parted them; after so many in a row it is not halved again.
const SHARED: f64 = 0.75;
const FUTILE_HALVINGS: u32 = 3;

/// A direction from the viewpoint, metres, and its length.
#[derive(Clone, Copy)]
struct Corner {
    direction: DVec3,
    length: f64,
}

/// Where the corners of a piece are, and a cone around them.
#[derive(Clone, Copy)]
struct PieceRange {
    from: u32,
    to: u32,
    hull: RoundCone,
    /// Whether the hull is one, and not just all directions: what no further cone is held against needs none.
    has_hull: bool,
}

/// Convex polygons, their corners one after the other in one buffer; and the buffers to cut them.
#[derive(Default)]
pub(super) struct Pieces {
    corners: Vec<Corner>,
    ranges: Vec<PieceRange>,
    /// What is left of the piece that is being cut, its heights above the plane that cuts it, and what remains then.
    rest: Vec<Corner>,
    heights: Vec<f64>,
    inside: Vec<Corner>,
    /// Numbers of the pieces that a cone may touch.
    met: Vec<usize>,
    /// Numbers of the cones that touch the pieces on the way from the whole to the one at hand.
    touching: Vec<u32>,
}

impl Pieces {
    /// Holds `piece` and nothing else.
    pub(super) fn start(&mut self, piece: &[DVec3]) {
        self.corners.clear();
        self.corners.extend(piece.iter().map(|&d| Corner::new(d)));
        self.ranges.clear();
        self.push(0);
    }

    /// The corners from number `first` on are a new piece.
    fn push(&mut self, first: usize) {
        self.ranges.push(PieceRange::new(first, self.corners.len()));
    }

    fn piece(&self, range: PieceRange) -> &[Corner] {
        range.of(&self.corners)
    }

    /// Whether nothing is left.
    pub(super) fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// The directions of the corners of each piece.
    pub(super) fn iter(&self) -> impl Iterator<Item = impl Iterator<Item = DVec3> + '_> {
        let directions = |range: &PieceRange| self.piece(*range).iter().map(|c| c.direction);
        self.ranges.iter().map(directions)
    }

    /// One of the pieces, if any is left.
    pub(super) fn last(&self) -> Option<Piece> {
        let range = self.ranges.last()?;
        Some(self.piece(*range).iter().map(|c| c.direction).collect())
    }

    /// Cuts `cone` out of all pieces; returns whether it hides any of them.
    pub(super) fn subtract(&mut self, cone: &Cone) -> bool {
        self.subtract_after(0, cone)
    }

    /// Cuts all `cones` out of all pieces; returns whether they hide any of them.
    ///
    /// Each cone is held against every piece that those before it have left: of hundreds of cones that is a square. Half of a
    /// piece is touched by fewer of them, and its halves by fewer still.
    pub(super) fn subtract_all(&mut self, cones: &Cones) -> bool {
        self.touching.clear();
        self.touching.extend(0..cones.len() as u32);
        let whole: SmallVec<[PieceRange; 1]> = self.ranges.drain(..).collect();
        let mut is_cut = false;
        for range in whole {
            is_cut |= self.carve(range, cones, 0..cones.len(), FUTILE_HALVINGS);
        }
        is_cut
    }

    /// Adds what those of the `cones` that `touching` lists leave of a piece; returns whether they hide any of it. The piece is
    /// halved as long as that parts the cones, or has failed to fewer times than `patience`.
    fn carve(
        &mut self,
        range: PieceRange,
        cones: &Cones,
        touching: Range<usize>,
        patience: u32,
    ) -> bool {
        let halves = match touching.len() > MANY_CONES && patience > 0 {
            true => self.halves(range),
            false => None,
        };
        let Some(halves) = halves else {
            return self.subtract_each(range, cones, touching);
        };
        let shared = SHARED * touching.len() as f64;
        let first = self.touching.len();
        let mut is_cut = false;
        for mut half in halves {
            if self.touch(&mut half, cones, touching.clone()) {
                let own = first..self.touching.len();
                let patience = match own.len() as f64 > shared {
                    true => patience - 1,
                    false => FUTILE_HALVINGS,
                };
                is_cut |= self.carve(half, cones, own, patience);
            } else {
                is_cut = true;
            }
            self.touching.truncate(first);
        }
        is_cut
    }

    /// Adds what those of the `cones` that `touching` lists leave of a piece; returns whether they hide any of it.
    fn subtract_each(&mut self, range: PieceRange, cones: &Cones, touching: Range<usize>) -> bool {
        let first = self.ranges.len();
        self.ranges.push(range);
        let mut is_cut = false;
        for i in touching {
            let cone = cones.get(self.touching[i] as usize);
            is_cut |= self.subtract_after(first, &cone);
            if self.ranges.len() == first {
                break;
            }
        }
        is_cut
    }

    /// Appends to `touching` those of the `cones` listed there in `among` that touch a piece; false when one hides all of it.
    fn touch(&mut self, range: &mut PieceRange, cones: &Cones, among: Range<usize>) -> bool {
        *range = range.with_hull(&self.corners);
        let (piece, hull) = (range.of(&self.corners), range.hull);
        for i in among {
            let number = self.touching[i];
            let cone = cones.get(number as usize);
            if hull.is_apart(cone.hull) || is_apart(piece, &cone) {
                continue;
            }
            if holds_all(&cone, piece) {
                return false;
            }
            self.touching.push(number);
        }
        true
    }

    /// The halves of a piece on either side of the middle of its longest edge, as it looks; none of a sliver.
    fn halves(&mut self, range: PieceRange) -> Option<[PieceRange; 2]> {
        self.hold(range);
        let count = self.rest.len();
        let directions = |i: usize| {
            let (a, b) = (self.rest[i], self.rest[(i + 1) % count]);
            [a, b].map(|c| c.direction / c.length)
        };
        let longest = (0..count)
            .map(directions)
            .max_by(|[a, b], [c, d]| a.distance_squared(*b).total_cmp(&c.distance_squared(*d)))?;
        // The plane of all directions that are as far from one end as from the other.
        let normal = longest[0] - longest[1];
        let side = ConeSide {
            normal,
            slack: SIDE_ROUNDOFF * normal.length(),
        };
        if self.measure(&side) != (true, true) {
            return None;
        }
        self.split();
        let below = self.ranges.pop()?;
        self.corners.extend_from_slice(&self.rest);
        let above = PieceRange::new(below.to as usize, self.corners.len());
        Some([below, above])
    }

    /// Cuts `cone` out of all pieces from number `first` on; returns whether it hides any of them.
    fn subtract_after(&mut self, first: usize, cone: &Cone) -> bool {
        // Nine of ten pieces are passed by here.
        let mut met = std::mem::take(&mut self.met);
        let hulls = self.ranges[first..].iter().zip(first..);
        met.extend(hulls.filter_map(|(range, i)| (!range.hull.is_apart(cone.hull)).then_some(i)));
        let mut is_cut = false;
        // From behind: what takes the place of one that is gone has had its turn.
        while let Some(i) = met.pop() {
            let range = self.ranges[i].with_hull(&self.corners);
            self.ranges[i] = range;
            if !range.hull.is_apart(cone.hull)
                && !is_apart(self.piece(range), cone)
                && self.cut(range, cone)
            {
                self.ranges.swap_remove(i);
                is_cut = true;
            }
        }
        self.met = met;
        is_cut
    }

    /// Adds what `cone` leaves of a piece, and returns true; or adds nothing when the cone hides none of it, so that it may
    /// stay whole rather than in splinters.
    fn cut(&mut self, range: PieceRange, cone: &Cone) -> bool {
        let before = (self.ranges.len(), self.corners.len());
        self.hold(range);
        // What falls outside one side after the other stays; what is inside all of them is hidden.
        for side in cone.sides {
            let (is_above, is_below) = self.measure(side);
            if !is_above {
                self.ranges.truncate(before.0);
                self.corners.truncate(before.1);
                return false;
            }
            if is_below {
                self.split();
            }
        }
        true
    }

    /// Takes a piece as the rest that is to be cut.
    fn hold(&mut self, range: PieceRange) {
        self.rest.clear();
        self.rest.extend_from_slice(range.of(&self.corners));
    }

    /// Fills in the heights of the rest above a side; returns whether any is positive and whether any is negative.
    fn measure(&mut self, side: &ConeSide) -> (bool, bool) {
        self.heights.clear();
        let (mut is_above, mut is_below) = (false, false);
        for c in &self.rest {
            let mut d = side.normal.dot(c.direction);
            if d.abs() <= side.slack * c.length {
                d = 0.0;
            }
            is_above |= d > 0.0;
            is_below |= d < 0.0;
            self.heights.push(d);
        }
        (is_above, is_below)
    }

    /// Splits the rest at height zero: what lies below becomes a piece, what lies above is the new rest.
    fn split(&mut self) {
        let first = self.corners.len();
        self.inside.clear();
        for (i, &a) in self.rest.iter().enumerate() {
            let j = if i + 1 < self.rest.len() { i + 1 } else { 0 };
            let (da, db) = (self.heights[i], self.heights[j]);
            if da >= 0.0 {
                self.inside.push(a);
            }
            if da <= 0.0 {
                self.corners.push(a);
            }
            if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
                let b = self.rest[j].direction;
                let cut = Corner::new(a.direction + (b - a.direction) * (da / (da - db)));
                self.inside.push(cut);
                self.corners.push(cut);
            }
        }
        self.push(first);
        std::mem::swap(&mut self.rest, &mut self.inside);
    }
}

impl PieceRange {
    fn new(from: usize, to: usize) -> Self {
        Self {
            from: from as u32,
            to: to as u32,
            hull: RoundCone::ALL,
            has_hull: false,
        }
    }

    /// Its own of the `corners` of all pieces.
    fn of(self, corners: &[Corner]) -> &[Corner] {
        &corners[self.from as usize..self.to as usize]
    }

    /// The same with a cone around its corners, which are among `corners`.
    fn with_hull(mut self, corners: &[Corner]) -> Self {
        if !self.has_hull {
            let own = self.of(corners);
            self.hull = RoundCone::new(own.iter().map(|c| (c.direction, c.length)));
            self.has_hull = true;
        }
        self
    }
}

impl Corner {
    fn new(direction: DVec3) -> Self {
        Self {
            direction,
            length: direction.length(),
        }
    }
}

/// True when a plane through the viewpoint and an edge of either shape has them on different sides.
fn is_apart(piece: &[Corner], cone: &Cone) -> bool {
    let beyond_cone = cone.sides.iter().any(|s| {
        piece
            .iter()
            .all(|c| s.normal.dot(c.direction) <= s.slack * c.length)
    });
    beyond_cone
        || (0..piece.len()).any(|i| {
            let (a, b) = (piece[i], piece[(i + 1) % piece.len()]);
            let m = b.direction.cross(a.direction);
            let slack = SIDE_ROUNDOFF * a.length * b.length;
            cone.rim.iter().all(|r| m.dot(*r) <= 0.0) && holds(piece, m, slack)
        })
}

/// True when the piece clearly reaches to the inner side of the plane with normal `m` and not to the other. The plane of an
/// edge as short as round-off points anywhere and holds nothing.
fn holds(piece: &[Corner], m: DVec3, slack: f64) -> bool {
    let height = |c: &Corner| (m.dot(c.direction), slack * c.length);
    piece.iter().map(height).all(|(h, slack)| h >= -slack)
        && piece.iter().map(height).any(|(h, slack)| h > slack)
}

/// Whether `cone` hides all of the piece, its border by more than round-off.
fn holds_all(cone: &Cone, piece: &[Corner]) -> bool {
    cone.sides.iter().all(|s| {
        piece
            .iter()
            .all(|c| s.normal.dot(c.direction) > s.slack * c.length)
    })
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    /// Cones of `count` small triangles between the viewpoint and the square of width 2 at height 1.
    fn confetti(random: &mut Random, count: usize, width: f64) -> Cones {
        let mut cones = Cones::default();
        for screen in 0..count {
            let middle = DVec3::new(random.next() * 2.0 - 1.0, random.next() * 2.0 - 1.0, 1.0);
            let corners = [0, 1, 2].map(|_| middle + random.point(width));
            let facing = corners[0].cross(corners[1]).dot(corners[2]).signum();
            let item = cones.cone(corners.into_iter(), -facing, screen as u32);
            cones.items.extend(item);
        }
        cones
    }

    /// Of the pieces, which lie in the plane at height 1.
    fn area(pieces: &Pieces) -> f64 {
        let areas = pieces.iter().map(|piece| {
            let p: Vec<DVec3> = piece.collect();
            let next = p.iter().cycle().skip(1);
            0.5 * p
                .iter()
                .zip(next)
                .map(|(a, b)| a.x * b.y - a.y * b.x)
                .sum::<f64>()
        });
        areas.sum()
    }

    #[test]
    fn what_many_cones_leave_is_what_each_of_them_leaves_in_turn() {
        let mut random = Random(11);
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let square = square.map(|[x, y]| DVec3::new(x, y, 1.0));
        // From a few that hide nothing of most pieces to so many that little is left; and some that halving does not part.
        for (count, width) in [(8, 0.3), (300, 0.05), (1000, 0.02), (600, 0.15), (200, 0.9)] {
            let cones = confetti(&mut random, count, width);
            let mut carved = Pieces::default();
            carved.start(&square);
            assert!(carved.subtract_all(&cones));
            let mut cut = Pieces::default();
            cut.start(&square);
            for cone in cones.iter() {
                cut.subtract(&cone);
            }
            let [found, known] = [area(&carved), area(&cut)];
            let roundoff = 1e3 * f64::EPSILON * count as f64;
            assert!((found - known).abs() < roundoff, "{count}: {found} {known}");
            assert!(known < 3.99, "{known}");
        }
    }

    #[test]
    fn one_cone_among_many_may_hide_it_all_and_all_may_hide_nothing() {
        let mut random = Random(12);
        let small = [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]].map(|[x, y]| DVec3::new(x, y, 1.0));
        let mut cones = confetti(&mut random, 400, 0.05);
        let wide = [[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]].map(|[x, y]| DVec3::new(x, y, 1.0));
        let item = cones.cone(wide.into_iter(), -1.0, 400);
        cones.items.extend(item);
        let mut pieces = Pieces::default();
        pieces.start(&small);
        assert!(pieces.subtract_all(&cones));
        assert!(pieces.is_empty());
        // All lie on the other side of the viewpoint.
        pieces.start(&small.map(|d| -d));
        assert!(!pieces.subtract_all(&confetti(&mut random, 400, 0.05)));
        assert!(!pieces.is_empty());
    }
}
