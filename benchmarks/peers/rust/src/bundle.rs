//! Bundle adjustment, the residuals of `models/bundle_adjustment.arael`.

use arael::model::*;
use arael::prelude::*;
use arael::simple_lm::LmConfig;

use crate::Problem;
use crate::columns::{Answer, Columns, flat3};

#[arael::model]
struct BundleCamera {
    r: QuaternionParam<f64>,
    t: Param<vect3d>,
    f: Param<f64>,
    k1: Param<f64>,
    k2: Param<f64>,
    hb: SelfBlock<BundleCamera>,
}

#[arael::model]
struct BundlePoint {
    pos: Param<vect3d>,
    hb: SelfBlock<BundlePoint>,
}

#[arael::model]
#[arael(constraint(hb, {
    let p = camera.r.rotation_matrix() * point.pos + camera.t;
    let x = -p.x / p.z;
    let y = -p.y / p.z;
    let r2 = x * x + y * y;
    let scale = camera.f * (1.0 + r2 * (camera.k1 + camera.k2 * r2));
    [(scale * x - bundleseen.pixel.x) * bundle.pixel_isigma,
     (scale * y - bundleseen.pixel.y) * bundle.pixel_isigma]
}))]
struct BundleSeen {
    #[arael(ref = root.cameras)]
    camera: Ref<BundleCamera>,
    #[arael(ref = root.points)]
    point: Ref<BundlePoint>,
    pixel: vect2d,
    hb: CrossBlock<BundleCamera, BundlePoint>,
}

#[arael::model]
#[arael(root)]
struct Bundle {
    cameras: refs::Vec<BundleCamera>,
    points: refs::Vec<BundlePoint>,
    seen: std::vec::Vec<BundleSeen>,
    pixel_isigma: f64,
}

pub fn load(data: &Columns) -> Box<dyn Problem> {
    let mut bundle = Bundle {
        cameras: refs::Vec::new(),
        points: refs::Vec::new(),
        seen: Vec::new(),
        pixel_isigma: data.one("pixel_isigma"),
    };
    let (mut cameras, mut points) = (Vec::new(), Vec::new());
    for (k, &f) in data.real("cameras.f").iter().enumerate() {
        cameras.push(bundle.cameras.push(BundleCamera {
            r: QuaternionParam::new(data.quatern("cameras.r", k).unit()),
            t: Param::new(data.vect3("cameras.t", k)),
            f: Param::new(f),
            k1: Param::new(data.real("cameras.k1")[k]),
            k2: Param::new(data.real("cameras.k2")[k]),
            hb: SelfBlock::new(),
        }));
    }
    for k in 0..data.real("points.pos").len() / 3 {
        points.push(bundle.points.push(BundlePoint {
            pos: Param::new(data.vect3("points.pos", k)),
            hb: SelfBlock::new(),
        }));
    }
    for (k, &camera) in data.index("observations.camera").iter().enumerate() {
        bundle.seen.push(BundleSeen {
            camera: cameras[camera as usize],
            point: points[data.index("observations.point")[k] as usize],
            pixel: data.vect2("observations.pixel", k),
            hb: CrossBlock::new(),
        });
    }
    Box::new(bundle)
}

impl Problem for Bundle {
    fn solve(&mut self, config: &LmConfig<f64>) -> SolveResult<f64> {
        self.solve_sparse(config)
    }

    fn answer(&self, out: &mut Answer) {
        let turns = self.cameras.iter().map(|c| {
            let (axis, angle) = c.r.value.get_axis_angle();
            axis * angle
        });
        out.add("r", 3, flat3(turns));
        out.add("t", 3, flat3(self.cameras.iter().map(|c| c.t.value)));
        out.add("f", 1, self.cameras.iter().map(|c| c.f.value).collect());
        out.add("k1", 1, self.cameras.iter().map(|c| c.k1.value).collect());
        out.add("k2", 1, self.cameras.iter().map(|c| c.k2.value).collect());
        out.add("pos", 3, flat3(self.points.iter().map(|p| p.pos.value)));
    }
}
