// Maps of planes, the residuals of models/plane_slam.arael. A pose is x y z roll pitch yaw, a plane
// its unit normal, on the sphere, and its offset.
#pragma once

#include "problem.h"
#include "../cpp/rotations.h"

struct PlaneSeen {
  const double* n;
  double c, normal_isigma, distance_isigma;

  template <typename T>
  bool operator()(const T* pose, const T* plane, T* r) const {
    T m[9];
    rotation(pose + 3, m);
    for (int i = 0; i < 3; ++i) {
      r[i] = (m[i] * plane[0] + m[3 + i] * plane[1] + m[6 + i] * plane[2] - n[i]) * normal_isigma;
    }
    const T far = plane[0] * pose[0] + plane[1] * pose[1] + plane[2] * pose[2] + plane[3];
    r[3] = (far - c) * distance_isigma;
    return true;
  }
};

struct PlanePair {
  const double* pos;
  double turn[9];
  double pos_isigma, ea_isigma;

  template <typename T>
  bool operator()(const T* prev, const T* cur, T* r) const {
    T from[9], to[9], expected[9], turned[9];
    rotation(prev + 3, from);
    rotation(cur + 3, to);
    for (int i = 0; i < 3; ++i) {
      const T moved = from[i] * (cur[0] - prev[0]) + from[3 + i] * (cur[1] - prev[1]) +
                      from[6 + i] * (cur[2] - prev[2]);
      r[i] = (moved - pos[i]) * pos_isigma;
    }
    product(from, turn, expected);
    product_back(expected, to, turned);
    euler_angles(turned, r + 3);
    for (int i = 3; i < 6; ++i) r[i] *= ea_isigma;
    return true;
  }
};

struct PlaneAnchor {
  const double* pos;
  double turn[9];
  double pos_isigma, ea_isigma;

  template <typename T>
  bool operator()(const T* pose, T* r) const {
    T m[9], turned[9];
    rotation(pose + 3, m);
    product_back(turn, m, turned);
    euler_angles(turned, r + 3);
    for (int i = 0; i < 3; ++i) {
      r[i] = (pose[i] - pos[i]) * pos_isigma;
      r[3 + i] *= ea_isigma;
    }
    return true;
  }
};

class PlaneMap : public Problem {
 public:
  explicit PlaneMap(const Columns& data) {
    const auto &pos = data.real("poses.pos"), &ea = data.real("poses.ea");
    const auto &n = data.real("planes.n"), &c = data.real("planes.c");
    poses_ = pos.size() / 3, planes_ = c.size();
    for (size_t k = 0; k < poses_; ++k) {
      state_.insert(state_.end(), &pos[3 * k], &pos[3 * k] + 3);
      state_.insert(state_.end(), &ea[3 * k], &ea[3 * k] + 3);
    }
    for (size_t k = 0; k < planes_; ++k) {
      state_.insert(state_.end(), &n[3 * k], &n[3 * k] + 3);
      state_.push_back(c[k]);
    }
    for (size_t k = 0; k < planes_; ++k) {
      problem_.AddParameterBlock(
          plane(k), 4,
          new ceres::ProductManifold<ceres::SphereManifold<3>, ceres::EuclideanManifold<1>>());
    }
    const auto& distance = data.real("observations.c");
    for (size_t k = 0; k < distance.size(); ++k) {
      auto* seen = new PlaneSeen{&data.real("observations.n")[3 * k], distance[k],
                                 data.one("normal_isigma"), data.one("distance_isigma")};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PlaneSeen, 4, 6, 4>(seen), nullptr,
                                pose(data.index("observations.pose")[k]),
                                plane(data.index("observations.plane")[k]));
    }
    const auto& prev = data.index("pose_pairs.prev");
    for (size_t k = 0; k < prev.size(); ++k) {
      auto* pair = new PlanePair{&data.real("pose_pairs.delta_pos")[3 * k], {},
                                 data.one("odometry_pos_isigma"), data.one("odometry_ea_isigma")};
      rotation(&data.real("pose_pairs.delta_ea")[3 * k], pair->turn);
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PlanePair, 6, 6, 6>(pair), nullptr,
                                pose(prev[k]), pose(data.index("pose_pairs.cur")[k]));
    }
    const auto& held = data.index("anchors.pose");
    for (size_t k = 0; k < held.size(); ++k) {
      auto* anchor = new PlaneAnchor{&data.real("anchors.pos")[3 * k], {},
                                     data.one("anchor_pos_isigma"), data.one("anchor_ea_isigma")};
      rotation(&data.real("anchors.ea")[3 * k], anchor->turn);
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PlaneAnchor, 6, 6>(anchor), nullptr,
                                pose(held[k]));
    }
    remember(state_);
  }

  const char* settings() const override {
    return "LM, SPARSE_NORMAL_CHOLESKY (SuiteSparse, AMD), automatic derivatives";
  }

  void answer(Answer& out) const override {
    std::vector<double> pos, turns, n, c;
    for (size_t k = 0; k < poses_; ++k) {
      const double* at = &state_[6 * k];
      double m[9];
      rotation(at + 3, m);
      pos.insert(pos.end(), at, at + 3);
      turns.insert(turns.end(), m, m + 9);
    }
    for (size_t k = 0; k < planes_; ++k) {
      const double* at = &state_[6 * poses_ + 4 * k];
      n.insert(n.end(), at, at + 3);
      c.push_back(at[3]);
    }
    out.add("pos", 3, pos);
    out.add("rotation", 9, turns);
    out.add("n", 3, n);
    out.add("c", 1, c);
  }

 protected:
  void configure(ceres::Solver::Options& options) const override {
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  }

 private:
  double* pose(int64_t k) { return &state_[6 * k]; }
  double* plane(int64_t k) { return &state_[6 * poses_ + 4 * k]; }

  size_t poses_ = 0, planes_ = 0;
  std::vector<double> state_;
};
