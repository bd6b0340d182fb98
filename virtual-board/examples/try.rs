//! Scratch.
use virtual_board::can::{Frame, Id};
use virtual_board::run::{Firmware, Flow, Options, View, run};
fn main() {
    let firmware = Firmware::read(std::path::Path::new(
        "target/board/thumbv7em-none-eabihf/board/actuator-board",
    ))
    .expect("it was built");
    let mut period = 0_u64;
    let script = move |view: &mut View<'_>| {
        period += 1;
        if period == 2990 {
            let mut n = 0;
            while view.word(0x2000_0000 + 4 * n) == Some(0xcccc_cccc) {
                n += 1;
            }
            println!("untouched {}", 4 * n);
        }
        if period.is_multiple_of(20) {
            let mut data = 30_000_i32.to_le_bytes().to_vec();
            data.push(u8::from(period < 400));
            let frame = Frame::data_frame(Id::Standard(0x201), &data);
            let now_ns = view.now_ns();
            view.port(0).expect("one").send(now_ns, frame);
        }
        Flow::On
    };
    let started = std::time::Instant::now();
    let mut options = Options::for_ms(3000);
    options.probes = vec![
        "DMA2_STREAM0".into(),
        "TIM1_UP_TIM10".into(),
        "TIM1_CC".into(),
    ];
    let finished = run(&firmware, options, script).expect("it runs");
    println!("{:?} for {} ns", started.elapsed(), finished.end_ns);
    println!("gaps {}", finished.gaps);
    println!("resets {:?}", finished.resets);
    println!("{:?}", finished.trace.rows.last());
    println!("frames {}", finished.trace.frames.len());
    for sent in finished.trace.frames.iter().take(8) {
        println!("{sent:?}");
    }
    for sent in finished.trace.frames.iter().rev().take(4) {
        println!("{sent:?}");
    }
    for (name, spans) in &finished.spans {
        println!(
            "{name} {} max {:?} min {:?}",
            spans.len(),
            spans.iter().map(|s| s.instructions).max(),
            spans.iter().map(|s| s.instructions).min()
        );
    }
    println!("{}", finished.trace.hash());
}
