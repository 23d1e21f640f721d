//! A plan of a robot with joints as a page of its own: one HTML file without anything from elsewhere, in which the robot
//! moves among its obstacles, seen from where one likes, with sliders over time and iterations.
//!
//! Names and numbers of the input stand in the page as JSON that is read as data and shown as text, never as code.

mod faces;

use serde_json::{Value, json};
use sidestep::arm::Arm;
use sidestep::space::{Vector, World};

const PAGE: &str = include_str!("page.html");
const SCRIPT: &str = include_str!("page.js");

/// What a page shows.
#[derive(Debug, Clone)]
pub struct ArmPage<'a> {
    /// Over everything.
    pub title: String,
    /// Lines under the title.
    pub lines: Vec<String>,
    /// The robot.
    pub arm: &'a Arm,
    /// What is around it.
    pub world: &'a World,
    /// Motions, the last one shown first: iterates of an optimizer and then the plan.
    pub tracks: Vec<Track>,
    /// Links that are drawn in another colour, because they hit something.
    pub hit: Vec<String>,
}

/// One motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Such as `iterate 12 of 40`.
    pub label: String,
    /// Whether the numbers before the configurations are seconds; else they are shares of the way.
    pub timed: bool,
    /// Times that increase from 0, each with a configuration; at least one.
    pub moments: Vec<(f64, Vec<f64>)>,
}

impl Track {
    /// Straight motions between configurations, shares of the way by length in joint space; so densely that no joint moves
    /// more than a tenth between two.
    pub fn along(label: impl Into<String>, configurations: &[&[f64]]) -> Self {
        const FINE: f64 = 0.1;
        let mut moments = Vec::new();
        let mut passed = 0.0;
        if let Some(first) = configurations.first() {
            moments.push((0.0, first.to_vec()));
        }
        for pair in configurations.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let length = sidestep::trajectory::distance(from, to);
            let count = (length / FINE).ceil().clamp(1.0, 100.0) as usize;
            for i in 1..=count {
                let t = i as f64 / count as f64;
                let at = from.iter().zip(to).map(|(a, b)| a + t * (b - a)).collect();
                moments.push((passed + t * length, at));
            }
            passed += length;
        }
        Self { label: label.into(), timed: false, moments }
    }
}

/// Most moments of all tracks together: what keeps a page of a robot of ten links under half a megabyte.
const MOST_MOMENTS: usize = 450;
/// Most spheres of a page's robot; of more, the largest of each link.
const MOST_SPHERES: usize = 700;

/// A link that moves: its name, and its spheres in its own frame.
struct Moving {
    name: String,
    spheres: Vec<[f64; 4]>,
}

impl ArmPage<'_> {
    /// The page.
    pub fn to_html(&self) -> String {
        // Only what cannot end the element that holds it.
        let data = self.data().to_string().replace('<', "\\u003c");
        PAGE.replacen("SCRIPT", SCRIPT, 1).replacen("DATA", &data, 1)
    }

    fn data(&self) -> Value {
        let (base, moving) = self.spheres();
        let every: usize = self.tracks.iter().map(|track| track.moments.len()).sum();
        let stride = every.div_ceil(MOST_MOMENTS).max(1);
        let tracks: Vec<Value> =
            self.tracks.iter().map(|track| self.track(track, stride, &moving)).collect();
        let (faces, balls) = faces::of(self.world);
        let [low, high] = self.box_around(&faces, &base);
        let links: Vec<Value> = moving
            .iter()
            .map(|link| {
                let spheres: Vec<Value> =
                    link.spheres.iter().map(|sphere| rounded(sphere)).collect();
                json!({"name": link.name, "spheres": spheres, "hit": self.hit.contains(&link.name)})
            })
            .collect();
        let names: Vec<&str> = self.arm.joints().iter().map(|joint| joint.name.as_str()).collect();
        let face = |face: &Vec<Vector>| Value::Array(face.iter().map(|p| rounded(p)).collect());
        json!({
            "title": self.title,
            "lines": self.lines,
            "joints": names,
            "links": links,
            "base": base.iter().map(|sphere| rounded(sphere)).collect::<Vec<_>>(),
            "faces": faces.iter().map(face).collect::<Vec<_>>(),
            "balls": balls.iter().map(|ball| rounded(ball)).collect::<Vec<_>>(),
            "low": low, "high": high,
            "tracks": tracks,
        })
    }

    /// The spheres that never move, in the root's frame, and those of each link that does, in its own.
    fn spheres(&self) -> (Vec<[f64; 4]>, Vec<Moving>) {
        let ends = |upper: bool| -> Vec<f64> {
            let end = |joint: &sidestep::arm::ArmJoint| {
                0.4 * joint.lower + 0.6 * if upper { joint.upper } else { 0.9 * joint.lower }
            };
            self.arm.joints().iter().map(end).collect()
        };
        let (here, there) = (ends(false), ends(true));
        let mut links: Vec<Moving> = Vec::new();
        let mut base = Vec::new();
        for (index, ball) in self.arm.balls_at(&here).iter().enumerate() {
            let name = self.arm.link_of_ball(index);
            let poses = [&here, &there].map(|q| self.arm.link_pose(name, q));
            let [Some(now), Some(then)] = poses else { continue };
            let [x, y, z] = ball.center;
            if now == then {
                base.push([x, y, z, ball.radius]);
                continue;
            }
            let [x, y, z] = now.apply_inverse(ball.center);
            let sphere = [x, y, z, ball.radius];
            match links.iter_mut().find(|link| link.name == name) {
                Some(link) => link.spheres.push(sphere),
                None => links.push(Moving { name: name.to_owned(), spheres: vec![sphere] }),
            }
        }
        let all: usize = links.iter().map(|link| link.spheres.len()).sum();
        if all > MOST_SPHERES {
            for link in &mut links {
                let kept = (link.spheres.len() * MOST_SPHERES / all).max(1);
                link.spheres.sort_by(|a, b| b[3].total_cmp(&a[3]));
                link.spheres.truncate(kept);
            }
        }
        (base, links)
    }

    fn track(&self, track: &Track, stride: usize, moving: &[Moving]) -> Value {
        let last = track.moments.len().saturating_sub(1);
        let shown = |&(i, _): &(usize, _)| i % stride == 0 || i == last;
        let moments: Vec<&(f64, Vec<f64>)> =
            track.moments.iter().enumerate().filter(shown).map(|(_, moment)| moment).collect();
        let poses: Vec<Vec<Value>> = moments
            .iter()
            .map(|(_, q)| {
                let pose = |link: &Moving| {
                    let pose = self
                        .arm
                        .link_pose(&link.name, q)
                        .unwrap_or(sidestep::space::Pose::IDENTITY);
                    let ([w, a, b, c], [x, y, z]) = (pose.wxyz(), pose.translation());
                    rounded(&[w, a, b, c, x, y, z])
                };
                moving.iter().map(pose).collect()
            })
            .collect();
        json!({
            "label": track.label,
            "timed": track.timed,
            "times": moments.iter().map(|(time, _)| (time * 1e4).round() / 1e4).collect::<Vec<_>>(),
            "joints": moments.iter().map(|(_, q)| rounded(q)).collect::<Vec<_>>(),
            "poses": poses,
        })
    }

    /// A box around the robot on its way and what of the world is near it.
    fn box_around(&self, faces: &[Vec<Vector>], base: &[[f64; 4]]) -> [Vector; 2] {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut add = |p: Vector, r: f64| {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(p[k] - r), high[k].max(p[k] + r));
            }
        };
        base.iter().for_each(|&[x, y, z, r]| add([x, y, z], r));
        for (_, q) in self.tracks.iter().flat_map(|track| &track.moments).step_by(10) {
            self.arm.balls_at(q).iter().for_each(|ball| add(ball.center, ball.radius));
        }
        add([0.0; 3], 0.1);
        let far = self.arm.reach();
        let near = |p: &&Vector| p.iter().all(|v| v.abs() <= far);
        faces.iter().flatten().filter(near).for_each(|&p| add(p, 0.0));
        [low, high]
    }
}

