//! The readers of cases and of checkpoints, fed with what nobody would write. The gate tries a few
//! hundred inputs; `PROPTEST_CASES=1000000 cargo test --release --test suite fuzz -- --nocapture` a
//! million of each.

use crate::allocation::largest;
use crate::support::{Petsc, box_case, petsc, shipped, thread_time};
use mics::archive::{Archive, Checkpointed};
use mics::config::load;
use mics::output::checkpoint::{FORMAT, Header, newest, open, path};
use mics::output::measure::{self, Sample};
use mics::output::{Marks, measure::Series};
use mics::run::{Account, Written};
use mics::scene::Scene;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use std::cell::{Cell, RefCell};
use std::time::Duration;

/// Bytes that a reader may allocate at once, over what it was given.
const ROOM: usize = 1 << 20;
/// Bytes for a case's reader, which sorts the bodies of a swarm into a million cells at most.
const ROOM_FOR_SWARMS: usize = 32 << 20;

/// As many inputs as PROPTEST_CASES says, or a few, the same every time unless PROPTEST_RNG_SEED
/// has others; failures are shown, not kept in files.
fn runner() -> TestRunner {
    let given = Config::default();
    let rng_seed = match given.rng_seed {
        RngSeed::Random => RngSeed::Fixed(1),
        fixed => fixed,
    };
    TestRunner::new(Config { failure_persistence: None, rng_seed, ..given })
}

/// Numbers that break things.
const NUMBERS: [u64; 12] = [
    0,
    1,
    u64::MAX,
    1 << 63,
    1 << 40,
    0x7ff0_0000_0000_0000,
    0x7ff8_0000_0000_0000,
    0xfff0_0000_0000_0000,
    0x7fef_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0x3ff0_0000_0000_0000,
    0x4340_0000_0000_0000,
];

/// A change of some bytes: where (of the length), and what becomes of them.
#[derive(Clone, Debug)]
enum Change {
    Flip(f64, u8),
    Number(f64, usize),
    Cut(f64),
    Put(f64, Vec<u8>),
    Repeat(f64, f64),
}

fn change() -> impl Strategy<Value = Change> {
    let at = || 0.0..1.0;
    prop_oneof![
        (at(), any::<u8>()).prop_map(|(at, bits)| Change::Flip(at, bits)),
        (at(), 0..NUMBERS.len()).prop_map(|(at, which)| Change::Number(at, which)),
        // Lengths and labels stand at the start.
        (0.0..0.05, 0..NUMBERS.len()).prop_map(|(at, which)| Change::Number(at, which)),
        at().prop_map(Change::Cut),
        (at(), prop::collection::vec(any::<u8>(), 1..40))
            .prop_map(|(at, bytes)| Change::Put(at, bytes)),
        (at(), 0.0..0.1).prop_map(|(at, part)| Change::Repeat(at, part)),
    ]
}

impl Change {
    fn make(&self, bytes: &mut Vec<u8>) {
        let n = bytes.len();
        let place = |at: f64| ((at * n as f64) as usize).min(n.saturating_sub(1));
        match self {
            _ if n == 0 => {}
            Change::Flip(at, bits) => bytes[place(*at)] ^= bits,
            Change::Number(at, which) => {
                // Most of a archive stands at multiples of eight, after a text of any length.
                let at = place(*at);
                let end = n.min(at + 8);
                bytes[at..end].copy_from_slice(&NUMBERS[*which].to_le_bytes()[..end - at]);
            }
            Change::Cut(at) => bytes.truncate(place(*at)),
            Change::Put(at, more) => {
                drop(bytes.splice(place(*at)..place(*at), more.iter().copied()))
            }
            Change::Repeat(at, part) => {
                let from = place(*at);
                let to = n.min(from + (part * n as f64) as usize);
                bytes.extend_from_within(from..to);
            }
        }
    }
}

/// A scene with a bit of all that lasts, and what else a checkpoint holds.
struct Whole {
    header: Header,
    account: Account,
    written: Written,
    series: Vec<Series>,
    marks: Marks,
    scene: Scene<2>,
}

impl Whole {
    fn serialize(&mut self, archive: &mut Archive) -> mics::Result<()> {
        self.header.serialize(archive)?;
        self.account.serialize(archive)?;
        self.written.serialize(archive)?;
        archive.each("measures", &mut self.series)?;
        self.marks.serialize(archive)?;
        self.scene.state.serialize(&self.scene.domain.grid, archive)
    }

