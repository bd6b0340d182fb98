//! Columns of which several may be a quantity, and their units.

use super::*;

fn of_joint(joint: &str) -> Import {
    Import {
        columns: Columns {
            selected: Vec::new(),
            joint: Some(joint.into()),
        },
        ..Import::default()
    }
}

#[test]
fn an_index_in_a_name_is_no_unit() {
    for (text, expected) in [
        (
            "time_s,goal_position[3],present_position[3]\n0,1,2\n0.1,3,4\n",
            [2.0, 4.0],
        ),
        ("time_s,cmd(deg),pos[rad]\n0,1,0\n0.1,3,1\n", [0.0, 57.3]),
        (
            "time_s,cmd[1] (deg),pos[0] (rad)\n0,1,0\n0.1,3,1\n",
            [0.0, 57.3],
        ),
        ("time_s,cmd (deg),pos [0.5]\n0,1,2\n0.1,3,4\n", [1.0, 2.0]),
        (
            "time_s,target.position (deg),current.position\n0,1,2\n0.1,3,4\n",
            [2.0, 4.0],
        ),
    ] {
        let read = read(text).expect("a recording").recording;
        assert_eq!(read.command_deg, [1.0, 3.0]);
        for (angle, expected) in read.angle_deg.iter().zip(expected) {
            assert!((angle - expected).abs() < 0.01, "{text}: {angle}");
        }
    }
    let items = "time_s,goal[0],goal[1],position\n0,1,2,3\n";
    let error = read(items).expect_err("two goals");
    assert!(error.contains("may both be the command"), "{error}");
}

#[test]
fn a_quantity_that_is_not_required_is_left_out_where_two_columns_may_be_it() {
    let text = "time_s,command_deg,angle_deg,left.voltage,right.voltage\n0,1,2,5,6\n0.1,3,4,5,6\n";
    let Imported { recording, notes } = read(text).expect("a recording");
    assert_eq!((recording.supply_v, notes.len()), (None, 1));
    let note = &notes[0].text;
    assert!(
        note.contains("`left.voltage` and `right.voltage` may both be the supply"),
        "{note}"
    );
    let import = with_columns(&["supply=right.voltage"]);
    let read = read_as(&import, "run.csv", text).expect("a recording");
    assert_eq!(read.recording.supply_v, Some(vec![6.0, 6.0]));
}

#[test]
fn the_unit_that_is_usual_for_a_name_is_noted() {
    let Imported { recording, notes } =
        read("time_s,q_des,q\n0,1,0\n0.1,1,1\n").expect("a recording");
    assert!((recording.angle_deg[1] - 57.3).abs() < 0.01);
    let texts: Vec<&str> = notes.iter().map(|note| &*note.text).collect();
    assert_eq!(
        texts,
        [
            "column `q_des` has no unit, rad is assumed; --column command=q_des:UNIT sets another",
            "column `q` has no unit, rad is assumed; --column angle=q:UNIT sets another",
        ]
    );
    let import = with_columns(&["command=q_des:deg", "angle=q:deg"]);
    let read = read_as(&import, "run.csv", "time_s,q_des,q\n0,1,0\n0.1,1,1\n");
    let Imported { recording, notes } = read.expect("a recording");
    assert_eq!((recording.angle_deg[1], notes.len()), (1.0, 0));
}

#[test]
fn rates_and_efforts_beside_the_angles_of_a_joint_are_neither_command_nor_angle() {
    let states = ["reference", "feedback"].map(|state| {
        let values = ["velocities", "effort", "positions"];
        values
            .map(|value| format!("{state}.{value}.elbow"))
            .join(",")
    });
    let text = format!(
        "time_s,{}\n0,9,9,1,9,9,2\n0.1,9,9,3,9,9,4\n",
        states.join(",")
    );
    let read = read_as(&of_joint("elbow"), "run.csv", text).expect("a joint");
    assert_eq!(read.recording.command_deg, [1.0, 3.0]);
    assert_eq!(read.recording.angle_deg, [2.0, 4.0]);
    let two = "time_s,a.goal.elbow,b.goal.elbow,position.elbow\n0,1,1,1\n";
    let error = read_as(&of_joint("elbow"), "run.csv", two);
    let error = error.expect_err("two commands");
    assert!(!error.contains("--joint"), "{error}");
}
