// Pose graphs, the residuals of models/pose_graph_2d.arael and models/pose_graph_3d.arael.
#pragma once

#include <ceres/rotation.h>

#include "problem.h"

struct PlanarEdge {
  const double *t, *u;
  double th, cos, sin;

  template <typename T>
  bool operator()(const T* a, const T* b, T* r) const {
    using std::cos;
    using std::sin;
    const T c = cos(a[2]), s = sin(a[2]), dx = b[0] - a[0], dy = b[1] - a[1];
    const T x = c * dx + s * dy - t[0], y = c * dy - s * dx - t[1];
    const T turned = wrapped(b[2] - a[2] - th);
    const T p = this->cos * x + this->sin * y, q = this->cos * y - this->sin * x;
    r[0] = u[0] * p + u[1] * q + u[2] * turned;
    r[1] = u[4] * q + u[5] * turned;
    r[2] = u[8] * turned;
    return true;
  }

  template <typename T>
  static T wrapped(const T& angle) {
    using std::floor;
    return angle - 2 * M_PI * floor((angle + M_PI) / (2 * M_PI));
  }
};

struct PlanarAnchor {
  double x, y, th, t_isigma, th_isigma;

  template <typename T>
  bool operator()(const T* a, T* r) const {
    r[0] = (a[0] - x) * t_isigma;
    r[1] = (a[1] - y) * t_isigma;
    r[2] = PlanarEdge::wrapped(a[2] - th) * th_isigma;
    return true;
  }
};

class PlanarGraph : public Problem {
 public:
  explicit PlanarGraph(const Columns& data) : data_(data) {
    const auto &t = data.real("poses.t"), &th = data.real("poses.th");
    for (size_t k = 0; k < th.size(); ++k) {
      state_.insert(state_.end(), {t[2 * k], t[2 * k + 1], th[k]});
    }
    const auto &a = data.index("edges.a"), &b = data.index("edges.b");
    const auto& turns = data.real("edges.th");
    for (size_t k = 0; k < turns.size(); ++k) {
      auto* edge = new PlanarEdge{&data.real("edges.t")[2 * k], &data.real("edges.u")[9 * k],
                                  turns[k], std::cos(turns[k]), std::sin(turns[k])};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PlanarEdge, 3, 3, 3>(edge),
                                nullptr, &state_[3 * a[k]], &state_[3 * b[k]]);
    }
    const auto& pose = data.index("anchors.pose");
    for (size_t k = 0; k < pose.size(); ++k) {
      const auto& at = data.real("anchors.t");
      auto* anchor = new PlanarAnchor{at[2 * k], at[2 * k + 1], data.real("anchors.th")[k],
                                      data.real("anchors.t_isigma")[k],
                                      data.real("anchors.th_isigma")[k]};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<PlanarAnchor, 3, 3>(anchor),
                                nullptr, &state_[3 * pose[k]]);
    }
    const auto& fixed = data.index("poses.t.fixed");
    for (size_t k = 0; k < fixed.size(); ++k) {
      if (fixed[k]) problem_.SetParameterBlockConstant(&state_[3 * k]);
    }
    remember(state_);
  }

  const char* settings() const override {
    return "LM, SPARSE_NORMAL_CHOLESKY (SuiteSparse, AMD), automatic derivatives";
  }

  void answer(Answer& out) const override {
    std::vector<double> id, t, th;
    for (const auto i : data_.index("poses.id")) id.push_back(static_cast<double>(i));
    for (size_t k = 0; k < id.size(); ++k) {
      t.insert(t.end(), {state_[3 * k], state_[3 * k + 1]});
      th.push_back(state_[3 * k + 2]);
    }
    out.add("id", 1, id);
    out.add("t", 2, t);
    out.add("th", 1, th);
  }

 protected:
  void configure(ceres::Solver::Options& options) const override {
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.initial_trust_region_radius = 1e9;  // the model's initial damping of 1e-9
  }

 private:
  const Columns& data_;
  std::vector<double> state_;
};

