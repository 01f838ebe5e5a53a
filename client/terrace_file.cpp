// SPDX-License-Identifier: BSD-3-Clause
#include "client/terrace_file.h"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "client/byte_stream.h"
#include "core/file_bytes.h"

namespace terrace {
namespace {

constexpr std::array<char, 8> kMagic{'T', 'E', 'R', 'R', 'A', 'C', 'E', '\0'};
constexpr std::uint32_t kWithoutViews = 1;
constexpr std::uint32_t kWithViews = 2;
// Magic, version with four bytes of room, size, checksum.
constexpr std::size_t kChecksumAt = 24;
constexpr std::size_t kHeaderBytes = 32;
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 30;
constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

// Least bytes that an item takes, so that counts are checked before anything is allocated.
constexpr std::size_t kMinRegionBytes = 200;
constexpr std::size_t kMinStaircaseBytes = 200;
constexpr std::size_t kMinViewBytes = 140;
constexpr std::size_t kCornerBytes = 3 * sizeof(double) + sizeof(Descriptor);
constexpr std::size_t kVertexBytes = 3 * sizeof(double);
constexpr std::size_t kEdgeBytes = 1 + 2 * sizeof(double);

/// FNV-1a over words of eight bytes, the checksum's own place taken as zero. For a given rest of the file
/// each step is a one-to-one map of what came before, so that a change within one word is never lost.
std::uint64_t Checksum(std::span<const std::uint8_t> bytes) {
  std::uint64_t sum = 0xcbf29ce484222325ULL;
  for (std::size_t at = 0; at < bytes.size(); at += 8) {
    if (at == kChecksumAt) continue;
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, 8);
    sum = (sum ^ word) * 0x100000001b3ULL;
  }
  return sum;
}

void PutVector(ByteWriter* out, const Eigen::Vector3d& v) { out->PutDoubles(v.data(), 3); }
void PutPose(ByteWriter* out, const Eigen::Isometry3d& pose) { out->PutDoubles(pose.matrix().data(), 16); }

void PutRing(ByteWriter* out, const Ring& ring) {
  out->Put(static_cast<std::uint32_t>(ring.size()));
  out->PutDoubles(ring.empty() ? nullptr : ring.front().data(), 3 * ring.size());
}

void PutRegion(ByteWriter* out, const TerrainRegion& region) {
  out->Put(region.id);
  out->Put(std::int32_t{region.revision});
  out->Put(static_cast<std::int8_t>(region.label));
  out->Put(static_cast<std::int8_t>(region.source));
  out->Put(region.confidence);
  out->PutText(region.why);
  PutVector(out, region.plane_world.normal);
  out->Put(region.plane_world.offset_m);
  out->PutDoubles(region.plane_covariance.data(), 9);
  PutVector(out, region.centroid_world);
  out->Put(region.rms_m);
  out->Put(region.area_m2);
  out->Put(region.support);
  out->Put(std::int32_t{region.num_observations});
  out->Put(region.first_seen.ns);
  out->Put(region.last_seen.ns);
  out->Put(static_cast<std::int8_t>(region.staircase_id.has_value()));
  out->Put(region.staircase_id.value_or(0));
  out->Put(static_cast<std::int8_t>(region.step_index.has_value()));
  out->Put(std::int32_t{region.step_index.value_or(0)});
  PutRing(out, region.outline_world);
  out->Put(static_cast<std::uint32_t>(region.holes_world.size()));
  for (const Ring& hole : region.holes_world) PutRing(out, hole);
  out->Put(static_cast<std::uint32_t>(region.edges.size()));
  for (const RegionEdge& edge : region.edges) {
    out->Put(static_cast<std::int8_t>(edge.kind));
    out->Put(edge.step_m.value_or(kNotGiven));
    out->Put(edge.sigma_m.value_or(kNotGiven));
  }
}

void PutStaircase(ByteWriter* out, const Staircase& staircase) {
  out->Put(staircase.id);
  out->Put(std::int32_t{staircase.num_risers});
  out->Put(std::int32_t{staircase.num_treads});
  for (const double value :
       {staircase.riser_m, staircase.riser_sigma_m, staircase.tread_m, staircase.tread_sigma_m,
        staircase.width_m, staircase.turn_per_step_rad, staircase.pitch_rad, staircase.confidence})
    out->Put(value);
  for (const auto* edge : {&staircase.foot_edge_world, &staircase.head_edge_world})
    for (const Eigen::Vector3d& end : *edge) PutVector(out, end);
  PutVector(out, staircase.direction_up_world);
  out->Put(staircase.last_seen.ns);
  out->Put(static_cast<std::uint32_t>(staircase.region_ids.size()));
  for (const std::int64_t id : staircase.region_ids) out->Put(id);
}

void PutView(ByteWriter* out, const PlaceView& view) {
  out->Put(view.t_capture.ns);
  PutPose(out, view.T_world_left);
  out->Put(static_cast<std::uint32_t>(view.corners.size()));
  for (const PlaceCorner& corner : view.corners) {
    PutVector(out, corner.p_left);
    for (const std::uint64_t word : corner.descriptor) out->Put(word);
  }
}

/// Reads members and holds them to what the structs promise.
class MapReader {
 public:
  explicit MapReader(ByteReader* in) : in_(in) {}

