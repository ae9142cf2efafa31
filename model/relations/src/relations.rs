//! Relations of operations: what a planner writes in tables, resolved and checked.

use std::time::Duration;

use crate::Precondition;

/// Number of a machine in [`Relations::machines`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MachineId(pub usize);

/// Number of a zone in [`Relations::zones`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ZoneId(pub usize);

/// Number of an operation in [`Relations::operations`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct OperationId(pub usize);

/// Number of a cycle start condition in [`Relations::conditions`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ConditionId(pub usize);

/// A component of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ComponentRef {
    pub machine: MachineId,
    /// Its number in [`CellMachine::components`].
    pub component: usize,
}

/// Number of a state in [`MachineComponent::states`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ComponentState(pub usize);

/// The line of a table that something comes from, for messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TableRow {
    /// The file, as a number in [`Relations::files`].
    pub file: usize,
    /// Its line, from 1.
    pub line: u32,
}

/// Everything that the tables of a cell describe. Made by [`parse`](crate::parse) alone, so that every number in it is that
/// of something.
#[derive(Clone, Debug, PartialEq)]
pub struct Relations {
    /// Name of the cell: one word.
    pub name: String,
    /// Title for people.
    pub title: String,
    /// Most products in the cell at once, from 1.
    pub products_max: usize,
    pub machines: Vec<CellMachine>,
    /// Volumes and passive resources that one machine at a time may have.
    pub zones: Vec<CollisionZone>,
    /// Cycle start conditions (CSC): which product, or other situation, has which sequences.
    pub conditions: Vec<StartCondition>,
    /// General functions of the cell (the second half of MCF).
    pub functions: Vec<CellFunction>,
    /// Declarations of operations (DOP).
    pub operations: Vec<DeclaredOperation>,
    /// Relations of operations (ROP), a list for each machine and condition.
    pub sequences: Vec<MachineSequence>,
    /// Executions of operations (EOP).
    pub executions: Vec<Execution>,
    /// Interlocks (IL).
    pub interlocks: Vec<Interlock>,
    /// Names of the files that the tables were read from.
    pub files: Vec<String>,
}

/// A machine: a robot, a fixture, a turntable, an operator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellMachine {
    pub name: String,
    pub title: String,
    pub components: Vec<MachineComponent>,
}

/// A part of a machine that has a state of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MachineComponent {
    pub name: String,
    pub title: String,
    pub kind: ComponentKind,
    /// At least two.
    pub states: Vec<String>,
    /// Actuators and sensors that it consists of, as circuit diagrams name them.
    pub subcomponents: Vec<String>,
    /// Function block that controls it; none where it is not stated.
    pub block: Option<String>,
}

/// How a component gets its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ComponentKind {
    /// By order.
    Actuator,
    /// From outside: it only reports.
    Sensor,
    /// By order; a property that no sensor measures.
    Variable,
}

impl ComponentKind {
    /// All kinds with their words.
    pub const ALL: [(&'static str, ComponentKind); 3] = [
        ("actuator", ComponentKind::Actuator),
        ("sensor", ComponentKind::Sensor),
        ("variable", ComponentKind::Variable),
    ];

    /// Whether it can be ordered into a state.
    pub fn is_active(self) -> bool {
        self != ComponentKind::Sensor
    }
}

/// A volume that two machines can reach into, or a passive resource that they share, such as a tool.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CollisionZone {
    pub name: String,
    pub title: String,
}

/// A cycle start condition: the situation in which a set of sequences is run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StartCondition {
    pub name: String,
    pub title: String,
    /// Product that is worked on; none where it does not depend on one.
    pub product: Option<String>,
    /// Work cycle that the sequences are of, from 1.
    pub cycle: u32,
    /// States that make it valid, all of them.
    pub states: Vec<(ComponentRef, ComponentState)>,
}

/// A function of the cell that no machine has, and its function block.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellFunction {
    pub name: String,
    pub title: String,
    pub block: String,
}

/// A row of the declarations of operations.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredOperation {
    /// Its identity, as planners number it.
    pub id: String,
    pub comment: String,
    pub machine: MachineId,
    /// Conditions in which it is done.
    pub conditions: Vec<ConditionId>,
    /// Zones that it takes, undivided; none where the column is empty. What counts is in the relations.
    pub zones: Option<Vec<ZoneId>>,
    pub duration: Option<Duration>,
    /// It is done every so many work cycles, from 1.
    pub every: u32,
    pub row: TableRow,
}

