//! Rays among the triangles and balls of a scene: what a ray meets first, and whether two points see each other.
//!
//! This is the only room that computes in f32 and the only one that uses obvhs. Outside, everything is f64 and metres. Inside, coordinates
//! are centred on the scene and scaled so that its largest half-extent is 1 (`frame`).
//!
//! Three rules keep closed rooms closed:
//!
//! 1. *A triangle test on which neighbours agree* (`triangle`): vertices are sheared into the ray's frame one by one.
//!    Edge functions are differences of products without fused operations. Two triangles therefore compute exactly opposite
//!    values on a shared edge; zero counts as inside.
//! 2. *Boxes that are never missed* (`tree`): the boxes under the tree are padded by more than all the rounding in
//!    the node test.
//! 3. *Sides decided by planes, not by distances* (`origin`): a ray meets a front only from in front and a back only
//!    from behind. "In front" is decided in f64 for the side that the ray's origin belongs to. No smallest distance is
//!    needed, and the surface under an origin does not shadow it.
//!
//! In the tree, smooth bodies are represented by the balls around them. They are met exactly (`body`); their leaves are not triangles here.
//!
//! In a convex scene nothing stands between two points inside it, so no ray is traced (`hull`). The same holds between two points of a box
//! that is empty, as above the desks of an office (`clear_boxes`).
//!
//! A crossing found by the walk is accepted as it is, unless it lies on an edge or is the back of a one-sided surface. These uncertain
//! crossings (about 4 in 10,000) are decided from all crossings of the ray (`tracer`).

mod ball;
mod body;
mod build;
mod clear_boxes;
mod crossings;
mod frame;
mod hull;
mod nodes;
mod origin;
mod region;
mod tracer;
mod tree;
mod triangle;

pub use crossings::Crossed;
pub use origin::Origin;
pub use tracer::{Meeting, SurfaceHit, Tracer, position_accuracy_m};

#[cfg(test)]
mod tests;
