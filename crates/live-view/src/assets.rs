//! The page's files, in the program itself: plain modules, without a build step.

use crate::Recording;
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;

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
    asset!("/live.js", "live.js", JS),
    asset!("/page.js", "page.js", JS),
    asset!("/wire.js", "wire.js", JS),
    asset!("/player.js", "player.js", JS),
    asset!("/camera.js", "camera.js", JS),
    asset!("/shapes.js", "shapes.js", JS),
    asset!("/gl-painter.js", "gl-painter.js", JS),
    asset!("/plain-painter.js", "plain-painter.js", JS),
    asset!("/painter.js", "painter.js", JS),
    asset!("/overlay.js", "overlay.js", JS),
    asset!("/scenery.js", "scenery.js", JS),
    asset!("/hands.js", "hands.js", JS),
    asset!("/stage.js", "stage.js", JS),
    asset!("/table.js", "table.js", JS),
    asset!("/charts.js", "charts.js", JS),
    asset!("/choice.js", "choice.js", JS),
    asset!("/operator.js", "operator.js", JS),
    asset!("/selected.js", "selected.js", JS),
    asset!("/vendor/uplot.js", "vendor/uPlot.iife.min.js", JS),
    asset!("/vendor/uplot.css", "vendor/uPlot.min.css", CSS),
];

/// The file of a path.
pub fn find(path: &str) -> Option<&'static Asset> {
    ALL.iter().find(|asset| asset.path == path)
}

/// The modules of the page in an order in which each stands after those that it imports; without the connection.
const MODULES: [&str; 17] = [
    "/wire.js",
    "/player.js",
    "/camera.js",
    "/shapes.js",
    "/gl-painter.js",
    "/plain-painter.js",
    "/painter.js",
    "/overlay.js",
    "/scenery.js",
    "/hands.js",
    "/stage.js",
    "/table.js",
    "/charts.js",
    "/choice.js",
    "/operator.js",
    "/selected.js",
    "/page.js",
];

/// The page as one file that plays a recording and asks nobody for anything; without charts.
///
/// # Errors
/// When a number of the recording's scene is none.
pub fn page_of(recording: &mut Recording) -> Result<String, serde_json::Error> {
    let text = |path: &str| find(path).map_or("", |asset| std::str::from_utf8(asset.bytes).unwrap_or(""));
    let mut script = String::new();
    for line in MODULES.iter().flat_map(|path| text(path).lines()).filter(|line| !line.starts_with("import ")) {
        script.push_str(line.strip_prefix("export ").unwrap_or(line));
        script.push('\n');
    }
    // No text of a recording can close the element that it stands in.
    let head = serde_json::to_string(&recording.head())?.replace('<', "\\u003c");
    let mut page = String::new();
    for line in text("/").lines() {
        match line {
            line if line.contains("vendor/") => continue,
            line if line.contains("view.css") => page.push_str(&format!("<style>\n{}</style>\n", text("/view.css"))),
            line if line.contains("live.js") => continue,
            "</body>" => {
                page.push_str(&format!("<script type=\"application/json\" id=\"recording\">{head}</script>\n"));
                let frames = BASE64.encode(recording.frames());
                page.push_str(&format!("<script type=\"text/plain\" id=\"recording-frames\">{frames}</script>\n"));
                page.push_str(&format!("<script type=\"module\">\n{script}</script>\n</body>\n"));
            }
            line => {
                page.push_str(line);
                page.push('\n');
            }
        }
    }
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
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
    fn the_page_of_a_recording_is_one_file_whose_modules_do_not_meet() {
        let scene = Scene { title: "</script><script>alert(1)".into(), ..Scene::default() };
        let page = page_of(&mut Recording::new(scene)).unwrap();
        assert_eq!((page.matches("<script").count(), page.matches("</script>").count()), (3, 3));
        for outside in ["http:", "https:", "src=", "href=\"v", "@import", "fetch(", "WebSocket(", "import {"] {
            assert!(!page.contains(outside), "{outside}");
        }
        let mut names = std::collections::HashSet::new();
        for line in page.lines() {
            let mut words = line.split(|letter: char| !letter.is_alphanumeric() && letter != '_');
            if let (Some("const" | "let" | "function" | "class"), Some(name)) = (words.next(), words.next()) {
                assert!(name.is_empty() || names.insert(name.to_owned()), "two modules have a {name}");
            }
        }
        assert!(names.len() > 50);
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
