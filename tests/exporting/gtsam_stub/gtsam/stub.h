// The part of the interface of GTSAM 4.3 that exported factors use, to compile them without GTSAM,
// whose wheel has no headers. Retractions are those of its conventions, so that derivatives can be
// checked by differences.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>

#include <Eigen/Dense>
#include <Eigen/Geometry>

namespace gtsam {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using Matrix2 = Eigen::Matrix2d;
using Matrix3 = Eigen::Matrix3d;
using Point2 = Eigen::Vector2d;
using Point3 = Eigen::Vector3d;
using Quaternion = Eigen::Quaterniond;
using Key = std::uint64_t;
using OptionalMatrixType = Matrix*;

class Rot2 {
  double theta_;

 public:
  explicit Rot2(double theta) : theta_(theta) {}
  Matrix2 matrix() const { return Eigen::Rotation2Dd(theta_).toRotationMatrix(); }
};

class Rot3 {
  Quaternion q_;

 public:
  Rot3(double w, double x, double y, double z) : q_(w, x, y, z) {}
  explicit Rot3(const Quaternion& q) : q_(q) {}
  Quaternion toQuaternion() const { return q_; }
  Matrix3 matrix() const { return q_.toRotationMatrix(); }
  Rot3 retract(const Vector& omega) const {
    const double angle = omega.norm();
    if (angle == 0) return *this;
    return Rot3(q_ * Quaternion(Eigen::AngleAxisd(angle, Point3(omega) / angle)));
  }
};

class Pose2 {
  double x_, y_, theta_;

 public:
  Pose2(double x, double y, double theta) : x_(x), y_(y), theta_(theta) {}
  double x() const { return x_; }
  double y() const { return y_; }
  double theta() const { return theta_; }
  Rot2 rotation() const { return Rot2(theta_); }
  Pose2 retract(const Vector& v) const {  // translation in the body, then the turn
    const Point2 t = rotation().matrix() * Point2(v[0], v[1]);
    return Pose2(x_ + t[0], y_ + t[1], theta_ + v[2]);
  }
};

class Pose3 {
  Rot3 r_;
  Point3 t_;

 public:
  Pose3(const Rot3& r, const Point3& t) : r_(r), t_(t) {}
  const Rot3& rotation() const { return r_; }
  const Point3& translation() const { return t_; }
  Pose3 retract(const Vector& v) const {  // rotation first; both in the body, to first order
    return Pose3(r_.retract(v.head(3)), t_ + r_.matrix() * Point3(v.tail(3)));
  }
};

namespace noiseModel {
struct Base {};
struct Unit {
  static std::shared_ptr<Base> Create(std::size_t) { return std::make_shared<Base>(); }
};
}  // namespace noiseModel

class NonlinearFactor {
 public:
  using shared_ptr = std::shared_ptr<NonlinearFactor>;
  virtual ~NonlinearFactor() = default;
  virtual shared_ptr clone() const = 0;
};

template <class T>
using MatrixFor = OptionalMatrixType;

template <class... Values>
class NoiseModelFactorN : public NonlinearFactor {
 public:
  template <class... Keys>
  explicit NoiseModelFactorN(const std::shared_ptr<noiseModel::Base>&, Keys...) {
    static_assert(sizeof...(Keys) == sizeof...(Values), "a key for each value");
  }
  virtual Vector evaluateError(const Values&... x, MatrixFor<Values>... H) const = 0;
};

}  // namespace gtsam
