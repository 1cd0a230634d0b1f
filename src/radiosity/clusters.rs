//! Sides that lie together, as a tree: what is far or faint is looked at many sides at a time.
//!
//! A row that asked every side would cost as much as there are sides, for each of as many nodes. Here a cluster whose sides
//! together send less than one ray may be wrong by is judged by one ray, to one of its sides: chosen once for all viewpoints,
//! with probability proportional to the light it sends, so that the choice is right in the mean and neighbouring points
//! agree on it (Walter et al. 2005, *Lightcuts*).

use super::cells::FaceLight;
use super::{SolveFace, SolveMesh};
use crate::visibility::Viewpoint;
use glam::DVec3;
use std::f64::consts::PI;

/// A node of the tree.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// One side, its number.
    Side(u32),
    /// The numbers of two nodes, both smaller than its own.
    Pair([u32; 2]),
}

#[derive(Clone, Copy, Debug)]
struct Cluster {
    kind: Kind,
    /// Bounding box, metres.
    lowest: DVec3,
    highest: DVec3,
}

/// The tree over all sides that reflect; children come before their parents.
#[derive(Clone, Debug, Default)]
pub(super) struct Clusters {
    nodes: Vec<Cluster>,
}

/// What a cluster sends.
#[derive(Clone, Copy, Debug)]
struct Power {
    /// Area times radiosity: a bound of it, W.
    total: f64,
    /// One of its sides …
    side: u32,
    /// … and what that one sends of the total, W.
    own: f64,
}

/// The light of all sides, and of the clusters that they make.
#[derive(Clone, Debug)]
pub(super) struct Sources {
    pub(super) faces: Vec<FaceLight>,
    /// What may come on top of it: RMS distance from a linear function and range over a whole face, before reflection, W/m².
    pub(super) ambient: f64,
    powers: Vec<Power>,
}

/// What is to be looked at.
pub(super) enum Source {
    /// A side.
    Side(usize),
    /// A side that stands for others, too, with so many times its own light.
    Delegate { side: usize, times: f64 },
}

/// Below which irradiance (W/m²) …
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// … a cluster is left out.
    pub(super) skip: f64,
    /// … one side may stand for all.
    pub(super) ray: f64,
}

impl Clusters {
    /// The tree over those of `faces` that reflect: halved at the median along the longest extent of their middles.
    pub(super) fn new(faces: &[SolveFace]) -> Self {
        let reflecting = |f: &u32| !faces[*f as usize].reflectance.is_black();
        let mut sides: Vec<u32> = (0..faces.len() as u32).filter(reflecting).collect();
        let mut tree = Self::default();
        if !sides.is_empty() {
            tree.build(faces, &mut sides);
        }
        tree
    }

    /// Appends the tree over `sides` and returns its number.
    fn build(&mut self, faces: &[SolveFace], sides: &mut [u32]) -> u32 {
        let cluster = match *sides {
            [side] => {
                let corners = faces[side as usize].rectangle;
                Cluster {
                    kind: Kind::Side(side),
                    lowest: corners.into_iter().fold(DVec3::INFINITY, DVec3::min),
                    highest: corners.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max),
                }
            }
            _ => {
                let middle = |s: &u32| faces[*s as usize].centre;
                let lowest = sides.iter().map(middle).fold(DVec3::INFINITY, DVec3::min);
                let highest = sides.iter().map(middle);
                let extent = highest.fold(DVec3::NEG_INFINITY, DVec3::max) - lowest;
                let axis = extent.max_position();
                let (half, _) = sides.split_at(sides.len() / 2);
                let half = half.len();
                sides.select_nth_unstable_by(half, |a, b| {
                    let order = middle(a)[axis].total_cmp(&middle(b)[axis]);
                    order.then(a.cmp(b))
                });
                let (left, right) = sides.split_at_mut(half);
                let pair = [self.build(faces, left), self.build(faces, right)];
                let [a, b] = pair.map(|n| self.nodes[n as usize]);
                Cluster {
                    kind: Kind::Pair(pair),
                    lowest: a.lowest.min(b.lowest),
                    highest: a.highest.max(b.highest),
                }
            }
        };
        self.nodes.push(cluster);
        self.nodes.len() as u32 - 1
    }

    /// Calls `sink` for all that `view` may see of `sources`, in an order that depends on the tree alone.
    pub(super) fn visit(
        &self,
        view: &Viewpoint,
        sources: &Sources,
        limits: Limits,
        mut sink: impl FnMut(Source),
    ) {
        let mut open: Vec<u32> = self
            .nodes
            .len()
            .checked_sub(1)
            .map(|n| n as u32)
            .into_iter()
            .collect();
        while let Some(n) = open.pop() {
            let (cluster, power) = (&self.nodes[n as usize], &sources.powers[n as usize]);
            let pair = match cluster.kind {
                Kind::Side(side) => {
                    sink(Source::Side(side as usize));
                    continue;
                }
                Kind::Pair(pair) => pair,
            };
            let arriving = cluster.largest_kernel(view) * power.total;
            if arriving <= limits.skip {
                continue;
            }
            if arriving <= limits.ray {
                sink(Source::Delegate {
                    side: power.side as usize,
                    times: power.total / power.own,
                });
            } else {
                open.extend(pair.into_iter().rev());
            }
        }
    }
}

