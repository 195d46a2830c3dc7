//! Connections over pairs of pipes within one process.

use fbptr::server::{Engine, Server};
use std::io::{self, Cursor};

#[test]
fn a_server_that_finishes_at_once_serves_the_pipes_that_it_was_given() {
    for round in 0..100 {
        let server = Server::start(Engine::new(4, 4).unwrap()).unwrap();
        for x in 0..3 {
            let stream = Cursor::new(format!("PX {x} 1 ff0000\n").into_bytes());
            server.serve_pipe(Box::new(stream), Box::new(io::sink()), || {}).unwrap();
        }
        let engine = server.finish();
        let row = [0, 1, 2].map(|x| engine.memory().get_pixel(x, 1).unwrap());
        assert_eq!(row, [[255, 0, 0, 255]; 3], "round {round}");
    }
}
