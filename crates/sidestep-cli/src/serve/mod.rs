//! `sidestep serve`: a map loaded once, then requests and answers as JSON, one a line, on standard input and output or
//! for many clients on a local port. docs/serve.md says what can be asked.

mod lines;
mod request;
mod session;

use std::io::{self, BufReader};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;
use sidestep::Profile;
use sidestep::scene::Scene;
use sidestep_io::input::Question;

use crate::Global;
use crate::failure::Failure;
use crate::input::{self, InputArgs};
use crate::output;
use session::session;

/// Clients that are served at once; others are told to come back.
const MOST_CLIENTS: usize = 64;

/// Arguments of `serve`.
#[derive(Args)]
#[command(
    after_help = "Example:\n  echo '{\"op\":\"plan\",\"start\":[1.5,1.5],\"goal\":[18,11]}' | sidestep serve map.yaml --robot-radius 0.2"
)]
pub struct ServeArgs {
    /// The map, or a task whose world and robot are meant: any file that `sidestep plan` reads
    map: PathBuf,
    #[command(flatten)]
    from: InputArgs,
    /// Distance that plans keep from obstacles and walls, in task units
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    margin: f64,
    /// Listen on this port of 127.0.0.1 (0 takes a free one and says which) instead of standard input
    #[arg(long)]
    port: Option<u16>,
}

/// What all clients share.
pub struct Base {
    /// The map without what clients add, for the robot with its margin and for the robot itself.
    pub scenes: [Scene; 2],
    /// What plans keep from everything.
    pub margin: f64,
}

/// Serves until standard input ends; on a port until the process is stopped.
pub fn run(args: &ServeArgs, global: &Global) -> Result<(), Failure> {
    // Ends are asked for by each request; a map needs some to be read as a task.
    let somewhere = Some([0.0, 0.0]);
    let question = Question {
        start: somewhere,
        goal: somewhere,
        clearance: args.margin,
        ..Question::default()
    };
    let task = input::read(&args.map, &args.from, question)?.tasks.swap_remove(0);
    task.plane()?;
    let with_margin = task.with_margin(args.margin);
    let setting = with_margin.map_err(|error| Failure::at("--margin", error.to_string()))?.setting;
    let scene = Scene::new(&setting, &Profile::DEFAULT);
    // A budget for the first question would break this off, again and again.
    if let Some(plane) = scene.plane() {
        plane.shortest_path().prepare_bounds(&|| true);
    }
    let own = Scene::new(&task.setting, &Profile::DEFAULT);
    let base = Arc::new(Base { scenes: [scene, own], margin: args.margin });
    let Some(port) = args.port else {
        session(io::stdin().lock(), io::stdout(), &base);
        return Ok(());
    };
    let unusable =
        |error: io::Error| Failure::at("--port", format!("{port} cannot be used ({error})"));
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(unusable)?;
    let address = listener.local_addr().map_err(unusable)?;
    output::print(&format!("{{\"listening\":\"{address}\"}}\n"))?;
    let clients = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming() {
        let Ok(stream) = stream else { continue };
        if clients.fetch_add(1, Ordering::Relaxed) >= MOST_CLIENTS {
            clients.fetch_sub(1, Ordering::Relaxed);
            let mut stream = stream;
            let refusal = b"{\"ok\":false,\"error\":\"too many clients; come back later\"}\n";
            let _ = io::Write::write_all(&mut stream, refusal);
            continue;
        }
        let (base, mine) = (base.clone(), clients.clone());
        let serve = move || {
            serve(stream, &base);
            mine.fetch_sub(1, Ordering::Relaxed);
        };
        if std::thread::Builder::new().spawn(serve).is_err() {
            clients.fetch_sub(1, Ordering::Relaxed);
            if !global.quiet {
                output::tell("a client was turned away: no thread can be started");
            }
        }
    }
    Ok(())
}

fn serve(stream: TcpStream, base: &Base) {
    let _ = stream.set_nodelay(true);
    if let Ok(reader) = stream.try_clone() {
        session(BufReader::new(reader), stream, base);
    }
}