  TerrainMap Map() {
    TerrainMap map;
    map.t_capture.ns = in_->Take<std::int64_t>();
    map.seq = in_->Take<std::int64_t>();
    map.map_id = in_->Take<std::int64_t>();
    map.epoch = in_->Take<std::int32_t>();
    map.T_world_left = Pose();
    in_->TakeDoubles(map.covariance.data(), 36);
    const Eigen::Isometry3d T_body_left = Pose();
    if (Flag()) map.T_body_left = T_body_left;
    map.gravity.down_world = Unit();
    map.gravity.sigma_rad = Number();
    map.gravity.source = Enum<GravitySource>(kNumGravitySources);
    for (std::size_t left = in_->TakeCount(kMinStaircaseBytes); left > 0; --left) {
      map.staircases.push_back(OneStaircase());
      RequireAscending(map.staircases, [](const Staircase& staircase) { return staircase.id; });
    }
    for (std::size_t left = in_->TakeCount(kMinRegionBytes); left > 0; --left) {
      map.regions.push_back(std::make_shared<const TerrainRegion>(Region()));
      RequireAscending(map.regions, [](const auto& region) { return region->id; });
    }
    return map;
  }

  PlaceView View() {
    PlaceView view;
    view.t_capture.ns = in_->Take<std::int64_t>();
    view.T_world_left = Pose();
    const auto& R = view.T_world_left.linear();
    constexpr double kRounding = 1e-6;
    if (!(R.transpose() * R).isIdentity(kRounding)) in_->Fail("must be a pose without scale or shear");
    for (std::size_t left = in_->TakeCount(kCornerBytes); left > 0; --left) {
      PlaceCorner& corner = view.corners.emplace_back();
      corner.p_left = Vector();
      for (std::uint64_t& word : corner.descriptor) word = in_->Take<std::uint64_t>();
    }
    return view;
  }

 private:
  static constexpr int kNumGravitySources = 5;

  double Number() {
    const auto value = in_->Take<double>();
    if (!std::isfinite(value)) in_->Fail("must be a finite number");
    return value;
  }
  std::optional<double> NumberOrNone() {
    const auto value = in_->Take<double>();
    return std::isnan(value) ? std::nullopt : std::optional(value);
  }
  bool Flag() { return Enum<int>(2) == 1; }
  template <typename Value>
  Value Enum(int count) {
    const auto value = in_->Take<std::int8_t>();
    if (value < 0 || value >= count) in_->Fail("must lie between 0 and " + std::to_string(count - 1));
    return static_cast<Value>(value);
  }
  Eigen::Vector3d Vector() {
    const double x = Number(), y = Number();
    return {x, y, Number()};
  }
  Eigen::Vector3d Unit() {
    constexpr double kRounding = 1e-6;
    const Eigen::Vector3d v = Vector();
    if (std::abs(v.norm() - 1.0) > kRounding) in_->Fail("must be a unit vector");
    return v;
  }
  Eigen::Isometry3d Pose() {
    Eigen::Isometry3d pose;
    in_->TakeDoubles(pose.matrix().data(), 16);
    if (!pose.matrix().allFinite()) in_->Fail("must be a pose of finite numbers");
    return pose;
  }
  Ring OneRing() {
    Ring ring(in_->TakeCount(kVertexBytes));
    if (ring.size() < 3) in_->Fail("a ring must have three vertices or more");
    in_->TakeDoubles(ring.front().data(), 3 * ring.size());
    for (const Eigen::Vector3d& vertex : ring)
      if (!vertex.allFinite()) in_->Fail("vertices must be finite");
    return ring;
  }
  template <typename Items, typename IdOf>
  void RequireAscending(const Items& items, const IdOf& id_of) {
    const bool ascends = items.size() < 2 || id_of(items[items.size() - 2]) < id_of(items.back());
    if (!ascends || id_of(items.back()) <= 0) in_->Fail("ids must be positive and ascend");
  }

