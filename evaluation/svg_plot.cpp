// SPDX-License-Identifier: BSD-3-Clause
#include "evaluation/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/print.h"

namespace terrace {
namespace {

constexpr double kWidth = 640, kHeight = 300;
constexpr double kLeft = 62, kRight = 14, kTop = 34, kBottom = 44;
constexpr double kMaxEqualHeight = 520, kMinEqualHeight = 170;

/// 1, 2 or 5 times a power of ten, so that about `count` steps fill the range.
double NiceStep(double range, int count) {
  const double rough = range / count;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  for (double factor : {1.0, 2.0, 5.0}) {
    if (rough <= factor * power) return factor * power;
  }
  return 10.0 * power;
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void Extend(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double size() const { return high - low; }
  /// Never empty, and with air on both sides.
  void Pad(double share) {
    if (!(low <= high)) low = 0.0, high = 1.0;
    const double pad = size() > 0.0 ? share * size() : std::max(0.5 * std::abs(low), 1e-3);
    low -= pad;
    high += pad;
  }
};

/// Where values lie on the page.
class Frame {
 public:
  Frame(const PlotStyle& style, Range x, Range y) : style_(style), x_(x), y_(y) {
    if (style.equal_axes) {
      const double inner = kWidth - kLeft - kRight;
      double scale = inner / x_.size();
      const double wanted = scale * y_.size() + kTop + kBottom;
      height_ = std::clamp(wanted, kMinEqualHeight, kMaxEqualHeight);
      scale = std::min(scale, (height_ - kTop - kBottom) / y_.size());
      Widen(&x_, inner / scale);
      Widen(&y_, (height_ - kTop - kBottom) / scale);
    }
  }

  double height() const { return height_; }
  double X(double x) const { return kLeft + (x - x_.low) / x_.size() * (kWidth - kLeft - kRight); }
  double Y(double y) const {
    return height_ - kBottom - (y - y_.low) / y_.size() * (height_ - kTop - kBottom);
  }

  /// Opens the element and draws title, axes and grid.
  std::string Begin() const {
    std::string svg;
    Print(&svg, "<svg viewBox=\"0 0 %.0f %.0f\" role=\"img\">\n", kWidth, height_);
    svg += "<text class=\"title\" x=\"" + std::to_string(static_cast<int>(kLeft)) + "\" y=\"18\">" +
           EscapeMarkup(style_.title) + "</text>\n";
    const double step_x = NiceStep(x_.size(), 7);
    for (double x = std::ceil(x_.low / step_x) * step_x; x <= x_.high; x += step_x) {
      Print(&svg, "<line class=\"grid\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\"/>", X(x), X(x), kTop,
            height_ - kBottom);
      Print(&svg, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%g</text>\n", X(x),
            height_ - kBottom + 15, Rounded(x, step_x));
    }
    const double step_y = style_.logarithmic_y ? 1.0 : NiceStep(y_.size(), 5);
    for (double y = std::ceil(y_.low / step_y) * step_y; y <= y_.high; y += step_y) {
      Print(&svg, "<line class=\"grid\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\"/>", kLeft,
            kWidth - kRight, Y(y), Y(y));
      Print(&svg, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%g</text>\n", kLeft - 6,
            Y(y) + 4, style_.logarithmic_y ? std::pow(10.0, y) : Rounded(y, step_y));
    }
    Print(&svg, "<text class=\"axis\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n",
          0.5 * (kLeft + kWidth - kRight), height_ - 8, EscapeMarkup(style_.x_label).c_str());
    Print(&svg,
          "<text class=\"axis\" transform=\"translate(14 %.1f) rotate(-90)\" "
          "text-anchor=\"middle\">%s</text>\n",
          0.5 * (kTop + height_ - kBottom), EscapeMarkup(style_.y_label).c_str());
    return svg;
  }

 private:
  /// Ticks near zero would print as 1e-17 or -0.
  static double Rounded(double value, double step) { return std::round(value / step) * step + 0.0; }

  static void Widen(Range* range, double size) {
    const double middle = 0.5 * (range->low + range->high);
    range->low = middle - 0.5 * size;
    range->high = middle + 0.5 * size;
  }

  const PlotStyle& style_;
  Range x_, y_;
  double height_ = kHeight;
};

std::string Polyline(const Frame& frame, const PlotSeries& series) {
  std::string svg = "<polyline fill=\"none\" stroke-width=\"1.6\" stroke=\"" + series.colour + "\" points=\"";
  for (const Eigen::Vector2d& p : series.points) Print(&svg, "%.1f,%.1f ", frame.X(p.x()), frame.Y(p.y()));
  return svg + "\"/>\n";
}

std::string Legend(const std::vector<PlotSeries>& series) {
  std::string svg;
  double x = kWidth - kRight;
  for (auto it = series.rbegin(); it != series.rend(); ++it) {
    if (it->name.empty()) continue;
    constexpr double kCharacter = 6.6;
    x -= kCharacter * static_cast<double>(it->name.size()) + 26;
    Print(&svg, "<rect x=\"%.1f\" y=\"12\" width=\"14\" height=\"4\" fill=\"%s\"/>", x, it->colour.c_str());
    Print(&svg, "<text class=\"tick\" x=\"%.1f\" y=\"18\">%s</text>\n", x + 18,
          EscapeMarkup(it->name).c_str());
  }
  return svg;
}

/// Points as they are drawn: logarithms taken, what cannot be shown left out.
std::vector<PlotSeries> Shown(const PlotStyle& style, std::vector<PlotSeries> series) {
  for (PlotSeries& one : series) {
    std::erase_if(one.points, [&](const Eigen::Vector2d& p) {
      return !p.allFinite() || (style.logarithmic_y && p.y() <= 0.0);
    });
    if (!style.logarithmic_y) continue;
    for (Eigen::Vector2d& p : one.points) p.y() = std::log10(p.y());
  }
  return series;
}

}  // namespace

std::string EscapeMarkup(const std::string& text) {
  std::string escaped;
  for (char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string PlotLines(const PlotStyle& style, const std::vector<PlotSeries>& series) {
  const std::vector<PlotSeries> shown = Shown(style, series);
  Range x, y;
  for (const PlotSeries& one : shown) {
    for (const Eigen::Vector2d& p : one.points) {
      x.Extend(p.x());
      y.Extend(p.y());
    }
  }
  for (const PlotReference& reference : style.references) {
    y.Extend(style.logarithmic_y ? std::log10(reference.y) : reference.y);
  }
  x.Pad(style.equal_axes ? 0.05 : 0.0);
  if (style.y_from_zero) y.Extend(0.0);
  y.Pad(0.05);
  if (style.y_from_zero) y.low = 0.0;
  const Frame frame(style, x, y);
  std::string svg = frame.Begin();
  for (const PlotReference& reference : style.references) {
    const double at = frame.Y(style.logarithmic_y ? std::log10(reference.y) : reference.y);
    Print(&svg, "<line class=\"reference\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\"/>", kLeft,
          kWidth - kRight, at, at);
    Print(&svg, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n",
          kWidth - kRight - 4, at - 4, EscapeMarkup(reference.name).c_str());
  }
  for (const PlotSeries& one : shown) svg += Polyline(frame, one);
  return svg + Legend(shown) + "</svg>\n";
}

std::string PlotShapes(const PlotStyle& style, const std::vector<PlotShape>& shapes,
                       const std::vector<PlotSeries>& series) {
  Range x, y;
  for (const PlotShape& shape : shapes) {
    for (const auto& ring : shape.rings) {
      for (const Eigen::Vector2d& p : ring) {
        x.Extend(p.x());
        y.Extend(p.y());
      }
    }
  }
  x.Pad(0.02);
  y.Pad(0.02);
  PlotStyle equal = style;
  equal.equal_axes = true;
  const Frame frame(equal, x, y);
  std::string svg = frame.Begin();
  for (const PlotShape& shape : shapes) {
    svg += "<path fill-rule=\"evenodd\" fill=\"" + shape.fill + "\" stroke=\"" + shape.stroke + "\" d=\"";
    for (const auto& ring : shape.rings) {
      char command = 'M';
      for (const Eigen::Vector2d& p : ring) {
        Print(&svg, "%c%.1f %.1f", command, frame.X(p.x()), frame.Y(p.y()));
        command = 'L';
      }
      svg += "Z";
    }
    svg += "\"><title>" + EscapeMarkup(shape.tooltip) + "</title></path>\n";
  }
  for (const PlotSeries& one : series) svg += Polyline(frame, one);
  return svg + Legend(series) + "</svg>\n";
}

std::string PlotBars(const PlotStyle& style, const std::vector<PlotBar>& bars) {
  constexpr double kRow = 22, kNames = 120;
  double most = 1e-9;
  for (const PlotBar& bar : bars) most = std::max({most, bar.value, bar.mark});
  const double height = kTop + kRow * static_cast<double>(bars.size()) + 8;
  const double scale = (kWidth - kNames - 90) / most;
  std::string svg;
  Print(&svg, "<svg viewBox=\"0 0 %.0f %.0f\" role=\"img\">\n", kWidth, height);
  svg += "<text class=\"title\" x=\"8\" y=\"18\">" + EscapeMarkup(style.title) + "</text>\n";
  double y = kTop;
  for (const PlotBar& bar : bars) {
    Print(&svg, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>", kNames - 8,
          y + 12, EscapeMarkup(bar.name).c_str());
    Print(&svg, "<rect class=\"bar\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"14\"/>", kNames, y + 1,
          scale * bar.value);
    Print(&svg, "<line class=\"mark\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\"/>",
          kNames + scale * bar.mark, kNames + scale * bar.mark, y, y + 16);
    Print(&svg, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\">%.1f | %.1f</text>\n",
          kNames + scale * std::max(bar.value, bar.mark) + 6, y + 12, bar.value, bar.mark);
    y += kRow;
  }
  return svg + "</svg>\n";
}

}  // namespace terrace
