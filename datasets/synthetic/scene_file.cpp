// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/scene_file.h"

#include <map>
#include <set>

#include <yaml-cpp/yaml.h>

#include "core/file_bytes.h"
#include "datasets/synthetic/scene_builder.h"
#include "datasets/synthetic/scene_objects.h"
#include "datasets/synthetic/scene_section.h"

namespace terrace::synthetic {
namespace {

namespace fs = std::filesystem;

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
    SceneObjects objects(material_index_, &builder_);
    for (Section& object : root_.Children("objects")) objects.Read(object);
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
    s.Number("pitch_down_deg", &scene_.mounting.pitch_down_rad, -90.0, 90.0, kRadPerDegree);
    s.Number("roll_deg", &scene_.mounting.roll_rad, -180.0, 180.0, kRadPerDegree);
    s.Number("body_height_m", &scene_.mounting.body_height_m, 0.0, 10.0);
    s.Vector<3>("left_in_body_m", &scene_.mounting.left_in_body, -10.0, 10.0);
    constexpr double kMillisecond = 1e-3;
    s.Flag("right_below", &scene_.right.below);
    s.Number("right_roll_deg", &scene_.right.roll_rad, -10.0, 10.0, kRadPerDegree);
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
      entry.Number("softness_deg", &lamp.softness_rad, 0.0, 45.0, kRadPerDegree);
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
    s.Number("start_z_m", &plan.start_z, -kSceneReach_m, kSceneReach_m);
    s.Number("heading_deg", &plan.heading_rad, -360.0, 360.0, kRadPerDegree);
    s.Number("speed_mps", &plan.speed_mps, 0.01, 5.0);
    s.Number("creep_mps", &plan.creep_mps, 1e-5, 1.0);
    s.Number("turn_degps", &plan.turn_radps, 1.0, 180.0, kRadPerDegree);
    s.Number("hold_start_s", &plan.hold_start_s, 0.0, 1000.0);
    s.Number("hold_end_s", &plan.hold_end_s, 0.0, 1000.0);
    s.Number("gaze_deg", &plan.gaze_rad, 0.0, 45.0, kRadPerDegree);
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