    fn of(petsc: &Petsc, wall: &str) -> Whole {
        let disc = |x: f64| {
            format!(
                "[[particle]]\nshape = {{ disc = {{ diameter = 0.3 }} }}\n\
                position = [{x:?}, 0.5]\nvelocity = [0.3, 0.1]\ndensity = 2.0\n"
            )
        };
        let more = format!(
            "{}{}[contact]\nnormal_stiffness = 100.0\nfriction = 0.5\n[[measure]]\nname = \"a\"\n\
            kind = \"spin\"\n[coupling]\nwall = \"{wall}\"",
            disc(0.4),
            disc(0.702)
        );
        let sides = ["\"periodic\"", "\"periodic\"", "\"wall\"", "\"slip\""];
        let text = box_case([1.2, 1.0], [12, 10], 0.05, sides, &more);
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("case.toml");
        std::fs::write(&file, &text).unwrap();
        let case = load(&file, &[]).unwrap().case;
        let mut scene = petsc.scene(&text);
        let mut series = measure::series(&case);
        for k in 0..5 {
            scene.step(2e-3).unwrap();
            let (exchange, bodies) = (&scene.state.exchange[..], &scene.state.bodies[..]);
            series[0].sample(
                &Sample {
                    time: f64::from(k),
                    exchange,
                    bodies,
                    max_speed: 1.0,
                    deepest: 0.0,
                    contacts: &[],
                },
                0.0,
            );
        }
        let account = Account { began: "today".into(), dt: Some(2e-3), ..Account::default() };
        let written = Written { fields: Some(0.0), rows: None };
        let marks = Marks::at(1000, vec![(0.0, 0), (0.01, 5)]);
        let header = Header { case: text, ..Header::default() };
        Whole { header, account, written, series, marks, scene }
    }
}

/// Numbers of inputs that were taken and refused, and the time of the slowest.
#[derive(Default)]
struct Outcomes {
    taken: Cell<u32>,
    refused: Cell<u32>,
    slowest: Cell<Duration>,
}

impl Outcomes {
    fn count<T>(&self, result: &mics::Result<T>, started: Duration) {
        let counter = if result.is_ok() { &self.taken } else { &self.refused };
        counter.set(counter.get() + 1);
        self.slowest.set(self.slowest.get().max(thread_time() - started));
    }

    fn show(&self, name: &str) {
        let (taken, refused, slowest) = (self.taken.get(), self.refused.get(), self.slowest.get());
        println!("{name}: {taken} taken, {refused} refused; the slowest took {slowest:?}");
        assert!(taken > 0 && refused > 0, "{name}: {taken} taken, {refused} refused");
    }
}

#[test]
fn random_checkpoint_bytes_are_run_or_refused() {
    let petsc = petsc();
    for wall in ["sharp", "mixing"] {
        let whole = RefCell::new(Whole::of(&petsc, wall));
        let mut bytes = Vec::new();
        let mut archive = Archive::write(&petsc.session, &mut bytes);
        whole.borrow_mut().serialize(&mut archive).unwrap();
        archive.finish().unwrap();
        let outcomes = Outcomes::default();
        let outcome = runner().run(&prop::collection::vec(change(), 0..4), |changes| {
            let mut bytes = bytes.clone();
            changes.iter().for_each(|change| change.make(&mut bytes));
            largest();
            let (started, mut whole) = (thread_time(), whole.borrow_mut());
            let mut rest = &bytes[..];
            let mut archive = Archive::read(&petsc.session, &mut rest);
            let result = whole
                .serialize(&mut archive)
                .and_then(|()| archive.finish())
                .and_then(|()| whole.scene.resume());
            outcomes.count(&result, started);
            let most = largest();
            prop_assert!(
                most <= 4 * bytes.len() + ROOM,
                "{most} bytes at once for {} bytes",
                bytes.len()
            );
            Ok(())
        });
        outcome.unwrap_or_else(|e| panic!("{wall}: {e}"));
        outcomes.show(&format!("checkpoints, {wall}"));
    }
}

