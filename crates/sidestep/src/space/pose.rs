//! A rigid motion: where a frame stands in another.
//!
//! `p' = R p + t` with R a rotation (row-major, `rotation[row][column]`) and t in metres.
//! Quaternions are named by the order of their numbers because both orders are common: wxyz
//! (Eigen's constructor, MuJoCo, cuRobo) and xyzw (ROS, SciPy).

use super::vector::{Vector, add, cross, dot, sub};
use crate::error::{InvalidInput, finite};

/// A rotation followed by a translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    rotation: [Vector; 3],
    translation: Vector,
}

/// How far a quaternion's length, or a product of a rotation's rows, may be from one: files round
/// to three digits.
const LOOSE: f64 = 1e-2;
/// How far they are from one by rounding.
const ROUNDING: f64 = 1e-14;

impl Pose {
    /// No motion.
    pub const IDENTITY: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// A translation, in metres.
    ///
    /// # Errors
    /// If a coordinate is not finite or above 1e9.
    pub fn at(translation: Vector) -> Result<Self, InvalidInput> {
        Ok(Self { translation: finite_vector("position", translation)?, ..Self::IDENTITY })
    }

    /// From a rotation matrix, row-major, and a translation in metres.
    ///
    /// # Errors
    /// If a number is not finite, or the rows are not within 1 % of a right-handed orthonormal
    /// triple; within that they are made orthonormal. Rows that are orthonormal but for rounding stay what they are, to the
    /// bit.
    pub fn from_rotation(rotation: [Vector; 3], translation: Vector) -> Result<Self, InvalidInput> {
        for (i, row) in rotation.iter().enumerate() {
            finite_vector(&format!("rotation[{i}]"), *row)?;
        }
        let [a, b, c] = rotation;
        let products =
            [dot(a, b), dot(b, c), dot(c, a), dot(a, a) - 1.0, dot(b, b) - 1.0, dot(c, c) - 1.0];
        if products.iter().any(|product| product.abs() > LOOSE) || dot(cross(a, b), c) < 0.0 {
            let found = format!("{rotation:?}");
            return Err(InvalidInput::new(
                "rotation",
                found,
                "three orthonormal rows, right-handed",
            ));
        }
        let is_exact = products.iter().all(|product| product.abs() <= ROUNDING);
        let rotation = if is_exact { rotation } else { orthonormal(rotation) };
        Ok(Self { rotation, ..Self::at(translation)? })
    }

    /// From a quaternion `[w, x, y, z]` and a translation in metres.
    ///
    /// # Errors
    /// If a number is not finite or the quaternion's length is not within 1 % of one; within that
    /// it is normalised.
    pub fn from_wxyz(wxyz: [f64; 4], translation: Vector) -> Result<Self, InvalidInput> {
        let length = wxyz.iter().map(|v| v * v).sum::<f64>().sqrt();
        if !((1.0 - LOOSE)..=(1.0 + LOOSE)).contains(&length) {
            let found = format!("{wxyz:?} of length {length}");
            return Err(InvalidInput::new(
                "quaternion",
                found,
                "a unit quaternion (length 0.99 to 1.01)",
            ));
        }
        let [w, x, y, z] = wxyz.map(|v| v / length);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Ok(Self { rotation, ..Self::at(translation)? })
    }

    /// From a quaternion `[x, y, z, w]` and a translation in metres.
    ///
    /// # Errors
    /// As [`Self::from_wxyz`].
    pub fn from_xyzw(xyzw: [f64; 4], translation: Vector) -> Result<Self, InvalidInput> {
        let [x, y, z, w] = xyzw;
        Self::from_wxyz([w, x, y, z], translation)
    }

    /// From roll, pitch and yaw about fixed x, y, z in radians (URDF's `rpy`: R = Rz(yaw) Ry(pitch)
    /// Rx(roll)).
    ///
    /// # Errors
    /// If a number is not finite or above 1e9.
    pub fn from_rpy(rpy: Vector, translation: Vector) -> Result<Self, InvalidInput> {
        finite_vector("rpy", rpy)?;
        let [(sr, cr), (sp, cp), (sy, cy)] = rpy.map(f64::sin_cos);
        let rotation = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ];
        Ok(Self { rotation, ..Self::at(translation)? })
    }

    /// The rotation, row-major.
    pub fn rotation(&self) -> [Vector; 3] {
        self.rotation
    }

    /// The translation, in metres.
    pub fn translation(&self) -> Vector {
        self.translation
    }

    /// The quaternion `[w, x, y, z]` with w >= 0 (Shepperd 1978: divide by the largest of the
    /// four).
    pub fn wxyz(&self) -> [f64; 4] {
        let r = self.rotation;
        let trace = r[0][0] + r[1][1] + r[2][2];
        // Four times the squares of w, x, y, z; the largest is at least one.
        let squares = [
            1.0 + trace,
            1.0 + 2.0 * r[0][0] - trace,
            1.0 + 2.0 * r[1][1] - trace,
            1.0 + 2.0 * r[2][2] - trace,
        ];
        let largest = (1..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
        let (wx, wy, wz) = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]);
        let (xy, yz, zx) = (r[1][0] + r[0][1], r[2][1] + r[1][2], r[0][2] + r[2][0]);
        let row = match largest {
            0 => [squares[0], wx, wy, wz],
            1 => [wx, squares[1], xy, zx],
            2 => [wy, xy, squares[2], yz],
            _ => [wz, zx, yz, squares[3]],
        };
        let factor = 0.5 / squares[largest].sqrt() * if row[0] < 0.0 { -1.0 } else { 1.0 };
        row.map(|v| v * factor)
    }

    /// `R p + t`: a point of the inner frame in the outer one.
    #[inline(always)]
    pub fn apply(&self, p: Vector) -> Vector {
        add(self.rotate(p), self.translation)
    }

    /// `R^T (p - t)`: a point of the outer frame in the inner one.
    #[inline(always)]
    pub fn apply_inverse(&self, p: Vector) -> Vector {
        self.rotate_inverse(sub(p, self.translation))
    }

    /// `R v`: a direction of the inner frame in the outer one.
    #[inline(always)]
    pub fn rotate(&self, v: Vector) -> Vector {
        [dot(self.rotation[0], v), dot(self.rotation[1], v), dot(self.rotation[2], v)]
    }

    /// `R^T v`: a direction of the outer frame in the inner one.
    #[inline(always)]
    pub fn rotate_inverse(&self, v: Vector) -> Vector {
        let r = &self.rotation;
        [0, 1, 2].map(|k| r[0][k] * v[0] + r[1][k] * v[1] + r[2][k] * v[2])
    }

    /// `self ∘ inner`: first `inner`, then `self`.
    pub fn compose(&self, inner: &Self) -> Self {
        let columns = [0, 1, 2].map(|k| inner.rotation.map(|row| row[k]));
        Self {
            rotation: self.rotation.map(|row| columns.map(|column| dot(row, column))),
            translation: self.apply(inner.translation),
        }
    }

    /// The motion back.
    pub fn inverse(&self) -> Self {
        let r = &self.rotation;
        let rotation = [0, 1, 2].map(|k| [r[0][k], r[1][k], r[2][k]]);
        Self { rotation, translation: [0, 1, 2].map(|k| -dot(rotation[k], self.translation)) }
    }
}

