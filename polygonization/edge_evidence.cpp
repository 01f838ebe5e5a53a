// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/edge_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace terrace {
namespace {

/// Evidence is asked for so far beyond an edge; it ends there soon, for it is taken near the surface only.
constexpr std::array<double, 3> kBeyond_m{0.015, 0.03, 0.045};
constexpr double kSpacing_m = 0.02;
/// What is said of an edge rests on at least this stretch of its ring, half before and half behind the
/// middle.
constexpr double kStretch_m = 0.3;
/// At so many places at least one looks past the plane, and at so many times more than where it goes on.
constexpr int kLeastPast = 4;
constexpr int kMoreThanOn = 2;

/// Numbers of places along a ring up to each.
struct Counts {
  std::vector<int> past{0}, on{0};
};

class RingView {
 public:
  RingView(const Ring2& ring, const EvidenceGrid& evidence) {
    EvidenceGrid::Reader reader(evidence);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      first_.push_back(num_places());
      const Eigen::Vector2d from = ring[i], to = ring[(i + 1) % ring.size()];
      const double length_m = (to - from).norm();
      const Eigen::Vector2d along = (to - from) / std::max(1e-12, length_m);
      const Eigen::Vector2d outward(along.y(), -along.x());  // the surface lies on the left
      const int num = std::max(1, static_cast<int>(length_m / kSpacing_m));
      for (int k = 0; k < num; ++k) Ask(from + (k + 0.5) / num * length_m * along, outward, &reader);
    }
    first_.push_back(num_places());
  }

  bool SeenPast(std::size_t edge) const {
    const int middle = (first_[edge] + first_[edge + 1]) / 2;
    const int half =
        std::max((first_[edge + 1] - first_[edge] + 1) / 2, static_cast<int>(0.5 * kStretch_m / kSpacing_m));
    const int past = Around(counts_.past, middle, half), on = Around(counts_.on, middle, half);
    return past >= kLeastPast && past >= kMoreThanOn * on;
  }

 private:
  int num_places() const { return static_cast<int>(counts_.past.size()) - 1; }

  void Ask(const Eigen::Vector2d& p, const Eigen::Vector2d& outward, EvidenceGrid::Reader* reader) {
    bool past = false, on = false;
    for (const double d : kBeyond_m) {
      const int known = reader->At(p + d * outward);
      past = past || known < 0;
      on = on || known >= EvidenceGrid::kOn;
    }
    counts_.past.push_back(counts_.past.back() + (past ? 1 : 0));
    counts_.on.push_back(counts_.on.back() + (on && !past ? 1 : 0));
  }

  /// The sum over the places around one, each at most once.
  int Around(const std::vector<int>& sums, int middle, int half) const {
    const int n = num_places();
    if (2 * half >= n) return sums.back();
    const int from = middle - half, to = middle + half;
    int sum =
        sums[static_cast<std::size_t>(std::min(to, n))] - sums[static_cast<std::size_t>(std::max(from, 0))];
    if (from < 0) sum += sums.back() - sums[static_cast<std::size_t>(n + from)];
    if (to > n) sum += sums[static_cast<std::size_t>(to - n)];
    return sum;
  }

  Counts counts_;
  std::vector<int> first_;  // place of each edge, and the number of places
};

}  // namespace

std::vector<bool> EdgesSeenPast(const TracedPiece& piece, const EvidenceGrid& evidence) {
  std::vector<bool> seen_past;
  const auto add = [&](const Ring2& ring) {
    const RingView view(ring, evidence);
    for (std::size_t i = 0; i < ring.size(); ++i) seen_past.push_back(view.SeenPast(i));
  };
  add(piece.outline);
  for (const Ring2& hole : piece.holes) add(hole);
  return seen_past;
}

}  // namespace terrace
