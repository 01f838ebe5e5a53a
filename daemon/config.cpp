// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <set>
#include <type_traits>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "lcmtypes/default_url.h"

namespace terrace {
namespace {

// VisitFields() of every config struct, written by config_fields.py from the headers.
#include "config_fields.inc"

const char* TypeName(bool) { return "true or false"; }
const char* TypeName(int) { return "a whole number"; }
const char* TypeName(double) { return "a number"; }
const char* TypeName(const std::string&) { return "text"; }
const char* TypeName(const std::optional<int>&) { return "a whole number or auto"; }
const char* TypeName(const std::optional<double>&) { return "a number or null"; }
const char* TypeName(const std::vector<double>&) { return "a list of numbers"; }

std::string Print(bool value) { return value ? "true" : "false"; }
std::string Print(int value) { return std::to_string(value); }
std::string Print(double value) {
  // The shortest text that reads back as the same number.
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}
std::string Print(const std::string& value) {
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

std::string Print(const std::optional<int>& value) { return value ? Print(*value) : "auto"; }
std::string Print(const std::optional<double>& value) { return value ? Print(*value) : "null"; }
std::string Print(const std::vector<double>& values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + Print(value);
  return text + "]";
}

/// Takes a value of the file; false: it is none of this type.
template <typename T>
bool Take(const YAML::Node& node, T* field) {
  T value{};
  if (!node.IsScalar() || !YAML::convert<T>::decode(node, value)) return false;
  // A number that is not one can only come from a mistake.
  if constexpr (std::is_same_v<T, double>) {
    if (!std::isfinite(value)) return false;
  }
  *field = value;
  return true;
}
bool Take(const YAML::Node& node, std::optional<int>* field) {
  if (node.IsScalar() && node.Scalar() == "auto") {
    field->reset();
    return true;
  }
  int value = 0;
  if (!Take(node, &value)) return false;
  *field = value;
  return true;
}
bool Take(const YAML::Node& node, std::optional<double>* field) {
  if (node.IsNull() || (node.IsScalar() && node.Scalar().empty())) {
    field->reset();
    return true;
  }
  double value = 0.0;
  if (!Take(node, &value)) return false;
  *field = value;
  return true;
}
bool Take(const YAML::Node& node, std::vector<double>* field) {
  if (!node.IsSequence()) return false;
  std::vector<double> values;
  for (const YAML::Node& item : node) {
    values.push_back(0.0);
    if (!Take(item, &values.back())) return false;
  }
  *field = values;
  return true;
}

/// One key of the file, bound to its field.
struct Key {
  std::string section;
  std::string name;
  std::string comment;
  std::function<std::string()> print;
  /// Takes the value; false: it has the wrong type, named by `type`.
  std::function<bool(const YAML::Node&)> set;
  const char* type;
};

/// All keys, and what each section's settings say about themselves.
class Binding {
 public:
  explicit Binding(Config* config) {
    PipelineConfig& p = config->pipeline;
    Bind("pipeline", &p.flow);
    Bind("camera", &p.image_scale);
    Bind("camera.mounting", &p.mounting);
    Bind("stereo", &p.rectifier);
    Bind("stereo", &p.stereo);
    Bind("odometry", &p.odometry);
    // One section for both: a user limits the range of the map, wherever that happens.
    Bind("mapping", &p.terrain.cloud);
    Bind("mapping", &p.terrain.mapping);
    Bind("modelling", &p.terrain.modelling);
    Bind("merging", &p.terrain.merging);
    Bind("labeling", &p.terrain.labeling);
    Bind("staircases", &p.terrain.staircases);
    Bind("robot", &p.terrain.robot);
    Bind("robot", &p.self_mask);
    Bind("lcm", &config->live);
    Bind("channels", &config->channels);
  }

  const std::vector<Key>& keys() const { return keys_; }

  const Key* Find(const std::string& section, const std::string& name) const {
    for (const Key& key : keys_) {
      if (key.section == section && key.name == name) return &key;
    }
    return nullptr;
  }

  bool HasSection(const std::string& section) const {
    for (const Key& key : keys_) {
      if (key.section == section || key.section.rfind(section + ".", 0) == 0) return true;
    }
    return false;
  }

  /// What the settings themselves find wrong, by section: sentences that start with the key.
  std::vector<std::pair<std::string, std::string>> Problems() const {
    std::vector<std::pair<std::string, std::string>> all;
    for (const auto& [section, problems] : checks_) {
      for (const std::string& problem : problems()) all.emplace_back(section, problem);
    }
    return all;
  }

 private:
  template <typename Settings>
  void Bind(const std::string& section, Settings* settings) {
    checks_.emplace_back(section, [settings] { return settings->Problems(); });
    VisitFields(*settings, [&](const char* name, auto& field, const char* comment) {
      keys_.push_back({section, name, comment, [&field] { return Print(field); },
                       [&field](const YAML::Node& node) { return Take(node, &field); }, TypeName(field)});
    });
  }

  std::vector<Key> keys_;
  std::vector<std::pair<std::string, std::function<std::vector<std::string>()>>> checks_;
};

/// Collects problems, and remembers where each key was last set.
class Loader {
 public:
  explicit Loader(Config* config) : binding_(config) {}

  void ReadFile(const std::filesystem::path& file) {
    YAML::Node root;
    try {
      if (std::filesystem::is_directory(file)) throw YAML::BadFile(file.string());
      root = YAML::LoadFile(file.string());
    } catch (const YAML::BadFile&) {
      problems_.push_back(file.string() + ": cannot be read");
      return;
    } catch (const YAML::Exception& error) {
      problems_.push_back(file.string() + ":" + std::to_string(error.mark.line + 1) +
                          ": is not YAML: " + error.msg);
      return;
    }
    if (root.IsNull()) return;
    if (!root.IsMap()) {
      problems_.push_back(file.string() + ": must hold sections, each with its keys");
      return;
    }
    SayWhatComesTwice(file, root);
    for (const auto& section : root)
      ReadSection(file, section.first.as<std::string>(""), section.first, section.second);
  }

  /// Which of two values is meant nobody can know.
  void SayWhatComesTwice(const std::filesystem::path& file, const YAML::Node& map) {
    std::set<std::string> keys;
    for (const auto& entry : map)
      if (const std::string key = entry.first.as<std::string>(""); !keys.insert(key).second)
        problems_.push_back(Where(file, entry.first) + ": '" + key + "' comes twice");
  }

  /// A section holds keys, or sections of its own.
  void ReadSection(const std::filesystem::path& file, const std::string& name, const YAML::Node& key,
                   const YAML::Node& content) {
    const std::string where = Where(file, key);
    if (!binding_.HasSection(name)) {
      problems_.push_back(where + ": there is no section '" + name + "'");
    } else if (content.IsMap()) {
      SayWhatComesTwice(file, content);
      for (const auto& entry : content) {
        const std::string inner = entry.first.as<std::string>("");
        if (entry.second.IsMap() && binding_.HasSection(name + "." + inner)) {
          ReadSection(file, name + "." + inner, entry.first, entry.second);
        } else {
          Set(name, inner, entry.second, Where(file, entry.first));
        }
      }
    } else if (!content.IsNull()) {
      problems_.push_back(where + ": section '" + name + "' must hold keys");
    }
  }

  void ReadSetting(const std::string& setting) {
    const std::string where = "--set " + setting;
    const std::size_t equals = setting.find('=');
    const std::size_t dot = setting.rfind('.', equals);
    if (equals == std::string::npos || dot == std::string::npos || dot > equals) {
      problems_.push_back(where + ": must read section.key=value");
      return;
    }
    YAML::Node value;
    try {
      value = YAML::Load(setting.substr(equals + 1));
    } catch (const YAML::Exception& error) {
      problems_.push_back(where + ": the value is not YAML: " + error.msg);
      return;
    }
    // An empty value sets a text to nothing.
    if (value.IsNull()) value = std::string();
    Set(setting.substr(0, dot), setting.substr(dot + 1, equals - dot - 1), value, where);
  }

  void Finish() {
    for (const auto& [section, problem] : binding_.Problems()) {
      const std::string name = problem.substr(0, problem.find(' '));
      const auto origin = origins_.find(section + "." + name);
      problems_.push_back((origin == origins_.end() ? "default" : origin->second) + ": " + section + "." +
                          problem);
    }
    if (problems_.empty()) return;
    std::string text;
    for (const std::string& problem : problems_) text += (text.empty() ? "" : "\n") + problem;
    throw ConfigError(text);
  }

 private:
  static std::string Where(const std::filesystem::path& file, const YAML::Node& node) {
    return file.string() + ":" + std::to_string(node.Mark().line + 1);
  }

  void Set(const std::string& section, const std::string& name, const YAML::Node& value,
           const std::string& where) {
    const std::string full = section + "." + name;
    const Key* key = binding_.Find(section, name);
    if (key == nullptr) {
      problems_.push_back(where + ": there is no key '" + full + "'");
    } else if (!key->set(value)) {
      const std::string text = value.IsScalar() ? value.Scalar() : "a list or a map";
      problems_.push_back(where + ": " + full + " = " + text + " must be " + key->type);
    } else {
      origins_[full] = where;
    }
  }

  Binding binding_;
  std::vector<std::string> problems_;
  std::map<std::string, std::string> origins_;
};

}  // namespace

Config LoadConfig(const std::optional<std::filesystem::path>& file,
                  const std::vector<std::string>& settings) {
  Config config;
  config.live.url = DefaultUrl(config.live.url);
  Loader loader(&config);
  if (file) loader.ReadFile(*file);
  for (const std::string& setting : settings) loader.ReadSetting(setting);
  loader.Finish();
  return config;
}

std::string PrintConfig(const Config& config) {
  Config copy = config;
  const Binding binding(&copy);
  std::string text =
      "# Every key of the configuration with its default. A file may hold any part of it; an unknown key is "
      "an error.\n";
  std::string section;
  for (const Key& key : binding.keys()) {
    const std::size_t dot = key.section.find('.');
    const std::string indent = dot == std::string::npos ? "  " : "    ";
    if (key.section != section) {
      const std::string top = key.section.substr(0, dot);
      if (section.substr(0, section.find('.')) != top) text += "\n" + top + ":\n";
      section = key.section;
      if (dot != std::string::npos) text += "  " + section.substr(dot + 1) + ":\n";
    }
    std::size_t begin = 0;
    while (begin < key.comment.size()) {
      const std::size_t end = std::min(key.comment.find('\n', begin), key.comment.size());
      text += indent + "# " + key.comment.substr(begin, end - begin) + "\n";
      begin = end + 1;
    }
    text += indent + key.name + ": " + key.print() + "\n";
  }
  return text;
}

std::string ConfigHash(const Config& config) {
  // FNV-1a: a name for equal settings, not a protection.
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : PrintConfig(config)) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  }
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(hash));
  return text.data();
}

}  // namespace terrace
