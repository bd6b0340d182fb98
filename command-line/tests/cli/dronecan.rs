//! DroneCAN nodes by `--bus dronecan:`.

use std::time::Duration;

use serde_json::Value;

use crate::served::Served;

/// Two nodes, which wait for their node-IDs.
struct Nodes(Served);

impl Nodes {
    fn new() -> Self {
        Self(Served::new(&["--protocol", "dronecan", "--nodes", "2"]))
    }

    fn run(&self, arguments: &str) -> assert_cmd::assert::Assert {
        let bus = &self.0.bus;
        let mut command = self
            .0
            .cli
            .actuator(&format!("{arguments} --bus dronecan:{bus}"));
        command.timeout(Duration::from_secs(60)).assert()
    }

    fn text(&self, arguments: &str) -> String {
        let output = self.run(arguments).success();
        String::from_utf8(output.get_output().stdout.clone()).expect("UTF-8")
    }

    fn json(&self, arguments: &str) -> Value {
        let text = self.text(&format!("{arguments} --json"));
        let first = text.lines().next().expect("a line");
        serde_json::from_str(first).expect("JSON")
    }

    fn error(&self, arguments: &str, status: i32) -> String {
        let output = self.run(arguments).code(status);
        String::from_utf8(output.get_output().stderr.clone()).expect("UTF-8")
    }
}

#[test]
fn nodes_get_ids_once_and_are_read_written_and_moved() {
    let nodes = Nodes::new();
    assert_eq!(nodes.json("scan"), serde_json::json!([]));
    let found = nodes.json("scan --allocate");
    let of = |found: &Value, key: &str| -> Vec<Value> {
        let all = found.as_array().expect("a list").iter();
        all.map(|node| node[key].clone()).collect()
    };
    assert_eq!(of(&found, "node"), [1, 2]);
    assert_eq!(of(&found, "name"), ["org.smart-actuator"; 2]);
    // A node keeps its ID.
    let again = nodes.json("scan --allocate");
    assert_eq!(of(&again, "unique_id"), of(&found, "unique_id"));

    let all = nodes.json("get");
    assert!(all.as_object().expect("an object").len() > 100);
    assert_eq!(all["stall_ms"], 500);
    nodes.text("set stall_ms=600 position_gain=9.5 --node 2");
    assert_eq!(nodes.text("get stall_ms --node 2"), "600\n");
    assert_eq!(nodes.text("get position_gain --node 2"), "9.5\n");
    assert_eq!(nodes.text("get stall_ms"), "500\n");

    nodes.text("move 20 --node 2");
    let status = nodes.json("monitor --for 0.3 --node 2");
    let angle_deg = status["angle_deg"].as_f64().expect("an angle");
    assert!((angle_deg - 20.0).abs() < 1.5, "{status}");
    let other = nodes.json("monitor --for 0.3");
    assert!(
        other["angle_deg"].as_f64().expect("an angle").abs() < 0.5,
        "{other}"
    );
    nodes.text("stop --node 2");
}

#[test]
fn what_a_node_does_not_have_or_take_is_reported() {
    let nodes = Nodes::new();
    assert!(nodes.error("get stall_ms", 1).contains("scan --allocate"));
    nodes.text("scan --allocate");
    for (arguments, status, message) in [
        ("get nonsense", 2, "node 1 has no parameter nonsense"),
        ("set stall_ms=much", 2, "stall_ms is much, expected 20 to"),
        (
            "set stall_ms=19",
            3,
            "node 1 keeps stall_ms at 500, expected 20 to",
        ),
        ("move 500 --within 1", 1, "expected 500 deg to be reached"),
        (
            "record --for 1",
            2,
            "DroneCAN has the commands scan, get, set",
        ),
    ] {
        let error = nodes.error(arguments, status);
        assert!(error.contains(message), "{arguments}: {error}");
    }
}
