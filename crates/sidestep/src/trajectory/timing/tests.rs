//! Timings against their limits, closed forms and the slow twin that tries other speeds.

use proptest::prelude::*;

use super::*;

fn limits(dof: usize) -> impl Strategy<Value = Limits> {
    let numbers = || prop::collection::vec(0.3..3.0_f64, dof);
    (numbers(), numbers()).prop_map(|(v, a)| Limits::new(v, a).unwrap())
}

fn paths() -> impl Strategy<Value = (Path, Limits)> {
    (1..8_usize, 2..8_usize).prop_flat_map(|(dof, n)| {
        let waypoints = prop::collection::vec(-2.0..2.0_f64, n * dof);
        let cuts = prop::collection::vec(0.0..0.5_f64, n - 2);
        (waypoints, cuts, limits(dof)).prop_map(move |(waypoints, mut cuts, limits)| {
            let point = |i: usize| &waypoints[i * dof..(i + 1) * dof];
            let side = |i: usize| {
                let squares = point(i).iter().zip(point(i + 1)).map(|(a, b)| (a - b) * (a - b));
                squares.sum::<f64>().sqrt()
            };
            for i in 0..n - 2 {
                cuts[i] *= side(i).min(side(i + 1));
                if cuts[i] < 0.01 {
                    cuts[i] = 0.0;
                }
            }
            (Path::blended(&waypoints, dof, &cuts).unwrap(), limits)
        })
    })
}

proptest! {
    #[test]
    fn limits_hold_at_every_moment((path, limits) in paths()) {
        let timed = time_path(&path, &limits).unwrap();
        let mut least_slack = f64::INFINITY;
        for i in 0..3000 {
            let moment = timed.at(timed.duration() * f64::from(i) / 3000.0);
            for j in 0..path.dof() {
                let v = moment.velocity[j].abs() / limits.velocity()[j];
                let a = moment.acceleration[j].abs() / limits.acceleration()[j];
                prop_assert!(v <= 1.0 && a <= 1.0, "joint {j} at {}: {v}, {a}", moment.time);
                least_slack = least_slack.min(1.0 - v.max(a));
            }
        }
        // The fastest timing is at some limit all the time.
        prop_assert!(least_slack < 1e-6, "{least_slack}");
    }

    #[test]
    fn derivatives_are_those_of_the_positions((path, limits) in paths(), share in 0.05..0.95_f64) {
        let timed = time_path(&path, &limits).unwrap();
        let (t, h) = (share * timed.duration(), 1e-6);
        let (before, now, after) = (timed.at(t - h), timed.at(t), timed.at(t + h));
        for j in 0..path.dof() {
            let slope = (after.position[j] - before.position[j]) / (2.0 * h);
            prop_assert!((slope - now.velocity[j]).abs() < 1e-4);
            let turn = (after.velocity[j] - before.velocity[j]) / (2.0 * h);
            // Where the acceleration jumps, the difference lies between the two.
            let (low, high) = (before.acceleration[j], after.acceleration[j]);
            prop_assert!(turn > low.min(high) - 1e-3 && turn < low.max(high) + 1e-3);
        }
    }

    #[test]
    fn straight_lines_match_the_trapezoid(a in -2.0..2.0_f64, b in -2.0..2.0_f64, limits in limits(2)) {
        prop_assume!((a - b).abs() > 0.1);
        let path = Path::polyline(&[a, b, b, a], 2).unwrap();
        let (d, v, acc) = ((a - b).abs(), limits.velocity(), limits.acceleration());
        let (v, acc) = (v[0].min(v[1]), acc[0].min(acc[1]));
        // Speed up, cruise, slow down; or only the two where the way is short.
        let exact = if v * v / acc < d { d / v + v / acc } else { 2.0 * (d / acc).sqrt() };
        let found = time_path(&path, &limits).unwrap().duration();
        prop_assert!(found >= exact * (1.0 - 1e-9) && found < exact * 1.002, "{found}, {exact}");
    }
}

