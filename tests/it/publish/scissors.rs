//! A way to a server that is cut on purpose.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};

/// Cuts what goes to `to` in every POST of the first `cuts` connections that have one after `bytes` bytes; the rest passes.
pub(super) fn scissors(to: SocketAddr, bytes: usize, cuts: usize) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let left = Arc::new(Mutex::new(cuts));
    std::thread::spawn(move || {
        for near in listener.incoming().flatten() {
            let (left, far) = (Arc::clone(&left), TcpStream::connect(to).unwrap());
            let (mut back_from, mut back_to) = (far.try_clone().unwrap(), near.try_clone().unwrap());
            std::thread::spawn(move || std::io::copy(&mut back_from, &mut back_to));
            std::thread::spawn(move || pass(near, far, bytes, &left));
        }
    });
    address
}

fn pass(mut near: TcpStream, mut far: TcpStream, bytes: usize, left: &Mutex<usize>) {
    let (mut buffer, mut posted) = ([0; 4096], None);
    while let Ok(count @ 1..) = near.read(&mut buffer) {
        if buffer[..count].starts_with(b"POST /api/files/local HTTP") && *left.lock().unwrap() > 0 {
            *left.lock().unwrap() -= 1;
            posted = Some(0);
        }
        if let Some(gone) = &mut posted {
            *gone += count;
            if *gone > bytes {
                break;
            }
        }
        if far.write_all(&buffer[..count]).is_err() {
            break;
        }
    }
    let _ = near.shutdown(std::net::Shutdown::Both);
    let _ = far.shutdown(std::net::Shutdown::Both);
}
