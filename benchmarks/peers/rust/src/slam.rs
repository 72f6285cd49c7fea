//! Visual-inertial SLAM, the residuals of `models/slam.arael`.

use arael::model::*;
use arael::prelude::*;
use arael::simple_lm::LmConfig;

use crate::Problem;
use crate::columns::{Answer, Columns, flat_matrix3, flat3};

#[arael::model]
struct SlamFeature {
    mf2r: matrix3d,
    camera_pos: vect3d,
    isigma: vect2d,
}

#[arael::model]
struct SlamGps {
    pos: vect3d,
    cov_r: matrix3d,
    cov_isigma: vect3d,
}

#[arael::model]
struct SlamInfo {
    delta_pos: vect3d,
    delta_ea: vect3d,
    delta_pos_cov_r: matrix3d,
    delta_pos_cov_isigma: vect3d,
    delta_ea_cov_r: matrix3d,
    delta_ea_cov_isigma: vect3d,
    gps: Option<SlamGps>,
    tilt_roll: f64,
    tilt_pitch: f64,
    features: refs::Vec<SlamFeature>,
}

#[arael::model]
#[arael(constraint(hb, guard = self.info.gps.is_some(), {
    let g = slammap.gamma;
    let off = slampose.info.gps.cov_r.transpose() * (slampose.pos - slampose.info.gps.pos);
    [g * atan(off.x * slampose.info.gps.cov_isigma.x / g),
     g * atan(off.y * slampose.info.gps.cov_isigma.y / g),
     g * atan(off.z * slampose.info.gps.cov_isigma.z / g)]
}))]
#[arael(constraint(hb, {
    let dp = slampose.pos - slampose.pos_value;
    let de = slampose.ea - slampose.ea_value;
    [dp.x * slammap.drift_pos_isigma, dp.y * slammap.drift_pos_isigma, dp.z * slammap.drift_pos_isigma,
     de.x * slammap.drift_ea_isigma, de.y * slammap.drift_ea_isigma, de.z * slammap.drift_ea_isigma]
}))]
#[arael(constraint(hb, {
    [(slampose.ea.x - slampose.info.tilt_roll) * slammap.tilt_isigma,
     (slampose.ea.y - slampose.info.tilt_pitch) * slammap.tilt_isigma]
}))]
struct SlamPose {
    pos: Param<vect3d>,
    ea: SimpleEulerAngleParam<f64>,
    info: SlamInfo,
    hb: SelfBlock<SlamPose>,
}

#[arael::model]
#[arael(constraint(hb_drift, {
    let dp = slamlandmark.pos - slamlandmark.pos_value;
    [dp.x * slammap.drift_lm_isigma, dp.y * slammap.drift_lm_isigma, dp.z * slammap.drift_lm_isigma]
}))]
struct SlamLandmark {
    pos: Param<vect3d>,
    frines: std::vec::Vec<SlamFrine>,
    hb_drift: SelfBlock<SlamLandmark>,
}

#[arael::model]
#[arael(constraint(hb, parent = lm, {
    let g = slammap.gamma;
    let in_body = pose.ea.rotation_matrix().transpose() * (lm.pos - pose.pos);
    let ray = feature.mf2r.transpose() * (in_body - feature.camera_pos);
    let across = atan2(ray.y, ray.x) * feature.isigma.x * slammap.frine_isigma_scale;
    let up = atan2(ray.z, ray.x) * feature.isigma.y * slammap.frine_isigma_scale;
    [g * atan(across / g), g * atan(up / g)]
}))]
struct SlamFrine {
    #[arael(ref = root.poses)]
    pose: Ref<SlamPose>,
    #[arael(ref = pose.info.features)]
    feature: Ref<SlamFeature>,
    hb: CrossBlock<SlamLandmark, SlamPose>,
}

#[arael::model]
#[arael(constraint(hb, {
    let from = prev.ea.rotation_matrix();
    let moved = from.transpose() * (cur.pos - prev.pos) - cur.info.delta_pos;
    let expected = from * cur.info.delta_ea.rotation_matrix();
    let turned = (expected.transpose() * cur.ea.rotation_matrix()).get_euler_angles();
    let p = cur.info.delta_pos_cov_r.transpose() * moved;
    let q = cur.info.delta_ea_cov_r.transpose() * turned;
    [p.x * cur.info.delta_pos_cov_isigma.x, p.y * cur.info.delta_pos_cov_isigma.y,
     p.z * cur.info.delta_pos_cov_isigma.z,
     q.x * cur.info.delta_ea_cov_isigma.x, q.y * cur.info.delta_ea_cov_isigma.y,
     q.z * cur.info.delta_ea_cov_isigma.z]
}))]
struct SlamPair {
    #[arael(ref = root.poses)]
    prev: Ref<SlamPose>,
    #[arael(ref = root.poses)]
    cur: Ref<SlamPose>,
    hb: CrossBlock<SlamPose, SlamPose>,
}

