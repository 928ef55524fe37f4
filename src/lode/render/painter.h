#pragma once

#include <array>
#include <cstdint>

#include "lode/core/progress.h"
#include "lode/render/color.h"
#include "lode/render/lens.h"
#include "lode/render/pixel_filter.h"
#include "lode/render/ray_scene.h"
#include "lode/render/sampling.h"
#include "lode/render/shading.h"
#include "lode/render/surface_renderer.h"

namespace lode {

/// Where sample i of a pixel looks, in pixels from the picture's upper left corner: in a soft
/// filter round the pixel's middle, or there where it is the only one.
[[nodiscard]] Lens::Point sample_point(int x, int y, std::uint32_t i, int samples_per_pixel);
/// The backdrop of a row.
[[nodiscard]] Color background_at(const RenderOptions& options, int y);

/// Pictures are made in bands of so many rows.
inline constexpr int kPictureBandRows = 128;

/// Gives single pixels of a picture, in two steps: sampling by rays, then finishing with what
/// the neighbours' samples saw. Const members may be called from any thread.
class Painter {
 public:
  /// All arguments must outlive the painter. `radius` of the ball that holds the scene.
  Painter(const RayScene& scene, const Lens& lens, double radius, const RenderOptions& options)
      : scene_(scene), lens_(lens), lights_(lens.axes()), radius_(radius), options_(options) {}

  [[nodiscard]] PixelData sample_pixel(int x, int y) const;
  /// Samples the rows y_begin <= y < y_end, tile by tile; some of them when cancelled.
  void sample_rows(PixelRows& rows, int y_begin, int y_end, Progress& progress) const;
  /// Needs the sampled pixels of the rows y_begin <= y < y_end within kFilterRadius of y.
  [[nodiscard]] Color finish_pixel(const PixelRows& rows, int x, int y, int y_begin,
                                   int y_end) const;
  /// The mean light of what its samples met, tone mapped; black where they met nothing.
  [[nodiscard]] Vec3f surface_light(const PixelRows& rows, int x, int y, int y_begin,
                                    int y_end) const;

 private:
  void add_lit(PixelData& pixel, const SceneHit& hit, const Vec3f& view, const PixelSequence& sky,
               const std::array<float, 3>& lamp, std::uint32_t sample) const;
  [[nodiscard]] float open_sky(const SceneHit& hit, const PixelSequence& sky,
                               std::uint32_t sample) const;
  const RayScene& scene_;
  const Lens& lens_;
  Lights lights_;
  double radius_;
  const RenderOptions& options_;
};

}  // namespace lode