/// The order of work of one machine in one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineSequence {
    pub condition: ConditionId,
    pub machine: MachineId,
    /// At least one.
    pub elements: Vec<SequenceElement>,
}

/// A place in a sequence: one operation, or several of which one is done.
#[derive(Clone, Debug, PartialEq)]
pub struct SequenceElement {
    /// At least one.
    pub alternatives: Vec<RelatedOperation>,
}

/// A row of the relations of operations.
#[derive(Clone, Debug, PartialEq)]
pub struct RelatedOperation {
    pub operation: OperationId,
    pub kind: OperationKind,
    /// Name that alternatives, or parallel operations of several machines, have in common.
    pub group: Option<String>,
    /// What has to be finished, besides the element before it.
    pub after: Precondition,
    /// Zones that the machine has while it does it.
    pub zones_before: Vec<ZoneId>,
    /// Of these, zones that it keeps afterwards, until a later operation that takes them does not keep them.
    pub zones_after: Vec<ZoneId>,
    pub comment: String,
    pub row: TableRow,
}

/// How an operation is chosen and carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OperationKind {
    /// By one machine, always in the same way (A).
    Basic,
    /// By one machine, in one of several ways, by the states of components (B).
    AlternativeExecution,
    /// One of several operations, chosen by the states of components (C).
    Alternative,
    /// An alternative that an error chooses, or one that stands by itself and is never scheduled (D).
    Exception,
    /// By several machines at once, each with an operation of its own (E).
    Parallel,
    /// Its start cannot be held back: an operator does it, for instance.
    Uncontrolled,
}

impl OperationKind {
    /// All kinds with their words.
    pub const ALL: [(&'static str, OperationKind); 6] = [
        ("basic", OperationKind::Basic),
        ("alternative-execution", OperationKind::AlternativeExecution),
        ("alternative", OperationKind::Alternative),
        ("exception", OperationKind::Exception),
        ("parallel", OperationKind::Parallel),
        ("uncontrolled", OperationKind::Uncontrolled),
    ];

    /// Its word in tables.
    pub fn word(self) -> &'static str {
        OperationKind::ALL.iter().find(|(_, kind)| *kind == self).map_or("", |(word, _)| word)
    }
}

/// One way to carry out an operation: the states that its machine passes through.
#[derive(Clone, Debug, PartialEq)]
pub struct Execution {
    pub operation: OperationId,
    /// Name of the way, where there are several.
    pub way: Option<String>,
    /// States that must be there first.
    pub initial: ExecutionStep,
    /// States that are ordered one after the other.
    pub actions: Vec<ExecutionStep>,
}

/// A row of an execution.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExecutionStep {
    /// States, `None` where any will do; components of other machines among them.
    pub states: Vec<(ComponentRef, Option<ComponentState>)>,
    /// Zones that are booked: the step has ended only when they are.
    pub booked: Vec<ZoneId>,
    /// Zones that are free again.
    pub released: Vec<ZoneId>,
    /// Type of the alarm where the states are not there, from 1.
    pub alarm: Option<u32>,
    /// Time after which it is given.
    pub delay: Option<Duration>,
    pub comment: String,
    pub row: TableRow,
}

/// What an interlock is about.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum InterlockedAction {
    /// A component going to a state.
    State { component: ComponentRef, to: ComponentState },
    /// A whole operation, as of a robot, or one way of it.
    Operation { operation: OperationId, way: Option<String> },
}

/// The terms of an action, of which one must be fulfilled.
#[derive(Clone, Debug, PartialEq)]
pub struct Interlock {
    pub action: InterlockedAction,
    /// At least one.
    pub terms: Vec<InterlockTerm>,
}

