//! Changes of inputs: of bytes, of numbers and lines of texts, of sections of checkpoints. The same seed gives the same input.
//!
//! Crates that mutate bytes know neither numbers in texts nor checksums, which would stop nearly every input at the reader's door.

use fastrand::Rng;

/// Numbers at which readers and what they build on them go wrong.
const EXTREMES: [&str; 22] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "1e-300",
    "5e-324",
    "1e-9",
    "0.999999",
    "1.0000001",
    "1e9",
    "1e19",
    "1e308",
    "-1e308",
    "nan",
    "inf",
    "-inf",
    "255",
    "65536",
    "4294967295",
    "9223372036854775807",
];

/// Whole numbers at which they do.
const WHOLE: [&str; 9] = [
    "0",
    "1",
    "2",
    "3",
    "-1",
    "255",
    "65536",
    "4294967295",
    "9223372036854775807",
];

/// The same as bits of sections.
const EXTREME_WORDS: [u64; 10] = [
    0,
    1,
    2,
    u64::MAX,
    1 << 63,
    0x7ff8_0000_0000_0000,
    0x7ff0_0000_0000_0000,
    0x7fef_ffff_ffff_ffff,
    0x4340_0000_0000_0000,
    0xffff_ffff,
];

/// Longest input [bytes]; what is longer says nothing that a shorter one does not.
pub const LONGEST: usize = 1 << 20;

/// Input `number`, made from one of the seeds.
pub fn input(seeds: &[Vec<u8>], number: u64) -> Vec<u8> {
    let mut random = Rng::with_seed(number);
    let mut input = seeds[random.usize(..seeds.len())].clone();
    let other = &seeds[random.usize(..seeds.len())];
    mutate(&mut input, other, &mut random);
    input
}

/// One to a few changes; `other` is what foreign parts are taken from.
pub fn mutate(input: &mut Vec<u8>, other: &[u8], random: &mut Rng) {
    loop {
        if input.starts_with(MAGIC) && random.u8(..8) > 0 {
            mutate_section(input, random);
        } else if std::str::from_utf8(input).is_ok() && random.u8(..8) > 0 {
            mutate_text(input, other, random);
        } else {
            mutate_bytes(input, other, random);
        }
        if random.bool() {
            break;
        }
    }
    input.truncate(LONGEST);
}

/// A part of `length` bytes at most.
fn part(length: usize, most: usize, random: &mut Rng) -> std::ops::Range<usize> {
    let start = random.usize(..=length);
    let end = start + random.usize(..=(length - start).min(most));
    start..end
}

