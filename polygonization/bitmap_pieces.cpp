// SPDX-License-Identifier: BSD-3-Clause
#include "polygonization/bitmap_pieces.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <numeric>

#include "core/check.h"

namespace terrace {
namespace {

constexpr int kNoPiece = -1;

/// Which ways the edge of a piece leaves each corner inside a box.
class EdgeField {
 public:
  enum Direction { kEast, kNorth, kWest, kSouth };

  explicit EdgeField(const cv::Rect& box)
      : box_(box), width_(box.width + 1), out_(static_cast<std::size_t>(width_) * (box.height + 1), 0) {}

  void Add(int x, int y, Direction direction) {
    At(x, y) = static_cast<std::uint8_t>(At(x, y) | 1U << direction);
  }
  bool Any(int x, int y) { return At(x, y) != 0; }

  /// Takes a ring out, from one of its corners on.
  std::vector<cv::Point> Follow(int x, int y) {
    static constexpr std::array<int, 4> kDx{1, 0, -1, 0};
    static constexpr std::array<int, 4> kDy{0, 1, 0, -1};
    std::vector<cv::Point> ring;
    int last = kNoPiece;
    while (Any(x, y)) {
      int direction = 0;
      while ((At(x, y) >> direction & 1U) == 0) ++direction;
      At(x, y) = static_cast<std::uint8_t>(At(x, y) & ~(1U << direction));
      if (direction != last) ring.emplace_back(x, y);
      last = direction;
      x += kDx[direction];
      y += kDy[direction];
    }
    // The walk may have begun in the middle of a straight edge.
    if (ring.size() > 2) {
      const cv::Point a = ring.back(), b = ring.front(), c = ring[1];
      if ((a.x == b.x && b.x == c.x) || (a.y == b.y && b.y == c.y)) ring.erase(ring.begin());
    }
    return ring;
  }

 private:
  std::uint8_t& At(int x, int y) {
    return out_[static_cast<std::size_t>(y - box_.y) * width_ + (x - box_.x)];
  }

