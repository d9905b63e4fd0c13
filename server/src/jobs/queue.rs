//! Queue of waiting requests.
//!
//! The request with the earliest deadline starts first. Requests with the same deadline, or without one, start first come first
//! served. A request beyond its client's share starts when that share allows.
//!
//! Deadlines: C. L. Liu & J. W. Layland, *Scheduling algorithms for multiprogramming in a hard real-time environment* (1973).
//! Virtual time and shares: A. Demers, S. Keshav & S. Shenker, *Analysis and simulation of a fair queueing algorithm* (1989).
//! Admission: A. K. Choudhury & E. L. Hahne, *Dynamic queue length thresholds for shared-memory packet switches* (1998). A client
//! may occupy at most twice as many slots as are free. So there is always a slot for the next client, and no waiting request is
//! evicted.
//!
//! Unlike in these sources, a client may be a few requests ahead of its share before others go first. Strict shares also reorder
//! random bursts of equal clients, and the slowest results then take a third longer than with first come first served.

use std::collections::HashMap;
use std::time::{Duration, Instant};

/// Identifies a client: its listener.
pub type ClientId = [u8; 16];

/// Scheduling data of a waiting request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueueKey {
    /// Client that sent it.
    pub client: ClientId,
    /// Time after which the result is of no use.
    pub deadline: Option<Instant>,
    /// Expected computing time.
    pub cost: Duration,
}

/// Bounded queue.
pub struct Queue<T> {
    waiting: Vec<QueuedJob<T>>,
    accounts: HashMap<ClientId, ClientAccount>,
    /// Virtual time, s: computing time that each active client has received since the queue was idle.
    now: f64,
    /// Wall-clock time at which `now` was computed.
    at: Instant,
    most: usize,
    servers: f64,
    ahead: f64,
    count: u64,
}

/// Waiting request.
struct QueuedJob<T> {
    key: QueueKey,
    /// Virtual time at which it may begin.
    start: f64,
    /// Sequence number by arrival.
    number: u64,
    item: T,
}

/// Account of a client. It is dropped once none of the client's requests waits or computes and virtual time has passed `end`.
#[derive(Clone, Copy, Default)]
struct ClientAccount {
    /// Virtual time at which all of the client's requests would be done within its share.
    end: f64,
    /// Virtual time at which its last request may begin; the next one begins no earlier, whatever the costs of both.
    start: f64,
    /// Number of its requests that wait or compute.
    open: usize,
}

/// A client may occupy this many times the free places of the queue: a single client two thirds of the queue, eight clients two
/// seventeenths each.
const SHARE: usize = 2;

impl<T> Queue<T> {
    /// Creates a queue of at most `most` requests for `servers` workers. A client may be ahead of its share by `ahead` of its requests.
    pub fn new(most: usize, servers: usize, ahead: f64) -> Self {
        let (waiting, accounts, at) = (Vec::new(), HashMap::new(), Instant::now());
        Self { waiting, accounts, now: 0.0, at, most, servers: servers.max(1) as f64, ahead, count: 0 }
    }

    /// Advances virtual time to `at`. The workers are shared by all clients that are active or ahead of their share. Accounts behind
    /// virtual time are dropped: their clients would begin at the current virtual time anyway.
    fn advance(&mut self, at: Instant) {
        let active = self.accounts.len().max(1) as f64;
        self.now += at.saturating_duration_since(self.at).as_secs_f64() * self.servers / active;
        self.at = at;
        self.accounts.retain(|_, account| account.open > 0 || account.end > self.now);
    }

    /// Number of waiting requests.
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// All waiting requests.
    pub fn items(&self) -> impl Iterator<Item = &T> {
        self.waiting.iter().map(|waiting| &waiting.item)
    }

    /// Earliest deadline of the waiting requests.
    pub fn next_deadline(&self) -> Option<Instant> {
        self.waiting.iter().filter_map(|waiting| waiting.key.deadline).min()
    }

    /// Expected computing time of the requests that go before a new one with this deadline.
    pub fn ahead(&self, deadline: Option<Instant>) -> Duration {
        let late = |deadline: Option<Instant>| (deadline.is_none(), deadline);
        let places = self.waiting.iter().map(|waiting| waiting.key);
        places.filter(|key| late(key.deadline) <= late(deadline)).map(|key| key.cost).sum()
    }

    /// Whether the queue is full.
    pub fn is_full(&self) -> bool {
        self.waiting.len() >= self.most
    }

    /// Number of waiting requests of this client.
    pub fn held(&self, client: &ClientId) -> usize {
        self.waiting.iter().filter(|waiting| waiting.key.client == *client).count()
    }

