//! Frames as ParaView XML files: the canopy as `.vtp`, the air as `.vti`.
//!
//! Arrays are stored raw, little-endian, behind the XML head (`AppendedData encoding="raw"`). Fields are the simulated time (`TimeValue`) and
//! where the file is from (`program`, `source`, `case`). Array names end in their SI unit.

use std::fmt::Write as _;
use std::io;
use std::iter::repeat_n;
use std::path::Path;

use glam::DVec3;

use super::atomic::{OutputError, invalid_data, write_atomically};
use super::provenance::Stamp;
use super::vtk_data::{Appended, write_file};
use crate::frame::{BodiesFrame, CableKind, FabricState, FluidFrame, StructureFrame};

/// Code of a cell to which a code array does not apply.
const NO_CODE: i8 = -1;

/// Writes fabric and cables of an instant as VTK `PolyData`.
///
/// Points are the nodes (m); cells are first the cable segments (`Lines`), then the fabric
/// triangles (`Polys`).
///
/// | array | on | type | meaning |
/// |---|---|---|---|
/// | `velocity_m_s` | points | 3 x f64 | node velocity (m/s) |
/// | `reaction_n` | points | 3 x f64 | force with which a support holds the node (N), without the air's pull on the node itself; zero where it is free |
/// | `contact_force_n` | points | 3 x f64 | force of other fabric on the node (N); only where the case has contact |
/// | `tension_1_n_m`, `tension_2_n_m` | cells | f64 | principal tensions, larger first (N/m); NaN on cables |
/// | `stress_pa`, `true_stress_pa` | cells | f64 | largest principal stress (Pa), over the thickness at rest and over that of fabric that has kept its volume; NaN on cables |
/// | `tension_1_direction` | cells | 3 × f64 | unit vector along `tension_1_n_m`, along which wrinkles run; 0 without tension, NaN on cables |
/// | `von_mises_pa` | cells | f64 | von Mises stress (Pa); NaN on cables |
/// | `shear_stress_pa`, `shear_strain` | cells | f64 | between warp and weft (Pa, 1); NaN on cables |
/// | `strain_1`, `strain_2` | cells | f64 | principal strains (Green), larger first; NaN on cables |
/// | `fabric_state` | cells | i8 | 0 taut, 1 wrinkled, 2 slack; -1 on cables |
/// | `cable_tension_n` | cells | f64 | tension (N); NaN on fabric |
/// | `cable_kind` | cells | i8 | 0 suspension line, 1 belt, 2 free cable, 3 vent line, 4 line over a gap, 5 riser; -1 on fabric |
///
/// # Errors
///
/// When the arrays of `structure` do not fit together or the file cannot be written; `path` is then
/// unchanged.
pub fn write_canopy_vtp(
    path: &Path,
    structure: &StructureFrame,
    stamp: Stamp<'_>,
) -> Result<(), OutputError> {
    check_structure(structure).map_err(|cause| OutputError::new("write", path, cause))?;
    let nodes = structure.positions_m.len();
    let (lines, polys) = (structure.cables.len(), structure.triangles.len());
    let mut data = Appended::default();
    let mut xml = String::from("<PolyData>\n");
    xml += &data.field_data(stamp);
    xml += &format!(
        "<Piece NumberOfPoints=\"{nodes}\" NumberOfVerts=\"0\" NumberOfLines=\"{lines}\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"{polys}\">\n"
    );

    xml += "<PointData Vectors=\"velocity_m_s\">\n";
    let velocities = structure.velocities_m_s.iter().map(|v| v.to_array());
    xml += &data.array("velocity_m_s", nodes, velocities);
    let reactions = structure.reactions_n.iter().map(|v| v.to_array());
    xml += &data.array("reaction_n", nodes, reactions);
    if let Some(forces) = &structure.contact_forces_n {
        let forces = forces.iter().map(|v| v.to_array());
        xml += &data.array("contact_force_n", nodes, forces);
    }
    xml += "</PointData>\n<CellData Scalars=\"tension_1_n_m\">\n";
    xml += &cell_data(&mut data, structure);
    xml += "</CellData>\n<Points>\n";
    let positions = structure.positions_m.iter().map(|p| p.to_array());
    xml += &data.array("points_m", nodes, positions);
    xml += "</Points>\n";
    xml += &topology(&mut data, "Lines", &structure.cables);
    xml += &topology(&mut data, "Polys", &structure.triangles);
    xml += "</Piece>\n</PolyData>\n";
    write_file(path, "PolyData", &xml, data)
}

