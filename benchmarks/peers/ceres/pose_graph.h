// Planar pose graphs, the residuals of models/pose_graph_2d.arael.
#pragma once

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
