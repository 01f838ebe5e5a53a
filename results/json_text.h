// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/geometry.h"
#include "core/json_value.h"

// How values are written into, and read from, the result files' JSON. For .cpp files only: nlohmann's header
// is heavy.

namespace terrace {

/// Members stay in the order in which they are written.
using OrderedJson = nlohmann::ordered_json;

/// Foreign text, such as names of files, may hold bytes that are no UTF-8: they are replaced, since no single
/// frame may end a run.
inline std::string Dumped(const OrderedJson& json, int indent = -1) {
  return json.dump(indent, ' ', false, OrderedJson::error_handler_t::replace);
}

/// Micrometres are enough for a vertex, and keep the file a third smaller.
inline OrderedJson PointJson(const Eigen::Vector3d& p) {
  const auto rounded = [](double v) { return std::round(v * 1e6) / 1e6 + 0.0; };
  return {rounded(p.x()), rounded(p.y()), rounded(p.z())};
}

inline OrderedJson VectorJson(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

inline OrderedJson RingJson(const Ring& ring) {
  OrderedJson points = OrderedJson::array();
  for (const Eigen::Vector3d& p : ring) points.push_back(PointJson(p));
  return points;
}

template <typename Derived>
OrderedJson RowMajorJson(const Eigen::MatrixBase<Derived>& matrix) {
  OrderedJson numbers = OrderedJson::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index col = 0; col < matrix.cols(); ++col) numbers.push_back(matrix(row, col));
  }
  return numbers;
}

template <typename T>
OrderedJson OrNullJson(const std::optional<T>& value) {
  return value ? OrderedJson(*value) : OrderedJson(nullptr);
}

inline std::optional<double> NumberOrNull(const JsonValue& json) {
  return json.IsNull() ? std::nullopt : std::optional(json.Number());
}

}  // namespace terrace
