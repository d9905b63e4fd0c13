//! Requests in flight. Nothing here waits, but for the film of the vase: requests are sent, tickets are polled, and connections come from
//! the keeper's thread.

use super::film::Film;
use super::prototype::block;
use super::service::{DaemonSupervisor, ServiceLink, kill};
use super::tally::{Step, Tally};
use super::world::{NewPiece, Piece, World};
use shatter_client::{Deadline, Effect, Error, ErrorKind, FractureResult, Impact, Poll, Ticket};
use shatter_export::contact::MergedContact;
use std::time::{Duration, Instant};

/// Deadline of requests; later results are of no use.
const DEADLINE: Duration = Duration::from_secs(3);

/// Deadline where steps wait for results.
const WAITING_DEADLINE: Duration = Duration::from_secs(120);

/// Maximum number of requests in flight, so that a slow daemon gets no further ones.
const UNDER_WAY_MAX: usize = 12;

/// Maximum number of requests for fragments among them.
const AGAIN_MAX: usize = 3;

/// Request in flight.
struct Sent {
    piece: u32,
    ticket: Ticket,
    impact: Impact,
    at_s: f64,
    /// Process id of its daemon.
    pid: u32,
}

pub struct Strikes<'k> {
    supervisor: &'k mut DaemonSupervisor,
    /// Connection, while there is a daemon.
    line: Option<ServiceLink>,
    /// Whether a step waits for the results of its requests, so that they do not depend on the speed of the machine.
    is_waiting: bool,
    sent: Vec<Sent>,
    /// Requests for whole objects that were lost with a daemon; they are sent again.
    lost: Vec<(u32, Impact)>,
    down_s: f64,
}

impl<'k> Strikes<'k> {
    pub fn new(line: ServiceLink, supervisor: &'k mut DaemonSupervisor, is_waiting: bool) -> Self {
        Self { supervisor, line: Some(line), is_waiting, sent: Vec::new(), lost: Vec::new(), down_s: 0.0 }
    }

    /// Kills the daemon.
    pub fn kill_daemon(&self) {
        self.line.iter().for_each(|line| kill(line.pid));
    }

    /// Exchange with the service in a step: sends requests for contacts, and turns at most one result into fragments.
    pub fn turn(&mut self, world: &mut World<'_>, film: &mut Film, now_s: f64, spent: &mut Step, tally: &mut Tally) {
        let merged_contacts = world.merged_contacts(now_s);
        let (before, begun) = (tally.switches(), Instant::now());
        self.connect(now_s, tally);
        for (piece, impact) in std::mem::take(&mut self.lost) {
            self.send(world, piece, impact, now_s, tally);
        }
        for (piece, merged_contacts) in merged_contacts {
            match merged_contacts {
                Ok(merged_contacts) => self.strike(world, film, piece, &merged_contacts, now_s, tally),
                Err(lost) => {
                    *tally.refused_count.entry("impulse_lost").or_default() += 1;
                    eprintln!("rapier_host: piece {piece}: {lost}");
                }
            }
        }
        let ended = self.poll(world, now_s, tally);
        spent.client = begun.elapsed();
        let after = tally.switches();
        (spent.waits, spent.taken) = (after[0] - before[0], after[1] - before[1]);
        let begun = Instant::now();
        if let Some((piece, sent_s, result)) = ended {
            let pid = self.line.as_ref().map_or(0, |line| line.pid);
            tally.record_result(now_s - sent_s, result.round_trip(), world.pieces[piece as usize].generation, &result);
            if !result.is_whole() {
                let new_pieces = new_pieces(&result, pid);
                new_pieces.iter().for_each(|new_piece| tally.hollow(new_piece.block.hollow));
                world.shatter(piece, new_pieces, now_s, film);
            }
            spent.swap = begun.elapsed();
        }
    }

    /// Takes over the requested connection.
    fn connect(&mut self, now_s: f64, tally: &mut Tally) {
        if self.line.is_some() {
            return;
        }
        match self.supervisor.line() {
            Some(Ok(line)) => {
                tally.paused_s.push(now_s - self.down_s);
                self.line = Some(line);
            }
            Some(Err(_)) => self.supervisor.want(None),
            None => {}
        }
    }

    /// Handles the loss of the daemon: fracture pauses, the simulation continues.
    fn disconnect(&mut self, now_s: f64) {
        if let Some(former) = self.line.take() {
            self.down_s = now_s;
            self.supervisor.want(Some(former));
        }
    }

