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

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};
    use std::task::{Context, Waker};

    use linewright_line::{StationId, Tick};

    use super::*;

    const OWNER: Owner = Owner::Station(StationId(0));

    /// Reports of a bus and orders to it, seen from outside.
    #[derive(Default)]
    struct Seen {
        news: Vec<News>,
        image: Option<InputImage>,
        outputs: Vec<u128>,
    }

    struct Bus(Arc<Mutex<Seen>>);

    impl Fieldbus for Bus {
        fn describe(&self) -> String {
            "a bus".to_owned()
        }
        fn next(&mut self) -> NextNews<'_> {
            Box::pin(poll_fn(|_| match std::mem::take(&mut self.0.lock().expect("whole").news) {
                news if news.is_empty() => Poll::Pending,
                news => Poll::Ready(Ok(news)),
            }))
        }
        fn inputs(&self, _: Owner) -> Option<InputImage> {
            self.0.lock().expect("whole").image
        }
        fn set_outputs(&mut self, _: Owner, image: u128) {
            self.0.lock().expect("whole").outputs.push(image);
        }
        fn release_outputs(&mut self) {}
        fn last_orders(&self) -> LastOrders {
            Box::new(|| {})
        }
        fn trouble(&self, _: Owner) -> Vec<String> {
            Vec::new()
        }
        fn diagnoses(&self) -> Vec<Diagnosis> {
            Vec::new()
        }
        fn states(&self, _: &mut dyn FnMut(&str, &'static str)) {}
        fn ask(&mut self, target: &BusTarget, _: BusRequest) -> Option<u64> {
            (*target == BusTarget::Node(5)).then_some(7)
        }
        fn take_answers(&mut self) -> Vec<(u64, Answer)> {
            Vec::new()
        }
    }

    type Look = Arc<Mutex<Seen>>;

    fn pair() -> (Joined, Look, Look) {
        let valid = InputImage::NEVER.followed_by(Tick::from_millis(1), 0, true, None);
        let seen = || Arc::new(Mutex::new(Seen { image: Some(valid), ..Seen::default() }));
        let (a, b) = (seen(), seen());
        (Joined::new(vec![Box::new(Bus(a.clone())), Box::new(Bus(b.clone()))], [OWNER]), a, b)
    }

    fn next(joined: &mut Joined) -> Option<Vec<News>> {
        let mut next = Box::pin(joined.next_news());
        match next.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(news) => Some(news.expect("no bus is lost")),
            Poll::Pending => None,
        }
    }

    #[test]
    fn an_image_is_valid_if_each_part_is_and_a_loss_on_one_bus_lets_go_on_the_other() {
        let (mut joined, a, b) = pair();
        assert!(next(&mut joined).is_none());
        assert!(joined.take_inputs(OWNER).valid);
        joined.set_outputs(OWNER, 3);
        {
            let mut a = a.lock().expect("whole");
            a.image = a.image.map(|image| image.followed_by(Tick::from_millis(2), 1, false, None));
            a.news.push(News::Noted("lost".to_owned()));
        }
        let news = next(&mut joined).expect("it is told");
        assert!(news.contains(&News::InputsChanged { owner: OWNER }), "{news:?}");
        assert_eq!(b.lock().expect("whole").outputs, [3, 0]);
        let image = joined.inputs(OWNER);
        assert_eq!((image.valid, image.bits, image.losses), (false, 1, 1));
    }

    /// As while a record is written: the loss is reported, and what follows the record was decided before it.
    #[test]
    fn outputs_decided_before_a_loss_stay_off_until_the_inputs_are_taken_again() {
        let (mut joined, a, b) = pair();
        joined.take_inputs(OWNER);
        {
            let mut a = a.lock().expect("whole");
            a.image = a.image.map(|image| image.followed_by(Tick::from_millis(2), 0, false, None));
            a.news.push(News::Noted("lost".to_owned()));
        }
        next(&mut joined).expect("it is told");
        joined.set_outputs(OWNER, 3);
        assert_eq!(b.lock().expect("whole").outputs, [0, 0], "neither at the loss nor after it");
        // The device is back before anything was decided anew: the loss still counts.
        {
            let mut a = a.lock().expect("whole");
            a.image = a.image.map(|image| image.followed_by(Tick::from_millis(3), 0, true, None));
        }
        joined.set_outputs(OWNER, 3);
        joined.take_inputs(OWNER);
        joined.set_outputs(OWNER, 3);
        assert_eq!(b.lock().expect("whole").outputs, [0, 0, 0, 3]);
    }

    #[test]
    fn a_busy_bus_keeps_no_other_waiting() {
        let (mut joined, a, b) = pair();
        b.lock().expect("whole").news.push(News::Noted("b".to_owned()));
        let told: Vec<News> = (0..2)
            .flat_map(|_| {
                a.lock().expect("whole").news = vec![News::Noted("a".to_owned())];
                next(&mut joined).expect("there is news")
            })
            .collect();
        assert!(told.contains(&News::Noted("b".to_owned())), "{told:?}");
    }

    #[test]
    fn a_device_of_no_bus_is_refused_by_name() {
        let (mut joined, ..) = pair();
        assert_eq!(joined.ask(&BusTarget::Node(5), BusRequest::Reset), 21);
        let number = joined.ask(&BusTarget::Node(6), BusRequest::Reset);
        let answers = joined.take_answers();
        let (told, Err(refusal)) = &answers[0] else { panic!("{answers:?}") };
        assert_eq!((*told, refusal.text.as_str()), (number, "node 06h, reset: no device of this bus has node id 06h"));
    }
}
