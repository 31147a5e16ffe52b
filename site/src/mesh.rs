//! The mesh of the bed as object `bed_mesh`: its heights are kept here and told row by row, as all of them
//! are longer than an answer's part can be.

use base::snapshot::{MeshShown, Snapshot};
use http::json::Writer;
use units::MOST_SIDE;

/// Unit in which heights are kept, mm; the greatest is 32 mm.
const UNIT: f32 = 0.001;

/// Parts of a matrix: a row each, and one that ends it.
const MATRIX: usize = MOST_SIDE + 1;
/// Parts of the object behind its first: `probed_matrix` and `mesh_matrix`.
pub const PARTS: usize = 2 * MATRIX;

/// Heights of the mesh in force.
#[derive(Debug)]
pub struct Heights {
    /// Number of the mesh that they are of; 0: of none.
    number: u32,
    rows: [[i16; MOST_SIDE]; MOST_SIDE],
}

impl Heights {
    /// Makes the heights of no mesh.
    #[must_use]
    pub const fn new() -> Self {
        Self { number: 0, rows: [[0; MOST_SIDE]; MOST_SIDE] }
    }

    /// Returns whether these are the heights of the mesh of this number.
    #[must_use]
    pub const fn are_of(&self, number: u32) -> bool {
        self.number == number
    }

    /// Takes a row of the mesh of this number, mm.
    pub fn set(&mut self, number: u32, row: usize, heights: &[f32]) {
        self.number = number;
        for (to, height) in self.rows.get_mut(row).into_iter().flatten().zip(heights) {
            *to = libm::roundf(height / UNIT) as i16;
        }
    }
}

/// Writes the first part of the object, which stays open.
pub fn begin(of: &Snapshot, json: &mut Writer<'_, '_>) {
    let mesh = of.mesh.unwrap_or_default();
    json.key("profile_name");
    json.text(mesh.name.as_str());
    for (key, end) in ["mesh_min", "mesh_max"].into_iter().zip(mesh.ends) {
        json.key(key);
        super::objects::write_numbers(end, json);
    }
    json.key("probed_matrix");
    json.begin_array();
}

/// Writes a further part of the object; the last one ends it. There are as many parts for every mesh, so that
/// one that changes meanwhile still makes an object.
pub fn write(part: usize, of: &Snapshot, heights: &Heights, json: &mut Writer<'_, '_>) {
    let row = part % MATRIX;
    if row == MOST_SIDE {
        json.end_array();
        if part < MATRIX {
            // Velvet's own surface between the points is known to the machine alone.
            json.key("mesh_matrix");
            json.begin_array();
        } else {
            json.end_object();
        }
        return;
    }
    let MeshShown { count: [columns, rows], number, .. } = of.mesh.unwrap_or_default();
    if row < usize::from(rows) && heights.are_of(number) {
        json.begin_array();
        for height in heights.rows.get(row).into_iter().flatten().take(usize::from(columns)) {
            json.fixed(i64::from(*height), 3);
        }
        json.end_array();
    }
}
