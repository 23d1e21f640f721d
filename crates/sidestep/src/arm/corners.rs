//! Corners that a robot may cut: parabolas around a plan's waypoints, proved free as a whole.
//!
//! A corner c between unit directions u and v is cut r before and after it by the parabola with the control points
//! c - r u, c, c + r v ([`Path::blended`]). It is cut into K chords. Between two of its points a joint strays from their
//! chord by at most e = r |v - u| / (4 K^2), so no point of the body strays from where it would be on the chord by more
//! than the sum over joints of e times 1 (sliding) or twice the reach (turning: the farthest that anything is from an
//! axis). K is taken so that this is below [`STRAY`], and the chords are proved free for a robot whose moving balls are all
//! larger by that: then the parabola is free for the robot itself, of the world and of its own links. Limits hold, for
//! the parabola stays between its control points.

use std::sync::Arc;

use super::certificate::Certifier;
use super::robot::Arm;
use super::scene::ArmScene;
use crate::error::InvalidInput;
use crate::trajectory::timing::Path;
use crate::trajectory::{Trajectory, distance};

/// What the larger robot is larger by, metres.
const STRAY: f64 = 5e-4;
/// Halvings of a corner's reach before the robot has to stop there.
const HALVINGS: usize = 6;
/// Most chords of a corner.
const MOST_CHORDS: usize = 200;

impl ArmScene {
    /// A trajectory with its corners cut by at most `reach` before and after each (rad or m, in joint space), as far as that
    /// is proved free; where nothing is, the robot stops. The trajectory itself must be certified.
    ///
    /// # Errors
    /// If the reach is negative or not finite, or the trajectory has fewer than two different configurations.
    pub fn with_corners_cut(
        &self,
        trajectory: &Trajectory,
        reach: f64,
    ) -> Result<Path, InvalidInput> {
        if !(reach >= 0.0 && reach.is_finite()) {
            return Err(InvalidInput::new("reach", reach, "a number of at least 0"));
        }
        // Nothing is said of the place of a waypoint that is there twice.
        let mut points: Vec<&[f64]> = trajectory.configurations().collect();
        points.dedup_by(|a, b| distance(a, b) < 1e-9);
        let larger = Certifier::new(Arc::new(self.arm().larger(STRAY)), Arc::clone(self.world()));
        let mut work = larger.work();
        let mut reaches = Vec::new();
        for corner in points.windows(3) {
            let [before, at, after] = [corner[0], corner[1], corner[2]];
            let (into, out) = (distance(before, at), distance(at, after));
            let u: Vec<f64> = before.iter().zip(at).map(|(a, b)| (b - a) / into).collect();
            let v: Vec<f64> = at.iter().zip(after).map(|(a, b)| (b - a) / out).collect();
            let mut r = reach.min(0.499 * into).min(0.499 * out);
            let mut proved = 0.0;
            for _ in 0..HALVINGS {
                if r <= 1e-6 {
                    break;
                }
                let stray = self.arm().stray(&u, &v) * r / 4.0;
                let chords = (stray / STRAY).sqrt().ceil().max(1.0) as usize;
                let free =
                    |from: &[f64], to: &[f64], work: &mut _| larger.motion_is_free(from, to, work);
                if chords <= MOST_CHORDS
                    && parabola(at, &u, &v, r, chords)
                        .windows(2)
                        .all(|pair| free(&pair[0], &pair[1], &mut work))
                {
                    proved = r;
                    break;
                }
                r *= 0.5;
            }
            reaches.push(proved);
        }
        Path::blended(&points.concat(), trajectory.dof(), &reaches)
    }
}

impl Arm {
    /// The same robot whose moving balls are all larger by `extra` metres.
    fn larger(&self, extra: f64) -> Self {
        let mut larger = self.clone();
        for part in larger.parts.iter_mut().filter(|part| part.slot > 0) {
            part.around.radius += extra;
            larger.balls[part.balls.clone()].iter_mut().for_each(|ball| ball.radius += extra);
        }
        larger
    }

    /// How far a point of the body moves at most while joint j moves by |v_j - u_j|, all of them at once; metres.
    fn stray(&self, u: &[f64], v: &[f64]) -> f64 {
        let reach = self.reach();
        let slots = self.chain.slots.iter();
        slots
            .map(|slot| {
                let moved = (slot.multiplier * (v[slot.coordinate] - u[slot.coordinate])).abs();
                moved * if slot.prismatic { 1.0 } else { 2.0 * reach }
            })
            .sum()
    }
}

