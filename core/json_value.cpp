// SPDX-License-Identifier: BSD-3-Clause
#include "core/json_value.h"

#include <cmath>

namespace terrace {

bool JsonValue::Has(const char* key) const { return value_->is_object() && value_->contains(key); }

JsonValue JsonValue::operator[](const char* key) const {
  if (!value_->is_object()) Fail("must be an object");
  const auto it = value_->find(key);
  if (it == value_->end()) Fail(std::string(key) + " is missing");
  return {*it, where_ + " " + key};
}

std::vector<JsonValue> JsonValue::Items() const {
  if (!value_->is_array()) Fail("must be an array");
  std::vector<JsonValue> items;
  items.reserve(value_->size());
  for (std::size_t i = 0; i < value_->size(); ++i) {
    items.emplace_back((*value_)[i], where_ + "[" + std::to_string(i) + "]");
  }
  return items;
}

std::vector<std::pair<std::string, JsonValue>> JsonValue::Members() const {
  if (!value_->is_object()) Fail("must be an object");
  std::vector<std::pair<std::string, JsonValue>> members;
  for (const auto& [name, value] : value_->items()) members.emplace_back(name, (*this)[name.c_str()]);
  return members;
}

double JsonValue::Number() const {
  if (!value_->is_number() || !std::isfinite(value_->get<double>())) Fail("must be a finite number");
  return value_->get<double>();
}

std::int64_t JsonValue::Integer() const {
  if (!value_->is_number_integer()) Fail("must be an integer");
  return value_->get<std::int64_t>();
}

bool JsonValue::Bool() const {
  if (!value_->is_boolean()) Fail("must be true or false");
  return value_->get<bool>();
}

std::string JsonValue::Text() const {
  if (!value_->is_string()) Fail("must be a text");
  return value_->get<std::string>();
}

std::vector<double> JsonValue::Numbers(std::size_t count) const {
  if (!value_->is_array() || value_->size() != count) {
    Fail("must be an array of " + std::to_string(count) + " numbers");
  }
  std::vector<double> numbers;
  for (const JsonValue& item : Items()) numbers.push_back(item.Number());
  return numbers;
}

Eigen::Vector3d JsonValue::Vector3() const {
  // Not by Numbers: outlines hold thousands of points, and naming the place of each coordinate is slow.
  if (!value_->is_array() || value_->size() != 3) Fail("must be an array of 3 numbers");
  Eigen::Vector3d v;
  for (int k = 0; k < 3; ++k) {
    const nlohmann::json& number = (*value_)[static_cast<std::size_t>(k)];
    if (!number.is_number() || !std::isfinite(number.get<double>())) Fail("must hold finite numbers");
    v[k] = number.get<double>();
  }
  return v;
}

Eigen::Vector3d JsonValue::UnitVector3() const {
  // What has been written in full comes back bit for bit: to normalise it again could change its last digit.
  constexpr double kRounding = 1e-15;
  const Eigen::Vector3d v = Vector3();
  const double off = std::abs(v.norm() - 1.0);
  if (off > 1e-3) Fail("must be a unit vector");
  return off <= kRounding ? v : v.normalized();
}

Ring JsonValue::Points() const {
  Ring ring;
  for (const JsonValue& item : Items()) ring.push_back(item.Vector3());
  if (ring.size() < 3) Fail("must hold at least three points");
  return ring;
}

void JsonValue::Fail(const std::string& rule) const { throw FileError(where_ + ": " + rule); }

nlohmann::json ParseJson(const std::string& text, const std::string& where) {
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& e) {
    throw FileError(where + ": is not JSON: " + e.what());
  }
}

nlohmann::json ReadJsonFile(const std::filesystem::path& path) {
  return ParseJson(ReadTextFile(path), path.string());
}

}  // namespace terrace
