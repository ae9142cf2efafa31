//! Requests to devices through the manager: each is answered, and disturbs nothing.

use linewright_line::ObjectWrite;

use super::*;
use crate::codec::NmtState;
use crate::manager::device_request::WAITING_MAX;
use crate::manager::{DeviceCondition, DeviceRequest, DeviceRequestError, RequestResult};
use crate::sdo::{Abort, ObjectId, TransferError, TransferFailure};

const VENDOR: ObjectId = ObjectId::new(0x1018, 1);

impl ManagerBench {
    fn ask(&mut self, node: u8, ask: DeviceRequest) -> u64 {
        self.manager.ask(self.now, node, ask, &mut self.out)
    }

    /// The frames sent and the answers given since this was last called.
    fn told(&mut self) -> (Vec<String>, Vec<(u64, RequestResult)>) {
        let out = std::mem::take(&mut self.out);
        let numbers: Vec<u64> = out.answers.iter().map(|answer| answer.0).collect();
        let events = out.events.iter().filter_map(|event| match event {
            BusEvent::Answered { number } => Some(*number),
            _ => None,
        });
        assert_eq!(events.collect::<Vec<u64>>(), numbers, "each answer is told once");
        (out.frames.iter().map(Frame::to_string).collect(), out.answers)
    }
}

fn write(index: u16, sub: u8, value: u32) -> DeviceRequest {
    DeviceRequest::Write { object: ObjectId::new(index, sub), value, bytes: None }
}

#[test]
fn an_object_is_read_and_the_bytes_are_the_answer() {
    let mut bench = ManagerBench::up();
    let number = bench.ask(6, DeviceRequest::Read(VENDOR));
    assert_eq!(bench.told(), (vec!["606#4018100100000000".to_owned()], vec![]));
    bench.hear("586#4318100178563412");
    assert_eq!(bench.told(), (vec![], vec![(number, Ok(vec![0x78, 0x56, 0x34, 0x12]))]));
    let number = bench.ask(6, DeviceRequest::Read(VENDOR));
    bench.told();
    bench.hear("586#8018100111000906");
    let error = TransferError { object: VENDOR, cause: TransferFailure::Refused(Abort::NO_SUBINDEX) };
    let (_, answers) = bench.told();
    assert_eq!(answers, [(number, Err(DeviceRequestError::Transfer(error)))]);
    assert_eq!(answers[0].1.as_ref().unwrap_err().abort(), Abort::NO_SUBINDEX);
}

#[test]
fn a_number_is_written_in_the_length_the_object_has() {
    let mut bench = ManagerBench::up();
    let number = bench.ask(6, write(0x5F00, 1, 3));
    assert_eq!(bench.told().0, ["606#40005F0100000000"]);
    bench.hear("586#4F005F0100000000");
    assert_eq!(bench.told().0, ["606#2F005F0103000000"]);
    bench.hear("586#60005F0100000000");
    assert_eq!(bench.told().1, [(number, Ok(vec![]))]);
    // 300 does not fit one byte: nothing is written.
    let number = bench.ask(6, write(0x5F00, 1, 300));
    bench.told();
    bench.hear("586#4F005F0100000000");
    let object = ObjectId::new(0x5F00, 1);
    assert_eq!(
        bench.told(),
        (vec![], vec![(number, Err(DeviceRequestError::TooLarge { object, value: 300, bytes: 1 }))])
    );
    // A length that is given is not read.
    bench.ask(6, DeviceRequest::Write { object, value: 3, bytes: Some(2) });
    assert_eq!(bench.told().0, ["606#2B005F0103000000"]);
}

