//! Peers that send garbage, write to what they have sent, or speak another version: each is refused by the rule that it breaks, or served
//! if the bytes are valid. No other client is affected.

mod support;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use shatter_client::{Client, Contact, ContactPartner, DegreeRule, ErrorKind, Impact};
use shatter_proto::PROTOCOL_VERSION;
use shatter_proto::name::OBJECT_NAME_MAX;
use shatter_proto::request::{Request, RequestWire};
use std::collections::BTreeMap;
use support::{InProcess, RawPeer, TestDirectory, timeout};

/// Requests under way at a time.
const BATCH: u64 = 32;

/// Words that do harm if they are trusted: zeros, ones, signs, infinities, not-a-numbers, lengths, large counts.
const WORDS: [u64; 12] = [
    0,
    1,
    u64::MAX,
    1 << 63,
    0x7ff0_0000_0000_0000,
    0xfff0_0000_0000_0000,
    0x7ff8_0000_0000_0001,
    0x3ff0_0000_0000_0000,
    64,
    65,
    0x0000_0040_0000_0040,
    0x7fff_ffff,
];

fn start() -> InProcess {
    let here = TestDirectory::new("garbage");
    here.database("vase", "tetra");
    InProcess::start(here, "[times]\ntick_ms = 1")
}

fn good(sequence: u64) -> RequestWire {
    let contact = Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0]);
    let partner = ContactPartner::new(sequence, 0.5, 3.0).rotating([0.1; 3], [1e-3, 1e-3, 1e-3, 0.0, 0.0, 0.0]);
    let contact = if sequence.is_multiple_of(2) { contact.partner(partner) } else { contact };
    let strike = Request {
        object: "vase".to_owned(),
        contacts: vec![contact],
        degree: DegreeRule::Sites(3),
        ..Request::default()
    };
    RequestWire { sequence, ..Request { seed: sequence / 3, ..strike }.wire([7; 16]).unwrap() }
}

/// A valid request with one to four words or bytes changed.
fn mutant(random: &mut ChaCha8Rng, sequence: u64) -> RequestWire {
    let mut wire = good(sequence);
    let bytes = bytemuck::bytes_of_mut(&mut wire);
    for _ in 0..=random.next_u32() % 4 {
        let at = random.next_u32() as usize % bytes.len();
        match random.next_u32() % 3 {
            0 => bytes[at] = random.next_u32() as u8,
            1 => bytes[at] ^= 1 << (random.next_u32() % 8),
            _ => {
                let word = at / 8 * 8;
                let value = WORDS[random.next_u32() as usize % WORDS.len()];
                bytes[word..word + 8].copy_from_slice(&value.to_le_bytes());
            }
        }
    }
    wire
}

/// Sends mutants; each must end as the rules demand for its bytes. Returns the outcomes.
fn check(count: u64) -> BTreeMap<&'static str, u64> {
    let daemon = start();
    let peer = RawPeer::open(&daemon.here.place);
    let mut random = ChaCha8Rng::seed_from_u64(count);
    let mut ends: BTreeMap<&'static str, u64> = BTreeMap::new();
    for batch in 0..count / BATCH {
        // Spread, so that no changed bit turns one into another.
        let spread = |number: u64| number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let numbers = (1..=BATCH).map(|i| spread(batch * BATCH + i));
        let mutants = numbers.map(|number| (number, mutant(&mut random, number)));
        let sent: Vec<_> = mutants.map(|(number, wire)| (number, wire, peer.send(wire))).collect();
        for (number, wire, sent) in sent {
            let found = peer.outcome(&sent);
            let name = match (wire.validate(), &found) {
                (Ok(strike), Ok(summary)) => {
                    assert_eq!((summary.seed, summary.object()), (strike.seed, strike.object.clone()), "misread");
                    if let DegreeRule::Sites(sites) = strike.degree {
                        assert!(summary.sites == sites || summary.sites == 0, "{strike:?}: {}", summary.sites);
                    }
                    "completed"
                }
                (Err(error), Err(Some(kind))) => {
                    // Requests with the same number share an error.
                    assert!(error.kind == *kind || wire.sequence != number, "{error}, but {kind:?}");
                    kind.name()
                }
                (Ok(Request { from: Some(_), .. }), Err(Some(ErrorKind::UnknownHandle))) => {
                    ErrorKind::UnknownHandle.name()
                }
                (Ok(_), Err(Some(kind))) => {
                    let later = [
                        ErrorKind::UnknownObject,
                        ErrorKind::Late,
                        ErrorKind::Busy,
                        ErrorKind::CapExceeded,
                        ErrorKind::ResultTooLarge,
                    ];
                    assert!(later.contains(kind), "{kind:?}");
                    kind.name()
                }
                (meant, found) => panic!("{meant:?}, but {found:?}"),
            };
            *ends.entry(name).or_default() += 1;
        }
    }
    // The toy engine has no cap on its sites.
    serves(&daemon, ends.get(ErrorKind::ResultTooLarge.name()).copied().unwrap_or(0));
    ends
}

