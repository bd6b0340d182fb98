//! Other Studios of the same user on this computer, on buses of their own.
//!
//! Each one that only this computer can reach has a file with its bus and its address in a folder
//! that only its user can read, as the address contains the token.

use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::PathBuf;
use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Time for a Studio of this computer to accept a connection.
const PATIENCE: Duration = Duration::from_millis(50);

/// A Studio.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Neighbour {
    /// The name of its bus.
    pub bus: String,
    /// The address of its page, with the token.
    pub url: String,
    address: SocketAddr,
}

impl Neighbour {
    /// A Studio with this bus at this address.
    pub fn new(bus: &str, url: String, address: SocketAddr) -> Self {
        Self {
            bus: bus.to_owned(),
            url,
            address,
        }
    }

    /// Whether only this computer can reach it.
    pub fn is_private(&self) -> bool {
        self.address.ip().is_loopback()
    }
}

/// The file of this Studio, which it removes at its end, and those of the others.
#[derive(Debug)]
pub struct Register {
    folder: PathBuf,
    own: PathBuf,
}

impl Register {
    /// Adds this Studio to those of a folder.
    ///
    /// # Errors
    /// If the folder or the file cannot be made, or the folder belongs to another user.
    pub fn join(folder: PathBuf, own: &Neighbour) -> io::Result<Self> {
        make_private(&folder)?;
        let register = Self {
            own: folder.join(format!("{}.json", own.address.port())),
            folder,
        };
        // What a Studio that was killed has left.
        let _: io::Result<()> = fs::remove_file(&register.own);
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let mut file = options.open(&register.own)?;
        file.write_all(&serde_json::to_vec(own)?)?;
        Ok(register)
    }

    /// The other Studios that answer, in the order of their ports.
    pub fn others(&self) -> Vec<Neighbour> {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let files = entries.map(|entry| entry.path());
        let mut others: Vec<Neighbour> = files
            .filter(|path| *path != self.own)
            .filter_map(|path| serde_json::from_slice(&fs::read(path).ok()?).ok())
            .filter(|other: &Neighbour| {
                TcpStream::connect_timeout(&other.address, PATIENCE).is_ok()
            })
            .collect();
        others.sort_by_key(|other| other.address);
        others
    }
}

impl Drop for Register {
    fn drop(&mut self) {
        // Others see that this one does not answer.
        let _: io::Result<()> = fs::remove_file(&self.own);
    }
}

/// The folder of this user's Studios.
pub fn folder() -> Option<PathBuf> {
    let of = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    let base = of("XDG_RUNTIME_DIR")
        .or_else(|| of("LOCALAPPDATA"))
        .map(PathBuf::from);
    let base = base.or_else(|| of("HOME").map(|home| PathBuf::from(home).join(".cache")))?;
    Some(base.join("actuator-studio"))
}

fn make_private(folder: &std::path::Path) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // It fails in a folder of another user.
        fs::set_permissions(folder, fs::Permissions::from_mode(0o700))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, TcpListener};

    use super::*;

    #[test]
    fn two_studios_see_each_other_until_one_ends_or_is_killed() {
        let folder = tempfile::tempdir().unwrap();
        let any = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        let listen = || TcpListener::bind(any).unwrap();
        let join = |bus: &str, listener: &TcpListener| {
            let address = listener.local_addr().unwrap();
            let own = Neighbour::new(bus, format!("http://{address}/?token=1"), address);
            (Register::join(folder.path().join("s"), &own).unwrap(), own)
        };
        let (first_listener, second_listener) = (listen(), listen());
        let (first, _) = join("can0", &first_listener);
        assert_eq!(first.others(), []);
        let (second, own) = join("can1", &second_listener);
        assert_eq!(first.others(), [own]);
        assert_eq!(second.others()[0].bus, "can0");
        drop(second);
        assert_eq!(first.others(), []);
        let (killed, _) = join("can1", &second_listener);
        std::mem::forget(killed);
        drop(second_listener);
        assert_eq!(first.others(), []);
    }
}