#[test]
fn an_object_that_cannot_be_read_is_written_in_the_length_it_takes() {
    let mut bench = ManagerBench::up();
    let number = bench.ask(6, write(0x2005, 0, 300));
    bench.hear("586#8005200001000106");
    assert_eq!(bench.told().0[1..], ["606#2B0520002C010000"], "300 has two bytes");
    bench.hear("586#8005200013000706");
    assert_eq!(bench.told().0, ["606#230520002C010000"], "too short, says the device");
    bench.hear("586#8005200030000906");
    let (frames, answers) = bench.told();
    let error = TransferError { object: ObjectId::new(0x2005, 0), cause: TransferFailure::Refused(Abort::VALUE) };
    assert_eq!((frames, answers), (vec![], vec![(number, Err(error.into()))]));
    // Another refusal is not about the length.
    bench.ask(6, write(0x2005, 0, 1));
    bench.hear("586#8005200001000106");
    assert_eq!(bench.told().0[1..], ["606#2F05200001000000"]);
    bench.hear("586#6005200000000000");
    assert_eq!(bench.told().1[0].1, Ok(vec![]));
}

/// None of what the process rests on is written now.
fn assert_guarded(bench: &mut ManagerBench) {
    for index in [0x1016, 0x1017, 0x1400, 0x1600, 0x1A00, 0x6200, 0x6206, 0x6002] {
        let number = bench.ask(6, write(index, 1, 1));
        let (frames, answers) = bench.told();
        assert!(frames.is_empty() && answers[0].0 == number, "{index:04X}h");
        let error = answers[0].1.as_ref().unwrap_err();
        assert_eq!(error.abort(), Abort::LOCAL_CONTROL);
        assert!(error.to_string().contains("is not written for others"), "{error}");
    }
}

#[test]
fn what_the_process_rests_on_is_not_written_in_any_state() {
    let mut bench = ManagerBench::up();
    assert_guarded(&mut bench);
    // Reading is never refused.
    bench.ask(6, DeviceRequest::Read(ObjectId::new(0x6200, 1)));
    assert_eq!(bench.told().0, ["606#4000620100000000"]);
    bench.hear("586#4F00620100000000");
    // Being booted, and then refused: it is tried again without a reset, and would be started with what was written.
    bench.hear("706#00");
    bench.told();
    assert_guarded(&mut bench);
    bench.hear("586#4300100091010300");
    bench.hear("586#8017100000000106");
    bench.told();
    assert_guarded(&mut bench);
    // The manufacturer's own objects may be set right.
    bench.ask(6, write(0x2001, 1, 0xFF));
    assert_eq!(bench.told().0, ["606#4001200100000000"]);
    bench.hear("586#8001200100000206");
    bench.told();
    bench.hear("706#04");
    assert_guarded(&mut bench);
}

#[test]
fn what_the_description_sets_is_not_written_by_others() {
    let mut devices = devices();
    devices[2].canopen_mut().expect("CANopen").setup.settings =
        vec![ObjectWrite { index: 0x2001, sub: 0, data: vec![1] }];
    let mut bench = ManagerBench::of(&devices);
    for text in ["706#00", "586#4300100091010300", "586#6001200000000000", "586#6017100000000000"] {
        bench.hear(text);
    }
    bench.hear("586#6016100100000000");
    bench.takes_error_values(6);
    bench.hear("586#4F01100000000000");
    bench.hear("186#00");
    bench.told();
    bench.ask(6, write(0x2001, 0, 5));
    let (_, answers) = bench.told();
    assert!(matches!(answers[0].1, Err(DeviceRequestError::Guarded { .. })), "{answers:?}");
}

#[test]
fn a_boot_comes_first_and_requests_wait_for_its_end() {
    let mut bench = ManagerBench::new();
    bench.hear("706#00");
    bench.told();
    let (first, second) =
        (bench.ask(6, DeviceRequest::Read(VENDOR)), bench.ask(6, DeviceRequest::Read(ObjectId::new(0x1008, 0))));
    assert_eq!(bench.told(), (vec![], vec![]), "the boot is under way");
    bench.configure_to_register(6);
    bench.told();
    bench.hear("586#4F01100000000000");
    assert_eq!(bench.told().0, ["000#0106", "606#4018100100000000"], "started, and then the first request");
    bench.hear("586#4318100101000000");
    let (frames, answers) = bench.told();
    assert_eq!((frames, answers), (vec!["606#4008100000000000".to_owned()], vec![(first, Ok(vec![1, 0, 0, 0]))]));
    assert!(second > first);
}

