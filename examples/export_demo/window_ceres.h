// Ceres problem of the model in window.h.
#ifndef WINDOW_CERES_H
#define WINDOW_CERES_H

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <ceres/ceres.h>

#include "window.h"

namespace window {

// c = a b, row by row.
template <int R, int T, int N>
inline void multiply(const double* a, const double* b, double* c) {
  for (int i = 0; i < R; i++)
    for (int j = 0; j < N; j++) {
      double sum = 0.0;
      for (int k = 0; k < T; k++) sum += a[i * T + k] * b[k * N + j];
      c[i * N + j] = sum;
    }
}

// Derivative of Plus at x, 3 x 3, row by row.
inline void pose_plus_jacobian(const double* x, double (&j)[9]) {
  (void)x;
  j[0] = 1.0;
  j[1] = 0.0;
  j[2] = 0.0;
  j[3] = 0.0;
  j[4] = 1.0;
  j[5] = 0.0;
  j[6] = 0.0;
  j[7] = 0.0;
  j[8] = 1.0;
}

// Derivative of Minus at x, 3 x 3, row by row.
inline void pose_minus_jacobian(const double* x, double (&j)[9]) {
  (void)x;
  j[0] = 1.0;
  j[1] = 0.0;
  j[2] = 0.0;
  j[3] = 0.0;
  j[4] = 1.0;
  j[5] = 0.0;
  j[6] = 0.0;
  j[7] = 0.0;
  j[8] = 1.0;
}

// parameters of Pose, poses: 3 scalars, a step of 3.
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 3; }
  int TangentSize() const override { return 3; }
  bool Plus(const double* x, const double* delta, double* moved) const override {
    window_pose_retract(x, delta, moved);
    return true;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    double j[9];
    pose_plus_jacobian(x, j);
    std::copy(std::begin(j), std::end(j), jacobian);
    return true;
  }
  bool Minus(const double* y, const double* x, double* step) const override {
    window_pose_local(x, y, step);
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    double j[9];
    pose_minus_jacobian(x, j);
    std::copy(std::begin(j), std::end(j), jacobian);
    return true;
  }
};

// Derivative of Plus at x, 2 x 2, row by row.
inline void landmark_plus_jacobian(const double* x, double (&j)[4]) {
  (void)x;
  j[0] = 1.0;
  j[1] = 0.0;
  j[2] = 0.0;
  j[3] = 1.0;
}

// Derivative of Minus at x, 2 x 2, row by row.
inline void landmark_minus_jacobian(const double* x, double (&j)[4]) {
  (void)x;
  j[0] = 1.0;
  j[1] = 0.0;
  j[2] = 0.0;
  j[3] = 1.0;
}

// Step.odometry: data is copied.
class StepOdometry : public ceres::SizedCostFunction<3, 3, 3> {
 public:
  explicit StepOdometry(const double* step_data) {
    std::copy(step_data, step_data + 3, step_data_.begin());
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    double tangent_0[9];
    double tangent_1[9];
    window_step_odometry(parameters[0], parameters[1], step_data_.data(), residuals, jacobians && jacobians[0] ? tangent_0 : nullptr, jacobians && jacobians[1] ? tangent_1 : nullptr);
    if (jacobians && jacobians[0]) {
      double minus[9];
      pose_minus_jacobian(parameters[0], minus);
      multiply<3, 3, 3>(tangent_0, minus, jacobians[0]);
    }
    if (jacobians && jacobians[1]) {
      double minus[9];
      pose_minus_jacobian(parameters[1], minus);
      multiply<3, 3, 3>(tangent_1, minus, jacobians[1]);
    }
    for (int i = 0; i < 3; i++)
      if (!std::isfinite(residuals[i])) return false;
    return true;
  }

 private:
  std::array<double, 3> step_data_;
};

// Sight.sight: data is copied.
class SightSight : public ceres::SizedCostFunction<2, 3, 2> {
 public:
  explicit SightSight(const double* sight_data) {
    std::copy(sight_data, sight_data + 2, sight_data_.begin());
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    double tangent_0[6];
    double tangent_1[4];
    window_sight_sight(parameters[0], parameters[1], sight_data_.data(), residuals, jacobians && jacobians[0] ? tangent_0 : nullptr, jacobians && jacobians[1] ? tangent_1 : nullptr);
    if (jacobians && jacobians[0]) {
      double minus[9];
      pose_minus_jacobian(parameters[0], minus);
      multiply<2, 3, 3>(tangent_0, minus, jacobians[0]);
    }
    if (jacobians && jacobians[1]) {
      double minus[4];
      landmark_minus_jacobian(parameters[1], minus);
      multiply<2, 2, 2>(tangent_1, minus, jacobians[1]);
    }
    for (int i = 0; i < 2; i++)
      if (!std::isfinite(residuals[i])) return false;
    return true;
  }

