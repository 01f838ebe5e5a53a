// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/euroc.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <yaml-cpp/yaml.h>

#include "core/file_bytes.h"
#include "core/lens_models.h"
#include "datasets/calibration_formats.h"
#include "datasets/folder_sequence.h"
#include "datasets/frame_times.h"
#include "datasets/ground_truth.h"
#include "datasets/text_table.h"
#include "datasets/yaml_value.h"

namespace terrace {
namespace {

namespace fs = std::filesystem;

using Problems = std::vector<std::string>;

// ---- sensor.yaml

/// One sensor.yaml; says every rule that a field breaks.
class SensorFile {
 public:
  SensorFile(const fs::path& path, Problems* problems) : path_(path.string()), problems_(problems) {
    constexpr std::uint64_t kMaxBytes = 1 << 20;
    std::string text;
    try {
      text = ReadTextFile(path, kMaxBytes);
    } catch (const FileError& error) {
      problems_->push_back(error.what());
      return;
    }
    // OpenCV's heading is no valid YAML directive.
    if (text.rfind("%YAML:", 0) == 0) text.erase(0, text.find('\n'));
    try {
      root_ = YAML::Load(text);
    } catch (const YAML::Exception& error) {
      Say(std::string("not valid YAML: ") + error.what());
      return;
    }
    readable_ = root_.IsMap();
    if (!readable_) Say("must be a YAML map");
    if (const std::string key = ContradictedKey(root_); !key.empty())
      Say("'" + key + "' comes twice, with different values");
  }

  bool readable() const { return readable_; }

  std::vector<double> Numbers(const std::string& key, std::size_t min_count, std::size_t max_count) {
    return NumbersOf(root_[key], key, min_count, max_count);
  }

  double NumberOr(const std::string& key, double otherwise) {
    if (!root_[key]) return otherwise;
    try {
      const double value = root_[key].as<double>();
      if (std::isfinite(value)) return value;
    } catch (const YAML::Exception&) {
    }
    Say(key + " must be a number");
    return otherwise;
  }

  std::string TextOr(const std::string& key, const std::string& otherwise) {
    const YAML::Node node = root_[key];
    if (!node) return otherwise;
    if (node.IsScalar()) return node.Scalar();
    Say(key + " must be a word");
    return otherwise;
  }

  /// T_body_sensor; 16 numbers by rows under T_BS: data.
  Eigen::Isometry3d BodyFromSensor() {
    const YAML::Node node = root_["T_BS"];
    const std::vector<double> data =
        NumbersOf(node && node.IsMap() ? node["data"] : node, "T_BS: data", 16, 16);
    if (data.size() != 16) return Eigen::Isometry3d::Identity();
    const Eigen::Matrix4d T = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(data.data());
    const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
    if (!(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0 ||
        !T.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-6)) {
      Say("T_BS must be a rotation and a translation");
      return Eigen::Isometry3d::Identity();
    }
    Eigen::Isometry3d T_body_sensor = Eigen::Isometry3d::Identity();
    T_body_sensor.linear() = R;
    T_body_sensor.translation() = T.topRightCorner<3, 1>();
    return CanonicalPose(T_body_sensor);
  }

  bool Has(const std::string& key) const { return root_[key].IsDefined(); }
  void Say(const std::string& what) { problems_->push_back(path_ + ": " + what); }

 private:
  std::vector<double> NumbersOf(const YAML::Node& node, const std::string& key, std::size_t min_count,
                                std::size_t max_count) {
    std::vector<double> values;
    bool good = node && node.IsSequence() && node.size() >= min_count && node.size() <= max_count;
    if (good) {
      try {
        for (const YAML::Node& item : node) values.push_back(item.as<double>());
      } catch (const YAML::Exception&) {
        good = false;
      }
      for (const double value : values) good = good && std::isfinite(value);
    }
    if (good) return values;
    Say(key + " must be a list of " + std::to_string(min_count) +
        (max_count > min_count ? " to " + std::to_string(max_count) : "") + " numbers");
    return {};
  }

