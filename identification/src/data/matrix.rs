//! Matrices as columns: those of the longer dimension, with MATLAB's names, `data(:,1)`.

use super::table::Column;

/// The columns of an array whose last dimension is contiguous.
pub fn rows(name: &str, sizes: &[usize], values: Vec<f64>) -> Vec<Column> {
    let sizes: Vec<usize> = sizes.iter().copied().filter(|size| *size != 1).collect();
    match sizes[..] {
        _ if values.is_empty() => Vec::new(),
        [] | [_] => vec![(name.to_owned(), values)],
        // Each row of the array is a column of the table.
        [count, length] if length >= count => {
            let numbered = (1..).zip(values.chunks(length));
            numbered
                .map(|(n, values)| (format!("{name}(:,{n})"), values.to_vec()))
                .collect()
        }
        [_, count] => {
            let of = |n: usize| values.iter().skip(n).step_by(count).copied().collect();
            (0..count)
                .map(|n| (format!("{name}(:,{})", n + 1), of(n)))
                .collect()
        }
        _ => Vec::new(),
    }
}
