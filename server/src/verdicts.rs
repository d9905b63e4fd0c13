//! Why strikes were closed without an answer, kept until their clients ask.

use shatter_proto::refusal::RefusalWire;
use shatter_proto::transport::{CLIENTS_MAX, STRIKES_PER_CLIENT_MAX};
use std::collections::{HashMap, VecDeque};

/// As many as all clients together can have under way; beyond that the oldest are forgotten.
const KEPT: usize = CLIENTS_MAX * STRIKES_PER_CLIENT_MAX;

/// A strike: the listener of its client, and its sequence.
pub type Key = ([u8; 16], u64);

/// The verdicts kept.
#[derive(Default)]
pub struct Verdicts {
    by_strike: HashMap<Key, RefusalWire>,
    order: VecDeque<Key>,
}

impl Verdicts {
    /// Keeps the verdict on a strike.
    pub fn keep(&mut self, strike: Key, verdict: RefusalWire) {
        if self.by_strike.insert(strike, verdict).is_some() {
            // A client that uses a sequence again: the new verdict is as young as any.
            self.order.retain(|other| *other != strike);
        }
        self.order.push_back(strike);
        while self.order.len() > KEPT {
            if let Some(oldest) = self.order.pop_front() {
                self.by_strike.remove(&oldest);
            }
        }
    }

    /// The verdict on a strike, if it is known.
    pub fn get(&self, strike: Key) -> Option<RefusalWire> {
        self.by_strike.get(&strike).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shatter_proto::{Kind, Refusal};

    #[test]
    fn the_oldest_verdicts_are_forgotten_first() {
        let mut verdicts = Verdicts::default();
        let verdict = |n: u64| RefusalWire::from(&Refusal::new(Kind::Busy, n.to_string(), "full"));
        for n in 0..=KEPT as u64 {
            verdicts.keep(([1; 16], n), verdict(n));
            verdicts.keep(([1; 16], n), verdict(n));
        }
        verdicts.keep(([1; 16], 1), verdict(1));
        verdicts.keep(([3; 16], 1), verdict(1));
        assert_eq!((verdicts.get(([1; 16], 0)), verdicts.get(([1; 16], 2))), (None, None));
        assert_eq!(verdicts.get(([1; 16], 1)), Some(verdict(1)));
        assert_eq!(verdicts.get(([2; 16], 1)), None);
        assert_eq!((verdicts.by_strike.len(), verdicts.order.len()), (KEPT, KEPT));
    }
}
