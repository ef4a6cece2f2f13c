//! stub
use crate::scene::photometry::IntensityWeb;
use glam::DVec3;
#[derive(Clone, Debug)]
pub struct WebSampler;
impl WebSampler {
    pub fn new(_w: &IntensityWeb) -> Self {
        WebSampler
    }
    pub fn sample(&self, _u: [f64; 2]) -> DVec3 {
        DVec3::Z
    }
}
impl IntensityWeb {
    pub fn intensity_towards_cd(&self, _f: &[DVec3; 3], _d: DVec3) -> f64 {
        0.0
    }
}
