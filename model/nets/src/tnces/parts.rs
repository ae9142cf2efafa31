//! Modules that closed loops are made of: outputs, inputs, the update between them, and the environment.
//!
//! Input, output and update modules are those of seed 003 §3.3.3 (L520-535, Figures 10 and 11, whose drawings are lost):
//! places and transitions are as described there, the names of the ports are chosen here.
//!
//! A change that reaches the update module while it is waiting starts no second wait, since t1 finds no token. Nothing
//! is lost by that: input modules read the *places* of the outputs when the update is over, so they see whatever has
//! been set until then. Only a pulse that begins and ends within one wait is never seen.

use super::{Interval, TncesModule};

/// A Boolean that events set and reset (output module, L531; Figure 10).
///
/// Event inputs `set`, `reset`. Condition outputs `on`, `off`. Event outputs `was_set`, `was_reset`, and `changed` for
/// either. Setting what is set already does nothing and is no change.
pub fn output(name: impl Into<String>, on: bool) -> TncesModule {
    let mut m = TncesModule::new(name);
    let (set, reset) = boolean(&mut m, on);
    let event = m.event_in("set");
    m.on(event, set);
    let event = m.event_in("reset");
    m.on(event, reset);
    m
}

/// A Boolean that copies another one on an event (input module, L531: the same, but "conditioned by condition arcs
/// (set/reset) from an external module").
///
/// Event input `update`. Condition inputs `x`, under which it is set, and `not_x`, under which it is reset; outputs as
/// of [`output`].
pub fn input(name: impl Into<String>, on: bool) -> TncesModule {
    let mut m = TncesModule::new(name);
    let (set, reset) = boolean(&mut m, on);
    let update = m.event_in("update");
    m.on(update, set).on(update, reset);
    let x = m.condition_in("x");
    m.only_if(x, set);
    let not_x = m.condition_in("not_x");
    m.only_if(not_x, reset);
    m
}

/// The delay between controller and plant (update module, L533-535, Figure 11; 100 ms there): "t1 is fired when an
/// external event happens and then, automatically, after 100 milliseconds t2 is fired producing a change in another
/// module".
///
/// Event input `event`, event output `changed` (L842).
pub fn update(name: impl Into<String>, delay: u32) -> TncesModule {
    let mut m = TncesModule::new(name);
    let idle = m.place("p1", 1);
    let waiting = m.place("p2", 0);
    let t1 = m.change("t1", idle, waiting, Interval::ANY);
    let t2 = m.change("t2", waiting, idle, Interval::exactly(delay));
    let event = m.event_in("event");
    m.on(event, t1).event_out("changed", [t2]);
    m
}

/// The environment as a source of events, at any time: event output `event`.
pub fn event_source(name: impl Into<String>) -> TncesModule {
    let mut m = TncesModule::new(name);
    let t = m.transition("occurs");
    m.external(t).event_out("event", [t]);
    m
}

/// The environment as a switch that turns on and off at any time; outputs as of [`output`].
pub fn switch(name: impl Into<String>, on: bool) -> TncesModule {
    let mut m = TncesModule::new(name);
    let (set, reset) = boolean(&mut m, on);
    m.external(set).external(reset);
    m
}

/// Two places, two transitions, and their outputs.
fn boolean(m: &mut TncesModule, on: bool) -> (crate::TransitionId, crate::TransitionId) {
    let off_place = m.place("off", u32::from(!on));
    let on_place = m.place("on", u32::from(on));
    let set = m.change("set", off_place, on_place, Interval::ANY);
    let reset = m.change("reset", on_place, off_place, Interval::ANY);
    m.condition_out("off", off_place).condition_out("on", on_place);
    m.event_out("was_set", [set]).event_out("was_reset", [reset]).event_out("changed", [set, reset]);
    (set, reset)
}
