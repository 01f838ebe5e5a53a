// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdio>
#include <string>

#include <Eigen/Core>

#include "evaluation/evaluation.h"

namespace terrace {

// What the parts of the report share.

inline constexpr const char* kTruthColour = "#8a8f98";
inline constexpr const char* kResultColour = "#0b6bcb";
inline constexpr const char* kSecondColour = "#d9730d";

inline std::string Number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

/// Picks two coordinates: a view from above is {0, 1}, from the side {0, 2}.
struct View {
  int across;
  int up;

  Eigen::Vector2d operator()(const Eigen::Vector3d& p) const { return {p[across], p[up]}; }
};
inline constexpr View kFromAbove{0, 1};
inline constexpr View kFromTheSide{0, 2};

void AddMapReport(const Evaluation& evaluation, std::string* html);
void AddFeetReport(const FeetEvaluation& feet, std::string* html);
void AddStaircasesReport(const StaircaseEvaluation& staircases, std::string* html);

}  // namespace terrace
