//! The grey box: motor, PI rate loop and P position loop in continuous time, as
//! [`model_core::models::grey_box`] steps it, which defines its equations and names.

mod modes;

use std::sync::Arc;

use model_core::models::{SetupParameters, grey_box::GreyBoxParameters};

use super::Dynamics;
use super::initial_state::InitialState;
use crate::experiment::Experiment;
use crate::hybrid::{Output, simulate};
use crate::model::{Description, Model, ModelParameter, ParameterValues, parameters};
use crate::scalar::Scalar;
use crate::start::DataSummary;
use modes::Servo;

/// Motor, rate loop and position loop, behind a delay.
///
/// The gains of the controller are known to its designer, so that only motor and delay are free by
/// default: command and angle alone determine only products of gains as long as nothing saturates.
#[derive(Debug, Clone, Copy)]
pub struct GreyBox;

parameters! {
    /// Parameters of [`GreyBox`].
    pub struct GreyBoxValues {
        motor_gain_up: GreyBoxParameters.within(1e-3, 1e3);
        motor_gain_down: GreyBoxParameters.within(1e-3, 1e3);
        motor_time_constant_s: GreyBoxParameters.within(1e-3, 100.0);
        delay_s: SetupParameters;
        proportional_gain: GreyBoxParameters.within(1e-4, 1e3).fixed();
        integral_gain: GreyBoxParameters.fixed();
        position_gain: GreyBoxParameters.within(1e-2, 5e3).fixed();
        anti_windup_gain: GreyBoxParameters.fixed();
        rate_anti_windup_gain: GreyBoxParameters.fixed();
        duty_limit_pct: GreyBoxParameters.within(1e-3, f64::INFINITY).fixed();
        rate_limit_up_deg_s: GreyBoxParameters.rate_limit().fixed();
        rate_limit_down_deg_s: GreyBoxParameters.rate_limit().fixed();
        position_limit_deg: GreyBoxParameters.fixed();
        initial_angle_deg: InitialState.initial_state();
        initial_rate_deg_s: InitialState.initial_state().fixed();
    }
}

pub(super) fn models() -> Vec<Arc<dyn Model>> {
    vec![Arc::new(GreyBox)]
}

impl Description for GreyBox {
    fn name(&self) -> &'static str {
        "grey-box"
    }

    fn summary(&self) -> &'static str {
        "motor, PI rate loop and P position loop with delay and limits"
    }

    fn parameters(&self) -> &[ModelParameter] {
        GreyBoxValues::<f64>::TABLE
    }
}

impl Dynamics for GreyBox {
    type Parameters<S: Scalar> = GreyBoxValues<S>;

    fn start(&self, experiments: &[Experiment]) -> GreyBoxValues<f64> {
        let data = DataSummary::of(experiments);
        GreyBoxValues {
            // At full duty the rate is the gain times 100 %.
            motor_gain_up: data.rate_up_deg_s / 100.0,
            motor_gain_down: data.rate_down_deg_s / 100.0,
            delay_s: data.second_order_delay_s,
            rate_limit_up_deg_s: f64::INFINITY,
            rate_limit_down_deg_s: f64::INFINITY,
            position_limit_deg: f64::INFINITY,
            initial_angle_deg: data.initial_angle_deg,
            initial_rate_deg_s: data.initial_rate_deg_s,
            ..GreyBoxValues::defaults()
        }
    }

    #[inline(always)]
    fn run<S: Scalar>(&self, run: &Experiment, p: &GreyBoxValues<S>, output: &mut impl Output<S>) {
        let initial = [p.initial_angle_deg, p.initial_rate_deg_s, S::constant(0.0)];
        simulate(&Servo(*p), run, initial, p.delay_s, output);
    }
}
