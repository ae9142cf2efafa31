//! Numbers in frames, compared with the Python package `cantools`: the same file, the same frames, every signal both
//! ways. Needs `pip install cantools` and a Python named by `LINEWRIGHT_PYTHON`; without it nothing is tested.

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

use linewright_dbc::{Mux, read};
use linewright_line::FrameField;

/// Reads the file, then lines of a message, its bytes in hexadecimal, a signal, and what it is worth in them.
const SCRIPT: &str = r#"
import sys, cantools
text, count = sys.stdin.read().split("\n---\n"), 0
for part in range(0, len(text) - 1, 2):
    database = cantools.database.load_string(text[part], "dbc")
    for line in text[part + 1].splitlines():
        message, data, signal, value = line.split()
        found = database.get_message_by_name(message).decode(bytes.fromhex(data), decode_choices=False)[signal]
        if found != float(value):
            sys.exit(f"{line}: cantools has {found!r}")
        count += 1
print(count)
"#;

/// Numbers that look random and are the same every time.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }
}

/// A file of messages with a signal each, of any place, size and byte order.
fn any_file(draw: &mut Draw) -> String {
    let mut text = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: A B\n\n".to_owned();
    for message in 0..200u64 {
        let id = if message % 2 == 0 { message + 1 } else { 0x8000_0000 + 0x1000_0000 + message };
        let (start, size, motorola) = loop {
            let (start, size, motorola) = (draw.below(64), 1 + draw.below(64), draw.below(2) == 0);
            let first = if motorola { start / 8 * 8 + 7 - start % 8 } else { start };
            if first + size <= 64 {
                break (start, size, motorola);
            }
        };
        let order = u8::from(!motorola);
        let sign = if draw.below(2) == 0 { '+' } else { '-' };
        let _ = writeln!(text, "BO_ {id} M{message}: 8 A");
        let _ = writeln!(text, " SG_ S{message} : {start}|{size}@{order}{sign} (1,0) [0|0] \"\" B\n");
    }
    text
}

#[test]
fn every_signal_is_worth_the_same() {
    let Ok(python) = std::env::var("LINEWRIGHT_PYTHON") else {
        println!("SKIPPED: no LINEWRIGHT_PYTHON; the comparison with cantools needs one that has it");
        return;
    };
    let has_it = Command::new(&python).args(["-c", "import cantools"]).stderr(Stdio::null()).status();
    if !has_it.is_ok_and(|status| status.success()) {
        println!("SKIPPED: {python} has no cantools");
        return;
    }
    let mut draw = Draw(0x5EED_1234_5678_9ABC);
    let gauge = include_str!("gauge.dbc").to_owned();
    let mut asked = String::new();
    let mut count = 0;
    for file in [gauge, any_file(&mut draw), any_file(&mut draw)] {
        let database = read(file.as_bytes()).expect("a sound file");
        let _ = write!(asked, "{file}\n---\n");
        for message in &database.messages {
            for _ in 0..20 {
                let mut data = draw.next().to_le_bytes();
                let selector = message.signals.iter().find(|signal| signal.mux == Mux::Selector);
                if let Some(field) = selector.and_then(|selector| selector.field) {
                    field.put(&mut data, draw.below(2));
                }
                for signal in &message.signals {
                    let field: FrameField = signal.field.expect("it lies in its frame");
                    let there = match (&signal.mux, selector.and_then(|selector| selector.field)) {
                        (Mux::Selected(values), Some(selector)) => {
                            values.iter().any(|(first, last)| (*first..=*last).contains(&selector.get(&data)))
                        }
                        _ => true,
                    };
                    let value = field.value(field.get(&data));
                    // More digits than a double has, both sides round in their own way; NaN is equal to nothing.
                    if !there || !value.is_finite() || value.abs() > 2f64.powi(52) {
                        continue;
                    }
                    let bytes: String =
                        data.iter().take(message.len as usize).map(|byte| format!("{byte:02x}")).collect();
                    let _ = writeln!(asked, "{} {bytes} {} {value:?}", message.name, signal.name);
                    count += 1;
                }
            }
        }
        asked.push_str("---\n");
    }
    let mut child = Command::new(python)
        .args(["-c", SCRIPT])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the Python that LINEWRIGHT_PYTHON names");
    child.stdin.take().expect("a pipe").write_all(asked.as_bytes()).expect("it reads");
    println!("{count} numbers compared");
    let said = child.wait_with_output().expect("it ends");
    assert!(said.status.success(), "cantools does not agree");
    assert_eq!(String::from_utf8_lossy(&said.stdout).trim(), count.to_string());
}
