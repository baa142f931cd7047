//! A small system of linear equations.

/// Solves six equations by elimination with partial pivoting. What no equation tells is zero.
pub(super) fn solve(mut matrix: [[f64; 6]; 6], mut right: [f64; 6]) -> [f64; 6] {
    for column in 0..6 {
        let largest = (column..6)
            .max_by(|&a, &b| matrix[a][column].abs().total_cmp(&matrix[b][column].abs()))
            .unwrap_or(column);
        matrix.swap(column, largest);
        right.swap(column, largest);
        let pivot = matrix[column];
        if pivot[column] == 0.0 {
            continue;
        }
        for row in column + 1..6 {
            let part = matrix[row][column] / pivot[column];
            for (value, pivot) in matrix[row].iter_mut().zip(pivot).skip(column) {
                *value -= part * pivot;
            }
            right[row] -= part * right[column];
        }
    }
    let mut solution = [0.0; 6];
    for row in (0..6).rev() {
        let known: f64 = (row + 1..6).map(|i| matrix[row][i] * solution[i]).sum();
        let pivot = matrix[row][row];
        solution[row] = if pivot == 0.0 { 0.0 } else { (right[row] - known) / pivot };
    }
    solution
}
