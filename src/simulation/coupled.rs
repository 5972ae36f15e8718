//! What couples the air with fabric and rigid bodies: markers with a kernel, or links of the lattice that the surfaces cut.

use super::air::AirEngine;
use super::bodies::Load;
use super::kernel_coupling::KernelCoupling;
use super::link_coupling::LinkCoupling;
use super::markers::MarkerEngine;
use crate::case::Scene;
use crate::case::coupling::Scheme;
use crate::case::scene::{Air, Coupling};
use crate::checkpoint::{CheckpointError, Reader, Writer};
use crate::cpu::cloth::{Cloth, MarkerReaction, TriangleReaction};
use crate::cut_links::OutOfAir;
use crate::gpu::DeviceError;
use crate::immersed::markers::Marker;
use crate::immersed::permeable::Permeable;
use crate::immersed::touched::OutOfDomain;
use crate::plan::Plan;
use crate::units::Units;

/// Air and structure, coupled.
#[derive(Debug)]
pub enum Coupled {
    /// Through a kernel.
    Kernel(Box<KernelCoupling>),
    /// At cut links.
    Links(Box<LinkCoupling>),
}

macro_rules! both {
    ($self:expr, $coupling:ident => $body:expr) => {
        match $self {
            Coupled::Kernel($coupling) => $body,
            Coupled::Links($coupling) => $body,
        }
    };
}

/// A point of a surface that has left the air, [cells].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftTheAir {
    /// Where it is.
    pub position: [f64; 3],
}

impl From<OutOfDomain> for LeftTheAir {
    fn from(out: OutOfDomain) -> Self {
        Self {
            position: out.position,
        }
    }
}

impl From<OutOfAir> for LeftTheAir {
    fn from(out: OutOfAir) -> Self {
        Self {
            position: out.position,
        }
    }
}

impl Coupled {
    pub(super) fn new(
        scene: &Scene,
        air: &Air,
        engine: &AirEngine,
        (coupling, plan): (&Coupling, &Plan),
    ) -> Result<Self, DeviceError> {
        Ok(match coupling.scheme {
            Scheme::Kernel => {
                Self::Kernel(Box::new(KernelCoupling::new(scene, air, engine, coupling)?))
            }
            Scheme::Links => Self::Links(Box::new(LinkCoupling::new(scene, air, engine, plan))),
        })
    }

    /// The scales.
    #[must_use]
    pub const fn units(&self) -> &Units {
        both!(self, coupling => coupling.units())
    }

    /// The kernel's side, to be changed.
    pub(super) const fn kernel_mut(&mut self) -> Option<&mut KernelCoupling> {
        match self {
            Self::Kernel(kernel) => Some(kernel),
            Self::Links(_) => None,
        }
    }

    /// The kernel's side, where there is one.
    pub(super) const fn kernel(&self) -> Option<&KernelCoupling> {
        match self {
            Self::Kernel(kernel) => Some(kernel),
            Self::Links(_) => None,
        }
    }

    /// The immersed boundary; `None` at cut links.
    #[must_use]
    pub fn immersed(&self) -> Option<&MarkerEngine> {
        self.kernel().map(KernelCoupling::immersed)
    }

    /// The markers of the fabric, fixed points of its triangles; none at cut links.
    #[must_use]
    pub fn markers(&self) -> &[Marker] {
        self.kernel().map_or(&[], KernelCoupling::markers)
    }

    /// Number of markers, or of links that are cut now.
    #[must_use]
    pub fn point_count(&self) -> usize {
        match self {
            Self::Kernel(kernel) => kernel.immersed().marker_count(),
            Self::Links(links) => links.link_count(),
        }
    }

    /// Total force on the air of the last `spread` or `bounce` [lattice units].
    #[must_use]
    pub const fn force_on_air(&self) -> [f64; 3] {
        both!(self, coupling => coupling.force_on_air())
    }

    /// Force on the air by the fabric alone in the last `spread` or `bounce` [lattice units].
    #[must_use]
    pub fn fabric_force_on_air(&self) -> [f64; 3] {
        both!(self, coupling => coupling.fabric_force_on_air())
    }

    /// Force on the air by fabric that is held, by the shares of held nodes [lattice units].
    pub(super) fn held_force_on_air(&self, cloth: &Cloth) -> [f64; 3] {
        both!(self, coupling => coupling.held_force_on_air(cloth))
    }

    /// What the air does to every rigid body by the last `spread` or `bounce`, at `time_s` [lattice units].
    #[must_use]
    pub fn body_loads(&self, time_s: f64) -> Vec<Load> {
        match self {
            Self::Kernel(kernel) => kernel.body_loads(time_s),
            Self::Links(links) => links.body_loads().to_vec(),
        }
    }

