#pragma once

#include <cstddef>
#include <vector>

#include "lode/core/vec.h"

namespace lode {

/// What a pixel's samples gave, each value the mean over all of them (a miss counts as zero).
struct PixelData {
  Vec3f flat;  ///< Light that needs no visibility: contour lines.
  Vec3f sky;   ///< Light of the whole sky, as if nothing stood in its way.
  Vec3f key;   ///< Light of the key lamp, as if nothing stood in its way.
  Vec3f normal;
  Vec3f position;
  float coverage = 0;      ///< Fraction of samples that met something.
  float sky_coverage = 0;  ///< Fraction that met a lit surface (no line).
  float sky_open = 0;      ///< Of sky_coverage, the part that saw the sky.
  float key_weight = 0;    ///< Cosine to the lamp.
  float key_open = 0;      ///< Of key_weight, the part that saw the lamp.
};

/// A moving window of whole rows of a picture, so that memory does not grow with its height.
class PixelRows {
 public:
  PixelRows(int width, int n_rows)
      : width_(width),
        n_rows_(n_rows),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(n_rows)) {}

  [[nodiscard]] int width() const { return width_; }
  /// Row y shares its place with the rows y ± n_rows.
  [[nodiscard]] PixelData& at(int x, int y) { return pixels_[index_of(x, y)]; }
  [[nodiscard]] const PixelData& at(int x, int y) const { return pixels_[index_of(x, y)]; }

 private:
  [[nodiscard]] std::size_t index_of(int x, int y) const {
    return static_cast<std::size_t>(y % n_rows_) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }

  int width_;
  int n_rows_;
  std::vector<PixelData> pixels_;
};

/// How far smooth_visibility looks, in pixels.
inline constexpr int kFilterRadius = 4;

/// Fractions of the sky and of the lamp that a pixel sees.
struct Visibility {
  float sky = 1;
  float key = 1;
};

/// The visibility at a pixel, averaged with those neighbours (rows y_begin <= y < y_end) that
/// lie on the same smooth piece of surface: a few dozen rays per pixel then look like hundreds.
/// Colour and shape are never filtered, so edges stay sharp.
/// `pixel_size`: distance of neighbouring pixels on the surface, seen head-on.
[[nodiscard]] Visibility smooth_visibility(const PixelRows& rows, int x, int y, int y_begin,
                                           int y_end, float pixel_size);

}  // namespace lode
