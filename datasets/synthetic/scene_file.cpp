// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/scene_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <yaml-cpp/yaml.h>

#include "core/file_bytes.h"
#include "datasets/synthetic/scene_builder.h"

namespace terrace::synthetic {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kFar_m = 1000.0;

/// One map of the file: reads its keys, remembers which were asked for, and collects what is wrong.
class Section {
 public:
  Section(YAML::Node node, std::string path, std::string file, std::vector<std::string>* problems)
      : node_(std::move(node)), path_(std::move(path)), file_(std::move(file)), problems_(problems) {
    if (node_.IsDefined() && !node_.IsNull() && !node_.IsMap()) {
      Say("", "must be a map");
      node_ = YAML::Node();
    }
  }

  bool Has(const std::string& key) {
    known_.insert(key);
    return node_.IsMap() && node_[key].IsDefined();
  }

  void Number(const std::string& key, double* value, double low, double high, double unit = 1.0) {
    if (!Has(key)) return;
    double read = 0.0;
    if (!Convert(node_[key], &read) || !(read >= low && read <= high)) {
      return Say(key,
                 "is " + Text(node_[key]) + ", must be a number from " + Short(low) + " to " + Short(high));
    }
    *value = read * unit;
  }

  template <typename Whole>
  void Count(const std::string& key, Whole* value, double low, double high) {
    double read = static_cast<double>(*value);
    if (!Has(key)) return;
    if (!Convert(node_[key], &read) || !(read >= low && read <= high) || read != std::floor(read)) {
      return Say(key, "is " + Text(node_[key]) + ", must be a whole number from " + Short(low) + " to " +
                          Short(high));
    }
    *value = static_cast<Whole>(read);
  }

  void Flag(const std::string& key, bool* value) {
    if (!Has(key)) return;
    try {
      *value = node_[key].as<bool>();
    } catch (const YAML::Exception&) {
      Say(key, "is " + Text(node_[key]) + ", must be true or false");
    }
  }

  void Word(const std::string& key, std::string* value) {
    if (!Has(key)) return;
    if (!node_[key].IsScalar()) return Say(key, "must be text");
    *value = node_[key].Scalar();
  }

  template <int kSize>
  void Vector(const std::string& key, Eigen::Matrix<double, kSize, 1>* value, double low = -kFar_m,
              double high = kFar_m) {
    if (!Has(key)) return;
    ReadVector(node_[key], key, value, low, high);
  }

  /// A list of vectors of two or three numbers.
  template <int kSize>
  std::vector<Eigen::Matrix<double, kSize, 1>> Vectors(const std::string& key) {
    std::vector<Eigen::Matrix<double, kSize, 1>> values;
    if (!Has(key)) return values;
    if (!node_[key].IsSequence()) {
      Say(key, "must be a list of points");
      return values;
    }
    for (std::size_t i = 0; i < node_[key].size(); ++i) {
      Eigen::Matrix<double, kSize, 1> value = Eigen::Matrix<double, kSize, 1>::Zero();
      ReadVector(node_[key][i], key + "[" + std::to_string(i) + "]", &value, -kFar_m, kFar_m);
      values.push_back(value);
    }
    return values;
  }

  Section Child(const std::string& key) {
    Has(key);
    return Section(node_.IsMap() ? node_[key] : YAML::Node(), PathOf(key), file_, problems_);
  }

  std::vector<Section> Children(const std::string& key) {
    std::vector<Section> children;
    if (!Has(key)) return children;
    if (!node_[key].IsSequence()) {
      Say(key, "must be a list");
      return children;
    }
    for (std::size_t i = 0; i < node_[key].size(); ++i) {
      children.emplace_back(node_[key][i], PathOf(key) + "[" + std::to_string(i) + "]", file_, problems_);
    }
    return children;
  }

  std::vector<std::string> Keys() const {
    std::vector<std::string> keys;
    if (!node_.IsMap()) return keys;
    for (const auto& entry : node_) keys.push_back(entry.first.as<std::string>());
    return keys;
  }

  void Require(const std::string& key) {
    if (!Has(key)) Say(key, "is missing");
  }

  void Say(const std::string& key, const std::string& what) {
    problems_->push_back(file_ + ": " + PathOf(key) + " " + what);
  }

