// SPDX-License-Identifier: BSD-3-Clause
#include "tools/camera_config.h"

#include <functional>
#include <map>

#include "core/field_problems.h"
#include "core/file_bytes.h"
#include "datasets/yaml_value.h"
#include "lcmtypes/image_codec.h"
#include "tools/camera_frame.h"

namespace terrace {

std::vector<std::string> CameraConfig::Problems() const {
  FieldProblems problems;
  const auto format_known = PixelFormatFromName(format);
  problems.Require(format_known.has_value(), "format", format, "be GREY, YUYV, MJPEG or Y8I");
  problems.Require(!device.empty(), "device", device, "name a camera");
  problems.Require(!has_two_devices() || device != device_right, "device_right", device_right,
                   "be another one than device");
  problems.Require(!(has_two_devices() && format_known == PixelFormat::kY8i), "device_right", device_right,
                   "be empty where format = Y8I holds both cameras");
  problems.Require(has_two_devices() || format_known == PixelFormat::kY8i || width % 2 == 0, "width", width,
                   "be even where two images lie side by side");
  problems.Require(ImageEncodingFromName(encoding).has_value(), "encoding", encoding,
                   "be raw, lossless or mjpeg");
  problems.RequireWithin("width", width, 16, 16384);
  problems.RequireWithin("height", height, 16, 16384);
  problems.RequireWithin("rate_hz", rate_hz, 0.1, 1000.0);
  problems.RequireWithin("exposure_us", exposure_us, 0.0, 1e6);
  problems.RequireWithin("stamp_offset_ms", stamp_offset_ms, -1000.0, 1000.0);
  problems.RequireWithin("max_skew_ms", max_skew_ms, 0.0, 1000.0);
  return problems.Take();
}

CameraConfig ReadCameraConfig(const std::filesystem::path& path) {
  CameraConfig config;
  const std::map<std::string, std::function<void(const YamlValue&)>> keys = {
      {"device", [&](const YamlValue& v) { config.device = v.Text(); }},
      {"device_right", [&](const YamlValue& v) { config.device_right = v.Text(); }},
      {"width", [&](const YamlValue& v) { config.width = v.WholeNumber(); }},
      {"height", [&](const YamlValue& v) { config.height = v.WholeNumber(); }},
      {"rate_hz", [&](const YamlValue& v) { config.rate_hz = v.Number(); }},
      {"format", [&](const YamlValue& v) { config.format = v.Text(); }},
      {"swap",
       [&](const YamlValue& v) {
         if (v.Text() != "true" && v.Text() != "false") v.Fail("must be true or false");
         config.swap = v.Text() == "true";
       }},
      {"exposure_us", [&](const YamlValue& v) { config.exposure_us = v.Number(); }},
      {"gain", [&](const YamlValue& v) { config.gain = v.WholeNumber(); }},
      {"stamp_offset_ms", [&](const YamlValue& v) { config.stamp_offset_ms = v.Number(); }},
      {"max_skew_ms", [&](const YamlValue& v) { config.max_skew_ms = v.Number(); }},
      {"encoding", [&](const YamlValue& v) { config.encoding = v.Text(); }}};
  const YamlValue file = ParseYaml(ReadTextFile(path), path.string());
  if (!file.IsMap()) file.Fail("must hold the keys of a camera, as tools/cameras/ shows");
  for (const auto& [key, value] : file.Members()) {
    const auto known = keys.find(key);
    if (known == keys.end()) value.Fail("there is no such key");
    known->second(value);
  }
  std::string problems;
  for (const std::string& problem : config.Problems()) problems += "\n  " + problem;
  if (!problems.empty()) throw FileError(path.string() + ":" + problems);
  return config;
}

}  // namespace terrace
