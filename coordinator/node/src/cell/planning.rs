//! Planning of a cell on a thread of its own.
//!
//! ```text
//!   cell's thread ── PlanningRequest (a copy) ──▶ planner: Scheduler::plan, as long as that takes
//!                 ◀── number, Schedule ──────────
//! ```
//!
//! The cell's thread never waits for the planner: each way has room for the one request that is under way. A planner that is
//! slow is what [`ScheduleFollower`] is made for. One that ends, by a panic, is logged; the rules decide until another is
//! begun, [`RESTART_AFTER`] the last, with a copy of that moment.

use std::sync::mpsc::{self, Receiver, SyncSender};
use std::time::Duration;

use linewright_coordinator_cell::schedule::{PlanningRequest, Schedule, ScheduleFollower, Scheduler, WITHIN};
use linewright_coordinator_cell::{Coordination, Dispatcher, PlayerState};
use linewright_line::Tick;
use tokio::sync::mpsc as news;

/// Least time between the beginnings of two planners. One that panics at a cell as it is does so again.
pub const RESTART_AFTER: Duration = Duration::from_secs(60);

/// Makes the scheduler of a planner.
type NewScheduler = Box<dyn Fn() -> Box<dyn Scheduler + Send> + Send>;

/// A follower of schedules, and its planner.
pub struct CellPlanning {
    follower: ScheduleFollower,
    planner: Option<Planner>,
    /// Another planner is not begun before.
    begin_due: Tick,
    new_scheduler: NewScheduler,
    /// The rules alone decide, as was logged.
    is_overdue: bool,
}

/// The way to the thread of a planner, and back.
struct Planner {
    requests: SyncSender<PlanningRequest>,
    schedules: news::Receiver<(u64, Schedule)>,
}

/// A schedule that has come from a planner; none if that has ended.
#[derive(Debug)]
pub struct PlannerNews(Option<(u64, Schedule)>);

impl CellPlanning {
    /// The follower is one that is planned for beside its decisions.
    pub fn new(
        follower: ScheduleFollower,
        new_scheduler: impl Fn() -> Box<dyn Scheduler + Send> + Send + 'static,
    ) -> Self {
        let new_scheduler = Box::new(new_scheduler);
        CellPlanning { follower, planner: None, begin_due: Tick::ZERO, new_scheduler, is_overdue: false }
    }

    /// The follower, as it is now.
    pub fn follower(&self) -> &ScheduleFollower {
        &self.follower
    }

    /// The dispatcher of a step. It waits for no planner.
    pub fn dispatcher(&mut self) -> &mut dyn Dispatcher {
        &mut self.follower
    }

    /// Passes a request to the planner, if one is due. After a step, when its orders are sent: a copy of the cell takes its time.
    pub fn request(&mut self, now: Tick, state: &PlayerState) {
        let is_overdue = self.follower.is_overdue(now);
        if is_overdue && !self.is_overdue {
            tracing::warn!(
                "no schedule within {} s; dispatching rules alone decide until one is made",
                WITHIN.as_secs_f64()
            );
        }
        self.is_overdue = is_overdue;
        if self.planner.is_none() && now < self.begin_due {
            return;
        }
        let Some(request) = self.follower.take_request(now, state) else { return };
        if self.planner.is_none() {
            self.begin_due = now + RESTART_AFTER;
            match begin((self.new_scheduler)()) {
                Ok(planner) => self.planner = Some(planner),
                Err(error) => return self.lost(&format!("no thread for it: {error}")),
            }
        }
        let is_passed = self.planner.as_ref().is_some_and(|planner| planner.requests.try_send(request).is_ok());
        if !is_passed {
            self.lost("it has ended");
        }
    }

    /// Waits for the planner. May be given up and called again.
    pub async fn news(&mut self) -> PlannerNews {
        match &mut self.planner {
            Some(planner) => PlannerNews(planner.schedules.recv().await),
            None => std::future::pending().await,
        }
    }

    /// Takes what has come from the planner. The next step puts the question to the follower again.
    pub fn take(&mut self, now: Tick, news: PlannerNews, coordination: &mut Coordination) {
        match news.0 {
            Some((number, schedule)) => {
                if self.follower.take_schedule(now, number, schedule) {
                    coordination.reconsider();
                }
            }
            None => self.lost("it has ended"),
        }
    }

    fn lost(&mut self, why: &str) {
        self.planner = None;
        self.follower.planner_lost();
        tracing::error!(
            "planner of the cell: {why}; dispatching rules alone decide, and it is started again within {} s; report the \
             panic in this log, if there is one",
            RESTART_AFTER.as_secs()
        );
    }
}

/// A planner on a thread of its own, at the priority of the process. It ends when nothing more is requested.
fn begin(scheduler: Box<dyn Scheduler + Send>) -> std::io::Result<Planner> {
    let (requests, requested) = mpsc::sync_channel(1);
    let (schedule, schedules) = news::channel(1);
    std::thread::Builder::new().name("planner".to_owned()).spawn(move || plan(scheduler, &requested, &schedule))?;
    Ok(Planner { requests, schedules })
}

fn plan(
    mut scheduler: Box<dyn Scheduler + Send>,
    requested: &Receiver<PlanningRequest>,
    schedules: &news::Sender<(u64, Schedule)>,
) {
    while let Ok(request) = requested.recv() {
        let schedule = request.plan(&mut *scheduler);
        if schedules.blocking_send((request.number(), schedule)).is_err() {
            return;
        }
    }
}