  /// Whatever nobody asked for is a spelling mistake.
  void RefuseUnknownKeys() {
    for (const std::string& key : Keys()) {
      if (known_.count(key) == 0) Say(key, "is not a key that this place knows");
    }
  }

 private:
  template <int kSize>
  void ReadVector(const YAML::Node& node, const std::string& key, Eigen::Matrix<double, kSize, 1>* value,
                  double low, double high) {
    Eigen::Matrix<double, kSize, 1> read;
    bool good = node.IsSequence() && node.size() == kSize;
    for (int i = 0; good && i < kSize; ++i) {
      good = Convert(node[static_cast<std::size_t>(i)], &read[i]) && read[i] >= low && read[i] <= high;
    }
    if (!good) {
      return Say(key, "is " + Text(node) + ", must be " + std::to_string(kSize) + " numbers from " +
                          Short(low) + " to " + Short(high));
    }
    *value = read;
  }

  static bool Convert(const YAML::Node& node, double* value) {
    if (!node.IsScalar()) return false;
    try {
      *value = node.as<double>();
    } catch (const YAML::Exception&) {
      return false;
    }
    return std::isfinite(*value);
  }

  static std::string Text(const YAML::Node& node) {
    YAML::Emitter out;
    out << YAML::Flow << node;
    std::string text = out.c_str();
    constexpr std::size_t kLongest = 60;
    if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
    return "'" + text + "'";
  }

  static std::string Short(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
  }

  std::string PathOf(const std::string& key) const {
    if (key.empty()) return path_.empty() ? "the file" : path_;
    return path_.empty() ? key : path_ + "." + key;
  }

  YAML::Node node_;
  std::string path_;
  std::string file_;
  std::vector<std::string>* problems_;
  std::set<std::string> known_;
};

/// Labels that truth may carry.
void ReadLabel(Section& section, const std::string& key, std::string* label) {
  static const std::set<std::string> kLabels{"walkway", "ramp",     "stair_tread", "stair_riser",
                                             "wall",    "obstacle", "level",       "other"};
  std::string word = *label;
  section.Word(key, &word);
  if (word != *label && kLabels.count(word) == 0) {
    return section.Say(key, "is '" + word +
                                "', must be walkway, ramp, stair_tread, stair_riser, wall, obstacle, level "
                                "or other");
  }
  *label = word;
}

class SceneReader {
 public:
  SceneReader(const YAML::Node& root, const std::string& file, std::vector<std::string>* problems)
      : root_(root, "", file, problems), builder_(scene_) {}

  Scene Read() {
    root_.Word("name", &scene_.name);
    root_.Word("description", &scene_.description);
    root_.Count("seed", &scene_.seed, 0, 4294967295.0);
    root_.Number("rate_hz", &scene_.rate_hz, 0.1, 200.0);
    root_.Count("frames", &scene_.max_frames, 0, 100000);
    ReadCamera(root_.Child("camera"));
    ReadLight(root_.Child("light"));
    ReadPhotometry(root_.Child("photometry"));
    ReadMaterials(root_.Child("materials"));
    root_.Require("objects");
    for (Section& object : root_.Children("objects")) ReadObject(object);
    ReadMotion(root_.Child("motion"));
    root_.RefuseUnknownKeys();
    builder_.Finish();
    return std::move(scene_);
  }

 private:
  void ReadCamera(Section s) {
    StereoCamera& c = scene_.camera;
    s.Count("width", &c.width, 16, 4096);
    s.Count("height", &c.height, 16, 4096);
    c.cx = 0.5 * (c.width - 1);
    c.cy = 0.5 * (c.height - 1);
    s.Number("fx", &c.fx, 10.0, 20000.0);
    c.fy = c.fx;
    s.Number("fy", &c.fy, 10.0, 20000.0);
    s.Number("cx", &c.cx, 0.0, 4096.0);
    s.Number("cy", &c.cy, 0.0, 4096.0);
    s.Number("baseline_m", &c.baseline_m, 0.001, 10.0);
    s.Number("pitch_down_deg", &scene_.mounting.pitch_down_rad, -90.0, 90.0, kDegree);
    s.Number("roll_deg", &scene_.mounting.roll_rad, -180.0, 180.0, kDegree);
    s.Number("body_height_m", &scene_.mounting.body_height_m, 0.0, 10.0);
    s.Vector<3>("left_in_body_m", &scene_.mounting.left_in_body, -10.0, 10.0);
    constexpr double kMillisecond = 1e-3;
    s.Flag("right_below", &scene_.right.below);
    s.Number("right_roll_deg", &scene_.right.roll_rad, -10.0, 10.0, kDegree);
    s.Number("right_row_shift_px", &scene_.right.row_shift_px, -100.0, 100.0);
    s.Number("right_late_ms", &scene_.right.late_s, -1000.0, 1000.0, kMillisecond);
    s.RefuseUnknownKeys();
  }

