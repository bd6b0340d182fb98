//! The last step: gains from the identified motor, and their verification in the closed loop by
//! what was not used in the identification. What disagrees is reported, and is not stored.

mod design;
mod response;
#[cfg(test)]
mod tests;
mod twin;
mod verify;

use firmware::parameters::{BoardParameters, ObjectValues};
use model_core::control::parameters::ControlParameters;
use model_core::plant::board::BoardPlantOptions;

use self::design::Identified;
use self::response::{LINES, Multisine, Response};
use self::twin::{Record, SIGNALS, Twin};
use self::verify::Motion;
use super::excite::{REST, excite};
use super::resistance::{COLD_DEG_C, COPPER_K, winding_deg_c};
use super::runs::arrive;
use super::samples::real;
use super::{CommissionError, Estimate, Findings, Parameter, Step, record, refuse};
use crate::analysis::linear_models::{Loop, Motor, Timing};
use crate::analysis::loop_gain;
use crate::can::capture::Capture;
use crate::can::client::{Client, ClientError};

pub use design::{LEAST_GAIN_DB, LEAST_PHASE_DEG};
pub use twin::DELAY_S;
pub use verify::Line;

const STEP: Step = Step::Tuning;

/// Greatest frequency of the sweep by that of the crossing: beyond it the shaft hardly moves.
const BEYOND: f64 = 1.3;

/// Noise of the encoder, which smooths its counts, deg: AS5045 data sheet.
const NOISE_DEG: f64 = 0.03;

/// Largest amplitudes of a line and of a step, deg: all lines together stay within 8 deg.
const LINE_DEG: f64 = 2.0;
const STEP_DEG: f64 = 10.0;

/// Least amplitudes, deg: a count of the encoder, and ten.
const LEAST_LINE_DEG: f64 = 0.1;
const LEAST_STEP_DEG: f64 = 1.0;

/// Time of the step, ms.
const STEP_MS: i32 = 500;

/// Half of the way of the moves with feed-forward, mdeg: it lies within the least range.
const WAY_MDEG: i32 = 12_000;

/// The moves need this share of the acceleration that [`Identified::duty_pct`] gives at rest,
/// without friction.
const SHARE: f64 = 0.4;

/// Feed-forward of the whole demand, in thousandths.
const WHOLE: u16 = 1000;

/// Margins of a loop.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Margins {
    /// Phase margin, deg.
    pub phase_deg: f64,
    /// Gain margin, dB.
    pub gain_db: f64,
    /// Frequency of the phase margin, Hz.
    pub crossing_hz: f64,
}

impl Margins {
    /// Those of a sampled loop; `None` of one that is not stable.
    fn of(motor: &Motor, control: &ControlParameters, timing: &Timing) -> Option<Self> {
        let margins = loop_gain::Margins::of(&Loop::sampled(motor, control, timing).ok()?);
        let phase = margins.phase_deg.filter(|_| margins.stable)?;
        Some(Self {
            phase_deg: phase.value.abs(),
            gain_db: margins.gain_db?.value.abs(),
            crossing_hz: phase.frequency_hz,
        })
    }
}

/// Gains that are proposed, and how the loop with them was measured.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Proposal {
    /// The objects of the gains, and their values.
    pub gains: Vec<(&'static str, f64)>,
    /// Bandwidth from command to angle, Hz, if the gain falls to half power.
    pub bandwidth_hz: Option<f64>,
    /// Margins of the identified motor.
    pub predicted: Margins,
    /// Least margins of all motors within three standard errors.
    pub least: Margins,
    /// Margins with the motor as the sweep shows it.
    pub measured: Option<Margins>,
    /// The lines of the sweep.
    pub lines: Vec<Line>,
    /// The step.
    pub step: Option<Motion>,
    /// The moves with feed-forward; `None` where the model is contradicted.
    pub moves: Option<Motion>,
}

impl Proposal {
    /// The margins with their names.
    pub fn margins(&self) -> [(&'static str, Option<Margins>); 3] {
        [
            ("predicted", Some(self.predicted)),
            ("least of all motors", Some(self.least)),
            ("by the sweep", self.measured),
        ]
    }
}

/// The result of the tuning.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Tuning {
    /// What is proposed, if anything is.
    pub proposal: Option<Proposal>,
    /// Why the gains are not stored; empty if they are.
    pub disagreements: Vec<String>,
    /// Why the feed-forward is not stored, if it is not.
    pub without_forward: Option<String>,
}

impl Tuning {
    /// The objects that are stored, and their values.
    pub fn objects(&self) -> Vec<(&'static str, f64)> {
        let proposal = self
            .proposal
            .iter()
            .filter(|_| self.disagreements.is_empty());
        let mut objects: Vec<_> = proposal.flat_map(|p| p.gains.clone()).collect();
        if !objects.is_empty() && self.without_forward.is_none() {
            objects.extend(FORWARD);
        }
        objects
    }

