//! Even and odd halves of independent replicas, merged into maps with their errors.

mod result;

pub use result::*;
