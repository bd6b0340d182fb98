//! Whether the experiments on the project have run with these sources.
//!
//! It is asked of the command of `assurance/`, a workspace of its own: the rule for a stale result
//! stands there alone, and no package of this workspace depends on it.

use std::process::Command;

/// The experiments whose results are not of these sources, a text for the release notes; `None` if
/// there are none. Without an answer all of them are in doubt, and the text says why.
pub fn stale() -> Option<String> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(cross_build::workspace());
    listed(command.args(["evidence", "--check"]))
}

/// What a command lists; `None` if it succeeds.
fn listed(command: &mut Command) -> Option<String> {
    let output = match command.output() {
        Ok(output) if output.status.success() => return None,
        Ok(output) => output,
        Err(error) => return Some(error.to_string()),
    };
    let printed = if output.stdout.is_empty() {
        output.stderr
    } else {
        output.stdout
    };
    Some(String::from_utf8_lossy(&printed).trim_end().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(script: &str) -> Option<String> {
        listed(Command::new("sh").args(["-c", script]))
    }

    #[test]
    fn a_failure_is_what_the_command_lists_or_why_it_does_not() {
        assert_eq!(of("echo all is well"), None);
        assert_eq!(of("echo stale; echo x >&2; false"), Some("stale".into()));
        assert_eq!(of("echo no git >&2; exit 2"), Some("no git".into()));
        let error = listed(&mut Command::new("/no such program"));
        assert!(error.is_some_and(|text| text.contains("No such file")));
    }
}
