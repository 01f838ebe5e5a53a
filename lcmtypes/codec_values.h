// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/geometry.h"
#include "core/time.h"

// What every family of messages is made of: checked numbers, times, vectors, rotations.

namespace terrace {

/// The moment, when it lies between 1970 and 2116: what is outside is no time, and would overflow
/// differences.
std::optional<Timestamp> TimeFromNanoseconds(std::int64_t ns);
std::optional<Timestamp> TimeFromMicroseconds(std::int64_t utime);
/// The exact moment, when it is the one that the microseconds name.
std::optional<Timestamp> TimeFrom(std::int64_t utime, std::int64_t ns);

inline bool AllFinite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}
inline bool AllFinite(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

/// Foreign text as it may stand in logs and results: on one line, without what is no UTF-8, and not endless.
std::string PlainText(std::string_view text);

/// The enum with this number, when it is one of the first `count`.
template <typename Enum>
std::optional<Enum> EnumFrom(int number, int count) {
  if (number < 0 || number >= count) return std::nullopt;
  return static_cast<Enum>(number);
}

template <typename Derived, typename Number>
void WriteVector(const Eigen::MatrixBase<Derived>& vector, Number* out) {
  for (Eigen::Index i = 0; i < vector.size(); ++i) out[i] = static_cast<Number>(vector[i]);
}
inline Eigen::Vector3d ReadVector(const double* in) { return {in[0], in[1], in[2]}; }

/// The rotation as CanonicalQuaternion.
void WriteQuaternion(const Eigen::Matrix3d& rotation, double* wxyz);
void WritePose(const Eigen::Isometry3d& pose, double* position, double* wxyz);
/// None when a number is not finite or the quaternion is none.
std::optional<Eigen::Isometry3d> ReadPose(const double* position, const double* wxyz);
/// "All zero" says that a pose is not known.
bool IsUnknownPose(const double* wxyz);

/// The upper triangle of a symmetric matrix, row after row.
template <int size, typename Number>
void WriteTriangle(const Eigen::Matrix<double, size, size>& matrix, Number* out) {
  for (int row = 0; row < size; ++row) {
    for (int col = row; col < size; ++col) *out++ = static_cast<Number>(matrix(row, col));
  }
}
template <int size, typename Number>
Eigen::Matrix<double, size, size> ReadTriangle(const Number* in) {
  Eigen::Matrix<double, size, size> matrix;
  for (int row = 0; row < size; ++row) {
    for (int col = row; col < size; ++col) matrix(row, col) = matrix(col, row) = *in++;
  }
  return matrix;
}

}  // namespace terrace