/// Writes rigid bodies of an instant as VTK `PolyData`: triangles with the array `body` (number of the body, in the
/// order of names) on cells and `velocity_m_s` (3 x f64) on points, which are in metres.
///
/// # Errors
///
/// When the arrays of `bodies` do not fit together or the file cannot be written; `path` is then unchanged.
pub fn write_bodies_vtp(
    path: &Path,
    bodies: &BodiesFrame,
    stamp: Stamp<'_>,
) -> Result<(), OutputError> {
    let (nodes, polys) = (bodies.positions_m.len(), bodies.triangles.len());
    check_length("node velocities", bodies.velocities_m_s.len(), nodes)
        .and_then(|()| check_length("numbers of bodies", bodies.numbers.len(), polys))
        .and_then(|()| check_nodes(bodies.triangles.as_flattened(), nodes))
        .map_err(|cause| OutputError::new("write", path, cause))?;
    let mut data = Appended::default();
    let mut xml = String::from("<PolyData>\n");
    xml += &data.field_data(stamp);
    xml += &format!(
        "<Piece NumberOfPoints=\"{nodes}\" NumberOfVerts=\"0\" NumberOfLines=\"0\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"{polys}\">\n"
    );
    xml += "<PointData Vectors=\"velocity_m_s\">\n";
    let velocities = bodies.velocities_m_s.iter().map(|v| v.to_array());
    xml += &data.array("velocity_m_s", nodes, velocities);
    xml += "</PointData>\n<CellData Scalars=\"body\">\n";
    let numbers = bodies.numbers.iter().map(|&number| [i64::from(number)]);
    xml += &data.array("body", polys, numbers);
    xml += "</CellData>\n<Points>\n";
    let positions = bodies.positions_m.iter().map(|p| p.to_array());
    xml += &data.array("points_m", nodes, positions);
    xml += "</Points>\n";
    xml += &topology(&mut data, "Polys", &bodies.triangles);
    xml += "</Piece>\n</PolyData>\n";
    write_file(path, "PolyData", &xml, data)
}

/// The arrays on cells; VTK counts lines before polygons.
fn cell_data<'a>(data: &mut Appended<'a>, structure: &'a StructureFrame) -> String {
    let (lines, polys) = (structure.cables.len(), structure.triangles.len());
    let cells = lines + polys;
    let not_on_cables = || repeat_n([f64::NAN], lines);
    let tension = |rank: usize| {
        let tensions = structure.principal_tensions_n_m.iter();
        not_on_cables().chain(tensions.map(move |pair| [pair[rank]]))
    };
    let stress = not_on_cables().chain(structure.stress_pa.iter().map(|&stress| [stress]));
    let on_fabric =
        |values: &'a [f64]| repeat_n([f64::NAN], lines).chain(values.iter().map(|&value| [value]));
    let states = structure.states.iter().map(|&state| [state_code(state)]);
    let states = repeat_n([NO_CODE], lines).chain(states);
    let cable_tensions = structure.cable_tensions_n.iter().map(|&tension| [tension]);
    let cable_tensions = cable_tensions.chain(repeat_n([f64::NAN], polys));
    let kinds = structure.cable_kinds.iter().map(|&kind| [kind_code(kind)]);
    let kinds = kinds.chain(repeat_n([NO_CODE], polys));

    let mut xml = data.array("tension_1_n_m", cells, tension(0));
    xml += &data.array("tension_2_n_m", cells, tension(1));
    xml += &data.array("stress_pa", cells, stress);
    for (name, values) in [
        ("true_stress_pa", &structure.true_stress_pa),
        ("von_mises_pa", &structure.von_mises_pa),
        ("shear_stress_pa", &structure.shear_stress_pa),
        ("shear_strain", &structure.shear_strain),
    ] {
        xml += &data.array(name, cells, on_fabric(values));
    }
    for (k, name) in ["strain_1", "strain_2"].into_iter().enumerate() {
        let strains = structure.principal_strains.iter().map(move |e| [e[k]]);
        xml += &data.array(name, cells, repeat_n([f64::NAN], lines).chain(strains));
    }
    let directions = structure.tension_directions.iter().map(|d| d.to_array());
    let directions = repeat_n([f64::NAN; 3], lines).chain(directions);
    xml += &data.array("tension_1_direction", cells, directions);
    xml += &data.array("fabric_state", cells, states);
    xml += &data.array("cable_tension_n", cells, cable_tensions);
    xml += &data.array("cable_kind", cells, kinds);
    xml
}

