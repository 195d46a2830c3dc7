//! Checks of the documentation: links resolve, and the README stays within its length.

use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn pages() -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> =
        ["README.md", "CHANGELOG.md", "CONTRIBUTING.md"].map(|page| root().join(page)).into();
    for folder in ["docs", "docs/course", "docs/curso"] {
        let docs = std::fs::read_dir(root().join(folder)).expect("there are docs");
        pages.extend(
            docs.map(|e| e.expect("an entry").path()).filter(|p| p.extension().is_some_and(|e| e == "md")),
        );
    }
    pages.sort();
    pages
}

/// Returns the targets of `[text](target)` in a page.
fn links(text: &str) -> Vec<&str> {
    let after = |(at, _): (usize, &str)| text[at + 2..].split(')').next();
    text.match_indices("](").filter_map(after).collect()
}

/// Returns the anchors of a page's headings, by the rule of the usual renderers.
fn anchors(text: &str) -> Vec<String> {
    let slug = |heading: &str| -> String {
        let lower = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = lower.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    text.lines().filter(|l| l.starts_with('#')).map(slug).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let (mut dead, mut count) = (Vec::new(), 0);
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("a page is text");
        for link in links(&text).into_iter().filter(|l| !l.contains("://")) {
            count += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target =
                if file.is_empty() { page.clone() } else { page.parent().expect("a folder").join(file) };
            let is_alive = match target.extension() {
                Some(ending) if ending == "md" && !anchor.is_empty() => std::fs::read_to_string(&target)
                    .is_ok_and(|text| anchors(&text).iter().any(|a| a == anchor)),
                _ => target.exists(),
            };
            if !is_alive {
                dead.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(count > 20 && dead.is_empty(), "{count} links, dead: {dead:#?}");
}

#[test]
fn the_readme_keeps_to_its_length_and_shows_a_picture_first() {
    let text = std::fs::read_to_string(root().join("README.md")).expect("there is one");
    assert!(text.lines().count() < 150, "{} lines", text.lines().count());
    let picture = text.find("](docs/pictures/").expect("a picture");
    assert!(text[..picture].lines().count() < 5);
}

/// Returns the code blocks of a page, without the lines of backticks.
fn code_blocks(text: &str) -> Vec<&str> {
    text.split("\n```").skip(1).step_by(2).map(|block| block.split_once('\n').map_or("", |b| b.1)).collect()
}

#[test]
fn the_library_page_shows_a_golden_test_in_eight_lines_and_a_game_in_forty() {
    let page = std::fs::read_to_string(root().join("docs/library.md")).expect("there is one");
    let blocks = code_blocks(&page);
    let lines_of = |what: &str| {
        let found = blocks.iter().find(|block| block.contains(what));
        found.unwrap_or_else(|| panic!("no block with {what}")).lines().count()
    };
    assert!(lines_of("assert_golden") <= 8 && lines_of("paddles") <= 40);
    // The golden test is compiled and run by tests/files; the rest of the page are doc tests.
    let compiled = include_str!("../files/golden_example.rs");
    assert!(blocks.iter().any(|block| block.trim_end() == compiled.trim_end()));
}

#[test]
fn the_viewers_page_has_every_key() {
    let page = std::fs::read_to_string(root().join("docs/viewer.md")).expect("there is one");
    for binding in fbptr::viewer::BINDINGS {
        let row = format!("| `{}` | {} | {} |", binding.name, binding.help, binding.help_nd);
        let row = row.replace("|  |", "| |");
        assert!(page.lines().any(|line| line == row), "docs/viewer.md lacks {row}");
    }
}
