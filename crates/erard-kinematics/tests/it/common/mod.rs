//! Linkages that several tests build.

#![allow(dead_code)] // every test file uses some of it

use crate::textbook::{FourBar, SliderCrank};
use erard_kinematics::linkage::{BodyId, JointId, Length, Linkage, PointId};

/// A linkage with its drives still to be chosen.
pub struct Built {
    pub linkage: Linkage,
    pub bodies: Vec<BodyId>,
    pub slide: Option<JointId>,
}

/// Symbols t2 (crank), t3 (coupler), t4 (rocker), as in the closed form.
pub fn four_bar(bar: FourBar) -> Built {
    let mut m = Linkage::new();
    let (bodies, _) = add_four_bar(&mut m, bar);
    Built { linkage: m, bodies, slide: None }
}

/// Adds a four-bar on the ground's origin; returns crank, coupler, rocker and the
/// rocker's pivot.
pub fn add_four_bar(m: &mut Linkage, bar: FourBar) -> (Vec<BodyId>, PointId) {
    let a = m.length("a", bar.a);
    let b = m.length("b", bar.b);
    let c = m.length("c", bar.c);
    let d = m.length("d", bar.d);
    let crank = m.body("crank", "t2");
    let coupler = m.body("coupler", "t3");
    let rocker = m.body("rocker", "t4");
    let tip = m.point(crank, "tip", a, Length::Zero);
    let joint = m.point(coupler, "joint", b, Length::Zero);
    let knee = m.point(rocker, "knee", c, Length::Zero);
    let far = m.point(m.ground(), "far", d, Length::Zero);
    m.revolute("A", m.origin(m.ground()), m.origin(crank));
    m.revolute("B", tip, m.origin(coupler));
    m.revolute("C", joint, knee);
    m.revolute("D", far, m.origin(rocker));
    (vec![crank, coupler, rocker], far)
}

/// Symbols t (crank), p (rod), x (slider), as in the closed form.
pub fn slider_crank(crank_rod: SliderCrank) -> Built {
    let mut m = Linkage::new();
    let r = m.length("r", crank_rod.r);
    let l = m.length("l", crank_rod.l);
    let e = if crank_rod.e == 0.0 { Length::Zero } else { m.length("e", crank_rod.e) };
    let crank = m.body("crank", "t");
    let rod = m.body("rod", "p");
    let block = m.slider("block");
    let tip = m.point(crank, "tip", r, Length::Zero);
    let end = m.point(rod, "end", l, Length::Zero);
    let line = m.point(m.ground(), "line", Length::Zero, e);
    m.revolute("main", m.origin(m.ground()), m.origin(crank));
    m.revolute("big end", tip, m.origin(rod));
    m.revolute("small end", end, m.origin(block));
    let slide = m.prismatic("cylinder", "x", line, erard_kinematics::linkage::Direction::X, m.origin(block));
    Built { linkage: m, bodies: vec![crank, rod], slide: Some(slide) }
}

/// The absolute difference of two angles up to whole turns.
pub fn angle_error(a: f64, b: f64) -> f64 {
    erard_kinematics::linkage::closed_form::wrap(a - b).abs()
}