impl Cluster {
    /// A bound of what a square metre of the cluster that faces `view` sends there, as a share of its radiosity, 1/m².
    fn largest_kernel(&self, view: &Viewpoint) -> f64 {
        let (n, eye) = (view.horizon.normal, view.position);
        let half = 0.5 * (self.highest - self.lowest);
        let above = n.dot(self.lowest + half - eye) + n.abs().dot(half);
        if above <= 0.0 {
            return 0.0;
        }
        let nearest = eye.distance_squared(eye.clamp(self.lowest, self.highest));
        (above / nearest.sqrt()).min(1.0) / (PI * nearest)
    }
}

impl Sources {
    /// The light of the faces of `mesh` with up to `ambient` (W/m²) more on each before it is reflected.
    pub(super) fn new(mesh: &SolveMesh, faces: Vec<FaceLight>, ambient: f64) -> Self {
        let nodes = &mesh.clusters.nodes;
        let mut powers: Vec<Power> = Vec::with_capacity(nodes.len());
        for (n, cluster) in nodes.iter().enumerate() {
            powers.push(match cluster.kind {
                Kind::Side(side) => {
                    let face = &mesh.faces[side as usize];
                    let largest = faces[side as usize].largest;
                    let own = face.area * (largest + ambient * face.reflectance.0.max_element());
                    Power {
                        total: own,
                        side,
                        own,
                    }
                }
                Kind::Pair(pair) => {
                    let [a, b] = pair.map(|p| powers[p as usize]);
                    let total = a.total + b.total;
                    let chosen = if evenly_spread(n) * total < a.total {
                        a
                    } else {
                        b
                    };
                    Power { total, ..chosen }
                }
            });
        }
        Self {
            faces,
            ambient,
            powers,
        }
    }
}

/// Number `n` of a sequence that fills 0…1 evenly.
fn evenly_spread(n: usize) -> f64 {
    /// One over the golden ratio.
    const STEP: f64 = 0.618_033_988_749_894_9;
    (STEP * n as f64).fract()
}

#[cfg(test)]
mod tests {
    use super::super::tests::cube_mesh;
    use super::*;

    /// A view from near one corner of the cube into its middle.
    fn view() -> Viewpoint {
        Viewpoint::new(DVec3::splat(0.1), DVec3::ONE.normalize())
    }

    /// What a visit finds: every side with how often its own light counts.
    fn found(limits: Limits) -> Vec<(usize, f64)> {
        let mesh = cube_mesh(0.5);
        let light = |_| FaceLight {
            largest: 2.0,
            ..FaceLight::default()
        };
        let sources = Sources::new(&mesh, mesh.faces.iter().map(light).collect(), 0.0);
        let mut all = Vec::new();
        mesh.clusters
            .visit(&view(), &sources, limits, |what| match what {
                Source::Side(side) => all.push((side, 1.0)),
                Source::Delegate { side, times } => all.push((side, times)),
            });
        all.sort_by_key(|x| x.0);
        all
    }

    #[test]
    fn every_side_is_looked_at_where_no_ray_may_be_wrong() {
        let exact = Limits {
            skip: 0.0,
            ray: 0.0,
        };
        let all: Vec<(usize, f64)> = (0..6).map(|side| (side, 1.0)).collect();
        assert_eq!(found(exact), all);
    }

    #[test]
    fn one_side_stands_for_all_where_any_ray_may_be_wrong() {
        let rough = Limits {
            skip: 0.0,
            ray: f64::INFINITY,
        };
        // Six sides of equal area and light.
        assert!(matches!(found(rough)[..], [(_, times)] if (times - 6.0).abs() < 1e-12));
        let none = Limits {
            skip: f64::INFINITY,
            ray: f64::INFINITY,
        };
        assert!(found(none).is_empty());
    }

    #[test]
    fn black_sides_are_in_no_cluster() {
        let mesh = cube_mesh(0.0);
        assert!(mesh.clusters.nodes.is_empty());
        let sources = Sources::new(&mesh, vec![FaceLight::default(); 6], 1.0);
        let limits = Limits {
            skip: 0.0,
            ray: 0.0,
        };
        mesh.clusters
            .visit(&view(), &sources, limits, |_| panic!("a black side"));
    }
}