    fn refused(why: String) -> Self {
        Self {
            proposal: None,
            disagreements: vec![why],
            without_forward: Some("the gains are not stored".into()),
        }
    }
}

/// Half a count of quantisation, and a count of noise, mdeg: within it the duty at rest would
/// change its sign with the noise of the encoder.
const DEAD_BAND_MDEG: u16 = 132;

/// The feed-forward of velocity and model, and the dead band at rest.
const FORWARD: [(&str, f64); 3] = [
    ("2013:1", WHOLE as f64),
    ("2013:2", WHOLE as f64),
    ("2013:3", DEAD_BAND_MDEG as f64),
];

/// A parameter of the loop.
type Field = fn(&mut ControlParameters) -> &mut f64;

/// The objects of the gains.
const GAINS: [(&str, Field); 4] = [
    ("60FB:1", |control| &mut control.position_gain),
    ("60F9:1", |control| &mut control.proportional_gain),
    ("60F9:2", |control| &mut control.integral_gain),
    ("60F9:3", |control| &mut control.anti_windup_gain),
];

/// The objects of what else acts in the linear loop, and of its limits.
const OTHERS: [(&str, Field); 6] = [
    ("60F9:4", |control| &mut control.feed_forward_gain),
    ("60F9:5", |control| &mut control.rate_filter),
    ("60F9:6", |control| &mut control.duty_limit_pct),
    ("60F9:7", |control| &mut control.duty_slew_pct_s),
    ("60FB:2", |control| &mut control.rate_command_limit_up_deg_s),
    ("60FB:3", |control| {
        &mut control.rate_command_limit_down_deg_s
    }),
];

/// The objects that the tuning changes.
pub fn changed() -> impl Iterator<Item = &'static str> {
    let gains = GAINS.into_iter().map(|(object, _)| object);
    let model = [
        "2011:1", "2011:2", "2011:4", "2011:5", "2011:6", "6083", "6084",
    ];
    let forward = FORWARD.into_iter().map(|(object, _)| object);
    gains.chain(model).chain(forward)
}

/// Proposes gains for what was found, and verifies them. The drive is off afterwards, with the
/// gains, 2011h, 2013h, 6083h and 6084h as they were verified.
///
/// # Errors
/// [`CommissionError`]; gains that cannot be found, and a loop that disagrees with its prediction,
/// are no errors.
pub fn tune(client: &mut Client, findings: &Findings) -> Result<Tuning, CommissionError> {
    let mut contradictions = findings.dynamics.contradictions.iter();
    let contradicts = |parameter| matches!(parameter, Parameter::Inertia | Parameter::Delay);
    if let Some(found) = contradictions.find(|found| contradicts(found.parameter)) {
        let why = format!("no gains follow from what is contradicted: {}", found.text);
        return Ok(Tuning::refused(why));
    }
    client.quick_stop()?;
    let ratio = real(client, "2011:3")?;
    let identified = identified(client, findings, ratio)?;
    let present = control(client)?;
    let Some(design) = identified.fastest(&present) else {
        let why = format!(
            "no gains give {LEAST_PHASE_DEG:.0} deg and {LEAST_GAIN_DB:.1} dB for all motors within \
             three standard errors"
        );
        return Ok(Tuning::refused(why));
    };
    let mut proposed = design.control;
    let gains = GAINS.map(|(object, field)| (object, *field(&mut proposed)));
    write(client, &findings.objects())?;
    write(client, &gains)?;
    write(client, &FORWARD.map(|(object, _)| (object, 0.0)))?;
    // The winding of the twin has 25 deg C for its limit, and the resistance of the warm one.
    let warm = identified.resistance_ohm.value / findings.resistance_ohm.value;
    let mut twin = Twin {
        plant: plant(&identified, findings, ratio),
        control: control(client)?,
        values: values(client, identified.most_a * warm)?,
    };
    let predicted = Margins::of(
        &identified.motor([0.0; 5]),
        &twin.control,
        &identified.timing(0.0),
    );
    let least = identified.least(&twin.control);
    let Some((predicted, least)) = predicted.zip(least) else {
        return refuse(STEP, "the rounded gains have no margins");
    };
    let centre_mdeg = findings.range_mdeg.0.midpoint(findings.range_mdeg.1);
    let lines = sweep(client, centre_mdeg, &identified, &mut twin, &predicted)?;
    let measured = verify::margins(&identified, &twin, &lines, predicted.crossing_hz);
    let mut disagreements = verify::of_sweep(&lines, &predicted, measured.as_ref());
    // What disagrees with its prediction moves no further.
    let mut stepped = None;
    if disagreements.is_empty() {
        let step = step(client, centre_mdeg, &identified, &twin)?;
        disagreements.extend(step.disagreement("a step"));
        stepped = Some(step);
    }
    let contradiction = findings.dynamics.contradictions.first();
    let (moves, without_forward) = match contradiction {
        Some(found) => (
            None,
            Some(format!("the model is contradicted: {}", found.text)),
        ),
        None if !disagreements.is_empty() => (None, Some("the gains are not verified".into())),
        None => {
            let moves = moves(client, centre_mdeg, &identified, &mut twin)?;
            let disagreement = moves.disagreement("moves with feed-forward");
            (Some(moves), disagreement)
        }
    };
    client.quick_stop()?;
    Ok(Tuning {
        proposal: Some(Proposal {
            gains: gains.to_vec(),
            bandwidth_hz: design.bandwidth_hz,
            predicted,
            least,
            measured,
            lines: lines.to_vec(),
            step: stepped,
            moves,
        }),
        disagreements,
        without_forward,
    })
}

