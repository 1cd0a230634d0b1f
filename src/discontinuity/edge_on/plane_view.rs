//! What the points of a segment see of the other things in one plane: flat visibility, with names for all that bounds it.
//!
//! In the plane of a face that cuts an emitter, everything is a segment: the part S of the emitter, the faces that cross
//! the plane, and the chord of the face itself between the two of its corners that are seen as the outermost. A point of S
//! lights stretches of the faces behind the chord. Between two points of S the same features bound the same stretches,
//! unless a line through two of these features meets S in between: these critical points are computed, not searched.

use crate::scene::FaceId;
use glam::{DVec2, DVec3};

/// So many points of S are looked from at first; only what changes between two of them is looked into further.
const FIRST_POINTS: usize = 9;

/// Where the points lie between equal steps: irrational, because scenes line up at simple shares.
const OFFSET: f64 = 0.618_033_988_749_894_9;

/// The first and the last point are so near to the ends of S (a share of it): what changes nearer is not told apart.
const END_SHARE: f64 = 1.0 / 4096.0;

/// Halvings that find a change which no two features explain: as many as a double has bits.
const MOST_HALVINGS: u32 = 52;

/// A segment in the plane that stops light: a face that crosses it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Obstacle {
    /// The numbers of its ends among [`PlaneView::points`].
    pub(super) ends: [u32; 2],
    /// None where the plane passes exactly through an edge between faces.
    pub(super) face: Option<FaceId>,
}

/// What bounds a lit stretch: something that a ray touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    /// A corner of the face or the end of an obstacle.
    Point(u32),
    /// Where two obstacles cross: faces that pierce each other.
    Crossing(u32, u32),
    /// Where an obstacle crosses the chord between two corners.
    OnChord(u32, [u32; 2]),
}

/// A stretch of an obstacle that a point of S lights, from ray to ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stretch {
    pub(super) face: FaceId,
    pub(super) ends: [Feature; 2],
}

/// A part of S (shares of it) from which the same features bound the lit stretches.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) lit: Vec<Stretch>,
}

/// The plane with its contents. The first coordinate runs along S from its start, the second away from the emitter.
pub(super) struct PlaneView {
    /// Length of S, metres.
    pub(super) length: f64,
    /// The points that bound anything: plane coordinates and position. Points at one place have one number.
    pub(super) points: Vec<(DVec2, DVec3)>,
    /// The numbers of the face's own corners.
    pub(super) corners: Vec<u32>,
    pub(super) obstacles: Vec<Obstacle>,
    /// Within this distance points are the same, metres.
    pub(super) tol: f64,
}

/// A ray from the apex: how far it goes sideways for each metre ahead. Seen from the apex an obstacle is a section from ray to
/// ray, and one over its distance ahead runs linearly in between.
#[derive(Clone, Copy)]
struct Section {
    obstacle: u32,
    rays: [f64; 2],
    /// One over the distance ahead at both rays, 1/m.
    nearness: [f64; 2],
    ends: [u32; 2],
}

impl Section {
    fn nearness_at(&self, ray: f64) -> f64 {
        let [a, b] = self.nearness;
        a + (b - a) * ((ray - self.rays[0]) / (self.rays[1] - self.rays[0]))
    }
}

impl PlaneView {
    /// Gives all points at one place the number of the first of them.
    pub(super) fn unite_points(&mut self) {
        let mut order: Vec<u32> = (0..self.points.len() as u32).collect();
        let at = |i: u32| self.points[i as usize].0;
        order.sort_by(|&a, &b| at(a).x.total_cmp(&at(b).x).then(a.cmp(&b)));
        let mut number: Vec<u32> = (0..self.points.len() as u32).collect();
        for (k, &i) in order.iter().enumerate() {
            let near = order[..k].iter().rev();
            let mut near = near.take_while(|&&j| at(i).x - at(j).x <= self.tol);
            if let Some(&j) = near.find(|&&j| at(i).distance(at(j)) <= self.tol) {
                number[i as usize] = number[j as usize];
            }
        }
        for c in &mut self.corners {
            *c = number[*c as usize];
        }
        self.corners.sort_unstable();
        self.corners.dedup();
        for o in &mut self.obstacles {
            o.ends = o.ends.map(|e| number[e as usize]);
        }
        self.obstacles.retain(|o| o.ends[0] != o.ends[1]);
    }

    /// The parts of S by what they light, in order; none where nothing is lit from anywhere.
    pub(super) fn cells(&self) -> Vec<Cell> {
        if self.corners.len() < 2 {
            return Vec::new();
        }
        let step = |i: usize| (i as f64 + OFFSET) / FIRST_POINTS as f64;
        let mut shares = vec![END_SHARE * OFFSET];
        shares.extend((0..FIRST_POINTS).map(step));
        shares.push(1.0 - END_SHARE * OFFSET);
        let seen: Vec<(f64, Vec<Stretch>)> =
            shares.into_iter().map(|s| (s, self.lit_from(s))).collect();
        let mut cells = vec![Cell {
            from: 0.0,
            to: 1.0,
            lit: seen[0].1.clone(),
        }];
        for pair in seen.windows(2) {
            self.part(&pair[0], &pair[1], MOST_HALVINGS, &mut cells);
        }
        cells.retain(|c| !c.lit.is_empty());
        cells
    }

