//! Sides that lie together, as a tree: what is faint is left out, or to rays, many sides at a time.
//!
//! A row that asked every side would cost as much as there are sides, for each of as many nodes. Here a whole cluster is
//! passed over when even rays over the hemisphere tell what its sides send as well as is asked for.

use super::cells::FaceLight;
use super::sweep::Sweep;
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
#[derive(Clone, Copy, Debug, Default)]
struct Power {
    /// Area times radiosity: a bound of it, W.
    total: f64,
    /// The largest radiosity of any of its sides, W/m².
    brightest: f64,
}

/// The light of all sides, and of the clusters that they make.
#[derive(Clone, Debug)]
pub(super) struct Sources {
    pub(super) faces: Vec<FaceLight>,
    /// What may come on top of it: RMS distance from a linear function and range over a whole face, before reflection, W/m².
    pub(super) ambient: f64,
    powers: Vec<Power>,
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

    /// Calls `sink` for the sides whose light is to be cut exactly for `view`, as the rays of `sweep` will not do for them, in an order that depends on the tree alone.
    pub(super) fn visit(
        &self,
        view: &Viewpoint,
        sources: &Sources,
        sweep: Option<Sweep>,
        mut sink: impl FnMut(usize),
    ) {
        let mut open: Vec<u32> = Vec::from_iter(self.root());
        while let Some(n) = open.pop() {
            let (cluster, power) = (&self.nodes[n as usize], &sources.powers[n as usize]);
            let pair = match cluster.kind {
                Kind::Side(side) => {
                    sink(side as usize);
                    continue;
                }
                Kind::Pair(pair) => pair,
            };
            let arriving = cluster.largest_kernel(view) * power.total;
            let is_swept = |s: Sweep| s.is_enough(power.brightest, arriving);
            if arriving > 0.0 && !sweep.is_some_and(is_swept) {
                open.extend(pair.into_iter().rev());
            }
        }
    }

    fn root(&self) -> Option<u32> {
        self.nodes.len().checked_sub(1).map(|n| n as u32)
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
        for cluster in nodes {
            powers.push(match cluster.kind {
                Kind::Side(side) => {
                    let face = &mesh.faces[side as usize];
                    let brightest = brightest(face, &faces[side as usize], ambient);
                    Power {
                        total: face.area * brightest,
                        brightest,
                    }
                }
                Kind::Pair(pair) => {
                    let [a, b] = pair.map(|p| powers[p as usize]);
                    Power {
                        total: a.total + b.total,
                        brightest: a.brightest.max(b.brightest),
                    }
                }
            });
        }
        Self {
            faces,
            ambient,
            powers,
        }
    }

    /// A bound of what all sides send, W.
    pub(super) fn power(&self) -> f64 {
        self.powers.last().map_or(0.0, |root| root.total)
    }

    /// The largest radiosity that side `f` of `mesh` may have, W/m².
    pub(super) fn brightest(&self, mesh: &SolveMesh, f: usize) -> f64 {
        brightest(&mesh.faces[f], &self.faces[f], self.ambient)
    }
}

fn brightest(face: &SolveFace, light: &FaceLight, ambient: f64) -> f64 {
    light.largest + ambient * face.reflectance.0.max_element()
}

#[cfg(test)]
mod tests {
    use super::super::sweep::RAYS;
    use super::super::tests::cube_mesh;
    use super::*;

    /// A view from near one corner of the cube into its middle.
    fn view() -> Viewpoint {
        Viewpoint::new(DVec3::splat(0.1), DVec3::ONE.normalize())
    }

    /// The sides of a cube, all of radiosity `brightest` (W/m²), that are to be cut exactly.
    fn cut(brightest: f64, sweep: Option<Sweep>) -> Vec<usize> {
        let mesh = cube_mesh(0.5);
        let light = |_| FaceLight {
            largest: brightest,
            ..FaceLight::default()
        };
        let sources = Sources::new(&mesh, mesh.faces.iter().map(light).collect(), 0.0);
        let mut sides = Vec::new();
        mesh.clusters
            .visit(&view(), &sources, sweep, |side| sides.push(side));
        sides.sort_unstable();
        sides
    }

    #[test]
    fn every_side_is_cut_where_there_are_no_rays() {
        assert_eq!(cut(2.0, None), [0, 1, 2, 3, 4, 5]);
    }

    #[test]
    fn none_is_cut_where_rays_will_do_or_there_is_no_light() {
        let few = Sweep {
            noise: f64::INFINITY,
            together: f64::INFINITY,
            rays: RAYS,
        };
        assert!(cut(2.0, Some(few)).is_empty());
        assert!(cut(0.0, None).is_empty());
    }

    #[test]
    fn black_sides_are_in_no_cluster() {
        let mesh = cube_mesh(0.0);
        assert!(mesh.clusters.nodes.is_empty());
        let sources = Sources::new(&mesh, vec![FaceLight::default(); 6], 1.0);
        mesh.clusters
            .visit(&view(), &sources, None, |_| panic!("a black side"));
    }
}
