//! Tests of the parsing of requests.

use super::*;

#[test]
fn a_message_is_its_identifier_and_its_request() {
    let (id, request) = parse(r#"{"id":7,"do":"move","node":1,"deg":-12.5}"#).expect("valid");
    assert_eq!(id, 7);
    assert!(matches!(request, Request::Move { node: 1, deg } if deg == -12.5));
    let (id, request) = parse(r#"{"do":"stop"}"#).expect("valid");
    assert_eq!(id, 0);
    assert!(matches!(request, Request::Stop));
}

#[test]
fn an_invalid_request_is_refused_with_its_cause() {
    for (text, cause) in [
        ("[]", "expected a map"),
        (r#"{"id":1}"#, "missing field `do`"),
        (r#"{"do":"jump"}"#, "unknown variant `jump`"),
        (r#"{"do":"move","node":1}"#, "missing field `deg`"),
        (r#"{"do":"move","node":"x","deg":0}"#, "expected u8"),
        (r#"{"id":"x","do":"stop"}"#, "expected u64"),
    ] {
        let error = parse(text).expect_err(text).to_string();
        assert!(error.contains(cause), "{text}: {error}");
    }
}
