#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/render/color.h"

namespace lode {

/// An 8-bit sRGB picture with straight alpha, rows from the top.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<Color> pixels;  ///< width · height of them.

  friend bool operator==(const Image&, const Image&) = default;

  [[nodiscard]] const Color& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

/// The bytes of a PNG file, tagged sRGB: RGB where every pixel is opaque, else RGBA.
/// The same image always gives the same bytes (for one version of zlib).
[[nodiscard]] Result<std::vector<std::byte>> encode_png(const Image& image);
/// Writes the image, whole or not at all.
[[nodiscard]] Result<void> write_png(const Image& image, const std::string& path);

}  // namespace lode
