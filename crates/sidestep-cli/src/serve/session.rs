//! One client: its obstacles, its last plan, and the answers to its requests in order.
//!
//! A thread reads ahead, so that `cancel` is seen while a plan is made; at most [`WAITING`] requests wait.

use std::collections::BTreeMap;
use std::io::{BufRead, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use sidestep::plan::ends::plan_with_margin;
use sidestep::plan::run::Iteration;
use sidestep::plan::{Options, Planner, Status, Stop, Watch, Wishes};
use sidestep::plane::geometry::Point;
use sidestep::plane::{explain, explain_path, points};
use sidestep::scene::{Query, Scene};
use sidestep::trajectory::driving::{DrivingLimits, drive, spaced};
use sidestep::{Obstacle, Task, Trajectory};
use sidestep_io::drive::nav2_error_code;

use super::Base;
use super::lines::{Line, MOST_BYTES, next};
use super::request::Request;
use crate::obstacle::parse_obstacle;

/// Requests that are read ahead.
const WAITING: usize = 64;
/// Most poses of an answer.
const MOST_POSES: usize = 10_000;
/// What a base without a map would answer.
const NO_MAP: &str = "there is no map";
/// Most obstacles of a client.
const MOST_OBSTACLES: usize = 10_000;

/// Answers requests until the input ends or nobody hears the answers.
pub fn session(mut reader: impl BufRead, writer: impl Write + Send, base: &Base) {
    let writer = Mutex::new(writer);
    // Plans are numbered as they are read; all up to this one are cancelled.
    let (cancelled, read) = (AtomicU64::new(0), AtomicU64::new(0));
    let (sender, receiver) = sync_channel::<(u64, Result<Request, String>)>(WAITING);
    std::thread::scope(|scope| {
        let (writer, cancelled) = (&writer, &cancelled);
        scope.spawn(move || Client::new(base).answer_all(&receiver, writer, cancelled));
        read_all(&mut reader, &sender, cancelled, &read);
        drop(sender);
    });
}

fn read_all(
    reader: &mut impl BufRead,
    sender: &SyncSender<(u64, Result<Request, String>)>,
    cancelled: &AtomicU64,
    read: &AtomicU64,
) {
    while let Ok(Some(line)) = next(reader) {
        let request = match line {
            Line::TooLong => Err(format!("a request has at most {MOST_BYTES} bytes")),
            Line::Text(text) if text.trim_ascii().is_empty() => continue,
            Line::Text(text) => serde_json::from_slice(&text).map_err(|error| error.to_string()),
        };
        let number = read.fetch_add(1, Ordering::Relaxed) + 1;
        if matches!(request, Ok(Request::Cancel { .. })) {
            cancelled.store(number, Ordering::Relaxed);
        }
        if sender.send((number, request)).is_err() {
            break;
        }
    }
}

struct Client<'a> {
    base: &'a Base,
    obstacles: BTreeMap<String, Obstacle>,
    /// The scenes of the map with the obstacles, until one of them changes.
    scenes: Option<[Arc<Scene>; 2]>,
    last: Option<Trajectory>,
}

impl<'a> Client<'a> {
    fn new(base: &'a Base) -> Self {
        Self { base, obstacles: BTreeMap::new(), scenes: None, last: None }
    }

    fn answer_all(
        &mut self,
        requests: &Receiver<(u64, Result<Request, String>)>,
        writer: &Mutex<impl Write + Send>,
        cancelled: &AtomicU64,
    ) {
        for (number, request) in requests {
            let go_on = || cancelled.load(Ordering::Relaxed) < number;
            let (id, answer) = match request {
                Ok(request) => self.answer(request, writer, &go_on),
                Err(error) => (Value::Null, Err(error)),
            };
            let mut line = match answer {
                Ok(answer) => answer,
                Err(error) => json!({ "ok": false, "error": error }),
            };
            line["id"] = id;
            if !say(writer, &line) {
                return;
            }
        }
    }