  TerrainRegion Region() {
    TerrainRegion region;
    region.id = in_->Take<std::int64_t>();
    region.revision = in_->Take<std::int32_t>();
    region.label = Enum<TerrainLabel>(kNumTerrainLabels);
    region.source = Enum<RegionSource>(kNumRegionSources);
    region.confidence = Number();
    region.why = in_->TakeText();
    region.plane_world.normal = Unit();
    region.plane_world.offset_m = Number();
    in_->TakeDoubles(region.plane_covariance.data(), 9);  // NaN where a map came from text
    region.centroid_world = Vector();
    region.rms_m = Number();
    region.area_m2 = Number();
    region.support = Number();
    region.num_observations = in_->Take<std::int32_t>();
    region.first_seen.ns = in_->Take<std::int64_t>();
    region.last_seen.ns = in_->Take<std::int64_t>();
    const bool on_staircase = Flag();
    const auto staircase_id = in_->Take<std::int64_t>();
    if (on_staircase) region.staircase_id = staircase_id;
    const bool is_step = Flag();
    const auto step_index = in_->Take<std::int32_t>();
    if (is_step) region.step_index = step_index;
    region.outline_world = OneRing();
    for (std::size_t left = in_->TakeCount(kVertexBytes); left > 0; --left)
      region.holes_world.push_back(OneRing());
    TakeEdges(&region);
    return region;
  }

  void TakeEdges(TerrainRegion* region) {
    std::size_t num_vertices = region->outline_world.size();
    for (const Ring& hole : region->holes_world) num_vertices += hole.size();
    const std::size_t num_edges = in_->TakeCount(kEdgeBytes);
    if (num_edges != 0 && num_edges != num_vertices) in_->Fail("must have no edges or one for each vertex");
    region->edges.reserve(num_edges);
    for (std::size_t i = 0; i < num_edges; ++i) {
      RegionEdge edge;
      edge.kind = Enum<EdgeKind>(kNumEdgeKinds);
      edge.step_m = NumberOrNone();
      edge.sigma_m = NumberOrNone();
      region->edges.push_back(edge);
    }
  }

  Staircase OneStaircase() {
    Staircase staircase;
    staircase.id = in_->Take<std::int64_t>();
    staircase.num_risers = in_->Take<std::int32_t>();
    staircase.num_treads = in_->Take<std::int32_t>();
    for (double* value :
         {&staircase.riser_m, &staircase.riser_sigma_m, &staircase.tread_m, &staircase.tread_sigma_m,
          &staircase.width_m, &staircase.turn_per_step_rad, &staircase.pitch_rad, &staircase.confidence})
      *value = Number();
    for (auto* edge : {&staircase.foot_edge_world, &staircase.head_edge_world})
      for (Eigen::Vector3d& end : *edge) end = Vector();
    staircase.direction_up_world = Unit();
    staircase.last_seen.ns = in_->Take<std::int64_t>();
    for (std::size_t left = in_->TakeCount(sizeof(std::int64_t)); left > 0; --left)
      staircase.region_ids.push_back(in_->Take<std::int64_t>());
    return staircase;
  }

