// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace terrace {

/// Boxes with `Axes` axes, packed into a tree in the order in which they come: eight neighbours share a
/// parent. So the caller's order decides how well it finds: along a ring, or along a curve through space.
template <int Axes>
class BoxTree {
 public:
  using Box = Eigen::AlignedBox<double, Axes>;

  BoxTree() = default;
  explicit BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), size_(boxes_.size()) {
    levels_.push_back(0);
    for (std::size_t begin = 0, end = size_; end - begin > 1;) {
      levels_.push_back(end);
      for (std::size_t child = begin; child < end; child += kFanOut) {
        Box parent = boxes_[child];
        for (std::size_t i = child + 1; i < std::min(child + kFanOut, end); ++i) parent.extend(boxes_[i]);
        boxes_.push_back(parent);
      }
      begin = std::exchange(end, boxes_.size());
    }
  }

  std::size_t size() const { return size_; }
  const Box& box(std::size_t i) const { return boxes_[i]; }

  /// Calls visit(i) in ascending order for every i for which enter(box) holds; enter() must hold for a box
  /// when it holds for one within.
  template <typename Enter, typename Visit>
  void ForEach(const Enter& enter, const Visit& visit) const {
    if (size_ > 0) Descend(levels_.size() - 1, 0, enter, visit);
  }

  struct Nearest {
    std::size_t index = 0;
    double squared_distance = std::numeric_limits<double>::infinity();  ///< infinite: there is none
  };
  /// The item that is nearest, of equals the first found: always the same one.
  /// @param to_box  squared distance to a box, at most that to any item within
  /// @param to_item  squared distance to item i; infinite: it does not count
  template <typename ToBox, typename ToItem>
  Nearest FindNearest(const ToBox& to_box, const ToItem& to_item) const {
    Nearest nearest;
    if (size_ > 0) Approach(levels_.size() - 1, 0, to_box, to_item, &nearest);
    return nearest;
  }

 private:
  static constexpr std::size_t kFanOut = 8;

  std::size_t EndOf(std::size_t level) const {
    return level + 1 < levels_.size() ? levels_[level + 1] : boxes_.size();
  }

  template <typename Enter, typename Visit>
  void Descend(std::size_t level, std::size_t i, const Enter& enter, const Visit& visit) const {
    if (!enter(boxes_[levels_[level] + i])) return;
    if (level == 0) {
      visit(i);
      return;
    }
    const std::size_t num_below = EndOf(level - 1) - levels_[level - 1];
    const std::size_t end = std::min((i + 1) * kFanOut, num_below);
    for (std::size_t child = i * kFanOut; child < end; ++child) Descend(level - 1, child, enter, visit);
  }

  template <typename ToBox, typename ToItem>
  void Approach(std::size_t level, std::size_t i, const ToBox& to_box, const ToItem& to_item,
                Nearest* nearest) const {
    if (level == 0) {
      const double squared = to_item(i);
      if (squared < nearest->squared_distance) *nearest = {i, squared};
      return;
    }
    const std::size_t num_below = EndOf(level - 1) - levels_[level - 1];
    const std::size_t begin = i * kFanOut;
    const std::size_t count = std::min(begin + kFanOut, num_below) - begin;
    std::array<double, kFanOut> bounds;
    for (std::size_t k = 0; k < count; ++k) bounds[k] = to_box(boxes_[levels_[level - 1] + begin + k]);
    for (std::size_t done = 0; done < count; ++done) {
      const auto next = std::min_element(bounds.begin(), bounds.begin() + static_cast<std::ptrdiff_t>(count));
      if (!(*next < nearest->squared_distance)) return;
      *next = std::numeric_limits<double>::infinity();
      Approach(level - 1, begin + static_cast<std::size_t>(next - bounds.begin()), to_box, to_item, nearest);
    }
  }

  std::vector<Box> boxes_;           // the items, then level after level
  std::size_t size_ = 0;             // items
  std::vector<std::size_t> levels_;  // where each level begins; the last one is the root
};

}  // namespace terrace
