//! `velvet bed`: a mesh that a board saved on its card, as words, a map and a page.

mod page;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow, bail};
use config::BoardId;
use motion::{GridShape, Interpolation, Motion};
use procedures::leveling::findings::{Means, sentence};
use procedures::leveling::form::Form;
use procedures::leveling::map;
use procedures::leveling::profile_file::ProfileReader;

/// What `velvet bed` takes.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// The mesh: NAME.mesh, or Smoothieware's cartesian.grid or delta.grid
    file: PathBuf,
    /// The machine's configuration: what lies between the points, and what there is to level the bed with
    #[arg(long)]
    config: Option<PathBuf>,
    /// Draw the bed: a page with a map, a view in space, and the heights
    #[arg(long, value_name = "HTML")]
    page: Option<PathBuf>,
}

/// Mesh of a bed, and the findings about it.
pub struct Mesh {
    pub shape: GridShape,
    pub heights: Vec<f32>,
    pub form: Form,
    pub means: Means,
    pub interpolation: Interpolation,
    /// Motion whose compensation is laid through the mesh's points.
    motion: Box<Motion>,
}

/// Prints the map and the sentences; writes the page.
pub fn bed(options: &Options) -> Result<()> {
    let path = options.file.display();
    let (shape, heights) = read(&options.file)?;
    let (means, interpolation) = of_machine(options)?;
    let mesh = Mesh::new(shape, heights, means, interpolation).with_context(|| format!("{path} is no mesh"))?;
    for line in mesh.map() {
        println!("{line}");
    }
    if let Some(page) = &options.page {
        let title = options.file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        fs::write(page, page::page(&mesh, &title)).with_context(|| format!("cannot write {}", page.display()))?;
    }
    Ok(())
}

/// Reads a mesh as a board keeps it (`NAME.mesh`, `cartesian.grid`, `delta.grid`): its points and heights.
pub fn read(path: &Path) -> Result<(GridShape, Vec<f32>)> {
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let read = if is_grid(path) { grid_of(&bytes) } else { mesh_of(&bytes) };
    read.with_context(|| format!("{} is no mesh", path.display()))
}

/// Returns whether the file is a grid as Smoothieware keeps it, which does not say where it lies.
pub fn is_grid(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "grid")
}

fn of_machine(options: &Options) -> Result<(Means, Interpolation)> {
    let Some(path) = &options.config else { return Ok((Means::default(), Interpolation::Spline)) };
    let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let (config, summary) = config::parse(&bytes, BoardId::default(), &mut ());
    if !summary.is_usable() {
        bail!("{} has errors; see: velvet check {0}", path.display());
    }
    Ok((map::means(&config), config.leveling.mesh.interpolation))
}

impl Mesh {
    fn new(shape: GridShape, heights: Vec<f32>, means: Means, interpolation: Interpolation) -> Result<Self> {
        let form = Form::of(&shape, &heights).ok_or_else(|| anyhow!("it has too few points"))?;
        let mut motion = Box::new(Motion::new());
        motion.draft().iter_mut().zip(&heights).for_each(|(to, height)| *to = *height);
        let laid = motion.level_by_draft(&shape, interpolation, None);
        laid.map_err(|flaw| anyhow!("{flaw}"))?;
        Ok(Self { shape, heights, form, means, interpolation, motion })
    }

    /// Returns the height of the surface at a place, mm.
    pub fn height(&self, x: f64, y: f64) -> f64 {
        self.motion.compensation().height(x, y).z
    }

    /// Returns the sentences that describe the bed.
    pub fn sentences(&self) -> Vec<String> {
        (0..).map_while(|number| sentence(&self.form, self.means, number)).map(|text| text.as_str().into()).collect()
    }

    fn map(&self) -> Vec<String> {
        let at = |x, y| self.height(x, y);
        let line = |index| map::line(&self.shape, &self.form, &at, self.means, index);
        (0..).map_while(line).map(|line| line.as_str().into()).collect()
    }
}

/// Reads a mesh file that has a name.
fn mesh_of(bytes: &[u8]) -> Result<(GridShape, Vec<f32>)> {
    let (mut reader, mut heights) = (ProfileReader::default(), Vec::new());
    let mut take = |_: usize, height: f32| heights.push(height);
    for byte in bytes {
        reader.push(*byte, &mut take).map_err(|flaw| anyhow!("{flaw}"))?;
    }
    let shape = reader.finish(&mut take).map_err(|flaw| anyhow!("{flaw}"))?;
    Ok((shape, heights))
}

