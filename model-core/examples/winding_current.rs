//! Prints the winding's current of the board plant as CSV: stalled and turning, at duties of both
//! signs. `assurance/circuit/compare.py` holds it against a circuit simulation.

use model_core::plant::board::{BoardPlant, BoardPlantOptions, Bridge, Slot};

/// PWM periods until the rate is steady: six mechanical time constants of 132 ms.
const SETTLING_PERIODS: i32 = 800;

/// A control period: the mean current, and the currents at the sample and at the scan, A.
fn control_period(plant: &mut BoardPlant, bridge: Bridge) -> [f64; 3] {
    let current = bridge.current_instant();
    let (mut charge, mut length_ns) = (0.0, 0);
    let (mut sampled_a, mut scan_a) = (0.0, 0.0);
    for period in 0..4 {
        for slot in Slot::ALL {
            let is_open = period == 3 && matches!(slot, Slot::Legs | Slot::Edge);
            let state = if is_open { Bridge::Coast } else { bridge };
            let mean_a = plant.advance(state, slot, current);
            charge += mean_a * slot.length_ns(current) as f64;
            length_ns += slot.length_ns(current);
            match slot {
                Slot::Current => sampled_a = plant.motor_current_a(),
                Slot::Legs => scan_a = plant.motor_current_a(),
                _ => {}
            }
        }
    }
    [charge / length_ns as f64, sampled_a, scan_a]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("compare,back_emf_v,mean_a,sampled_a,scan_a");
    for percent in [10, 20, 30, 50, 80, 100] {
        // Stalled, turning without load, and turning against a load of a third of the stall torque.
        for (is_jammed, torque_nm) in [(true, 0.0), (false, 0.0), (false, -0.3)] {
            for sign in [1, -1] {
                let mut options = BoardPlantOptions::default();
                options.drivetrain.gear_train.hard_stop_deg = 32_000.0;
                let mut plant = BoardPlant::try_new(&options)?;
                plant.defects.is_jammed = is_jammed;
                plant.defects.torque_nm = torque_nm * f64::from(sign);
                let compare = 560 * percent * sign;
                let bridge = Bridge::driven(compare);
                for _ in 0..SETTLING_PERIODS / 4 {
                    control_period(&mut plant, bridge);
                }
                let back_emf_v = plant.reading().back_emf_v;
                let [mean_a, sampled_a, scan_a] = control_period(&mut plant, bridge);
                println!("{compare},{back_emf_v},{mean_a},{sampled_a},{scan_a}");
            }
        }
    }
    Ok(())
}