    fn strike(
        &mut self,
        world: &mut World<'_>,
        film: &Film,
        piece: u32,
        merged_contacts: &[MergedContact],
        now_s: f64,
        tally: &mut Tally,
    ) {
        let own = &world.pieces[piece as usize];
        let again = |sent: &&Sent| world.pieces[sent.piece as usize].generation > 0;
        let full = own.generation > 0 && self.sent.iter().filter(again).count() >= AGAIN_MAX;
        let under_way = self.sent.iter().any(|sent| sent.piece == piece);
        if !own.alive || under_way || full || self.sent.len() >= UNDER_WAY_MAX || self.line.is_none() {
            return;
        }
        let positions = &film.actors[own.actor].shell.positions;
        let snapped: Vec<MergedContact> =
            merged_contacts.iter().map(|merged_contact| snap(merged_contact, own, positions)).collect();
        if let Some(impact) = Impact::of(&snapped) {
            let impact = impact.seed(u64::from(piece)).keep();
            let impact = impact.deadline(if self.is_waiting { WAITING_DEADLINE } else { DEADLINE });
            let impact = impact.enable(Effect::Hulls).enable(Effect::Release);
            self.send(world, piece, impact, now_s, tally);
        }
    }

    fn send(&mut self, world: &mut World<'_>, piece: u32, impact: Impact, now_s: f64, tally: &mut Tally) {
        let Some(line) = &self.line else {
            self.lost.push((piece, impact));
            return;
        };
        let own = &world.pieces[piece as usize];
        let impact = match own.origin {
            // Its result was retained by the former daemon.
            Some((pid, ..)) if pid != line.pid => return world.spare(piece),
            Some((_, handle, fragment)) => impact.from(handle, fragment),
            None => impact,
        };
        let pid = line.pid;
        match line.objects[own.prototype].strike(&impact) {
            Ok(ticket) => {
                tally.strikes += 1;
                self.sent.push(Sent { piece, ticket, impact, at_s: now_s, pid });
            }
            Err(error) => self.refused(world, (piece, impact, pid), &error, now_s, tally),
        }
    }

    /// Polls all tickets; returns the first result that is ready.
    fn poll(&mut self, world: &mut World<'_>, now_s: f64, tally: &mut Tally) -> Option<(u32, f64, FractureResult)> {
        let (mut index, mut found) = (0, None);
        while index < self.sent.len() && found.is_none() {
            let ticket = &mut self.sent[index].ticket;
            let polled = if self.is_waiting {
                ticket.wait(Deadline::after(WAITING_DEADLINE)).map(Poll::Ready)
            } else {
                ticket.poll()
            };
            match polled {
                Ok(Poll::Pending) => index += 1,
                Ok(Poll::Ready(result)) => {
                    let sent = self.sent.remove(index);
                    found = Some((sent.piece, sent.at_s, result));
                }
                // The ticket stays valid.
                Err(error) if error.kind == ErrorKind::Busy && error.at == "results" => index += 1,
                Err(error) => {
                    let sent = self.sent.remove(index);
                    self.refused(world, (sent.piece, sent.impact, sent.pid), &error, now_s, tally);
                }
            }
        }
        found
    }

    fn refused(
        &mut self,
        world: &mut World<'_>,
        (piece, impact, pid): (u32, Impact, u32),
        error: &Error,
        now_s: f64,
        tally: &mut Tally,
    ) {
        *tally.refused_count.entry(error.kind.name()).or_default() += 1;
        let whole = world.pieces[piece as usize].origin.is_none();
        match error.kind {
            ErrorKind::Lost | ErrorKind::NoDaemon => {
                // Tickets of a lost daemon may report the loss late.
                if self.line.as_ref().is_some_and(|line| line.pid == pid) {
                    self.disconnect(now_s);
                }
                // A fragment is lost with the daemon that retained it.
                if whole { self.lost.push((piece, impact)) } else { world.spare(piece) }
            }
            // The piece can be struck again at its next contact.
            kind if kind.retry() => {}
            _ if !whole => world.spare(piece),
            _ => eprintln!("rapier_host: {error}"),
        }
    }
}

/// Moves the contact to the nearest visible point: colliders are convex hulls, but the contact must be on the surface.
fn snap(merged_contact: &MergedContact, piece: &Piece, positions: &[[f32; 3]]) -> MergedContact {
    let own = [0, 1, 2].map(|k| merged_contact.point_m[k] - piece.center_m[k]);
    let away = |point: &[f32; 3]| (0..3).map(|k| (f64::from(point[k]) - own[k]).powi(2)).sum::<f64>();
    let nearest = positions.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
    let point_m = nearest.map(|point| [0, 1, 2].map(|k| f64::from(point[k]) + piece.center_m[k]));
    MergedContact { point_m: point_m.unwrap_or(merged_contact.point_m), ..*merged_contact }
}

/// Fragments, copied out of shared memory.
fn new_pieces(result: &FractureResult, pid: u32) -> Vec<NewPiece> {
    let handle = result.handle();
    let new_piece = |fragment: shatter_client::Fragment<'_>| {
        let velocity = fragment.velocity();
        NewPiece {
            block: block(&fragment),
            linear_m_s: velocity.map_or([0.0; 3], |own| own.linear_m_s),
            angular_rad_s: velocity.map_or([0.0; 3], |own| own.angular_rad_s),
            origin: handle.map(|handle| (pid, handle, fragment.id())),
        }
    };
    result.fragments().map(new_piece).collect()
}