  void ReadLight(Section s) {
    Lighting& light = scene_.lighting;
    s.Number("ambient", &light.ambient, 0.0, 100.0);
    s.Number("occlusion_reach_m", &light.occlusion_reach_m, 0.01, 100.0);
    s.Number("sky", &light.sky, 0.0, 100.0);
    s.Number("texel_m", &light.texel_m, 0.005, 1.0);
    s.Count("rays_per_texel", &light.rays_per_texel, 1, 1024);
    for (Section& entry : s.Children("lamps")) {
      Lamp lamp;
      std::string kind = "ceiling";
      entry.Word("kind", &kind);
      if (kind != "ceiling" && kind != "sun") entry.Say("kind", "is '" + kind + "', must be ceiling or sun");
      lamp.distant = kind == "sun";
      entry.Vector<3>("center_m", &lamp.center);
      entry.Vector<2>("size_m", &lamp.size_m, 0.01, 100.0);
      entry.Vector<3>("direction", &lamp.direction, -1.0, 1.0);
      if (lamp.distant && lamp.direction.norm() < 0.01) entry.Say("direction", "must not be zero");
      entry.Number("softness_deg", &lamp.softness_rad, 0.0, 45.0, kDegree);
      entry.Number("strength", &lamp.strength, 0.0, 1000.0);
      entry.RefuseUnknownKeys();
      light.lamps.push_back(lamp);
    }
    s.RefuseUnknownKeys();
  }

  void ReadPhotometry(Section s) {
    Photometry& p = scene_.photometry;
    s.Number("full_well", &p.full_well, 10.0, 1e9);
    s.Number("read_noise", &p.read_noise, 0.0, 1e6);
    s.Number("gain_right", &p.gain_right, 0.01, 100.0);
    s.Number("exposure_ms", &p.exposure_s, 0.0, 1000.0, 1e-3);
    s.Number("vignette", &p.vignette, 0.0, 0.95);
    s.Number("target", &p.target, 0.001, 1.0);
    s.Number("exposure_speed_hz", &p.exposure_speed_hz, 0.0, 1000.0);
    s.Number("black", &p.black, 0.0, 100.0);
    s.RefuseUnknownKeys();
  }

  void ReadMaterials(Section s) {
    for (const std::string& name : s.Keys()) {
      Section entry = s.Child(name);
      Material material;
      material.name = name;
      std::string pattern = Name(material.pattern);
      entry.Word("pattern", &pattern);
      if (const auto found = PatternFromName(pattern)) {
        material.pattern = *found;
      } else {
        std::string known;
        for (int i = 0; i < kNumPatterns; ++i)
          known += (i ? ", " : "") + std::string(Name(static_cast<Pattern>(i)));
        entry.Say("pattern", "is '" + pattern + "', must be one of " + known);
      }
      entry.Number("albedo", &material.albedo, 0.02, 0.95);
      entry.Number("contrast", &material.contrast, 0.0, 10.0);
      entry.Number("scale_m", &material.scale_m, 0.005, 10.0);
      entry.Number("mirror", &material.mirror, 0.0, 1.0);
      entry.Count("seed", &material.seed, 0, 4294967295.0);
      entry.RefuseUnknownKeys();
      material_index_[name] = static_cast<int>(scene_.materials.size());
      scene_.materials.push_back(material);
    }
    if (scene_.materials.empty()) {
      scene_.materials.push_back({});
      scene_.materials.back().name = "concrete";
      material_index_["concrete"] = 0;
    }
  }

  int ReadMaterial(Section& s, const std::string& key, int otherwise) {
    std::string name;
    s.Word(key, &name);
    if (name.empty()) return otherwise;
    const auto found = material_index_.find(name);
    if (found != material_index_.end()) return found->second;
    s.Say(key, "is '" + name + "', must be one of the file's materials");
    return otherwise;
  }

