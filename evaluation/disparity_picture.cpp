// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/disparity_picture.h"

#include <algorithm>
#include <cmath>

#include <openssl/evp.h>

#include "core/check.h"
#include "evaluation/svg_plot.h"

namespace terrace {
namespace {

constexpr float kWorst_px = 2.0F;
constexpr float kBrightestError = 200.0F;  // of a value that is not called wrong

std::string DataUri(const std::string& type, const std::vector<std::uint8_t>& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  text.resize(static_cast<std::size_t>(EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                                       bytes.data(), static_cast<int>(bytes.size()))));
  return "data:image/" + type + ";base64," + text;
}

}  // namespace

GrayImage PictureOfErrors(const FloatImage& disparity_px, const DisparityTruth& truth) {
  const FloatImage& true_px = truth.disparity_px;
  TERRACE_CHECK(disparity_px.width == true_px.width && disparity_px.height == true_px.height,
                disparity_px.width, disparity_px.height, true_px.width, true_px.height);
  float largest = 1.0F;
  for (std::size_t i = 0; i < true_px.data.size(); ++i)
    if (truth.pixels[i] != PixelTruth::kNotKnown) largest = std::max(largest, true_px.data[i]);
  const int width = disparity_px.width, height = disparity_px.height;
  GrayImage picture{2 * width, height, {}};
  picture.data.resize(2 * disparity_px.data.size());
  for (int v = 0; v < height; ++v) {
    std::uint8_t* row = picture.data.data() + static_cast<std::size_t>(v) * 2 * width;
    for (int u = 0; u < width; ++u) {
      const float d = disparity_px.At(u, v);
      row[u] = d > 0.0F ? static_cast<std::uint8_t>(255.0F * std::min(d / largest, 1.0F)) : 0;
      if (truth.pixels[true_px.Index(u, v)] != PixelTruth::kVisible) continue;
      const float error = std::abs(d - true_px.At(u, v));
      row[width + u] =
          error <= kWorst_px ? static_cast<std::uint8_t>(kBrightestError * error / kWorst_px) : 255;
    }
  }
  return picture;
}

std::string JpegUri(const GrayImage& image) {
  constexpr int kQuality = 85;
  return DataUri("jpeg", EncodeJpeg(image, kQuality));
}

std::string PngUri(const std::vector<std::uint8_t>& file) { return DataUri("png", file); }

std::string EmbeddedImage(const GrayImage& image, const std::string& description) {
  return "<img alt=\"" + EscapeMarkup(description) + "\" src=\"" + JpegUri(image) + "\">";
}

}  // namespace terrace
