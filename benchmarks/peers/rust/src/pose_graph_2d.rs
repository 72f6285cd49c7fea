//! Planar pose graphs, the residuals of `models/pose_graph_2d.arael`.

use arael::model::*;
use arael::prelude::*;
use arael::simple_lm::LmConfig;

use crate::Problem;
use crate::columns::{Answer, Columns};

#[arael::model]
struct PlanarPose {
    t: Param<vect2d>,
    turn: AngleParam<f64>,
    hb: SelfBlock<PlanarPose>,
}

#[arael::model]
#[arael(constraint(hb, {
    let d = a.turn.rotation_matrix.transpose() * (b.t - a.t) - planaredge.t;
    let x = planaredge.cos * d.x + planaredge.sin * d.y;
    let y = planaredge.cos * d.y - planaredge.sin * d.x;
    let turned = rad_diff(rad_diff(b.turn.angle, a.turn.angle), planaredge.th);
    [planaredge.u[0].x * x + planaredge.u[0].y * y + planaredge.u[0].z * turned,
     planaredge.u[1].y * y + planaredge.u[1].z * turned,
     planaredge.u[2].z * turned]
}))]
struct PlanarEdge {
    #[arael(ref = root.poses)]
    a: Ref<PlanarPose>,
    #[arael(ref = root.poses)]
    b: Ref<PlanarPose>,
    t: vect2d,
    th: f64,
    cos: f64,
    sin: f64,
    u: matrix3d,
    hb: CrossBlock<PlanarPose, PlanarPose>,
}

#[arael::model]
#[arael(constraint(pose.hb, {
    [(pose.t.x - planaranchor.t.x) * planaranchor.t_isigma,
     (pose.t.y - planaranchor.t.y) * planaranchor.t_isigma,
     rad_diff(pose.turn.angle, planaranchor.th) * planaranchor.th_isigma]
}))]
struct PlanarAnchor {
    #[arael(ref = root.poses)]
    pose: Ref<PlanarPose>,
    t: vect2d,
    th: f64,
    t_isigma: f64,
    th_isigma: f64,
}

#[arael::model]
#[arael(root)]
struct PlanarGraph {
    poses: refs::Vec<PlanarPose>,
    edges: std::vec::Vec<PlanarEdge>,
    anchors: std::vec::Vec<PlanarAnchor>,
    #[arael(skip)]
    ids: Vec<f64>,
}

pub fn load(data: &Columns) -> Box<dyn Problem> {
    let ids = data.index("poses.id").iter().map(|&i| i as f64).collect();
    let mut graph = PlanarGraph { poses: refs::Vec::new(), edges: Vec::new(), anchors: Vec::new(), ids };
    let mut poses = Vec::new();
    for (k, &th) in data.real("poses.th").iter().enumerate() {
        poses.push(graph.poses.push(PlanarPose {
            t: Param::new(data.vect2("poses.t", k)),
            turn: AngleParam::new(th),
            hb: SelfBlock::new(),
        }));
    }
    for (k, &pose) in poses.iter().enumerate() {
        graph.poses[pose].t.optimize = data.index("poses.t.fixed")[k] == 0;
        graph.poses[pose].turn.angle.optimize = data.index("poses.th.fixed")[k] == 0;
    }
    for (k, &th) in data.real("edges.th").iter().enumerate() {
        graph.edges.push(PlanarEdge {
            a: poses[data.index("edges.a")[k] as usize],
            b: poses[data.index("edges.b")[k] as usize],
            t: data.vect2("edges.t", k),
            th,
            cos: th.cos(),
            sin: th.sin(),
            u: data.matrix3("edges.u", k),
            hb: CrossBlock::new(),
        });
    }
    for (k, &th) in data.real("anchors.th").iter().enumerate() {
        graph.anchors.push(PlanarAnchor {
            pose: poses[data.index("anchors.pose")[k] as usize],
            t: data.vect2("anchors.t", k),
            th,
            t_isigma: data.real("anchors.t_isigma")[k],
            th_isigma: data.real("anchors.th_isigma")[k],
        });
    }
    Box::new(graph)
}

impl Problem for PlanarGraph {
    fn solve(&mut self, config: &LmConfig<f64>) -> SolveResult<f64> {
        self.solve_sparse(config)
    }

    fn answer(&self, out: &mut Answer) {
        out.add("id", 1, self.ids.clone());
        let t = self.poses.iter().flat_map(|p| [p.t.value.x, p.t.value.y]);
        out.add("t", 2, t.collect());
        out.add("th", 1, self.poses.iter().map(|p| p.turn.angle.value).collect());
    }
}
