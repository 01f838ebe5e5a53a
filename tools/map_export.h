// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/terrain_map.h"
#include "mapping/octomap_bytes.h"

namespace terrace {

// A map as the bytes of files that other programs read. World frame, metres.

/// Stanford PLY, binary: triangles with the colour of their label, the normal, the label's number and the
/// region's id at each vertex.
std::string PlyBytes(const TerrainMap& map);
/// glTF 2.0 in one binary file (.glb), y up as it is there: one mesh a label, in its colour.
std::string GlbBytes(const TerrainMap& map);
/// A FeatureCollection as in GeoJSON, but for its coordinates, which are metres in the world, x y z: a
/// Polygon with holes a region, with label, confidence, plane and staircase as properties.
std::string GeoJsonText(const TerrainMap& map);
/// Voxels of this edge that the regions pass through, as OctoMap's file. Between them is what is free or
/// unknown: a map does not say which.
std::string OctomapText(const TerrainMap& map, double voxel_m, OctomapFormat format);

}  // namespace terrace
