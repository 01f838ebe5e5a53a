// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace terrace {

/// Text that may stand anywhere in HTML or SVG.
std::string EscapeMarkup(const std::string& text);

/// A line through points, or single points.
struct PlotSeries {
  std::string name;
  std::string colour;  ///< as in CSS
  std::vector<Eigen::Vector2d> points;
};

/// A horizontal line to read a plot by.
struct PlotReference {
  double y = 0.0;
  std::string name;
};

struct PlotStyle {
  std::string title;
  std::string x_label;
  std::string y_label;
  bool equal_axes = false;     ///< a metre is as long across as up
  bool logarithmic_y = false;  ///< values not above 0 are left out
  bool y_from_zero = false;
  std::vector<PlotReference> references;
};

/// One plot as an <svg> element that needs nothing from outside.
std::string PlotLines(const PlotStyle& style, const std::vector<PlotSeries>& series);

/// A closed outline with holes, filled.
struct PlotShape {
  std::vector<std::vector<Eigen::Vector2d>> rings;
  std::string fill;    ///< as in CSS; "none" for outlines only
  std::string stroke;  ///< as in CSS
  std::string tooltip;
};

/// A plan: shapes in order, equal axes, then lines on top of them.
std::string PlotShapes(const PlotStyle& style, const std::vector<PlotShape>& shapes,
                       const std::vector<PlotSeries>& series);

/// One bar a row, with a second, thinner mark.
struct PlotBar {
  std::string name;
  double value = 0.0;
  double mark = 0.0;
};
std::string PlotBars(const PlotStyle& style, const std::vector<PlotBar>& bars);

}  // namespace terrace
