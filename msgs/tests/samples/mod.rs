//! One message of each kind with every field set, so that a swapped or dropped field shows: for the golden bytes and the
//! hostile input.

use linewright_msgs::{
    ActivityState, AlarmState, Answer, Bounded, Byte, CellState, CoReadRequest, CoReadResponse, CoWriteIdRequest,
    CycleTime, DescribeParametersResponse, DiagnosticArray, DiagnosticStatus, DispatchOrderFeedback, DispatchOrderGoal,
    DispatchOrderResult, Flag, FloatingPointRange, GetAvailableTransitionsResponse, Header, IntegerRange, KeyValue,
    LineState, Log, ModeOrder, NodeState, NodeTransition, OrderEnd, OrderState, Parameter, ParameterDescriptor,
    ParameterEvent, ParameterValue, PartState, ProcessImage, ProductionRequest, ProductionState, RunTaskFeedback,
    RunTaskGoal, RunTaskResult, SecureOrder, SetModeRequest, SetModeResponse, StationEvent, StationState, Text, Time,
    TransitionDescription, TransitionEvent, TriggerResponse,
};

pub fn header() -> Header {
    Header { stamp: Time { sec: 1_700_000_000, nanosec: 123_456_789 }, frame_id: "line".into() }
}

pub fn answer() -> Answer {
    Answer {
        station: "s2".into(),
        boot_id: 0x1122_3344_5566_7788,
        request_number: 41,
        agreed: false,
        in_the_way: "lift bar".into(),
    }
}

pub fn station_state() -> StationState {
    StationState {
        header: header(),
        boot_id: 0x0102_0304_0506_0708,
        sequence: 9,
        station: "s1".into(),
        description: 0x0FED_CBA9_8765_4321,
        mode_epoch: 10,
        coordinator_boot_id: 0x0BAD_CAFE_0BAD_CAFE,
        mode: StationState::MODE_HAND,
        lifecycle: StationState::LIFECYCLE_INACTIVE,
        generation: 0x1234_5678_9ABC_DEF0,
        cycle: 3,
        done: vec![3, 2, 2],
        started: vec![3, 3, 2],
        places: vec![StationState::PLACE_COMPLETED, StationState::PLACE_INCOMPLETE, StationState::PLACE_NONE],
        recovering_home: false,
        round: 4,
        at_home: false,
        stopped: true,
        selector_manual: false,
        devices_valid: true,
        measured: Bounded::new(vec![5, 0, 128]).expect("three fit"),
        measured_age_ms: 12,
        position_lost: true,
        placed: true,
        place: 2,
        incomplete: vec![1],
        stop_causes: vec![StationState::CAUSE_WATCHDOG],
        operation: "drill".into(),
        fault: "drill: not down after 2 s".into(),
        blocked_by: vec!["s2 unknown".into(), "ä".into()],
        request_number: 42,
        request_operations: vec![0, 2],
        answers: vec![answer()],
    }
}

pub fn station_event() -> StationEvent {
    StationEvent {
        header: header(),
        station: "s1".into(),
        sequence: 77,
        kind: StationEvent::KIND_FAULT,
        operation: "drill".into(),
        cycle: 3,
        text: "not down".into(),
    }
}

pub fn process_image() -> ProcessImage {
    ProcessImage {
        header: header(),
        boot_id: 5,
        sequence: 6,
        description: 0x1112_1314_1516_1718,
        lives: 3,
        number: 9,
        number_boot_id: 10,
        mode_epoch: 11,
        valid: true,
        bits: Bounded::new((0..16).collect()).expect("sixteen fit"),
    }
}

pub fn mode_order() -> ModeOrder {
    ModeOrder {
        header: header(),
        boot_id: 5,
        sequence: 6,
        epoch: 7,
        mode: StationState::MODE_AUTO,
        enabled: true,
        master_stop: false,
        stop_round: -2,
        manual_all: true,
        buttons: 0x8000_0001,
        resume: true,
        lease_ms: 500,
        lives: vec![12, 4],
        found_generation: 9,
        stopped: vec!["robot".into()],
        manual: vec!["m1".into()],
        standing_by: vec!["m2".into()],
    }
}

pub fn line_state() -> LineState {
    LineState {
        header: header(),
        boot_id: 5,
        sequence: 6,
        description: 0xFEDC_BA98_7654_3210,
        epoch: 7,
        mode: StationState::MODE_AUTO,
        enabled: false,
        master_stop: true,
        text: "auto".into(),
        estop_latched: true,
        estop_pressed: false,
        console_lost: true,
        resume: false,
        restarted: vec!["s1".into()],
        left_out: vec!["s2".into(), "s3".into()],
        obstacles: vec!["second coordinator".into()],
        refusal: "s2 stands on manual".into(),
        refused: "manual s2".into(),
        refusal_age_ms: 1500,
        refusals: 2,
        stations: vec!["s1".into(), "s2".into()],
        station_heard: vec![LineState::HEARD_FRESH, LineState::HEARD_STALE],
        waiting_for: vec!["s2".into()],
    }
}

