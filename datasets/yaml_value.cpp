// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/yaml_value.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/SVD>

namespace terrace {

YamlValue YamlValue::operator[](const std::string& key) const {
  if (!Has(key)) Fail(key + " is missing");
  return {node_[key], where_ + ": " + key};
}

std::vector<YamlValue> YamlValue::Items() const {
  if (!node_.IsSequence()) Fail("must be a list");
  std::vector<YamlValue> items;
  for (std::size_t i = 0; i < node_.size(); ++i)
    items.emplace_back(node_[i], where_ + "[" + std::to_string(i) + "]");
  return items;
}

std::vector<std::pair<std::string, YamlValue>> YamlValue::Members() const {
  std::vector<std::pair<std::string, YamlValue>> members;
  if (!node_.IsMap()) return members;
  for (const auto& member : node_) {
    if (!member.first.IsScalar()) continue;
    members.emplace_back(member.first.Scalar(),
                         YamlValue(member.second, where_ + ": " + member.first.Scalar()));
  }
  return members;
}

double YamlValue::Number() const {
  double value = 0.0;
  if (!node_.IsScalar() || !YAML::convert<double>::decode(node_, value) || !std::isfinite(value))
    Fail("must be a finite number");
  return value;
}

double YamlValue::NumberOr(const std::string& key, double otherwise) const {
  return Has(key) ? (*this)[key].Number() : otherwise;
}

int YamlValue::WholeNumber() const {
  const double value = Number();
  constexpr double kLargest = 1e9;
  if (value != std::floor(value) || std::abs(value) > kLargest) Fail("must be a whole number");
  return static_cast<int>(value);
}

std::string YamlValue::Text() const {
  if (!node_.IsScalar()) Fail("must be a word");
  return node_.Scalar();
}

std::string YamlValue::TextOr(const std::string& key, const std::string& otherwise) const {
  return Has(key) ? (*this)[key].Text() : otherwise;
}

void YamlValue::Collect(const YAML::Node& node, std::vector<double>* numbers) const {
  constexpr std::size_t kMost = 4096;
  for (const YAML::Node& item : node) {
    if (numbers->size() >= kMost) Fail("holds too many numbers");
    if (item.IsSequence()) {
      Collect(item, numbers);
    } else {
      numbers->push_back(YamlValue(item, where_).Number());
    }
  }
}

std::vector<double> YamlValue::Numbers() const {
  if (node_.IsMap() && node_["data"].IsDefined()) return (*this)["data"].Numbers();
  if (!node_.IsSequence()) Fail("must be a list of numbers");
  std::vector<double> numbers;
  Collect(node_, &numbers);
  return numbers;
}

std::vector<double> YamlValue::Numbers(std::size_t count) const {
  std::vector<double> numbers = Numbers();
  if (numbers.size() != count) Fail("must be a list of " + std::to_string(count) + " numbers");
  return numbers;
}

Eigen::Matrix3d YamlValue::Matrix3() const {
  const std::vector<double> numbers = Numbers(9);
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data());
}

Eigen::Isometry3d YamlValue::Pose() const {
  const std::vector<double> numbers = Numbers(16);
  const Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
  const auto pose = PoseFrom(T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>());
  if (!pose || !T.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-6))
    Fail("must be a rotation and a translation");
  return *pose;
}

void YamlValue::Fail(const std::string& rule) const { throw FileError(where_ + ": " + rule); }

std::optional<Eigen::Isometry3d> PoseFrom(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  constexpr double kLargestError = 2e-3;
  if (!R.allFinite() || !t.allFinite() || !(R * R.transpose()).isIdentity(kLargestError) ||
      R.determinant() < 0.0) {
    return std::nullopt;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = svd.matrixU() * svd.matrixV().transpose();
  pose.translation() = t;
  return pose;
}

std::string ContradictedKey(const YAML::Node& node) {
  std::map<std::string, YAML::Node> values;
  for (const auto& item : node) {
    const YAML::Node value = node.IsMap() ? item.second : YAML::Node(item);
    if (node.IsMap()) {
      const std::string key = item.first.as<std::string>("");
      const auto [before, is_new] = values.emplace(key, value);
      if (!is_new && YAML::Dump(before->second) != YAML::Dump(value)) return key;
    }
    if (std::string key = ContradictedKey(value); !key.empty()) return key;
  }
  return "";
}

YamlValue ParseYaml(std::string text, const std::string& where) {
  if (text.rfind("%YAML", 0) == 0) text.erase(0, text.find('\n'));
  // YAML forbids the tabs that JSON allows.
  std::replace(text.begin(), text.end(), '\t', ' ');
  try {
    const YAML::Node root = YAML::Load(text);
    if (const std::string key = ContradictedKey(root); !key.empty())
      throw FileError(where + ": '" + key + "' comes twice, with different values");
    return {root, where};
  } catch (const YAML::Exception& error) {
    throw FileError(where + ": not valid YAML: " + error.what());
  }
}

}  // namespace terrace
