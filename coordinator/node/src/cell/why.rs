//! Reason why a part, a production order or a resource does not go on, by its name.

use linewright_coordinator_cell::dispatch::Reasons;
use linewright_coordinator_cell::dispatch::{ShortestRoutes, why_not, why_resource};
use linewright_coordinator_cell::production::ProductionStatus;
use linewright_coordinator_cell::{Coordination, PartId};
use linewright_line::{Tick, suggestion};

use super::words::{names, parts};

/// Parts of one order for which a reason is given, at most.
const PARTS_MAX: usize = 5;

/// Numbers of parts that are listed where another was named, at most.
const NUMBERS_MAX: usize = 30;

/// Reason why a part (`part 7`, or `7`), a production order or a resource does not go on; orders and resources by their
/// names. An error for an unknown one.
pub fn why(
    ways: &ShortestRoutes,
    reasons: &Reasons,
    coordination: &Coordination,
    now: Tick,
    about: &str,
) -> Result<Vec<String>, String> {
    let (about, state) = (about.trim(), coordination.state());
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
                format!("`{about}` is cancelled; {} still in the cell.", parts(inside))
            }
            ProductionStatus::Withdrawn => format!("`{about}` is withdrawn."),
        }];
        let counts = |part: &PartId| production.order_of(*part).is_some_and(|of| of.id == order.id);
        let parts: Vec<PartId> = state.parts().map(|part| part.id).filter(counts).take(PARTS_MAX).collect();
        lines.extend(parts.into_iter().flat_map(|part| why_not(ways, reasons, coordination, now, part)));
        return Ok(lines);
    }
    let handling = state.table().handling();
    match handling.resource_or_station_named(about) {
        Ok(resource) => return Ok(why_resource(coordination, now, resource)),
        Err(several) if !several.is_empty() => {
            return Ok(several.into_iter().flat_map(|resource| why_resource(coordination, now, resource)).collect());
        }
        Err(_) => (),
    }
    let number = about.strip_prefix("part").unwrap_or(about).trim().parse().ok();
    match number.map(PartId).filter(|&part| state.part(part).is_some()) {
        Some(part) => Ok(why_not(ways, reasons, coordination, now, part)),
        None if number.is_some() => {
            let mut inside: Vec<String> =
                state.parts().take(NUMBERS_MAX + 1).map(|part| part.id.0.to_string()).collect();
            if inside.len() > NUMBERS_MAX {
                inside[NUMBERS_MAX] = "…".to_owned();
            }
            let inside = if inside.is_empty() { "none".to_owned() } else { inside.join(", ") };
            Err(format!(
                "no part {about} in the cell; parts inside: {inside}",
                about = about.trim_start_matches("part").trim()
            ))
        }
        None => {
            let orders = production.orders().map(|order| order.request.name.as_str());
            let resources = handling.resources.iter().map(|resource| resource.name.as_ref());
            let names: Vec<&str> = orders.chain(resources).collect();
            let hint = suggestion(about, names.iter().copied()).map(|hint| format!("; {hint}")).unwrap_or_default();
            Err(format!("no part, production order or resource `{about}`{hint}"))
        }
    }
}
