// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "stereo/census.h"

namespace terrace {

constexpr int kBlock = 16;        // pixels whose minima are found together
constexpr int kRowsTogether = 8;  // through which the horizontal paths run in lockstep

/// Bytes between the states of neighbouring pixels' paths. They hold 255, so that a disparity outside the
/// range is never the best neighbour.
constexpr int kPathPadding = 64;
/// Bytes before the first pixel of a row of paths, and behind the last: room for a pixel beside the image,
/// where diagonal paths begin.
constexpr int kPathMargin = kPathPadding + 256 + kPathPadding;
constexpr int kMinimaMargin = 64;
/// Where the ranges of neighbours differ they hold at most 32 disparities, so that ranges shifted by this
/// against each other do not touch: greater shifts are cut to it.
constexpr int kMaxRangeThatShifts = 32;
constexpr int kMaxShift = 33;

/// From which column, counted from its own, the paths come into a pixel from the row before: the vertical one
/// and the diagonal ones.
constexpr int kFromColumn[] = {0, -1, 1};
constexpr int kMostFromRow = 3;

/// Where the work on a strip goes on.
struct StripMemory {
  std::uint8_t* costs;        // of kRowsTogether rows
  std::uint8_t* sums;         // of all paths but those from above, of all rows of the strip and one more
  std::uint8_t* row_sums;     // of all paths, of one row
  std::uint8_t* paths[2];     // state of the paths from row to row: the row before and this one
  std::uint8_t* minima[2];    // of the same
  std::uint8_t *shifts, *p2;  // of ranges of 16: of kRowsTogether rows
  std::ptrdiff_t row_bytes;
  std::ptrdiff_t pixel_bytes;               // of the state of one path
  std::ptrdiff_t path_bytes, minima_bytes;  // from one path's row to the next one's: vertical, diagonal
  int padded_width;
};

/// In place of the number of vectors that hold the disparities of a pixel: one vector holds those of several.
constexpr int kOfBlocks = -1;

alignas(64) constexpr std::uint8_t kNoCosts[256] = {};

/// One row of the images and of the volumes.
struct RowPointers {
  const std::uint8_t* left[CensusImage::kNumPlanes];
  const std::uint8_t* right[CensusImage::kNumPlanes];
  const std::uint8_t* p2[kMostFromRow];            // of the horizontal paths only the first
  const std::int16_t* first;                       // disparity of each pixel's range
  const std::int16_t* first_before[kMostFromRow];  // the same of the pixel that the path comes from
  const std::uint8_t* prior_costs;
  std::uint8_t* costs;
  std::uint8_t* sums;
};

/// Cost of a disparity that leads out of the right image: more than a good match has, less than a wrong one,
/// so that surfaces continue to where only the left camera sees them; such winners are thrown away. Less
/// where the left image shows nothing either: there it says nothing about where things are not.
constexpr std::uint8_t kMaxCostOutside = 10;

/// What becomes of the values of the paths from row to row, and of the costs, which are computed on the way.
enum class Sums {
  kNone,   // outside the strip: neither is kept
  kCosts,  // no such paths: the costs are stored
  kSet,    // the upward paths: both are stored
  kAdd,    // the downward paths: with the other paths' sums they give the row's
};

}  // namespace terrace