pub fn cycle_time() -> CycleTime {
    CycleTime { header: header(), number: 12, duration_s: 3.558 }
}

pub fn text() -> Text {
    Text::from("auto")
}

pub fn flag() -> Flag {
    Flag { data: true }
}

pub fn diagnostics() -> DiagnosticArray {
    let status = DiagnosticStatus {
        level: DiagnosticStatus::STALE,
        name: "coordinator: clamp 1 io".into(),
        message: "no heartbeat (1017h) for 230 ms".into(),
        hardware_id: "CANopen node 21h".into(),
        values: vec![KeyValue::new("state", "ERROR")],
    };
    DiagnosticArray { header: header(), status: vec![status] }
}

pub fn co_read() -> (CoReadRequest, CoReadResponse) {
    (CoReadRequest { index: 0x1018, subindex: 1 }, CoReadResponse { success: true, data: 0x1234_5678 })
}

pub fn co_write_id() -> CoWriteIdRequest {
    CoWriteIdRequest { nodeid: 0x21, index: 0x6200, subindex: 1, data: 0x1234_5678, canopen_datatype: 7 }
}

pub fn trigger() -> TriggerResponse {
    TriggerResponse { success: true, message: "ordered to reset".into() }
}

pub fn run_task() -> (RunTaskGoal, RunTaskResult, RunTaskFeedback) {
    let goal = RunTaskGoal {
        memory: 0x1122_3344_5566_7788,
        epoch: 3,
        id: 41,
        task: "load m1".into(),
        parameter_names: vec!["slot".into(), "program".into()],
        parameters: vec![4, -1],
        part: "part 7".into(),
        limit_ms: 24_000,
    };
    let result = RunTaskResult {
        epoch: 3,
        id: 41,
        end: RunTaskResult::END_REFUSED,
        code: RunTaskResult::REFUSED_LATE,
        text: "no time left".into(),
    };
    let phase = RunTaskFeedback::PHASE_SECURING;
    (goal, result, RunTaskFeedback { phase, operation: "approach".into(), step: 2, steps: 5 })
}

pub fn order_state() -> OrderState {
    let end = |id, end, code| OrderEnd { epoch: 3, id, end, code };
    OrderState {
        header: header(),
        boot_id: 0x0102_0304_0506_0708,
        sequence: 9,
        station: "robot".into(),
        description: 0x0F1E_2D3C_4B5A_6978,
        memory: 0x1122_3344_5566_7788,
        epoch: 3,
        doing_epoch: 3,
        doing_id: 41,
        phase: RunTaskFeedback::PHASE_RUNNING,
        secured_epoch: 3,
        secured_id: 37,
        secured_way: SecureOrder::WAY_BACK,
        rest: "home".into(),
        in_handshake: true,
        ended: Bounded::new(vec![end(38, RunTaskResult::END_DONE, 0), end(40, RunTaskResult::END_FAILED, 7)]).unwrap(),
        refused: Bounded::new(vec![end(39, RunTaskResult::END_REFUSED, RunTaskResult::REFUSED_BUSY)]).unwrap(),
        inputs: Bounded::new(vec![0b101, 0x80]).unwrap(),
    }
}

/// The answer with transitions, and the event of one.
pub fn lifecycle() -> (GetAvailableTransitionsResponse, TransitionEvent) {
    let state = |id, label: &str| NodeState { id, label: label.into() };
    let transition = |id, label: &str| NodeTransition { id, label: label.into() };
    let described = TransitionDescription {
        transition: transition(NodeTransition::TRANSITION_ACTIVATE, "activate"),
        start_state: state(NodeState::PRIMARY_STATE_INACTIVE, "inactive"),
        goal_state: state(NodeState::TRANSITION_STATE_ACTIVATING, "activating"),
    };
    let event = TransitionEvent {
        timestamp: 1_700_000_000_123_456_789,
        transition: transition(NodeTransition::TRANSITION_ON_ACTIVATE_SUCCESS, "transition_success"),
        start_state: state(NodeState::TRANSITION_STATE_ACTIVATING, "activating"),
        goal_state: state(NodeState::PRIMARY_STATE_ACTIVE, "active"),
    };
    (GetAvailableTransitionsResponse { available_transitions: vec![described] }, event)
}

pub fn parameters() -> (ParameterEvent, DescribeParametersResponse) {
    let value = ParameterValue {
        r#type: ParameterValue::TYPE_DOUBLE,
        bool_value: true,
        integer_value: -3,
        double_value: 1.5,
        string_value: "debug".into(),
        byte_array_value: vec![Byte(7)],
        bool_array_value: vec![false, true],
        integer_array_value: vec![i64::MIN],
        double_array_value: vec![-0.25],
        string_array_value: vec!["a".into(), String::new()],
    };
    let parameter = |name: &str| Parameter { name: name.into(), value: value.clone() };
    let event = ParameterEvent {
        stamp: header().stamp,
        node: "/line/s1".into(),
        new_parameters: vec![parameter("new")],
        changed_parameters: vec![parameter("changed"), parameter("b.c")],
        deleted_parameters: vec![parameter("deleted")],
    };
    let range = FloatingPointRange { from_value: 0.5, to_value: 10.0, step: 0.25 };
    let whole = IntegerRange { from_value: -2, to_value: 9, step: 3 };
    let descriptor = ParameterDescriptor {
        name: "rate".into(),
        r#type: ParameterValue::TYPE_DOUBLE,
        description: "How often.".into(),
        additional_constraints: "Odd.".into(),
        read_only: true,
        dynamic_typing: false,
        floating_point_range: Bounded::new(vec![range]).expect("one"),
        integer_range: Bounded::new(vec![whole]).expect("one"),
    };
    (event, DescribeParametersResponse { descriptors: vec![descriptor.clone(), descriptor] })
}

