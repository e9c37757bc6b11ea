//! Linkages with textbook solutions, independent of graph, equations and step. The tests of `erard-kinematics`
//! also compare its solver with them.

/// Four-bar linkage: crank `a` from the origin, coupler `b`, rocker `c` from `(d, 0)`. Lengths in metres, angles
/// absolute: `a u(t2) + b u(t3) - c u(t4) - (d, 0) = 0`, with `u` the unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourBar {
    /// Length of the crank, m.
    pub a: f64,
    /// Length of the coupler, m.
    pub b: f64,
    /// Length of the rocker, m.
    pub c: f64,
    /// Distance from the crank's pivot to the rocker's, m.
    pub d: f64,
}

/// Angles of coupler and rocker (rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourBarPose {
    /// Angle of the coupler, rad.
    pub t3: f64,
    /// Angle of the rocker, rad.
    pub t4: f64,
}

impl FourBar {
    /// Returns the pose at crank angle `t2` (rad): the intersection of the circles about the crank's end (radius `b`)
    /// and the rocker's pivot (radius `c`). `side` +1 places the joint to the left of the way from the crank's end to
    /// the rocker's pivot, -1 to the right. `None` if the circles do not meet.
    #[must_use]
    pub fn pose(&self, t2: f64, side: f64) -> Option<FourBarPose> {
        let (s, c) = t2.sin_cos();
        let (px, py) = (self.a * c, self.a * s);
        let (dx, dy) = (self.d - px, -py);
        let distance = dx.hypot(dy);
        // Along the way to the rocker's pivot, and square to it.
        let along = (self.b * self.b - self.c * self.c + distance * distance) / (2.0 * distance);
        let square = self.b * self.b - along * along;
        if square < 0.0 || square.is_nan() {
            return None;
        }
        let across = side * square.sqrt();
        let (ex, ey) = (dx / distance, dy / distance);
        let joint = (px + along * ex - across * ey, py + along * ey + across * ex);
        Some(FourBarPose { t3: (joint.1 - py).atan2(joint.0 - px), t4: joint.1.atan2(joint.0 - self.d) })
    }

    /// Returns the textbook's velocity ratios `(dt3/dt2, dt4/dt2)` at a pose. Infinite or NaN where coupler and rocker
    /// are in line.
    #[must_use]
    pub fn rates(&self, t2: f64, pose: FourBarPose) -> (f64, f64) {
        let between = (pose.t4 - pose.t3).sin();
        (self.a * (t2 - pose.t4).sin() / (self.b * between), self.a * (t2 - pose.t3).sin() / (self.c * between))
    }

    /// Returns the limits of the crank angle (rad, 0 to π) of a crank that cannot turn fully: coupler and rocker in
    /// line, `a² + d² - 2ad cos t2 = (b ± c)²`.
    #[must_use]
    pub fn dead_centres(&self) -> [Option<f64>; 2] {
        [self.b + self.c, self.b - self.c].map(|reach| {
            let cosine = (self.a * self.a + self.d * self.d - reach * reach) / (2.0 * self.a * self.d);
            (cosine.abs() <= 1.0).then(|| cosine.acos())
        })
    }
}

/// Slider-crank: crank `r` from the origin, rod `l`, slider on the line `y = e` at `x > 0` (on the far side of the
/// crank): `r u(t) + l u(p) = (x, e)`. Metres, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SliderCrank {
    /// Length of the crank, m.
    pub r: f64,
    /// Length of the connecting rod, m.
    pub l: f64,
    /// Height of the slider's line above the crank's pivot, m.
    pub e: f64,
}

impl SliderCrank {
    /// Returns rod angle (rad) and slider position (m) at crank angle `t` (rad); `None` if the rod is too short.
    #[must_use]
    pub fn pose(&self, t: f64) -> Option<(f64, f64)> {
        let (s, c) = t.sin_cos();
        let sine = (self.e - self.r * s) / self.l;
        (sine.abs() <= 1.0).then(|| {
            let p = sine.asin();
            (p, self.r * c + self.l * p.cos())
        })
    }

    /// Returns the derivative `dx/dt` of slider position by crank angle, in metres per radian; `None` if the rod is too
    /// short.
    #[must_use]
    pub fn slider_rate(&self, t: f64) -> Option<f64> {
        let (p, _) = self.pose(t)?;
        let rod = -self.r * t.cos() / (self.l * p.cos());
        Some(-self.r * t.sin() - self.l * p.sin() * rod)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The textbook four-bar closes its own loop. Rounding of square root and
    /// arctangent leaves a few 1e-16; 1e-14 allows for cancellation near a dead centre.
    #[test]
    fn four_bar_closes() {
        let bar = FourBar { a: 0.1, b: 0.25, c: 0.3, d: 0.35 };
        for step in 0..64 {
            let t2 = f64::from(step) * 0.1;
            for side in [1.0, -1.0] {
                let pose = bar.pose(t2, side).expect("a Grashof crank turns fully");
                let x = bar.a * t2.cos() + bar.b * pose.t3.cos() - bar.c * pose.t4.cos() - bar.d;
                let y = bar.a * t2.sin() + bar.b * pose.t3.sin() - bar.c * pose.t4.sin();
                assert!(x.hypot(y) < 1e-14, "{t2}: {x} {y}");
            }
        }
    }

    /// Out of reach is `None`: never a number.
    #[test]
    fn too_short_a_rod_has_no_pose() {
        let short = SliderCrank { r: 0.1, l: 0.05, e: 0.0 };
        assert_eq!(short.pose(std::f64::consts::FRAC_PI_2), None);
    }
}