/// What the loop depends on, at the present temperature and supply.
fn identified(
    client: &mut Client,
    findings: &Findings,
    ratio: f64,
) -> Result<Identified, CommissionError> {
    let warm = 1.0 + COPPER_K * (winding_deg_c(client)? - COLD_DEG_C);
    let at_rest_v = client.integer("6079")? as f64 * 1e-3;
    let permille = client.integer("6072")?.min(client.integer("6073")?);
    let rated_ma = client.integer("6075")?;
    let super::Friction { upward, downward } = findings.friction;
    Ok(Identified {
        most_a: permille as f64 * rated_ma as f64 * 1e-6,
        resistance_ohm: findings.resistance_ohm.over(1.0 / warm),
        inductance_h: findings.inductance_h,
        v_s_rad: findings.torque_constant_nm_a.over(1.0 / ratio),
        inertia_kg_m2: findings.dynamics.inertia_kg_m2,
        viscous_nm_s: upward.viscous_nm_s.mean(downward.viscous_nm_s),
        delay_s: findings.dynamics.delay_s,
        supply_v: Estimate {
            value: at_rest_v.midpoint(findings.least_supply_v),
            standard_error: (at_rest_v - findings.least_supply_v).abs() / 2.0 / design::REACH,
        },
    })
}

/// The model of the identified motor.
fn plant(identified: &Identified, findings: &Findings, ratio: f64) -> BoardPlantOptions {
    let mut plant = BoardPlantOptions::default();
    plant.encoder.encoder_noise_deg = NOISE_DEG;
    let drivetrain = &mut plant.drivetrain;
    drivetrain.electrical.winding_resistance_ohm = identified.resistance_ohm.value;
    drivetrain.electrical.winding_inductance_h = identified.inductance_h;
    drivetrain.electrical.torque_constant_nm_a = findings.torque_constant_nm_a.value;
    let gears = &mut drivetrain.gear_train;
    let beyond_kg_m2 = gears.output_inertia_kg_m2 + gears.load_inertia_kg_m2;
    gears.gear_ratio = ratio;
    gears.motor_inertia_kg_m2 =
        (identified.inertia_kg_m2.value - beyond_kg_m2).max(0.0) / (ratio * ratio);
    let backlash = findings.dynamics.backlash_deg;
    gears.backlash_deg = backlash.map_or(0.0, |backlash| backlash.value);
    let super::Friction { upward, downward } = findings.friction;
    let coulomb = upward.coulomb_nm.mean(downward.coulomb_nm);
    // Without friction of its own the output would not rest within the backlash.
    let at_motor_nm = coulomb.value - gears.bearing_friction_nm;
    drivetrain.friction.coulomb_friction_nm = at_motor_nm.max(0.0);
    let viscous_nm_s = identified.viscous_nm_s.value.max(0.0);
    drivetrain.friction.viscous_friction_nm_s_deg = viscous_nm_s.to_radians();
    plant
}

/// The loop of the board.
fn control(client: &mut Client) -> Result<ControlParameters, CommissionError> {
    let mut control = ControlParameters::default();
    for (object, field) in GAINS.into_iter().chain(OTHERS) {
        *field(&mut control) = real(client, object)?;
    }
    Ok(control)
}

