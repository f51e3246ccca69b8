//! Names of servers to addresses, on a thread that is given up in time; ureq's own panics where the system gives no thread.

use std::io::Error as IoError;
use std::thread::Builder;

use crossbeam_channel::bounded;
use ureq::Error;
use ureq::config::Config;
use ureq::http::Uri;
use ureq::unversioned::resolver::{DefaultResolver, ResolvedSocketAddrs, Resolver};
use ureq::unversioned::transport::NextTimeout;
use ureq::unversioned::transport::time::Duration;

use super::in_words;

/// Looks names up as ureq does.
#[derive(Clone, Copy, Debug)]
pub(super) struct Names;

impl Resolver for Names {
    fn resolve(&self, uri: &Uri, config: &Config, timeout: NextTimeout) -> Result<ResolvedSocketAddrs, Error> {
        let (tell, told) = bounded(1);
        let (uri, config) = (uri.clone(), config.clone());
        let look_up = move || {
            let endless = NextTimeout { after: Duration::NotHappening, ..timeout };
            let _ = tell.send(DefaultResolver::default().resolve(&uri, &config, endless));
        };
        // In words: what a busy system says of threads it says of sockets too, where it means something else.
        Builder::new().spawn(look_up).map_err(|error| Error::Io(IoError::other(in_words(&error))))?;
        told.recv_timeout(*timeout.after).unwrap_or(Err(Error::Timeout(timeout.reason)))
    }
}
