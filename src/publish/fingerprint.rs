//! The SHA-256 of a certificate, by which a server is known that nobody vouches for.

use std::fmt;
use std::str::FromStr;

use sha2::{Digest, Sha256};

/// The SHA-256 of a certificate in DER, as `openssl x509 -fingerprint -sha256` has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint([u8; 32]);

impl Fingerprint {
    /// Of a certificate in DER.
    pub fn of(certificate: &[u8]) -> Self {
        Self(Sha256::digest(certificate).into())
    }
}

impl FromStr for Fingerprint {
    type Err = String;

    /// 64 hexadecimal digits, with colons between the bytes or without; what `openssl` writes before them may stand there, too.
    fn from_str(text: &str) -> Result<Self, String> {
        let digits: Vec<u32> = text
            .rsplit('=')
            .next()
            .unwrap_or_default()
            .chars()
            .filter(|c| *c != ':')
            .map(|c| c.to_digit(16))
            .collect::<Option<_>>()
            .unwrap_or_default();
        let bytes: Vec<u8> = digits.chunks_exact(2).map(|pair| (pair[0] * 16 + pair[1]) as u8).collect();
        let wrong = || {
            "must be 64 hexadecimal digits, as printed by openssl x509 -in CERTIFICATE -noout -fingerprint -sha256"
                .to_owned()
        };
        if digits.len() != 64 { Err(wrong()) } else { bytes.try_into().map(Self).map_err(|_| wrong()) }
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().enumerate().try_for_each(|(i, byte)| write!(f, "{}{byte:02X}", if i == 0 { "" } else { ":" }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_openssl_prints_is_read_and_nothing_else() {
        let fingerprint = Fingerprint::of(b"abc");
        let text = fingerprint.to_string();
        assert!(text.starts_with("BA:78:16:BF:") && text.ends_with(":15:AD"), "{text}");
        for same in [text.clone(), text.replace(':', ""), text.to_lowercase(), format!("sha256 Fingerprint={text}")] {
            assert_eq!(same.parse(), Ok(fingerprint), "{same}");
        }
        let other =
            [String::new(), text[3..].to_owned(), format!("{text}:00"), text.replace("BA", "XY"), "=".to_owned()];
        for wrong in other {
            assert!(wrong.parse::<Fingerprint>().is_err(), "{wrong}");
        }
    }
}
