//! Tests of the parsing of requests.

use super::*;

#[test]
fn a_message_is_its_identifier_and_its_request() {
    let (id, request) = parse(r#"{"id":7,"do":"move","node":1,"deg":-12.5}"#);
    assert_eq!(id, 7);
    assert!(matches!(request, Ok(Request::Move { node: 1, deg }) if deg == -12.5));
    let (id, request) = parse(r#"{"do":"stop"}"#);
    assert_eq!(id, 0);
    assert!(matches!(request, Ok(Request::Stop)));
}

#[test]
fn an_invalid_request_is_refused_with_its_cause() {
    for (text, number, cause) in [
        ("[]", 0, "expected a map"),
        (r#"{"id":1}"#, 1, "missing field `do`"),
        (r#"{"id":2,"do":"jump"}"#, 2, "unknown variant `jump`"),
        (r#"{"id":3,"do":"move","node":1}"#, 3, "missing field `deg`"),
        (
            r#"{"id":4,"do":"move","node":"x","deg":0}"#,
            4,
            "expected u8",
        ),
        (
            r#"{"id":5,"do":"preview","settings":{"4":"x"}}"#,
            5,
            "expected i32",
        ),
    ] {
        let (id, request) = parse(text);
        assert_eq!(id, number, "the answer belongs to the request");
        let error = request.expect_err(text).to_string();
        assert!(error.contains(cause), "{text}: {error}");
    }
}
