//! Test inputs by integer tick, exact on every target.
