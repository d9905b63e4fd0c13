//! Files of the page.

/// One file of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageFile {
    /// Path below the folder of the page; empty: the page itself.
    pub path: &'static str,
    /// Media type.
    pub media_type: &'static str,
    /// Contents.
    pub bytes: &'static [u8],
}

/// All files of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageFiles(pub &'static [PageFile]);

impl PageFiles {
    /// The page that `npm run build` made.
    #[cfg(feature = "page")]
    pub const BUILT: Self = Self(&[
        PageFile {
            path: "",
            media_type: "text/html; charset=utf-8",
            bytes: include_bytes!(concat!(env!("OUT_DIR"), "/index.html")),
        },
        PageFile {
            path: "view.js",
            media_type: "text/javascript; charset=utf-8",
            bytes: include_bytes!(concat!(env!("OUT_DIR"), "/view.js")),
        },
        PageFile {
            path: "view.css",
            media_type: "text/css; charset=utf-8",
            bytes: include_bytes!(concat!(env!("OUT_DIR"), "/view.css")),
        },
        PageFile {
            path: "licenses.txt",
            media_type: "text/plain; charset=utf-8",
            bytes: include_bytes!(concat!(env!("OUT_DIR"), "/licenses.txt")),
        },
    ]);

    /// The file at `path`.
    #[must_use]
    pub fn file(&self, path: &str) -> Option<&'static PageFile> {
        self.0.iter().find(|file| file.path == path)
    }
}
