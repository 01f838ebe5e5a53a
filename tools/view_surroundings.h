// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <terrace/disparity_v1_t.hpp>
#include <terrace/octree_v1_t.hpp>

#include "client/terrain_query.h"
#include "core/time.h"
#include "tools/view_record.h"

namespace terrace {

// What the map is made of, and what is no plane: as records that a browser can be sent.

/// The cells of an octree that no region passes through. Little endian: edge of a finest leaf [m] and the
/// lowest corner x, y, z of all [m, world] as float32, then for each cell its lowest corner from there in
/// finest leaves and its edge in finest leaves, four uint16. Null when the message holds no octree that can
/// be read.
/// @param query  to the map; null: there is none, and all cells are taken
ViewBytes CellsRecord(const octree_v1_t& message, Timestamp t_heard, const TerrainQuery* query);

/// Disparity as a picture: least and greatest known disparity [px] as float32, then a JPEG whose colours run
/// between them, dark violet to yellow; black: not known. Null when the message cannot be read, or knows
/// nothing.
ViewBytes DisparityRecord(const disparity_v1_t& message, Timestamp t_heard);

/// Points of a disparity image, one of every fourth pixel along either axis, that lie on no region. Little
/// endian: place of the camera x, y, z [m, world] and the unit u [m] as float32, then for each point its
/// offset from there in units, three int16. Null when the message cannot be read, or does not know where it
/// was taken.
ViewBytes PointsRecord(const disparity_v1_t& message, Timestamp t_heard, const TerrainQuery* query);

}  // namespace terrace
