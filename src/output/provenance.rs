//! What a file says of where it is from: program, case, and what was changed in it.

use super::xml::escaped;

/// The mark of a PNG file.
const PNG_MARK: &[u8] = b"\x89PNG\r\n\x1a\n";

/// First bytes of a PNG file: its mark and the chunk of its size, which comes first.
const PNG_HEAD_BYTES: usize = 33;

/// What its parts are called in pictures.
const IN_PICTURES: [&str; 3] = ["Software", "Source", "Comment"];

/// Where a frame or a picture is from. Frames carry it as field data of these names, PNG files as texts, SVG files as metadata.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Program and version.
    pub program: String,
    /// Name of the case file, its variant, and what the command line changed of the physics.
    pub source: String,
    /// The physics of the case as it is run, as TOML.
    pub case: String,
}

/// An instant of a run.
#[derive(Debug, Clone, Copy)]
pub struct Stamp<'a> {
    /// Simulated time [s].
    pub time_s: f64,
    /// Where it is from.
    pub provenance: &'a Provenance,
}

impl Provenance {
    /// Names and texts as field data; those without a text are left out.
    pub(super) fn fields(&self) -> impl Iterator<Item = (&'static str, &str)> {
        self.named(["program", "source", "case"])
    }

    /// A PNG file with the texts `Software`, `Source` and `Comment`; what is no PNG file stays as it is.
    #[must_use]
    pub fn put_into_png(&self, png: &[u8]) -> Vec<u8> {
        let head = png.split_at_checked(PNG_HEAD_BYTES);
        let Some((head, rest)) = head.filter(|_| png.starts_with(PNG_MARK)) else {
            return png.to_vec();
        };
        let texts = self.named(IN_PICTURES);
        let chunks = texts.flat_map(|(keyword, text)| international_text(keyword, text));
        head.iter()
            .copied()
            .chain(chunks)
            .chain(rest.iter().copied())
            .collect()
    }

    /// An SVG file with the same texts as its metadata; what is no SVG file stays as it is.
    #[must_use]
    pub fn put_into_svg(&self, svg: &str) -> String {
        let texts = self.named(IN_PICTURES);
        let texts: String = texts
            .map(|(keyword, text)| format!("{keyword}: {}\n", escaped(text.trim_end())))
            .collect();
        let mark = svg.find("<svg").unwrap_or(svg.len());
        match svg[mark..].find('>') {
            Some(end) if !texts.is_empty() => {
                let (head, rest) = svg.split_at(mark + end + 1);
                format!("{head}\n<metadata>\n{texts}</metadata>\n{rest}")
            }
            _ => svg.to_owned(),
        }
    }

    fn named(&self, names: [&'static str; 3]) -> impl Iterator<Item = (&'static str, &str)> {
        let texts = [&self.program, &self.source, &self.case].map(String::as_str);
        (names.into_iter().zip(texts)).filter(|(_, text)| !text.is_empty())
    }
}

/// A chunk `iTXt` of a PNG file (PNG 1.2, section 4.2.3.3), not compressed, without a language.
fn international_text(keyword: &str, text: &str) -> Vec<u8> {
    let mut chunk = b"iTXt".to_vec();
    chunk.extend_from_slice(keyword.as_bytes());
    chunk.extend_from_slice(&[0; 5]);
    chunk.extend_from_slice(text.as_bytes());
    let length = (chunk.len() - 4) as u32;
    let checksum = crc32fast::hash(&chunk);
    let mut bytes = length.to_be_bytes().to_vec();
    bytes.extend_from_slice(&chunk);
    bytes.extend_from_slice(&checksum.to_be_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn another_program_reads_the_texts_of_a_picture() {
        let image = image::RgbImage::from_pixel(5, 3, image::Rgb([1, 2, 3]));
        let mut plain = Cursor::new(Vec::new());
        image.write_to(&mut plain, image::ImageFormat::Png).unwrap();
        let provenance = Provenance {
            program: "ripstop 1".to_owned(),
            source: "case.toml, --set fabric.name=Ü".to_owned(),
            case: "[air]\nspeed = 1.0\n".to_owned(),
        };
        let bytes = provenance.put_into_png(plain.get_ref());
        let again = image::load_from_memory(&bytes).unwrap().to_rgb8();
        assert_eq!(again, image);
        let reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let texts = &reader.info().utf8_text;
        let texts = texts
            .iter()
            .map(|t| (&t.keyword[..], t.get_text().unwrap()));
        let expected = [
            ("Software", &provenance.program),
            ("Source", &provenance.source),
            ("Comment", &provenance.case),
        ];
        assert!(texts.eq(expected.map(|(name, text)| (name, text.clone()))));
        let nothing = Provenance::default();
        assert_eq!(&nothing.put_into_png(plain.get_ref()), plain.get_ref());
        for other in [&b"short"[..], &[7; 100]] {
            assert_eq!(provenance.put_into_png(other), other);
        }
    }

    #[test]
    fn the_texts_stand_in_a_drawing_and_change_nothing_else() {
        let provenance = Provenance {
            program: "ripstop 1".to_owned(),
            source: "a&b.toml, --set title=\"\u{1b}\"".to_owned(),
            case: "title = \"<Ü>\"\n[air]\nspeed = 1.0\n".to_owned(),
        };
        let plain = "<?xml version=\"1.0\"?>\n<svg width=\"5\"><title>a</title></svg>";
        let svg = provenance.put_into_svg(plain);
        let metadata = "\n<metadata>\nSoftware: ripstop 1\nSource: a&amp;b.toml, --set title=&quot;\u{fffd}&quot;\n\
            Comment: title = &quot;&lt;Ü&gt;&quot;\n[air]\nspeed = 1.0\n</metadata>\n";
        let (head, rest) = svg.split_once(metadata).unwrap();
        assert!(head.ends_with("<svg width=\"5\">") && rest.starts_with("<title>"));
        assert_eq!(format!("{head}{rest}"), plain);
        assert_eq!(Provenance::default().put_into_svg(plain), plain);
        for other in ["", "<p>no drawing</p>", "<svg cut short"] {
            assert_eq!(provenance.put_into_svg(other), other);
        }
    }
}
