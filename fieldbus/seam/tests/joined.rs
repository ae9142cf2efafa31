//! Several buses as one.

use std::future::{Future, poll_fn};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, Waker};

use linewright_fieldbus_seam::{
    Answer, BusRequest, BusTarget, Diagnosis, Fieldbus, InputImage, Joined, LastOrders, News, NextNews,
};
use linewright_line::{Owner, StationId, Tick};

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