/// The model of the board, which its feed-forward uses, and a limit of the mean current, A.
fn values(client: &mut Client, most_a: f64) -> Result<ObjectValues, CommissionError> {
    let mut values = ObjectValues::DEFAULT;
    let model = &mut values.model;
    let fields = [
        ("2011:1", &mut model.resistance_ohm),
        ("2011:2", &mut model.torque_constant_nm_a),
        ("2011:3", &mut model.gear_ratio),
        ("2011:4", &mut model.inertia_kg_m2),
        ("2011:5", &mut model.viscous_friction_nm_s),
        ("2011:6", &mut model.coulomb_friction_nm),
        ("2011:8", &mut model.inductance_h),
    ];
    for (object, field) in fields {
        *field = real(client, object)? as f32;
    }
    // Of the rated current of the twin.
    let rated_ma = f64::from(BoardParameters::DEFAULT.current.rated_ma);
    let permille = (most_a * 1e6 / rated_ma).round().min(u16::MAX.into()) as u16;
    values.limits.max_torque_permille = permille;
    values.limits.max_current_permille = permille;
    Ok(values)
}

fn write(client: &mut Client, objects: &[(&str, f64)]) -> Result<(), ClientError> {
    let mut objects = objects.iter();
    objects.try_for_each(|(object, value)| client.write(object, &value.to_string()))
}

fn records(capture: &Capture) -> Vec<Record> {
    capture
        .records
        .iter()
        .map(|values| Record::of(values))
        .collect()
}

/// The angle as the object of an amplitude, mdeg.
fn mdeg(deg: f64, (least, most): (f64, f64)) -> i32 {
    (deg.clamp(least, most) * 1e3) as i32
}

/// A multisine whose lines reach beyond the crossing.
fn sweep(
    client: &mut Client,
    centre_mdeg: i32,
    identified: &Identified,
    twin: &mut Twin,
    predicted: &Margins,
) -> Result<[Line; LINES], CommissionError> {
    let (sine, base_mhz) = Multisine::reaching(BEYOND * predicted.crossing_hz);
    let pct_deg = identified.duty_by_command(&twin.control, &sine);
    let amplitude_mdeg = mdeg(identified.duty_pct() / pct_deg, (LEAST_LINE_DEG, LINE_DEG));
    let settings = [
        (3, 9),
        (4, amplitude_mdeg),
        (5, base_mhz),
        (11, LINES as i32),
        (12, sine.periods as i32),
    ];
    let records = records(&excite(client, centre_mdeg, (&SIGNALS, REST), &settings)?);
    let supply_v = records.iter().map(|record| record.supply_v).sum::<f64>();
    twin.plant.drivetrain.electrical.supply_v = supply_v / records.len() as f64;
    let followed = twin.follow(&records);
    let followed = followed.or_else(|error| refuse(STEP, error.to_string()))?;
    let start = verify::start(&records);
    let of = |records: &[Record]| Response::of(records, &sine, start);
    let Some((measured, predicted)) = of(&records).zip(of(&followed)) else {
        return refuse(
            STEP,
            format!("{} records of the sweep are too few", records.len()),
        );
    };
    Ok(verify::lines(&sine, &measured, &predicted))
}

/// A step there and back.
fn step(
    client: &mut Client,
    centre_mdeg: i32,
    identified: &Identified,
    twin: &Twin,
) -> Result<Motion, CommissionError> {
    let pct_deg = twin.control.position_gain * twin.control.proportional_gain;
    let amplitude_mdeg = mdeg(identified.duty_pct() / pct_deg, (LEAST_STEP_DEG, STEP_DEG));
    let settings = [(3, 0), (4, amplitude_mdeg), (8, STEP_MS), (12, 1)];
    motion(
        &excite(client, centre_mdeg, (&SIGNALS, REST), &settings)?,
        twin,
    )
}

/// Moves by the profile of the axis to both sides, with feed-forward.
fn moves(
    client: &mut Client,
    centre_mdeg: i32,
    identified: &Identified,
    twin: &mut Twin,
) -> Result<Motion, CommissionError> {
    client.quick_stop()?;
    write(client, &FORWARD)?;
    twin.values.tracking.velocity_permille = WHOLE;
    twin.values.tracking.model_permille = WHOLE;
    twin.values.tracking.dead_band_mdeg = DEAD_BAND_MDEG;
    let motor = identified.motor([0.0; 5]);
    let greatest_deg_s2 = identified.duty_pct() * motor.motor_gain / motor.motor_time_constant_s;
    let acceleration = ((SHARE * greatest_deg_s2 * 1e3) as u32).max(1).to_string();
    client.write("6083", &acceleration)?;
    client.write("6084", &acceleration)?;
    client.enable(1)?;
    let (capture, moved) = record(client, &SIGNALS, |client| {
        client.pause(REST)?;
        for way_mdeg in [WAY_MDEG, -WAY_MDEG, 0] {
            arrive(client, centre_mdeg + way_mdeg)?;
        }
        Ok(())
    })?;
    moved?;
    motion(&capture, twin)
}

fn motion(capture: &Capture, twin: &Twin) -> Result<Motion, CommissionError> {
    let motion = Motion::of(&records(capture), twin);
    motion.or_else(|error| refuse(STEP, error.to_string()))
}
