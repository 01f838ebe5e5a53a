// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include <Eigen/Core>

#include "labeling/flight_model.h"
#include "labeling/region_shape.h"

namespace terrace {

/// The unrolled coordinates of a flight that may be there: how far up the stairs (`along`) and how far across
/// them (`lateral`) something lies. In them every flight is straight.
class FlightFrame {
 public:
  virtual ~FlightFrame() = default;

  /// @param lateral  what lies beside it does not count: of the flight, or of the shape itself
  virtual Interval AlongExtent(const RegionShape& shape, const Interval& lateral) const = 0;
  virtual Interval LateralExtent(const RegionShape& shape) const = 0;
  virtual Eigen::Vector2d PointAt(double along_m, double lateral_m) const = 0;
  /// Unit vector up the stairs at a point of the plan.
  virtual Eigen::Vector2d UpAt(const Eigen::Vector2d& p) const = 0;
  /// After how much `along` a flight is back where it was; 0: never.
  virtual double period_m() const = 0;
  virtual bool spiral() const = 0;
  /// The law with riser 1 at `foot_along_m`, in the coordinates of the level frame.
  /// @param lateral  of the flight
  virtual FlightModel ModelAt(double foot_along_m, const Interval& lateral) const = 0;

  /// Along, of all that it may be, what is nearest to the hint.
  double Unwrapped(double along_m, double hint_m) const;
  /// Height of a support where it comes nearest to a place of the flight.
  double HeightNear(const RegionShape& shape, double along_m, double lateral_m) const;
};
using FlightFramePtr = std::shared_ptr<const FlightFrame>;

/// Along one direction of the plan; lateral to the left of the origin of the level frame.
class StraightFrame : public FlightFrame {
 public:
  explicit StraightFrame(const Eigen::Vector2d& direction) : direction_(direction) {}

  Interval AlongExtent(const RegionShape& shape, const Interval& lateral) const override;
  Interval LateralExtent(const RegionShape& shape) const override;
  Eigen::Vector2d PointAt(double along_m, double lateral_m) const override;
  Eigen::Vector2d UpAt(const Eigen::Vector2d& /*p*/) const override { return direction_; }
  double period_m() const override { return 0.0; }
  bool spiral() const override { return false; }
  FlightModel ModelAt(double foot_along_m, const Interval& lateral) const override;

 private:
  Eigen::Vector2d direction_;
};

/// Around an axis, along the circle of the middle radius; lateral is the distance from the axis.
class SpiralFrame : public FlightFrame {
 public:
  /// @param turn_sign  +1 turns left going up, -1 right
  SpiralFrame(const Eigen::Vector2d& axis, double radius_m, double turn_sign)
      : axis_(axis), radius_m_(radius_m), turn_sign_(turn_sign) {}

  Interval AlongExtent(const RegionShape& shape, const Interval& lateral) const override;
  Interval LateralExtent(const RegionShape& shape) const override;
  Eigen::Vector2d PointAt(double along_m, double lateral_m) const override;
  Eigen::Vector2d UpAt(const Eigen::Vector2d& p) const override;
  double period_m() const override;
  bool spiral() const override { return true; }
  FlightModel ModelAt(double foot_along_m, const Interval& lateral) const override;

 private:
  Eigen::Vector2d axis_;
  double radius_m_;
  double turn_sign_;
};

/// The frame in which a known flight lies, and where in it.
struct PlacedFrame {
  FlightFramePtr frame;
  double foot_along_m = 0.0;
  Interval lateral;
};
PlacedFrame FrameOf(const FlightModel& model);

}  // namespace terrace
