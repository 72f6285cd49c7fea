// Factors for GTSAM 4.3 of the model in window.h.
#ifndef WINDOW_GTSAM_H
#define WINDOW_GTSAM_H

#include <algorithm>
#include <array>
#include <memory>

#include <gtsam/geometry/Pose2.h>
#include <gtsam/geometry/Pose3.h>
#include <gtsam/nonlinear/NonlinearFactor.h>

#include "window.h"

namespace window {

// parameters of Pose, poses: stored scalars of a value of GTSAM.
inline std::array<double, 3> pose_stored(const gtsam::Pose2& x) {
  return {x.x(), x.y(), x.theta()};
}

// Derivative of arael's step by GTSAM's.
inline Eigen::Matrix<double, 3, 3> pose_step(const gtsam::Pose2& x) {
  (void)x;
  const gtsam::Matrix2 r = x.rotation().matrix();
  Eigen::Matrix<double, 3, 3> j;
  j.setZero();
  j(0, 0) = r(0, 0);
  j(0, 1) = r(0, 1);
  j(1, 0) = r(1, 0);
  j(1, 1) = r(1, 1);
  j(2, 2) = 1.0;
  return j;
}

// parameters of Landmark, landmarks: stored scalars of a value of GTSAM.
inline std::array<double, 2> landmark_stored(const gtsam::Point2& x) {
  return {x[0], x[1]};
}

// Derivative of arael's step by GTSAM's.
inline Eigen::Matrix<double, 2, 2> landmark_step(const gtsam::Point2& x) {
  (void)x;
  Eigen::Matrix<double, 2, 2> j;
  j.setZero();
  j(0, 0) = 1.0;
  j(1, 1) = 1.0;
  return j;
}

// Step.odometry: whitened, so its noise model is the unit matrix.
class StepOdometry : public gtsam::NoiseModelFactorN<gtsam::Pose2, gtsam::Pose2> {
  using Base = gtsam::NoiseModelFactorN<gtsam::Pose2, gtsam::Pose2>;
  std::array<double, 3> step_data_;

 public:
  using Base::evaluateError;
  StepOdometry(gtsam::Key a, gtsam::Key b, const double* step_data)
      : Base(gtsam::noiseModel::Unit::Create(3), a, b) {
    std::copy(step_data, step_data + 3, step_data_.begin());
  }

  gtsam::NonlinearFactor::shared_ptr clone() const override {
    return std::make_shared<StepOdometry>(*this);
  }

  gtsam::Vector evaluateError(const gtsam::Pose2& a, const gtsam::Pose2& b, gtsam::OptionalMatrixType H1, gtsam::OptionalMatrixType H2) const override {
    gtsam::Vector residual(3);
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> tangent_0;
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> tangent_1;
    window_step_odometry(pose_stored(a).data(), pose_stored(b).data(), step_data_.data(), residual.data(), H1 ? tangent_0.data() : nullptr, H2 ? tangent_1.data() : nullptr);
    if (H1) *H1 = tangent_0 * pose_step(a);
    if (H2) *H2 = tangent_1 * pose_step(b);
    return residual;
  }
};

// Sight.sight: whitened, so its noise model is the unit matrix.
class SightSight : public gtsam::NoiseModelFactorN<gtsam::Pose2, gtsam::Point2> {
  using Base = gtsam::NoiseModelFactorN<gtsam::Pose2, gtsam::Point2>;
  std::array<double, 2> sight_data_;

 public:
  using Base::evaluateError;
  SightSight(gtsam::Key pose, gtsam::Key landmark, const double* sight_data)
      : Base(gtsam::noiseModel::Unit::Create(2), pose, landmark) {
    std::copy(sight_data, sight_data + 2, sight_data_.begin());
  }

  gtsam::NonlinearFactor::shared_ptr clone() const override {
    return std::make_shared<SightSight>(*this);
  }

  gtsam::Vector evaluateError(const gtsam::Pose2& pose, const gtsam::Point2& landmark, gtsam::OptionalMatrixType H1, gtsam::OptionalMatrixType H2) const override {
    gtsam::Vector residual(2);
    Eigen::Matrix<double, 2, 3, Eigen::RowMajor> tangent_0;
    Eigen::Matrix<double, 2, 2, Eigen::RowMajor> tangent_1;
    window_sight_sight(pose_stored(pose).data(), landmark_stored(landmark).data(), sight_data_.data(), residual.data(), H1 ? tangent_0.data() : nullptr, H2 ? tangent_1.data() : nullptr);
    if (H1) *H1 = tangent_0 * pose_step(pose);
    if (H2) *H2 = tangent_1 * landmark_step(landmark);
    return residual;
  }
};

// Anchor.prior: whitened, so its noise model is the unit matrix.
class AnchorPrior : public gtsam::NoiseModelFactorN<gtsam::Pose2> {
  using Base = gtsam::NoiseModelFactorN<gtsam::Pose2>;
  std::array<double, 3> anchor_data_;

 public:
  using Base::evaluateError;
  AnchorPrior(gtsam::Key pose, const double* anchor_data)
      : Base(gtsam::noiseModel::Unit::Create(3), pose) {
    std::copy(anchor_data, anchor_data + 3, anchor_data_.begin());
  }

  gtsam::NonlinearFactor::shared_ptr clone() const override {
    return std::make_shared<AnchorPrior>(*this);
  }

  gtsam::Vector evaluateError(const gtsam::Pose2& pose, gtsam::OptionalMatrixType H1) const override {
    gtsam::Vector residual(3);
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> tangent_0;
    window_anchor_prior(pose_stored(pose).data(), anchor_data_.data(), residual.data(), H1 ? tangent_0.data() : nullptr);
    if (H1) *H1 = tangent_0 * pose_step(pose);
    return residual;
  }
};

}  // namespace window

#endif
