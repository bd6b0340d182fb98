//! `documentation/index.html`: the variables, and how simulated time advances. The text is in
//! `templates/documentation.html`.

use askama::Template;
use model_core::actuator::Settings;

use crate::description::{model_identifier, summary};
use crate::variables::{self, Quantity, Variable};

#[derive(Template)]
#[template(path = "documentation.html")]
struct Documentation {
    name: String,
    summary: &'static str,
    variables: Vec<Variable>,
}

/// The page for these settings.
///
/// ```
/// use model_core::actuator::{ModelKind, PlantKind, Settings};
///
/// let settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
/// assert!(actuator_fmu::documentation::html(&settings).contains("<td>command_deg</td>"));
/// ```
pub fn html(settings: &Settings) -> String {
    let page = Documentation {
        name: model_identifier(settings),
        summary: summary(settings),
        variables: variables::of(settings),
    };
    // Writing to a string does not fail.
    page.render().unwrap_or_default()
}
