//! Maps of planes, the residuals of `models/plane_slam.arael`.

use arael::model::*;
use arael::prelude::*;
use arael::simple_lm::LmConfig;

use crate::Problem;
use crate::columns::{Answer, Columns, flat_matrix3, flat3};

#[arael::model]
struct PlanePose {
    pos: Param<vect3d>,
    ea: SimpleEulerAngleParam<f64>,
    hb: SelfBlock<PlanePose>,
}

#[arael::model]
struct Plane {
    n: UnitVecParam<f64>,
    c: Param<f64>,
    hb: SelfBlock<Plane>,
}

#[arael::model]
#[arael(constraint(hb, {
    let off = pose.ea.rotation_matrix().transpose() * plane.n.unit - planeseen.n;
    let far = plane.n.unit.x * pose.pos.x + plane.n.unit.y * pose.pos.y
        + plane.n.unit.z * pose.pos.z + plane.c;
    [off.x * planemap.normal_isigma, off.y * planemap.normal_isigma, off.z * planemap.normal_isigma,
     (far - planeseen.c) * planemap.distance_isigma]
}))]
struct PlaneSeen {
    #[arael(ref = root.poses)]
    pose: Ref<PlanePose>,
    #[arael(ref = root.planes)]
    plane: Ref<Plane>,
    n: vect3d,
    c: f64,
    hb: CrossBlock<PlanePose, Plane>,
}

#[arael::model]
#[arael(constraint(hb, {
    let from = prev.ea.rotation_matrix();
    let moved = from.transpose() * (cur.pos - prev.pos) - planepair.delta_pos;
    let expected = from * planepair.delta_ea.rotation_matrix();
    let turned = (expected.transpose() * cur.ea.rotation_matrix()).get_euler_angles();
    [moved.x * planemap.odometry_pos_isigma, moved.y * planemap.odometry_pos_isigma,
     moved.z * planemap.odometry_pos_isigma,
     turned.x * planemap.odometry_ea_isigma, turned.y * planemap.odometry_ea_isigma,
     turned.z * planemap.odometry_ea_isigma]
}))]
struct PlanePair {
    #[arael(ref = root.poses)]
    prev: Ref<PlanePose>,
    #[arael(ref = root.poses)]
    cur: Ref<PlanePose>,
    delta_pos: vect3d,
    delta_ea: vect3d,
    hb: CrossBlock<PlanePose, PlanePose>,
}

#[arael::model]
#[arael(constraint(pose.hb, {
    let off = pose.pos - planeanchor.pos;
    let turned = (planeanchor.ea.rotation_matrix().transpose() * pose.ea.rotation_matrix())
        .get_euler_angles();
    [off.x * planemap.anchor_pos_isigma, off.y * planemap.anchor_pos_isigma,
     off.z * planemap.anchor_pos_isigma,
     turned.x * planemap.anchor_ea_isigma, turned.y * planemap.anchor_ea_isigma,
     turned.z * planemap.anchor_ea_isigma]
}))]
struct PlaneAnchor {
    #[arael(ref = root.poses)]
    pose: Ref<PlanePose>,
    pos: vect3d,
    ea: vect3d,
}

#[arael::model]
#[arael(root)]
struct PlaneMap {
    poses: refs::Vec<PlanePose>,
    planes: refs::Vec<Plane>,
    seen: std::vec::Vec<PlaneSeen>,
    pairs: std::vec::Vec<PlanePair>,
    anchors: std::vec::Vec<PlaneAnchor>,
    normal_isigma: f64,
    distance_isigma: f64,
    odometry_pos_isigma: f64,
    odometry_ea_isigma: f64,
    anchor_pos_isigma: f64,
    anchor_ea_isigma: f64,
}

pub fn load(data: &Columns) -> Box<dyn Problem> {
    let mut map = PlaneMap {
        poses: refs::Vec::new(),
        planes: refs::Vec::new(),
        seen: Vec::new(),
        pairs: Vec::new(),
        anchors: Vec::new(),
        normal_isigma: data.one("normal_isigma"),
        distance_isigma: data.one("distance_isigma"),
        odometry_pos_isigma: data.one("odometry_pos_isigma"),
        odometry_ea_isigma: data.one("odometry_ea_isigma"),
        anchor_pos_isigma: data.one("anchor_pos_isigma"),
        anchor_ea_isigma: data.one("anchor_ea_isigma"),
    };
    let (mut poses, mut planes) = (Vec::new(), Vec::new());
    for k in 0..data.real("poses.pos").len() / 3 {
        poses.push(map.poses.push(PlanePose {
            pos: Param::new(data.vect3("poses.pos", k)),
            ea: SimpleEulerAngleParam::new(data.vect3("poses.ea", k)),
            hb: SelfBlock::new(),
        }));
    }
    for (k, &c) in data.real("planes.c").iter().enumerate() {
        planes.push(map.planes.push(Plane {
            n: UnitVecParam::new(data.vect3("planes.n", k)),
            c: Param::new(c),
            hb: SelfBlock::new(),
        }));
    }
    for (k, &c) in data.real("observations.c").iter().enumerate() {
        map.seen.push(PlaneSeen {
            pose: poses[data.index("observations.pose")[k] as usize],
            plane: planes[data.index("observations.plane")[k] as usize],
            n: data.vect3("observations.n", k),
            c,
            hb: CrossBlock::new(),
        });
    }
    for (k, &prev) in data.index("pose_pairs.prev").iter().enumerate() {
        map.pairs.push(PlanePair {
            prev: poses[prev as usize],
            cur: poses[data.index("pose_pairs.cur")[k] as usize],
            delta_pos: data.vect3("pose_pairs.delta_pos", k),
            delta_ea: data.vect3("pose_pairs.delta_ea", k),
            hb: CrossBlock::new(),
        });
    }
    for (k, &pose) in data.index("anchors.pose").iter().enumerate() {
        map.anchors.push(PlaneAnchor {
            pose: poses[pose as usize],
            pos: data.vect3("anchors.pos", k),
            ea: data.vect3("anchors.ea", k),
        });
    }
    Box::new(map)
}

impl Problem for PlaneMap {
    fn solve(&mut self, config: &LmConfig<f64>) -> SolveResult<f64> {
        self.solve_sparse(config)
    }

    fn answer(&self, out: &mut Answer) {
        out.add("pos", 3, flat3(self.poses.iter().map(|p| p.pos.value)));
        out.add("rotation", 9, flat_matrix3(self.poses.iter().map(|p| p.ea.value.rotation_matrix())));
        out.add("n", 3, flat3(self.planes.iter().map(|p| p.n.unit)));
        out.add("c", 1, self.planes.iter().map(|p| p.c.value).collect());
    }
}
