// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/fault.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "datasets/text_table.h"

namespace terrace::synthetic {

FaultSpan FaultSpan::Of(const FaultyRecording& recording) {
  constexpr std::chrono::seconds kBefore(2), kLasts(2);
  const std::vector<RecordedImage>& images = recording.left;
  FaultSpan span;
  if (images.empty()) return span;
  const auto first_from = [&](Timestamp t) {
    const auto at =
        std::find_if(images.begin(), images.end(), [t](const auto& image) { return image.t >= t; });
    return static_cast<std::size_t>(at - images.begin());
  };
  span.begin = first_from(images.front().t + kBefore);
  span.end = first_from(images.front().t + kBefore + kLasts);
  if (span.end == images.size()) {
    span.begin = images.size() / 3;
    span.end = images.size() * 2 / 3;
  }
  span.t_begin = images[span.begin].t;
  span.t_end = images[span.end].t;
  return span;
}

std::vector<Fault> AllFaults() {
  std::vector<Fault> all;
  for (const auto& kind : {ImageFaults(), PairFaults(), TimeFaults(), ImuFaults(), PriorFaults()})
    all.insert(all.end(), kind.begin(), kind.end());
  return all;
}

void ApplyFault(const std::string& description, FaultyRecording& recording) {
  const std::size_t colon = description.find(':');
  const std::string name = description.substr(0, colon);
  const std::vector<Fault> all = AllFaults();
  const auto fault = std::find_if(all.begin(), all.end(), [&](const Fault& f) { return f.name == name; });
  if (fault == all.end()) throw FaultError("no fault is called " + name);
  double strength = fault->strength;
  if (colon != std::string::npos) {
    const std::optional<double> given = ParseDouble(description.substr(colon + 1));
    if (!given) throw FaultError(description + ": the strength must be a number");
    strength = *given;
  }
  constexpr std::size_t kFewest = 9;  // images: a third before, a third with the fault, a third after
  if (recording.left.size() < kFewest)
    throw FaultError(recording.source.string() + ": must have at least 9 images");
  fault->apply(recording, FaultSpan::Of(recording), strength);
}

}  // namespace terrace::synthetic