/// The cells of one sort, each joining `N` points.
fn topology<'a, const N: usize>(
    data: &mut Appended<'a>,
    element: &str,
    cells: &'a [[u32; N]],
) -> String {
    let points = cells.iter().flatten().map(|&node| [i64::from(node)]);
    let ends = (1..=cells.len()).map(|cell| [(cell * N) as i64]);
    let connectivity = data.array("connectivity", cells.len() * N, points);
    let offsets = data.array("offsets", cells.len(), ends);
    format!("<{element}>\n{connectivity}{offsets}</{element}>\n")
}

fn state_code(state: FabricState) -> i8 {
    match state {
        FabricState::Taut => 0,
        FabricState::Wrinkled => 1,
        FabricState::Slack => 2,
    }
}

fn kind_code(kind: CableKind) -> i8 {
    match kind {
        CableKind::SuspensionLine => 0,
        CableKind::Belt => 1,
        CableKind::Cable => 2,
        CableKind::VentLine => 3,
        CableKind::GapLine => 4,
        CableKind::Riser => 5,
    }
}

/// VTK would crash on a node index out of range, so it must not get into a file.
fn check_structure(structure: &StructureFrame) -> io::Result<()> {
    let nodes = structure.positions_m.len();
    let (cables, triangles) = (structure.cables.len(), structure.triangles.len());
    check_length("node velocities", structure.velocities_m_s.len(), nodes)?;
    check_length("reactions", structure.reactions_n.len(), nodes)?;
    if let Some(forces) = &structure.contact_forces_n {
        check_length("contact forces", forces.len(), nodes)?;
    }
    let tensions = structure.principal_tensions_n_m.len();
    check_length("principal tensions", tensions, triangles)?;
    for (what, values) in [
        ("stresses", &structure.stress_pa),
        ("true stresses", &structure.true_stress_pa),
        ("von Mises stresses", &structure.von_mises_pa),
        ("shear stresses", &structure.shear_stress_pa),
        ("shear strains", &structure.shear_strain),
    ] {
        check_length(what, values.len(), triangles)?;
    }
    let strains = structure.principal_strains.len();
    check_length("principal strains", strains, triangles)?;
    let directions = structure.tension_directions.len();
    check_length("tension directions", directions, triangles)?;
    check_length("fabric states", structure.states.len(), triangles)?;
    check_length("cable kinds", structure.cable_kinds.len(), cables)?;
    check_length("cable tensions", structure.cable_tensions_n.len(), cables)?;
    check_nodes(structure.cables.as_flattened(), nodes)?;
    check_nodes(structure.triangles.as_flattened(), nodes)
}

fn check_nodes(used: &[u32], nodes: usize) -> io::Result<()> {
    let outside = |node: &&u32| usize::try_from(**node).is_ok_and(|node| node >= nodes);
    match used.iter().find(outside) {
        Some(node) => Err(invalid_data(format!(
            "a cell joins node {node}, but there are only {nodes} nodes"
        ))),
        None => Ok(()),
    }
}

fn check_length(what: &str, found: usize, expected: usize) -> io::Result<()> {
    if found == expected {
        return Ok(());
    }
    Err(invalid_data(format!(
        "the frame has {found} {what} instead of {expected}"
    )))
}

