//! Reflection laws: how a packet that arrives at a surface leaves it.
//!
//! Every law has its four faces in a file of its own: `sample` draws whether and how a packet leaves, `pdf_per_sr` is
//! the density of the directions that survivors get, `eval_per_sr` the BRDF (or its like for the other side), `total`
//! the share that survives. Mirrors and panes send light into single directions: their `pdf` and `eval` are 0, since
//! no connection finds them.
//!
//! Sampling is analogue: a packet survives with a probability equal to the share that leaves, and a survivor carries
//! all of its flux on.

mod diffuse;
mod glass;
mod mirror;
mod phong;
mod translucent;

#[cfg(test)]
mod tests;

use glam::DVec3;

pub use diffuse::Diffuse;
pub use glass::Glass;
pub use mirror::Mirror;
pub use phong::Phong;
pub use translucent::Translucent;

use super::random::Stream;
use crate::scene::ReflectionLaw;

/// A reflection law, ready for sampling.
#[derive(Clone, Debug)]
pub enum Law {
    /// Lambert's law.
    Diffuse(Diffuse),
    /// A diffuse part and a lobe about the mirror direction.
    Phong(Box<Phong>),
    /// A mirror.
    Mirror(Mirror),
    /// A thin pane.
    Glass(Glass),
    /// Diffuse to both sides.
    Translucent(Translucent),
}

/// How a packet leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// Unit direction.
    pub direction: DVec3,
    /// By which way.
    pub way: Way,
}

/// The way that a packet takes off a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Reflected in all directions.
    Spread,
    /// Reflected in a lobe about the mirror direction.
    Lobe,
    /// Reflected as by a mirror.
    Mirrored,
    /// Passed on to the other side, its direction kept.
    Passed,
    /// Spread out on the other side.
    SpreadThrough,
}

impl Way {
    /// Whether it leads to the other side of the surface.
    #[inline]
    pub fn leads_through(self) -> bool {
        matches!(self, Way::Passed | Way::SpreadThrough)
    }
}

/// A pair of directions at a surface, both away from it: `towards` where light comes from, `leaving` where it goes;
/// `normal` is that of the side of `towards`.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// Unit normal.
    pub normal: DVec3,
    /// Unit direction to where the light comes from.
    pub towards: DVec3,
    /// Unit direction of the light that leaves.
    pub leaving: DVec3,
}

impl Pair {
    /// Cosine on the lit side.
    #[inline]
    pub fn cos_in(&self) -> f64 {
        self.normal.dot(self.towards)
    }

    /// Cosine of the leaving direction; negative on the other side.
    #[inline]
    pub fn cos_out(&self) -> f64 {
        self.normal.dot(self.leaving)
    }

    /// Cosine between the leaving direction and the mirror direction.
    #[inline]
    pub fn cos_alpha(&self) -> f64 {
        mirrored(-self.towards, self.normal).dot(self.leaving)
    }
}

/// A direction reflected at a plane with a unit normal.
#[inline]
pub fn mirrored(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

impl Law {
    /// Makes a law ready; a phong law tabulates its lobe's reflectance, some 20 ms.
    pub fn new(law: &ReflectionLaw) -> Law {
        match *law {
            ReflectionLaw::Diffuse { reflectance } => Law::Diffuse(Diffuse { reflectance }),
            ReflectionLaw::Phong { diffuse_reflectance, specular_reflectance, exponent } => {
                Law::Phong(Box::new(Phong::new(diffuse_reflectance, specular_reflectance, exponent)))
            }
            ReflectionLaw::Mirror { reflectance } => Law::Mirror(Mirror { reflectance }),
            ReflectionLaw::Glass { refractive_index, internal_transmittance } => {
                Law::Glass(Glass { refractive_index, internal_transmittance })
            }
            ReflectionLaw::Translucent { diffuse_reflectance, diffuse_transmittance } => {
                Law::Translucent(Translucent { reflectance: diffuse_reflectance, transmittance: diffuse_transmittance })
            }
        }
    }

    /// Draws whether a packet that travels along `direction` survives, and if so how it leaves the side with this unit
    /// normal.
    #[inline]
    pub fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        match self {
            Law::Diffuse(law) => law.sample(normal, stream),
            Law::Phong(law) => law.sample(direction, normal, stream),
            Law::Mirror(law) => law.sample(direction, normal, stream),
            Law::Glass(law) => law.sample(direction, normal, stream),
            Law::Translucent(law) => law.sample(normal, stream),
        }
    }

    /// Density per sr of the directions that [`Law::sample`] gives to survivors.
    pub fn pdf_per_sr(&self, pair: &Pair) -> f64 {
        match self {
            Law::Diffuse(law) => law.pdf_per_sr(pair),
            Law::Phong(law) => law.pdf_per_sr(pair),
            Law::Mirror(_) | Law::Glass(_) => 0.0,
            Law::Translucent(law) => law.pdf_per_sr(pair),
        }
    }

    /// Luminance that leaves for each lx that arrives, in cd/m² per lx (the BRDF, per sr; behind the surface the BTDF).
    pub fn eval_per_sr(&self, pair: &Pair) -> f64 {
        match self {
            Law::Diffuse(law) => law.eval_per_sr(pair),
            Law::Phong(law) => law.eval_per_sr(pair),
            Law::Mirror(_) | Law::Glass(_) => 0.0,
            Law::Translucent(law) => law.eval_per_sr(pair),
        }
    }

    /// Share of the light that leaves again, on either side, if it arrives under an angle of this cosine.
    #[inline]
    pub fn total(&self, cos_in: f64) -> f64 {
        match self {
            Law::Diffuse(law) => law.total(),
            Law::Phong(law) => law.total(),
            Law::Mirror(law) => law.total(),
            Law::Glass(law) => law.total(cos_in),
            Law::Translucent(law) => law.total(),
        }
    }

    /// Whether all light that arrives is absorbed.
    #[inline]
    pub fn is_black(&self) -> bool {
        match self {
            Law::Glass(_) => false,
            law => law.total(1.0) <= 0.0,
        }
    }

    /// Whether it spreads light, so that a walk looks for luminaires there.
    pub fn scatters(&self) -> bool {
        !self.is_black() && !matches!(self, Law::Mirror(_) | Law::Glass(_))
    }

    /// Share of the light that is reflected as by a mirror, at an angle of this cosine.
    pub fn mirror_share(&self, cos_in: f64) -> f64 {
        match self {
            Law::Mirror(law) => law.total(),
            Law::Glass(law) => law.shares(cos_in)[0],
            Law::Diffuse(_) | Law::Phong(_) | Law::Translucent(_) => 0.0,
        }
    }

    /// Whether it reflects as a mirror does, at least in part.
    pub fn is_mirror(&self) -> bool {
        match self {
            Law::Mirror(law) => law.total() > 0.0,
            Law::Glass(law) => law.refractive_index > 1.0,
            Law::Diffuse(_) | Law::Phong(_) | Law::Translucent(_) => false,
        }
    }
}
