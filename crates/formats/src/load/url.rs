//! URLs in scene files: file names inside the root, and data URIs.

use super::path_inside;

/// Returns the file names inside the root that a URL may mean, in order of preference: as written,
/// without query and fragment, and with %XX decoded. Empty for other schemes, absolute paths, and
/// paths that lead out of the root.
///
/// `folder` is that of the file that contains the URL: empty, or ending in `/`.
pub(crate) fn local_paths(folder: &str, url: &str) -> Vec<String> {
    let url = url.trim();
    if has_scheme(url) {
        return Vec::new();
    }
    let bare = url.split(['#', '?']).next().unwrap_or("");
    let decoded = unescape(bare);
    let mut paths: Vec<String> = Vec::new();
    for name in [url, bare, decoded.as_deref().unwrap_or(bare)] {
        if let Some(path) = path_inside(folder, name).filter(|p| !paths.contains(p)) {
            paths.push(path);
        }
    }
    paths
}

/// Returns whether a URL refers to a file outside the root: by `..`, or by an absolute path.
pub(crate) fn is_outside(folder: &str, url: &str) -> bool {
    let url = url.trim();
    let bare = url.split(['#', '?']).next().unwrap_or("");
    let names_file = !bare.is_empty() && !has_scheme(url) && !bare.ends_with(['/', '\\']);
    names_file && path_inside(folder, bare).is_none()
}

/// Returns whether a URL is relative to the folder of the file that contains it.
pub(crate) fn is_relative(url: &str) -> bool {
    let name = url.trim();
    !name.is_empty() && !has_scheme(name) && !name.starts_with(['/', '\\'])
}

/// Returns `url`, written in a file of the folder `from`, as a file of the folder `to` would write
/// it. URLs that are not relative stay as they are.
pub(crate) fn rebased(url: &str, from: &str, to: &str) -> String {
    if from == to || !is_relative(url) {
        return url.to_string();
    }
    // A folder is a path: in a URL these characters have meanings.
    let mut folder = String::with_capacity(from.len());
    for c in from.chars() {
        match c {
            '%' | '#' | '?' | ':' => folder.push_str(&format!("%{:02X}", c as u32)),
            c => folder.push(c),
        }
    }
    format!("{}{folder}{}", "../".repeat(to.matches('/').count()), url.trim())
}

/// Returns whether a URL begins with a scheme, such as `http:`.
fn has_scheme(url: &str) -> bool {
    url.split_once(':').is_some_and(|(scheme, _)| {
        !scheme.is_empty()
            && scheme.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.'))
    })
}

/// Returns the part of a URL after `#`, unless it is empty.
pub(crate) fn fragment(url: &str) -> Option<&str> {
    url.trim().split_once('#').map(|(_, fragment)| fragment).filter(|f| !f.is_empty())
}

/// Decodes %XX; `None` if the result is not UTF-8.
fn unescape(text: &str) -> Option<String> {
    String::from_utf8(unescape_bytes(text)).ok()
}

fn unescape_bytes(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let hex = |i: usize| bytes.get(i).and_then(|b| (*b as char).to_digit(16));
        match (bytes[at], hex(at + 1), hex(at + 2)) {
            (b'%', Some(high), Some(low)) => {
                out.push((high * 16 + low) as u8);
                at += 3;
            }
            (byte, _, _) => {
                out.push(byte);
                at += 1;
            }
        }
    }
    out
}

/// Returns whether a URL is a data URI.
pub(crate) fn is_data(url: &str) -> bool {
    url.trim().get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// Decodes a data URI (`data:image/png;base64,...` or `data:,...`); `None` for other URLs, `Err`
/// for an invalid one.
pub(crate) fn data(url: &str) -> Option<Result<Vec<u8>, &'static str>> {
    if !is_data(url) {
        return None;
    }
    let url = url.trim();
    let Some((head, body)) = url[5..].split_once(',') else { return Some(Err("a data URI without a comma")) };
    let is_base64 = head.rsplit(';').next().is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    Some(match is_base64 {
        true => base64(&unescape_bytes(body)).ok_or("a data URI that is not base64"),
        false => Ok(unescape_bytes(body)),
    })
}