    /// Ends the last of `cells` and begins others where what is lit changes between two points.
    fn part(
        &self,
        before: &(f64, Vec<Stretch>),
        after: &(f64, Vec<Stretch>),
        halvings: u32,
        cells: &mut Vec<Cell>,
    ) {
        if before.1 == after.1 {
            return;
        }
        let critical = self.critical_between(before, after);
        let middle = match critical.as_slice() {
            [] => 0.5 * (before.0 + after.0),
            [only] => *only,
            many => 0.5 * (many[many.len() / 2 - 1] + many[many.len() / 2]),
        };
        let is_narrow = (after.0 - before.0) * self.length <= self.tol;
        if critical.len() == 1 || halvings == 0 || is_narrow {
            if let Some(last) = cells.last_mut() {
                last.to = middle;
            }
            cells.push(Cell {
                from: middle,
                to: 1.0,
                lit: after.1.clone(),
            });
            return;
        }
        let between = (middle, self.lit_from(middle));
        self.part(before, &between, halvings - 1, cells);
        self.part(&between, after, halvings - 1, cells);
    }

    /// The shares of S, sorted, that lie on a line through two features of the stretches that change, each once.
    fn critical_between(
        &self,
        (from, before): &(f64, Vec<Stretch>),
        (to, after): &(f64, Vec<Stretch>),
    ) -> Vec<f64> {
        let gone = before.iter().filter(|s| !after.contains(s));
        let new = after.iter().filter(|s| !before.contains(s));
        let mut features: Vec<Feature> = Vec::new();
        for f in gone.chain(new).flat_map(|s| s.ends) {
            if !features.contains(&f) {
                features.push(f);
            }
        }
        let places: Vec<DVec2> = features.iter().map(|&f| self.place(f)).collect();
        let mut shares = Vec::new();
        for (i, &p) in places.iter().enumerate() {
            for &q in &places[..i] {
                let share = (p.x - p.y * ((q.x - p.x) / (q.y - p.y))) / self.length;
                if share > *from && share < *to {
                    shares.push(share);
                }
            }
        }
        shares.sort_unstable_by(f64::total_cmp);
        shares.dedup_by(|b, a| (*b - *a) * self.length <= self.tol);
        shares
    }

    /// Where a feature is, plane coordinates.
    fn place(&self, feature: Feature) -> DVec2 {
        let segment = |[a, b]: [u32; 2]| [self.at(a), self.at(b)];
        let ends = |o: u32| segment(self.obstacles[o as usize].ends);
        match feature {
            Feature::Point(i) => self.at(i),
            Feature::Crossing(a, b) => meeting(ends(a), ends(b)),
            Feature::OnChord(o, chord) => meeting(ends(o), segment(chord)),
        }
    }

    /// The position of a feature that is a point of the scene; of others the place in the plane.
    pub(super) fn position(&self, feature: Feature) -> Result<DVec3, DVec2> {
        match feature {
            Feature::Point(i) => Ok(self.points[i as usize].1),
            other => Err(self.place(other)),
        }
    }

    fn at(&self, point: u32) -> DVec2 {
        self.points[point as usize].0
    }

    /// The section from ray to ray, in order.
    fn section(&self, apex: f64, obstacle: u32, ends: [u32; 2]) -> Section {
        let ray = |i: u32| {
            let p = self.at(i);
            (p.x - apex) / p.y
        };
        let [a, b] = ends;
        let ends = if ray(a) <= ray(b) { [a, b] } else { [b, a] };
        Section {
            obstacle,
            rays: ends.map(ray),
            nearness: ends.map(|i| 1.0 / self.at(i).y),
            ends,
        }
    }

    /// What a point of S lights past the face.
    fn lit_from(&self, share: f64) -> Vec<Stretch> {
        let apex = share * self.length;
        let ray = |i: &u32| (self.at(*i).x - apex) / self.at(*i).y;
        let by_ray = |a: &&u32, b: &&u32| ray(a).total_cmp(&ray(b));
        let outermost = (
            self.corners.iter().min_by(by_ray),
            self.corners.iter().max_by(by_ray),
        );
        let (Some(&left), Some(&right)) = outermost else {
            return Vec::new();
        };
        let chord = self.section(apex, u32::MAX, [left, right]);
        let mut sections: Vec<Section> = Vec::new();
        for (i, o) in self.obstacles.iter().enumerate() {
            let s = self.section(apex, i as u32, o.ends);
            if s.rays[1] > chord.rays[0] && s.rays[0] < chord.rays[1] {
                sections.push(s);
            }
        }
        Sweep {
            view: self,
            chord,
            sections,
        }
        .lit()
    }
}

