// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/place_view.h"
#include "core/terrain_map.h"

namespace terrace {

/// A map and, where they were kept, the views by which its places are recognised.
struct SavedMap {
  TerrainMapPtr map;
  std::vector<PlaceView> views;
};

/// A map as the bytes of a `.terrace` file: exact, every bit of every number. Little endian: the text
/// "TERRACE" and a zero, the version and the size of the file as 32 and 64 bits, a checksum of 64 bits over
/// all the rest, then head, staircases, regions and views one member after the other (terrace_file.cpp). A
/// file without views is of version 1, one with views of version 2.
std::vector<std::uint8_t> TerraceFileBytes(const TerrainMap& map, const std::vector<PlaceView>& views = {});
/// Throws FileError (core/file_bytes.h) with the name, the place and what is wrong. What changes within one
/// of its words of eight bytes is always found, anything else but once in 2^64 times.
SavedMap FromTerraceFile(std::span<const std::uint8_t> bytes, const std::string& name);

/// Throws FileError. The file is there whole or not at all.
void SaveTerraceFile(const std::filesystem::path& path, const TerrainMap& map,
                     const std::vector<PlaceView>& views = {});
SavedMap LoadTerraceFile(const std::filesystem::path& path);

}  // namespace terrace
