// Bundle adjustment, the residuals of models/bundle_adjustment.arael. A camera is a unit quaternion
// (w x y z), a translation, a focal length and two coefficients of distortion; points are eliminated.
#pragma once

#include <ceres/rotation.h>

#include "problem.h"

struct BundleSeen {
  const double* pixel;
  double isigma;

  template <typename T>
  bool operator()(const T* camera, const T* point, T* r) const {
    T p[3];
    ceres::UnitQuaternionRotatePoint(camera, point, p);
    const T depth = -(p[2] + camera[6]);
    const T x = (p[0] + camera[4]) / depth, y = (p[1] + camera[5]) / depth;
    const T square = x * x + y * y;
    const T scale = camera[7] * (1.0 + square * (camera[8] + camera[9] * square));
    r[0] = (scale * x - pixel[0]) * isigma;
    r[1] = (scale * y - pixel[1]) * isigma;
    return true;
  }
};

class Bundle : public Problem {
 public:
  explicit Bundle(const Columns& data) {
    const auto &r = data.real("cameras.r"), &t = data.real("cameras.t");
    const auto &f = data.real("cameras.f"), &k1 = data.real("cameras.k1");
    const auto &k2 = data.real("cameras.k2"), &points = data.real("points.pos");
    cameras_ = f.size(), points_ = points.size() / 3;
    for (size_t k = 0; k < cameras_; ++k) {
      state_.insert(state_.end(), &r[4 * k], &r[4 * k] + 4);
      state_.insert(state_.end(), &t[3 * k], &t[3 * k] + 3);
      state_.insert(state_.end(), {f[k], k1[k], k2[k]});
    }
    state_.insert(state_.end(), points.begin(), points.end());
    using Turned = ceres::ProductManifold<ceres::QuaternionManifold, ceres::EuclideanManifold<6>>;
    for (size_t k = 0; k < cameras_; ++k) {
      problem_.AddParameterBlock(camera(k), kWidth, new Turned());
      order_.AddElementToGroup(camera(k), 1);
    }
    for (size_t k = 0; k < points_; ++k) {
      problem_.AddParameterBlock(point(k), 3);
      order_.AddElementToGroup(point(k), 0);
    }
    const auto &seen = data.index("observations.camera"), &of = data.index("observations.point");
    for (size_t k = 0; k < seen.size(); ++k) {
      auto* ray = new BundleSeen{&data.real("observations.pixel")[2 * k], data.one("pixel_isigma")};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<BundleSeen, 2, kWidth, 3>(ray),
                                nullptr, camera(seen[k]), point(of[k]));
    }
    remember(state_);
  }

  const char* settings() const override {
    return "LM, SPARSE_SCHUR (points eliminated, SuiteSparse), automatic derivatives";
  }

  void answer(Answer& out) const override {
    std::vector<double> r, t, f, k1, k2;
    for (size_t k = 0; k < cameras_; ++k) {
      const double* at = &state_[kWidth * k];
      double vector[3];
      ceres::QuaternionToAngleAxis(at, vector);
      r.insert(r.end(), vector, vector + 3);
      t.insert(t.end(), at + 4, at + 7);
      f.push_back(at[7]);
      k1.push_back(at[8]);
      k2.push_back(at[9]);
    }
    out.add("r", 3, r);
    out.add("t", 3, t);
    out.add("f", 1, f);
    out.add("k1", 1, k1);
    out.add("k2", 1, k2);
    out.add("pos", 3, {state_.begin() + kWidth * cameras_, state_.end()});
  }

 protected:
  void configure(ceres::Solver::Options& options) const override {
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>(order_);
  }

 private:
  static constexpr int kWidth = 10;

  double* camera(int64_t k) { return &state_[kWidth * k]; }
  double* point(int64_t k) { return &state_[kWidth * cameras_ + 3 * k]; }

  size_t cameras_ = 0, points_ = 0;
  ceres::ParameterBlockOrdering order_;
  std::vector<double> state_;
};