/// Gram and Schmidt on rows that are nearly orthonormal.
fn orthonormal([a, b, _]: [Vector; 3]) -> [Vector; 3] {
    let normalised = |v: Vector| v.map(|x| x / dot(v, v).sqrt());
    let a = normalised(a);
    let along = dot(a, b);
    let b = normalised([0, 1, 2].map(|k| b[k] - along * a[k]));
    [a, b, cross(a, b)]
}

/// Checks the three numbers of a point or a direction.
pub(crate) fn finite_vector(field: &str, v: Vector) -> Result<Vector, InvalidInput> {
    for (k, &value) in v.iter().enumerate() {
        finite(&format!("{field}[{k}]"), value)?;
    }
    Ok(v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn poses() -> impl Strategy<Value = Pose> {
        let numbers = prop::array::uniform4(-1.0..1.0_f64);
        (numbers, prop::array::uniform3(-2.0..2.0)).prop_filter_map(
            "a short quaternion",
            |(q, t)| {
                let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
                (length > 0.1).then(|| Pose::from_wxyz(q.map(|v| v / length), t).unwrap())
            },
        )
    }

    fn near(a: Vector, b: Vector) -> bool {
        (0..3).all(|k| (a[k] - b[k]).abs() < 1e-12)
    }

    proptest! {
        #[test]
        fn motions_compose_and_go_back(
            a in poses(), b in poses(), p in prop::array::uniform3(-2.0..2.0_f64),
        ) {
            prop_assert!(near(a.compose(&b).apply(p), a.apply(b.apply(p))));
            prop_assert!(near(a.inverse().apply(a.apply(p)), p));
            prop_assert!(near(a.apply_inverse(a.apply(p)), p));
        }

        #[test]
        fn quaternions_come_back(a in poses(), p in prop::array::uniform3(-2.0..2.0_f64)) {
            let [w, x, y, z] = a.wxyz();
            prop_assert!(w >= 0.0);
            let again = Pose::from_xyzw([x, y, z, w], a.translation()).unwrap();
            prop_assert!(near(a.apply(p), again.apply(p)));
        }
    }

    #[test]
    fn conventions_are_those_of_ros() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let half = 0.5_f64.sqrt();
        let x = [1.0, 0.0, 0.0];
        for (pose, expected) in [
            (Pose::from_rpy([0.0, 0.0, quarter], [0.0; 3]), [0.0, 1.0, 0.0]),
            (Pose::from_rpy([0.0, quarter, 0.0], [0.0; 3]), [0.0, 0.0, -1.0]),
            (Pose::from_rpy([quarter, 0.0, quarter], [0.0; 3]), [0.0, 1.0, 0.0]),
            (Pose::from_wxyz([half, 0.0, 0.0, half], [0.0; 3]), [0.0, 1.0, 0.0]),
            (Pose::from_xyzw([0.0, half, 0.0, half], [1.0, 2.0, 3.0]), [1.0, 2.0, 2.0]),
        ] {
            assert!(near(pose.clone().unwrap().apply(x), expected), "{pose:?}");
        }
    }

    #[test]
    fn refuses_what_is_no_motion() {
        let nan = f64::NAN;
        let mirrored = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        for (pose, field) in [
            (Pose::at([0.0, nan, 0.0]), "position[1]"),
            (Pose::from_wxyz([0.0; 4], [0.0; 3]), "quaternion"),
            (Pose::from_wxyz([nan, 0.0, 0.0, 1.0], [0.0; 3]), "quaternion"),
            (Pose::from_wxyz([1.0, 1.0, 0.0, 0.0], [0.0; 3]), "quaternion"),
            (Pose::from_rpy([f64::INFINITY, 0.0, 0.0], [0.0; 3]), "rpy[0]"),
            (Pose::from_rotation(mirrored, [0.0; 3]), "rotation"),
            (Pose::from_rotation([[1.0, 0.0, 0.0]; 3], [0.0; 3]), "rotation"),
        ] {
            assert_eq!(pose.unwrap_err().field, field);
        }
    }
}
