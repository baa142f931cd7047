//! Reference tables of `tests/data`.

/// Rows of a reference table, without its comments and its head.
pub fn table(text: &str) -> Vec<Vec<String>> {
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .skip(1)
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect()
}