/// Writes the air of an instant: one `.vti`, or with boxes of finer cells one for every lattice and at `path` a `.vtm` that
/// lists them.
///
/// For `flow_0.vtm` these are `flow_0.vti`, `flow_0_box_1.vti`, `flow_0_box_2.vti` and so on, each box after those around it. Where others
/// follow, `vtkGhostType` hides points that one of them covers.
///
/// # Errors
///
/// As [`write_flow_vti`].
pub fn write_flow(path: &Path, fluid: &FluidFrame, stamp: Stamp<'_>) -> Result<(), OutputError> {
    if fluid.finer.is_empty() {
        return write_flow_vti(path, fluid, stamp);
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut listed = String::new();
    let lattices: Vec<&FluidFrame> = std::iter::once(fluid).chain(&fluid.finer).collect();
    for (number, lattice) in lattices.iter().enumerate() {
        let name = match number {
            0 => format!("{stem}.vti"),
            _ => format!("{stem}_box_{number}.vti"),
        };
        write_lattice(
            &path.with_file_name(&name),
            lattice,
            &lattices[number + 1..],
            stamp,
        )?;
        let label = match number {
            0 => "outermost".to_owned(),
            _ => format!("box {number}"),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            listed,
            "<DataSet index=\"{number}\" name=\"{label}\" file=\"{name}\"/>"
        );
    }
    write_atomically(path, |out| {
        write!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\" \
             byte_order=\"LittleEndian\">\n<vtkMultiBlockDataSet>\n{listed}</vtkMultiBlockDataSet>\n</VTKFile>\n"
        )
    })
}

/// Writes one grid of air of an instant as VTK `ImageData` whose points are the cell
/// centres.
///
/// Point arrays: `velocity_m_s` (3 x f32, in m/s) and `pressure_pa` (f32, in Pa), the pressure above
/// the outlet's. Coordinates are in metres.
///
/// # Errors
///
/// When the arrays of `fluid` do not fit its grid, the grid is empty, or the file cannot be
/// written; `path` is then unchanged.
pub fn write_flow_vti(
    path: &Path,
    fluid: &FluidFrame,
    stamp: Stamp<'_>,
) -> Result<(), OutputError> {
    write_lattice(path, fluid, &[], stamp)
}

/// The same, with points that lie in one of the `finer` grids hidden.
fn write_lattice(
    path: &Path,
    fluid: &FluidFrame,
    finer: &[&FluidFrame],
    stamp: Stamp<'_>,
) -> Result<(), OutputError> {
    check_fluid(fluid).map_err(|cause| OutputError::new("write", path, cause))?;
    let count = fluid.velocity_m_s.len();
    let extent = fluid
        .cells
        .map(|cells| format!("0 {}", cells - 1))
        .join(" ");
    let [x, y, z] = fluid.origin_m.to_array();
    let edge = fluid.cell_size_m;
    let mut data = Appended::default();
    let mut xml = String::new();
    // Writing to a string cannot fail.
    let _ = writeln!(
        xml,
        "<ImageData WholeExtent=\"{extent}\" Origin=\"{x:?} {y:?} {z:?}\" \
         Spacing=\"{edge:?} {edge:?} {edge:?}\">"
    );
    xml += &data.field_data(stamp);
    let _ = writeln!(xml, "<Piece Extent=\"{extent}\">");
    xml += "<PointData Scalars=\"pressure_pa\" Vectors=\"velocity_m_s\">\n";
    xml += &data.array("velocity_m_s", count, fluid.velocity_m_s.iter().copied());
    xml += &data.array("pressure_pa", count, fluid.pressure_pa.iter().map(|&p| [p]));
    if !finer.is_empty() {
        xml += &data.array("vtkGhostType", count, hidden(fluid, finer).map(|h| [h]));
    }
    xml += "</PointData>\n<CellData>\n</CellData>\n</Piece>\n</ImageData>\n";
    write_file(path, "ImageData", &xml, data)
}

/// VTK's mark of a point that is not shown.
const HIDDEN_POINT: u8 = 2;

