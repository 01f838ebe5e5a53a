// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/file_bytes.h"
#include "core/geometry.h"

// nlohmann's header is heavy: include this from .cpp files only.

namespace terrace {

/// A value inside a JSON file that knows its place, so that every error names it. A view: the document must
/// outlive it.
class JsonValue {
 public:
  JsonValue(const nlohmann::json& value, std::string where) : value_(&value), where_(std::move(where)) {}

  bool Has(const char* key) const;
  bool IsNull() const { return value_->is_null(); }
  /// The member `key`; FileError when it is missing.
  JsonValue operator[](const char* key) const;
  /// The elements of an array.
  std::vector<JsonValue> Items() const;
  /// The members of an object, by name.
  std::vector<std::pair<std::string, JsonValue>> Members() const;

  double Number() const;  ///< finite
  std::int64_t Integer() const;
  bool Bool() const;
  std::string Text() const;
  std::vector<double> Numbers(std::size_t count) const;  ///< an array of exactly `count` finite numbers
  Eigen::Vector3d Vector3() const;
  Eigen::Vector3d UnitVector3() const;  ///< FileError when its length is not 1 within 1e-3; normalised
  Ring Points() const;                  ///< at least three

  [[noreturn]] void Fail(const std::string& rule) const;

 private:
  const nlohmann::json* value_;
  std::string where_;
};

/// A whole JSON file, or one line of a .jsonl file. Throws FileError.
nlohmann::json ParseJson(const std::string& text, const std::string& where);
nlohmann::json ReadJsonFile(const std::filesystem::path& path);

}  // namespace terrace
