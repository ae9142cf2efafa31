//! Requests of a page of the console to the coordinator of a cell.
//!
//! They are those of `order`, `answer`, `resource` and `why`. A command ends, and with it what it has asked; the console lives on. So a
//! request that has no reply in time is given up together with the callers that have sent it: the middleware would send it when a link
//! that was cut is there again, minutes later.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use linewright_console_view::{CellRequest, ResourceCommand};
use linewright_msgs::{SetResourceRequest, SubmitOrdersRequest, Time, WhyNotRequest};
use miette::miette;

use super::operate::{moment, usual_name};
use super::{CellCallers, CellClient, ask, change, request};

/// Time for a reply; afterwards a request is given up.
pub const REPLY_WITHIN: Duration = Duration::from_secs(2);

/// A reply to a request.
#[derive(Debug)]
pub enum CellReply {
    /// It is done; what there is to be known of it.
    Done(String),
    /// It is refused, or could not be sent; why.
    Refused(String),
    /// Nothing has come.
    None,
}

impl CellClient {
    /// Asks, and gives the reply.
    pub fn request(&self, request: CellRequest) -> impl Future<Output = CellReply> + use<> {
        let callers = self.callers.clone();
        async move {
            match tokio::time::timeout(REPLY_WITHIN, perform(&callers, request)).await {
                Ok(Ok(text)) => CellReply::Done(text),
                Ok(Err(why)) => CellReply::Refused(format!("{why}")),
                Err(_) => CellReply::None,
            }
        }
    }

    /// Gives up what was asked and has no reply: the callers are opened anew.
    ///
    /// # Errors
    /// When the middleware has failed.
    pub fn give_up(&mut self) -> miette::Result<()> {
        self.callers = Arc::new(CellCallers::open(&mut self.node)?);
        Ok(())
    }
}

async fn perform(callers: &CellCallers, of: CellRequest) -> miette::Result<String> {
    match of {
        CellRequest::Answer { alarm, word, by } => {
            callers.answer(alarm, &word, by).await?;
            Ok(format!("alarm {alarm} is answered: {word}"))
        }
        CellRequest::Submit { product, quantity, name, due_s } => {
            let wall = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
            let name = if name.is_empty() { usual_name(&product, wall) } else { name };
            let due = due_s.map_or(Ok(Time::default()), |due| moment(wall, Some(f64::from(due)), "due"))?;
            let requests = vec![linewright_msgs::ProductionRequest { due, ..request(&name, &product, quantity) }];
            let response = ask(&callers.submit, &SubmitOrdersRequest { requests }).await?;
            if !response.accepted {
                return Err(miette!("{}", response.problems.join("; ")));
            }
            let numbers: Vec<String> = response.ids.iter().map(u64::to_string).collect();
            Ok(format!("production order {}: `{name}`", numbers.join(", ")))
        }
        CellRequest::Cancel { order } => {
            change(&callers.cancel, &order).await?;
            Ok(format!("`{order}` is cancelled"))
        }
        CellRequest::Withdraw { order } => {
            change(&callers.withdraw, &order).await?;
            Ok(format!("`{order}` is withdrawn"))
        }
        CellRequest::Why { about } => {
            let response = ask(&callers.why, &WhyNotRequest { about }).await?;
            Ok(response.lines.join("\n"))
        }
        CellRequest::Resource { resource, to, by } => {
            let (what, state) = match to {
                ResourceCommand::Up => (SetResourceRequest::UP, "is in service again"),
                ResourceCommand::Down => (SetResourceRequest::DOWN, "is out of service"),
                ResourceCommand::Reset => (SetResourceRequest::RESET, "is reset"),
            };
            callers.resource(&resource, what, "", by).await?;
            Ok(format!("{resource} {state}"))
        }
    }
}
