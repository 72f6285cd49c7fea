// Maps of planes, the residuals of models/plane_slam.arael. A pose is x y z roll pitch yaw, which
// steps are added to; a plane moves on the sphere of unit normals, and along. Observations have
// their derivatives written out, the rest has automatic ones.
#pragma once

#include "../cpp/rotations.h"
#include "graph.h"

using PlanePose = Plain<6>;

// Two tangents of the unit sphere at n, orthonormal.
inline Eigen::Matrix<double, 3, 2> tangents(const Eigen::Vector3d& n) {
  Eigen::Matrix<double, 3, 2> found;
  found.col(0) = n.unitOrthogonal();
  found.col(1) = n.cross(found.col(0));
  return found;
}

class PlaneVertex : public g2o::BaseVertex<PlaneVertex, 3, Eigen::Vector4d> {
 public:
  void oplusImpl(const g2o::VectorX::MapType& step) {
    const Eigen::Vector3d n = estimate_.head<3>(), along = tangents(n) * step.head<2>();
    estimate_.head<3>() = (n + along).normalized();
    estimate_[3] += step[2];
  }
};

class PlaneSeen : public g2o::BaseBinaryEdge<4, Eigen::Vector4d, PlanePose, PlaneVertex> {
 public:
  PlaneSeen(const double* n, double c, double normal_isigma, double distance_isigma)
      : normal_isigma_(normal_isigma), distance_isigma_(distance_isigma) {
    measurement_ << n[0], n[1], n[2], c;
  }

  void computeError() override {
    const auto& pose = vertexXn<0>()->estimate();
    const auto& plane = vertexXn<1>()->estimate();
    Matrix m;
    rotation(pose.data() + 3, m.data());
    const Eigen::Vector3d n = plane.head<3>();
    error_.head<3>() = (m.transpose() * n - measurement_.head<3>()) * normal_isigma_;
    error_[3] = (n.dot(pose.head<3>()) + plane[3] - measurement_[3]) * distance_isigma_;
  }

  void linearizeOplus() override {
    const auto& pose = vertexXn<0>()->estimate();
    const Eigen::Vector3d n = vertexXn<1>()->estimate().head<3>();
    const Eigen::Matrix<double, 3, 2> moves = tangents(n);
    Matrix m;
    rotation(pose.data() + 3, m.data());
    const Eigen::Vector3d seen = m.transpose() * n;
    // R = Rz Ry Rx: turning by yaw about z of the world, by roll about x of the body, by pitch
    // about what is y after roll is undone.
    const double sr = std::sin(pose[3]), cr = std::cos(pose[3]);
    const Eigen::Vector3d roll(1, 0, 0), pitch(0, cr, -sr), yaw = m.row(2);
    auto& at_pose = jacobianOplusXn<0>();
    at_pose.setZero();
    at_pose.block<3, 1>(0, 3) = seen.cross(roll) * normal_isigma_;
    at_pose.block<3, 1>(0, 4) = seen.cross(pitch) * normal_isigma_;
    at_pose.block<3, 1>(0, 5) = seen.cross(yaw) * normal_isigma_;
    at_pose.block<1, 3>(3, 0) = n.transpose() * distance_isigma_;
    auto& at_plane = jacobianOplusXn<1>();
    at_plane.block<3, 2>(0, 0) = m.transpose() * moves * normal_isigma_;
    at_plane.block<3, 1>(0, 2).setZero();
    at_plane.block<1, 2>(3, 0) = pose.head<3>().transpose() * moves * distance_isigma_;
    at_plane(3, 2) = distance_isigma_;
  }

 private:
  using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

  double normal_isigma_, distance_isigma_;
};

class PlanePair : public g2o::BaseBinaryEdge<6, Eigen::Vector3d, PlanePose, PlanePose> {
 public:
  PlanePair(const double* pos, const double* ea, double pos_isigma, double ea_isigma)
      : pos_isigma_(pos_isigma), ea_isigma_(ea_isigma) {
    measurement_ << pos[0], pos[1], pos[2];
    rotation(ea, turn_);
  }

  template <typename T>
  bool operator()(const T* prev, const T* cur, T* r) const {
    T from[9], to[9], expected[9], turned[9];
    rotation(prev + 3, from);
    rotation(cur + 3, to);
    for (int i = 0; i < 3; ++i) {
      const T moved = from[i] * (cur[0] - prev[0]) + from[3 + i] * (cur[1] - prev[1]) +
                      from[6 + i] * (cur[2] - prev[2]);
      r[i] = (moved - T(measurement_[i])) * T(pos_isigma_);
    }
    product(from, turn_, expected);
    product_back(expected, to, turned);
    euler_angles(turned, r + 3);
    for (int i = 3; i < 6; ++i) r[i] *= T(ea_isigma_);
    return true;
  }

