//! The machines, one file (or folder) each: a table of axes, a sketch, and a closed-form inverse where one exists.

pub mod arm;
pub mod two_sided;
