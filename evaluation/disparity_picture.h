// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "evaluation/disparity_truth.h"

namespace terrace {

/// A disparity image beside what is wrong with it. Left half: grey by disparity, brightest at the largest
/// true one, black where unknown. Right half: grey by the error up to 2 px; white where a pixel that both
/// cameras see has no value or is farther off, black where all is well or nothing is known.
GrayImage PictureOfErrors(const FloatImage& disparity_px, const DisparityTruth& truth);

/// An image as a URI that holds it whole.
std::string JpegUri(const GrayImage& image);
/// The bytes of a PNG file as such a URI.
std::string PngUri(const std::vector<std::uint8_t>& file);
/// An image as an HTML element that needs no other file.
std::string EmbeddedImage(const GrayImage& image, const std::string& description);

}  // namespace terrace
