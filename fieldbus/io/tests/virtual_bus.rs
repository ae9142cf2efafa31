//! The virtual bus between participants of one process and of several.

use std::time::{Duration, Instant};

use linewright_canopen::Frame;
use linewright_fieldbus::{Bus, BusOptions, Transport};

fn options(dir: &tempfile::TempDir) -> BusOptions {
    BusOptions { transport: Transport::Virtual, dir: Some(dir.path().to_owned()) }
}

fn frame(number: u16) -> Frame {
    Frame::data_frame(0x181, &number.to_le_bytes()).unwrap()
}

async fn within<T>(what: impl Future<Output = T>) -> T {
    tokio::time::timeout(Duration::from_secs(10), what).await.expect("nothing within 10 s")
}

#[tokio::test]
async fn everyone_else_hears_a_frame_once_and_its_sender_does_not() {
    let dir = tempfile::tempdir().unwrap();
    let mut bus: Vec<Bus> = (0..3).map(|_| Bus::open("vcan0", &options(&dir)).unwrap()).collect();
    bus[0].send(&frame(1));
    assert_eq!(within(bus[1].recv()).await.expect("a virtual bus stays"), frame(1));
    assert_eq!(within(bus[2].recv()).await.expect("a virtual bus stays"), frame(1));
    bus[1].send(&frame(2));
    assert_eq!(within(bus[0].recv()).await.expect("a virtual bus stays"), frame(2));
    assert!(tokio::time::timeout(Duration::from_millis(20), bus[0].recv()).await.is_err());
}

#[tokio::test]
async fn buses_of_different_names_do_not_meet() {
    let dir = tempfile::tempdir().unwrap();
    let mut a = Bus::open("can-a", &options(&dir)).unwrap();
    let mut b = Bus::open("can-drill.1", &options(&dir)).unwrap();
    a.send(&frame(1));
    assert!(tokio::time::timeout(Duration::from_millis(20), b.recv()).await.is_err());
}

#[tokio::test]
async fn a_burst_longer_than_any_queue_arrives_complete_and_in_order() {
    let dir = tempfile::tempdir().unwrap();
    let mut sender = Bus::open("vcan0", &options(&dir)).unwrap();
    let mut reader = Bus::open("vcan0", &options(&dir)).unwrap();
    for number in 0..500 {
        sender.send(&frame(number));
    }
    let sending = tokio::spawn(async move {
        // A participant that waits for frames also passes on its backlog.
        let _ = tokio::time::timeout(Duration::from_secs(2), sender.recv()).await;
        sender
    });
    for number in 0..500 {
        assert_eq!(within(reader.recv()).await.expect("a virtual bus stays"), frame(number));
    }
    assert_eq!(sending.await.unwrap().stats().overruns, 0);
}

#[tokio::test]
async fn a_member_that_never_reads_holds_nobody_up() {
    let dir = tempfile::tempdir().unwrap();
    let mut sender = Bus::open("vcan0", &options(&dir)).unwrap();
    let _deaf = Bus::open("vcan0", &options(&dir)).unwrap();
    let mut reader = Bus::open("vcan0", &options(&dir)).unwrap();
    for number in 0..2000 {
        sender.send(&frame(number));
        assert_eq!(within(reader.recv()).await.expect("a virtual bus stays"), frame(number));
    }
    assert!(sender.stats().overruns > 0, "the deaf member's loss is counted");
}

#[tokio::test]
async fn a_newcomer_is_noticed_and_a_dead_one_is_buried() {
    let dir = tempfile::tempdir().unwrap();
    let mut sender = Bus::open("vcan0", &options(&dir)).unwrap();
    // Remains of a killed process: a socket's file without a reader.
    let dead = dir.path().join("vcan0/dead.can");
    drop(std::os::unix::net::UnixDatagram::bind(&dead).unwrap());
    tokio::time::sleep(Duration::from_millis(30)).await;
    sender.send(&frame(1));
    assert!(!dead.exists());
    let mut late = Bus::open("vcan0", &options(&dir)).unwrap();
    let joined = Instant::now();
    let heard = async {
        loop {
            sender.send(&frame(2));
            if let Ok(heard) = tokio::time::timeout(Duration::from_millis(1), late.recv()).await {
                break heard;
            }
        }
    };
    assert_eq!(within(heard).await.expect("a virtual bus stays"), frame(2));
    assert!(joined.elapsed() < Duration::from_millis(500), "noticed after {:?}", joined.elapsed());
}