    fn answer(
        &mut self,
        request: Request,
        writer: &Mutex<impl Write + Send>,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> (Value, Result<Value, String>) {
        match request {
            Request::Set { id, name, obstacle } => (id, self.set(name, &obstacle)),
            Request::Remove { id, name } => {
                let removed = self.obstacles.remove(&name).is_some();
                self.scenes = None;
                let unknown = || format!("there is no obstacle named {name:?}");
                (id, if removed { Ok(json!({ "ok": true })) } else { Err(unknown()) })
            }
            Request::Clear { id } => {
                self.obstacles.clear();
                self.scenes = None;
                (id, Ok(json!({ "ok": true })))
            }
            Request::Cancel { id } => (id, Ok(json!({ "ok": true }))),
            Request::Info { id } => {
                let bounds = self.base.scenes[1].plane().map(|plane| plane.world().bounds());
                let answer = json!({
                    "ok": true,
                    "bounds": bounds.map(|bounds| [bounds.min, bounds.max]),
                    "robot_radius": self.base.scenes[1].plane().map(|plane| plane.robot().radius()),
                    "margin": self.base.margin,
                    "obstacles": self.obstacles.keys().collect::<Vec<_>>(),
                });
                (id, Ok(answer))
            }
            Request::Plan { ref id, .. } => {
                let id = id.clone();
                let see = |waypoints: &[Point], index: usize| {
                    say(writer, &json!({ "id": id, "iterate": index, "waypoints": waypoints }));
                };
                let answer = self.plan(&request, &see, go_on);
                (id, answer)
            }
        }
    }

    fn set(&mut self, name: String, obstacle: &str) -> Result<Value, String> {
        if self.obstacles.len() >= MOST_OBSTACLES && !self.obstacles.contains_key(&name) {
            return Err(format!("a client has at most {MOST_OBSTACLES} obstacles"));
        }
        let obstacle = parse_obstacle(obstacle)?;
        let moved = self.obstacles.insert(name, obstacle).is_some();
        self.scenes = None;
        Ok(json!({ "ok": true, "moved": moved }))
    }

    /// The scenes of the map with the client's obstacles.
    fn scenes(&mut self) -> Result<[Arc<Scene>; 2], String> {
        if let Some(scenes) = &self.scenes {
            return Ok(scenes.clone());
        }
        let obstacles: Vec<_> = self.obstacles.values().cloned().collect();
        let with = |scene: &Scene| scene.with_obstacles(&obstacles).map(Arc::new);
        let [asked, own] = &self.base.scenes;
        let scenes = [with(asked).ok_or(NO_MAP)?, with(own).ok_or(NO_MAP)?];
        Ok(self.scenes.insert(scenes).clone())
    }

    fn plan(
        &mut self,
        request: &Request,
        see: &(dyn Fn(&[Point], usize) + Sync),
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Value, String> {
        let Request::Plan {
            start,
            goal,
            budget_ms,
            planner,
            warm,
            stream,
            max_turn,
            min_radius,
            snap,
            ..
        } = request
        else {
            return Err("not a plan".into());
        };
        let begin = Instant::now();
        let words = |error: sidestep::InvalidInput| error.to_string();
        let budget = match budget_ms {
            Some(ms) if !(*ms > 0.0 && *ms <= 1e9) => {
                return Err(format!("budget_ms: {ms} is not above 0 and at most 1e9"));
            }
            ms => ms.map(|ms| Duration::from_secs_f64(ms / 1e3)),
        };
        let planner: Planner = planner.as_deref().unwrap_or("auto").parse().map_err(words)?;
        let scenes = self.scenes()?;
        let task = |scene: &Scene, start: Point, goal: Point| {
            let plane = scene.plane().ok_or(NO_MAP)?;
            let world = plane.world().clone();
            Task::in_plane("", world, plane.robot(), start, goal).map_err(words)
        };
        let (mut own, mut changes) = (task(&scenes[1], *start, *goal)?, Vec::new());
        if let Some(most) = snap {
            (own, changes) = own.snapped(self.base.margin, *most).map_err(words)?;
        }
        let plane = own.plane().map_err(words)?;
        let asked = task(&scenes[0], plane.start, plane.goal)?;
        let query = Query::new(&scenes[0], &asked).map_err(words)?;
        let own_query = Query::new(&scenes[1], &own).map_err(words)?;
        let wishes = Wishes::default();
        let wished = max_turn.is_some() || min_radius.is_some();
        let options = Options {
            stop: if budget.is_some() { Stop::Best } else { Stop::First },
            warm_start: self.last.clone().filter(|_| *warm),
            wishes: wished.then(|| Wishes {
                turn: max_turn.map_or(wishes.turn, f64::to_radians),
                radius: min_radius.unwrap_or(wishes.radius),
            }),
            prove: budget.is_none(),
            ..Options::default()
        };
        let in_time = || go_on() && budget.is_none_or(|budget| begin.elapsed() < budget);
        let show = |iteration: &Iteration<'_>| {
            if *stream {
                let mut values = vec![0.0; iteration.waypoints.len()];
                query.scene().to_task(iteration.waypoints, &mut values);
                see(values.as_chunks::<2>().0, iteration.index);
            }
        };
        let watch = Watch { see: &show, go_on: &in_time };
        let (plan, relaxed) =
            plan_with_margin(&own_query, &query, &planner, &options, watch).map_err(words)?;
        changes.extend(relaxed);
        let certified = plan.certified();
        let limits = DrivingLimits::default();
        let poses = certified
            .map(|path| drive(points(&spaced(path, limits.spacing(), MOST_POSES)), &limits))
            .transpose()
            .map_err(words)?;
        let poses = poses.map(|poses| {
            let row = |p: &sidestep::trajectory::driving::Pose| {
                [p.position[0], p.position[1], p.yaw, p.time, p.speed, p.curvature]
            };
            poses.iter().map(row).collect::<Vec<_>>()
        });
        let reason = match (&plan.status, own.plane()) {
            (Status::Invalid(violation), Ok(task)) => explain(&task, self.base.margin, violation),
            (Status::Unsolved(reason), Ok(task)) => match (reason.violation(), &plan.attempt) {
                (Some(violation), Some(path)) => {
                    let words = explain_path(&task, self.base.margin, path, violation);
                    reason.to_string().replace(&violation.to_string(), &words)
                }
                _ => reason.to_string(),
            },
            (status, _) => status.reason(),
        };
        let answer = json!({
            "ok": true,
            "status": plan.status.name(),
            "reason": reason,
            "nav2_error_code": nav2_error_code(&plan.status),
            "warnings": changes.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "origin": certified.map(|_| plan.origin.to_string()),
            "length": certified.map(Trajectory::length),
            "sharpest_turn_deg": certified.map(|path| path.sharpest_turn().to_degrees()),
            "turning_radius": certified.map(Trajectory::turning_radius).filter(|radius| radius.is_finite()),
            "roughness": certified.map(Trajectory::roughness),
            "clearance": certified.map(|path| own_query.scene().clearance(path)).filter(|c| c.is_finite()),
            "time_us": begin.elapsed().as_secs_f64() * 1e6,
            "poses": poses.unwrap_or_default(),
        });
        if certified.is_some() {
            self.last = certified.cloned();
        }
        Ok(answer)
    }
}

/// Writes a line; whether anybody hears.
fn say(writer: &Mutex<impl Write>, line: &Value) -> bool {
    let Ok(mut writer) = writer.lock() else { return false };
    writer.write_all(format!("{line}\n").as_bytes()).and_then(|()| writer.flush()).is_ok()
}
