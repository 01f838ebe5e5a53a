// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include <Eigen/Core>

#include "core/body_pose.h"
#include "core/terrain_map.h"
#include "core/time.h"
#include "tools/view_record.h"

namespace terrace {

/// What there is one newest of, in the order in which it is sent. When there is not time for everything,
/// there is none for the last ones.
enum class ViewSlot { kCamera, kPlan, kImage, kDisparity, kCells, kPoints };
inline constexpr std::size_t kNumViewSlots = 6;

/// Some of the slots.
class ViewSlots {
 public:
  bool Has(ViewSlot slot) const { return ((bits_ >> static_cast<unsigned>(slot)) & 1u) != 0; }
  void Add(ViewSlot slot) { bits_ |= 1u << static_cast<unsigned>(slot); }
  void Add(const ViewSlots& others) { bits_ |= others.bits_; }

 private:
  unsigned bits_ = 0;
};

/// What is known now, for any number of browsers. Keeps no queue for anybody: each browser's ViewCursor says
/// what that one lacks, so what a slow one costs does not grow. Used from one thread.
class ViewFeed {
 public:
  explicit ViewFeed(const ViewHello& hello) : hello_(MakeHello(hello)) {}

  void TakeMap(TerrainMapPtr map, Timestamp t_heard);
  void TakePose(const BodyPose& pose, ViewBytes record);
  void TakeEvent(ViewBytes record);  ///< status or reply
  /// The newest one of its slot.
  void Take(ViewSlot slot, ViewBytes record) { newest_[static_cast<std::size_t>(slot)] = std::move(record); }

 private:
  friend class ViewCursor;

  const ViewBytes hello_;
  std::array<ViewBytes, kNumViewSlots> newest_;
  TerrainMapPtr map_;
  Timestamp t_map_heard_;
  /// Poses that tell the way so far to who comes later: one every few centimetres, thinned when they are
  /// many.
  std::vector<ViewBytes> way_;
  std::vector<Eigen::Vector3d> way_places_;
  int epoch_ = 0;
  double way_step_m_ = kFirstStepM;
  /// The newest poses, status messages and replies, by number.
  std::deque<ViewBytes> events_;
  std::int64_t next_event_ = 0;

  static constexpr double kFirstStepM = 0.05;
};

/// What one browser has been sent.
class ViewCursor {
 public:
  explicit ViewCursor(const ViewFeed* feed) : feed_(feed) { Restart(); }

  /// Everything is to be sent again, from who speaks to the whole map.
  void Restart();
  /// Of the slots, camera and plan are sent in any case, others only when they are wanted.
  void SetWants(const ViewSlots& wants) { wants_ = wants; }
  const ViewSlots& wants() const { return wants_; }

  /// What is to be sent next; null when the browser has everything.
  ViewBytes Next();

  /// Poses, status messages and replies that came too fast for this browser.
  std::int64_t num_skipped() const { return num_skipped_; }

 private:
  ViewBytes NextOfMap();
  ViewBytes NextOfSlot(ViewSlot slot);

  const ViewFeed* feed_;
  ViewSlots wants_;
  std::deque<ViewBytes> start_;  // what begins a stream, not sent yet
  std::array<ViewBytes, kNumViewSlots> sent_;
  TerrainMapPtr sent_map_;
  std::vector<std::int64_t> seen_again_;  // to be told, of sent_map_
  std::int64_t next_event_ = 0;
  std::int64_t num_skipped_ = 0;
};

}  // namespace terrace
