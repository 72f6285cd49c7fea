// Rotations of the models: R = Rz(yaw) Ry(pitch) Rx(roll), row-major.
#pragma once

#include <cmath>

template <typename T>
void rotation(const T* ea, T* m) {
  using std::cos;
  using std::sin;
  const T sr = sin(ea[0]), cr = cos(ea[0]), sp = sin(ea[1]), cp = cos(ea[1]);
  const T sy = sin(ea[2]), cy = cos(ea[2]);
  m[0] = cy * cp, m[1] = cy * sp * sr - sy * cr, m[2] = cy * sp * cr + sy * sr;
  m[3] = sy * cp, m[4] = sy * sp * sr + cy * cr, m[5] = sy * sp * cr - cy * sr;
  m[6] = -sp, m[7] = cp * sr, m[8] = cp * cr;
}

// out = a b
template <typename A, typename B, typename T>
void product(const A* a, const B* b, T* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

// out = a' b
template <typename A, typename B, typename T>
void product_back(const A* a, const B* b, T* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[3 * i + j] = a[i] * b[j] + a[3 + i] * b[3 + j] + a[6 + i] * b[6 + j];
}

// Roll, pitch and yaw of a matrix.
template <typename T>
void euler_angles(const T* m, T* ea) {
  using std::asin;
  using std::atan2;
  ea[0] = atan2(m[7], m[8]);
  ea[1] = asin(-m[6]);
  ea[2] = atan2(m[3], m[0]);
}