pub fn secure_order() -> SecureOrder {
    SecureOrder { epoch: 3, id: 41, way: SecureOrder::WAY_STOP }
}

pub fn production_request() -> ProductionRequest {
    ProductionRequest {
        key: Bounded::new((1..=16).collect()).unwrap(),
        name: "rush".into(),
        product: "A".into(),
        quantity: 12,
        release: Time { sec: 1_700_000_000, nanosec: 0 },
        due: Time { sec: 1_700_003_600, nanosec: 500_000_000 },
        priority: -3,
        after: vec!["first".into()],
    }
}

pub fn cell_state() -> CellState {
    let at = || Time { sec: 1_700_000_001, nanosec: 2 };
    let part = PartState { id: 7, stage: "A.turn".into(), place: "ST, position 3".into(), since: at(), order: 2 };
    let activity = ActivityState {
        id: 31,
        name: "load M1".into(),
        part: 7,
        began: at(),
        running: false,
        text: "waits for alarm 4".into(),
        stations: vec!["robot".into(), "m1".into()],
        tasks: vec!["put down".into(), "clamp".into()],
        numbers: vec!["slot=2\nside=1".into(), String::new()],
    };
    let order = ProductionState {
        id: 2,
        name: "rush".into(),
        product: "A".into(),
        quantity: 12,
        entered: 5,
        done: 3,
        lost: 1,
        status: ProductionState::STATUS_IN_WORK,
        text: "in work".into(),
        due: at(),
        ended: Time::default(),
    };
    let alarm = AlarmState {
        id: 4,
        raised: at(),
        text: "put it back".into(),
        answers: vec!["in-store".into()],
        meanings: vec!["part in ST".into()],
        verdicts: vec![AlarmState::VERDICT_CONTRADICTS],
        verdict_reasons: vec!["ST: part expected, sensor off".into()],
        lead: vec!["s1".into(), "s2".into()],
        reset: vec!["s2".into()],
        at_order: vec!["s5".into()],
        lead_to: AlarmState::LEAD_ON,
        lead_because: "s3 has completed its order".into(),
        bring: "s4".into(),
        to_rest: "open".into(),
    };
    CellState {
        header: header(),
        boot_id: 0x0102_0304_0506_0708,
        sequence: 9,
        cell: "workcell_c1".into(),
        epoch: 3,
        starting: true,
        parts_inside: 1,
        parts_left: 3,
        orders_open: 1,
        parts: Bounded::new(vec![part]).unwrap(),
        activities: Bounded::new(vec![activity]).unwrap(),
        orders: Bounded::new(vec![order]).unwrap(),
        alarms: Bounded::new(vec![alarm]).unwrap(),
        down: Bounded::new(vec!["M2".into()]).unwrap(),
    }
}

pub fn set_mode() -> (SetModeRequest, SetModeResponse) {
    let request = SetModeRequest {
        command: SetModeRequest::MANUAL,
        station: "robot".into(),
        stamp: Time { sec: 1_700_000_001, nanosec: 2 },
        by: "ada".into(),
        note: "a part lies on the floor".into(),
    };
    (request, SetModeResponse { accepted: true, reason: "auto, robot in manual".into(), epoch: 0x0102_0304_0506_0708 })
}

pub fn dispatch_order() -> (DispatchOrderGoal, DispatchOrderResult, DispatchOrderFeedback) {
    let order = ProductionState {
        id: 2,
        name: "rush".into(),
        product: "A".into(),
        quantity: 12,
        entered: 5,
        done: 3,
        status: ProductionState::STATUS_IN_WORK,
        text: "in work".into(),
        ..ProductionState::default()
    };
    let goal = DispatchOrderGoal { request: production_request(), by: "ada".into() };
    let (end, problems) = (DispatchOrderResult::END_REFUSED, vec!["no product `Z`".into()]);
    (goal, DispatchOrderResult { end, order: order.clone(), problems }, DispatchOrderFeedback { order })
}

pub fn log_line() -> Log {
    Log {
        stamp: Time { sec: 1_700_000_001, nanosec: 2 },
        level: Log::WARN.0,
        name: "transfer_line.mill_1".into(),
        msg: "ignored a message".into(),
        file: "node.rs".into(),
        function: String::new(),
        line: 77,
    }
}
