// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "labeling/flight_model.h"
#include "labeling/region_shape.h"
#include "labeling/sight.h"
#include "labeling/staircase_config.h"

namespace terrace {

/// One shape in its place in a flight.
struct StepMember {
  int shape = 0;  ///< index into the shapes searched
  bool riser = false;
  int step_index = 0;          ///< riser 1 is the lowest, tread 1 lies above riser 1
  bool only_evidence = false;  ///< of the step, but no region to step on
};

/// What a staircase was found by.
struct StaircaseEvidence {
  int num_seen = 0;           ///< steps that obey its law, however many fragments each has
  int num_to_see = 0;         ///< steps that the camera could see from where it is
  bool seen_sharply = false;  ///< noise moves most of its members by little of a rise
  bool faces_tile = false;    ///< faces of two neighbouring steps reach from one to the next
  bool sides_agree = false;
  double height_rms_m = 0.0;  ///< of the steps about the law
};

/// A staircase among the shapes of one map.
struct FoundStaircase {
  FlightModel model;
  int num_risers = 0;
  int num_treads = 0;
  double rise_sigma_m = 0.0;
  double run_sigma_m = 0.0;
  double confidence = 0.0;
  StaircaseEvidence evidence;
  std::vector<StepMember> members;  ///< ascending by shape
  std::optional<int> foot_shape;    ///< floor before riser 1
  std::optional<int> head_shape;    ///< landing above the last riser
};

/// Finds flights of steps: all risers and treads of one flight together obey one FlightModel.
class StaircaseFinder {
 public:
  explicit StaircaseFinder(const StaircaseConfig& config) : config_(config) {}

  /// @param known  flights found before: they are looked for first, and need less support to stay
  /// @param sight  where the camera and the robot are now
  /// @param compete  known flights must stand against new ones; else only what they leave is searched, which
  ///                 is much quicker
  std::vector<FoundStaircase> Find(const std::vector<RegionShapePtr>& shapes,
                                   const std::vector<FlightModel>& known, const Sight& sight,
                                   bool compete) const;

 private:
  StaircaseConfig config_;
};

}  // namespace terrace