  BoxSpec ReadBox(Section& s) {
    BoxSpec spec;
    s.Word("name", &spec.name);
    s.Vector<3>("base_center_m", &spec.base_center);
    s.Vector<3>("size_m", &spec.size_m, 0.001, kFar_m);
    s.Number("yaw_deg", &spec.yaw_rad, -360.0, 360.0, kDegree);
    s.Number("tilt_deg", &spec.tilt_rad, -90.0, 90.0, kDegree);
    ReadLabel(s, "top_label", &spec.top_label);
    ReadLabel(s, "side_label", &spec.side_label);
    s.Flag("detail", &spec.detail);
    return spec;
  }

  void ReadObject(Section& s) {
    std::string kind;
    s.Word("kind", &kind);
    const int material = ReadMaterial(s, "material", 0);
    if (kind == "floor" || kind == "ceiling") {
      FloorSpec spec;
      spec.name = kind;
      spec.faces_down = kind == "ceiling";
      if (spec.faces_down) spec.label = "other";
      s.Word("name", &spec.name);
      s.Vector<2>("min_m", &spec.min);
      s.Vector<2>("max_m", &spec.max);
      if (!(spec.max.x() > spec.min.x() && spec.max.y() > spec.min.y()))
        s.Say("max_m", "must lie beyond min_m");
      s.Number("z_m", &spec.z_m, -kFar_m, kFar_m);
      ReadLabel(s, "label", &spec.label);
      builder_.AddFloor(spec, material);
    } else if (kind == "wall") {
      ReadWall(s, material);
    } else if (kind == "box") {
      builder_.AddBox(ReadBox(s), material);
    } else if (kind == "moving_box") {
      const BoxSpec spec = ReadBox(s);
      std::vector<MovingObject::Key> keys;
      for (Section& entry : s.Children("keys")) {
        MovingObject::Key key{0.0, Eigen::Vector3d::Zero()};
        entry.Number("t_s", &key.t_s, 0.0, 1e6);
        entry.Vector<3>("offset_m", &key.offset);
        if (!keys.empty() && key.t_s <= keys.back().t_s)
          entry.Say("t_s", "must be later than that of the key before");
        entry.RefuseUnknownKeys();
        keys.push_back(key);
      }
      builder_.AddMovingBox(spec, keys, material);
    } else if (kind == "quad") {
      ReadQuad(s, material);
    } else if (kind == "staircase") {
      ReadStaircase(s, material);
    } else if (kind == "spiral") {
      SpiralSpec spec;
      s.Word("name", &spec.name);
      s.Vector<3>("axis_foot_m", &spec.axis_foot);
      s.Number("inner_m", &spec.inner_m, 0.05, 20.0);
      s.Number("outer_m", &spec.outer_m, 0.1, 50.0);
      if (spec.outer_m <= spec.inner_m) s.Say("outer_m", "must be larger than inner_m");
      s.Count("risers", &spec.num_risers, 2, 100);
      s.Number("riser_m", &spec.riser_m, 0.01, 1.0);
      s.Number("start_deg", &spec.start_rad, -360.0, 360.0, kDegree);
      s.Number("turn_per_step_deg", &spec.turn_per_step_rad, -60.0, 60.0, kDegree);
      s.Number("landing_deg", &spec.landing_rad, 1.0, 120.0, kDegree);
      if (std::abs(spec.turn_per_step_rad) < kDegree)
        s.Say("turn_per_step_deg", "must be at least 1 either way");
      if ((spec.num_risers - 1) * std::abs(spec.turn_per_step_rad) + spec.landing_rad > 350.0 * kDegree) {
        s.Say("risers", "turn over themselves: steps and landing must stay within 350 degrees");
      }
      builder_.AddSpiral(spec, material, ReadMaterial(s, "riser_material", material));
    } else if (kind == "ramp") {
      RampSpec spec;
      s.Word("name", &spec.name);
      s.Vector<3>("foot_m", &spec.foot);
      s.Number("yaw_deg", &spec.yaw_rad, -360.0, 360.0, kDegree);
      s.Number("length_m", &spec.length_m, 0.05, 100.0);
      s.Number("rise_m", &spec.rise_m, 0.01, 20.0);
      s.Number("width_m", &spec.width_m, 0.05, 100.0);
      s.Number("landing_m", &spec.landing_m, 0.0, 100.0);
      builder_.AddRamp(spec, material);
    } else if (kind == "rubble") {
      RubbleSpec spec;
      s.Word("name", &spec.name);
      s.Vector<2>("min_m", &spec.min);
      s.Vector<2>("max_m", &spec.max);
      s.Number("z_m", &spec.z_m, -kFar_m, kFar_m);
      s.Count("count", &spec.count, 1, 2000);
      s.Number("min_size_m", &spec.min_size_m, 0.01, 5.0);
      s.Number("max_size_m", &spec.max_size_m, 0.01, 5.0);
      s.Number("max_height_m", &spec.max_height_m, 0.005, 5.0);
      s.Number("max_tilt_deg", &spec.max_tilt_rad, 0.0, 60.0, kDegree);
      s.Number("clear_m", &spec.clear_m, 0.0, 100.0);
      s.Count("seed", &spec.seed, 0, 4294967295.0);
      builder_.AddRubble(spec, material);
    } else {
      s.Say("kind",
            "is '" + kind +
                "', must be floor, ceiling, wall, box, moving_box, quad, staircase, spiral, ramp or rubble");
      return;
    }
    s.RefuseUnknownKeys();
  }

