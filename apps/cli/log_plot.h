#pragma once

#include <string>
#include <vector>

namespace lode::cli {

/// A line of a plot; points where x or y is not positive are left out.
struct PlotLine {
  struct Point {
    double x;
    double y;
  };
  std::string name;
  std::string color;  ///< As CSS has it.
  std::vector<Point> points;
};

/// An SVG of lines over axes that are both logarithmic, with a legend; "nothing to show" where no
/// point is left.
[[nodiscard]] std::string log_plot(const std::string& title, const std::string& x_name,
                                   const std::string& y_name, const std::vector<PlotLine>& lines);

/// For text in HTML and SVG.
[[nodiscard]] std::string escaped(const std::string& text);

}  // namespace lode::cli
