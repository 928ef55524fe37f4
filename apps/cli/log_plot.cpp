#include "log_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lode::cli {
namespace {

constexpr double kPlotWidth = 560;
constexpr double kPlotHeight = 340;
constexpr double kLeft = 70;
constexpr double kRight = 16;
constexpr double kTop = 34;
constexpr double kBottom = 52;

bool is_shown(const PlotLine::Point& p) {
  return p.x > 0 && p.y > 0 && std::isfinite(p.x) && std::isfinite(p.y);
}

/// An axis of powers of ten.
struct LogAxis {
  double low = 1e300;  ///< log10.
  double high = -1e300;

  void include(double value) {
    low = std::min(low, std::log10(value));
    high = std::max(high, std::log10(value));
  }
  /// To whole powers where these are near, and not without extent.
  void finish() {
    low = std::floor(low * 4) / 4 - 0.05;
    high = std::ceil(high * 4) / 4 + 0.05;
  }
  [[nodiscard]] double share(double value) const {
    return (std::log10(value) - low) / (high - low);
  }
};

struct Plot {
  LogAxis x;
  LogAxis y;

  [[nodiscard]] double left_of(double value) const {
    return kLeft + x.share(value) * (kPlotWidth - kLeft - kRight);
  }
  [[nodiscard]] double top_of(double value) const {
    return kPlotHeight - kBottom - y.share(value) * (kPlotHeight - kTop - kBottom);
  }
};

/// Powers of ten, with 2 and 5 times these where there are few.
std::vector<double> ticks_of(const LogAxis& axis) {
  const bool is_wide = axis.high - axis.low > 2.5;
  std::vector<double> ticks;
  for (int power = static_cast<int>(std::floor(axis.low)); power <= axis.high; ++power)
    for (const double step : {1.0, 2.0, 5.0}) {
      if (is_wide && step > 1) continue;
      const double tick = step * std::pow(10, power);
      if (std::log10(tick) >= axis.low && std::log10(tick) <= axis.high) ticks.push_back(tick);
    }
  return ticks;
}

std::string tick_text(double value) {
  if (value >= 1e6) return fmt::format("{:g} M", value / 1e6);
  if (value >= 1e3) return fmt::format("{:g} k", value / 1e3);
  return fmt::format("{:g}", value);
}

std::string axes_of(const Plot& plot, const std::string& x_name, const std::string& y_name) {
  std::string svg;
  for (const double tick : ticks_of(plot.x))
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>"
        "<text x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">{4}</text>\n",
        plot.left_of(tick), kTop, kPlotHeight - kBottom, kPlotHeight - kBottom + 16,
        tick_text(tick));
  for (const double tick : ticks_of(plot.y))
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5}</text>\n",
        kLeft, kPlotWidth - kRight, plot.top_of(tick), kLeft - 6, plot.top_of(tick) + 4,
        tick_text(tick));
  svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                     (kLeft + kPlotWidth - kRight) / 2, kPlotHeight - 14, escaped(x_name));
  svg += fmt::format(
      "<text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
      (kTop + kPlotHeight - kBottom) / 2, escaped(y_name));
  return svg;
}

std::string line_svg(const Plot& plot, const PlotLine& line, std::size_t place) {
  std::string path;
  std::string dots;
  for (const PlotLine::Point& p : line.points) {
    if (!is_shown(p)) continue;
    path += fmt::format("{:.1f},{:.1f} ", plot.left_of(p.x), plot.top_of(p.y));
    dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"/>",
                        plot.left_of(p.x), plot.top_of(p.y), line.color);
  }
  const double top = kTop + 12 + 16 * static_cast<double>(place);
  return fmt::format(
      "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>{}"
      "<rect x=\"{}\" y=\"{}\" width=\"14\" height=\"3\" fill=\"{}\"/>"
      "<text x=\"{}\" y=\"{}\">{}</text>\n",
      path, line.color, dots, kPlotWidth - 190, top, line.color, kPlotWidth - 170, top + 5,
      escaped(line.name));
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string made;
  for (const char c : text) {
    if (c == '&')
      made += "&amp;";
    else if (c == '<')
      made += "&lt;";
    else if (c == '>')
      made += "&gt;";
    else if (c == '"')
      made += "&quot;";
    else
      made += c;
  }
  return made;
}

std::string log_plot(const std::string& title, const std::string& x_name, const std::string& y_name,
                     const std::vector<PlotLine>& lines) {
  Plot plot;
  bool has_points = false;
  for (const PlotLine& line : lines)
    for (const PlotLine::Point& p : line.points) {
      if (!is_shown(p)) continue;
      has_points = true;
      plot.x.include(p.x);
      plot.y.include(p.y);
    }
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\">"
      "<text class=\"title\" x=\"{2}\" y=\"18\">{3}</text>\n",
      kPlotWidth, kPlotHeight, kLeft, escaped(title));
  if (!has_points)
    return svg + fmt::format("<text x=\"{}\" y=\"{}\">nothing to show</text></svg>\n", kLeft, 60);
  plot.x.finish();
  plot.y.finish();
  svg += axes_of(plot, x_name, y_name);
  for (std::size_t i = 0; i < lines.size(); ++i) svg += line_svg(plot, lines[i], i);
  return svg + "</svg>\n";
}

}  // namespace lode::cli
