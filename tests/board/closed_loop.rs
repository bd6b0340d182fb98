use system_tests::board_elf::board_elf;
use virtual_board::can::{Frame, Id};
use virtual_board::run::{Firmware, Flow, Options, View, run};

#[test]
fn the_shaft_goes_where_the_bus_commands_it() {
    let firmware = Firmware::read(board_elf()).expect("it was built");
    let mut period = 0_u64;
    let script = move |view: &mut View<'_>| {
        period += 1;
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
    let finished = run(&firmware, Options::for_ms(3000), script).expect("it runs");
    println!("{:?} for {} ns", started.elapsed(), finished.end_ns);
    println!("gaps {}", finished.gaps);
    println!("resets {:?}", finished.resets);
    println!("{:?}", finished.trace.rows.last());
    println!("frames {}", finished.trace.frames.len());
    for sent in finished.trace.frames.iter().take(8) {
        println!("{sent:?}");
    }
    println!("{}", finished.trace.hash());
    assert!(finished.gaps.is_empty(), "{}", finished.gaps);
    let angle_deg = finished.rig.reading().output.angle_deg;
    assert!((angle_deg - 30.0).abs() < 0.5, "{angle_deg}");
}
