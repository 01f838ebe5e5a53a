// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "stereo/disparity_units.h"

namespace terrace {

constexpr int kReach = 2;  // of the 5x5 window
constexpr int kWindowPixels = 25;
constexpr int kImageBorder = 96;  // pixels repeated left and right of the images, which vectors may touch
constexpr int kRowMargin = UnitImage::kMargin;

constexpr int kUnitsPerPx = UnitImage::kUnitsPerPx;
/// Grey levels and gradients are in eighths, cut so that the sum over a window fits into 16 bits.
constexpr int kGreyUnits = 8;
constexpr int kMaxGrey = 1300;

/// The known disparities of five rows, column by column.
struct ColumnDisparities {
  std::int16_t* sum;  ///< without what does not fit into 16 bits
  std::int16_t *low, *high;
};

/// What the two images say about one row at the disparities given, smoothed.
struct ResidualRow {
  std::int16_t* disparity;  ///< 0 where unknown or outside the right image: then all others are 0 as well
  std::int16_t* valid;      ///< 1 where known and not beside another surface
  std::int16_t* gradient;   ///< of the left image, along the row
  std::int16_t* residual;   ///< left less right
  std::int16_t* at_edge;    ///< not 0 where the window holds other surfaces
  std::int16_t* slope;      ///< of the disparity from row to row, where the surface is steep
  bool any_steep = false;   ///< else `slope` holds nothing
};

/// Sums over five rows, column by column. All are whole numbers below 2^24.
struct ColumnSums {
  std::int16_t *n, *g, *e;
  float *gg, *ge, *ee;
};

struct RefineLimits {
  std::int16_t max_jump;  ///< in kUnitsPerPx
  std::int16_t gain;      ///< of the left image against the right one, times 2^13
  float max_step, given_sigma;
};

/// @param rows    of disparities, in units; the middle one's columns are asked for
/// @param middle  where the surface is steep, and how
void DisparitiesOfColumns(const std::int16_t* const* rows, const ResidualRow& middle, int width,
                          const ColumnDisparities& columns);
/// Residual and gradient of the middle one of five rows of disparities.
void ResidualsOfRow(const std::uint8_t* left, const std::uint8_t* right, const std::int16_t* const* rows,
                    const ColumnDisparities& columns, int width, const RefineLimits& limits,
                    const ResidualRow& out);

/// Moves the sums of columns down by a row.
void MoveColumnSums(const ResidualRow& entering, const ResidualRow& leaving, int width,
                    const ColumnSums& sums);
/// The middle one of five rows, whose residuals and sums are known.
/// @param sigma  out; null: not wanted
void RefineRow(const ResidualRow* rows, const ColumnSums& columns, int width, const RefineLimits& limits,
               float* disparity, float* sigma);

}  // namespace terrace