/// Where the lines through two segments meet.
fn meeting([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> DVec2 {
    let (r, s) = (b - a, d - c);
    a + r * ((c - a).perp_dot(s) / r.perp_dot(s))
}

/// Rays from one apex, from left to right across the chord.
struct Sweep<'v> {
    view: &'v PlaneView,
    chord: Section,
    sections: Vec<Section>,
}

/// A ray at which something begins or ends.
type Event = (f64, Feature);

impl Sweep<'_> {
    /// The lit stretches in order.
    fn lit(mut self) -> Vec<Stretch> {
        self.sections
            .sort_by(|a, b| a.rays[0].total_cmp(&b.rays[0]));
        let events = self.events();
        let mut out: Vec<Stretch> = Vec::new();
        let mut open = false;
        let (mut next, mut active): (usize, Vec<usize>) = (0, Vec::new());
        for pair in events.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            while next < self.sections.len() && self.sections[next].rays[0] <= from.0 {
                active.push(next);
                next += 1;
            }
            active.retain(|&i| self.sections[i].rays[1] > from.0);
            // Points on one ray: nothing is seen between them.
            let ahead = 1.0 / self.chord.nearness_at(0.5 * (from.0 + to.0));
            if (to.0 - from.0) * ahead <= self.view.tol {
                continue;
            }
            self.between(&active, from, to, &mut |face, ends| {
                match (out.last_mut(), face) {
                    (Some(last), Some(face)) if open && last.face == face => last.ends[1] = ends[1],
                    (_, Some(face)) => out.push(Stretch { face, ends }),
                    (_, None) => {}
                }
                open = face.is_some();
            });
        }
        out
    }

    /// The rays at which sections begin, end or cross the chord, sorted, from the chord's left end to its right one.
    fn events(&self) -> Vec<Event> {
        let [left, right] = self.chord.ends;
        let [first, last] = self.chord.rays;
        let mut events = vec![(first, Feature::Point(left)), (last, Feature::Point(right))];
        for s in &self.sections {
            for (ray, end) in s.rays.into_iter().zip(s.ends) {
                events.push((ray, Feature::Point(end)));
            }
            let (from, to) = (s.rays[0].max(first), s.rays[1].min(last));
            let gap = |ray: f64| s.nearness_at(ray) - self.chord.nearness_at(ray);
            let (a, b) = (gap(from), gap(to));
            if a * b < 0.0 {
                let feature = Feature::OnChord(s.obstacle, [left, right]);
                events.push((from + (to - from) * (a / (a - b)), feature));
            }
        }
        events.retain(|e| e.0 >= first && e.0 <= last);
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        events
    }

    /// Reports what is lit between two rays, between which no section begins, ends or crosses the chord.
    fn between(
        &self,
        active: &[usize],
        from: Event,
        to: Event,
        report: &mut impl FnMut(Option<FaceId>, [Feature; 2]),
    ) {
        let middle = 0.5 * (from.0 + to.0);
        let rim = 1.0 / self.chord.nearness_at(middle);
        // What lies on the chord stops the light without a line; what lies before it hides all.
        let (mut nearest, mut is_stopped): (Option<&Section>, bool) = (None, false);
        for s in active.iter().map(|&i| &self.sections[i]) {
            let ahead = 1.0 / s.nearness_at(middle);
            if ahead <= rim + self.view.tol {
                is_stopped = true;
            } else if nearest.is_none_or(|n| s.nearness_at(middle) > n.nearness_at(middle)) {
                nearest = Some(s);
            }
        }
        let Some(top) = nearest.filter(|_| !is_stopped) else {
            report(None, [from.1, to.1]);
            return;
        };
        // Another section may be nearer at an end: faces that pierce each other.
        for end in [from.0, to.0] {
            let other = active
                .iter()
                .map(|&i| &self.sections[i])
                .max_by(|a, b| a.nearness_at(end).total_cmp(&b.nearness_at(end)));
            let Some(other) = other.filter(|o| o.obstacle != top.obstacle) else {
                continue;
            };
            let gap = |ray: f64| other.nearness_at(ray) - top.nearness_at(ray);
            let (g_end, g_middle) = (gap(end), -gap(middle));
            let cut = end + (middle - end) * (g_end / (g_end + g_middle));
            let width = |a: f64, b: f64| (b - a) * rim;
            let is_inside = width(from.0, cut) > self.view.tol && width(cut, to.0) > self.view.tol;
            if g_end > 0.0 && is_inside {
                let (a, b) = (top.obstacle, other.obstacle);
                let crossing = (cut, Feature::Crossing(a.min(b), a.max(b)));
                self.between(active, from, crossing, report);
                self.between(active, crossing, to, report);
                return;
            }
        }
        let face = self.view.obstacles[top.obstacle as usize].face;
        report(face, [from.1, to.1]);
    }
}
