//! The binary part of VTK XML files: arrays declared in the XML head, their bytes appended raw.

use std::io::{self, Write};
use std::path::Path;

use super::atomic::{OutputError, invalid_data, write_atomically};
use super::provenance::Stamp;

/// Bytes converted at a time.
const CHUNK_BYTES: usize = 64 * 1024;

/// Size of the byte count in front of every block (`header_type="UInt64"`).
const BLOCK_HEAD_BYTES: u64 = 8;

/// A number VTK can store.
pub(super) trait Scalar: Copy {
    /// VTK's name of the type.
    const VTK_TYPE: &'static str;
    /// Appends the little-endian bytes.
    fn append_to(self, bytes: &mut Vec<u8>);
}

macro_rules! scalar {
    ($($number:ty => $name:literal),*) => {$(
        impl Scalar for $number {
            const VTK_TYPE: &'static str = $name;
            fn append_to(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
        }
    )*};
}
scalar!(f32 => "Float32", f64 => "Float64", i8 => "Int8", u8 => "UInt8", i64 => "Int64");

type WriteBlock<'a> = Box<dyn FnOnce(&mut dyn Write) -> io::Result<()> + 'a>;

/// The arrays of one file, in the order of their bytes.
#[derive(Default)]
pub(super) struct Appended<'a> {
    blocks: Vec<(u64, WriteBlock<'a>)>,
    next_offset: u64,
}

impl<'a> Appended<'a> {
    /// Adds an array of `count` tuples of `N` components and returns its `DataArray` element.
    ///
    /// Nothing is converted before [`write_file`] runs.
    pub(super) fn array<T: Scalar, const N: usize>(
        &mut self,
        name: &str,
        count: usize,
        tuples: impl Iterator<Item = [T; N]> + 'a,
    ) -> String {
        let bytes = (count * N * size_of::<T>()) as u64;
        let write = move |out: &mut dyn Write| write_tuples(out, count, tuples);
        let offset = self.add(bytes, Box::new(write));
        let vtk_type = T::VTK_TYPE;
        format!(
            "<DataArray type=\"{vtk_type}\" Name=\"{name}\" NumberOfComponents=\"{N}\" \
             NumberOfTuples=\"{count}\" format=\"appended\" offset=\"{offset}\"/>\n"
        )
    }

    /// The `FieldData` element that tells the simulated time [s], which ParaView knows by its name, and where the file is from.
    pub(super) fn field_data(&mut self, stamp: Stamp<'a>) -> String {
        let mut fields = self.array("TimeValue", 1, std::iter::once([stamp.time_s]));
        for (name, text) in stamp.provenance.fields() {
            fields += &self.text(name, text);
        }
        format!("<FieldData>\n{fields}</FieldData>\n")
    }

    /// Adds a text, which ends with a byte 0, and returns its element.
    fn text(&mut self, name: &str, text: &'a str) -> String {
        let bytes = text.len() as u64 + 1;
        let write = move |out: &mut dyn Write| {
            out.write_all(text.as_bytes())?;
            out.write_all(&[0])
        };
        let offset = self.add(bytes, Box::new(write));
        format!(
            "<Array type=\"String\" Name=\"{name}\" NumberOfTuples=\"1\" format=\"appended\" offset=\"{offset}\"/>\n"
        )
    }

    /// Appends a block of so many bytes; returns where it begins.
    fn add(&mut self, bytes: u64, write: WriteBlock<'a>) -> u64 {
        let offset = self.next_offset;
        self.next_offset += BLOCK_HEAD_BYTES + bytes;
        self.blocks.push((bytes, write));
        offset
    }
}

fn write_tuples<T: Scalar, const N: usize>(
    out: &mut dyn Write,
    count: usize,
    tuples: impl Iterator<Item = [T; N]>,
) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(CHUNK_BYTES + N * size_of::<T>());
    let mut written = 0;
    for tuple in tuples {
        for number in tuple {
            number.append_to(&mut bytes);
        }
        written += 1;
        if bytes.len() >= CHUNK_BYTES {
            out.write_all(&bytes)?;
            bytes.clear();
        }
    }
    // A wrong count would shift every later array without any reader noticing.
    if written != count {
        return Err(invalid_data(format!(
            "an array has {written} entries instead of {count}"
        )));
    }
    out.write_all(&bytes)
}

/// Writes a VTK XML file of the data set type `kind` atomically: `content` is the XML inside
/// `VTKFile`, which refers to the arrays of `appended`.
pub(super) fn write_file(
    path: &Path,
    kind: &str,
    content: &str,
    appended: Appended<'_>,
) -> Result<(), OutputError> {
    write_atomically(path, |out| {
        write!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" \
             byte_order=\"LittleEndian\" header_type=\"UInt64\">\n{content}\
             <AppendedData encoding=\"raw\">\n_"
        )?;
        for (bytes, write) in appended.blocks {
            out.write_all(&bytes.to_le_bytes())?;
            write(out)?;
        }
        out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    })
}