    /// Adds `item` at this moment; returns it if the queue is full or its client has used its share of the places.
    ///
    /// # Errors
    /// `item`, if the queue is full or the client has its share of it.
    pub fn push(&mut self, at: Instant, key: QueueKey, item: T) -> Result<(), T> {
        self.advance(at);
        if self.held(&key.client) >= SHARE * self.most.saturating_sub(self.waiting.len()) {
            return Err(item);
        }
        let cost = key.cost.as_secs_f64();
        let account = self.accounts.entry(key.client).or_default();
        let ahead = (account.end - self.now).max(0.0);
        account.end = self.now + ahead + cost;
        account.open += 1;
        self.count += 1;
        let start = (self.now + (ahead - self.ahead * cost).max(0.0)).max(account.start);
        account.start = start;
        self.waiting.push(QueuedJob { key, start, number: self.count, item });
        Ok(())
    }

    /// Removes the most urgent request of the clients that `may` admits.
    pub fn pop(&mut self, may: impl Fn(&ClientId) -> bool) -> Option<(QueueKey, T)> {
        let before = |&a: &usize, &b: &usize| {
            let (a, b) = (&self.waiting[a], &self.waiting[b]);
            let late = |key: &QueueKey| (key.deadline.is_none(), key.deadline);
            let by_deadline = late(&a.key).cmp(&late(&b.key));
            by_deadline.then(a.start.total_cmp(&b.start)).then(a.number.cmp(&b.number))
        };
        let best = (0..self.waiting.len()).filter(|&index| may(&self.waiting[index].key.client)).min_by(before)?;
        let QueuedJob { key, item, .. } = self.waiting.swap_remove(best);
        Some((key, item))
    }

    /// Records that a popped request has computed for `time` and is done at this moment.
    pub fn completed(&mut self, at: Instant, key: &QueueKey, time: Duration) {
        self.advance(at);
        if let Some(account) = self.accounts.get_mut(&key.client) {
            account.end += time.as_secs_f64() - key.cost.as_secs_f64();
        }
        self.close(&key.client);
    }

    /// Removes all requests that `which` selects.
    pub fn take(&mut self, which: impl Fn(&QueueKey, &T) -> bool) -> Vec<T> {
        let mut taken = Vec::new();
        for index in (0..self.waiting.len()).rev() {
            if which(&self.waiting[index].key, &self.waiting[index].item) {
                taken.push(self.remove(index));
            }
        }
        taken
    }

    /// Removes a request that never computed; its client's account becomes what it would be without it.
    fn remove(&mut self, index: usize) -> T {
        let QueuedJob { key, item, .. } = self.waiting.swap_remove(index);
        if let Some(account) = self.accounts.get_mut(&key.client) {
            let own = self.waiting.iter().filter(|waiting| waiting.key.client == key.client);
            account.start = own.map(|waiting| waiting.start).fold(0.0, f64::max);
            account.end -= key.cost.as_secs_f64();
        }
        self.close(&key.client);
        item
    }