#[test]
fn checkpoint_with_foreign_content_is_refused() {
    let run = tempfile::tempdir().unwrap();
    std::fs::create_dir(run.path().join("checkpoint")).unwrap();
    let petsc = petsc();
    let begin = |format: u32| [&b"mics\0ckp"[..], &format.to_le_bytes()].concat();
    let begins = prop_oneof![Just(vec![]), Just(begin(FORMAT - 1)), Just(begin(FORMAT))];
    let parts = (begins, prop::collection::vec(any::<u8>(), 0..200), any::<bool>());
    let outcome = runner().run(&parts, |(head, rest, sealed)| {
        let (right, mut bytes) = (head == begin(FORMAT), [head, rest].concat());
        if sealed {
            bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        }
        std::fs::write(path(run.path(), 7), &bytes).unwrap();
        largest();
        prop_assert_eq!(newest(run.path()).is_ok(), right && sealed);
        if let Ok(mut archive) = open(run.path(), 7) {
            let played =
                Header::default().serialize(&mut Archive::read(&petsc.session, &mut archive));
            prop_assert!(played.is_err() || !sealed);
        }
        let most = largest();
        prop_assert!(most <= ROOM, "{most} bytes at once");
        Ok(())
    });
    outcome.unwrap_or_else(|e| panic!("{e}"));
}

/// Replacements of a word or a number of a case.
const WORDS: [&str; 24] = [
    "-1",
    "0",
    "1",
    "0.0",
    "-0.0",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "1e-308",
    "9223372036854775807",
    "1e999",
    "[]",
    "{}",
    "\"\"",
    "\"wall\"",
    "true",
    "[[1]]",
    "[1.0, 1.0]",
    "[1, 2, 3]",
    "{ a = 1 }",
    "=",
    "\u{1F300}",
    "1979-05-27",
];

#[test]
fn random_case_text_is_read_or_refused() {
    let names = [
        "cylinder-wake",
        "crowd",
        "settling-disc",
        "oscillating-cylinder",
        "wall-fall",
        "sphere-stream",
        "lid-driven-cavity",
    ];
    let texts: Vec<String> = names
        .iter()
        .map(|name| std::fs::read_to_string(shipped(&format!("cases/{name}/case.toml"))).unwrap())
        // Placing a crowd takes as long as it takes.
        .map(|text| text.replace("count = 300", "count = 20"))
        .collect();
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("case.toml");
    let word =
        (0.0..1.0, 0..WORDS.len()).prop_map(|(at, which)| (at, Some(which), Change::Cut(1.0)));
    let bytes = change().prop_map(|change| (0.0, None, change));
    let changes = prop::collection::vec(prop_oneof![3 => word, 1 => bytes], 0..4);
    let set = prop::option::of(("[a-z]{1,8}(\\.[a-z0-9]{1,8}){0,3}", 0..WORDS.len()));
    let outcomes = Outcomes::default();
    let outcome = runner().run(&(0..texts.len(), changes, set), |(which, changes, set)| {
        let mut bytes = texts[which].clone().into_bytes();
        for (at, word, change) in changes {
            let Some(word) = word else {
                change.make(&mut bytes);
                continue;
            };
            // A whole word, so that what comes of it often is TOML.
            let is_part = |b: &u8| b.is_ascii_alphanumeric() || b".-_\"".contains(b);
            let at = (at * bytes.len() as f64) as usize;
            let from = bytes[..at].iter().rposition(|b| !is_part(b)).map_or(0, |k| k + 1);
            let to = bytes[at..].iter().position(|b| !is_part(b)).map_or(bytes.len(), |k| at + k);
            bytes.splice(from..to, WORDS[word].bytes());
        }
        std::fs::write(&file, &bytes).unwrap();
        let set: Vec<String> =
            set.map(|(key, word)| format!("{key}={}", WORDS[word])).into_iter().collect();
        largest();
        let started = thread_time();
        let result = load(&file, &set);
        outcomes.count(&result, started);
        let most = largest();
        prop_assert!(
            most <= 16 * bytes.len() + ROOM_FOR_SWARMS,
            "{most} bytes at once for {} bytes",
            bytes.len()
        );
        if let Err(e) = result {
            prop_assert_eq!(e.exit_code(), 2, "{}", e);
        }
        Ok(())
    });
    outcome.unwrap_or_else(|e| panic!("{e}"));
    outcomes.show("cases");
}
