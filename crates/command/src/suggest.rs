//! Spelling suggestions for unknown verbs. Used for messages about to be sent, never while a stream
//! is decoded.

use super::verb::Verb;

/// Longest word considered; every verb is much shorter.
const MAX_WORD: usize = 16;

/// Returns the one verb nearest to `word`: at most one edit away (a letter inserted, deleted,
/// replaced, or two exchanged), or two for words of five letters and more. `None` if there is none,
/// or if several are equally near.
pub(super) fn nearest_verb(word: &str) -> Option<&'static str> {
    nearest(word, Verb::all().iter().map(|verb| verb.name))
}

/// Returns the one of some names, all in one case, that is nearest to `word` in either case, by the
/// rule of `nearest_verb`.
pub fn nearest<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    if word.len() < 2 || word.len() > MAX_WORD || !word.is_ascii() {
        return None;
    }
    let upper = word.to_ascii_uppercase();
    let allowed = if upper.len() < 5 { 1 } else { 2 };
    let mut nearest: Option<(usize, &str)> = None;
    let mut is_alone = true;
    for name in names {
        let distance = edits(upper.as_bytes(), name.to_ascii_uppercase().as_bytes());
        match nearest {
            Some((best, _)) if distance > best => {}
            Some((best, _)) if distance == best => is_alone = false,
            _ => (nearest, is_alone) = (Some((distance, name)), true),
        }
    }
    nearest.filter(|(distance, _)| *distance <= allowed && is_alone).map(|(_, name)| name)
}

/// Returns the optimal string alignment distance (Damerau and Levenshtein) of two words.
fn edits(a: &[u8], b: &[u8]) -> usize {
    let mut rows = [[0; MAX_WORD + 1]; MAX_WORD + 1];
    if a.len() > MAX_WORD || b.len() > MAX_WORD {
        return usize::MAX;
    }
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = match (i, j) {
                (0, j) => j,
                (i, 0) => i,
                (i, j) => {
                    let changed = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                    let least = changed.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
                    let is_exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                    if is_exchanged { least.min(rows[i - 2][j - 2] + 1) } else { least }
                }
            };
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_are_seen_through_and_other_words_are_not() {
        for (word, verb) in [
            ("LIEN", "LINE"),
            ("lnie", "LINE"),
            ("CELAR", "CLEAR"),
            ("FILRECT", "FILLRECT"),
            ("PERSPEKTIVE", "PERSPECTIVE"),
            ("PRESNET", "PRESENT"),
            ("SIZED", "SIZE"),
            // Two edits in five letters.
            ("KLAER", "CLEAR"),
            ("LUGHD", "LIGHT"),
        ] {
            assert_eq!(nearest_verb(word), Some(verb), "{word}");
        }
        for word in ["", "X", "TXTE", "FOO", "NONSENSE", "HTTP", "ÄLINE", "AAAAAAAAAAAAAAAAAAAAAAAAA", "-"] {
            assert_eq!(nearest_verb(word), None, "{word}");
        }
        assert_eq!(edits(b"", b"AB"), 2);
        assert_eq!(edits(b"AB", b"BA"), 1);
        assert!(
            Verb::all().iter().all(|verb| nearest_verb(verb.name) == Some(verb.name) || verb.name.len() < 2)
        );
    }
}