  void ReadWall(Section& s, int material) {
    WallSpec spec;
    s.Word("name", &spec.name);
    s.Vector<2>("from_m", &spec.from);
    s.Vector<2>("to_m", &spec.to);
    if ((spec.to - spec.from).norm() < 1e-3) s.Say("to_m", "must differ from from_m");
    s.Number("z_m", &spec.z_m, -kFar_m, kFar_m);
    s.Number("height_m", &spec.height_m, 0.01, 100.0);
    s.Number("thickness_m", &spec.thickness_m, 0.0, 10.0);
    ReadLabel(s, "label", &spec.label);
    const double length = (spec.to - spec.from).norm();
    for (Section& entry : s.Children("openings")) {
      WallSpec::Opening opening{0.0, 1.0, 0.0, 2.0};
      entry.Number("from_m", &opening.from_m, 0.0, length);
      entry.Number("to_m", &opening.to_m, 0.0, length);
      entry.Number("bottom_m", &opening.bottom_m, 0.0, spec.height_m);
      entry.Number("top_m", &opening.top_m, 0.0, spec.height_m);
      if (!(opening.from_m > 0.0 && opening.to_m > opening.from_m && opening.to_m < length)) {
        entry.Say("to_m", "must lie beyond from_m, both inside the wall");
      }
      if (!(opening.top_m > opening.bottom_m && opening.top_m < spec.height_m)) {
        entry.Say("top_m", "must lie between bottom_m and the wall's height");
      }
      entry.RefuseUnknownKeys();
      spec.openings.push_back(opening);
    }
    builder_.AddWall(spec, material);
  }

  void ReadQuad(Section& s, int material) {
    QuadSpec spec;
    s.Word("name", &spec.name);
    ReadLabel(s, "label", &spec.label);
    s.Flag("detail", &spec.detail);
    s.Require("corners_m");
    const std::vector<Eigen::Vector3d> corners = s.Vectors<3>("corners_m");
    if (corners.size() != 4) return s.Say("corners_m", "must be four points");
    std::copy(corners.begin(), corners.end(), spec.corners.begin());
    const Eigen::Vector3d normal = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
    if (normal.norm() < 1e-6 || std::abs(normal.normalized().dot(corners[1] - corners[0])) > 1e-4 ||
        std::abs(normal.normalized().dot(corners[2] - corners[0])) > 1e-4) {
      return s.Say("corners_m", "must lie in one plane within 0.1 mm");
    }
    builder_.AddQuad(spec, material);
  }