  ByteReader* const in_;
};

/// The version.
std::uint32_t TakeHeader(ByteReader* in, std::span<const std::uint8_t> bytes) {
  std::array<char, 8> magic{};
  for (char& c : magic) c = in->Take<char>();
  if (magic != kMagic) in->Fail("this is no .terrace file");
  const auto version = in->Take<std::uint32_t>();
  if (version != kWithoutViews && version != kWithViews)
    in->Fail("is of version " + std::to_string(version) + ", only 1 and 2 are known");
  if (in->Take<std::uint32_t>() != 0) in->Fail("must be zero");
  const auto size = in->Take<std::uint64_t>();
  if (size != bytes.size() || size % 8 != 0)
    in->Fail("the file has " + std::to_string(bytes.size()) + " bytes, must have " + std::to_string(size));
  if (in->Take<std::uint64_t>() != Checksum(bytes)) in->Fail("the checksum differs: the file is damaged");
  return version;
}

/// Enough room for the bytes of a map but for long reasons.
std::size_t RoomFor(const TerrainMap& map, const std::vector<PlaceView>& views) {
  constexpr std::size_t kHeadBytes = 1024, kRegionBytes = 512, kStaircaseBytes = 512;
  std::size_t num_bytes = kHeadBytes;
  for (const auto& region : map.regions) {
    std::size_t num_vertices = region->outline_world.size();
    for (const Ring& hole : region->holes_world) num_vertices += hole.size();
    num_bytes += kRegionBytes + kVertexBytes * num_vertices + kEdgeBytes * region->edges.size();
  }
  for (const Staircase& staircase : map.staircases)
    num_bytes += kStaircaseBytes + sizeof(std::int64_t) * staircase.region_ids.size();
  for (const PlaceView& view : views) num_bytes += kMinViewBytes + kCornerBytes * view.corners.size();
  return num_bytes;
}

}  // namespace

std::vector<std::uint8_t> TerraceFileBytes(const TerrainMap& map, const std::vector<PlaceView>& views) {
  ByteWriter out;
  out.Reserve(RoomFor(map, views));
  for (const char c : kMagic) out.Put(c);
  out.Put(views.empty() ? kWithoutViews : kWithViews);
  out.Put(std::uint32_t{0});
  out.Put(std::uint64_t{0});  // size and checksum, when they are known
  out.Put(std::uint64_t{0});
  out.Put(map.t_capture.ns);
  out.Put(map.seq);
  out.Put(map.map_id);
  out.Put(std::int32_t{map.epoch});
  PutPose(&out, map.T_world_left);
  out.PutDoubles(map.covariance.data(), 36);
  PutPose(&out, map.T_body_left.value_or(Eigen::Isometry3d::Identity()));
  out.Put(static_cast<std::int8_t>(map.T_body_left.has_value()));
  PutVector(&out, map.gravity.down_world);
  out.Put(map.gravity.sigma_rad);
  out.Put(static_cast<std::int8_t>(map.gravity.source));
  out.Put(static_cast<std::uint32_t>(map.staircases.size()));
  for (const Staircase& staircase : map.staircases) PutStaircase(&out, staircase);
  out.Put(static_cast<std::uint32_t>(map.regions.size()));
  for (const auto& region : map.regions) PutRegion(&out, *region);
  if (!views.empty()) {
    out.Put(static_cast<std::uint32_t>(views.size()));
    for (const PlaceView& view : views) PutView(&out, view);
  }
  out.PadToWords();
  const std::uint64_t size = out.bytes().size();
  std::memcpy(out.bytes().data() + kChecksumAt - sizeof(size), &size, sizeof(size));
  const std::uint64_t sum = Checksum(out.bytes());
  std::memcpy(out.bytes().data() + kChecksumAt, &sum, sizeof(sum));
  return std::move(out.bytes());
}

SavedMap FromTerraceFile(std::span<const std::uint8_t> bytes, const std::string& name) {
  ByteReader in(bytes, name);
  if (bytes.size() < kHeaderBytes) in.Fail("too short for a .terrace file");
  const std::uint32_t version = TakeHeader(&in, bytes);
  MapReader reader(&in);
  SavedMap saved;
  saved.map = std::make_shared<const TerrainMap>(reader.Map());
  if (version == kWithViews)
    for (std::size_t left = in.TakeCount(kMinViewBytes); left > 0; --left)
      saved.views.push_back(reader.View());
  if (in.left() >= 8) in.Fail("there is more behind the last item");
  return saved;
}

void SaveTerraceFile(const std::filesystem::path& path, const TerrainMap& map,
                     const std::vector<PlaceView>& views) {
  // Under another name until it is whole, so that no half file is ever there.
  const std::filesystem::path partial = path.string() + ".partial";
  std::error_code error;
  try {
    WriteFileBytes(partial, TerraceFileBytes(map, views));
  } catch (const FileError&) {
    std::filesystem::remove(partial, error);
    throw;
  }
  std::filesystem::rename(partial, path, error);
  if (!error) return;
  const std::string why = error.message();
  std::filesystem::remove(partial, error);
  throw FileError(path.string() + ": cannot be written: " + why);
}

SavedMap LoadTerraceFile(const std::filesystem::path& path) {
  return FromTerraceFile(ReadFileBytes(path, kMaxFileBytes), path.string());
}

}  // namespace terrace
