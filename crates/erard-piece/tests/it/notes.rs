//! tmp
use erard::keyboard::Keyboard;
use erard_midi::{Law, Velocity, file::{Note, Piece}};
use erard_piece::{Options, Score, Silence, perform};

fn go(key: usize, notes: Vec<Note>, show: bool) {
    let kb = Keyboard::builtin("concert-grand-strings").unwrap();
    let instruments = kb.instruments().unwrap();
    let score = Score::of(&Piece { notes, ..Piece::default() }, &Law::GOEBL);
    let t = std::time::Instant::now();
    let p = perform(&score, &instruments, &Options { threads: 1, ..Options::default() }, &|_| Ok(Box::new(Silence)), &mut |_| true).unwrap();
    println!("key {key} {:?} {:?} steps {} = {:.2} us; music {:.1} s", t.elapsed(), p.dampers, p.steps, t.elapsed().as_secs_f64() / p.steps as f64 * 1e6, score.duration_s);
    if show { for n in &p.notes {
        println!("{:.3} v {:5.1} F {:6.2} pressed {:.3} late {:?} louder {:?} home {} trials {} off {:+.1?} faults {:?} {}", n.wanted.on_s, n.wanted.velocity.counts(), n.force_n, n.pressed_s, n.late_s().map(|x| (x*1e5).round()/100.0), n.louder().map(|x| (x*100.0).round()/100.0), n.from_home, n.trials, n.released.map(|r| 1e3*(r[0]-n.wanted.off_s)), n.faults(), n.reasons().iter().map(|r| r.to_string()).collect::<Vec<_>>().join("; "));
    } }
    println!("{:?}", p.summary());
}

#[test]
fn tmp() {
    let v = |n: u8| Velocity::of_seven_bits(n);
    for key in [4, 40, 80] {
    let mut notes = vec![];
    for (i, vel) in [10u8, 20, 40, 60, 80, 100, 115, 127, 60, 61, 45].iter().enumerate() {
        notes.push(Note { key, start_s: i as f64 * 1.2, end_s: i as f64 * 1.2 + 0.5, velocity: v(*vel), release: None });
    }
    go(key, notes, true);
    }
    for key in [40] {
    let mut notes = vec![];
    let mut t = 0.0;
    for i in 0..40 {
        let p = [0.4, 0.3, 0.2, 0.15, 0.12, 0.1, 0.08, 0.07][i / 5];
        notes.push(Note { key, start_s: t, end_s: t + 0.5 * p, velocity: v(70), release: None });
        t += p;
    }
    go(key, notes, true);
    }
}
#[test]
fn hanon() {
    for kb in ["concert-grand-strings", "heavy-touch"] {
    let instruments = Keyboard::builtin(kb).unwrap().instruments().unwrap();
    let piece = erard_midi::file::read(&std::fs::read("pieces/hanon.mid").unwrap()).unwrap();
    let score = Score::of(&piece, &Law::GOEBL);
    let t = std::time::Instant::now();
    let p = perform(&score, &instruments, &Options { threads: 1, ..Options::default() }, &|_| Ok(Box::new(Silence)), &mut |_| true).unwrap();
    println!("{kb} {:?} steps {}", t.elapsed(), p.steps);
    for n in p.notes.iter().take(100).filter(|n| !n.faults().is_empty()) {
        println!("{:.3} key {} v {:5.1} F {:6.2} pressed {:.3} late {:?} louder {:?} home {} trials {} off {:+.1?} faults {:?} {}", n.wanted.on_s, n.wanted.key, n.wanted.velocity.counts(), n.force_n, n.pressed_s, n.late_s().map(|x| (x*1e5).round()/100.0), n.louder().map(|x| (x*100.0).round()/100.0), n.from_home, n.trials, n.released.map(|r| 1e3*(r[0]-n.wanted.off_s)), n.faults(), n.reasons().iter().map(|r| r.to_string()).collect::<Vec<_>>().join("; "));
    }
    println!("{:?}", p.summary());
    }
}
