// Bundle adjustment, the residuals of models/bundle_adjustment.arael. As in g2o's example for these
// files a camera is nine scalars that steps are added to: rotation vector, translation, focal
// length, two coefficients of distortion. Points are eliminated.
#pragma once

#include "graph.h"

using Camera = Plain<9>;
using Point = Plain<3>;

class BundleSeen : public g2o::BaseBinaryEdge<2, Eigen::Vector2d, Camera, Point> {
 public:
  BundleSeen(const double* pixel, double isigma) : isigma_(isigma) {
    measurement_ << pixel[0], pixel[1];
  }

  template <typename T>
  bool operator()(const T* camera, const T* point, T* r) const {
    T p[3];
    turned(camera, point, p);
    const T depth = -(p[2] + camera[5]);
    const T x = (p[0] + camera[3]) / depth, y = (p[1] + camera[4]) / depth;
    const T square = x * x + y * y;
    const T scale = camera[6] * (T(1.0) + square * (camera[7] + camera[8] * square));
    r[0] = (scale * x - T(measurement_[0])) * T(isigma_);
    r[1] = (scale * y - T(measurement_[1])) * T(isigma_);
    return true;
  }

  G2O_MAKE_AUTO_AD_FUNCTIONS

 private:
  // Rodrigues' formula; its limit where the vector is zero.
  template <typename T>
  static void turned(const T* v, const T* x, T* out) {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const T square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const T cross[3] = {v[1] * x[2] - v[2] * x[1], v[2] * x[0] - v[0] * x[2],
                        v[0] * x[1] - v[1] * x[0]};
    T c(1.0), s(1.0), rest(0.0);
    if (square > T(1e-24)) {
      const T angle = sqrt(square);
      c = cos(angle), s = sin(angle) / angle;
      rest = (T(1.0) - c) / square * (v[0] * x[0] + v[1] * x[1] + v[2] * x[2]);
    }
    for (int i = 0; i < 3; ++i) out[i] = c * x[i] + s * cross[i] + rest * v[i];
  }

  double isigma_;
};

class Bundle : public Graph {
 public:
  explicit Bundle(const Columns& data) {
    const auto &r = data.real("cameras.r"), &t = data.real("cameras.t");
    const auto &f = data.real("cameras.f"), &k1 = data.real("cameras.k1");
    const auto &k2 = data.real("cameras.k2"), &points = data.real("points.pos");
    use<g2o::BlockSolverPL<9, 3>>();
    for (size_t k = 0; k < f.size(); ++k) {
      const Eigen::Quaterniond q(r[4 * k], r[4 * k + 1], r[4 * k + 2], r[4 * k + 3]);
      const Eigen::AngleAxisd turn(q);
      Eigen::Matrix<double, 9, 1> start;
      start << turn.angle() * turn.axis(), t[3 * k], t[3 * k + 1], t[3 * k + 2], f[k], k1[k], k2[k];
      cameras_.push_back(vertex<Camera>(start, false));
    }
    for (size_t k = 0; k < points.size(); k += 3) {
      points_.push_back(
          vertex<Point>(Eigen::Vector3d(points[k], points[k + 1], points[k + 2]), true));
    }
    const auto &seen = data.index("observations.camera"), &of = data.index("observations.point");
    const auto& pixel = data.real("observations.pixel");
    for (size_t k = 0; k < seen.size(); ++k) {
      edge(std::make_shared<BundleSeen>(&pixel[2 * k], data.one("pixel_isigma")), cameras_[seen[k]],
           points_[of[k]]);
    }
  }

  const char* settings() const override {
    return "LM, points eliminated, Eigen's sparse Cholesky, block-wise AMD, automatic derivatives";
  }

  void answer(Answer& out) const override {
    std::vector<double> r, t, f, k1, k2, pos;
    for (const auto& camera : cameras_) {
      const double* at = camera->estimate().data();
      r.insert(r.end(), at, at + 3);
      t.insert(t.end(), at + 3, at + 6);
      f.push_back(at[6]);
      k1.push_back(at[7]);
      k2.push_back(at[8]);
    }
    for (const auto& point : points_) {
      pos.insert(pos.end(), point->estimate().data(), point->estimate().data() + 3);
    }
    out.add("r", 3, r);
    out.add("t", 3, t);
    out.add("f", 1, f);
    out.add("k1", 1, k1);
    out.add("k2", 1, k2);
    out.add("pos", 3, pos);
  }

 private:
  std::vector<std::shared_ptr<Camera>> cameras_;
  std::vector<std::shared_ptr<Point>> points_;
};