#[test]
fn a_device_that_boots_in_the_middle_overtakes_the_request() {
    let mut bench = ManagerBench::up();
    let number = bench.ask(6, DeviceRequest::Read(VENDOR));
    bench.told();
    bench.hear("706#00");
    let (frames, answers) = bench.told();
    assert_eq!(frames, ["606#4000100000000000"], "the boot begins; nothing is aborted, that would end it");
    assert!(matches!(&answers[..], [(n, Err(DeviceRequestError::Overtaken(_)))] if *n == number), "{answers:?}");
    // The answer under way goes to the boot, as an unexpected one: it is not the device type.
    bench.configure(6);
    bench.hear("186#01");
    assert!(bench.manager.inputs(bench.now, CLAMP).valid);
}

#[test]
fn nobody_waits_for_ever_and_not_too_many_wait() {
    let mut bench = ManagerBench::up();
    let number = bench.ask(6, DeviceRequest::Read(VENDOR));
    for _ in 0..WAITING_MAX {
        bench.ask(6, DeviceRequest::Read(VENDOR));
    }
    bench.told();
    let over = bench.ask(6, DeviceRequest::Read(VENDOR));
    assert_eq!(bench.told().1, [(over, Err(DeviceRequestError::Full))]);
    let mut answers = Vec::new();
    for _ in 0..100 {
        bench.pass_with(100, &[4, 5, 6]);
        answers.extend(bench.told().1);
    }
    assert_eq!(answers.len(), WAITING_MAX + 1, "each has its answer");
    assert!(matches!(&answers[0], (n, Err(DeviceRequestError::Transfer(error)))
        if *n == number && matches!(error.cause, TransferFailure::Silent { .. })));
    assert!(answers[1..].iter().any(|(_, answer)| matches!(answer, Err(DeviceRequestError::Waited(_)))));
    assert!(bench.manager.next_deadline().unwrap() > bench.now);
    // Another device's requests are not held up by this one's.
    bench.ask(6, DeviceRequest::Read(VENDOR));
    bench.ask(4, DeviceRequest::Read(VENDOR));
    assert!(bench.told().0.contains(&"604#4018100100000000".to_owned()));
}

#[test]
fn who_cannot_answer_is_not_asked() {
    let mut bench = ManagerBench::up();
    bench.ask(99, DeviceRequest::Read(VENDOR));
    assert_eq!(bench.told().1[0].1, Err(DeviceRequestError::UnknownNode { node: 99 }));
    bench.hear("706#04");
    bench.told();
    bench.ask(6, DeviceRequest::Read(VENDOR));
    let (frames, answers) = bench.told();
    let text = answers[0].1.as_ref().unwrap_err().to_string();
    assert!(frames.is_empty() && text.contains("stopped by somebody else"), "{text}");
    bench.pass_with(300, &[4, 5]);
    bench.told();
    bench.ask(6, DeviceRequest::Read(VENDOR));
    let text = bench.told().1[0].1.as_ref().unwrap_err().to_string();
    assert!(text.contains("no heartbeat (1017h)"), "{text}");
}

#[test]
fn a_reset_is_sent_and_takes_its_owners_outputs_along_once_the_device_boots() {
    let mut bench = ManagerBench::up();
    bench.set(DRILL, 0b11);
    bench.take();
    bench.manager.reset_node(bench.now, node(4), &mut bench.out);
    assert_eq!(bench.frames(), ["000#8104"]);
    bench.hear("704#00");
    assert!(bench.frames().contains(&"205#00".to_owned()), "the drill's other device lets go");
    assert!(!bench.inputs(DRILL).valid);
    let status = bench.manager.statuses().find(|status| status.node == node(4)).unwrap();
    assert_eq!((status.condition, status.losses, status.nmt), (DeviceCondition::Booting, 1, Some(NmtState::BootUp)));
}