#[arael::model]
#[arael(root)]
struct SlamMap {
    poses: refs::Deque<SlamPose>,
    landmarks: refs::Vec<SlamLandmark>,
    pairs: std::vec::Vec<SlamPair>,
    gamma: f64,
    drift_pos_isigma: f64,
    drift_ea_isigma: f64,
    drift_lm_isigma: f64,
    tilt_isigma: f64,
    frine_isigma_scale: f64,
}

pub fn load(data: &Columns) -> Box<dyn Problem> {
    let mut map = SlamMap {
        poses: refs::Deque::new(),
        landmarks: refs::Vec::new(),
        pairs: Vec::new(),
        gamma: data.one("gamma"),
        drift_pos_isigma: data.one("drift_pos_isigma"),
        drift_ea_isigma: data.one("drift_ea_isigma"),
        drift_lm_isigma: data.one("drift_lm_isigma"),
        tilt_isigma: data.one("tilt_isigma"),
        frine_isigma_scale: data.one("frine_isigma_scale"),
    };
    let features = data.index("poses.info.features.offsets");
    let mut poses = Vec::new();
    for k in 0..features.len() - 1 {
        let mut seen = refs::Vec::new();
        for f in features[k] as usize..features[k + 1] as usize {
            seen.push(SlamFeature {
                mf2r: data.matrix3("poses.info.features.mf2r", f),
                camera_pos: data.vect3("poses.info.features.camera_pos", f),
                isigma: data.vect2("poses.info.features.isigma", f),
            });
        }
        let has_gps = data.index("poses.info.gps")[k] != 0;
        poses.push(map.poses.push_back(SlamPose {
            pos: Param::new(data.vect3("poses.pos", k)),
            ea: SimpleEulerAngleParam::new(data.vect3("poses.ea", k)),
            info: SlamInfo {
                delta_pos: data.vect3("poses.info.delta_pos", k),
                delta_ea: data.vect3("poses.info.delta_ea", k),
                delta_pos_cov_r: data.matrix3("poses.info.delta_pos_cov_r", k),
                delta_pos_cov_isigma: data.vect3("poses.info.delta_pos_cov_isigma", k),
                delta_ea_cov_r: data.matrix3("poses.info.delta_ea_cov_r", k),
                delta_ea_cov_isigma: data.vect3("poses.info.delta_ea_cov_isigma", k),
                gps: has_gps.then(|| SlamGps {
                    pos: data.vect3("poses.info.gps.pos", k),
                    cov_r: data.matrix3("poses.info.gps.cov_r", k),
                    cov_isigma: data.vect3("poses.info.gps.cov_isigma", k),
                }),
                tilt_roll: data.real("poses.info.tilt_roll")[k],
                tilt_pitch: data.real("poses.info.tilt_pitch")[k],
                features: seen,
            },
            hb: SelfBlock::new(),
        }));
    }
    let bounds = data.index("landmarks.frines.offsets");
    let (pose, feature) = (data.index("landmarks.frines.pose"), data.index("landmarks.frines.feature"));
    for j in 0..bounds.len() - 1 {
        let frines = (bounds[j] as usize..bounds[j + 1] as usize)
            .map(|f| {
                let at = poses[pose[f] as usize];
                SlamFrine {
                    pose: at,
                    feature: map.poses[at].info.features.ref_at(feature[f] as usize),
                    hb: CrossBlock::new(),
                }
            })
            .collect();
        map.landmarks.push(SlamLandmark {
            pos: Param::new(data.vect3("landmarks.pos", j)),
            frines,
            hb_drift: SelfBlock::new(),
        });
    }
    let pairs = data.index("pose_pairs.prev").iter().zip(data.index("pose_pairs.cur"));
    map.pairs = pairs
        .map(|(&a, &b)| SlamPair { prev: poses[a as usize], cur: poses[b as usize], hb: CrossBlock::new() })
        .collect();
    Box::new(map)
}

impl Problem for SlamMap {
    fn solve(&mut self, config: &LmConfig<f64>) -> SolveResult<f64> {
        self.solve_sparse(config)
    }

    fn answer(&self, out: &mut Answer) {
        out.add("pos", 3, flat3(self.poses.iter().map(|p| p.pos.value)));
        out.add("rotation", 9, flat_matrix3(self.poses.iter().map(|p| p.ea.value.rotation_matrix())));
        out.add("landmarks", 3, flat3(self.landmarks.iter().map(|l| l.pos.value)));
    }
}
