// SPDX-License-Identifier: BSD-3-Clause
#include "client/ot_cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

namespace terrace {
namespace {

constexpr int kOtDepth = 16;
constexpr std::string_view kDataMark = "\ndata\n";
constexpr std::string_view kOtMagic = "# Octomap OcTree file";

[[noreturn]] void RefuseOt(const char* why) { throw std::runtime_error(std::string("octree: ") + why); }

/// Goes through the nodes in the order of the file, parents before children, lowest child first.
class NodeReader {
 public:
  NodeReader(std::span<const std::uint8_t> bytes, std::vector<OccupiedCell>* cells)
      : bytes_(bytes), cells_(cells) {}

  void Read(const Eigen::Vector3i& corner, int depth) {
    float log_odds = 0.0f;
    if (bytes_.size() < sizeof(log_odds) + 1) RefuseOt("ends in the middle of a node");
    std::memcpy(&log_odds, bytes_.data(), sizeof(log_odds));  // as the writing machine has it: little endian
    const unsigned children = bytes_[sizeof(log_odds)];
    bytes_ = bytes_.subspan(sizeof(log_odds) + 1);
    const int num_leaves = 1 << (kOtDepth - depth);
    if (children == 0) {
      if (log_odds > 0.0f) cells_->push_back({corner, num_leaves});
      return;
    }
    if (depth == kOtDepth) RefuseOt("is deeper than an octree of OctoMap");
    for (int child = 0; child < 8; ++child) {
      if (((children >> child) & 1u) == 0) continue;
      const Eigen::Vector3i octant(child & 1, (child >> 1) & 1, (child >> 2) & 1);
      Read(corner + num_leaves / 2 * octant, depth + 1);
    }
  }

  bool done() const { return bytes_.empty(); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::vector<OccupiedCell>* const cells_;
};

}  // namespace

OccupiedCells ReadOtCells(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kMaxHeader = 1024;
  const std::string_view start(reinterpret_cast<const char*>(bytes.data()),
                               std::min(bytes.size(), kMaxHeader));
  const std::size_t mark = start.find(kDataMark);
  if (!start.starts_with(kOtMagic) || mark == std::string_view::npos) RefuseOt("is no file of OctoMap's .ot");
  std::istringstream header{std::string(start.substr(0, mark))};
  OccupiedCells result;
  std::string id;
  std::size_t num_nodes = 0;
  for (std::string line; std::getline(header, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "id") words >> id;
    if (key == "size") words >> num_nodes;
    if (key == "res") words >> result.leaf_m;
  }
  if (id != "OcTree") RefuseOt("is of another kind than OcTree");
  if (!(result.leaf_m > 0.0) || !std::isfinite(result.leaf_m)) RefuseOt("has no size of a leaf");
  NodeReader nodes(bytes.subspan(mark + kDataMark.size()), &result.cells);
  if (num_nodes > 0) nodes.Read(Eigen::Vector3i::Constant(-(1 << (kOtDepth - 1))), 0);
  if (!nodes.done()) RefuseOt("goes on behind its last node");
  return result;
}

}  // namespace terrace