#[test]
fn the_state_is_what_the_last_heartbeat_said_and_none_once_there_is_none() {
    let nmt = |bench: &ManagerBench| bench.manager.statuses().find(|status| status.node == node(6)).unwrap().nmt;
    // Found pre-operational, or booting: refused either way.
    for first in ["706#7F", "706#00"] {
        let mut bench = ManagerBench::new();
        assert_eq!(nmt(&bench), None);
        bench.hear(first);
        let said = if first == "706#00" { NmtState::BootUp } else { NmtState::PreOperational };
        assert_eq!(nmt(&bench), Some(said));
        bench.hear("586#4300100091010300");
        bench.hear("586#8017100000000106");
        bench.hear("706#7F");
        let status = bench.manager.statuses().find(|status| status.node == node(6)).unwrap();
        assert_eq!((status.condition, status.nmt), (DeviceCondition::Refused, Some(NmtState::PreOperational)));
        bench.pass_with(100, &[4]);
        bench.hear("706#04");
        assert_eq!(nmt(&bench), Some(NmtState::Stopped));
        bench.pass(200);
        assert_eq!(nmt(&bench), None, "silent");
        // It falls silent in the middle of its boot: nothing is lost, and still it reports nothing.
        bench.hear("706#00");
        assert_eq!(nmt(&bench), Some(NmtState::BootUp));
        (0..100).for_each(|_| bench.pass(50));
        let status = bench.manager.statuses().find(|status| status.node == node(6)).unwrap();
        assert_eq!((status.condition, status.nmt), (DeviceCondition::Absent, None));
    }
}

#[test]
fn only_a_device_that_somebody_stopped_is_started_by_request() {
    let mut bench = ManagerBench::up();
    let start = |bench: &mut ManagerBench| {
        let said = bench.manager.start_node(bench.now, node(6), &mut bench.out);
        (said, bench.frames())
    };
    let (said, frames) = start(&mut bench);
    assert!(said.unwrap().starts_with("operational") && frames.is_empty());
    bench.hear("706#04");
    bench.frames();
    let woken = vec!["000#8006".to_owned(), "606#4000100000000000".to_owned()];
    assert_eq!(start(&mut bench), (Ok("woken, to be configured and started".to_owned()), woken));
    bench.configure(6);
    assert_eq!(bench.frames().last().map(String::as_str), Some("000#0106"));
    bench.hear("706#05");
    bench.frames();
    bench.hear("706#00");
    bench.frames();
    let (said, frames) = start(&mut bench);
    assert!(said.unwrap_err().starts_with("being identified") && frames.is_empty());
    // Refused: it is looked at again, from the beginning.
    bench.hear("586#4300100091010300");
    bench.hear("586#8017100000000106");
    bench.frames();
    let (said, frames) = start(&mut bench);
    assert!(said.unwrap_err().contains("is being looked at again"));
    assert_eq!(frames, ["606#4000100000000000"]);
}

#[test]
fn requests_one_after_the_other_do_not_keep_an_error_from_being_looked_at() {
    let mut bench = ManagerBench::up();
    bench.hear("086#1023050000000000");
    bench.told();
    let mut reads = 0;
    for _ in 0..60 {
        // There is always one under way and one that waits.
        bench.ask(6, DeviceRequest::Read(VENDOR));
        bench.ask(6, DeviceRequest::Read(VENDOR));
        for node in [4, 5, 6] {
            bench.hear(&format!("7{node:02X}#05"));
        }
        bench.pass(50);
        while let Some(asked) = bench.told().0.into_iter().rfind(|frame| frame.starts_with("606#40")) {
            let register = asked == "606#4001100000000000";
            reads += u32::from(register);
            bench.hear(if register { "586#4F01100005000000" } else { "586#4318100178563412" });
        }
    }
    assert_eq!(reads, 3, "one a second");
}
