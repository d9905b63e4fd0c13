//! Fuzz target for messages in shared memory.

use super::{choice, seed};
use bytemuck::{AnyBitPattern, Zeroable, bytes_of};
use shatter_proto::control::{
    self, ControlReplyHeader, ControlRequest, ControlRequestWire, ObjectRow, ServiceStatusRow,
};
use shatter_proto::layout::{Layout, SectionCounts};
use shatter_proto::request::{Contact, ContactPartner, Request, RequestWire};
use shatter_proto::result::{AlignedBlock, BLOCK_BYTES, ResultHeader, StageCost, Summary};
use shatter_proto::view::CheckedLayout;
use shatter_transport::daemon_info::DaemonInfo;

const LISTENER: [u8; 16] = [7; 16];

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let contact = Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0]);
    let contact = contact.partner(ContactPartner::new(1, 0.5, 3.0));
    let strike = Request { object: "vase".to_owned(), contacts: vec![contact], ..Request::default() };
    let strike = RequestWire { sequence: 1, ..strike.wire(LISTENER).expect("a valid strike") };
    let mut payload = vec![AlignedBlock::zeroed(); control::blocks::<ObjectRow>(2)];
    let mut row = ObjectRow::zeroed();
    row.set_name("vase");
    row.set_material("glass");
    let header = control::write(&mut payload, &[row, row], 2, false);
    vec![
        seed(0, bytes_of(&strike)),
        seed(1, bytes_of(&ControlRequest::RequestError(3).wire(LISTENER))),
        seed(2, DaemonInfo::ours(7, "seed").to_json()),
        seed(3, [bytes_of(&header), bytemuck::cast_slice(&payload)].concat()),
        seed(4, result()),
    ]
}

/// Header and payload of a result with one fragment of one triangle.
fn result() -> Vec<u8> {
    let counts = SectionCounts { fragments: 1, runs: 1, vertices: 3, indices: 3, ..SectionCounts::default() };
    let layout = Layout::new(&counts).expect("small counts");
    let mut payload = vec![AlignedBlock::zeroed(); layout.blocks()];
    let sections = layout.split(&mut payload).expect("room for the layout");
    let fragment = &mut sections.fragments[0];
    (fragment.vertex_count, fragment.index_count, fragment.run_count) = (3, 3, 1);
    let run = &mut sections.runs[0];
    (run.neighbor, run.material, run.vertex_count, run.index_count) = (shatter_proto::result::OUTER, 1, 3, 3);
    sections.indices.copy_from_slice(&[0, 1, 2]);
    sections.summary.set_object("vase");
    [bytes_of(&layout.header(5)), bytemuck::cast_slice(&payload)].concat()
}

/// A `T` from the first bytes, and the rest as blocks; missing bytes are 0.
fn parts<T: AnyBitPattern>(bytes: &[u8]) -> (T, Vec<AlignedBlock>) {
    let mut head = bytes[..bytes.len().min(size_of::<T>())].to_vec();
    head.resize(size_of::<T>(), 0);
    let rest = bytes.get(size_of::<T>()..).unwrap_or_default();
    let mut blocks = vec![AlignedBlock::zeroed(); rest.len().div_ceil(BLOCK_BYTES)];
    bytemuck::cast_slice_mut(&mut blocks)[..rest.len()].copy_from_slice(rest);
    (bytemuck::pod_read_unaligned(&head), blocks)
}

pub(super) fn run(input: &[u8]) -> bool {
    let Some((kind, rest)) = choice(input, 5) else { return false };
    match kind {
        0 => strike(&parts(rest).0),
        1 => {
            let (wire, _) = parts::<ControlRequestWire>(rest);
            wire.validate().is_ok_and(|request| {
                assert_eq!(request.wire(wire.listener).validate().expect("it was understood"), request);
                true
            })
        }
        2 => std::str::from_utf8(rest)
            .is_ok_and(|json| DaemonInfo::from_json(json).is_ok_and(|hello| hello.check().is_ok())),
        3 => reply(rest),
        _ => {
            let (header, payload) = parts::<ResultHeader>(rest);
            CheckedLayout::new(&header, &payload).is_ok_and(|checked| {
                let view = checked.view(&payload).expect("a checked result has a view");
                let summary = Summary::from(view.summary);
                let names = [summary.degree_origin.name(), summary.energy_source.name(), summary.stop_criterion.name()];
                assert!(names.iter().all(|name| !name.is_empty()));
                view.stages.iter().for_each(|row| _ = StageCost::from(row));
                view.effects.iter().for_each(|row| _ = row.cost());
                true
            })
        }
    }
}

fn strike(wire: &RequestWire) -> bool {
    wire.validate().is_ok_and(|strike| {
        let again = strike.wire(wire.listener).expect("what the daemon accepts can be sent");
        assert_eq!(again.validate().expect("it was understood"), strike);
        true
    })
}

fn reply(bytes: &[u8]) -> bool {
    let (header, payload) = parts::<ControlReplyHeader>(bytes);
    let status = control::read::<ServiceStatusRow>(&header, &payload).is_ok();
    let objects = control::read::<ObjectRow>(&header, &payload).is_ok_and(|rows| {
        rows.iter().for_each(|row| _ = (row.name(), row.material(), row.error()));
        true
    });
    status || objects
}
