//! Compiles the public key in by which images are verified: the file named by `VITRINE_PUBLIC_KEY`, or the development key.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

use ed25519_dalek::VerifyingKey;
use ed25519_dalek::pkcs8::DecodePublicKey;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-env-changed=VITRINE_PUBLIC_KEY");
    let development = Path::new(&env::var("CARGO_MANIFEST_DIR")?).join("keys/development.public.pem");
    let chosen = env::var_os("VITRINE_PUBLIC_KEY").map_or_else(|| development.clone(), PathBuf::from);
    let text = format!(
        "/// The public key whose images this firmware takes, as RFC 8032 encodes it.\n\
         pub const PUBLIC_KEY: [u8; 32] = {:?};\n\n\
         /// The development key. Its secret part lies in the tree for everybody to read: what it signs proves nothing.\n\
         pub const DEVELOPMENT_KEY: [u8; 32] = {:?};\n",
        read(&chosen)?,
        read(&development)?,
    );
    fs::write(Path::new(&env::var("OUT_DIR")?).join("keys.rs"), text)?;
    Ok(())
}

fn read(path: &Path) -> Result<[u8; 32], Box<dyn Error>> {
    println!("cargo:rerun-if-changed={}", path.display());
    let named = |error: &dyn Error| format!("the public key {}: {error}", path.display());
    let text = fs::read_to_string(path).map_err(|error| named(&error))?;
    Ok(VerifyingKey::from_public_key_pem(&text).map_err(|error| named(&error))?.to_bytes())
}