#[test]
fn stops_and_blends() {
    let corner = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0];
    let limits = Limits::new(vec![1.0; 2], vec![2.0; 2]).unwrap();
    let time = |path: &Path| time_path(path, &limits).unwrap().duration();
    let stopped = Path::polyline(&corner, 2).unwrap();
    let blended = Path::blended(&corner, 2, &[0.2]).unwrap();
    assert!((time(&stopped) - 3.0).abs() < 1e-2, "{}", time(&stopped));
    assert!(time(&blended) < 2.7);
    // At the middle of the parabola: r |v - u| / 4 from the corner.
    let middle = time_path(&blended, &limits).unwrap();
    let middle = middle.at(0.5 * middle.duration()).position;
    let away = (1.0 - middle[0]).hypot(middle[1]);
    assert!((away - 0.2 * 2.0_f64.sqrt() / 4.0).abs() < 1e-3, "{away}");
    // There and back: a stop, whatever is asked.
    let back = Path::blended(&[0.0, 1.0, 0.0], 1, &[0.3]).unwrap();
    let one = Limits::new(vec![1.0], vec![2.0]).unwrap();
    let there = time_path(&back, &one).unwrap();
    assert!((there.at(0.5 * there.duration()).position[0] - 1.0).abs() < 1e-3);
    // A configuration said twice changes nothing.
    let twice = [0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 1.0];
    let twice = Path::blended(&twice, 2, &[0.2, 0.2]).unwrap();
    assert!((time(&twice) - time(&blended)).abs() < 1e-12);
}

#[test]
fn samples_increase_and_end_at_the_end() {
    let path = Path::polyline(&[0.0, 1.0], 1).unwrap();
    let timed = time_path(&path, &Limits::new(vec![1.0], vec![2.0]).unwrap()).unwrap();
    for period in [0.1, timed.duration() / 7.0, 100.0] {
        let moments = timed.sampled(period).unwrap();
        assert!(moments.windows(2).all(|pair| pair[1].time - pair[0].time > 1e-7));
        let last = moments.last().unwrap();
        assert_eq!((last.time, last.velocity[0]), (timed.duration(), 0.0));
        assert!((last.position[0] - 1.0).abs() < 1e-12);
        assert_eq!((moments[0].time, moments[0].position[0]), (0.0, 0.0));
    }
    assert!(timed.sampled(0.0).is_err() && timed.sampled(1e-300).is_err());
}

#[test]
fn refuses_what_is_no_path() {
    for (waypoints, dof, reach, field) in [
        (vec![0.0, 1.0, 2.0], 2, vec![], "waypoints"),
        (vec![0.0], 1, vec![], "waypoints"),
        (vec![0.0, 1.0], 0, vec![], "waypoints"),
        (vec![1.0, 1.0, 1.0], 1, vec![0.0], "waypoints"),
        (vec![1.0, f64::NAN], 1, vec![], "waypoints[1][0]"),
        (vec![0.0, 1.0, 2.0], 1, vec![], "reach"),
        (vec![0.0, 1.0, 2.0], 1, vec![-0.1], "reach[0]"),
        (vec![0.0, 1.0, 2.0], 1, vec![1.5], "reach"),
        (vec![0.0, 1.0, 2.0, 3.0], 1, vec![0.6, 0.6], "reach"),
    ] {
        assert_eq!(Path::blended(&waypoints, dof, &reach).unwrap_err().field, field);
    }
    let path = Path::polyline(&[0.0, 1.0], 1).unwrap();
    let two = Limits::new(vec![1.0; 2], vec![1.0; 2]).unwrap();
    assert_eq!(time_path(&path, &two).unwrap_err().field, "limits");
    assert_eq!(Limits::new(vec![1.0], vec![0.0]).unwrap_err().field, "acceleration[0]");
    assert_eq!(Limits::new(vec![1.0], vec![]).unwrap_err().field, "limits");
}