    /// Places of markers, or of the nodes of cut surfaces [cells].
    pub(super) fn positions(&self) -> Vec<[f64; 3]> {
        match self {
            Self::Kernel(kernel) => kernel.positions().to_vec(),
            Self::Links(links) => links.positions(),
        }
    }

    /// True if all that the structure touches lies in the box of cells `first..end`.
    #[must_use]
    pub fn touches_only(&self, first: [usize; 3], end: [usize; 3]) -> bool {
        match self {
            Self::Kernel(kernel) => kernel.immersed().touches_only(first, end),
            Self::Links(links) => links.surface().touches_only(first, end),
        }
    }

    /// Places of the markers, and what the last `spread` owes the air there in the next step [cells, lattice units]; nothing at cut links, where
    /// the air has it at once.
    pub(super) fn pending_forces(&self) -> Vec<([f64; 3], [f64; 3])> {
        self.kernel()
            .map_or_else(Vec::new, |kernel| kernel.pending_forces().collect())
    }

    /// Goes on on another lattice at `time_s`: with a kernel owing the air the forces of its first markers [cells, lattice units], at cut links from
    /// what was known `before`.
    pub(super) fn go_on(
        &mut self,
        air: &AirEngine,
        (cloth, time_s): (Option<&Cloth>, f64),
        owed: &[([f64; 3], [f64; 3])],
        before: Option<&LinkCoupling>,
    ) -> Result<Result<(), LeftTheAir>, DeviceError> {
        match (self, before) {
            (Self::Kernel(kernel), _) => left(kernel.go_on(air, cloth, time_s, owed)),
            (Self::Links(links), Some(before)) => {
                let gone_on = links.go_on(before, cloth, time_s);
                Ok(gone_on.map_err(LeftTheAir::from))
            }
            (Self::Links(links), None) => {
                Ok(links.find_links(cloth, time_s).map_err(LeftTheAir::from))
            }
        }
    }

    /// What cut links know of the air; nothing with a kernel.
    pub(super) fn into_links(self) -> Option<Box<LinkCoupling>> {
        match self {
            Self::Kernel(_) => None,
            Self::Links(links) => Some(links),
        }
    }

    /// Stage `send_markers`.
    pub(super) fn send_markers(
        &mut self,
        air: &AirEngine,
        cloth: Option<&Cloth>,
        time_s: f64,
    ) -> Result<Result<(), LeftTheAir>, DeviceError> {
        match self {
            Self::Kernel(kernel) => left(kernel.send_markers(air, cloth, time_s)),
            Self::Links(_) => Ok(Ok(())),
        }
    }

    /// Stage `interpolate`.
    pub(super) fn interpolate(
        &mut self,
        air: &AirEngine,
        cloth: Option<&Cloth>,
        time_s: f64,
    ) -> Result<Result<(), LeftTheAir>, DeviceError> {
        match self {
            Self::Kernel(kernel) => left(kernel.interpolate(air, cloth, time_s)),
            Self::Links(_) => Ok(Ok(())),
        }
    }

    /// Has a device begin with what `fetch_air_velocities` takes.
    pub(super) fn ask_air_velocities(&mut self) {
        if let Self::Kernel(kernel) = self {
            kernel.ask_air_velocities();
        }
    }

    /// Stage `fetch_air_velocities`.
    pub(super) fn fetch_air_velocities(&mut self) -> Result<(), DeviceError> {
        match self {
            Self::Kernel(kernel) => kernel.fetch_air_velocities(),
            Self::Links(_) => Ok(()),
        }
    }

    /// Stage `find_links`.
    pub(super) fn find_links(
        &mut self,
        cloth: Option<&Cloth>,
        time_s: f64,
    ) -> Result<(), LeftTheAir> {
        match self {
            Self::Kernel(_) => Ok(()),
            Self::Links(links) => links.find_links(cloth, time_s).map_err(LeftTheAir::from),
        }
    }

    /// Stage `read_links`.
    pub(super) fn read_links(&mut self, air: &mut AirEngine) -> Result<(), DeviceError> {
        match self {
            Self::Kernel(_) => Ok(()),
            Self::Links(links) => links.read_links(air),
        }
    }

    /// Stage `fetch_links`.
    pub(super) fn fetch_links(&mut self, air: &mut AirEngine) -> Result<(), DeviceError> {
        match self {
            Self::Kernel(_) => Ok(()),
            Self::Links(links) => links.fetch_links(air),
        }
    }

    /// First cell and end of the box of cells whose next step depends on what the structure does in this one; `None` where that is not known.
    pub(super) fn awaited_cells(&self) -> Option<[[i32; 3]; 2]> {
        match self {
            Self::Kernel(kernel) => kernel.immersed().forced_cells(),
            Self::Links(links) => links.surface().touched(),
        }
    }

