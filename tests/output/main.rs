//! What is written for other programs and for pages in space: sensor grids, models, views.

mod in_a_browser;
mod radiance_grids;
mod report_view;
mod scene_glb;
