// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/consistency.h"
#include "evaluation/disparity_evaluation.h"
#include "evaluation/feet_evaluation.h"
#include "evaluation/film_strip.h"
#include "evaluation/map_evaluation.h"
#include "evaluation/region_census.h"
#include "evaluation/staircase_evaluation.h"
#include "evaluation/trajectory_evaluation.h"
#include "results/replay_result.h"

namespace terrace {

/// How the latency of a replay at recorded speed grows with the map: slopes of a straight line.
struct LatencyGrowth {
  int count = 0;
  double ms_per_1000_cells = 0.0;
  double ms_per_100_regions = 0.0;
};

/// Everything that is measured of one result. Parts whose truth the sequence does not have are none.
struct Evaluation {
  std::filesystem::path result;
  std::filesystem::path sequence;
  std::vector<std::string> notes;  ///< what could not be measured, and why

  std::optional<TrajectoryEvaluation> trajectory;
  std::optional<MapEvaluation> map;
  std::optional<FeetEvaluation> feet;
  std::optional<StaircaseEvaluation> staircases;
  std::optional<DisparityEvaluation> disparity;
  std::optional<DisparityConsistency> consistency;
  RegionCensus regions;

  ReplayStats stats;
  std::optional<LatencyGrowth> latency_growth;
  std::vector<ResultFrame> frames;
  std::vector<FilmPicture> film;  ///< empty without --save-tracks
  TerrainMap result_map;
  TrueScene scene;  ///< empty when the sequence has none
};

/// Measures what `terraced replay` left in a folder against the truth that the sequence comes with. Throws
/// FileError or ImageError.
Evaluation EvaluateResult(const std::filesystem::path& result, const std::filesystem::path& sequence,
                          const MapEvaluationOptions& options = {});

}  // namespace terrace