/// The mark of every point: hidden where a finer grid has the air.
fn hidden<'a>(
    fluid: &'a FluidFrame,
    finer: &'a [&FluidFrame],
) -> impl ExactSizeIterator<Item = u8> + Clone + 'a {
    let [nx, ny, _] = fluid.cells;
    (0..fluid.velocity_m_s.len()).map(move |i| {
        let cell = [i % nx, i / nx % ny, i / nx / ny].map(|n| n as f64);
        let place = fluid.origin_m + fluid.cell_size_m * DVec3::from_array(cell);
        let covered = finer.iter().any(|finer| {
            let low = finer.origin_m - 0.5 * finer.cell_size_m;
            let size = DVec3::from_array(finer.cells.map(|n| n as f64)) * finer.cell_size_m;
            place.cmpgt(low).all() && place.cmplt(low + size).all()
        });
        if covered { HIDDEN_POINT } else { 0 }
    })
}

fn check_fluid(fluid: &FluidFrame) -> io::Result<()> {
    let [nx, ny, nz] = fluid.cells;
    let count = nx.checked_mul(ny).and_then(|area| area.checked_mul(nz));
    let count = count
        .filter(|&count| count > 0)
        .ok_or_else(|| invalid_data(format!("a grid of {nx} x {ny} x {nz} cells has no volume")))?;
    let edge_is_valid = fluid.cell_size_m.is_finite() && fluid.cell_size_m > 0.0;
    if !fluid.origin_m.is_finite() || !edge_is_valid {
        return Err(invalid_data("the grid has no valid origin or cell size"));
    }
    check_length("air velocities", fluid.velocity_m_s.len(), count)?;
    check_length("pressures", fluid.pressure_pa.len(), count)
}

#[cfg(test)]
mod tests {
    use super::super::provenance::Provenance;
    use super::*;
    use glam::DVec3;
    use std::fs;

    /// A written file taken apart again.
    struct Parsed {
        head: String,
        binary: Vec<u8>,
    }

    impl Parsed {
        fn read(path: &Path) -> Self {
            let bytes = fs::read(path).unwrap();
            let mark = b"<AppendedData encoding=\"raw\">\n_";
            let start = bytes.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
            let tail = b"\n</AppendedData>\n</VTKFile>\n";
            assert!(bytes.ends_with(tail));
            Self {
                head: String::from_utf8(bytes[..start].to_vec()).unwrap(),
                binary: bytes[start..bytes.len() - tail.len()].to_vec(),
            }
        }

        /// (name, offset, block) of every array, in the order of the head.
        fn arrays(&self) -> Vec<(String, usize, &[u8])> {
            let value = |line: &str, key: &str| {
                let from = line.find(&format!(" {key}=\"")).unwrap() + key.len() + 3;
                line[from..].split('"').next().unwrap().to_owned()
            };
            let elements = (self.head.lines()).filter(|l| {
                ["<DataArray ", "<Array "]
                    .iter()
                    .any(|tag| l.starts_with(tag))
            });
            elements
                .map(|line| {
                    let offset: usize = value(line, "offset").parse().unwrap();
                    let length = self.binary[offset..offset + 8].try_into().unwrap();
                    let length = u64::from_le_bytes(length) as usize;
                    let block = &self.binary[offset + 8..offset + 8 + length];
                    (value(line, "Name"), offset, block)
                })
                .collect()
        }

        fn check_blocks_follow_each_other(&self) {
            let mut expected = 0;
            for (name, offset, block) in self.arrays() {
                assert_eq!(offset, expected, "{name}");
                expected += 8 + block.len();
            }
            assert_eq!(expected, self.binary.len());
        }

        fn array(&self, name: &str) -> &[u8] {
            let found = self.arrays().into_iter().find(|a| a.0 == name);
            found.unwrap().2
        }
    }