/// A combination that allows an action.
#[derive(Clone, Debug, PartialEq)]
pub struct InterlockTerm {
    /// Expected in automatic mode. Only such terms count in synthesis; in manual mode all do.
    pub is_automatic: bool,
    pub states: Vec<InterlockState>,
    /// Zones that the machine has during the action, in manual mode.
    pub zones_before: Vec<ZoneId>,
    /// Of these, zones that it keeps.
    pub zones_after: Vec<ZoneId>,
    /// Operations on the same product that may not have started.
    pub not_started: Vec<OperationId>,
    /// Operations that may not be going on, of any product.
    pub not_ongoing: Vec<OperationId>,
    /// Product that the term is about; all where there is none.
    pub product: Option<String>,
    pub comment: String,
    pub row: TableRow,
}

/// A state that a term asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InterlockState {
    pub component: ComponentRef,
    pub state: ComponentState,
    /// It is needed at the beginning of the action alone.
    pub is_initial: bool,
}

impl Relations {
    /// A machine.
    pub fn machine(&self, id: MachineId) -> &CellMachine {
        &self.machines[id.0]
    }

    /// A component of a machine.
    pub fn component(&self, of: ComponentRef) -> &MachineComponent {
        &self.machine(of.machine).components[of.component]
    }

    /// A component as tables name it: `FIX152.Y18`.
    pub fn component_name(&self, of: ComponentRef) -> String {
        format!("{}.{}", self.machine(of.machine).name, self.component(of).name)
    }

    /// The name of a state.
    pub fn state_name(&self, of: ComponentRef, state: ComponentState) -> &str {
        &self.component(of).states[state.0]
    }

    /// A declared operation.
    pub fn operation(&self, id: OperationId) -> &DeclaredOperation {
        &self.operations[id.0]
    }

    /// A zone.
    pub fn zone(&self, id: ZoneId) -> &CollisionZone {
        &self.zones[id.0]
    }

    /// The sequence of a machine in a condition.
    pub fn sequence(&self, condition: ConditionId, machine: MachineId) -> Option<&MachineSequence> {
        self.sequences.iter().find(|sequence| sequence.condition == condition && sequence.machine == machine)
    }

    /// The rows of the relations of a condition, in the order of the tables.
    pub fn related(&self, condition: ConditionId) -> impl Iterator<Item = (MachineId, &RelatedOperation)> {
        let sequences = self.sequences.iter().filter(move |sequence| sequence.condition == condition);
        sequences.flat_map(|sequence| sequence.rows().map(|row| (sequence.machine, row)))
    }

    /// The ways of an operation: one execution for each.
    pub fn ways(&self, operation: OperationId) -> impl Iterator<Item = &Execution> {
        self.executions.iter().filter(move |execution| execution.operation == operation)
    }

    /// A place for messages: `relations.csv:14`.
    pub fn place(&self, row: TableRow) -> String {
        format!("{}:{}", self.files.get(row.file).map_or("?", String::as_str), row.line)
    }

    /// The same without the places in files: what two tables that are written differently have in common.
    pub fn without_rows(mut self) -> Self {
        self.files.clear();
        let none = TableRow::default();
        self.operations.iter_mut().for_each(|operation| operation.row = none);
        let elements = self.sequences.iter_mut().flat_map(|sequence| &mut sequence.elements);
        elements.flat_map(|element| &mut element.alternatives).for_each(|row| row.row = none);
        for execution in &mut self.executions {
            execution.initial.row = none;
            execution.actions.iter_mut().for_each(|step| step.row = none);
        }
        self.interlocks.iter_mut().flat_map(|interlock| &mut interlock.terms).for_each(|term| term.row = none);
        self
    }
}

impl MachineSequence {
    /// The rows of all its elements, in their order.
    pub fn rows(&self) -> impl Iterator<Item = &RelatedOperation> {
        self.elements.iter().flat_map(|element| &element.alternatives)
    }
}

impl Execution {
    /// All rows, the initial one first.
    pub fn steps(&self) -> impl DoubleEndedIterator<Item = &ExecutionStep> {
        std::iter::once(&self.initial).chain(&self.actions)
    }

    /// The state that a component is left in; none where the rows do not state one.
    pub fn last_state(&self, component: ComponentRef) -> Option<ComponentState> {
        self.steps().rev().find_map(|step| step.state(component)).flatten()
    }
}

impl ExecutionStep {
    /// What the row has for a component: nothing, any, or a state.
    pub fn state(&self, component: ComponentRef) -> Option<Option<ComponentState>> {
        self.states.iter().find(|(of, _)| *of == component).map(|(_, state)| *state)
    }
}