/// Numbers to a tenth of a millimetre, as short as they can be.
fn rounded(numbers: &[f64]) -> Value {
    let short = |value: &f64| {
        let value = (value * 1e4).round() / 1e4;
        if value == 0.0 { json!(0) } else { json!(value) }
    };
    Value::Array(numbers.iter().map(short).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robots::{Moving as Joints, Preparation, prepare, read_urdf};
    use sidestep::space::{Object, Pose, Shape};

    fn page(name: &str) -> String {
        let text = "<robot name='two'><link name='base'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>\
            <link name='arm'><collision><origin xyz='0.3 0 0'/><geometry><sphere radius='0.05'/></geometry></collision></link>\
            <joint name='turn' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/>\
            <limit lower='-1' upper='1' velocity='1' effort='1'/></joint></robot>";
        let preparation = Preparation { moving: Joints::All, ..Preparation::default() };
        let mut none = |_: &str, _| panic!("no mesh");
        let robot = prepare(read_urdf(text).unwrap(), None, &preparation, &mut none).unwrap();
        let shape = Shape::cuboid([0.1; 3]).unwrap();
        let at = Pose::at([0.5, 0.5, 0.0]).unwrap();
        let world = World::new(vec![Object::new(name, vec![(at, shape)])]).unwrap();
        let track = Track::along("plan", &[&[-0.5], &[0.5]]);
        ArmPage {
            title: name.to_owned(),
            lines: vec![name.to_owned()],
            arm: &robot.arm,
            world: &world,
            tracks: vec![track],
            hit: Vec::new(),
        }
        .to_html()
    }

    #[test]
    fn a_page_is_whole_and_names_are_only_data() {
        let evil = "</script><script>alert(1)</script><img src=x onerror=alert(1)>DATA SCRIPT";
        let html = page(evil);
        assert!(html.len() < 60_000, "{}", html.len());
        assert!(!html.contains("<script>alert") && !html.contains("<img"));
        assert_eq!(html.matches("<script").count(), 2);
        let begin = html.find("id=\"data\">").unwrap() + 10;
        let end = begin + html[begin..].find("</script>").unwrap();
        let shell = format!("{}{}", &html[..begin], &html[end..]);
        let foreign = ["http://", "https://", "src=", "url(", "import"];
        assert!(foreign.iter().all(|word| !shell.contains(word)));
        let data: Value = serde_json::from_str(&html[begin..end]).unwrap();
        assert_eq!(data["title"], evil);
        // One sphere stands, one moves; a box of six sides, each in four parts or fewer.
        assert_eq!(data["base"], json!([[0, 0, 0, 0.1]]));
        assert_eq!(data["links"][0]["spheres"], json!([[0.3, 0, 0, 0.05]]));
        let track = &data["tracks"][0];
        assert_eq!(track["times"].as_array().unwrap().len(), 11);
        assert_eq!(track["joints"][10], json!([0.5]));
        assert!(data["faces"].as_array().unwrap().len() >= 6);
    }
}
