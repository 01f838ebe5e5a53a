// SPDX-License-Identifier: BSD-3-Clause
#include "labeling/why_undecided.h"

namespace terrace {

const char* WhyUndecided(LabelRule rule) {
  switch (rule) {
    case LabelRule::kTooSmall:
      return "too small";
    case LabelRule::kTopNotSeen:
      return "its top was not seen";
    case LabelRule::kSlopeNotResolved:
      return "inclined, not resolved";
    case LabelRule::kSlopeNotPlane:
      return "inclined, not a plane";
    case LabelRule::kSlopeJustSeen:
      return "inclined, just seen";
    case LabelRule::kSlopeOutOfReach:
      return "not reachable";
    case LabelRule::kSlopeTooSmall:
      return "inclined, too small to walk on";
    case LabelRule::kSlopeNotKnown:
      return "slope not known";
    case LabelRule::kSteepFootNotKnown:
      return "steep, nothing known of its foot";
    case LabelRule::kTooSmallToWalkOn:
      return "too small to walk on";
    case LabelRule::kFacesDown:
      return "faces down";
    default:
      return "";
  }
}

}  // namespace terrace
