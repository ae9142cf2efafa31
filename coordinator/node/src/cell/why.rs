//! Why something does not go on, whatever a person calls it.

use linewright_coordinator_cell::dispatch::words::Reasons;
use linewright_coordinator_cell::dispatch::{ShortestRoutes, why_not, why_out};
use linewright_coordinator_cell::exception::{AlarmAnswerRefusal, ResourceRequest, StationUnavailable};
use linewright_coordinator_cell::production::ProductionStatus;
use linewright_coordinator_cell::{PartId, PlayerState, ResourceId};
use linewright_line::{Line, StationId, Tick, suggestion};

use super::words::{names, parts};

/// Of so many parts of one order it is said why they do not go on.
const PARTS_MAX: usize = 5;

/// Why a part (`part 7`, or `7`) or a production order does not go on, or a resource is left out, these by their names; what
/// is not known where there is none.
pub fn why(
    ways: &ShortestRoutes,
    reasons: &Reasons,
    state: &PlayerState,
    now: Tick,
    about: &str,
) -> Result<Vec<String>, String> {
    let about = about.trim();
    let production = state.production();
    if let Some(order) = production.named(about) {
        let mut lines = vec![match production.status(order, now) {
            ProductionStatus::Waiting { on, until } => {
                let until = until.map(|until| format!("its release in {} s", until.since(now).as_secs()));
                format!(
                    "`{about}` waits for {}.",
                    names(production, &on).chain(until).collect::<Vec<_>>().join(" and ")
                )
            }
            ProductionStatus::Released => {
                format!("`{about}` is released, and none of its {} has entered.", parts(order.request.quantity))
            }
            ProductionStatus::InWork { .. } => format!(
                "`{about}`: {} of {} done, {} inside.",
                order.done,
                parts(order.request.quantity),
                order.inside()
            ),
            ProductionStatus::Done { .. } => format!("`{about}` is done."),
            ProductionStatus::Cancelled { inside, .. } => {
                format!("`{about}` is cancelled; {} still to be finished.", parts(inside))
            }
            ProductionStatus::Withdrawn => format!("`{about}` is withdrawn."),
        }];
        let counts = |part: &PartId| production.order_of(*part).is_some_and(|of| of.id == order.id);
        let parts: Vec<PartId> = state.parts().map(|part| part.id).filter(counts).take(PARTS_MAX).collect();
        lines.extend(parts.into_iter().flat_map(|part| why_not(ways, reasons, state, now, part)));
        return Ok(lines);
    }
    let handling = state.table().handling();
    if let Some(resource) = handling.resource_named(about) {
        return Ok(why_out(state, now, resource));
    }
    let number = about.strip_prefix("part").unwrap_or(about).trim().parse().ok();
    match number.map(PartId).filter(|&part| state.part(part).is_some()) {
        Some(part) => Ok(why_not(ways, reasons, state, now, part)),
        None => {
            let orders = production.orders().map(|order| order.request.name.as_str());
            let resources = handling.resources.iter().map(|resource| resource.name.as_ref());
            let names: Vec<&str> = orders.chain(resources).collect();
            let hint = suggestion(about, names.iter().copied()).map(|hint| format!("; {hint}")).unwrap_or_default();
            Err(format!("there is no part, no production order and no resource `{about}`{hint}"))
        }
    }
}

/// Why what a person says is not believed or not done, in words.
pub fn refused(line: &Line, state: &PlayerState, asked: ResourceRequest, why: AlarmAnswerRefusal) -> String {
    let station = |id: StationId| line.station(id).name.as_str();
    let resource = |id: ResourceId| state.table().handling().resource(id).map_or("?", |resource| &resource.name);
    match why {
        AlarmAnswerRefusal::NoSuchAlarm => format!("there is no {}", asked_for(asked)),
        AlarmAnswerRefusal::NoSuchWord => {
            let words = state.exceptions().alarms().find(|alarm| asked == ResourceRequest::Answer(alarm.id));
            let words = words.map(|alarm| alarm.words.join(", "));
            format!("answers to {} are {}", asked_for(asked), words.unwrap_or_default())
        }
        AlarmAnswerRefusal::NoSuchResource => "there is no such resource".to_owned(),
        AlarmAnswerRefusal::AlreadySo if matches!(asked, ResourceRequest::Reset(_)) => {
            "it is not in emergency stop by itself".to_owned()
        }
        AlarmAnswerRefusal::AlreadySo => "it is so already".to_owned(),
        AlarmAnswerRefusal::Moves(id) if matches!(asked, ResourceRequest::Reset(_)) => {
            format!("{} has not been heard to stand", station(id))
        }
        AlarmAnswerRefusal::Moves(id) => {
            format!("{} still moves; wait until it stands, look again where the part is, then answer", station(id))
        }
        AlarmAnswerRefusal::HasPart(id) => {
            format!("the sensor of {} sees a part, where by this answer there is none", resource(id))
        }
        AlarmAnswerRefusal::HasNoPart(id) => {
            format!("the sensor of {} sees no part, where by this answer there is one", resource(id))
        }
        AlarmAnswerRefusal::NotHeard(id) => format!("{} is not heard", station(id)),
        AlarmAnswerRefusal::NotAtRest(id) => {
            format!("{} stands between two rests; lead it to one by hand", station(id))
        }
        AlarmAnswerRefusal::CannotWork(id, StationUnavailable::Devices) => {
            format!("the devices of {} are not there", station(id))
        }
        AlarmAnswerRefusal::CannotWork(id, StationUnavailable::Incomplete) => {
            format!("an operation of {} was stopped before its end; complete or undo it in manual", station(id))
        }
        AlarmAnswerRefusal::CannotWork(id, StationUnavailable::ByHand) => format!("{} is moved by hand", station(id)),
        AlarmAnswerRefusal::EmergencyStop(id) => {
            format!("{} is in emergency stop; look why, then give reset", station(id))
        }
        AlarmAnswerRefusal::Open(id) => format!("an activity of {} has failed; answer its alarm first", resource(id)),
    }
}

fn asked_for(asked: ResourceRequest) -> String {
    match asked {
        ResourceRequest::Answer(alarm) => format!("alarm {}", alarm.0),
        ResourceRequest::Alarm(_) | ResourceRequest::Down(_) | ResourceRequest::Up(_) | ResourceRequest::Reset(_) => {
            "such alarm".to_owned()
        }
    }
}