  G2O_MAKE_AUTO_AD_FUNCTIONS

 private:
  double turn_[9], pos_isigma_, ea_isigma_;
};

class PlaneAnchor : public g2o::BaseUnaryEdge<6, Eigen::Vector3d, PlanePose> {
 public:
  PlaneAnchor(const double* pos, const double* ea, double pos_isigma, double ea_isigma)
      : pos_isigma_(pos_isigma), ea_isigma_(ea_isigma) {
    measurement_ << pos[0], pos[1], pos[2];
    rotation(ea, turn_);
  }

  template <typename T>
  bool operator()(const T* pose, T* r) const {
    T m[9], turned[9];
    rotation(pose + 3, m);
    product_back(turn_, m, turned);
    euler_angles(turned, r + 3);
    for (int i = 0; i < 3; ++i) {
      r[i] = (pose[i] - T(measurement_[i])) * T(pos_isigma_);
      r[3 + i] *= T(ea_isigma_);
    }
    return true;
  }

  G2O_MAKE_AUTO_AD_FUNCTIONS

 private:
  double turn_[9], pos_isigma_, ea_isigma_;
};

class PlaneMap : public Graph {
 public:
  explicit PlaneMap(const Columns& data) {
    // To eliminate the planes first, which many poses see, took four times as long.
    use<g2o::BlockSolverX>();
    const auto &pos = data.real("poses.pos"), &ea = data.real("poses.ea");
    for (size_t k = 0; k < pos.size(); k += 3) {
      Eigen::Matrix<double, 6, 1> start;
      start << pos[k], pos[k + 1], pos[k + 2], ea[k], ea[k + 1], ea[k + 2];
      poses_.push_back(vertex<PlanePose>(start, false));
    }
    const auto &n = data.real("planes.n"), &c = data.real("planes.c");
    for (size_t k = 0; k < c.size(); ++k) {
      const Eigen::Vector4d start(n[3 * k], n[3 * k + 1], n[3 * k + 2], c[k]);
      planes_.push_back(vertex<PlaneVertex>(start, false));
    }
    const auto &normal = data.real("observations.n"), &distance = data.real("observations.c");
    for (size_t k = 0; k < distance.size(); ++k) {
      edge(std::make_shared<PlaneSeen>(&normal[3 * k], distance[k], data.one("normal_isigma"),
                                       data.one("distance_isigma")),
           poses_[data.index("observations.pose")[k]],
           planes_[data.index("observations.plane")[k]]);
    }
    const auto& prev = data.index("pose_pairs.prev");
    for (size_t k = 0; k < prev.size(); ++k) {
      edge(std::make_shared<PlanePair>(&data.real("pose_pairs.delta_pos")[3 * k],
                                       &data.real("pose_pairs.delta_ea")[3 * k],
                                       data.one("odometry_pos_isigma"),
                                       data.one("odometry_ea_isigma")),
           poses_[prev[k]], poses_[data.index("pose_pairs.cur")[k]]);
    }
    const auto& held = data.index("anchors.pose");
    for (size_t k = 0; k < held.size(); ++k) {
      edge(std::make_shared<PlaneAnchor>(&data.real("anchors.pos")[3 * k],
                                         &data.real("anchors.ea")[3 * k],
                                         data.one("anchor_pos_isigma"),
                                         data.one("anchor_ea_isigma")),
           poses_[held[k]]);
    }
  }

  const char* settings() const override {
    return "LM, Eigen's sparse Cholesky, block-wise AMD, derivatives of observations written out";
  }

  void answer(Answer& out) const override {
    std::vector<double> pos, turns, n, c;
    for (const auto& pose : poses_) {
      const double* at = pose->estimate().data();
      double m[9];
      rotation(at + 3, m);
      pos.insert(pos.end(), at, at + 3);
      turns.insert(turns.end(), m, m + 9);
    }
    for (const auto& plane : planes_) {
      const double* at = plane->estimate().data();
      n.insert(n.end(), at, at + 3);
      c.push_back(at[3]);
    }
    out.add("pos", 3, pos);
    out.add("rotation", 9, turns);
    out.add("n", 3, n);
    out.add("c", 1, c);
  }

 private:
  std::vector<std::shared_ptr<PlanePose>> poses_;
  std::vector<std::shared_ptr<PlaneVertex>> planes_;
};
