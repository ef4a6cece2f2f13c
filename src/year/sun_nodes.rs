//! Fewer suns than hours: a grid over the sun's paths of the year. Sunlight reflected by surfaces is interpolated between its
//! nodes.
//!
//! The grid uses declination and hour angle. In these coordinates the sun of every hour of a year has a neighbour within a degree
//! or two. A shadow ray to a node serves all these suns. A sample of their own suns corrects the rest (docs/methods.md, section
//! 27). Direct sunlight has sharp edges and is sampled at each hour's own position.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec3;

use crate::estimators::sunlight::Suns;

/// Steps of the grid in degrees of declination and of hour angle.
const STEP_DEG: f64 = 4.0;
/// Number of nodes around a sun.
const AROUND: usize = 4;

/// Nodes, and the weights of the nodes for each sun.
#[derive(Clone, Debug)]
pub(super) struct SunNodes {
    /// The nodes as suns of 1 lx perpendicular to their rays.
    pub suns: Suns,
    /// For each sun the surrounding nodes with their weights, which add up to 1.
    around: Vec<[(u32, f64); AROUND]>,
    /// The fields of the grid that contain suns; empty if the suns themselves are nodes.
    pub fields: Vec<SunField>,
    /// The suns of all fields, field by field.
    in_fields: Vec<u16>,
}

/// A field of the grid.
#[derive(Clone, Debug)]
pub(super) struct SunField {
    /// The nodes at its corners; `None` for a corner below the horizon.
    pub corners: [Option<u32>; AROUND],
    suns: Range<usize>,
}

impl SunNodes {
    /// Nodes for suns seen from a latitude. If the suns are not more than the nodes, each sun is its own node.
    pub fn of(suns: &Suns, latitude_deg: f64) -> SunNodes {
        let frame = EquinoxAxes::at(latitude_deg);
        let corners: Vec<[(SunNode, f64); AROUND]> =
            suns.towards.iter().map(|towards| frame.corners(*towards)).collect();
        let used = corners.iter().flatten().filter(|(_, weight)| *weight > 0.0).map(|(node, _)| (*node, 0));
        let mut numbers: BTreeMap<SunNode, u32> = used.collect();
        if numbers.len() >= suns.towards.len() {
            return SunNodes::themselves(suns);
        }
        numbers.values_mut().zip(0..).for_each(|(place, number)| *place = number);
        let mut by_field: BTreeMap<[SunNode; AROUND], Vec<u16>> = BTreeMap::new();
        for (sun, corners) in corners.iter().enumerate() {
            by_field.entry(corners.map(|(node, _)| node)).or_default().push(sun as u16);
        }
        let (mut fields, mut in_fields) = (Vec::with_capacity(by_field.len()), Vec::with_capacity(corners.len()));
        for (nodes, suns) in by_field {
            let first = in_fields.len();
            in_fields.extend(suns);
            let corners = nodes.map(|node| numbers.get(&node).copied());
            fields.push(SunField { corners, suns: first..in_fields.len() });
        }
        let around = corners
            .iter()
            .map(|corners| corners.map(|(node, weight)| (numbers.get(&node).copied().unwrap_or_default(), weight)));
        let around = around.collect();
        let towards = numbers.keys().map(|node| frame.towards(*node)).collect();
        SunNodes { suns: Suns { towards, disk: suns.disk }, around, fields, in_fields }
    }

    /// Makes each sun its own node.
    pub fn themselves(suns: &Suns) -> SunNodes {
        let itself = (0..suns.towards.len() as u32).map(|sun| [(sun, 1.0), (sun, 0.0), (sun, 0.0), (sun, 0.0)]);
        SunNodes { suns: suns.clone(), around: itself.collect(), fields: vec![], in_fields: vec![] }
    }

    /// The suns in a field, in the order of time.
    pub fn suns_in(&self, field: &SunField) -> &[u16] {
        &self.in_fields[field.suns.clone()]
    }

    /// Interpolates a value of the nodes for a sun.
    #[inline]
    pub fn between(&self, sun: usize, of_node: impl Fn(usize) -> f64) -> f64 {
        self.around(sun).map(|(node, weight)| weight * of_node(node)).sum()
    }

    /// The nodes around a sun, with their weights.
    #[inline]
    pub fn around(&self, sun: usize) -> impl Iterator<Item = (usize, f64)> {
        let around = self.around[sun].iter().filter(|(_, weight)| *weight > 0.0);
        around.map(|(node, weight)| (*node as usize, *weight))
    }
}

/// A node by its step numbers of declination and of hour angle.
type SunNode = (i32, i32);

/// Axes: towards the pole, towards the sun at noon of an equinox, and west.
struct EquinoxAxes {
    pole: DVec3,
    noon: DVec3,
    west: DVec3,
}