/// Checks that the daemon still serves others correctly, and that at most `failed` requests failed in it.
fn serves(daemon: &InProcess, failed: u64) {
    let service: Client = daemon.connect();
    let vase = service.object("vase", timeout()).unwrap();
    let impact = Impact::new([Contact::new([0.0, 0.1, 0.0]).impulse([-1.0, 0.0, 0.0])]).degree(DegreeRule::Sites(5));
    assert_eq!(vase.strike(&impact).unwrap().wait(timeout()).unwrap().fragments().len(), 5);
    assert_eq!(service.status(timeout()).unwrap().failed, failed);
}

#[test]
fn mutated_requests_end_as_the_rules_say() {
    let ends = check(20_000);
    println!("20000 mutated requests: {ends:?}");
    assert!(ends["completed"] > 100 && ends.len() > 8, "{ends:?}");
}

/// The long run: `cargo test --release --workspace --test malformed_requests -- --ignored --nocapture`.
#[test]
#[ignore = "minutes"]
fn a_million_mutated_requests_end_as_the_rules_say() {
    println!("1000000 mutated requests: {:?}", check(1_000_000));
}

#[test]
fn writes_to_a_sent_request_do_not_affect_other_clients() {
    let daemon = start();
    let peer = RawPeer::open(&daemon.here.place);
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut completed = 0;
    for round in 0..400 {
        let sent: Vec<_> = (0..8).map(|i| peer.send(good(1 + round * 8 + i))).collect();
        for sent in &sent {
            let own = std::ptr::from_ref(sent.payload()).cast_mut().cast::<u8>();
            for _ in 0..32 {
                let at = random.next_u32() as usize % size_of::<RequestWire>();
                // SAFETY: the request's own memory, writable and mapped while `sent` lives. The test is that the daemon reads it meanwhile.
                unsafe { own.add(at).write_volatile(random.next_u32() as u8) };
            }
        }
        completed += sent.iter().filter(|sent| peer.end(sent).is_some()).count();
    }
    println!("{completed} of 3200 scribbled requests were copied before, or stayed good");
    serves(&daemon, 0);
}

#[test]
fn peers_of_another_version_get_an_error() {
    let daemon = start();
    let peer = RawPeer::open(&daemon.here.place);
    let check = |wire: RequestWire, kind| assert_eq!(peer.outcome(&peer.send(wire)).unwrap_err(), Some(kind));
    check(RequestWire { version: PROTOCOL_VERSION + 1, ..good(1) }, ErrorKind::VersionMismatch);
    check(RequestWire { magic: 7, ..good(2) }, ErrorKind::BadMagic);
    check(RequestWire { object_length: OBJECT_NAME_MAX as u32 + 1, ..good(3) }, ErrorKind::ObjectName);
    let hello = std::fs::read_to_string(daemon.here.place.hello()).unwrap();
    let protocol = |version: u32| format!("\"protocol\": {version}");
    let other = hello.replace(&protocol(PROTOCOL_VERSION), &protocol(PROTOCOL_VERSION + 7));
    assert_ne!(other, hello);
    std::fs::write(daemon.here.place.hello(), other).unwrap();
    let error = Client::connect_at(&daemon.here.place, timeout()).err().unwrap();
    assert_eq!(error.kind, ErrorKind::VersionMismatch);
    let both = [PROTOCOL_VERSION, PROTOCOL_VERSION + 7].map(|version| format!("protocol {version}"));
    assert!(both.iter().all(|version| error.message.contains(version)), "{error}");
}
