//! BSDFs: how a packet that arrives at a surface leaves it.
//!
//! Every BSDF has its own file and implements one trait, [`Reflection`]. `sample` draws whether and how a packet leaves. `pdf_per_sr` is
//! the density of the directions of the survivors. `eval_per_sr` is the BRDF (or the BTDF for the other side). `total` is the share that
//! survives. Mirrors and panes send light into single directions: their `pdf` and `eval` are 0, because no connection finds them. The list
//! of all BSDFs is in this file, in one place: the call of `bsdfs!`.
//!
//! Sampling is analogue: a packet survives with a probability equal to the share that leaves, and a survivor keeps all of its flux. (Walks
//! carry weights from diffuse surfaces: see [`crate::transport::Roulette`].)

mod blinn;
mod diffuse;
mod glass;
mod glossy;
mod lossless;
mod mirror;
mod phong;
mod translucent;

#[cfg(test)]
mod tests;

use glam::DVec3;

pub use blinn::Blinn;
pub use diffuse::Diffuse;
pub use glass::Glass;
pub use glossy::Glossy;
pub(super) use lossless::draw_power_of_cosine;
pub use mirror::Mirror;
pub use phong::Phong;
pub use translucent::Translucent;

use super::random::Stream;
use crate::scene::BsdfParameters;

/// The functions of a BSDF.
pub trait Reflection {
    /// Draws whether a packet that travels along `direction` survives, and if so how it leaves the side with this unit normal.
    fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered>;

    /// Returns the share of the light that leaves again, on either side, if it arrives at an angle with this cosine.
    fn total(&self, cos_in: f64) -> f64;

    /// Returns the density per sr of the directions that [`Reflection::sample`] gives to survivors.
    fn pdf_per_sr(&self, _: &Pair) -> f64 {
        0.0
    }

    /// Returns the luminance that leaves per lx that arrives, in cd/m² per lx (the BRDF, per sr; behind the surface the BTDF).
    fn eval_per_sr(&self, pair: &Pair) -> f64 {
        self.lobe_per_sr(pair) + self.spread_per_sr(pair)
    }

    /// Returns the part of the BRDF around one direction. Packets leave by it with [`LobeKind::Glossy`].
    fn lobe_per_sr(&self, _: &Pair) -> f64 {
        0.0
    }

    /// Returns the smooth part of the BRDF, which connections find well.
    fn spread_per_sr(&self, _: &Pair) -> f64 {
        0.0
    }

    /// Returns the reflectance of the diffuse part of a glossy BSDF; 0 for BSDFs without a lobe.
    fn diffuse_part(&self) -> f64 {
        0.0
    }

    /// Returns the width of the lobe of a glossy BSDF in rad, about its standard deviation. `None` for BSDFs without a lobe.
    fn lobe_width_rad(&self) -> Option<f64> {
        None
    }

    /// Draws how a packet leaves by the rest of a glossy BSDF, the lobe and the term that compensates its losses. This rest has a
    /// probability of `total` minus `diffuse_part`. `None` for BSDFs without a lobe.
    fn sample_gloss(&self, _direction: DVec3, _normal: DVec3, _: &mut Stream) -> Option<Scattered> {
        None
    }

    /// Whether all light leaves in single directions, so that no connection finds it.
    fn is_specular(&self) -> bool {
        false
    }

    /// Returns the share of the light that is reflected as by a mirror, at an angle with this cosine.
    fn mirror_share(&self, _cos_in: f64) -> f64 {
        0.0
    }

    /// Whether it reflects as a mirror, at least in part.
    fn is_mirror(&self) -> bool {
        false
    }
}

