// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <yaml-cpp/yaml.h>

namespace terrace::synthetic {

inline constexpr double kRadPerDegree = std::numbers::pi / 180.0;
/// Nothing of a scene lies farther from its origin.
inline constexpr double kSceneReach_m = 1000.0;

/// One map of the file: reads its keys, remembers which were asked for, and collects what is wrong.
class Section {
 public:
  Section(YAML::Node node, std::string path, std::string file, std::vector<std::string>* problems)
      : node_(std::move(node)), path_(std::move(path)), file_(std::move(file)), problems_(problems) {
    if (node_.IsDefined() && !node_.IsNull() && !node_.IsMap()) {
      Say("", "must be a map");
      node_ = YAML::Node();
    }
  }

  bool Has(const std::string& key) {
    known_.insert(key);
    return node_.IsMap() && node_[key].IsDefined();
  }

  void Number(const std::string& key, double* value, double low, double high, double unit = 1.0) {
    if (!Has(key)) return;
    double read = 0.0;
    if (!Convert(node_[key], &read) || !(read >= low && read <= high)) {
      return Say(key,
                 "is " + Text(node_[key]) + ", must be a number from " + Short(low) + " to " + Short(high));
    }
    *value = read * unit;
  }

  template <typename Whole>
  void Count(const std::string& key, Whole* value, double low, double high) {
    double read = static_cast<double>(*value);
    if (!Has(key)) return;
    if (!Convert(node_[key], &read) || !(read >= low && read <= high) || read != std::floor(read)) {
      return Say(key, "is " + Text(node_[key]) + ", must be a whole number from " + Short(low) + " to " +
                          Short(high));
    }
    *value = static_cast<Whole>(read);
  }

  void Flag(const std::string& key, bool* value) {
    if (!Has(key)) return;
    try {
      *value = node_[key].as<bool>();
    } catch (const YAML::Exception&) {
      Say(key, "is " + Text(node_[key]) + ", must be true or false");
    }
  }

  void Word(const std::string& key, std::string* value) {
    if (!Has(key)) return;
    if (!node_[key].IsScalar()) return Say(key, "must be text");
    *value = node_[key].Scalar();
  }

  template <int kSize>
  void Vector(const std::string& key, Eigen::Matrix<double, kSize, 1>* value, double low = -kSceneReach_m,
              double high = kSceneReach_m) {
    if (!Has(key)) return;
    ReadVector(node_[key], key, value, low, high);
  }

  /// A list of vectors of two or three numbers.
  template <int kSize>
  std::vector<Eigen::Matrix<double, kSize, 1>> Vectors(const std::string& key) {
    std::vector<Eigen::Matrix<double, kSize, 1>> values;
    if (!Has(key)) return values;
    if (!node_[key].IsSequence()) {
      Say(key, "must be a list of points");
      return values;
    }
    for (std::size_t i = 0; i < node_[key].size(); ++i) {
      Eigen::Matrix<double, kSize, 1> value = Eigen::Matrix<double, kSize, 1>::Zero();
      ReadVector(node_[key][i], key + "[" + std::to_string(i) + "]", &value, -kSceneReach_m, kSceneReach_m);
      values.push_back(value);
    }
    return values;
  }

  Section Child(const std::string& key) {
    Has(key);
    return Section(node_.IsMap() ? node_[key] : YAML::Node(), PathOf(key), file_, problems_);
  }

  std::vector<Section> Children(const std::string& key) {
    std::vector<Section> children;
    if (!Has(key)) return children;
    if (!node_[key].IsSequence()) {
      Say(key, "must be a list");
      return children;
    }
    for (std::size_t i = 0; i < node_[key].size(); ++i) {
      children.emplace_back(node_[key][i], PathOf(key) + "[" + std::to_string(i) + "]", file_, problems_);
    }
    return children;
  }

  std::vector<std::string> Keys() const {
    std::vector<std::string> keys;
    if (!node_.IsMap()) return keys;
    for (const auto& entry : node_) keys.push_back(entry.first.as<std::string>());
    return keys;
  }

  void Require(const std::string& key) {
    if (!Has(key)) Say(key, "is missing");
  }

  void Say(const std::string& key, const std::string& what) {
    problems_->push_back(file_ + ": " + PathOf(key) + " " + what);
  }

  /// Whatever nobody asked for is a spelling mistake.
  void RefuseUnknownKeys() {
    for (const std::string& key : Keys()) {
      if (known_.count(key) == 0) Say(key, "is not a key that this place knows");
    }
  }

 private:
  template <int kSize>
  void ReadVector(const YAML::Node& node, const std::string& key, Eigen::Matrix<double, kSize, 1>* value,
                  double low, double high) {
    Eigen::Matrix<double, kSize, 1> read;
    bool good = node.IsSequence() && node.size() == kSize;
    for (int i = 0; good && i < kSize; ++i) {
      good = Convert(node[static_cast<std::size_t>(i)], &read[i]) && read[i] >= low && read[i] <= high;
    }
    if (!good) {
      return Say(key, "is " + Text(node) + ", must be " + std::to_string(kSize) + " numbers from " +
                          Short(low) + " to " + Short(high));
    }
    *value = read;
  }

  static bool Convert(const YAML::Node& node, double* value) {
    if (!node.IsScalar()) return false;
    try {
      *value = node.as<double>();
    } catch (const YAML::Exception&) {
      return false;
    }
    return std::isfinite(*value);
  }

  static std::string Text(const YAML::Node& node) {
    YAML::Emitter out;
    out << YAML::Flow << node;
    std::string text = out.c_str();
    constexpr std::size_t kLongest = 60;
    if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
    return "'" + text + "'";
  }

  static std::string Short(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
  }

  std::string PathOf(const std::string& key) const {
    if (key.empty()) return path_.empty() ? "the file" : path_;
    return path_.empty() ? key : path_ + "." + key;
  }

  YAML::Node node_;
  std::string path_;
  std::string file_;
  std::vector<std::string>* problems_;
  std::set<std::string> known_;
};

}  // namespace terrace::synthetic
