//! The compiled module of the Python package `smart_actuator`.
//!
//! It takes arguments that the Python modules have validated, and releases the interpreter lock
//! while it computes. The public interface is documented there.

mod batch;
mod campaign;
mod exception;
mod export;
mod identify;
mod request;
mod sensitivity;
mod stepped;
mod tables;
mod trace;
mod watch;

use pyo3::prelude::*;

#[pymodule(gil_used = false)]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<stepped::Actuator>()?;
    module.add_class::<batch::ActuatorBatch>()?;
    module.add_function(wrap_pyfunction!(sensitivity::sensitivity, module)?)?;
    module.add_function(wrap_pyfunction!(sensitivity::command_sensitivity, module)?)?;
    module.add_function(wrap_pyfunction!(trace::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(campaign::monte_carlo, module)?)?;
    module.add_function(wrap_pyfunction!(identify::identify, module)?)?;
    module.add_function(wrap_pyfunction!(export::export, module)?)?;
    module.add_function(wrap_pyfunction!(tables::presets, module)?)?;
    module.add_function(wrap_pyfunction!(tables::parameters, module)?)?;
    module.add_function(wrap_pyfunction!(tables::inputs, module)?)
}