/// Makes the list of BSDFs. For each it needs a description, its type here, and how that is made from the BSDF of a scene.
macro_rules! bsdfs {
    ($($(#[$what:meta])* $bsdf:ident($ready:ty) from $given:pat => $made:expr;)*) => {
        /// A BSDF, ready for sampling.
        #[derive(Clone, Debug)]
        pub enum Bsdf {
            $($(#[$what])* $bsdf($ready),)*
        }

        impl Bsdf {
            /// Makes a BSDF ready for sampling. A BSDF with a lobe tabulates the lobe's losses, which takes about 20 ms.
            pub fn new(bsdf: &BsdfParameters) -> Bsdf {
                match *bsdf {
                    $($given => Bsdf::$bsdf($made),)*
                }
            }
        }

        /// Calls one method of whichever BSDF it is.
        macro_rules! of_bsdf {
            ($any:expr, $one:ident => $call:expr) => {
                match $any {
                    $(Bsdf::$bsdf($one) => $call,)*
                }
            };
        }
    };
}

bsdfs! {
    /// Lambert's law.
    Diffuse(Diffuse) from BsdfParameters::Diffuse { reflectance } => Diffuse { reflectance };
    /// A diffuse part and a lobe about the mirror direction.
    Phong(Box<Glossy<Phong>>) from BsdfParameters::Phong { diffuse_reflectance, specular_reflectance, exponent } =>
        Box::new(Glossy::new(diffuse_reflectance, specular_reflectance, Phong { exponent }));
    /// A diffuse part and a lobe about the half vector.
    Blinn(Box<Glossy<Blinn>>) from BsdfParameters::Blinn { diffuse_reflectance, specular_reflectance, exponent } =>
        Box::new(Glossy::new(diffuse_reflectance, specular_reflectance, Blinn { exponent }));
    /// A mirror.
    Mirror(Mirror) from BsdfParameters::Mirror { reflectance } => Mirror { reflectance };
    /// A thin pane.
    Glass(Glass) from BsdfParameters::Glass { refractive_index, internal_transmittance, glazed_share } =>
        Glass { refractive_index, internal_transmittance, glazed_share };
    /// Diffuse to both sides.
    Translucent(Translucent) from BsdfParameters::Translucent { diffuse_reflectance, diffuse_transmittance } =>
        Translucent { reflectance: diffuse_reflectance, transmittance: diffuse_transmittance };
}

/// The methods of [`Reflection`] for whichever BSDF it is.
#[expect(missing_docs, reason = "see the trait")]
impl Bsdf {
    #[inline]
    pub fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        of_bsdf!(self, bsdf => bsdf.sample(direction, normal, stream))
    }

    #[inline]
    pub fn total(&self, cos_in: f64) -> f64 {
        of_bsdf!(self, bsdf => bsdf.total(cos_in))
    }

    pub fn pdf_per_sr(&self, pair: &Pair) -> f64 {
        of_bsdf!(self, bsdf => bsdf.pdf_per_sr(pair))
    }

    pub fn eval_per_sr(&self, pair: &Pair) -> f64 {
        of_bsdf!(self, bsdf => bsdf.eval_per_sr(pair))
    }

    pub fn lobe_per_sr(&self, pair: &Pair) -> f64 {
        of_bsdf!(self, bsdf => bsdf.lobe_per_sr(pair))
    }

    pub fn spread_per_sr(&self, pair: &Pair) -> f64 {
        of_bsdf!(self, bsdf => bsdf.spread_per_sr(pair))
    }

    /// Shares of the light that surfaces without lobes scatter diffusely to the lit side and to the other side; 0 for others.
    #[inline]
    pub fn diffuse_shares(&self) -> [f64; 2] {
        match self {
            Bsdf::Diffuse(bsdf) => [bsdf.reflectance, 0.0],
            Bsdf::Translucent(bsdf) => [bsdf.reflectance, bsdf.transmittance],
            _ => [0.0; 2],
        }
    }

    pub fn diffuse_part(&self) -> f64 {
        of_bsdf!(self, bsdf => bsdf.diffuse_part())
    }

    pub fn lobe_width_rad(&self) -> Option<f64> {
        of_bsdf!(self, bsdf => bsdf.lobe_width_rad())
    }

    pub fn sample_gloss(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        of_bsdf!(self, bsdf => bsdf.sample_gloss(direction, normal, stream))
    }

    #[inline]
    pub fn is_specular(&self) -> bool {
        of_bsdf!(self, bsdf => bsdf.is_specular())
    }

    pub fn mirror_share(&self, cos_in: f64) -> f64 {
        of_bsdf!(self, bsdf => bsdf.mirror_share(cos_in))
    }

    pub fn is_mirror(&self) -> bool {
        of_bsdf!(self, bsdf => bsdf.is_mirror())
    }
}

impl Bsdf {
    /// Whether all light that arrives is absorbed.
    #[inline]
    pub fn is_black(&self) -> bool {
        match self {
            Bsdf::Glass(_) => false,
            bsdf => bsdf.total(1.0) <= 0.0,
        }
    }

    /// Whether it scatters light, so that a walk draws light samples there.
    pub fn scatters(&self) -> bool {
        !self.is_black() && !self.is_specular()
    }
}

/// How a packet leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// Unit direction.
    pub direction: DVec3,
    /// Its lobe.
    pub lobe: LobeKind,
}

/// The lobe of a BSDF by which a packet leaves a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LobeKind {
    /// Reflected in all directions.
    Spread,
    /// Reflected in a glossy lobe, about the mirror direction.
    Glossy,
    /// Reflected as by a mirror.
    Mirrored,
    /// Transmitted to the other side in the same direction.
    Passed,
    /// Scattered on the other side.
    SpreadThrough,
}

impl LobeKind {
    /// Whether it leads to the other side of the surface.
    #[inline]
    pub fn leads_through(self) -> bool {
        matches!(self, LobeKind::Passed | LobeKind::SpreadThrough)
    }
}

/// A pair of directions at a surface, both away from it: `towards` where the light comes from, `leaving` where it goes. `normal` belongs to
/// the side of `towards`.
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
    /// Returns the cosine on the lit side.
    #[inline]
    pub fn cos_in(&self) -> f64 {
        self.normal.dot(self.towards)
    }

    /// Returns the cosine of the leaving direction; negative on the other side.
    #[inline]
    pub fn cos_out(&self) -> f64 {
        self.normal.dot(self.leaving)
    }

    /// Returns the cosine between the leaving direction and the mirror direction.
    #[inline]
    pub fn cos_alpha(&self) -> f64 {
        mirrored(-self.towards, self.normal).dot(self.leaving)
    }
}

/// Reflects a direction at a plane with a unit normal.
#[inline]
pub fn mirrored(direction: DVec3, normal: DVec3) -> DVec3 {
    direction - normal * (2.0 * direction.dot(normal))
}