 private:
  std::array<double, 2> sight_data_;
};

// Anchor.prior: data is copied.
class AnchorPrior : public ceres::SizedCostFunction<3, 3> {
 public:
  explicit AnchorPrior(const double* anchor_data) {
    std::copy(anchor_data, anchor_data + 3, anchor_data_.begin());
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    double tangent_0[9];
    window_anchor_prior(parameters[0], anchor_data_.data(), residuals, jacobians && jacobians[0] ? tangent_0 : nullptr);
    if (jacobians && jacobians[0]) {
      double minus[9];
      pose_minus_jacobian(parameters[0], minus);
      multiply<3, 3, 3>(tangent_0, minus, jacobians[0]);
    }
    for (int i = 0; i < 3; i++)
      if (!std::isfinite(residuals[i])) return false;
    return true;
  }

 private:
  std::array<double, 3> anchor_data_;
};

// The rows of a model. A ref is the number of a row.
struct Model {
  std::vector<std::array<double, 3>> pose;
  std::vector<bool> pose_fixed;  // one a row, or empty
  std::vector<std::array<double, 2>> landmark;
  std::vector<bool> landmark_fixed;  // one a row, or empty
  int poses_count = 0;
  int landmarks_count = 0;
  std::vector<int> steps_a;
  std::vector<int> steps_b;
  std::vector<std::array<double, 3>> step_data;
  int steps_count = 0;
  std::vector<int> sights_pose;
  std::vector<int> sights_landmark;
  std::vector<std::array<double, 2>> sight_data;
  int sights_count = 0;
  std::vector<int> anchors_pose;
  std::vector<std::array<double, 3>> anchor_data;
  int anchors_count = 0;
};

// Adds all rows of `model` to `problem`, which changes its parameters. The cost of
// Ceres is half of the sum of squares; robust losses are in the residuals.
inline void build_problem(Model& model, ceres::Problem& problem) {
  for (std::size_t row = 0; row < model.pose.size(); row++) {
    double* x = model.pose[row].data();
    problem.AddParameterBlock(x, 3, new PoseManifold);
    if (!model.pose_fixed.empty() && model.pose_fixed[row]) {
      problem.SetParameterBlockConstant(x);
      continue;
    }
  }
  for (std::size_t row = 0; row < model.landmark.size(); row++) {
    double* x = model.landmark[row].data();
    problem.AddParameterBlock(x, 2);
    if (!model.landmark_fixed.empty() && model.landmark_fixed[row]) {
      problem.SetParameterBlockConstant(x);
      continue;
    }
  }
  for (int i = 0; i < model.steps_count; i++) {  // Step.odometry
    const int row1 = model.steps_a[static_cast<std::size_t>(i)];
    const int row2 = model.steps_b[static_cast<std::size_t>(i)];
    problem.AddResidualBlock(new StepOdometry(model.step_data[static_cast<std::size_t>(i)].data()), nullptr, model.pose[static_cast<std::size_t>(row1)].data(), model.pose[static_cast<std::size_t>(row2)].data());
  }
  for (int i = 0; i < model.sights_count; i++) {  // Sight.sight
    const int row1 = model.sights_pose[static_cast<std::size_t>(i)];
    const int row2 = model.sights_landmark[static_cast<std::size_t>(i)];
    problem.AddResidualBlock(new SightSight(model.sight_data[static_cast<std::size_t>(i)].data()), nullptr, model.pose[static_cast<std::size_t>(row1)].data(), model.landmark[static_cast<std::size_t>(row2)].data());
  }
  for (int i = 0; i < model.anchors_count; i++) {  // Anchor.prior
    const int row1 = model.anchors_pose[static_cast<std::size_t>(i)];
    problem.AddResidualBlock(new AnchorPrior(model.anchor_data[static_cast<std::size_t>(i)].data()), nullptr, model.pose[static_cast<std::size_t>(row1)].data());
  }
}

}  // namespace window

#endif
