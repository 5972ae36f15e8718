//! Tables of lines for a canopy from a mesh file: comma-separated text, one line per row below the names of the columns.
//!
//! `x_m, y_m, z_m` (a place at a node of the mesh, where the line is attached), `end_x_m, end_y_m, end_z_m` (its other end; lines that end at
//! the same place are joined there, and held), `length_m` (unstretched; the distance where it is left empty). Rows that begin with `#` are
//! passed over.

use glam::DVec3;

/// One line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TableLine {
    /// Where it is attached [m].
    pub attached_m: DVec3,
    /// Its other end [m].
    pub end_m: DVec3,
    /// Unstretched length [m].
    pub length_m: f64,
}

/// Names of the columns, in any order.
const COLUMNS: [&str; 7] = [
    "x_m", "y_m", "z_m", "end_x_m", "end_y_m", "end_z_m", "length_m",
];

/// Reads a table; the error says which row is wrong, counted from 1.
pub fn parse(text: &str) -> Result<Vec<TableLine>, String> {
    let mut rows = text
        .lines()
        .enumerate()
        .map(|(number, row)| (number + 1, row.trim()))
        .filter(|(_, row)| !row.is_empty() && !row.starts_with('#'));
    let (_, names) = rows.next().ok_or("it is empty")?;
    let names: Vec<&str> = names.split(',').map(str::trim).collect();
    let mut order = [0; COLUMNS.len()];
    for (column, place) in COLUMNS.iter().zip(&mut order) {
        *place = names
            .iter()
            .position(|name| name == column)
            .ok_or_else(|| format!("it has no column {column}"))?;
    }
    let mut lines = Vec::new();
    for (number, row) in rows {
        let cells: Vec<&str> = row.split(',').map(str::trim).collect();
        let cell = |k: usize| cells.get(order[k]).copied().unwrap_or_default();
        let value = |k: usize| -> Result<f64, String> {
            let read = cell(k).parse::<f64>().ok().filter(|v| v.is_finite());
            read.ok_or_else(|| format!("row {number}: `{}` is no {}", cell(k), COLUMNS[k]))
        };
        let attached_m = DVec3::new(value(0)?, value(1)?, value(2)?);
        let end_m = DVec3::new(value(3)?, value(4)?, value(5)?);
        let length_m = if cell(6).is_empty() {
            attached_m.distance(end_m)
        } else {
            value(6)?
        };
        if length_m <= 0.0 {
            return Err(format!(
                "row {number}: a length of {length_m} m is not positive"
            ));
        }
        lines.push(TableLine {
            attached_m,
            end_m,
            length_m,
        });
    }
    if lines.is_empty() {
        return Err("it has no lines".to_owned());
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_may_stand_in_any_order() {
        let text = "length_m, x_m, y_m, z_m, end_x_m, end_y_m, end_z_m\n# apex\n, 3, 0, 4, 0, 0, 0\n2.5, 1, 0, 0, 0, 0, 0\n";
        let lines = parse(text).unwrap();
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0].length_m, 5.0);
        assert_eq!(lines[1].attached_m, DVec3::X);
        assert_eq!(lines[1].length_m, 2.5);
    }

    #[test]
    fn faults_name_their_row() {
        let head = "x_m,y_m,z_m,end_x_m,end_y_m,end_z_m,length_m\n";
        for (rows, part) in [
            ("1,2,3,4,5\n", "row 2: `` is no end_z_m"),
            ("1,2,3,4,5,nan,1\n", "row 2"),
            ("1,2,3,4,5,6,-1\n", "not positive"),
            ("", "no lines"),
        ] {
            let error = parse(&format!("{head}{rows}")).unwrap_err();
            assert!(error.contains(part), "{rows}: {error}");
        }
        assert!(parse("x_m,y_m\n").unwrap_err().contains("z_m"));
        assert!(parse("").is_err());
    }
}