/// Decodes base64 (RFC 4648, both alphabets); white space is ignored, padding is optional.
fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count, mut is_over) = (0_u32, 0, false);
    for byte in text.iter().filter(|b| !b.is_ascii_whitespace()) {
        let six = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => {
                is_over = true;
                continue;
            }
            _ => return None,
        };
        if is_over {
            return None;
        }
        bits = bits << 6 | u32::from(six);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    // Six remaining bits would be a lone character, which encodes nothing.
    (count < 6).then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside_the_folder() {
        assert_eq!(local_paths("", "a.png"), ["a.png"]);
        assert_eq!(local_paths("sub/", "./b//c.x3d#View"), ["sub/b/c.x3d#View", "sub/b/c.x3d"]);
        assert_eq!(local_paths("sub/", "../a%20b.png"), ["a%20b.png", "a b.png"]);
        for out in [
            "",
            "..",
            "../a",
            "a/../../b",
            "/etc/passwd",
            "\\a",
            "http://h/a",
            "file:a",
            "urn:x",
            "a/",
            "C:\\a",
        ] {
            assert!(local_paths("", out).is_empty(), "{out:?}");
        }
        assert!(local_paths("sub/", "%2e%2e/%2e%2e/a").iter().all(|p| p.starts_with("sub/")));
    }

    #[test]
    fn what_climbs_out_of_the_root_is_told_from_what_is_elsewhere() {
        for (folder, url) in [("", "../a.png"), ("b/", "../../a.x3d#P"), ("", "/a.png"), ("", "c/../../a")] {
            assert!(is_outside(folder, url), "{url}");
        }
        for (folder, url) in [("", "a.png"), ("b/", "../a.png"), ("", "http://h/../a"), ("", ""), ("", "#P")]
        {
            assert!(!is_outside(folder, url), "{url}");
        }
        assert_eq!(["a#P", "a", "a#"].map(fragment), [Some("P"), None, None]);
    }

    #[test]
    fn data_uris_give_their_bytes() {
        assert_eq!(data("data:image/png;base64,iVBORw0KGgo="), Some(Ok(b"\x89PNG\r\n\x1a\n".to_vec())));
        assert_eq!(data(" DATA:;base64,aGV s\nbG8"), Some(Ok(b"hello".to_vec())));
        assert_eq!(data("data:,a%20b"), Some(Ok(b"a b".to_vec())));
        assert_eq!(data("data:;base64,%61GVsbG8%3D"), Some(Ok(b"hello".to_vec())));
        for broken in ["data:image/png", "data:;base64,a", "data:;base64,ab=c", "data:;base64,a!"] {
            assert!(matches!(data(broken), Some(Err(_))), "{broken}");
        }
        assert_eq!(data("picture.png"), None);
        assert_eq!(data("dätä:,"), None);
    }

    #[test]
    fn a_relative_url_is_found_from_another_folder_too() {
        for (url, from, to, expected) in [
            ("a.png", "", "lib/", "a.png"),
            (" a.png ", "my/", "lib/deep/", "my/a.png"),
            ("../a.png", "my/own/", "", "my/a.png"),
            ("a%20b.png#x", "my/", "lib/", "my/a b.png"),
            ("a.png", "100%#1?/", "lib/", "100%#1?/a.png"),
            ("a.png", "c:d/", "", "c:d/a.png"),
            ("x.x3d#View", "a#b/", "", "a#b/x.x3d"),
        ] {
            let rebased = rebased(url, from, to);
            assert!(local_paths(to, &rebased).iter().any(|path| path == expected), "{url} {from} {rebased}");
        }
        for url in ["", "http://x/a.png", "data:,a", "/a.png", "\\a.png"] {
            assert_eq!(rebased(url, "my/", "lib/"), url);
        }
        assert_eq!(rebased(" a.png", "my/", "my/"), " a.png");
        assert!(is_outside("lib/", &rebased("../../a.png", "my/", "lib/")));
    }
}
