//! The sheets that travel with the program.

/// Names and texts.
const SHEETS: [(&str, &str); 12] = [
    ("T1", include_str!("sheets/T1.sheet")),
    ("T1b", include_str!("sheets/T1b.sheet")),
    ("T2", include_str!("sheets/T2.sheet")),
    ("R1", include_str!("sheets/R1.sheet")),
    ("R2", include_str!("sheets/R2.sheet")),
    ("R3", include_str!("sheets/R3.sheet")),
    ("R4", include_str!("sheets/R4.sheet")),
    ("R5", include_str!("sheets/R5.sheet")),
    ("R6", include_str!("sheets/R6.sheet")),
    ("R7", include_str!("sheets/R7.sheet")),
    ("R8", include_str!("sheets/R8.sheet")),
    ("R9", include_str!("sheets/R9.sheet")),
];

/// Returns the text of a sheet by its name.
pub fn named(name: &str) -> Option<&'static str> {
    SHEETS.iter().find(|(other, _)| other.eq_ignore_ascii_case(name)).map(|(_, text)| *text)
}

/// Returns the titles of all, which begin with their names.
pub fn list() -> String {
    let title = |text: &'static str| text.lines().find_map(|line| line.strip_prefix("title:")).unwrap_or("");
    SHEETS.iter().map(|(_, text)| format!("{}\n", title(text).trim())).collect()
}