#[tokio::test]
async fn datagrams_that_are_no_frames_are_counted() {
    let dir = tempfile::tempdir().unwrap();
    let mut bus = Bus::open("vcan0", &options(&dir)).unwrap();
    let path = std::fs::read_dir(dir.path().join("vcan0")).unwrap().next().unwrap().unwrap().path();
    let stranger = std::os::unix::net::UnixDatagram::unbound().unwrap();
    for bad in [&[0u8; 15][..], &[0; 17], &[], &[9; 16]] {
        stranger.send_to(bad, &path).unwrap();
    }
    stranger.send_to(&frame(7).to_bytes(), &path).unwrap();
    assert_eq!(within(bus.recv()).await.expect("a virtual bus stays"), frame(7));
    assert_eq!(bus.stats().malformed, 4);
}

#[tokio::test]
async fn a_member_whose_socket_was_cleaned_away_comes_back() {
    let dir = tempfile::tempdir().unwrap();
    let mut a = Bus::open("vcan0", &options(&dir)).unwrap();
    let mut b = Bus::open("vcan0", &options(&dir)).unwrap();
    std::fs::remove_dir_all(dir.path().join("vcan0")).unwrap();
    let heard = async {
        loop {
            a.send(&frame(1));
            b.send(&frame(2));
            if let Ok(heard) = tokio::time::timeout(Duration::from_millis(5), b.recv()).await {
                break heard;
            }
        }
    };
    assert_eq!(within(heard).await.expect("a virtual bus stays"), frame(1));
}

/// Set in a child process of [`a_killed_process_leaves_nothing_behind`]: the directory of its bus.
const CHILD: &str = "LINEWRIGHT_TEST_CHILD";

/// Not a test of its own: what the child process does, started by the test below.
#[tokio::test]
async fn child_echoes_for_ever() {
    let Some(dir) = std::env::var_os(CHILD) else { return };
    let options = BusOptions { transport: Transport::Virtual, dir: Some(dir.into()) };
    let mut bus = Bus::open("vcan0", &options).unwrap();
    loop {
        let frame = bus.recv().await.expect("a virtual bus stays");
        bus.send(&frame);
    }
}

#[tokio::test]
async fn a_killed_process_leaves_nothing_behind() {
    let dir = tempfile::tempdir().unwrap();
    let mut bus = Bus::open("vcan0", &options(&dir)).unwrap();
    let mut child = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "virtual_bus::child_echoes_for_ever"])
        .env(CHILD, dir.path())
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let echoed = async {
        loop {
            bus.send(&frame(1));
            if let Ok(heard) = tokio::time::timeout(Duration::from_millis(5), bus.recv()).await {
                break heard;
            }
        }
    };
    assert_eq!(within(echoed).await.expect("a virtual bus stays"), frame(1));
    let members = || std::fs::read_dir(dir.path().join("vcan0")).unwrap().count();
    assert_eq!(members(), 2);
    child.kill().unwrap();
    child.wait().unwrap();
    bus.send(&frame(2));
    assert_eq!(members(), 1);
    let stats = bus.stats();
    assert_eq!((stats.send_errors, stats.overruns), (0, 0));
}

#[tokio::test]
async fn frames_reach_the_bus_past_its_first_owner() {
    let dir = tempfile::tempdir().expect("a directory");
    let stuck = Bus::open("vcan0", &options(&dir)).expect("a virtual bus");
    let mut device = Bus::open("vcan0", &options(&dir)).expect("a virtual bus");
    let last = stuck.last_wire().expect("a socket");
    let frame = Frame::data_frame(0x123, &[0, 5]).expect("a frame");
    assert_eq!(std::thread::spawn(move || last.send(&[frame])).join().expect("it ends"), 1);
    assert_eq!(device.recv().await.expect("a virtual bus stays"), frame);
}