/// The ends of a parabola's chords.
fn parabola(c: &[f64], u: &[f64], v: &[f64], r: f64, chords: usize) -> Vec<Vec<f64>> {
    (0..=chords)
        .map(|i| {
            let t = i as f64 / chords as f64;
            let (first, last) = ((1.0 - t) * (1.0 - t) * r, t * t * r);
            (0..c.len()).map(|k| c[k] - first * u[k] + last * v[k]).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::{Body, BodyShape, Joint, JointKind, Limits, Link, Model};
    use crate::profile::Profile;
    use crate::rng::{Purpose, stream};
    use crate::space::generate::Family;
    use crate::space::vector::{norm, sub};
    use crate::space::{Pose, World};
    use crate::trajectory::timing::{Limits as Fast, time_path};
    use rand::RngExt;
    use std::collections::HashMap;

    /// Three links in the plane z = 0.
    fn arm() -> Arc<Arm> {
        let ball = |x: f64| Body {
            origin: Pose::at([x, 0.0, 0.0]).unwrap(),
            shape: BodyShape::Sphere { radius: 0.03 },
        };
        let links = (0..4).map(|i| Link {
            name: format!("{i}"),
            bodies: if i == 0 {
                vec![]
            } else {
                (1..=6).map(|k| ball(0.05 * f64::from(k))).collect()
            },
        });
        let limits = Limits { lower: -2.9, upper: 2.9, velocity: None, effort: None };
        let joints = (0..3).map(|i| Joint {
            name: format!("j{i}"),
            kind: JointKind::Revolute,
            parent: i,
            child: i + 1,
            origin: Pose::at([if i == 0 { 0.0 } else { 0.3 }, 0.0, 0.0]).unwrap(),
            axis: [0.0, 0.0, 1.0],
            limits: Some(limits),
            mimic: None,
        });
        let model = Model::new("three", links.collect(), joints.collect()).unwrap();
        let arm = Arm::new(&model, &[], &HashMap::new()).unwrap();
        let pair = |a: &str, b: &str| (a.to_owned(), b.to_owned());
        Arc::new(arm.with_self_collisions(&[pair("1", "2"), pair("2", "3")]).unwrap())
    }

    /// The deepest that any ball is in the world or in a link that it must not touch, f64 and densely.
    fn deepest(scene: &ArmScene, q: &[f64]) -> f64 {
        let (arm, world) = (scene.arm(), scene.world());
        let balls = arm.balls_at(q);
        let of_world = balls.iter().flat_map(|ball| {
            (0..world.pieces()).map(|i| ball.radius - world.distance(i as u32, ball.center).0)
        });
        let of_self = arm.pairs.iter().flat_map(|&[a, b]| {
            let (a, b) = (arm.parts[a].balls.clone(), arm.parts[b].balls.clone());
            let balls = &balls;
            a.flat_map(move |i| {
                b.clone().map(move |j| {
                    let apart = norm(sub(balls[i].center, balls[j].center));
                    balls[i].radius + balls[j].radius - apart
                })
            })
        });
        of_world.chain(of_self).fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn what_is_driven_is_free_everywhere() {
        let arm = arm();
        let limits = Fast::new(vec![1.0; 3], vec![4.0; 3]).unwrap();
        let (mut cut, mut stops, mut sooner) = (0, 0, 0);
        for index in 0..60 {
            let world = Family::PlanarBoxes.generate(5, index, [0.0; 3]).unwrap().world;
            let scene = ArmScene::new(&arm, &Arc::new(world), &Profile::DEFAULT);
            let mut rng = stream(5, Purpose::Task, index, 77);
            // A walk of free motions, as a plan is one.
            let mut points: Vec<Vec<f64>> = Vec::new();
            for _ in 0..400 {
                let near = points.last().cloned();
                let q: Vec<f64> = match near {
                    Some(q) => q.iter().map(|v| v + 1.2 * (rng.random::<f64>() - 0.5)).collect(),
                    None => arm.drawn(&mut rng),
                };
                let from = points.last().unwrap_or(&q).clone();
                if scene.motion_is_free(&from, &q) {
                    points.push(q);
                }
                if points.len() == 6 {
                    break;
                }
            }
            if points.len() < 3 {
                continue;
            }
            let plan = Trajectory::new(3, points.concat());
            let path = scene.with_corners_cut(&plan, 0.3).unwrap();
            let timed = time_path(&path, &limits).unwrap();
            let slow = time_path(&Path::polyline(plan.values(), 3).unwrap(), &limits).unwrap();
            sooner += usize::from(timed.duration() < slow.duration() - 1e-9);
            let mut least = f64::INFINITY;
            for i in 0..=2000 {
                let moment = timed.at(timed.duration() * f64::from(i) / 2000.0);
                let depth = deepest(&scene, &moment.position);
                assert!(depth < 0.0, "world {index}: {depth} deep at {}", moment.time);
                if (20..1980).contains(&i) {
                    least = least.min(norm([0, 1, 2].map(|k| moment.velocity[k])));
                }
            }
            if least > 0.05 { cut += 1 } else { stops += 1 }
        }
        assert!(cut > 10 && sooner > 30, "{cut} never stop, {stops} do, {sooner} sooner");
    }

    #[test]
    fn a_parabola_that_strays_into_an_obstacle_is_made_smaller() {
        let arm = arm();
        let free = ArmScene::new(&arm, &Arc::new(World::default()), &Profile::DEFAULT);
        let plan = Trajectory::new(3, vec![0.0, 0.3, 0.3, 1.0, 0.3, 0.3, 1.0, 1.3, 0.3]);
        let limits = Fast::new(vec![1.0; 3], vec![4.0; 3]).unwrap();
        let duration = |reach: f64| {
            let path = free.with_corners_cut(&plan, reach).unwrap();
            time_path(&path, &limits).unwrap().duration()
        };
        assert!(duration(0.4) < duration(0.1) && duration(0.1) < duration(0.0));
        assert_eq!(free.with_corners_cut(&plan, -1.0).unwrap_err().field, "reach");
    }
}
