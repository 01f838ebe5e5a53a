// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <span>

#include "core/check.h"

namespace terrace {
namespace {

/// Names of the lens models in messages, by DistortionModel.
constexpr std::array kModelNames = {"pinhole-radtan",   "pinhole-equidistant", "omni",      "double-sphere",
                                    "extended-unified", "field-of-view",       "polynomial"};

bool AllFinite(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

bool AllFinite(std::span<const float> values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

/// The enum with this number, when it is one of the first `count`.
template <typename Enum>
std::optional<Enum> EnumFrom(int number, int count) {
  if (number < 0 || number >= count) return std::nullopt;
  return static_cast<Enum>(number);
}

template <typename Derived>
void Write(const Eigen::MatrixBase<Derived>& vector, double* out) {
  for (Eigen::Index i = 0; i < vector.size(); ++i) out[i] = vector[i];
}

Eigen::Vector3d Vector(const double* in) { return {in[0], in[1], in[2]}; }

void WriteQuaternion(const Eigen::Matrix3d& rotation, double* wxyz) {
  const Eigen::Quaterniond q = CanonicalQuaternion(rotation);
  wxyz[0] = q.w();
  wxyz[1] = q.x();
  wxyz[2] = q.y();
  wxyz[3] = q.z();
}

void WritePose(const Eigen::Isometry3d& pose, double* position, double* wxyz) {
  Write(pose.translation(), position);
  WriteQuaternion(pose.linear(), wxyz);
}

std::optional<Eigen::Isometry3d> ReadPose(const double* position, const double* wxyz) {
  // Others round their quaternions to a few digits; what is further from unit length is no rotation.
  constexpr double kMaxLengthError = 1e-2;
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!AllFinite({position, 3}) || !AllFinite({wxyz, 4}) || std::abs(q.norm() - 1.0) > kMaxLengthError) {
    return std::nullopt;
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = Vector(position);
  return CanonicalPose(pose);
}

/// "All zero" says that a pose is not known.
bool IsUnknownPose(const double* wxyz) {
  return std::all_of(wxyz, wxyz + 4, [](double v) { return v == 0.0; });
}

/// A number that changes when the bytes do (FNV-1a), in hexadecimal.
std::string ContentHash(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const std::uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3u;
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

void WriteCamera(const RawCamera& camera, std::size_t num_distortion, double* K,
                 std::vector<double>* distortion) {
  const double matrix[9] = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  std::copy(std::begin(matrix), std::end(matrix), K);
  *distortion = camera.distortion;
  distortion->resize(num_distortion, 0.0);
}

RawCamera ReadCamera(const double* K, DistortionModel model, const std::vector<double>& distortion) {
  return {K[0], K[4], K[2], K[5], model, distortion};
}

constexpr std::int64_t kMaxNanoseconds = std::int64_t{1} << 62;

}  // namespace

std::optional<Timestamp> TimeFromNanoseconds(std::int64_t ns) {
  if (ns < 0 || ns > kMaxNanoseconds) return std::nullopt;
  return Timestamp{ns};
}

std::optional<Timestamp> TimeFromMicroseconds(std::int64_t utime) {
  if (utime < 0 || utime > kMaxNanoseconds / 1000) return std::nullopt;
  return Timestamp::FromMicroseconds(utime);
}

pose_t ToMessage(Timestamp t, const Eigen::Isometry3d& T_world_body) {
  pose_t message{};
  message.utime = t.utime();
  WritePose(T_world_body, message.pos, message.orientation);
  return message;
}

std::optional<Eigen::Isometry3d> FromMessage(const pose_t& message) {
  return ReadPose(message.pos, message.orientation);
}

pose_t ToPoseMessage(const PoseEstimate& pose, const Eigen::Isometry3d& T_body_left,
                     std::optional<Timestamp> t_prev) {
  const Eigen::Isometry3d T_left_body = T_body_left.inverse();
  pose_t message = ToMessage(pose.t_capture, pose.T_world_left * T_left_body);
  if (t_prev && *t_prev < pose.t_capture) {
    const double dt = Seconds(pose.t_capture - *t_prev);
    const Eigen::Isometry3d T_prev_body = T_body_left * pose.T_prev_left * T_left_body;
    const Eigen::AngleAxisd turn(T_prev_body.linear());
    Write(T_prev_body.linear().transpose() * T_prev_body.translation() / dt, message.vel);
    Write(turn.axis() * (turn.angle() / dt), message.rotation_rate);
  }
  return message;
}

update_t ToUpdateMessage(const PoseEstimate& pose, std::optional<Timestamp> t_prev) {
  update_t message{};
  message.timestamp = pose.t_capture.utime();
  message.prev_timestamp = t_prev.value_or(pose.t_capture).utime();
  WritePose(pose.T_prev_left, message.translation, message.rotation);
  for (int row = 0; row < 6; ++row) {
    for (int col = 0; col < 6; ++col) message.covariance[row][col] = pose.covariance_prev(row, col);
  }
  message.estimate_status = update_t::ESTIMATE_VALID;
  if (pose.status == TrackingStatus::kBridging)
    message.estimate_status = update_t::ESTIMATE_INSUFFICIENT_FEATURES;
  if (pose.status == TrackingStatus::kLost || !t_prev) message.estimate_status = update_t::NO_DATA;
  return message;
}

imu_v1_t ToMessage(const ImuSample& sample) {
  imu_v1_t message{};
  message.utime = sample.t.utime();
  message.t_ns = sample.t.ns;
  Write(sample.gyro, message.gyro);
  Write(sample.accel, message.accel);
  return message;
}

std::optional<ImuSample> FromMessage(const imu_v1_t& message) {
  const std::optional<Timestamp> t = TimeFromNanoseconds(message.t_ns);
  if (!t || !AllFinite(message.gyro) || !AllFinite(message.accel)) return std::nullopt;
  return ImuSample{*t, Vector(message.gyro), Vector(message.accel)};
}

body_prior_v1_t ToMessage(const BodyPrior& prior) {
  body_prior_v1_t message{};
  message.utime = prior.t.utime();
  message.t_ns = prior.t.ns;
  message.kind = static_cast<std::int8_t>(prior.kind);
  WritePose(prior.T_odom_body, message.pos, message.quat);
  for (int i = 0; i < 36; ++i) message.cov[i] = prior.covariance(i / 6, i % 6);
  return message;
}

std::optional<BodyPrior> FromMessage(const body_prior_v1_t& message) {
  const std::optional<Eigen::Isometry3d> T_odom_body = ReadPose(message.pos, message.quat);
  const std::optional<Timestamp> t = TimeFromNanoseconds(message.t_ns);
  if (!t || !T_odom_body || !AllFinite(message.cov)) return std::nullopt;
  if (message.kind != body_prior_v1_t::ATTITUDE && message.kind != body_prior_v1_t::LEG_ODOMETRY)
    return std::nullopt;
  BodyPrior prior;
  prior.t = *t;
  prior.kind = static_cast<PriorKind>(message.kind);
  prior.T_odom_body = *T_odom_body;
  for (int i = 0; i < 36; ++i) prior.covariance(i / 6, i % 6) = message.cov[i];
  return prior;
}

std::optional<BodyPrior> PriorFromPose(const pose_t& message, PriorKind kind) {
  const std::optional<Eigen::Isometry3d> T_odom_body = FromMessage(message);
  const std::optional<Timestamp> t = TimeFromMicroseconds(message.utime);
  if (!t || !T_odom_body) return std::nullopt;
  return BodyPrior{*t, kind, *T_odom_body, Matrix6d::Zero()};
}

calibration_v1_t ToMessage(const StereoCalibration& calibration, Timestamp t) {
  TERRACE_CHECK(calibration.left.model == calibration.right.model);
  calibration_v1_t message{};
  message.width = calibration.width;
  message.height = calibration.height;
  message.rectified = calibration.rectified();
  const std::size_t num_distortion =
      std::max(calibration.left.distortion.size(), calibration.right.distortion.size());
  message.n_dist = static_cast<std::int32_t>(num_distortion);
  message.dist.resize(2);
  WriteCamera(calibration.left, num_distortion, message.K[0], &message.dist[0]);
  WriteCamera(calibration.right, num_distortion, message.K[1], &message.dist[1]);
  message.model = kModelNames.at(static_cast<std::size_t>(calibration.left.model));
  for (int i = 0; i < 9; ++i) message.R_right_left[i] = calibration.T_rawright_rawleft.linear()(i / 3, i % 3);
  Write(calibration.T_rawright_rawleft.translation(), message.t_right_left);
  if (calibration.T_body_rawleft) {
    WritePose(*calibration.T_body_rawleft, message.body_from_left_pos, message.body_from_left_quat);
  }
  if (calibration.T_body_imu) {
    WritePose(*calibration.T_body_imu, message.body_from_imu_pos, message.body_from_imu_quat);
  }
  message.imu_noise[0] = calibration.imu_noise.gyro_density;
  message.imu_noise[1] = calibration.imu_noise.gyro_walk;
  message.imu_noise[2] = calibration.imu_noise.accel_density;
  message.imu_noise[3] = calibration.imu_noise.accel_walk;

  std::vector<std::uint8_t> content(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(content.data(), 0, static_cast<int>(content.size()));
  message.content_hash = ContentHash(content);
  message.utime = t.utime();
  message.name = calibration.name;
  return message;
}

std::optional<StereoCalibration> FromMessage(const calibration_v1_t& message) {
  StereoCalibration calibration;
  const auto name = std::find(kModelNames.begin(), kModelNames.end(), message.model);
  if (name == kModelNames.end()) return std::nullopt;
  const auto model = static_cast<DistortionModel>(name - kModelNames.begin());
  calibration.name = message.name;
  calibration.width = message.width;
  calibration.height = message.height;
  calibration.left = ReadCamera(message.K[0], model, message.dist[0]);
  calibration.right = ReadCamera(message.K[1], model, message.dist[1]);
  for (int i = 0; i < 9; ++i) calibration.T_rawright_rawleft.linear()(i / 3, i % 3) = message.R_right_left[i];
  calibration.T_rawright_rawleft.translation() = Vector(message.t_right_left);
  if (!IsUnknownPose(message.body_from_left_quat)) {
    calibration.T_body_rawleft = ReadPose(message.body_from_left_pos, message.body_from_left_quat);
    if (!calibration.T_body_rawleft) return std::nullopt;
  }
  if (!IsUnknownPose(message.body_from_imu_quat)) {
    calibration.T_body_imu = ReadPose(message.body_from_imu_pos, message.body_from_imu_quat);
    if (!calibration.T_body_imu) return std::nullopt;
  }
  if (!AllFinite(message.imu_noise)) return std::nullopt;
  calibration.imu_noise = {message.imu_noise[0], message.imu_noise[1], message.imu_noise[2],
                           message.imu_noise[3]};
  return calibration;
}

status_v1_t ToMessage(const Status& status) {
  const auto small = [](double v) { return static_cast<float>(v); };
  status_v1_t message{};
  message.utime = status.t.utime();
  message.seq = status.seq;
  message.version = status.version;
  message.config_hash = status.config_hash;
  message.uptime_ms = status.uptime_ms;
  message.state = static_cast<std::int8_t>(status.state);
  message.source = static_cast<std::int8_t>(status.source);
  message.tracking = static_cast<std::int8_t>(status.tracking);
  message.gravity_source = static_cast<std::int8_t>(status.gravity_source);
  message.window_s = small(status.window_s);
  message.reason = status.reason;
  message.fps_in = small(status.fps_in);
  message.fps_out = small(status.fps_out);
  message.age_p50_ms = small(status.age_p50_ms);
  message.age_p99_ms = small(status.age_p99_ms);
  message.age_max_ms = small(status.age_max_ms);
  message.n_deadline_missed = status.num_deadline_missed;
  message.n_bad_frames = status.num_bad_frames;
  message.n_time_jumps = status.num_time_jumps;
  message.n_decode_errors = status.num_decode_errors;
  message.n_imu_gaps = status.num_imu_gaps;
  message.n_lost = status.num_lost;
  message.vo_matches = status.num_matches;
  message.vo_inliers = status.num_inliers;
  message.vo_rms_px = small(status.rms_px);
  message.dense_ratio = small(status.dense_ratio);
  message.vertical_disparity_px = small(status.vertical_disparity_px);
  message.octree_nodes = status.num_octree_nodes;
  message.n_regions = status.num_regions;
  message.map_bytes = status.map_bytes;
  message.rss_bytes = status.rss_bytes;
  message.cpu = small(status.cpu);
  message.n_stages = static_cast<std::int32_t>(status.stages.size());
  for (const StageStatus& stage : status.stages) {
    stage_stat_v1_t stat{};
    stat.name = stage.name;
    stat.n_in = stage.num_in;
    stat.n_out = stage.num_out;
    stat.n_dropped = stage.num_dropped;
    stat.queue_depth = stage.queue_depth;
    stat.ms_last = small(stage.last_ms);
    stat.ms_p50 = small(stage.p50_ms);
    stat.ms_p99 = small(stage.p99_ms);
    stat.ms_max = small(stage.max_ms);
    message.stages.push_back(std::move(stat));
  }
  return message;
}

std::optional<Status> FromMessage(const status_v1_t& message) {
  const auto state = EnumFrom<DaemonState>(message.state, 7);
  const auto source = EnumFrom<InputSource>(message.source, 2);
  const auto tracking = EnumFrom<TrackingStatus>(message.tracking, 3);
  const auto gravity_source = EnumFrom<GravitySource>(message.gravity_source, 5);
  const auto t = TimeFromMicroseconds(message.utime);
  if (!state || !source || !tracking || !gravity_source || !t) return std::nullopt;
  Status status;
  status.t = *t;
  status.seq = message.seq;
  status.version = message.version;
  status.config_hash = message.config_hash;
  status.uptime_ms = message.uptime_ms;
  status.state = *state;
  status.source = *source;
  status.tracking = *tracking;
  status.gravity_source = *gravity_source;
  status.window_s = message.window_s;
  status.reason = message.reason;
  status.fps_in = message.fps_in;
  status.fps_out = message.fps_out;
  status.age_p50_ms = message.age_p50_ms;
  status.age_p99_ms = message.age_p99_ms;
  status.age_max_ms = message.age_max_ms;
  status.num_deadline_missed = message.n_deadline_missed;
  status.num_bad_frames = message.n_bad_frames;
  status.num_time_jumps = message.n_time_jumps;
  status.num_decode_errors = message.n_decode_errors;
  status.num_imu_gaps = message.n_imu_gaps;
  status.num_lost = message.n_lost;
  status.num_matches = message.vo_matches;
  status.num_inliers = message.vo_inliers;
  status.rms_px = message.vo_rms_px;
  status.dense_ratio = message.dense_ratio;
  status.vertical_disparity_px = message.vertical_disparity_px;
  status.num_octree_nodes = message.octree_nodes;
  status.num_regions = message.n_regions;
  status.map_bytes = message.map_bytes;
  status.rss_bytes = message.rss_bytes;
  status.cpu = message.cpu;
  for (const stage_stat_v1_t& stat : message.stages) {
    status.stages.push_back({stat.name, stat.n_in, stat.n_out, stat.n_dropped, stat.queue_depth, stat.ms_last,
                             stat.ms_p50, stat.ms_p99, stat.ms_max});
  }
  return status;
}

region_v1_t ToMessage(const TerrainRegion& region, const Gravity& gravity) {
  region_v1_t message{};
  message.id = region.id;
  message.revision = region.revision;
  message.predicted = region.predicted();
  message.first_utime = region.first_seen.utime();
  message.last_utime = region.last_seen.utime();
  message.n_obs = region.num_observations;

  const Eigen::Vector3d& normal = region.plane_world.normal;
  const PlaneAxes axes = AxesOf(normal);
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : region.outline_world) origin += p;
  if (!region.outline_world.empty()) origin /= static_cast<double>(region.outline_world.size());
  origin = region.plane_world.Project(origin);
  Write(origin, message.origin);
  Eigen::Matrix3d R_world_plane;
  R_world_plane << axes.x, axes.y, normal;
  WriteQuaternion(R_world_plane, message.quat);
  int next = 0;
  for (int row = 0; row < 3; ++row) {
    for (int col = row; col < 3; ++col) {
      message.plane_cov[next++] = static_cast<float>(region.plane_covariance(row, col));
    }
  }

  const auto add_ring = [&](const Ring& ring) {
    message.ring_size.push_back(static_cast<std::int32_t>(ring.size()));
    for (const Eigen::Vector3d& p : ring) {
      message.coords.push_back(static_cast<float>(axes.x.dot(p - origin)));
      message.coords.push_back(static_cast<float>(axes.y.dot(p - origin)));
    }
  };
  add_ring(region.outline_world);
  for (const Ring& hole : region.holes_world) add_ring(hole);
  message.n_rings = static_cast<std::int32_t>(message.ring_size.size());
  message.n_coords = static_cast<std::int32_t>(message.coords.size());
  message.n_vertices = message.n_coords / 2;
  for (const RegionEdge& edge : region.edges)
    message.edge_kind.push_back(static_cast<std::int8_t>(edge.kind));
  message.edge_kind.resize(static_cast<std::size_t>(message.n_vertices), region_v1_t::EDGE_LIMIT_OF_VIEW);

  message.area = static_cast<float>(region.area_m2);
  message.rms = static_cast<float>(region.rms_m);
  message.slope =
      static_cast<float>(std::acos(std::clamp(std::abs(normal.dot(gravity.up_world())), 0.0, 1.0)));
  message.support = static_cast<float>(region.support);
  message.label = static_cast<std::int8_t>(region.label);
  message.label_prob[message.label] = static_cast<float>(region.confidence);
  message.staircase_id = region.staircase_id.value_or(0);
  message.step_index = region.step_index.value_or(0);
  return message;
}

std::optional<TerrainRegion> FromMessage(const region_v1_t& message) {
  const auto label = EnumFrom<TerrainLabel>(message.label, kNumTerrainLabels);
  const auto T_world_plane = ReadPose(message.origin, message.quat);
  const auto first_seen = TimeFromMicroseconds(message.first_utime);
  const auto last_seen = TimeFromMicroseconds(message.last_utime);
  if (!label || !T_world_plane || !first_seen || !last_seen || message.id <= 0) return std::nullopt;
  if (!AllFinite(message.coords) || !AllFinite(message.plane_cov) || !AllFinite(message.label_prob)) {
    return std::nullopt;
  }
  if (message.n_rings < 1 || message.n_coords % 2 != 0 || message.n_vertices != message.n_coords / 2) {
    return std::nullopt;
  }

  TerrainRegion region;
  region.id = message.id;
  region.revision = message.revision;
  region.label = *label;
  region.confidence = message.label_prob[message.label];
  region.plane_world.normal = T_world_plane->linear().col(2);
  region.plane_world.offset_m = region.plane_world.normal.dot(T_world_plane->translation());
  int next = 0;
  for (int row = 0; row < 3; ++row) {
    for (int col = row; col < 3; ++col) {
      region.plane_covariance(row, col) = region.plane_covariance(col, row) = message.plane_cov[next++];
    }
  }
  region.rms_m = message.rms;
  region.area_m2 = message.area;
  region.support = message.support;
  region.source = message.predicted != 0 ? RegionSource::kPredicted : RegionSource::kSeen;
  region.num_observations = message.n_obs;
  region.first_seen = *first_seen;
  region.last_seen = *last_seen;
  if (message.staircase_id != 0) region.staircase_id = message.staircase_id;
  if (message.step_index != 0) region.step_index = message.step_index;

  std::size_t vertex = 0;
  const std::size_t num_vertices = message.coords.size() / 2;
  for (const std::int32_t size : message.ring_size) {
    if (size < 3 || static_cast<std::size_t>(size) > num_vertices - vertex) return std::nullopt;
    Ring ring;
    for (std::int32_t i = 0; i < size; ++i, ++vertex) {
      ring.push_back(*T_world_plane *
                     Eigen::Vector3d(message.coords[2 * vertex], message.coords[2 * vertex + 1], 0.0));
    }
    if (region.outline_world.empty()) {
      region.outline_world = std::move(ring);
    } else {
      region.holes_world.push_back(std::move(ring));
    }
  }
  if (vertex != num_vertices) return std::nullopt;
  for (const std::int8_t number : message.edge_kind) {
    const auto kind = EnumFrom<EdgeKind>(number, 4);
    if (!kind) return std::nullopt;
    region.edges.push_back({*kind, {}, {}});
  }
  return region;
}

staircase_v1_t ToMessage(const Staircase& staircase) {
  staircase_v1_t message{};
  message.id = staircase.id;
  message.last_utime = staircase.last_seen.utime();
  message.n_risers = staircase.num_risers;
  message.n_treads = staircase.num_treads;
  message.riser = static_cast<float>(staircase.riser_m);
  message.riser_sigma = static_cast<float>(staircase.riser_sigma_m);
  message.tread = static_cast<float>(staircase.tread_m);
  message.tread_sigma = static_cast<float>(staircase.tread_sigma_m);
  message.width = static_cast<float>(staircase.width_m);
  for (int end = 0; end < 2; ++end) {
    Write(staircase.foot_edge_world[end], message.foot_edge + 3 * end);
    Write(staircase.head_edge_world[end], message.head_edge + 3 * end);
  }
  for (int i = 0; i < 3; ++i) message.direction_up[i] = static_cast<float>(staircase.direction_up_world[i]);
  message.turn_per_step = static_cast<float>(staircase.turn_per_step_rad);
  message.pitch = static_cast<float>(staircase.pitch_rad);
  message.confidence = static_cast<float>(staircase.confidence);
  message.n_region_ids = static_cast<std::int32_t>(staircase.region_ids.size());
  message.region_ids = staircase.region_ids;
  return message;
}

std::optional<Staircase> FromMessage(const staircase_v1_t& message) {
  const auto last_seen = TimeFromMicroseconds(message.last_utime);
  if (!last_seen || message.id <= 0 || message.n_risers < 0 || message.n_treads < 0 ||
      !AllFinite(message.foot_edge) || !AllFinite(message.head_edge) || !AllFinite(message.direction_up)) {
    return std::nullopt;
  }
  Staircase staircase;
  staircase.id = message.id;
  staircase.last_seen = *last_seen;
  staircase.num_risers = message.n_risers;
  staircase.num_treads = message.n_treads;
  staircase.riser_m = message.riser;
  staircase.riser_sigma_m = message.riser_sigma;
  staircase.tread_m = message.tread;
  staircase.tread_sigma_m = message.tread_sigma;
  staircase.width_m = message.width;
  for (int end = 0; end < 2; ++end) {
    staircase.foot_edge_world[end] = Vector(message.foot_edge + 3 * end);
    staircase.head_edge_world[end] = Vector(message.head_edge + 3 * end);
  }
  for (int i = 0; i < 3; ++i) staircase.direction_up_world[i] = message.direction_up[i];
  staircase.turn_per_step_rad = message.turn_per_step;
  staircase.pitch_rad = message.pitch;
  staircase.confidence = message.confidence;
  staircase.region_ids = message.region_ids;
  return staircase;
}

std::optional<TerrainView> FromMessage(const terrain_v1_t& message) {
  const auto t_capture = TimeFromMicroseconds(message.utime);
  const auto T_world_left = ReadPose(message.sensor_pos, message.sensor_quat);
  const Eigen::Vector3d down_world = Vector(message.gravity);
  constexpr double kMaxLengthError = 1e-3;
  if (!t_capture || !T_world_left || !(std::abs(down_world.norm() - 1.0) < kMaxLengthError))
    return std::nullopt;
  return TerrainView{*t_capture, *T_world_left, down_world};
}

namespace {

/// Fills parts one after the other, each up to its size.
class PartWriter {
 public:
  PartWriter(const TerrainMap& map, std::int8_t kind, std::int64_t base_seq, std::size_t max_bytes)
      : max_bytes_(max_bytes) {
    blank_.utime = map.t_capture.utime();
    blank_.seq = map.seq;
    blank_.map_id = map.map_id;
    blank_.frame_id = "world";
    WritePose(map.T_world_left, blank_.sensor_pos, blank_.sensor_quat);
    Write(map.gravity.down_world, blank_.gravity);
    blank_.kind = kind;
    blank_.base_seq = base_seq;
    parts_.push_back(blank_);
    for (const Staircase& staircase : map.staircases) parts_[0].staircases.push_back(ToMessage(staircase));
    parts_[0].n_staircases = static_cast<std::int32_t>(parts_[0].staircases.size());
    bytes_ = static_cast<std::size_t>(parts_[0].getEncodedSize());
  }

  void Remove(std::int64_t id) {
    terrain_v1_t& part = PartWithRoomFor(sizeof(id));
    part.removed_ids.push_back(id);
    ++part.n_removed;
  }

  void Add(region_v1_t region) {
    terrain_v1_t& part = PartWithRoomFor(static_cast<std::size_t>(region._getEncodedSizeNoHash()));
    part.regions.push_back(std::move(region));
    ++part.n_regions;
  }

  std::vector<terrain_v1_t> Finish() {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      parts_[i].part = static_cast<std::int32_t>(i);
      parts_[i].n_parts = static_cast<std::int32_t>(parts_.size());
    }
    return std::move(parts_);
  }

 private:
  terrain_v1_t& PartWithRoomFor(std::size_t bytes) {
    const bool empty =
        parts_.back().n_regions == 0 && parts_.back().n_removed == 0 && parts_.back().n_staircases == 0;
    if (bytes_ + bytes > max_bytes_ && !empty) {
      parts_.push_back(blank_);
      bytes_ = static_cast<std::size_t>(blank_.getEncodedSize());
    }
    bytes_ += bytes;
    return parts_.back();
  }

  std::size_t max_bytes_;
  terrain_v1_t blank_{};
  std::vector<terrain_v1_t> parts_;
  std::size_t bytes_ = 0;
};

}  // namespace

std::vector<terrain_v1_t> SnapshotMessages(const TerrainMap& map, std::size_t max_bytes) {
  PartWriter writer(map, terrain_v1_t::SNAPSHOT, 0, max_bytes);
  for (const auto& region : map.regions) writer.Add(ToMessage(*region, map.gravity));
  return writer.Finish();
}

std::vector<terrain_v1_t> DeltaMessages(const TerrainMap& base, const TerrainMap& map,
                                        std::size_t max_bytes) {
  TERRACE_CHECK(base.map_id == map.map_id, base.map_id, map.map_id);
  PartWriter writer(map, terrain_v1_t::DELTA, base.seq, max_bytes);
  std::map<std::int64_t, const TerrainRegion*> before;
  for (const auto& region : base.regions) before.emplace(region->id, region.get());
  std::vector<const TerrainRegion*> changed;
  for (const auto& region : map.regions) {
    const auto old = before.find(region->id);
    if (old == before.end() || old->second != region.get()) changed.push_back(region.get());
    if (old != before.end()) before.erase(old);
  }
  for (const auto& [id, region] : before) writer.Remove(id);
  for (const TerrainRegion* region : changed) writer.Add(ToMessage(*region, map.gravity));
  return writer.Finish();
}

}  // namespace terrace
