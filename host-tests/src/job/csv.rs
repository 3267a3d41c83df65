//! A CSV file beside a job: a head line that names the columns, then rows of cells.
//!
//! Cells are set apart by commas; what follows a `#` is a comment, lines without a cell count for nothing. Errors carry
//! the file's own name with line and column in it.

use super::{JobError, Place, Places};
use std::path::Path;

/// The text of a file.
pub(super) struct Csv {
    /// As errors tell it.
    pub name: String,
    text: String,
}

impl Csv {
    /// The file that stands at `key` of a job, seen from the folder of the job's own file.
    ///
    /// # Errors
    /// `BadFile`: at the key where the file cannot be read, at the file itself where it is no text.
    pub fn beside(places: &Places, key: &str, given: &str) -> Result<Self, JobError> {
        let folder = Path::new(&places.file).parent().unwrap_or(Path::new(""));
        let path = folder.join(given);
        let name = path.display().to_string();
        let bytes = std::fs::read(&path).map_err(|error| {
            let detail = format!(
                "{name} cannot be read ({error}); the path is seen from the folder of the job file"
            );
            places.refuse(key, "BadFile", detail)
        })?;
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Self { name, text }),
            Err(_) => Err(JobError {
                file: name,
                place: None,
                key: None,
                name: "BadFile",
                detail: "it is not text in UTF-8; expected a table of comma-separated numbers"
                    .into(),
            }),
        }
    }

    /// Lines that hold anything, counted from 1.
    pub fn lines(&self) -> impl Iterator<Item = (usize, &str)> {
        // A mark that some spreadsheets put before everything else.
        let text = self.text.strip_prefix('\u{feff}').unwrap_or(&self.text);
        (1..)
            .zip(text.lines())
            .map(|(line, text)| (line, text.split('#').next().unwrap_or("")))
            .filter(|(_, text)| !text.trim().is_empty())
    }

    pub fn refuse(
        &self,
        place: Option<Place>,
        column: Option<&str>,
        name: &'static str,
        detail: String,
    ) -> JobError {
        JobError {
            file: self.name.clone(),
            place,
            key: column.map(Into::into),
            name,
            detail,
        }
    }

    /// The cells of a line with their places, as many as there are columns.
    pub fn row<'a>(
        &self,
        (line, text): (usize, &'a str),
        columns: usize,
    ) -> Result<impl Iterator<Item = (Place, &'a str)>, JobError> {
        let count = cells(line, text).count();
        if count != columns {
            let place = Some(Place { line, column: 1 });
            let detail = format!("expected {columns} cells, found {count}");
            return Err(self.refuse(place, None, "WrongType", detail));
        }
        Ok(cells(line, text))
    }

    /// Any number, also one that is not finite.
    pub fn loose(&self, place: Place, column: &str, cell: &str) -> Result<f64, JobError> {
        cell.parse().map_err(|_| {
            let short: String = cell.chars().take(40).collect();
            let detail = format!("expected a number, found {short:?}");
            self.refuse(Some(place), Some(column), "WrongType", detail)
        })
    }

    pub fn number(&self, place: Place, column: &str, cell: &str) -> Result<f64, JobError> {
        let x = self.loose(place, column, cell)?;
        if x.is_finite() {
            return Ok(x);
        }
        let detail = format!("expected a finite number, found {cell}");
        Err(self.refuse(Some(place), Some(column), "NotFinite", detail))
    }

    pub fn ranged(
        &self,
        place: Place,
        column: &str,
        cell: &str,
        (least, most): (f64, f64),
    ) -> Result<f64, JobError> {
        let x = self.number(place, column, cell)?;
        if x >= least && x <= most {
            return Ok(x);
        }
        let detail = format!("expected a number from {least:e} to {most:e}, found {x}");
        Err(self.refuse(Some(place), Some(column), "OutOfRange", detail))
    }

    /// Rows of numbers in the order of `known`, whatever the order of the columns in the file; of the known columns the
    /// first `needed` must be there, the others are `None` where they are not. Numbers need not be finite: what is done
    /// with them has names of its own for that.
    pub fn table<const N: usize>(
        &self,
        known: [&str; N],
        needed: usize,
        most: usize,
    ) -> Result<Vec<Row<N>>, JobError> {
        let mut lines = self.lines();
        let Some((line, head)) = lines.next() else {
            let detail = format!(
                "it is empty; expected a line of column names, {}, and rows of numbers",
                known[..needed].join(",")
            );
            return Err(self.refuse(None, None, "OutOfRange", detail));
        };
        let mut columns: Vec<usize> = Vec::new();
        for (place, cell) in cells(line, head) {
            let Some(column) = known.iter().position(|name| *name == cell) else {
                let detail = format!(
                    "no such column is known here; expected are {}, as names in the first line",
                    known.join(", ")
                );
                return Err(self.refuse(Some(place), Some(cell), "UnknownField", detail));
            };
            if columns.contains(&column) {
                let detail = "this column is there already; keep one of them".into();
                return Err(self.refuse(Some(place), Some(cell), "Contradictory", detail));
            }
            columns.push(column);
        }
        if let Some(missing) = (0..needed).find(|column| !columns.contains(column)) {
            let name = known[missing];
            let place = Some(Place { line, column: 1 });
            let detail = format!("the column is missing; add {name}");
            return Err(self.refuse(place, Some(name), "MissingField", detail));
        }
        let mut rows = Vec::new();
        for (line, text) in lines {
            if rows.len() >= most {
                let place = Some(Place { line, column: 1 });
                let detail = format!("more than {most} rows; split the file");
                return Err(self.refuse(place, None, "OutOfRange", detail));
            }
            let mut row = Row {
                line,
                cells: [None; N],
            };
            for ((place, cell), column) in self.row((line, text), columns.len())?.zip(&columns) {
                let x = self.loose(place, known[*column], cell)?;
                row.cells[*column] = Some((place, x));
            }
            rows.push(row);
        }
        Ok(rows)
    }
}

/// A row of a table: its line, and its numbers with their places.
pub(super) struct Row<const N: usize> {
    pub line: usize,
    cells: [Option<(Place, f64)>; N],
}

impl<const N: usize> Row<N> {
    pub fn number(&self, column: usize) -> Option<f64> {
        self.cells.get(column)?.map(|(_, x)| x)
    }

    pub fn place(&self, column: usize) -> Place {
        let start = Place {
            line: self.line,
            column: 1,
        };
        let cell = self.cells.get(column).copied().flatten();
        cell.map_or(start, |(place, _)| place)
    }

    /// Three numbers that stand side by side in the order of columns, all of them needed.
    pub fn three(&self, first: usize) -> [f64; 3] {
        std::array::from_fn(|i| self.number(first + i).unwrap_or(f64::NAN))
    }
}

/// The cells of a line with their places.
pub(super) fn cells(line: usize, text: &str) -> impl Iterator<Item = (Place, &str)> {
    let mut column = 1;
    text.split(',').map(move |cell| {
        let lead = cell.chars().take_while(|c| c.is_whitespace()).count();
        let place = Place {
            line,
            column: column + lead,
        };
        column += cell.chars().count() + 1;
        (place, cell.trim())
    })
}
