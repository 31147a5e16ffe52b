//! `velvet key` and `velvet sign`: the owner's key, and firmware that is signed with it.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use update::PRIME;

#[derive(Args)]
pub struct KeyOptions {
    /// The file of the secret key; made when it is not there
    #[arg(default_value = "velvet.key")]
    file: PathBuf,
}

#[derive(Args)]
pub struct SignOptions {
    /// The firmware: flashme.bin, firmware.bin, or an image alone
    file: PathBuf,
    /// The file of the secret key, as `velvet key` makes it
    #[arg(long, default_value = "velvet.key")]
    key: PathBuf,
    /// Where the signed firmware goes [default: the same file]
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Prints the public half of a key; makes the key first if there is none.
pub fn key(options: &KeyOptions) -> Result<()> {
    let path = &options.file;
    let secret = if path.exists() { read(path)? } else { make(path)? };
    println!("[update]\nkey = {}", digits(&update::public_key(&secret)));
    Ok(())
}

/// Signs a firmware file with a key.
pub fn sign(options: &SignOptions) -> Result<()> {
    let secret = read(&options.key)?;
    let mut bytes = fs::read(&options.file).with_context(|| options.file.display().to_string())?;
    let manifest = update::sign_file(&mut bytes, &PRIME, &secret)
        .map_err(|flaw| anyhow::anyhow!("{}: {flaw}", options.file.display()))?;
    let out = options.out.as_ref().unwrap_or(&options.file);
    fs::write(out, bytes).with_context(|| out.display().to_string())?;
    println!("{}: {}, signed with {}", out.display(), manifest.version(), digits(&update::public_key(&secret)));
    Ok(())
}

fn make(path: &Path) -> Result<[u8; 32]> {
    let mut secret = [0; 32];
    if let Err(error) = getrandom::fill(&mut secret) {
        bail!("this computer gives no random numbers: {error}");
    }
    write_secret(path, &format!("{}\n", digits(&secret))).with_context(|| path.display().to_string())?;
    eprintln!("{} holds the secret key: keep it, and keep it to yourself", path.display());
    Ok(secret)
}

/// Writes a secret file that only its owner can read, never over another one.
fn write_secret(path: &Path, text: &str) -> std::io::Result<()> {
    use std::io::Write;
    let mut options = fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)?.write_all(text.as_bytes())
}

fn read(path: &Path) -> Result<[u8; 32]> {
    let text = fs::read_to_string(path)
        .with_context(|| format!("{}: no key can be read; velvet key makes one", path.display()))?;
    let text = text.trim();
    ensure!(text.len() == 64 && text.is_ascii(), "{} is no key: 64 hexadecimal digits", path.display());
    let mut key = [0; 32];
    for (place, at) in key.iter_mut().zip((0..64).step_by(2)) {
        let pair = u8::from_str_radix(&text[at..at + 2], 16);
        *place = pair.with_context(|| format!("{} is no key: 64 hexadecimal digits", path.display()))?;
    }
    Ok(key)
}

fn digits(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use update::{MANIFEST_BYTES, Manifest, Policy, check_file};

    struct File(Vec<u8>);

    impl update::Bytes for File {
        fn length(&self) -> u32 {
            self.0.len() as u32
        }

        fn read(&mut self, at: u32, into: &mut [u8]) -> Result<(), update::Flaw> {
            let bytes = self.0.get(at as usize..at as usize + into.len()).ok_or(update::Flaw::Unreadable)?;
            into.copy_from_slice(bytes);
            Ok(())
        }
    }

    fn image() -> Vec<u8> {
        let mut image = vec![0x11; 2048];
        image[..MANIFEST_BYTES].copy_from_slice(&Manifest::draft("test", &PRIME));
        update::seal(&mut image, &PRIME, None).unwrap();
        image
    }

    /// Makes a key, signs a file with it, and shows it to a board that is locked to that key.
    #[test]
    fn what_is_signed_with_a_key_runs_on_a_board_that_is_locked_to_it() {
        let folder = std::env::temp_dir().join(format!("velvet-keys-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("velvet.key");
        let secret = make(&path).unwrap();
        assert_eq!(read(&path).unwrap(), secret);
        assert!(make(&path).is_err(), "a key is never written over");
        let whole = {
            let mut boot = vec![0xFF; PRIME.image() as usize];
            boot[..8].copy_from_slice(&[0x00, 0x00, 0x02, 0x20, 0x91, 0x02, 0x00, 0x08]);
            [boot, image()].concat()
        };
        let with_trailer = [whole.clone(), update::trailer(&whole).to_vec()].concat();
        let policy = Policy { key: Some(update::public_key(&secret)), is_locked: true };
        for bytes in [image(), whole, with_trailer] {
            assert!(check_file(&mut File(bytes.clone()), &PRIME, &policy).is_err(), "it is not signed");
            let file = folder.join("flashme.bin");
            fs::write(&file, bytes).unwrap();
            sign(&SignOptions { file: file.clone(), key: path.clone(), out: None }).unwrap();
            check_file(&mut File(fs::read(&file).unwrap()), &PRIME, &policy).unwrap();
        }
        let mut spoiled = image();
        spoiled[2000] ^= 1;
        let file = folder.join("spoiled.bin");
        fs::write(&file, spoiled).unwrap();
        let refused = sign(&SignOptions { file, key: path, out: None }).unwrap_err();
        assert!(refused.to_string().contains("SHA-256 does not match"), "{refused}");
        fs::remove_dir_all(&folder).unwrap();
    }
}