  void ReadStaircase(Section& s, int material) {
    StaircaseSpec spec;
    s.Word("name", &spec.name);
    s.Vector<3>("foot_m", &spec.foot);
    s.Number("yaw_deg", &spec.yaw_rad, -360.0, 360.0, kDegree);
    s.Count("risers", &spec.num_risers, 2, 100);
    s.Number("riser_m", &spec.riser_m, 0.01, 1.0);
    s.Number("tread_m", &spec.tread_m, 0.05, 5.0);
    s.Number("width_m", &spec.width_m, 0.1, 100.0);
    s.Number("nosing_m", &spec.nosing_m, 0.0, 0.2);
    s.Number("slab_m", &spec.slab_m, 0.005, 0.2);
    s.Flag("open_risers", &spec.open_risers);
    s.Flag("sides", &spec.sides);
    s.Number("landing_m", &spec.landing_m, 0.0, 100.0);
    if (spec.nosing_m >= spec.tread_m) s.Say("nosing_m", "must be smaller than tread_m");
    if (spec.slab_m >= spec.riser_m) s.Say("slab_m", "must be smaller than riser_m");
    builder_.AddStaircase(spec, material, ReadMaterial(s, "riser_material", material));
  }

  void ReadMotion(Section s) {
    MotionPlan& plan = scene_.motion;
    std::string kind = Name(plan.kind);
    s.Word("kind", &kind);
    if (const auto found = MotionKindFromName(kind)) {
      plan.kind = *found;
    } else {
      s.Say("kind", "is '" + kind + "', must be walk, stand, creep or turn_on_spot");
    }
    plan.path = s.Vectors<2>("path_m");
    if (plan.path.empty()) s.Say("path_m", "must hold at least the starting point");
    s.Number("start_z_m", &plan.start_z, -kFar_m, kFar_m);
    s.Number("heading_deg", &plan.heading_rad, -360.0, 360.0, kDegree);
    s.Number("speed_mps", &plan.speed_mps, 0.01, 5.0);
    s.Number("creep_mps", &plan.creep_mps, 1e-5, 1.0);
    s.Number("turn_degps", &plan.turn_radps, 1.0, 180.0, kDegree);
    s.Number("hold_start_s", &plan.hold_start_s, 0.0, 1000.0);
    s.Number("hold_end_s", &plan.hold_end_s, 0.0, 1000.0);
    s.Number("gaze_deg", &plan.gaze_rad, 0.0, 45.0, kDegree);
    s.Number("bounce", &plan.bounce, 0.0, 5.0);
    s.Number("duration_s", &plan.duration_s, 0.0, 3600.0);
    s.RefuseUnknownKeys();
  }

  Section root_;
  Scene scene_;
  SceneBuilder builder_;
  std::map<std::string, int> material_index_;
};

const std::vector<fs::path>& SceneFolders() {
  static const std::vector<fs::path> folders{TERRACE_SCENES_SOURCE_DIR, TERRACE_SCENES_INSTALL_DIR};
  return folders;
}

}  // namespace

Scene LoadScene(const fs::path& file) {
  constexpr std::uint64_t kMaxBytes = 4 << 20;
  YAML::Node root;
  try {
    root = YAML::Load(ReadTextFile(file, kMaxBytes));
  } catch (const FileError& error) {
    throw SceneError(error.what());
  } catch (const YAML::Exception& error) {
    throw SceneError(file.string() + ": not valid YAML: " + error.what());
  }
  if (!root.IsMap()) throw SceneError(file.string() + ": must be a YAML map");
  std::vector<std::string> problems;
  Scene scene = SceneReader(root, file.string(), &problems).Read();
  if (scene.name.empty()) scene.name = file.stem().string();
  if (!problems.empty()) {
    std::string text;
    for (const std::string& problem : problems) text += (text.empty() ? "" : "\n") + problem;
    throw SceneError(text);
  }
  return scene;
}

fs::path FindScene(const std::string& scene) {
  const bool is_name = scene.find('/') == std::string::npos;
  for (const fs::path& folder : SceneFolders()) {
    if (is_name && fs::is_regular_file(folder / (scene + ".yaml"))) return folder / (scene + ".yaml");
  }
  if (fs::is_regular_file(scene)) return scene;
  std::string known;
  for (const std::string& name : ShippedScenes()) known += (known.empty() ? "" : ", ") + name;
  throw SceneError("'" + scene + "' is neither a scene file nor one of the shipped scenes: " + known);
}

std::vector<std::string> ShippedScenes() {
  std::set<std::string> names;
  for (const fs::path& folder : SceneFolders()) {
    if (!fs::is_directory(folder)) continue;
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() == ".yaml") names.insert(entry.path().stem().string());
    }
  }
  return {names.begin(), names.end()};
}

}  // namespace terrace::synthetic
