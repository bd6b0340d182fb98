//! Reads HDF5, and MAT files of version 7.3, which are HDF5: the numeric vectors and the columns of
//! the matrices of each group.

use super::table::Group;

/// The error of a program without this format.
#[cfg(not(feature = "hdf5"))]
pub fn groups(_: Vec<u8>) -> Result<Vec<Group>, String> {
    Err(super::not_built("an HDF5 file, as MAT of version 7.3 is"))
}

/// The columns of each group.
#[cfg(feature = "hdf5")]
pub fn groups(bytes: Vec<u8>) -> Result<Vec<Group>, String> {
    let damaged = |error: hdf5_reader::error::Error| format!("a damaged HDF5 file: {error}");
    let file = hdf5_reader::Hdf5File::from_vec(bytes).map_err(damaged)?;
    let mut groups = Vec::new();
    collect(&file.root_group().map_err(damaged)?, "", 0, &mut groups).map_err(damaged)?;
    match groups.iter().all(|(_, columns)| columns.is_empty()) {
        true => Err(
            "an HDF5 file without a vector or matrix of numbers that is read, expected data sets \
             of plain types, uncompressed or with gzip; of a timetable or iddata, of pandas or of \
             h5py records, its columns as vectors"
                .into(),
        ),
        false => Ok(groups),
    }
}

/// Deepest group that is read.
#[cfg(feature = "hdf5")]
const DEEPEST: usize = 4;

#[cfg(feature = "hdf5")]
fn collect(
    group: &hdf5_reader::group::Group,
    path: &str,
    depth: usize,
    groups: &mut Vec<Group>,
) -> hdf5_reader::error::Result<()> {
    let (inside, datasets) = group.members()?;
    let mut columns = Vec::new();
    for dataset in &datasets {
        if let Some(values) = numbers(dataset) {
            let sizes: Vec<usize> = dataset.shape().iter().map(|size| *size as usize).collect();
            columns.extend(super::matrix::rows(dataset.name(), &sizes, values));
        }
    }
    groups.push((path.to_owned(), columns));
    // MATLAB keeps the content of cells and objects in groups that start so.
    let named = inside.iter().filter(|group| !group.name().starts_with('#'));
    for group in named.filter(|_| depth < DEEPEST) {
        let path = match path {
            "" => group.name().to_owned(),
            _ => format!("{path}/{}", group.name()),
        };
        collect(group, &path, depth + 1, groups)?;
    }
    Ok(())
}

/// The numbers of a data set of any type; `None` for what is no number.
#[cfg(feature = "hdf5")]
fn numbers(dataset: &hdf5_reader::Dataset) -> Option<Vec<f64>> {
    macro_rules! first_of {
        ($($T:ty),+) => {
            None$(.or_else(|| {
                let values = dataset.read_array::<$T>().ok()?;
                Some(values.iter().map(|value| *value as f64).collect())
            }))+
        };
    }
    first_of!(f64, f32, i8, u8, i16, u16, i32, u32, i64, u64)
}