    /// Records that one request of `client` fewer waits or computes. When none is left at all, all accounts start again.
    fn close(&mut self, client: &ClientId) {
        if let Some(account) = self.accounts.get_mut(client) {
            account.open -= 1;
        }
        if self.accounts.values().all(|account| account.open == 0) {
            self.accounts.clear();
            self.now = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    fn key(client: u8, deadline: Option<Instant>) -> QueueKey {
        QueueKey { client: [client; 16], deadline, cost: 10 * MS }
    }

    /// Queue of strict shares for one worker, and the time at which everything happens.
    fn strict<T>(most: usize) -> (Queue<T>, Instant) {
        let queue = Queue::new(most, 1, 0.0);
        let at = queue.at;
        (queue, at)
    }

    fn order<T>(queue: &mut Queue<T>) -> Vec<T> {
        std::iter::from_fn(|| queue.pop(|_| true)).map(|(_, item)| item).collect()
    }

    #[test]
    fn the_earliest_deadline_goes_first_and_none_last() {
        let (mut queue, now) = strict(9);
        for (name, deadline) in [("never", None), ("third", Some(30)), ("first", Some(10)), ("second", Some(20))] {
            assert_eq!(queue.push(now, key(1, deadline.map(|ms| now + ms * MS)), name), Ok(()));
        }
        assert_eq!(queue.next_deadline(), Some(now + 10 * MS));
        assert_eq!(queue.ahead(Some(now + 25 * MS)), 20 * MS);
        assert_eq!((queue.ahead(None), queue.ahead(Some(now))), (40 * MS, Duration::ZERO));
        assert_eq!(order(&mut queue), ["first", "second", "third", "never"]);
    }

    #[test]
    fn clients_take_turns_however_much_one_asks() {
        let (mut queue, now) = strict(99);
        (0..6).for_each(|n| _ = queue.push(now, key(1, None), format!("greedy {n}")));
        (0..2).for_each(|n| _ = queue.push(now, key(2, None), format!("modest {n}")));
        let found = order(&mut queue);
        assert_eq!(found[..4], ["greedy 0", "modest 0", "greedy 1", "modest 1"], "{found:?}");
        assert_eq!(found[4..].len(), 4);
    }

    #[test]
    fn a_few_ahead_of_the_share_are_served_as_they_come_and_more_are_not() {
        let now = Instant::now();
        let mut queue = Queue::new(99, 1, 4.0);
        (0..12).for_each(|n| _ = queue.push(now, key(1, None), n));
        (100..102).for_each(|n| _ = queue.push(now, key(2, None), n));
        assert_eq!(order(&mut queue), [0, 1, 2, 3, 4, 100, 101, 5, 6, 7, 8, 9, 10, 11]);
        // First come first served holds as long as no client is more than four requests ahead, whatever the order of senders.
        let mut queue = Queue::new(99, 1, 4.0);
        let senders = [1, 1, 2, 1, 2, 2, 1, 1];
        for (n, client) in senders.into_iter().enumerate() {
            queue.push(now + 8 * n as u32 * MS, key(client, None), n).unwrap();
        }
        assert_eq!(order(&mut queue), [0, 1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn those_of_one_client_keep_their_order_whatever_they_cost() {
        let now = Instant::now();
        let mut queue = Queue::new(99, 2, 4.0);
        let costs = [10, 10, 10, 1, 40, 1, 10, 1, 1, 30];
        (0..3).for_each(|n| _ = queue.push(now, key(2, None), 100 + n));
        for (n, cost) in costs.into_iter().enumerate() {
            queue.push(now, QueueKey { cost: cost * MS, ..key(1, None) }, n).unwrap();
            if n == 4 {
                let (key, _) = queue.pop(|client| *client == [2; 16]).unwrap();
                queue.completed(now, &key, MS);
            }
        }
        let found: Vec<usize> = order(&mut queue).into_iter().filter(|n| *n < 100).collect();
        assert_eq!(found, (0..costs.len()).collect::<Vec<_>>());
    }

    #[test]
    fn a_share_is_computing_time_and_not_a_number_of_strikes() {
        let (mut queue, now) = strict(99);
        for round in 0..8 {
            queue.push(now, QueueKey { cost: 30 * MS, ..key(1, None) }, ("long", round)).unwrap();
            queue.push(now, key(2, None), ("short", round)).unwrap();
        }
        let first = &order(&mut queue)[..8];
        assert_eq!(first.iter().filter(|(name, _)| *name == "long").count(), 2, "{first:?}");
    }

    #[test]
    fn a_newcomer_is_neither_favored_nor_made_to_wait_for_the_past() {
        let (mut queue, mut now) = strict(99);
        (0..40).for_each(|n| _ = queue.push(now, key(1, None), n));
        (0..20).for_each(|_| {
            let (key, _) = queue.pop(|_| true).unwrap();
            now += 10 * MS;
            queue.completed(now, &key, 10 * MS);
        });
        (0..4).for_each(|n| _ = queue.push(now, key(2, None), 100 + n));
        let next: Vec<i32> = (0..6).map(|_| queue.pop(|_| true).unwrap().1).collect();
        assert_eq!(next.iter().filter(|n| **n >= 100).count(), 3, "{next:?}");
    }

    /// Each client sends its next request when the previous one is done; two compute at once, for random times.
    #[test]
    fn clients_that_wait_for_their_results_are_served_alike() {
        let mut queue = Queue::new(99, 2, 4.0);
        let (mut random, mut now) = (draws(), queue.at);
        let mut served = [0u32; 8];
        (0..8).for_each(|client| _ = queue.push(now, key(client, None), client));
        let mut running = Vec::new();
        for _ in 0..4000 {
            while running.len() < 2
                && let Some(next) = queue.pop(|_| true)
            {
                running.push(next);
            }
            let (key, client) = running.swap_remove(random() as usize % running.len());
            let time = MS * (4 + random() as u32 % 12);
            now += time / 2;
            queue.completed(now, &key, time);
            served[client as usize] += 1;
            queue.push(now, QueueKey { cost: MS * (8 + random() as u32 % 4), ..key }, client).unwrap();
        }
        let (least, most) = (served.iter().min().unwrap(), served.iter().max().unwrap());
        assert!(f64::from(*least) > 0.95 * f64::from(*most), "{served:?}");
    }

    /// Pseudo-random numbers (Marsaglia's xorshift, 2003).
    fn draws() -> impl FnMut() -> u64 {
        let mut state = 88_172_645_463_325_252u64;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state >> 11
        }
    }

    /// Sends as many requests as the queue accepts.
    fn fill(queue: &mut Queue<u32>, at: Instant, client: u8) -> usize {
        while queue.push(at, key(client, None), 0).is_ok() {}
        queue.held(&[client; 16])
    }

    #[test]
    fn a_full_queue_reserves_slots_for_new_clients() {
        let (mut queue, now) = strict(99);
        assert_eq!((fill(&mut queue, now, 1), queue.len()), (66, 66), "a single client has two thirds");
        assert_eq!((fill(&mut queue, now, 2), queue.len()), (22, 88), "the second has two thirds of the rest");
        for client in 3..=5 {
            assert!(fill(&mut queue, now, client) > 0, "{client}: {} wait", queue.len());
        }
        assert_eq!(fill(&mut queue, now, 1), 66, "no waiting request is evicted");
    }

    #[test]
    fn the_queue_accepts_up_to_its_limit() {
        for most in 0..9 {
            let (mut queue, now) = strict(most);
            let taken: usize = (1..=9).map(|client| fill(&mut queue, now, client)).sum();
            assert_eq!((taken, queue.len(), queue.is_full()), (most, most, true));
        }
    }

    #[test]
    fn equals_that_keep_sending_have_equal_shares() {
        let (mut queue, now) = strict(99);
        for round in 0..2000 {
            (0..8).for_each(|client| _ = queue.push(now, key((client + round) as u8 % 8, None), 0));
            queue.pop(|_| true).unwrap();
        }
        let held: Vec<usize> = (0..8).map(|client| queue.held(&[client; 16])).collect();
        assert!(held.iter().all(|held| (10..=13).contains(held)), "{held:?}");
    }

    #[test]
    fn a_client_that_may_not_is_passed_over() {
        let (mut queue, now) = strict(9);
        (0..2).for_each(|n| _ = queue.push(now, key(1, None), n));
        queue.push(now, key(2, None), 10).unwrap();
        let other = |client: &ClientId| *client != [1; 16];
        assert_eq!(queue.pop(other).unwrap().1, 10);
        assert_eq!((queue.pop(other), queue.len()), (None, 2));
        assert_eq!(order(&mut queue), [0, 1]);
    }

    #[test]
    fn removed_requests_do_not_count_for_the_share() {
        let (mut queue, now) = strict(9);
        (0..6).for_each(|n| _ = queue.push(now, key(1 + (n % 2) as u8, Some(now + n * MS)), n));
        let mut late = queue.take(|key, _| key.deadline <= Some(now + 2 * MS));
        late.sort_unstable();
        assert_eq!((late, queue.len()), (vec![0, 1, 2], 3));
        assert_eq!(order(&mut queue), [3, 4, 5]);
    }

    #[test]
    fn withdrawn_requests_do_not_change_the_share() {
        let (mut queue, now) = strict(99);
        (0..30).for_each(|n| _ = queue.push(now, key(1, None), n));
        assert_eq!(queue.pop(|_| true).unwrap().1, 0);
        assert_eq!(queue.take(|_, n| *n > 0).len(), 29);
        (100..103).for_each(|n| _ = queue.push(now, key(2, None), n));
        queue.push(now, key(1, None), 1).unwrap();
        let key = order(&mut queue).iter().position(|n| *n == 1).unwrap();
        assert!(key <= 1, "{key}");
    }

    #[test]
    fn idle_clients_are_forgotten() {
        let (mut queue, mut now) = strict(9);
        // One client stays; two hundred come and go.
        queue.push(now, key(255, None), 255).unwrap();
        for client in 0..200 {
            queue.push(now, key(client, None), client).unwrap();
            let (key, _) = queue.pop(|other| *other != [255; 16]).unwrap();
            now += 40 * MS;
            queue.completed(now, &key, MS);
        }
        assert!(queue.accounts.len() < 4, "{}", queue.accounts.len());
        let (key, _) = queue.pop(|_| true).unwrap();
        queue.completed(now, &key, MS);
        assert!(queue.accounts.is_empty());
    }
}
