//! The files of the page, as `console/page` builds them.

/// A file of the page.
#[derive(Debug)]
pub struct Asset {
    /// Path in its address.
    pub path: &'static str,
    pub content_type: &'static str,
    pub text: &'static str,
}

/// All that is loaded before the first frame.
pub const ASSETS: [Asset; 3] = [
    Asset { path: "/", content_type: "text/html; charset=utf-8", text: include_str!("../../page/dist/index.html") },
    Asset {
        path: "/page.js",
        content_type: "text/javascript; charset=utf-8",
        text: include_str!("../../page/dist/page.js"),
    },
    Asset {
        path: "/page.css",
        content_type: "text/css; charset=utf-8",
        text: include_str!("../../page/dist/page.css"),
    },
];
