//! Rays among the triangles and balls of a scene: what does a ray meet first, and do two points see each other?
//!
//! This is the only room that works in f32, and the only one that knows obvhs. Outside, everything is f64 and metres;
//! inside, coordinates are recentred and scaled on the scene so that its largest half-extent is 1 (`frame`).
//!
//! Three rules keep closed rooms closed:
//!
//! 1. *A triangle test that neighbours agree on* (`triangle`): vertices are sheared into the ray's frame one by one
//!    and edge functions are products subtracted without fusing, so that two triangles compute exactly opposite
//!    values on a shared edge; zero counts as inside.
//! 2. *Boxes that are never missed* (`tree`): the boxes under the tree are padded by more than all the rounding in
//!    the node test.
//! 3. *Sides decided by planes, not by distances* (`origin`): a ray meets a front only from in front and a back only
//!    from behind, where "in front" is judged in f64 on the side that its origin belongs to. No smallest distance is
//!    needed, and what an origin lies on does not shadow it.
//!
//! Smooth bodies stand in the tree as the balls around them, and are met exactly (`body`); their leaves are no triangles here.
//!
//! Where a scene is convex nothing stands between two places within it, and no ray is asked (`hull`).
//!
//! What the walk finds is taken as it is, unless it lies on an edge or is the back of a one-sided surface. Such
//! doubtful crossings (some 4 in 10,000) are settled with all crossings of the ray in hand (`tracer`).

mod ball;
mod body;
mod build;
mod crossings;
mod frame;
mod hull;
mod nodes;
mod origin;
mod tracer;
mod tree;
mod triangle;

pub use crossings::Crossed;
pub use origin::Origin;
pub use tracer::{Meeting, SurfaceHit, Tracer, position_accuracy_m};

#[cfg(test)]
mod tests;
