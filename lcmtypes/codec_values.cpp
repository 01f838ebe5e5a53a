// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/codec_values.h"

namespace terrace {
namespace {

constexpr std::int64_t kMaxNanoseconds = std::int64_t{1} << 62;

}  // namespace

std::optional<Timestamp> TimeFromNanoseconds(std::int64_t ns) {
  if (ns < 0 || ns > kMaxNanoseconds) return std::nullopt;
  return Timestamp{ns};
}

std::optional<Timestamp> TimeFromMicroseconds(std::int64_t utime) {
  if (utime < 0 || utime > kMaxNanoseconds / 1000) return std::nullopt;
  return Timestamp::FromMicroseconds(utime);
}

std::optional<Timestamp> TimeFrom(std::int64_t utime, std::int64_t ns) {
  const std::optional<Timestamp> t = TimeFromNanoseconds(ns);
  if (!t || t->utime() != utime) return std::nullopt;
  return t;
}

void WriteQuaternion(const Eigen::Matrix3d& rotation, double* wxyz) {
  const Eigen::Quaterniond q = CanonicalQuaternion(rotation);
  wxyz[0] = q.w();
  wxyz[1] = q.x();
  wxyz[2] = q.y();
  wxyz[3] = q.z();
}

void WritePose(const Eigen::Isometry3d& pose, double* position, double* wxyz) {
  WriteVector(pose.translation(), position);
  WriteQuaternion(pose.linear(), wxyz);
}

std::optional<Eigen::Isometry3d> ReadPose(const double* position, const double* wxyz) {
  // Others round their quaternions to a few digits; what is further from unit length is no rotation.
  constexpr double kMaxLengthError = 1e-2;
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!AllFinite({position, 3}) || !AllFinite({wxyz, 4}) || std::abs(q.norm() - 1.0) > kMaxLengthError) {
    return std::nullopt;
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = ReadVector(position);
  return CanonicalPose(pose);
}

bool IsUnknownPose(const double* wxyz) {
  return std::all_of(wxyz, wxyz + 4, [](double v) { return v == 0.0; });
}

}  // namespace terrace
