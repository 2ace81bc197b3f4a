//! Tables as aligned text and as CSV.

/// The side of its column at which a text stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// Columns with a heading each, and rows of texts.
#[derive(Clone, Debug)]
pub struct Table<const N: usize> {
    heads: [(&'static str, Align); N],
    rows: Vec<[String; N]>,
}

impl<const N: usize> Table<N> {
    /// A table without rows. Where all headings are empty, none is shown.
    pub fn new(heads: &[(&'static str, Align); N]) -> Self {
        Self { heads: *heads, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: [String; N]) {
        self.rows.push(cells);
    }

    /// Aligned text, two blanks between columns, every line after `indent`.
    pub fn text(&self, indent: &str) -> String {
        let heads = self.heads.map(|(name, _)| name.to_string());
        let shown: Vec<&[String; N]> =
            heads.iter().any(|h| !h.is_empty()).then_some(&heads).into_iter().chain(&self.rows).collect();
        let width = |column: usize| shown.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: [usize; N] = std::array::from_fn(width);
        let mut text = String::new();
        for row in shown {
            let mut line = indent.to_string();
            for (column, cell) in row.iter().enumerate() {
                let gap = if column == 0 { "" } else { "  " };
                let pad = " ".repeat(widths[column] - cell.chars().count());
                match self.heads[column].1 {
                    Align::Left => line.extend([gap, cell, &pad]),
                    Align::Right => line.extend([gap, &pad, cell]),
                }
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }

    /// Comma-separated values under a line of headings; a text with a comma, quote or line break is quoted.
    pub fn csv(&self) -> String {
        let heads = self.heads.map(|(name, _)| name.to_string());
        std::iter::once(&heads).chain(&self.rows).map(|row| csv_line(row)).collect()
    }
}

/// One line of comma-separated values.
pub fn csv_line(cells: &[String]) -> String {
    cells.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(",") + "\n"
}

fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.into() }
}

/// The shortest text that reads back as the same number, with an exponent where plain digits would be long.
pub fn exact(x: f64) -> String {
    format!("{x:?}")
}

/// A number for reading: at most four significant digits, `1.234e-5` where plain digits would be long.
pub fn short(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || !x.is_finite() || (x.fract() == 0.0 && size < 1e6) {
        format!("{x}")
    } else if (1e-3..1e4).contains(&size) {
        let decimals = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
        let text = format!("{x:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
    } else {
        let text = format!("{x:.3e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_by_characters_not_bytes() {
        let mut table = Table::new(&[("θ", Align::Left), ("value", Align::Right)]);
        table.row(["grazing°".into(), "1".into()]);
        table.row(["0".into(), "12345678".into()]);
        assert_eq!(table.text(" "), " θ            value\n grazing°         1\n 0         12345678\n");
    }

    #[test]
    fn csv_quotes_what_would_break_it() {
        let mut table = Table::new(&[("a", Align::Left), ("b", Align::Left)]);
        table.row(["x,\"y\"".into(), "z".into()]);
        assert_eq!(table.csv(), "a,b\n\"x,\"\"y\"\"\",z\n");
    }

    #[test]
    fn exact_numbers_read_back() {
        for x in [0.1 + 0.2, 1e-300, f64::MAX, 1.0 / 3.0, 5e-324] {
            assert_eq!(exact(x).parse(), Ok(x));
            assert!(exact(x).len() < 25, "{x:?}");
        }
    }

    #[test]
    fn short_numbers_keep_four_digits() {
        let shown = [0.0, 1.0, 0.987654321, 12.345678, 1.5e-7, 1e9, f64::INFINITY, -0.0012345].map(short);
        assert_eq!(shown, ["0", "1", "0.9877", "12.35", "1.5e-7", "1e9", "inf", "-0.001234"]);
    }
}
