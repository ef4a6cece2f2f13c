//! BSDFs: how a packet that arrives at a surface leaves it.
//!
//! Every BSDF has a file of its own and stands behind one trait, [`Reflection`]: `sample` draws whether and how a packet leaves,
//! `pdf_per_sr` is the density of the directions that survivors get, `eval_per_sr` the BRDF (or its like for the other side), `total`
//! the share that survives. Mirrors and panes send light into single directions: their `pdf` and `eval` are 0, since
//! no connection finds them. The list of all BSDFs is in this file, once: the call of `bsdfs!`.
//!
//! Sampling is analogue: a packet survives with a probability equal to the share that leaves, and a survivor carries
//! all of its flux on. (Walks carry weights from diffuse surfaces: see [`crate::chain::Roulette`].)

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
pub use mirror::Mirror;
pub use phong::Phong;
pub use translucent::Translucent;

use super::random::Stream;
use crate::scene::ReflectionLaw;

/// What a BSDF can do.
pub trait Reflection {
    /// Draws whether a packet that travels along `direction` survives, and if so how it leaves the side with this unit
    /// normal.
    fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered>;

    /// Share of the light that leaves again, on either side, if it arrives under an angle of this cosine.
    fn total(&self, cos_in: f64) -> f64;

    /// Density per sr of the directions that [`Reflection::sample`] gives to survivors.
    fn pdf_per_sr(&self, _: &Pair) -> f64 {
        0.0
    }

    /// Luminance that leaves for each lx that arrives, in cd/m² per lx (the BRDF, per sr; behind the surface the BTDF).
    fn eval_per_sr(&self, pair: &Pair) -> f64 {
        self.lobe_per_sr(pair) + self.spread_per_sr(pair)
    }

    /// Its part about a direction, which packets leave by [`LobeKind::Glossy`].
    fn lobe_per_sr(&self, _: &Pair) -> f64 {
        0.0
    }

    /// Its smooth part, which connections find well.
    fn spread_per_sr(&self, _: &Pair) -> f64 {
        0.0
    }

    /// Reflectance of the part of a glossy BSDF that sends light alike to all sides; 0 of BSDFs without a lobe.
    fn diffuse_part(&self) -> f64 {
        0.0
    }

    /// Draws how a packet leaves by all the rest of a glossy BSDF, lobe and what makes up for its losses, which it does with a
    /// probability of `total` less `diffuse_part`. `None` of BSDFs without a lobe.
    fn sample_gloss(&self, _direction: DVec3, _normal: DVec3, _: &mut Stream) -> Option<Scattered> {
        None
    }

    /// Whether all light that leaves goes into single directions, so that no connection finds it.
    fn is_specular(&self) -> bool {
        false
    }

    /// Share of the light that is reflected as by a mirror, at an angle of this cosine.
    fn mirror_share(&self, _cos_in: f64) -> f64 {
        0.0
    }

    /// Whether it reflects as a mirror does, at least in part.
    fn is_mirror(&self) -> bool {
        false
    }
}

/// Makes the list of BSDFs: for each what it does, its type here, and how that comes from the BSDF of a scene.
macro_rules! bsdfs {
    ($($(#[$what:meta])* $bsdf:ident($ready:ty) from $given:pat => $made:expr;)*) => {
        /// A BSDF, ready for sampling.
        #[derive(Clone, Debug)]
        pub enum Bsdf {
            $($(#[$what])* $bsdf($ready),)*
        }

        impl Bsdf {
            /// Makes a BSDF ready; one with a lobe tabulates what that loses, some 20 ms.
            pub fn new(bsdf: &ReflectionLaw) -> Bsdf {
                match *bsdf {
                    $($given => Bsdf::$bsdf($made),)*
                }
            }
        }

        /// Calls the same method of whichever BSDF it is.
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
    Diffuse(Diffuse) from ReflectionLaw::Diffuse { reflectance } => Diffuse { reflectance };
    /// A diffuse part and a lobe about the mirror direction.
    Phong(Box<Glossy<Phong>>) from ReflectionLaw::Phong { diffuse_reflectance, specular_reflectance, exponent } =>
        Box::new(Glossy::new(diffuse_reflectance, specular_reflectance, Phong { exponent }));
    /// A diffuse part and a lobe about the half vector.
    Blinn(Box<Glossy<Blinn>>) from ReflectionLaw::Blinn { diffuse_reflectance, specular_reflectance, exponent } =>
        Box::new(Glossy::new(diffuse_reflectance, specular_reflectance, Blinn { exponent }));
    /// A mirror.
    Mirror(Mirror) from ReflectionLaw::Mirror { reflectance } => Mirror { reflectance };
    /// A thin pane.
    Glass(Glass) from ReflectionLaw::Glass { refractive_index, internal_transmittance, glazed_share } =>
        Glass { refractive_index, internal_transmittance, glazed_share };
    /// Diffuse to both sides.
    Translucent(Translucent) from ReflectionLaw::Translucent { diffuse_reflectance, diffuse_transmittance } =>
        Translucent { reflectance: diffuse_reflectance, transmittance: diffuse_transmittance };
}

/// What [`Reflection`] says, of whichever BSDF it is.
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

    pub fn diffuse_part(&self) -> f64 {
        of_bsdf!(self, bsdf => bsdf.diffuse_part())
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

    /// Whether it spreads light, so that a walk looks for luminaires there.
    pub fn scatters(&self) -> bool {
        !self.is_black() && !self.is_specular()
    }
}

/// How a packet leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// Unit direction.
    pub direction: DVec3,
    /// By which way.
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
    /// Passed on to the other side, its direction kept.
    Passed,
    /// Spread out on the other side.
    SpreadThrough,
}

impl LobeKind {
    /// Whether it leads to the other side of the surface.
    #[inline]
    pub fn leads_through(self) -> bool {
        matches!(self, LobeKind::Passed | LobeKind::SpreadThrough)
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
