use super::*;

const HEADER: &str = "index,sub,object,entry,type,access,pdo,default,min,max,unit,flags,\
                      relation,value,meaning,source";

fn error(line: &str) -> String {
    let text = format!("{HEADER}\n{line}\n");
    parse(&text, &|_| None).map_or_else(|error| error.to_string(), |_| "none".into())
}

#[test]
fn an_error_names_line_and_column() {
    assert_eq!(error("0x2000,,A,B,u8,rw,,0,,,,,,command.a,,"), "none");
    assert!(
        error("0x2000,,A").contains("line: 2"),
        "{}",
        error("0x2000,,A")
    );
    assert_eq!(
        error("0x2000,,A,B,u8,rw,,256,,,,,,command.a,,"),
        "line 2: default is \"256\", expected a value of the type"
    );
    assert_eq!(
        error("0x2000,,A,B,u9,rw,,0,,,,,,command.a,,"),
        "line 2: type is \"u9\", expected u8 to u64, i8 to i64, f32, str or dom"
    );
    assert_eq!(
        error("0x2000,,A,B,u8,rw,,0,1,,,,,command.a,,"),
        "line 2: max is \"\", expected both limits or none"
    );
    assert_eq!(
        error("0x2000,,A,B,u8,rw,,0,,,,,,command.a,,\n0x2000,,A,B,u8,rw,,0,,,,,,command.a,,"),
        "line 3: the entry does not come after the one before it"
    );
    assert_eq!(
        error("0x2000,,A,B,u8,rw,,0,,,,,,,,"),
        "line 2: value is \"\", expected the path of a value"
    );
    assert_eq!(
        error("0x2000,,A,B,f32,rw,,,,,,,,control.none,,"),
        "line 2: value is \"control.none\", expected a control parameter"
    );
}

#[test]
fn a_second_address_of_a_value_takes_default_limits_and_unit_from_the_first() {
    let first = "0x2000,,A,B,i32,rw,,5,0,9,mA,,,parameters.a.b,,";
    let lines = |second: &str| format!("{HEADER}\n{first}\n{second}\n");
    let rows = parse(
        &lines("0x2001,,A,B,u32,rw,,,,,,,,parameters.a.b,,"),
        &|_| None,
    );
    let row = &rows.expect("valid")[1];
    assert_eq!(row.default, Default::Integer(5, "5".into()));
    assert_eq!(row.limits, Some(("0".into(), "9".into())));
    assert_eq!((row.unit.as_str(), row.kind), ("mA", DataType::U32));
    assert_eq!(
        error(&format!(
            "{first}\n0x2001,,A,B,u32,rw,,6,,,,,,parameters.a.b,,"
        )),
        "line 3: default is \"6\", expected nothing: the value is declared elsewhere"
    );
}

#[test]
fn values_are_those_of_their_type() {
    assert_eq!(
        default("-5", DataType::I8),
        Some(Default::Integer(-5, "-5".into()))
    );
    assert_eq!(
        default("$NODEID+0x180", DataType::U32),
        Some(Default::NodeId(0x180))
    );
    assert_eq!(default("$NODEID+0x180", DataType::U16), None);
    assert_eq!(default("0.5", DataType::F32), Some(Default::Real(0.5)));
    assert_eq!(default("nan", DataType::F32), None);
    assert_eq!(default("x", DataType::Domain), None);
    assert_eq!(relation("in 1 2"), Some(Some(Relation::OneOf(vec![1, 2]))));
    assert_eq!(relation("=1"), None);
}
