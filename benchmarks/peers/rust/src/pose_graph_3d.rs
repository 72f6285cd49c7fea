//! Spatial pose graphs, the residuals of `models/pose_graph_3d.arael`. The vector part of a relative
//! quaternion is taken from the rotation matrix: (m21 - m12, ...) / (4 w), with 4 w^2 = 1 + trace.

use arael::model::*;
use arael::prelude::*;
use arael::simple_lm::LmConfig;

use crate::Problem;
use crate::columns::{Answer, Columns, flat3};

#[arael::model]
struct SpatialPose {
    t: Param<vect3d>,
    q: QuaternionParam<f64>,
    hb: SelfBlock<SpatialPose>,
}

#[arael::model]
#[arael(constraint(hb, {
    let back = a.q.rotation_matrix().transpose();
    let d = back * (b.t - a.t) - spatialedge.t;
    let m = spatialedge.back * (back * b.q.rotation_matrix());
    let k = 1.0 / sqrt(1.0 + m[0].x + m[1].y + m[2].z);
    let p = (m[2].y - m[1].z) * k;
    let q = (m[0].z - m[2].x) * k;
    let r = (m[1].x - m[0].y) * k;
    let u = spatialedge.u;
    [u[0][0] * d.x + u[0][1] * d.y + u[0][2] * d.z + u[0][3] * p + u[0][4] * q + u[0][5] * r,
     u[1][1] * d.y + u[1][2] * d.z + u[1][3] * p + u[1][4] * q + u[1][5] * r,
     u[2][2] * d.z + u[2][3] * p + u[2][4] * q + u[2][5] * r,
     u[3][3] * p + u[3][4] * q + u[3][5] * r,
     u[4][4] * q + u[4][5] * r,
     u[5][5] * r]
}))]
struct SpatialEdge {
    #[arael(ref = root.poses)]
    a: Ref<SpatialPose>,
    #[arael(ref = root.poses)]
    b: Ref<SpatialPose>,
    t: vect3d,
    back: matrix3d,
    u: matrixd<6, 6>,
    hb: CrossBlock<SpatialPose, SpatialPose>,
}

#[arael::model]
#[arael(constraint(pose.hb, {
    let d = pose.t - spatialanchor.t;
    let m = spatialanchor.back * pose.q.rotation_matrix();
    let k = 1.0 / sqrt(1.0 + m[0].x + m[1].y + m[2].z);
    [d.x * spatialanchor.t_isigma, d.y * spatialanchor.t_isigma, d.z * spatialanchor.t_isigma,
     (m[2].y - m[1].z) * k, (m[0].z - m[2].x) * k, (m[1].x - m[0].y) * k]
}))]
struct SpatialAnchor {
    #[arael(ref = root.poses)]
    pose: Ref<SpatialPose>,
    t: vect3d,
    back: matrix3d,
    t_isigma: f64,
}

#[arael::model]
#[arael(root)]
struct SpatialGraph {
    poses: refs::Vec<SpatialPose>,
    edges: std::vec::Vec<SpatialEdge>,
    anchors: std::vec::Vec<SpatialAnchor>,
    #[arael(skip)]
    ids: Vec<f64>,
}

pub fn load(data: &Columns) -> Box<dyn Problem> {
    let ids: Vec<f64> = data.index("poses.id").iter().map(|&i| i as f64).collect();
    let mut poses = Vec::new();
    let mut graph = SpatialGraph { poses: refs::Vec::new(), edges: Vec::new(), anchors: Vec::new(), ids };
    for k in 0..graph.ids.len() {
        poses.push(graph.poses.push(SpatialPose {
            t: Param::new(data.vect3("poses.t", k)),
            q: QuaternionParam::new(data.quatern("poses.q", k).unit()),
            hb: SelfBlock::new(),
        }));
    }
    for (k, &pose) in poses.iter().enumerate() {
        graph.poses[pose].t.optimize = data.index("poses.t.fixed")[k] == 0;
        graph.poses[pose].q.optimize = data.index("poses.q.fixed")[k] == 0;
    }
    let upper = data.real("edges.u");
    for (k, &a) in data.index("edges.a").iter().enumerate() {
        let mut u = [[0.0; 6]; 6];
        for i in 0..6 {
            u[i].copy_from_slice(&upper[36 * k + 6 * i..36 * k + 6 * i + 6]);
        }
        graph.edges.push(SpatialEdge {
            a: poses[a as usize],
            b: poses[data.index("edges.b")[k] as usize],
            t: data.vect3("edges.t", k),
            back: data.quatern("edges.q", k).unit().rotation_matrix().transpose(),
            u: matrixd::from_array(u),
            hb: CrossBlock::new(),
        });
    }
    for (k, &pose) in data.index("anchors.pose").iter().enumerate() {
        graph.anchors.push(SpatialAnchor {
            pose: poses[pose as usize],
            t: data.vect3("anchors.t", k),
            back: data.quatern("anchors.q", k).unit().rotation_matrix().transpose(),
            t_isigma: data.real("anchors.t_isigma")[k],
        });
    }
    Box::new(graph)
}

impl Problem for SpatialGraph {
    fn solve(&mut self, config: &LmConfig<f64>) -> SolveResult<f64> {
        self.solve_sparse(config)
    }

    fn answer(&self, out: &mut Answer) {
        out.add("id", 1, self.ids.clone());
        out.add("t", 3, flat3(self.poses.iter().map(|p| p.t.value)));
        let q = self.poses.iter().map(|p| p.q.value).flat_map(|q| [q.t, q.v.x, q.v.y, q.v.z]);
        out.add("q", 4, q.collect());
    }
}