  const cv::Rect box_;
  const int width_;
  std::vector<std::uint8_t> out_;
};

}  // namespace

BitmapPieces::BitmapPieces(const cv::Mat1b& bitmap) {
  FindRuns(bitmap);
  FindPieces();
}

void BitmapPieces::FindRuns(const cv::Mat1b& bitmap) {
  for (int y = 0; y < bitmap.rows; ++y) {
    first_run_.push_back(static_cast<int>(runs_.size()));
    const std::uint8_t* row = bitmap[y];
    const std::uint8_t* const row_end = row + bitmap.cols;
    const auto find = [&](const std::uint8_t* from, int value) {
      const void* found = std::memchr(from, value, static_cast<std::size_t>(row_end - from));
      return found != nullptr ? static_cast<const std::uint8_t*>(found) : row_end;
    };
    for (const std::uint8_t* begin = find(row, 255); begin != row_end;) {
      const std::uint8_t* end = find(begin, 0);
      runs_.push_back({y, static_cast<int>(begin - row), static_cast<int>(end - row), kNoPiece});
      begin = find(end, 255);
    }
  }
  first_run_.push_back(static_cast<int>(runs_.size()));
}

void BitmapPieces::FindPieces() {
  // Each run belongs to the tree of the first run it hangs together with.
  std::vector<int> parent(runs_.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root_of = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t y = 1; y + 1 < first_run_.size(); ++y) {
    int above = first_run_[y - 1], below = first_run_[y];
    while (above < first_run_[y] && below < first_run_[y + 1]) {
      if (std::max(runs_[above].begin, runs_[below].begin) < std::min(runs_[above].end, runs_[below].end)) {
        const int a = root_of(above), b = root_of(below);
        parent[std::max(a, b)] = std::min(a, b);
      }
      ++(runs_[above].end < runs_[below].end ? above : below);
    }
  }
  std::vector<std::int64_t> sum_x, sum_y;
  for (int i = 0; i < static_cast<int>(runs_.size()); ++i) {
    Run& run = runs_[i];
    const int root = root_of(i);
    if (root == i) {
      run.piece = static_cast<int>(pieces_.size());
      pieces_.emplace_back();
      sum_x.push_back(0);
      sum_y.push_back(0);
    }
    run.piece = runs_[root].piece;
    Piece& piece = pieces_[run.piece];
    const int count = run.end - run.begin;
    piece.box |= cv::Rect(run.begin, run.y, count, 1);
    piece.num_pixels += count;
    sum_x[run.piece] += std::int64_t{count} * (run.begin + run.end - 1);  // twice
    sum_y[run.piece] += std::int64_t{count} * run.y;
  }
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    pieces_[i].centroid =
        Eigen::Vector2d(0.5 * static_cast<double>(sum_x[i]), static_cast<double>(sum_y[i])) /
        pieces_[i].num_pixels;
}

int BitmapPieces::PieceAt(int x, int y) const {
  if (y < 0 || y + 1 >= static_cast<int>(first_run_.size())) return kNoPiece;
  const auto row_end = runs_.begin() + first_run_[y + 1];
  const auto run = std::upper_bound(runs_.begin() + first_run_[y], row_end, x,
                                    [](int value, const Run& r) { return value < r.end; });
  return run != row_end && run->begin <= x ? run->piece : kNoPiece;
}

std::vector<int> BitmapPieces::CountSet(const cv::Mat1b& bitmap) const {
  TERRACE_CHECK(bitmap.rows + 1 == static_cast<int>(first_run_.size()), bitmap.rows, first_run_.size());
  std::vector<int> counts(pieces_.size(), 0);
  for (const Run& run : runs_) {
    const std::uint8_t* row = bitmap[run.y];
    counts[run.piece] +=
        run.end - run.begin - static_cast<int>(std::count(row + run.begin, row + run.end, 0));
  }
  return counts;
}

template <typename Use>
void BitmapPieces::ForEachGap(int y, int begin, int end, const Use& use) const {
  if (y >= 0 && y + 1 < static_cast<int>(first_run_.size())) {
    const auto row_end = runs_.begin() + first_run_[y + 1];
    auto run = std::upper_bound(runs_.begin() + first_run_[y], row_end, begin,
                                [](int value, const Run& r) { return value < r.end; });
    for (; run != row_end && run->begin < end; ++run) {
      if (begin < run->begin) use(begin, run->begin);
      begin = run->end;
    }
  }
  if (begin < end) use(begin, end);
}

std::vector<std::vector<cv::Point>> BitmapPieces::TraceRings(int piece) const {
  const cv::Rect& box = pieces_[piece].box;
  const auto for_each_run = [&](const auto& use) {
    for (int i = first_run_[box.y]; i < first_run_[box.y + box.height]; ++i)
      if (runs_[i].piece == piece) use(runs_[i]);
  };
  EdgeField edges(box);
  for_each_run([&](const Run& run) {
    edges.Add(run.begin, run.y + 1, EdgeField::kSouth);
    edges.Add(run.end, run.y, EdgeField::kNorth);
    ForEachGap(run.y - 1, run.begin, run.end, [&](int begin, int end) {
      for (int x = begin; x < end; ++x) edges.Add(x, run.y, EdgeField::kEast);
    });
    ForEachGap(run.y + 1, run.begin, run.end, [&](int begin, int end) {
      for (int x = begin; x < end; ++x) edges.Add(x + 1, run.y + 1, EdgeField::kWest);
    });
  });
  // The first corner of a ring, row by row, is where a run begins, or, around a hole, ends.
  std::vector<std::vector<cv::Point>> rings;
  for_each_run([&](const Run& run) {
    for (const int x : {run.begin, run.end})
      while (edges.Any(x, run.y)) rings.push_back(edges.Follow(x, run.y));
  });
  return rings;
}

}  // namespace terrace
