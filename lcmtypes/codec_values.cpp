// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/codec_values.h"

namespace terrace {
namespace {

constexpr std::int64_t kMaxNanoseconds = std::int64_t{1} << 62;

/// Bytes of the character that the text begins with, by table 3-7 of the Unicode standard; 0: it is none.
std::size_t CharacterSize(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0u; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first < 0xC2 || first > 0xF4) return 0;
  const std::size_t size = first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  const unsigned least = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
  const unsigned most = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
  if (byte(1) < least || byte(1) > most) return 0;
  for (std::size_t i = 2; i < size; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  return size;
}

}  // namespace

std::string PlainText(std::string_view text) {
  constexpr std::size_t kLongest = 500;
  std::string plain;
  while (!text.empty() && plain.size() < kLongest) {
    const std::size_t size = CharacterSize(text);
    const bool is_control = size == 1 && (static_cast<std::uint8_t>(text[0]) < 0x20 || text[0] == 0x7F);
    plain += size == 0 || is_control ? std::string_view("?") : text.substr(0, size);
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
  return text.empty() ? plain : plain + "...";
}

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