    /// Stage `bounce`.
    pub(super) fn bounce(
        &mut self,
        air: &mut AirEngine,
        cloth: Option<&Cloth>,
        time_s: f64,
        released: bool,
    ) -> Result<(), DeviceError> {
        match self {
            Self::Kernel(_) => Ok(()),
            Self::Links(links) => links.bounce(air, cloth, time_s, released),
        }
    }

    /// The markers as the fabric feels them in this solve.
    pub(super) fn reactions(&self) -> &[MarkerReaction] {
        self.kernel().map_or(&[], KernelCoupling::reactions)
    }

    /// What they let pass; empty where nothing passes the fabric.
    pub(super) fn permeable(&self) -> &[Permeable] {
        self.kernel().map_or(&[], KernelCoupling::permeable)
    }

    /// The triangles that the air reacts on in this solve.
    pub(super) fn cut_triangles(&self) -> &[TriangleReaction] {
        match self {
            Self::Kernel(_) => &[],
            Self::Links(links) => links.reactions(),
        }
    }

    /// Makes what the fabric feels in the solve to come.
    pub(super) fn gather_reactions(&mut self) {
        both!(self, coupling => coupling.gather_reactions());
    }

    /// Stage `send_marker_forces`.
    pub(super) fn send_marker_forces(
        &mut self,
        cloth: Option<&Cloth>,
        time_s: f64,
        released: bool,
    ) {
        if let Self::Kernel(kernel) = self {
            kernel.send_marker_forces(cloth, time_s, released);
        }
    }

    /// Stage `spread`.
    pub(super) fn spread(&mut self, cloth: Option<&Cloth>, time_s: f64, released: bool) {
        if let Self::Kernel(kernel) = self {
            kernel.spread(cloth, time_s, released);
        }
    }

    /// Stage `repeat_forcing`.
    pub(super) fn repeat_forcing(&mut self) -> Result<(), DeviceError> {
        match self {
            Self::Kernel(kernel) => kernel.repeat_forcing(),
            Self::Links(_) => Ok(()),
        }
    }

    /// Stage `fetch_marker_forces`.
    pub(super) fn fetch_marker_forces(&mut self) -> Result<(), DeviceError> {
        match self {
            Self::Kernel(kernel) => kernel.fetch_marker_forces(),
            Self::Links(_) => Ok(()),
        }
    }

    /// Mean velocity of the air through what is permeable, and what residual slip adds to it, which at cut links is nothing [m/s]; `None`
    /// where nothing is permeable.
    #[must_use]
    pub fn through_velocities_m_s(&self) -> Option<[f64; 2]> {
        match self {
            Self::Kernel(kernel) => kernel.through_velocities_m_s(),
            Self::Links(links) => links.through_velocity_m_s().map(|through| [through, 0.0]),
        }
    }

    /// Root mean square slip of the air at the markers, beside what passes them [m/s]; `None` at cut links, where the wall's velocity is met at
    /// the cut.
    pub fn slip_m_s(&self) -> Result<Option<f64>, DeviceError> {
        self.kernel().map(KernelCoupling::slip_m_s).transpose()
    }

    /// Mean normal velocity of the air through all surfaces at `time_s`, relative to them and beside what they let pass [m/s]; `None` at cut
    /// links, which nothing else passes.
    pub fn leakage_m_s(
        &self,
        cloth: Option<&Cloth>,
        time_s: f64,
    ) -> Result<Option<f64>, DeviceError> {
        let of_kernel = |kernel: &KernelCoupling| kernel.leakage_m_s(cloth, time_s);
        self.kernel().map(of_kernel).transpose()
    }

    /// Fastest marker, or node of a cut surface [cells per step].
    #[must_use]
    pub fn fastest_marker(&self) -> f64 {
        both!(self, coupling => coupling.fastest_marker())
    }

    /// Fastest point of the fabric as its nodes move now [cells per step].
    pub(super) fn fastest_of_fabric(&self, cloth: &Cloth) -> f64 {
        both!(self, coupling => coupling.fastest_of_fabric(cloth))
    }

    pub(super) fn save(&self, out: &mut Writer) -> std::io::Result<()> {
        both!(self, coupling => coupling.save(out))
    }

    pub(super) fn restore(
        &mut self,
        from: &Reader,
        air: &AirEngine,
    ) -> Result<(), CheckpointError> {
        match self {
            Self::Kernel(kernel) => kernel.restore(from, air),
            Self::Links(links) => links.restore(from),
        }
    }
}

/// The same of a marker.
fn left<E>(done: Result<Result<(), OutOfDomain>, E>) -> Result<Result<(), LeftTheAir>, E> {
    done.map(|done| done.map_err(LeftTheAir::from))
}
