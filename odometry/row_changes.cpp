// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/row_changes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace terrace {
namespace {

constexpr std::size_t kFewest = 20;  // landmarks seen in both frames
constexpr double kKeep = 0.75;
constexpr double kEnoughWeight = 1.5;  // that of two frames and more
/// A robot that stands shows nothing either way.
constexpr double kStands_px = 1.0;
constexpr double kComeAndGo_px = 0.3;
constexpr int kLasts = 30;  // frames

double Middle(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

}  // namespace

double RowChanges::change_px() const { return weight_ > 0.0 ? std::sqrt(squares_ / weight_) : 0.0; }

bool RowChanges::Update(const Window& window, const std::vector<Match>& matches) {
  std::vector<std::pair<std::int64_t, Place>> places;
  for (const Match& match : matches) {
    if (!match.found_in_right) continue;
    const std::int64_t id = window.landmarks[static_cast<std::size_t>(match.landmark)].id;
    places.push_back({id, {match.measurement.uvd.head<2>(), match.vertical_px}});
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<double> changes, moves;
  auto before = before_.begin();
  for (const auto& [id, place] : places) {
    while (before != before_.end() && before->first < id) ++before;
    if (before == before_.end()) break;
    if (before->first != id) continue;
    changes.push_back(place.lower_px - before->second.lower_px);
    moves.push_back((place.left_px - before->second.left_px).norm());
  }
  before_ = std::move(places);
  if (changes.size() < kFewest) return false;
  const double change = Middle(&changes);
  squares_ = kKeep * squares_ + change * change;
  weight_ = kKeep * weight_ + 1.0;
  const bool changing = weight_ > kEnoughWeight && change_px() > kComeAndGo_px;
  const bool news = changing && num_left_ == 0;
  if (changing)
    num_left_ = kLasts;
  else if (Middle(&moves) > kStands_px)
    num_left_ = std::max(num_left_ - 1, 0);
  return news;
}

}  // namespace terrace
