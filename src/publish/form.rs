//! A form with a file in it, as RFC 7578 has it.

/// The pieces round a file of a `multipart/form-data` body.
pub(super) struct Form {
    head: Vec<u8>,
    tail: Vec<u8>,
    boundary: String,
}

impl Form {
    /// Fields and then a file, which is `name`; its bytes are between `before` and `behind`. `seed` is a hash of them.
    pub(super) fn of(fields: &[(&str, &str)], name: &str, seed: &str) -> Self {
        // The file cannot hold a line with its own SHA-256.
        let boundary = format!("trunnion-{seed}");
        let mut head = String::new();
        for (key, value) in fields {
            head += &format!("--{boundary}\r\nContent-Disposition: form-data; name=\"{key}\"\r\n\r\n{value}\r\n");
        }
        head += &format!(
            "--{boundary}\r\nContent-Disposition: form-data; name=\"file\"; filename=\"{name}\"\r\n\
             Content-Type: application/octet-stream\r\n\r\n"
        );
        Self { head: head.into_bytes(), tail: format!("\r\n--{boundary}--\r\n").into_bytes(), boundary }
    }

    /// The header that goes with it.
    pub(super) fn kind(&self) -> String {
        format!("multipart/form-data; boundary={}", self.boundary)
    }

    /// The body, with the file's bytes.
    pub(super) fn body<'a>(&'a self, file: &'a [u8]) -> Vec<&'a [u8]> {
        vec![&self.head, file, &self.tail]
    }
}