impl EquinoxAxes {
    fn at(latitude_deg: f64) -> EquinoxAxes {
        let (sin, cos) = latitude_deg.to_radians().sin_cos();
        EquinoxAxes { pole: DVec3::new(0.0, cos, sin), noon: DVec3::new(0.0, -sin, cos), west: DVec3::NEG_X }
    }

    fn towards(&self, (declination, hour_angle): SunNode) -> DVec3 {
        let (sin, cos) = (STEP_DEG * f64::from(declination)).to_radians().sin_cos();
        let (across, along) = (STEP_DEG * f64::from(hour_angle)).to_radians().sin_cos();
        sin * self.pole + cos * (along * self.noon + across * self.west)
    }

    /// The nodes around a direction with their bilinear weights. The weights of nodes below the horizon are given to the others.
    fn corners(&self, towards: DVec3) -> [(SunNode, f64); AROUND] {
        let declination = towards.dot(self.pole).clamp(-1.0, 1.0).asin().to_degrees() / STEP_DEG;
        let hour_angle = towards.dot(self.west).atan2(towards.dot(self.noon)).to_degrees() / STEP_DEG;
        let (row, column) = (declination.floor(), hour_angle.floor());
        let (up, on) = (declination - row, hour_angle - column);
        let turn = (360.0 / STEP_DEG) as i32;
        let node = |i: i32, j: i32| (row as i32 + i, (column as i32 + j).rem_euclid(turn));
        let mut corners = [
            (node(0, 0), (1.0 - up) * (1.0 - on)),
            (node(0, 1), (1.0 - up) * on),
            (node(1, 0), up * (1.0 - on)),
            (node(1, 1), up * on),
        ];
        for (node, weight) in &mut corners {
            *weight *= f64::from(u8::from(self.towards(*node).z > 0.0));
        }
        let all: f64 = corners.iter().map(|(_, weight)| weight).sum();
        if all > 0.0 {
            corners.iter_mut().for_each(|(_, weight)| *weight /= all);
        } else {
            corners[0].1 = 1.0;
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::solar_position::{Moment, direction_of, solar_position_deg};
    use crate::base::sun::Sun;

    /// Checks the suns of a year at 52° N. The nodes are at most a seventh of the suns, above the horizon, and within a step of the
    /// sun. Interpolation of a smooth function of direction is accurate to 0.2%. Planted fault: the nearest node alone is not. Few
    /// suns are their own nodes.
    #[test]
    fn nodes_stand_for_suns() {
        let disk = Sun::of_normal(DVec3::Z, 1.0);
        let at = |day: u32, hour: u32| {
            let moment = Moment::of_date(2026, 1 + day / 28, 1 + day % 28, f64::from(hour) - 0.5);
            let [elevation_deg, azimuth_deg] = solar_position_deg(52.0, 13.0, moment);
            (elevation_deg > 0.0).then(|| direction_of(elevation_deg, azimuth_deg))
        };
        let towards: Vec<DVec3> = (0..336).flat_map(|day| (0..24).filter_map(move |hour| at(day, hour))).collect();
        let suns = Suns { towards, disk: [disk.sine(), disk.one_minus_cosine()] };
        let nodes = SunNodes::of(&suns, 52.0);
        assert!(7 * nodes.suns.towards.len() < suns.towards.len(), "{}", nodes.suns.towards.len());
        assert!(nodes.suns.towards.iter().all(|towards| towards.z > 0.0));
        let smooth = |towards: DVec3| 2.0 + towards.dot(DVec3::new(0.5, -0.7, 0.5)).powi(3);
        let (mut worst, mut worst_of_nearest) = (0.0f64, 0.0f64);
        for (sun, towards) in suns.towards.iter().enumerate().filter(|(_, towards)| towards.z > 0.15) {
            let around: Vec<(usize, f64)> = nodes.around(sun).collect();
            let value = |(node, weight): &(usize, f64)| weight * smooth(nodes.suns.towards[*node]);
            assert!((around.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(around.iter().all(|(node, _)| nodes.suns.towards[*node].dot(*towards) > 0.994));
            worst = worst.max((around.iter().map(value).sum::<f64>() / smooth(*towards) - 1.0).abs());
            let nearest = around.iter().max_by(|one, other| one.1.total_cmp(&other.1)).expect("a node");
            worst_of_nearest = worst_of_nearest.max((value(&(nearest.0, 1.0)) / smooth(*towards) - 1.0).abs());
        }
        assert!(worst < 0.002 && worst_of_nearest > 0.01, "{worst}, {worst_of_nearest}");
        let few = Suns { towards: suns.towards[..3].to_vec(), disk: suns.disk };
        assert_eq!(SunNodes::of(&few, 52.0).suns.towards, few.towards);
    }
}