  std::string path_;
  Problems* problems_;
  YAML::Node root_;
  bool readable_ = false;
};

struct CameraFile {
  RawCamera camera;
  int width = 0;
  int height = 0;
  Eigen::Isometry3d T_body_camera = Eigen::Isometry3d::Identity();
};

RawCamera ReadPinhole(SensorFile* file) {
  RawCamera camera;
  const std::vector<double> intrinsics = file->Numbers("intrinsics", 4, 4);
  if (intrinsics.size() == 4) {
    camera.fx = intrinsics[0];
    camera.fy = intrinsics[1];
    camera.cx = intrinsics[2];
    camera.cy = intrinsics[3];
  }
  const std::string distortion = file->TextOr("distortion_model", "none");
  const auto model = ModelOfAnyName(distortion);
  if (!model) {
    file->Say("distortion_model is " + distortion + ", must be radial-tangential, equidistant or none");
  } else if (distortion != "none") {
    camera.model = *model;
    const std::vector<std::size_t> counts = CoefficientCounts(*model);
    camera.distortion =
        file->Numbers("distortion_coefficients", std::max<std::size_t>(counts.front(), 1), counts.back());
  }
  return camera;
}

CameraFile ReadCameraFile(const fs::path& path, Problems* problems) {
  CameraFile out;
  SensorFile file(path, problems);
  if (!file.readable()) return out;
  const std::vector<double> resolution = file.Numbers("resolution", 2, 2);
  if (resolution.size() == 2) {
    const auto whole = [&](double side) {
      if (side >= 1 && side <= std::numeric_limits<int>::max() && side == std::floor(side)) {
        return static_cast<int>(side);
      }
      file.Say("resolution must be two whole numbers of pixels");
      return 0;
    };
    out.width = whole(resolution[0]);
    out.height = whole(resolution[1]);
  }
  const std::string camera_model = file.TextOr("camera_model", "pinhole");
  if (camera_model == "omni" && file.Has("omni_distortion_center")) {
    try {
      out.camera = *ReadEurocSensor(ParseYaml(ReadTextFile(path), path.string())).cameras.front().lens;
    } catch (const FileError& error) {
      problems->push_back(error.what());
    }
  } else {
    if (camera_model != "pinhole") file.Say("camera_model is " + camera_model + ", must be pinhole");
    out.camera = ReadPinhole(&file);
  }
  out.T_body_camera = file.BodyFromSensor();
  return out;
}

StereoCalibration ReadCalibration(const fs::path& mav, Problems* problems) {
  const fs::path left_path = mav / "cam0" / "sensor.yaml";
  const fs::path right_path = mav / "cam1" / "sensor.yaml";
  const std::size_t num_before = problems->size();
  const CameraFile left = ReadCameraFile(left_path, problems);
  const CameraFile right = ReadCameraFile(right_path, problems);
  StereoCalibration calibration;
  calibration.name = (mav / "cam0" / "sensor.yaml").string() + " with cam1/sensor.yaml";
  if (problems->size() > num_before) return calibration;
  calibration.width = left.width;
  calibration.height = left.height;
  calibration.left = left.camera;
  calibration.right = right.camera;
  calibration.T_rawright_rawleft = right.T_body_camera.inverse() * left.T_body_camera;
  calibration.T_body_rawleft = left.T_body_camera;
  if (right.width != left.width || right.height != left.height) {
    problems->push_back(right_path.string() + ": resolution differs from that of cam0, must be the same");
  }
  const Problems senseless = calibration.Problems();
  problems->insert(problems->end(), senseless.begin(), senseless.end());
  return calibration;
}

// ---- images

struct ImageRow {
  Timestamp t;
  std::string file;
};

Table<ImageRow> ReadImageRows(const fs::path& camera) {
  const fs::path csv = camera / "data.csv";
  const auto parse = [](std::span<const std::string_view> cells) -> std::optional<ImageRow> {
    const std::optional<Timestamp> t = cells.empty() ? std::nullopt : ParseNanoseconds(cells[0]);
    if (!t || (cells.size() > 1 && cells[1].empty())) return std::nullopt;
    return ImageRow{*t, cells.size() > 1 ? std::string(cells[1]) : std::to_string(t->ns) + ".png"};
  };
  Table<ImageRow> table = ReadTable<ImageRow>(csv, ',', "a time stamp [ns] and a file name", parse);
  return table;
}

std::vector<Timestamp> TimesOf(const std::vector<ImageRow>& rows) {
  std::vector<Timestamp> times;
  for (const ImageRow& row : rows) times.push_back(row.t);
  return times;
}

/// Every image of either camera once, in order of time.
std::vector<FolderFrame> PairUp(const fs::path& mav, const std::vector<ImageRow>& left,
                                const std::vector<ImageRow>& right) {
  const auto missing = [](const char* side, Timestamp t) {
    return "no " + std::string(side) + " image within 0.5 ms of time stamp " + std::to_string(t.ns);
  };
  std::vector<FolderFrame> frames;
  std::size_t l = 0, r = 0;
  while (l < left.size() || r < right.size()) {
    FolderFrame frame;
    const bool pair = l < left.size() && r < right.size() && left[l].t - right[r].t <= kMaxPairOffset &&
                      right[r].t - left[l].t <= kMaxPairOffset;
    const bool take_left = pair || r == right.size() || (l < left.size() && left[l].t < right[r].t);
    const bool take_right = pair || !take_left;
    frame.t_capture = take_left ? left[l].t : right[r].t;
    if (!take_right)
      frame.problem = (mav / "cam1" / "data.csv").string() + ": " + missing("right", frame.t_capture);
    if (!take_left)
      frame.problem = (mav / "cam0" / "data.csv").string() + ": " + missing("left", frame.t_capture);
    if (take_left) frame.left = mav / "cam0" / "data" / left[l++].file;
    if (take_right) frame.right = mav / "cam1" / "data" / right[r++].file;
    frames.push_back(std::move(frame));
  }
  return frames;
}

// ---- samples

/// Rows of a sensor that a sequence can do without: what is wrong with the file becomes a warning.
template <typename Row, typename Parse>
std::vector<Row> ReadOptionalSensor(const fs::path& csv, const std::string& rule, Parse parse,
                                    const std::vector<ClockOffset>& clock, Problems* warnings) {
  Table<Row> table = ReadTable<Row>(csv, ',', rule, parse);
  CountOn(clock, &table.rows);
  SortByTime(csv, "sample", &table);
  if (!table.problem.empty()) warnings->push_back(table.problem + "; it is not used");
  warnings->insert(warnings->end(), table.warnings.begin(), table.warnings.end());
  return std::move(table.rows);
}

std::vector<ImuSample> ReadImu(const fs::path& csv, const std::vector<ClockOffset>& clock,
                               Problems* warnings) {
  const auto parse = [](std::span<const std::string_view> cells) -> std::optional<ImuSample> {
    const std::optional<Timestamp> t = cells.empty() ? std::nullopt : ParseNanoseconds(cells[0]);
    const auto v = ParseDoubles(cells, 1, 6);
    if (!t || !v) return std::nullopt;
    return ImuSample{*t, {(*v)[0], (*v)[1], (*v)[2]}, {(*v)[3], (*v)[4], (*v)[5]}};
  };
  return ReadOptionalSensor<ImuSample>(csv, "a time stamp [ns], 3 rates of turn and 3 accelerations", parse,
                                       clock, warnings);
}

std::vector<BodyPrior> ReadPriors(const fs::path& csv, PriorKind kind, const std::vector<ClockOffset>& clock,
                                  Problems* warnings) {
  const auto parse = [kind](std::span<const std::string_view> cells) -> std::optional<BodyPrior> {
    const std::optional<Timestamp> t = cells.empty() ? std::nullopt : ParseNanoseconds(cells[0]);
    const auto v = ParseDoubles(cells, 1, 13);
    if (!t || !v) return std::nullopt;
    const Eigen::Quaterniond q((*v)[3], (*v)[4], (*v)[5], (*v)[6]);
    const Vector6d sigma = Eigen::Map<const Vector6d>(v->data() + 7);
    if (std::abs(q.norm() - 1.0) > 0.01 || (sigma.array() < 0).any()) return std::nullopt;
    BodyPrior prior{*t, kind};
    prior.T_odom_body.linear() = q.normalized().toRotationMatrix();
    prior.T_odom_body.translation() = Eigen::Map<const Eigen::Vector3d>(v->data());
    prior.T_odom_body = CanonicalPose(prior.T_odom_body);
    prior.covariance.diagonal() = sigma.array().square();
    return prior;
  };
  return ReadOptionalSensor<BodyPrior>(
      csv, "a time stamp [ns], position, quaternion w x y z and 6 standard deviations", parse, clock,
      warnings);
}

/// Body axes and noise of the IMU; without them its samples mean nothing.
bool ReadImuCalibration(const fs::path& path, StereoCalibration* calibration, Problems* warnings) {
  Problems problems;
  SensorFile file(path, &problems);
  if (file.readable()) {
    const Eigen::Isometry3d T_body_imu = file.BodyFromSensor();
    calibration->imu_noise = {
        file.NumberOr("gyroscope_noise_density", 0), file.NumberOr("gyroscope_random_walk", 0),
        file.NumberOr("accelerometer_noise_density", 0), file.NumberOr("accelerometer_random_walk", 0)};
    if (problems.empty()) calibration->T_body_imu = T_body_imu;
  }
  for (const std::string& problem : problems) warnings->push_back(problem + "; the IMU is not used");
  return problems.empty();
}

SensorSamples ReadSamples(const fs::path& mav, const std::vector<ClockOffset>& clock, SequenceInfo* info) {
  SensorSamples samples;
  if (fs::exists(mav / "imu0")) {
    if (ReadImuCalibration(mav / "imu0" / "sensor.yaml", &info->calibration, &info->warnings)) {
      samples.imu = ReadImu(mav / "imu0" / "data.csv", clock, &info->warnings);
    }
    info->has_imu = !samples.imu.empty();
  }
  if (fs::exists(mav / "attitude0")) {
    samples.priors = ReadPriors(mav / "attitude0" / "data.csv", PriorKind::kAttitude, clock, &info->warnings);
    info->has_attitude = !samples.priors.empty();
  }
  if (fs::exists(mav / "legs0")) {
    const std::vector<BodyPrior> legs =
        ReadPriors(mav / "legs0" / "data.csv", PriorKind::kLegOdometry, clock, &info->warnings);
    info->has_legs = !legs.empty();
    samples.priors.insert(samples.priors.end(), legs.begin(), legs.end());
    std::stable_sort(samples.priors.begin(), samples.priors.end(),
                     [](const BodyPrior& a, const BodyPrior& b) { return a.t < b.t; });
  }
  return samples;
}

}  // namespace

StereoCalibration ReadEurocCalibration(const fs::path& path) {
  const fs::path mav = path / "mav0";
  Problems problems;
  StereoCalibration calibration = ReadCalibration(mav, &problems);
  if (fs::exists(mav / "imu0" / "sensor.yaml")) {
    ReadImuCalibration(mav / "imu0" / "sensor.yaml", &calibration, &problems);
  }
  ThrowIfAny(problems);
  return calibration;
}

std::unique_ptr<Sequence> OpenEurocSequence(const fs::path& path) {
  const fs::path mav = path / "mav0";
  Problems problems;
  SequenceInfo info;
  info.kind = SequenceKind::kEuroc;
  info.path = path;
  info.calibration = ReadCalibration(mav, &problems);
  Table<ImageRow> left = ReadImageRows(mav / "cam0");
  Table<ImageRow> right = ReadImageRows(mav / "cam1");
  const std::vector<ClockOffset> clock = OffsetsThatCountOn(TimesOf(left.rows));
  CountOn(clock, &left.rows);
  CountOn(clock, &right.rows);
  SortByTime(mav / "cam0" / "data.csv", "image", &left);
  SortByTime(mav / "cam1" / "data.csv", "image", &right);
  if (const auto sentence = SentenceAbout(clock))
    info.warnings.push_back((mav / "cam0" / "data.csv").string() + ": " + *sentence);
  for (const Table<ImageRow>* side : {&left, &right}) {
    if (!side->problem.empty()) problems.push_back(side->problem);
    info.warnings.insert(info.warnings.end(), side->warnings.begin(), side->warnings.end());
  }
  ThrowIfAny(problems);

  std::vector<FolderFrame> frames = PairUp(mav, left.rows, right.rows);
  const bool any_pair =
      std::any_of(frames.begin(), frames.end(), [](const FolderFrame& f) { return f.problem.empty(); });
  if (!any_pair) {
    ThrowIfAny({mav.string() + ": no two time stamps of cam0/data.csv and cam1/data.csv lie within 0.5 ms"});
  }
  SensorSamples samples = ReadSamples(mav, clock, &info);
  info.has_true_poses = HasTrueTrajectory(path);
  return std::make_unique<FolderSequence>(std::move(info), std::move(frames), std::move(samples),
                                          left.num_time_jumps + right.num_time_jumps);
}

}  // namespace terrace
