// Residual and Jacobian of an edge of a pose graph: the exported cost function beside Ceres'
// automatic differentiation of the same residual, by turns. Prints nanoseconds of each.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include <ceres/rotation.h>

#include "pose_graph_3d_ceres.h"

// t (3), quaternion w x y z (4) of each pose; data: t (3), q (4), u (36), as the model's edge.
struct Edge {
  const double* data;
  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    const T inverse[4] = {a[3], -a[4], -a[5], -a[6]};
    const T moved[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    T dt[3];
    ceres::UnitQuaternionRotatePoint(inverse, moved, dt);
    T turn[4], difference[4];
    const T measured[4] = {T(data[3]), T(-data[4]), T(-data[5]), T(-data[6])};
    ceres::QuaternionProduct(inverse, b + 3, turn);
    ceres::QuaternionProduct(measured, turn, difference);
    const T sign = difference[0] < T(0) ? T(-2) : T(2);
    const T e[6] = {dt[0] - data[0], dt[1] - data[1], dt[2] - data[2],
                    sign * difference[1], sign * difference[2], sign * difference[3]};
    for (int i = 0; i < 6; i++) {
      residual[i] = T(0);
      for (int k = 0; k < 6; k++) residual[i] += data[7 + 6 * i + k] * e[k];
    }
    return true;
  }
};

double nanoseconds(const ceres::CostFunction& cost, const double* const* x, int count) {
  double residual[6], ja[42], jb[42], sum = 0;
  double* jacobians[] = {ja, jb};
  const auto begin = std::chrono::steady_clock::now();
  for (int k = 0; k < count; k++) {
    cost.Evaluate(x, residual, jacobians);
    sum += residual[0] + ja[5] + jb[7];
  }
  const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - begin;
  if (sum == 42) std::puts("");
  return time.count() / count;
}

int main() {
  double a[] = {1, 2, 3, 0.9, 0.1, -0.3, 0.3}, b[] = {1.5, 2.2, 2.7, 0.8, 0.2, 0.4, -0.4};
  double data[43] = {0.5, 0.1, -0.2, 1, 0, 0, 0};
  for (double* q : {a + 3, b + 3}) {
    const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; k++) q[k] /= length;
  }
  for (int k = 0; k < 36; k++) data[7 + k] = k / 6 <= k % 6 ? 1.0 + 0.1 * k : 0.0;
  const double* x[] = {a, b};
  const pose_graph_3d::EdgeBetween exported(data);
  const ceres::AutoDiffCostFunction<Edge, 6, 7, 7> automatic(new Edge{data});
  double r0[6], r1[6];
  exported.Evaluate(x, r0, nullptr);
  automatic.Evaluate(x, r1, nullptr);
  for (int k = 0; k < 6; k++)
    if (std::fabs(r0[k] - r1[k]) > 1e-12) return std::puts("the residuals differ"), 1;
  std::vector<double> one, other;
  for (int turn = 0; turn < 9; turn++) {
    one.push_back(nanoseconds(exported, x, 200000));
    other.push_back(nanoseconds(automatic, x, 200000));
  }
  std::sort(one.begin(), one.end());
  std::sort(other.begin(), other.end());
  double ra[6], ja[36], jb[36], sum = 0;
  std::vector<double> plain;
  for (int turn = 0; turn < 9; turn++) {
    const auto begin = std::chrono::steady_clock::now();
    for (int k = 0; k < 200000; k++) {
      pose_graph_3d_edge_between(a, b, data, ra, ja, jb);
      sum += ra[0] + ja[5] + jb[7];
    }
    plain.push_back(std::chrono::duration<double, std::nano>(
        std::chrono::steady_clock::now() - begin).count() / 200000);
  }
  std::sort(plain.begin(), plain.end());
  std::printf("%g %g %g%s\n", plain[4], one[4], other[4], sum == 42 ? " " : "");
  return 0;
}