fn mutate_bytes(input: &mut Vec<u8>, other: &[u8], random: &mut Rng) {
    let at = random.usize(..=input.len());
    match random.u8(..8) {
        0 => input.truncate(at),
        1 => {
            input.drain(part(input.len(), 64, random));
        }
        2 => {
            let copied = input[part(input.len(), 64, random)].to_vec();
            input.splice(at..at, copied);
        }
        3 => {
            let foreign = other[part(other.len(), 256, random)].to_vec();
            input.splice(at..at, foreign);
        }
        4 if input.len() >= at + 4 => {
            let word = EXTREME_WORDS[random.usize(..EXTREME_WORDS.len())] as u32;
            input[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        5 if at < input.len() => input[at] = random.u8(..),
        _ if at < input.len() => input[at] ^= 1 << random.u8(..8),
        _ => input.push(random.u8(..)),
    }
}

/// Where numbers stand in a text.
fn numbers(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    let is_part = |byte: u8| byte.is_ascii_digit() || b".+-_eE".contains(&byte);
    let mut found = Vec::new();
    let mut at = 0;
    while at < text.len() {
        let begins = text[at].is_ascii_digit()
            || (text[at] == b'-' && text.get(at + 1).is_some_and(u8::is_ascii_digit));
        let in_word = at > 0 && (text[at - 1].is_ascii_alphanumeric() || text[at - 1] == b'_');
        if begins && !in_word {
            let length = text[at..].iter().take_while(|b| is_part(**b)).count();
            found.push(at..at + length);
            at += length;
        } else {
            at += 1;
        }
    }
    found
}

/// Lines with their ends.
fn lines(text: &[u8]) -> Vec<std::ops::Range<usize>> {
    let mut start = 0;
    let of = text.split_inclusive(|byte| *byte == b'\n').map(|line| {
        let range = start..start + line.len();
        start = range.end;
        range
    });
    of.collect()
}

fn mutate_text(input: &mut Vec<u8>, other: &[u8], random: &mut Rng) {
    let (numbers, lines) = (numbers(input), lines(input));
    let one_of = |ranges: &[std::ops::Range<usize>], random: &mut Rng| {
        ranges[random.usize(..ranges.len())].clone()
    };
    match random.u8(..16) {
        0..=6 if !numbers.is_empty() => {
            let place = one_of(&numbers, random);
            // A count that is no whole number is refused at once.
            let is_whole = input[place.clone()].iter().all(u8::is_ascii_digit);
            let of: &[&str] = if is_whole && random.u8(..4) > 0 {
                &WHOLE
            } else {
                &EXTREMES
            };
            let extreme = of[random.usize(..of.len())];
            input.splice(place, extreme.bytes());
        }
        7 | 8 if !numbers.is_empty() => {
            // A few digits more or less: what is still plausible.
            let place = one_of(&numbers, random);
            let text = String::from_utf8_lossy(&input[place.clone()]).into_owned();
            let factor = [-1.0, 0.01, 0.1, 0.5, 2.0, 3.0, 10.0, 1000.0][random.usize(..8)];
            let value = text.parse::<f64>().unwrap_or(1.0) * factor;
            let changed = if text.contains(['.', 'e']) {
                format!("{value:?}")
            } else {
                format!("{value:.0}")
            };
            input.splice(place, changed.into_bytes());
        }
        9 if !numbers.is_empty() => {
            let (from, to) = (one_of(&numbers, random), one_of(&numbers, random));
            let copied = input[from].to_vec();
            input.splice(to, copied);
        }
        10 if !lines.is_empty() => {
            input.drain(one_of(&lines, random));
        }
        11 if !lines.is_empty() => {
            let (copied, at) = (one_of(&lines, random), one_of(&lines, random).start);
            let copied = input[copied].to_vec();
            input.splice(at..at, copied);
        }
        12 | 13 if !lines.is_empty() && !other.is_empty() => {
            // Lines of another input: keys and whole tables that this one has not.
            let foreign = self::lines(other);
            let first = random.usize(..foreign.len());
            let last = (first + random.usize(..8)).min(foreign.len() - 1);
            let copied = other[foreign[first].start..foreign[last].end].to_vec();
            let at = one_of(&lines, random).start;
            input.splice(at..at, copied);
        }
        14 if !lines.is_empty() => {
            // A key twice, or a value without its key.
            let line = one_of(&lines, random);
            let equals = input[line.clone()].iter().position(|b| *b == b'=');
            if let Some(equals) = equals {
                input.drain(line.start..line.start + equals);
            }
        }
        _ => mutate_bytes(input, other, random),
    }
}

const MAGIC: &[u8] = b"RIPSTOP\0";

/// Magic and version.
const HEADER: usize = 12;

/// Name and data of all sections behind the header, as far as they can be told apart.
fn sections(checkpoint: &[u8]) -> Vec<(Vec<u8>, Vec<u8>)> {
    fn take<'a>(rest: &mut &'a [u8], count: usize) -> Option<&'a [u8]> {
        let (taken, left) = rest.split_at_checked(count)?;
        *rest = left;
        Some(taken)
    }
    let mut found = Vec::new();
    let mut rest = checkpoint.get(HEADER..).unwrap_or_default();
    let mut next = || {
        let length = u32::from_le_bytes(take(&mut rest, 4)?.try_into().ok()?);
        let name = take(&mut rest, length as usize)?.to_vec();
        let length = u64::from_le_bytes(take(&mut rest, 8)?.try_into().ok()?);
        take(&mut rest, 4)?;
        let length = usize::try_from(length).ok()?.min(rest.len());
        Some((name, take(&mut rest, length)?.to_vec()))
    };
    while let Some(section) = next() {
        found.push(section);
    }
    found
}

fn checkpoint(header: &[u8], sections: &[(Vec<u8>, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    for (name, data) in sections {
        bytes.extend((name.len() as u32).to_le_bytes());
        bytes.extend(name);
        bytes.extend((data.len() as u64).to_le_bytes());
        bytes.extend(crc32fast::hash(data).to_le_bytes());
        bytes.extend(data);
    }
    bytes
}

/// Changes one section, and writes its length and checksum anew.
fn mutate_section(input: &mut Vec<u8>, random: &mut Rng) {
    let mut sections = sections(input);
    // Identity and end are hardly worth a change, and populations are one as good as the other.
    let worth: Vec<usize> = (0..sections.len())
        .filter(|n| {
            let name = &sections[*n].0;
            let is_plain =
                name.starts_with(b"populations") || name == b"identity" || name == b"end";
            !is_plain || random.u8(..8) == 0
        })
        .collect();
    if worth.is_empty() {
        return mutate_bytes(input, &[], random);
    }
    let number = worth[random.usize(..worth.len())];
    let data = &mut sections[number].1;
    match random.u8(..12) {
        0..=5 if data.len() >= 8 => {
            let at = 8 * random.usize(..data.len() / 8);
            let word = EXTREME_WORDS[random.usize(..EXTREME_WORDS.len())];
            data[at..at + 8].copy_from_slice(&word.to_le_bytes());
        }
        6 => data.truncate(random.usize(..=data.len() / 8) * 8),
        7 => data.extend_from_within(..data.len().min(8)),
        8 => data.clear(),
        9 => {
            sections.remove(number);
        }
        10 => {
            let copy = sections[number].clone();
            sections.insert(random.usize(..=sections.len()), copy);
        }
        _ => mutate_bytes(data, &[], random),
    }
    *input = checkpoint(&input[..HEADER], &sections);
}
