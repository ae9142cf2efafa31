//! The buses of one node as one.
//!
//! An owner's devices may hang on several. Its image is valid if each part is, and a loss on one bus lets go of the
//! outputs on all others: they were set before the loss was known.

use std::future::poll_fn;
use std::task::Poll;

use linewright_line::Owner;

use crate::{
    Answer, BusRefusal, BusRequest, BusTarget, Diagnosis, Fieldbus, InputImage, LastOrders, News, NextNews, abort,
};

/// State kept of an owner's images.
struct OwnerKnowledge {
    owner: Owner,
    /// Number of losses of validity of its image when last reported.
    reported: u32,
    /// The same when its inputs were last taken: its outputs are decided by those.
    taken: u32,
}

/// Several buses as one.
pub struct Joined {
    buses: Vec<Box<dyn Fieldbus>>,
    owners: Vec<OwnerKnowledge>,
    /// The bus polled first next time: a busy one must not keep the others waiting.
    turn: usize,
    /// Requests to devices of no bus: the last one's number, and what is not taken yet.
    unknown: u64,
    answers: Vec<(u64, Answer)>,
}

impl Joined {
    /// These buses, which carry the images of these owners.
    pub fn new(buses: Vec<Box<dyn Fieldbus>>, owners: impl IntoIterator<Item = Owner>) -> Self {
        let mut known: Vec<OwnerKnowledge> = Vec::new();
        for owner in owners {
            if !known.iter().any(|known| known.owner == owner) {
                known.push(OwnerKnowledge { owner, reported: 0, taken: 0 });
            }
        }
        Joined { buses, owners: known, turn: 0, unknown: 0, answers: Vec::new() }
    }

    /// Description of these buses.
    pub fn describe(&self) -> String {
        self.buses.iter().map(|bus| bus.describe()).collect::<Vec<_>>().join(", ")
    }

    /// Runs the buses until there is something to report; see [`Fieldbus::next`]. For ever where there is none.
    ///
    /// # Errors
    /// When one of them is gone. The node then has to end.
    pub fn next_news(&mut self) -> NextNews<'_> {
        if self.buses.len() == 1 {
            return self.buses[0].next();
        }
        Box::pin(async move {
            let mut news = self.first().await?;
            self.let_go_of_the_lost(&mut news);
            Ok(news)
        })
    }

    fn first(&mut self) -> NextNews<'_> {
        let turn = (self.turn + 1) % self.buses.len().max(1);
        self.turn = turn;
        let mut waiting: Vec<_> = self.buses.iter_mut().map(|bus| bus.next()).collect();
        waiting.rotate_left(turn);
        Box::pin(poll_fn(move |context| {
            let ready = waiting.iter_mut().find_map(|next| match next.as_mut().poll(context) {
                Poll::Ready(news) => Some(news),
                Poll::Pending => None,
            });
            ready.map_or(Poll::Pending, Poll::Ready)
        }))
    }

    /// Lets go of every output of an owner whose image has become invalid, on every bus.
    fn let_go_of_the_lost(&mut self, news: &mut Vec<News>) {
        for at in 0..self.owners.len() {
            let OwnerKnowledge { owner, reported, .. } = self.owners[at];
            let losses = self.inputs(owner).losses;
            if losses != reported {
                self.owners[at].reported = losses;
                self.set_outputs(owner, 0);
                // The image of its node has changed as well, whichever bus reported it.
                let changed = News::InputsChanged { owner };
                if !news.contains(&changed) {
                    news.push(changed);
                }
            }
        }
    }

    /// The inputs of `owner` now; not valid if none of its devices is here.
    pub fn inputs(&self, owner: Owner) -> InputImage {
        let images = self.buses.iter().filter_map(|bus| bus.inputs(owner));
        images.reduce(InputImage::joined).unwrap_or(InputImage::NEVER)
    }

    /// The inputs of `owner` now, by which its outputs are decided from here on.
    pub fn take_inputs(&mut self, owner: Owner) -> InputImage {
        let image = self.inputs(owner);
        if let Some(known) = self.owners.iter_mut().find(|known| known.owner == owner) {
            known.taken = image.losses;
        }
        image
    }

    /// Sets the output image of `owner`; see [`Fieldbus::set_outputs`]. Everything is off instead where a device was
    /// lost after [`Joined::take_inputs`]: the image was decided before the loss was known.
    pub fn set_outputs(&mut self, owner: Owner, image: u128) {
        let image = if self.is_overtaken(owner) { 0 } else { image };
        self.buses.iter_mut().for_each(|bus| bus.set_outputs(owner, image));
    }

    /// Whether a device was lost after `take_inputs`.
    fn is_overtaken(&self, owner: Owner) -> bool {
        let losses = self.inputs(owner).losses;
        self.owners.iter().any(|known| known.owner == owner && known.taken != losses)
    }

    /// Lets go of every output, for an orderly end.
    pub fn release_outputs(&mut self) {
        self.buses.iter_mut().for_each(|bus| bus.release_outputs());
    }

    /// Frames that let go of outputs when these buses get no turn any more.
    pub fn last_orders(&self) -> LastOrders {
        let all: Vec<LastOrders> = self.buses.iter().map(|bus| bus.last_orders()).collect();
        Box::new(move || all.iter().for_each(|last| last()))
    }

    /// Why the inputs of `owner` are invalid.
    pub fn trouble(&self, owner: Owner) -> Vec<String> {
        self.buses.iter().flat_map(|bus| bus.trouble(owner)).collect()
    }

    pub fn diagnoses(&self) -> Vec<Diagnosis> {
        self.buses.iter().flat_map(|bus| bus.diagnoses()).collect()
    }

    /// The name of each device that has a state, and that state.
    pub fn states(&self, take: &mut dyn FnMut(&str, &'static str)) {
        self.buses.iter().for_each(|bus| bus.states(take));
    }

    pub fn ask(&mut self, target: &BusTarget, request: BusRequest) -> u64 {
        let count = self.buses.len() as u64 + 1;
        for (at, bus) in (0..).zip(&mut self.buses) {
            if let Some(number) = bus.ask(target, request) {
                return number * count + at;
            }
        }
        self.unknown += 1;
        let number = self.unknown * count + count - 1;
        let text = match target {
            BusTarget::Node(node) => format!("{target}, {request}: no device of this bus has node id {node:02X}h"),
            BusTarget::Device(_) => format!("{target}, {request}: there is no such device on this bus"),
        };
        self.answers.push((number, Err(BusRefusal { text, code: abort::NO_CONNECTION })));
        number
    }

    /// Results of requests since the last call.
    pub fn take_answers(&mut self) -> Vec<(u64, Answer)> {
        let count = self.buses.len() as u64 + 1;
        let mut answers = std::mem::take(&mut self.answers);
        for (at, bus) in (0..).zip(&mut self.buses) {
            answers.extend(bus.take_answers().into_iter().map(|(number, answer)| (number * count + at, answer)));
        }
        answers
    }
}