    fn canopy() -> StructureFrame {
        StructureFrame {
            positions_m: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NEG_Z],
            velocities_m_s: vec![DVec3::new(1.0, 2.0, 3.0); 4],
            triangles: vec![[0, 1, 2]],
            reactions_n: vec![DVec3::ZERO; 4],
            contact_forces_n: None,
            principal_tensions_n_m: vec![[30.0, -0.5]],
            tension_directions: vec![DVec3::X],
            stress_pa: vec![4e5],
            true_stress_pa: vec![4.1e5],
            von_mises_pa: vec![3e5],
            shear_stress_pa: vec![1e5],
            shear_strain: vec![0.01],
            principal_strains: vec![[0.02, -0.01]],
            yield_stress_pa: None,
            rest_areas_m2: vec![0.5],
            states: vec![FabricState::Wrinkled],
            cables: vec![[0, 3], [1, 3]],
            cable_kinds: vec![CableKind::SuspensionLine, CableKind::Belt],
            cable_tensions_n: vec![7.0, 8.0],
        }
    }

    fn stamp(provenance: &Provenance) -> Stamp<'_> {
        Stamp {
            time_s: 2.0,
            provenance,
        }
    }

    fn doubles(bytes: &[u8]) -> Vec<f64> {
        let chunks = bytes.chunks_exact(8);
        chunks
            .map(|c| f64::from_le_bytes(c.try_into().unwrap()))
            .collect()
    }

    #[test]
    fn canopy_arrays_lie_where_the_head_says() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("canopy.vtp");
        let provenance = Provenance {
            program: "ripstop 1".to_owned(),
            ..Provenance::default()
        };
        let stamp = Stamp {
            time_s: 1.25,
            provenance: &provenance,
        };
        write_canopy_vtp(&path, &canopy(), stamp).unwrap();
        let file = Parsed::read(&path);
        file.check_blocks_follow_each_other();
        assert!(file.head.contains("NumberOfLines=\"2\""));
        assert!(file.head.contains("NumberOfPolys=\"1\""));
        assert_eq!(doubles(file.array("TimeValue")), [1.25]);
        assert_eq!(file.array("program"), b"ripstop 1\0");
        assert_eq!(doubles(file.array("points_m"))[3..6], [1.0, 0.0, 0.0]);
        let tension = doubles(file.array("tension_2_n_m"));
        assert!(tension[0].is_nan() && tension[1].is_nan());
        assert_eq!(tension[2], -0.5);
        let tension = doubles(file.array("cable_tension_n"));
        assert_eq!(tension[..2], [7.0, 8.0]);
        assert!(tension[2].is_nan());
        assert_eq!(file.array("fabric_state"), [255, 255, 1]);
        assert_eq!(file.array("cable_kind"), [0, 1, 255]);
    }

    #[test]
    fn flow_arrays_lie_where_the_head_says() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flow.vti");
        // More than one conversion chunk.
        let cells = [40, 30, 20];
        let fluid = FluidFrame {
            finer: Vec::new(),
            origin_m: DVec3::new(-1.0, 0.5, 1e-7),
            cell_size_m: 0.25,
            cells,
            velocity_m_s: (0..24_000).map(|i| [i as f32, 0.0, -1.0]).collect(),
            pressure_pa: (0..24_000).map(|i| 0.5 * i as f32).collect(),
        };
        write_flow_vti(&path, &fluid, stamp(&Provenance::default())).unwrap();
        let file = Parsed::read(&path);
        file.check_blocks_follow_each_other();
        assert!(file.head.contains("Extent=\"0 39 0 29 0 19\""));
        assert!(file.head.contains("Origin=\"-1.0 0.5 1e-7\""));
        assert_eq!(file.array("velocity_m_s").len(), 24_000 * 12);
        let pressure = file.array("pressure_pa");
        assert_eq!(pressure[pressure.len() - 4..], 11_999.5f32.to_le_bytes());
    }

    #[test]
    fn a_frame_that_does_not_fit_together_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("canopy.vtp");
        let nothing = Provenance::default();
        let mut broken = canopy();
        broken.triangles[0][1] = 4;
        let error = write_canopy_vtp(&path, &broken, stamp(&nothing)).unwrap_err();
        assert!(error.to_string().contains("node 4, but there are only 4"));
        let mut broken = canopy();
        broken.stress_pa.clear();
        let error = write_canopy_vtp(&path, &broken, stamp(&nothing)).unwrap_err();
        assert!(error.to_string().contains("0 stresses instead of 1"));
        let fluid = FluidFrame {
            finer: Vec::new(),
            origin_m: DVec3::ZERO,
            cell_size_m: 1.0,
            cells: [2, 0, 2],
            velocity_m_s: Vec::new(),
            pressure_pa: Vec::new(),
        };
        assert!(write_flow_vti(&path, &fluid, stamp(&nothing)).is_err());
        assert!(!path.exists());
    }
}
