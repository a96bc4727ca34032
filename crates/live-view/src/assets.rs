//! The page's files, in the program itself: plain modules, without a build step.

/// A file of the page.
#[derive(Clone, Copy, Debug)]
pub struct Asset {
    /// Its path.
    pub path: &'static str,
    /// Its content type.
    pub content_type: &'static str,
    /// Its bytes.
    pub bytes: &'static [u8],
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const JS: &str = "text/javascript; charset=utf-8";

macro_rules! asset {
    ($path:literal, $file:literal, $content_type:expr) => {
        Asset { path: $path, content_type: $content_type, bytes: include_bytes!(concat!("../assets/", $file)) }
    };
}

/// All files.
pub const ALL: &[Asset] = &[
    asset!("/", "index.html", HTML),
    asset!("/view.css", "view.css", CSS),
    asset!("/main.js", "main.js", JS),
    asset!("/wire.js", "wire.js", JS),
    asset!("/player.js", "player.js", JS),
    asset!("/camera.js", "camera.js", JS),
    asset!("/painter.js", "painter.js", JS),
    asset!("/overlay.js", "overlay.js", JS),
    asset!("/stage.js", "stage.js", JS),
    asset!("/table.js", "table.js", JS),
    asset!("/charts.js", "charts.js", JS),
    asset!("/operator.js", "operator.js", JS),
    asset!("/vendor/uplot.js", "vendor/uPlot.iife.min.js", JS),
    asset!("/vendor/uplot.css", "vendor/uPlot.min.css", CSS),
];

/// The file of a path.
pub fn find(path: &str) -> Option<&'static Asset> {
    ALL.iter().find(|asset| asset.path == path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sha2::{Digest, Sha256};

    /// Hashes of the vendored files: assets/vendor/README.md says where they are from.
    #[test]
    fn vendored_files_are_those_that_were_looked_at() {
        let page = include_str!("../assets/vendor/README.md");
        for path in ["/vendor/uplot.js", "/vendor/uplot.css"] {
            let hash: String =
                Sha256::digest(find(path).unwrap().bytes).iter().map(|byte| format!("{byte:02x}")).collect();
            assert!(page.contains(&hash), "{path}: {hash}");
        }
    }

    #[test]
    fn the_page_asks_for_nothing_but_its_own_files() {
        let own = ALL.iter().filter(|asset| !asset.path.starts_with("/vendor"));
        for asset in own {
            let text = std::str::from_utf8(asset.bytes).unwrap();
            for line in text.lines().filter(|line| line.contains("http://") || line.contains("https://")) {
                assert!(line.contains("www.w3.org"), "{}: {line}", asset.path);
            }
            for from in text.split("from \"./").skip(1) {
                let name = from.split('"').next().unwrap();
                assert!(find(&format!("/{name}")).is_some(), "{} imports {name}", asset.path);
            }
        }
    }
}
