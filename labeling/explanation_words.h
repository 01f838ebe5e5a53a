// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/explanation.h"
#include "labeling/labeling_config.h"
#include "labeling/staircase_config.h"

namespace terrace {

/// Says an explanation in words: the rule, the numbers that it went by, and what else the thing could have
/// been. With the limits of the settings, which must outlive this.
class ExplanationWords {
 public:
  ExplanationWords(const LabelingConfig& config, const StaircaseConfig& stairs, const RobotConfig& robot)
      : config_(config), stairs_(stairs), robot_(robot) {}

  /// A few sentences on one line; what `text` holds does not matter.
  std::string Of(const RegionExplanation& region) const;
  std::string Of(const StaircaseExplanation& staircase) const;

 private:
  std::string Reason(const RegionExplanation& region) const;
  std::string OtherwiseUndecided(const RegionExplanation& region) const;
  std::string OtherwiseFace(const RegionExplanation& region) const;
  std::string OtherwiseSupport(const RegionExplanation& region) const;

  const LabelingConfig& config_;
  const StaircaseConfig& stairs_;
  const RobotConfig& robot_;
};

}  // namespace terrace
