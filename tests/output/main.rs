//! Files for other programs and for 3D pages: sensor grids, models, views.

mod in_a_browser;
mod radiance_grids;
mod report_view;
mod scene_glb;