/// Reads a grid as Smoothieware writes it: points along X, along Y if that differs, sizes, heights; for a
/// delta points along a side, radius, heights. The file's length tells the kinds apart.
fn grid_of(bytes: &[u8]) -> Result<(GridShape, Vec<f32>)> {
    let count = |index: usize| bytes.get(index).map_or(0, |byte| usize::from(*byte));
    let (nx, ny) = (count(0), count(1));
    let is_long = |header: usize, points: usize| bytes.len() == header + 4 * points;
    let (header, sizes, counts) = match () {
        () if is_long(9, nx * nx) => (1, 2, [nx, nx]),
        () if is_long(10, nx * ny) => (2, 2, [nx, ny]),
        () if is_long(5, nx * nx) => (1, 1, [nx, nx]),
        () => bail!("no grid has {} bytes", bytes.len()),
    };
    if counts.iter().any(|count| *count < 2) {
        bail!("it has fewer than two points along a side");
    }
    let chunks = bytes.get(header..).unwrap_or_default().chunks_exact(4);
    let numbers: Vec<f32> = chunks.map(|chunk| f32::from_le_bytes(chunk.try_into().unwrap_or_default())).collect();
    let (size, heights) = numbers.split_at(sizes);
    let (origin, size) = match *size {
        [radius] => ([-f64::from(radius); 2], [2.0 * f64::from(radius); 2]),
        [width, depth] => ([0.0; 2], [f64::from(width), f64::from(depth)]),
        _ => bail!("it has no size"),
    };
    let step = [0, 1].map(|axis| size[axis] / (counts[axis] - 1) as f64);
    Ok((GridShape { origin, step, count: counts }, heights.to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "mesh 1\npoints 3 2\norigin 10 20\nstep 40 55\nheights\n0 0.1 0.2\n0 0.1 0.2\n";

    fn grid(head: &[u8], numbers: &[f32]) -> Vec<u8> {
        head.iter().copied().chain(numbers.iter().flat_map(|number| number.to_le_bytes())).collect()
    }

    #[test]
    fn every_file_that_a_board_writes_is_read() {
        let (shape, heights) = mesh_of(TEXT.as_bytes()).expect("a mesh");
        assert_eq!((shape.count, shape.origin, heights.len()), ([3, 2], [10.0, 20.0], 6));
        let square = grid(&[2], &[100.0, 80.0, 0.0, 0.1, 0.2, 0.3]);
        let (shape, heights) = grid_of(&square).expect("a grid");
        assert_eq!((shape.step, shape.count, heights), ([100.0, 80.0], [2, 2], vec![0.0, 0.1, 0.2, 0.3]));
        let oblong = grid(&[3, 2], &[100.0, 80.0, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5]);
        let (shape, _) = grid_of(&oblong).expect("a grid");
        assert_eq!((shape.step, shape.count), ([50.0, 80.0], [3, 2]));
        let round = grid(&[3], &[60.0, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]);
        let (shape, _) = grid_of(&round).expect("a grid");
        assert_eq!((shape.origin, shape.step), ([-60.0; 2], [60.0; 2]));
        assert!(grid_of(&square[1..]).is_err() && grid_of(&[]).is_err() && mesh_of(b"G28").is_err());
    }

    #[test]
    fn what_is_said_is_what_the_board_says() {
        let (shape, heights) = mesh_of(TEXT.as_bytes()).expect("a mesh");
        let mesh = Mesh::new(shape, heights, Means::default(), Interpolation::Bilinear).expect("a mesh");
        assert!((mesh.height(30.0, 40.0) - 0.05).abs() < 1e-6);
        assert!(mesh.sentences().iter().any(|line| line.contains("the right side is 0.200 mm higher")));
        assert!(mesh.map().len() > 10);
        let steep = Mesh::new(shape, vec![0.0, 20.0, 0.0, 0.0, 0.0, 0.0], Means::default(), Interpolation::Spline);
        assert!(steep.err().expect("too steep").to_string().contains("25 %"));
    }

    #[test]
    fn the_page_stands_alone_and_a_name_cannot_break_it() {
        let (shape, heights) = mesh_of(TEXT.as_bytes()).expect("a mesh");
        let mesh = Mesh::new(shape, heights, Means::default(), Interpolation::Spline).expect("a mesh");
        let page = page::page(&mesh, "</title><b>bed.mesh");
        assert!(!page.contains("</title><b>") && !page.contains("{{"));
        for outside in ["src=\"http", "href=\"http", "@import", "url(http"] {
            assert!(!page.contains(outside), "{outside}");
        }
        assert!(page.contains("the right side is 0.200 mm higher") && page.contains("\"wide\":64"));
    }
}
