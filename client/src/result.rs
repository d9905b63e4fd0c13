//! The result of a request: fragments borrowed straight from shared memory.

use crate::connection::{LoanCount, LoanedResult};
use crate::fragment::{Fragment, fragment, fragments};
use bytemuck::Zeroable;
use shatter_proto::convention::Convention;
use shatter_proto::result::{BLOCK_BYTES, EffectWire, SummaryWire};
use shatter_proto::view::{CheckedLayout, ResultView};
use shatter_proto::{Error, ErrorKind};
use std::sync::LazyLock;
use std::time::Duration;

pub use shatter_proto::result::{
    Bond, DebrisPoint, DegreeMethod, DegreeOrigin, EffectCost, EnergySource, FractureCriterion, FragmentSurface,
    FragmentVelocity, MissedTime, NO_MATERIAL, OuterAttributes, OverrunCause, SkinVertex, StageCost, StageKind,
    StopCriterion, Summary,
};

/// The result of a request. It holds one bucket of the daemon's pool until it is dropped: drop it once the fragments are
/// copied to where they are needed.
///
/// Arrays lie in shared memory and are borrowed; facts are copied when they are asked for. It may be sent to another thread; to share
/// it between threads, share its [`Fragment`]s.
#[must_use]
pub struct FractureResult {
    loan: LoanedResult,
    layout: Box<CheckedLayout>,
    convention: Convention,
    round_trip: Duration,
    _count: LoanCount,
}

/// The summary of a result whose memory the daemon changed.
static EMPTY: LazyLock<SummaryWire> = LazyLock::new(SummaryWire::zeroed);

impl FractureResult {
    /// Checks every offset, count and index of `loan` before anything of it is used. The request has a sequence and a convention.
    pub(crate) fn new(
        loan: LoanedResult,
        (sequence, convention): (u64, Convention),
        round_trip: Duration,
        count: LoanCount,
    ) -> Result<Self, Error> {
        let header = *loan.user_header();
        if header.sequence != sequence {
            let message = format!("the result is that of request {}, not {sequence}", header.sequence);
            return Err(Error::new(ErrorKind::BadResult, "sequence", message));
        }
        let layout = Box::new(CheckedLayout::new(&header, loan.payload())?);
        Ok(Self { loan, layout, convention, round_trip, _count: count })
    }

    /// The rows of shared memory, for the bindings of this workspace and for its tests. Their layout changes with the protocol: no
    /// part of the public interface.
    #[doc(hidden)]
    pub fn raw_view(&self) -> ResultView<'_> {
        // The ranges fit: they were checked against this very payload, whose length does not change.
        self.layout.view(self.loan.payload()).unwrap_or_else(|| ResultView::empty(&EMPTY))
    }

    /// The coordinates of the result: those of the connection. Lengths, here named by the meter, are in its unit.
    #[must_use]
    pub fn convention(&self) -> Convention {
        self.convention
    }

    /// The facts.
    pub fn summary(&self) -> Summary {
        self.raw_view().summary.into()
    }

    /// Names this result to later requests ([`Impact::from`](crate::Impact::from)); `None` if it is not kept: the request did not
    /// ask for it, the object stayed whole, or the service keeps no results. The service keeps it for a time (`times.kept_s`), until
    /// it keeps as many younger ones as it may (`results.kept_max`), or until [`Client::release`](crate::Client::release).
    #[must_use]
    pub fn handle(&self) -> Option<u64> {
        Some(self.raw_view().summary.handle).filter(|handle| *handle != 0)
    }

    /// Cost of each stage, in the order in which data flows.
    pub fn stages(&self) -> impl ExactSizeIterator<Item = StageCost> {
        self.raw_view().stages.iter().map(StageCost::from)
    }

    /// Cost of each effect, in the order of [`Effect::ALL`](crate::Effect::ALL).
    pub fn effects(&self) -> impl Iterator<Item = EffectCost> {
        self.raw_view().effects.iter().filter_map(EffectWire::cost)
    }

    /// Which fragments touch, and which the world holds; empty unless `bonds` is on.
    pub fn bonds(&self) -> impl ExactSizeIterator<Item = Bond> {
        self.raw_view().bonds.iter().map(Bond::from)
    }

    /// Points on cracks from which dust and chips come; empty unless `debris` is on.
    pub fn debris(&self) -> impl ExactSizeIterator<Item = DebrisPoint> {
        self.raw_view().debris.iter().map(DebrisPoint::from)
    }

    /// Whether the object stayed whole: below its threshold, or the request asked for the threshold alone.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.raw_view().fragments.is_empty()
    }

    /// The fragments, in the order of their ids.
    pub fn fragments(&self) -> impl ExactSizeIterator<Item = Fragment<'_>> {
        fragments(self.raw_view())
    }

    /// The fragment of that id, if there is one.
    #[must_use]
    pub fn fragment(&self, id: u32) -> Option<Fragment<'_>> {
        fragment(self.raw_view(), id)
    }

    /// Vertices of all fragments one after another, m, each relative to the center of its fragment.
    #[must_use]
    pub fn positions(&self) -> &[[f32; 3]] {
        self.raw_view().positions
    }

    /// From sending the request to finding the result.
    #[must_use]
    pub fn round_trip(&self) -> Duration {
        self.round_trip
    }

    /// Size of the result, bytes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.loan.user_header().used_bytes
    }

    /// Addresses of the result in this process: where shared memory is mapped.
    #[must_use]
    pub fn address_range(&self) -> std::ops::Range<usize> {
        let payload = self.loan.payload();
        let start = payload.as_ptr() as usize;
        start..start + payload.len() * BLOCK_BYTES
    }
}
