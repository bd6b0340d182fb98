//! Workbooks of Excel as text: the longest sheet, its cells separated by tabs.

/// The text.
///
/// # Errors
/// For a damaged workbook, and in a program that was built without reading workbooks.
#[cfg(feature = "xlsx")]
pub fn text(workbook: Vec<u8>) -> Result<Vec<u8>, String> {
    use calamine::{Data, Reader, Xlsx};
    let damaged = |error| format!("a damaged workbook: {error}");
    let mut workbook = Xlsx::new(std::io::Cursor::new(workbook)).map_err(damaged)?;
    let sheets = workbook.worksheets();
    let longest = sheets.iter().max_by_key(|(_, sheet)| sheet.height());
    let (name, sheet) = longest.ok_or("a workbook without a sheet")?;
    let is_same = |(other, cells): &&(String, calamine::Range<Data>)| {
        other != name && cells.height() > 1 && cells.rows().next() == sheet.rows().next()
    };
    if let Some((other, _)) = sheets.iter().find(is_same) {
        return Err(format!(
            "a workbook whose sheets `{name}` and `{other}` have the same header, expected one \
             recording"
        ));
    }
    let cell = |cell: &Data| match cell {
        // A day of 86,400 s: where the times of a recording are dates, only differences matter.
        Data::DateTime(time) => format!("{}", time.as_f64() * 86_400.0),
        Data::Error(_) => String::new(),
        other => other.to_string().replace(['\t', '\n', '\r'], " "),
    };
    let row = |row: &[Data]| row.iter().map(cell).collect::<Vec<_>>().join("\t");
    let rows: Vec<String> = sheet.rows().map(row).collect();
    Ok(rows.join("\n").into_bytes())
}

/// The error of a program without this format.
#[cfg(not(feature = "xlsx"))]
pub fn text(_: Vec<u8>) -> Result<Vec<u8>, String> {
    Err(super::not_built("a workbook of Excel"))
}
