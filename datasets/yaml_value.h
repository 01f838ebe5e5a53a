// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <yaml-cpp/yaml.h>

#include "core/file_bytes.h"

// yaml-cpp's header is heavy: include this from .cpp files only.

namespace terrace {

/// A value inside a YAML or JSON file that knows its place, so that every error names it. Whatever is asked
/// for and is not there is a FileError.
class YamlValue {
 public:
  YamlValue(const YAML::Node& node, std::string where) : node_(node), where_(std::move(where)) {}

  bool IsMap() const { return node_.IsMap(); }
  bool IsList() const { return node_.IsSequence(); }
  bool Has(const std::string& key) const { return node_.IsMap() && node_[key].IsDefined(); }
  YamlValue operator[](const std::string& key) const;
  std::vector<YamlValue> Items() const;
  std::vector<std::pair<std::string, YamlValue>> Members() const;

  double Number() const;  ///< finite
  double NumberOr(const std::string& key, double otherwise) const;
  int WholeNumber() const;
  std::string Text() const;
  std::string TextOr(const std::string& key, const std::string& otherwise) const;
  /// All numbers of a list, of a list of lists by rows, or of a matrix of OpenCV or ROS ({rows, cols, data}).
  std::vector<double> Numbers() const;
  std::vector<double> Numbers(std::size_t count) const;  ///< exactly so many
  Eigen::Matrix3d Matrix3() const;                       ///< nine numbers by rows
  /// Sixteen numbers by rows that are a rotation and a translation.
  Eigen::Isometry3d Pose() const;

  const std::string& where() const { return where_; }
  [[noreturn]] void Fail(const std::string& rule) const;

 private:
  void Collect(const YAML::Node& node, std::vector<double>* numbers) const;

  YAML::Node node_;
  std::string where_;
};

/// A rotation and a translation, the rotation made exact; numbers in files have as few as six digits. None
/// when it is no rotation.
std::optional<Eigen::Isometry3d> PoseFrom(const Eigen::Matrix3d& R, const Eigen::Vector3d& t);

/// The first key that stands twice in one map, with values that are not the same: which of them is meant
/// nobody can know. Empty: none does.
std::string ContradictedKey(const YAML::Node& node);

/// A whole YAML or JSON text; OpenCV's heading is forgiven. Throws FileError.
YamlValue ParseYaml(std::string text, const std::string& where);

}  // namespace terrace
