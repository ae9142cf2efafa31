//! The page that is part of the program: how large it is, and that it is what its sources build.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use linewright_console_server::ASSETS;

/// Most bytes of the first load, compressed by `gzip -9`.
const FIRST_LOAD_MAX: usize = 100 * 1024;

fn page() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../page")
}

fn compressed(bytes: &[u8]) -> Option<usize> {
    let mut gzip = Command::new("gzip").arg("-9").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().ok()?;
    // Small enough for the pipes of both sides.
    gzip.stdin.take()?.write_all(bytes).ok()?;
    Some(gzip.wait_with_output().ok()?.stdout.len())
}

#[test]
fn the_first_load_is_small() {
    let sizes = ASSETS.iter().map(|asset| compressed(asset.text.as_bytes()));
    let Some(size) = sizes.sum::<Option<usize>>() else {
        println!("SKIPPED: no gzip here");
        return;
    };
    assert!((1000..FIRST_LOAD_MAX).contains(&size), "{size} bytes");
}

/// Scripts and styles come from files alone, as the content security policy asks for.
#[test]
fn the_page_has_nothing_inline_and_loads_from_here_alone() {
    let html = ASSETS[0].text;
    assert!(!html.contains("<style") && !html.contains("style=") && !html.contains("javascript:"), "{html}");
    for element in html.split("<script").skip(1) {
        assert!(element.split_once("</script>").is_some_and(|(tag, _)| tag.ends_with('>')), "{element}");
    }
    let paths: Vec<&str> = ASSETS.iter().map(|asset| asset.path).collect();
    for attribute in ["src=\"", "href=\""] {
        for value in html.split(attribute).skip(1).filter_map(|rest| rest.split('"').next()) {
            assert!(paths.contains(&value), "{value} is not served");
        }
    }
}

/// Runs a command in a directory; the reason where it cannot be run or fails.
fn run(dir: &Path, program: &str, args: &[&str]) -> Result<(), String> {
    let output = Command::new(program).args(args).current_dir(dir).output();
    let output = output.map_err(|error| format!("{program}: {error}"))?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned() + &String::from_utf8_lossy(&output.stdout);
    if output.status.success() { Ok(()) } else { Err(format!("{program} {}: {text}", args.join(" "))) }
}

#[test]
fn the_committed_page_is_what_its_sources_build() {
    let copy = tempfile::tempdir().expect("a directory");
    fs::create_dir(copy.path().join("src")).expect("a directory");
    for name in ["package.json", "package-lock.json", "tsconfig.json", "build.mjs"] {
        fs::copy(page().join(name), copy.path().join(name)).expect("a file of the page");
    }
    for entry in fs::read_dir(page().join("src")).expect("its sources").flatten() {
        fs::copy(entry.path(), copy.path().join("src").join(entry.file_name())).expect("a source");
    }
    if let Err(why) = run(copy.path(), "node", &["--version"])
        .and_then(|()| run(copy.path(), "npm", &["ci", "--no-audit", "--no-fund", "--prefer-offline"]))
    {
        println!("SKIPPED: no Node with the packages of the page here ({why})");
        return;
    }
    run(copy.path(), "npm", &["run", "build"]).expect("its sources build");
    for name in ["index.html", "page.js", "page.css"] {
        let read = |dir: &Path| fs::read_to_string(dir.join("dist").join(name)).expect("a file that is built");
        let is_same = read(copy.path()) == read(&page());
        assert!(
            is_same,
            "console/page/dist/{name} is not what its sources build: `npm ci`, `npm run build` in console/page"
        );
    }
}
