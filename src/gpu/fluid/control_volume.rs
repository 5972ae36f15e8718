//! What crosses the faces of a box of cells, step by step, on the device. The sums of a step stay there in a ring, so that keeping
//! the balance costs no wait; the host adds them up in double precision when it asks, or when the ring is full.

use super::names::by_number;
use super::{Bound, Fluid};
use crate::gpu::error::DeviceError;
use crate::gpu::shaders::{self, parameters};
use crate::lattice::DIRECTIONS;
use crate::lattice::control_volume::{ControlVolume, MassMomentum};

/// Steps that wait on the device.
const RING_STEPS: usize = 256;

/// Entries that one workgroup sums.
const PORTION: usize = 1024;

parameters! {
    /// What one workgroup sums: entries of one array.
    Portion {
        /// Number of the array.
        array_number: u32,
        /// First entry in the list.
        first: u32,
        /// Entries.
        count: u32,
        /// Unused.
        padding: u32,
    }
    /// Where the sums of a step go.
    RingPlace {
        /// Where they begin.
        offset: u32,
        /// Portions.
        portions: u32,
        /// Unused.
        padding_a: u32,
        /// Unused.
        padding_b: u32,
    }
}

/// A box under watch.
#[derive(Debug)]
pub struct VolumeWatch {
    sums: wgpu::Buffer,
    ring: wgpu::Buffer,
    /// By parity of the step to come.
    sides: [Side; 2],
    /// Parities of the steps that wait.
    waiting: Vec<bool>,
    total: MassMomentum,
}

#[derive(Debug)]
struct Side {
    bound: Bound,
    /// Sign and direction of every portion.
    meaning: Vec<(f64, usize)>,
}

impl Fluid {
    /// Begins to watch a box.
    pub fn watch_volume(&self, volume: &ControlVolume) -> Result<VolumeWatch, DeviceError> {
        let device = &self.device;
        let [pipeline] = device.pipelines(
            &shaders::CONTROL_VOLUME[self.population_storage() as usize],
            ["outflow"],
            &[],
        )?;
        let lists = [0, 1].map(|parity| portions(volume, parity));
        let most = lists[0].1.len().max(lists[1].1.len());
        let sums = device.storage("outflow sums", (4 * most * RING_STEPS) as u64)?;
        let ring = device.uniform::<RingPlace>("ring")?;
        let side = |(entries, portions, meaning): &(Vec<u32>, Vec<Portion>, Vec<(f64, usize)>)| {
            let entries = device.storage_of("crossings", entries)?;
            let portions = device.storage_of("portions", portions)?;
            let mut named = by_number(&self.populations);
            named.extend([
                ("crossings", &entries),
                ("portions", &portions),
                ("outflow_sums", &sums),
                ("ring", &ring),
            ]);
            Ok(Side {
                bound: device.bind(&pipeline, &named)?,
                meaning: meaning.clone(),
            })
        };
        let sides = [side(&lists[0])?, side(&lists[1])?];
        Ok(VolumeWatch {
            sums,
            ring,
            sides,
            waiting: Vec::with_capacity(RING_STEPS),
            total: MassMomentum::default(),
        })
    }

    /// Adds the net outflow of the step just done.
    pub fn add_outflow(&self, watch: &mut VolumeWatch) -> Result<(), DeviceError> {
        if watch.waiting.len() == RING_STEPS {
            self.collect(watch)?;
        }
        let side = &watch.sides[usize::from(self.odd)];
        let portions = side.meaning.len();
        let place = RingPlace {
            offset: (watch.waiting.len() * watch.stride()) as u32,
            portions: portions as u32,
            ..RingPlace::default()
        };
        self.device.write(&watch.ring, 0, &[place]);
        let mut commands = self.device.record("outflow");
        {
            let mut pass = commands.pass("outflow");
            side.bound
                .dispatch(&mut pass, self.device.workgroups(64 * portions as u64));
        }
        self.device.leave(commands);
        watch.waiting.push(self.odd);
        Ok(())
    }

    /// Fetches what waits on the device.
    fn collect(&self, watch: &mut VolumeWatch) -> Result<(), DeviceError> {
        if watch.waiting.is_empty() {
            return Ok(());
        }
        let stride = watch.stride();
        let sums: Vec<f32> = self
            .device
            .read(&watch.sums, 0, stride * watch.waiting.len())?;
        for (odd, step) in watch.waiting.drain(..).zip(sums.chunks_exact(stride)) {
            let side = &watch.sides[usize::from(odd)];
            for (&(sign, direction), &sum) in side.meaning.iter().zip(step) {
                let net = sign * f64::from(sum);
                watch.total.mass_excess += net;
                for a in 0..3 {
                    watch.total.momentum[a] += net * f64::from(DIRECTIONS[direction][a]);
                }
            }
        }
        Ok(())
    }

    /// Mass and momentum that left the box minus what entered it, since the last call.
    pub fn take_outflow(&self, watch: &mut VolumeWatch) -> Result<MassMomentum, DeviceError> {
        self.collect(watch)?;
        Ok(std::mem::take(&mut watch.total))
    }
}

impl VolumeWatch {
    fn stride(&self) -> usize {
        self.sides[0].meaning.len().max(self.sides[1].meaning.len())
    }
}

/// The list of entries, its portions and their meaning.
fn portions(volume: &ControlVolume, parity: usize) -> (Vec<u32>, Vec<Portion>, Vec<(f64, usize)>) {
    let (mut entries, mut portions, mut meaning) = (Vec::new(), Vec::new(), Vec::new());
    for crossing in &volume.crossings[parity] {
        for (sign, array, slots) in [
            (1.0, crossing.leaving_array, &crossing.leaving),
            (-1.0, crossing.entering_array, &crossing.entering),
        ] {
            for part in slots.chunks(PORTION) {
                portions.push(Portion {
                    array_number: array as u32,
                    first: entries.len() as u32,
                    count: part.len() as u32,
                    padding: 0,
                });
                meaning.push((sign, crossing.direction));
                entries.extend_from_slice(part);
            }
        }
    }
    (entries, portions, meaning)
}
