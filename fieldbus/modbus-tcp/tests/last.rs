//! Last orders to devices: outputs off, also where they are refused at first; and their texts.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};

use linewright_line::Table;
use linewright_modbus::ModbusRequest;
use linewright_modbus_tcp::{LastOrder, LastOutcome, send_all};
use linewright_testkit::samples::{listed, samples};

const OFF: ModbusRequest = ModbusRequest::WriteCoils { first: 0, count: 2, bits: 0 };

/// Outcome of a last order to a device that answers orders with these, and the number of orders.
fn outcome_of(order: ModbusRequest, answers: &'static [&'static [u8]]) -> (LastOutcome, usize) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let socket = TcpStream::connect(listener.local_addr().expect("its address")).expect("a connection");
    socket.set_nonblocking(true).expect("it need not wait");
    let (mut device, _) = listener.accept().expect("the connection");
    let serves = std::thread::spawn(move || {
        let mut orders = 0;
        let mut bytes = vec![0; order.adu(0, 1).len()];
        while device.read_exact(&mut bytes).is_ok() {
            let answer = answers.get(orders).copied().unwrap_or_default();
            orders += 1;
            device.write_all(answer).expect("it is read");
        }
        orders
    });
    let last = LastOrder::new(("a device", 1), Some(order));
    last.set(socket);
    let outcome = send_all(std::slice::from_ref(&last))[0];
    last.forget();
    (outcome, serves.join().expect("it ends"))
}

const TAKEN: &[u8] = &[0xFF, 0xFF, 0, 0, 0, 6, 1, 0x0F, 0, 0, 0, 2];
/// By a device that was ordered to write registers.
const FAILED: &[u8] = &[0xFF, 0xFF, 0, 0, 0, 3, 1, 0x90, 4];
const BUSY: &[u8] = &[0xFF, 0xFF, 0, 0, 0, 3, 1, 0x8F, 6];

#[test]
fn an_order_that_is_refused_is_sent_again_and_never_counts_as_taken() {
    assert_eq!(outcome_of(OFF, &[TAKEN]), (LastOutcome::Taken, 1));
    // An answer to an earlier request comes first.
    assert_eq!(
        outcome_of(OFF, &[&[0, 7, 0, 0, 0, 4, 1, 2, 1, 3, 0xFF, 0xFF, 0, 0, 0, 6, 1, 0x0F, 0, 0, 0, 2]]).0,
        LastOutcome::Taken
    );
    assert_eq!(outcome_of(OFF, &[BUSY, BUSY, TAKEN]), (LastOutcome::Taken, 3));
    let (outcome, orders) = outcome_of(OFF, &[BUSY; 20]);
    assert_eq!(outcome, LastOutcome::Refused(6));
    assert!((5..=11).contains(&orders), "{orders}");
    assert_eq!(outcome_of(OFF, &[]), (LastOutcome::Unanswered, 1));
}

#[test]
fn the_function_of_an_answer_is_that_of_the_order() {
    let registers = ModbusRequest::write_bits((Table::HoldingRegisters, 0), 2, 0);
    assert_eq!(outcome_of(registers, &[TAKEN]).0, LastOutcome::Unanswered);
    assert_eq!(outcome_of(registers, &[FAILED; 20]).0, LastOutcome::Refused(4));
}

#[test]
fn all_texts_of_last_orders() {
    let outcomes = samples!(LastOutcome {
        LastOutcome::Taken => LastOutcome::Taken;
        LastOutcome::Unsent => LastOutcome::Unsent;
        LastOutcome::Refused(_) => LastOutcome::Refused(4);
        LastOutcome::Gone => LastOutcome::Gone;
        LastOutcome::Unanswered => LastOutcome::Unanswered;
    });
    let text = |outcome: &LastOutcome| outcome.text("10.0.0.7:502 unit 1").unwrap_or_else(|| "no text".to_owned());
    let listed = listed("last orders", &outcomes, text);
    let expected = "last orders
  Taken: no text
  Unsent: Modbus device 10.0.0.7:502 unit 1 was not sent the order to turn its outputs off; they may be on
  Refused: Modbus device 10.0.0.7:502 unit 1 refuses the order to turn its outputs off: device failure (exception 4); \
they may be on
  Gone: Modbus device 10.0.0.7:502 unit 1 ended the connection before it answered the order to turn its outputs off; \
they may be on
  Unanswered: Modbus device 10.0.0.7:502 unit 1 has not answered the order to turn its outputs off; they may be on
";
    assert_eq!(listed, expected);
}
