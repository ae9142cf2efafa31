//! Starts of activities: the cell is played without a fault, by the real player and the real controllers, until each
//! activity can start.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use linewright_cell::net::Supply;
use linewright_coordinator_cell::compile::{OrderTiming, Unplayable, compile_cell};
use linewright_coordinator_cell::{
    CellMessage, CellTable, Coordination, ModeId, PlayerInput, PlayerOutbox, PlayerState, RecordKind,
};
use linewright_line::{StationId, Tick};
use linewright_station_logic::CompileError;
use thiserror::Error;

use super::ProtocolSetting;
use super::players::{ProtocolPlayer, SingleStart, StartableModes};
use super::station::TaskStationModel;

/// Sent again only after everything else has run out: a late copy of the first message is the same.
const PACE: OrderTiming =
    OrderTiming { repeat_interval: Duration::from_secs(24 * 3600), grace: Duration::from_secs(1) };
/// So often the cell is played from its beginning, each time with other decisions.
const ROUNDS: u64 = 24;
/// At most so many activities in one round.
const STARTS_MAX: usize = 400;
/// Of each part type so many may come.
const PARTS: u32 = 3;

/// Why the order protocol of a cell cannot be explored.
#[derive(Debug, Error)]
pub enum NotPlayable {
    /// It has no form that can be played.
    #[error(transparent)]
    Unplayable(#[from] Unplayable),
    /// A station has no controller.
    #[error(transparent)]
    Compile(#[from] CompileError),
}

/// An activity about to start.
pub(super) struct ActivityStart {
    pub name: String,
    pub mode: ModeId,
    pub stations: Vec<StationId>,
    pub machines: Vec<TaskStationModel>,
    pub player: ProtocolPlayer,
}

/// Properties by which two modes are the same to the order protocol: the orders and their stations, and the recovery
/// policy.
type ModeKind = (Vec<(StationId, Arc<str>)>, Vec<usize>, bool);

fn kind(table: &CellTable, mode: ModeId) -> ModeKind {
    let orders = table.activity(mode).orders.iter().map(|order| (order.station, order.task.clone())).collect();
    let handled = table.handling().mode(mode);
    (orders, handled.rules.clone(), handled.gone.is_some())
}

/// One stage for each kind of activity that is met.
pub(super) fn stages(setting: &ProtocolSetting<'_>) -> Result<Vec<ActivityStart>, NotPlayable> {
    let parts = vec![PARTS; setting.cell.part_types.len()];
    let table = Arc::new(compile_cell(setting.cell, Some(setting.line), Supply::Batch(&parts), PACE)?.table);
    let mut handling = table.handling().clone();
    // Sensors, and stations that are silent for long, are not explored.
    handling.lost_after = None;
    handling.resources.iter_mut().for_each(|resource| resource.is_sensed = false);
    let table = Arc::new(Arc::unwrap_or_clone(table).with_handling(handling));
    let ours = |mode: &ModeId| {
        let activity = table.activity(*mode);
        !activity.orders.is_empty() && setting.only.is_none_or(|only| &*activity.name == only)
    };
    let mut open: BTreeSet<ModeKind> = table.modes().filter(ours).map(|mode| kind(&table, mode)).collect();
    let mut stages = Vec::new();
    for round in 0..ROUNDS {
        if open.is_empty() {
            break;
        }
        play(setting, &table, round, &mut open, &mut stages)?;
    }
    Ok(stages)
}

fn play(
    setting: &ProtocolSetting<'_>,
    table: &Arc<CellTable>,
    round: u64,
    open: &mut BTreeSet<ModeKind>,
    stages: &mut Vec<ActivityStart>,
) -> Result<(), NotPlayable> {
    let line = setting.line;
    let mut machines = line.station_ids().map(|id| TaskStationModel::new(line, id)).collect::<Result<Vec<_>, _>>()?;
    let (mut out, mut now) = (PlayerOutbox::default(), Tick::ZERO);
    let Ok(mut coordination) = Coordination::begin(PlayerState::new(table.clone()), now, 1, &mut out) else {
        return Ok(());
    };
    for turn in 0..STARTS_MAX as u64 {
        say(&mut coordination, &machines, line, now);
        let mut asked = StartableModes::default();
        coordination.reconsider();
        coordination.step(now, &[PlayerInput::Starts(true)], &mut asked, &mut PlayerOutbox::default());
        asked.0.sort_unstable();
        asked.0.dedup();
        for &mode in &asked.0 {
            if !open.remove(&kind(table, mode)) {
                continue;
            }
            let activity = table.activity(mode);
            let mut stations: Vec<StationId> = activity.orders.iter().map(|order| order.station).collect();
            stations.dedup();
            let player = ProtocolPlayer {
                coordination: coordination.clone(),
                now,
                starts: 0,
                firing: None,
                alarmed: Vec::new(),
            };
            stages.push(ActivityStart {
                name: activity.name.to_string(),
                mode,
                machines: stations.iter().map(|station| machines[station.index()].clone()).collect(),
                stations,
                player,
            });
        }
        let is_new = |mode: &&ModeId| open.contains(&kind(table, **mode));
        let any = asked.0.len().max(1) as u64;
        // Any other order of decisions will do, as long as rounds differ.
        let chosen = (turn.wrapping_mul(7919) ^ (round.wrapping_mul(104_729) + turn / 3)) % any;
        let wanted = asked.0.iter().find(is_new).or(asked.0.get(chosen as usize)).copied();
        let Some(mode) = wanted else { return Ok(()) };
        let mut out = PlayerOutbox::default();
        coordination.reconsider();
        coordination.step(now, &[], &mut SingleStart(Some(mode)), &mut out);
        // All stations at once, each to its end; then what has no stations ends by its own time.
        for _ in 0..50 {
            for send in out.sends.drain(..) {
                if let CellMessage::Order(order) = send {
                    machines[order.station.index()].order(&order);
                    machines[order.station.index()].finish(line);
                }
            }
            if coordination.state().firings().len() == 0 {
                break;
            }
            out = PlayerOutbox::default();
            let stays = say_into(&mut coordination, &machines, line, now, &mut out);
            if !stays && out.sends.is_empty() {
                now = coordination.next_deadline().filter(|&at| at < Tick::NEVER).unwrap_or(now).max(now);
                coordination.step(now, &[], &mut SingleStart(None), &mut out);
            }
            if out.records.iter().any(|record| matches!(record.fact, RecordKind::Raised { .. })) {
                return Ok(());
            }
        }
    }
    Ok(())
}

fn say(coordination: &mut Coordination, machines: &[TaskStationModel], line: &linewright_line::Line, now: Tick) {
    let mut out = PlayerOutbox::default();
    say_into(coordination, machines, line, now, &mut out);
}

/// Gives the reports of all stations to the coordination. Whether anything has followed.
fn say_into(
    coordination: &mut Coordination,
    machines: &[TaskStationModel],
    line: &linewright_line::Line,
    now: Tick,
    out: &mut PlayerOutbox,
) -> bool {
    let said: Vec<_> = line.station_ids().zip(machines).map(|(id, machine)| (id, machine.says().heard)).collect();
    let inputs: Vec<PlayerInput<'_>> = said.iter().map(|(id, heard)| PlayerInput::Station(*id, heard)).collect();
    let before = out.records.len();
    coordination.step(now, &inputs, &mut SingleStart(None), out);
    out.records.len() > before
}