// A pose is a position and a unit quaternion (w x y z).
struct SpatialEdge {
  const double *t, *q, *u;

  template <typename T>
  bool operator()(const T* at, const T* aq, const T* bt, const T* bq, T* r) const {
    const T back[4] = {aq[0], -aq[1], -aq[2], -aq[3]};
    const T moved[3] = {bt[0] - at[0], bt[1] - at[1], bt[2] - at[2]};
    const T measured[4] = {T(q[0]), T(-q[1]), T(-q[2]), T(-q[3])};
    T e[6], turned[4], off[4];
    ceres::UnitQuaternionRotatePoint(back, moved, e);
    for (int i = 0; i < 3; ++i) e[i] -= t[i];
    ceres::QuaternionProduct(back, bq, turned);
    ceres::QuaternionProduct(measured, turned, off);
    const T twice = off[0] < 0.0 ? T(-2.0) : T(2.0);
    for (int i = 0; i < 3; ++i) e[3 + i] = twice * off[1 + i];
    for (int i = 0; i < 6; ++i) {
      r[i] = T(0.0);
      for (int j = i; j < 6; ++j) r[i] += u[6 * i + j] * e[j];
    }
    return true;
  }
};

class SpatialGraph : public Problem {
 public:
  explicit SpatialGraph(const Columns& data) : data_(data) {
    const auto &t = data.real("poses.t"), &q = data.real("poses.q");
    const size_t poses = t.size() / 3;
    if (!data.index("anchors.pose").empty()) fail("anchors of spatial graphs are not built here");
    for (size_t k = 0; k < poses; ++k) {
      state_.insert(state_.end(), &t[3 * k], &t[3 * k] + 3);
      state_.insert(state_.end(), &q[4 * k], &q[4 * k] + 4);
    }
    for (size_t k = 0; k < poses; ++k) {
      problem_.AddParameterBlock(position(k), 3);
      problem_.AddParameterBlock(turn(k), 4, new ceres::QuaternionManifold());
    }
    const auto &a = data.index("edges.a"), &b = data.index("edges.b");
    for (size_t k = 0; k < a.size(); ++k) {
      auto* edge = new SpatialEdge{&data.real("edges.t")[3 * k], &data.real("edges.q")[4 * k],
                                   &data.real("edges.u")[36 * k]};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<SpatialEdge, 6, 3, 4, 3, 4>(edge),
                                nullptr, position(a[k]), turn(a[k]), position(b[k]), turn(b[k]));
    }
    const auto &held = data.index("poses.t.fixed"), &turned = data.index("poses.q.fixed");
    for (size_t k = 0; k < poses; ++k) {
      if (held[k]) problem_.SetParameterBlockConstant(position(k));
      if (turned[k]) problem_.SetParameterBlockConstant(turn(k));
    }
    remember(state_);
  }

  const char* settings() const override {
    return "LM, SPARSE_NORMAL_CHOLESKY (SuiteSparse, AMD), automatic derivatives";
  }

  void answer(Answer& out) const override {
    std::vector<double> id, t, q;
    for (const auto i : data_.index("poses.id")) id.push_back(static_cast<double>(i));
    for (size_t k = 0; k < id.size(); ++k) {
      const double* at = &state_[7 * k];
      t.insert(t.end(), at, at + 3);
      q.insert(q.end(), at + 3, at + 7);
    }
    out.add("id", 1, id);
    out.add("t", 3, t);
    out.add("q", 4, q);
  }

 protected:
  void configure(ceres::Solver::Options& options) const override {
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.initial_trust_region_radius = 1e9;
  }

 private:
  double* position(int64_t k) { return &state_[7 * k]; }
  double* turn(int64_t k) { return &state_[7 * k + 3]; }

  const Columns& data_;
  std::vector<double> state_;
};
