#pragma once

#include <functional>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/render/color.h"
#include "lode/render/image.h"

namespace lode {

/// What colours stand for.
struct Legend {
  std::string title;  ///< Such as the field's name.
  double low = 0;     ///< Values at the bar's ends.
  double high = 1;
  std::function<Color(double value)> color;
};

/// Pictures smaller than this, either way, have no room for one.
inline constexpr int kLeastLegendWidth = 320;
inline constexpr int kLeastLegendHeight = 240;

/// Draws a bar of the colours at the picture's right, with round values beside it and the title
/// above, in a colour that stands out from what is there. Fails where there is no font.
[[nodiscard]] Result<void> draw_legend(const Legend& legend, Image& image);

/// Multiples of 1, 2 or 5 times a power of ten from low to high, three to nine; fewer where doubles
/// hardly tell the ends apart, and of one value that.
[[nodiscard]] std::vector<double> round_values(double low, double high);

}  // namespace lode
