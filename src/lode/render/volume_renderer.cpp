#include "lode/render/volume_renderer.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "lode/core/out_of_memory.h"
#include "lode/render/painter.h"
#include "lode/render/ray_scene.h"
#include "lode/render/render_checks.h"
#include "lode/render/volume_tracer.h"

namespace lode {
namespace {

constexpr Color kFilmColor{120, 128, 140};

/// Means over a pixel's samples.
struct VolumePixel {
  Vec3f light;       ///< Of the volume.
  float onto = 0;    ///< Transmittance of samples that end at the opaque surface; others count 0.
  float beyond = 0;  ///< The same of those that do not.
};

/// What of a picture all bands share.
struct VolumeScene {
  const VolumeView& view;
  const LightRamps& ramps;
  const Lens& lens;
  const RayScene* opaque;  ///< May be null.
  BoundaryFilm film;
  const RenderOptions& options;
  double radius;
};

/// Where a ray meets the opaque surface; far away without one.
VolumeRay to_volume_ray(const VolumeScene& scene, const Lens::Point& point, bool& is_stopped) {
  VolumeRay ray{point.x, point.y};
  is_stopped = false;
  if (scene.opaque == nullptr) return ray;
  const auto sight = scene.lens.ray_through(point.x, point.y, scene.radius);
  if (!sight) return ray;
  const auto hit = scene.opaque->intersect(sight->origin, sight->direction);
  if (!hit) return ray;
  is_stopped = true;
  ray.end_depth = dot(scene.lens.axes().forward, widened(hit->position));
  return ray;
}

/// A band of rows from y_begin on, as many as `pixels` holds.
class VolumeBand {
 public:
  VolumeBand(const VolumeScene& scene, int y_begin, std::span<VolumePixel> pixels)
      : scene_(scene), y_begin_(y_begin), pixels_(pixels) {
    y_end_ = y_begin + static_cast<int>(pixels.size() / static_cast<std::size_t>(width()));
  }

  void trace_tile(int tile_x, int tile_y, VolumeTracer& tracer) {
    points_.clear();
    for (int y = tile_y * kTile; y < std::min((tile_y + 1) * kTile, y_end_); ++y)
      for (int x = tile_x * kTile; x < std::min((tile_x + 1) * kTile, width()); ++x)
        points_.push_back({x, y});
    const int n = scene_.options.samples_per_pixel;
    for (int i = 0; i < n; ++i) {
      rays_.clear();
      is_stopped_.clear();
      for (const auto& [x, y] : points_) {
        bool is_stopped = false;
        rays_.push_back(to_volume_ray(scene_, sample_point(x, y, static_cast<std::uint32_t>(i), n),
                                      is_stopped));
        is_stopped_.push_back(is_stopped);
      }
      light_.resize(rays_.size());
      tracer.trace(tile_x, tile_y, rays_, light_);
      add_samples(1.0 / n);
    }
  }

 private:
  static constexpr int kTile = VolumeView::kTile;
  [[nodiscard]] int width() const { return scene_.options.width; }

  void add_samples(double share) {
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto& [x, y] = points_[i];
      VolumePixel& pixel =
          pixels_[static_cast<std::size_t>(y - y_begin_) * static_cast<std::size_t>(width()) +
                  static_cast<std::size_t>(x)];
      pixel.light = pixel.light + to_vec3f(light_[i].light * share);
      (is_stopped_[i] ? pixel.onto : pixel.beyond) +=
          static_cast<float>(light_[i].transmittance * share);
    }
  }

  struct PixelPlace {
    int x, y;
  };
  const VolumeScene& scene_;
  int y_begin_;
  int y_end_;
  std::span<VolumePixel> pixels_;
  std::vector<PixelPlace> points_;
  std::vector<VolumeRay> rays_;
  std::vector<bool> is_stopped_;
  std::vector<RayLight> light_;
};

/// `y_begin`: of a row of tiles.
void trace_band(const VolumeScene& scene, int y_begin, std::span<VolumePixel> pixels,
                Progress& progress) {
  std::ranges::fill(pixels, VolumePixel{});
  struct Worker {
    VolumeBand band;
    VolumeTracer tracer;
  };
  std::vector<Worker> workers(
      static_cast<std::size_t>(n_workers(scene.options.threads)),
      {VolumeBand(scene, y_begin, pixels), VolumeTracer(scene.view, scene.ramps, scene.film)});
  const auto n_rows = static_cast<int>(pixels.size()) / scene.options.width;
  const int n_tiles_x = scene.view.n_tiles_x();
  const int tile_rows = (n_rows + VolumeView::kTile - 1) / VolumeView::kTile;
  parallel_for(static_cast<std::size_t>(n_tiles_x) * static_cast<std::size_t>(tile_rows),
               scene.options.threads, 4, [&](std::size_t tile, int worker) {
                 if (progress.is_cancelled()) return;
                 Worker& mine = workers[static_cast<std::size_t>(worker)];
                 mine.band.trace_tile(
                     static_cast<int>(tile) % n_tiles_x,
                     y_begin / VolumeView::kTile + static_cast<int>(tile) / n_tiles_x, mine.tracer);
               });
}

/// Volume over surface over backdrop.
Color compose(const VolumePixel& pixel, const Vec3f& surface, const Color& backdrop) {
  if (pixel.beyond > 1 - 1e-5f) return backdrop;
  const float backdrop_share = pixel.beyond * (static_cast<float>(backdrop.a) * (1.0f / 255));
  const float alpha = 1 - pixel.beyond + backdrop_share;
  if (!(alpha > 0)) return backdrop;
  const Vec3f sum = pixel.light + surface * pixel.onto + to_linear(backdrop) * backdrop_share;
  return to_srgb(sum * (1 / alpha), alpha);
}

Result<Image> paint_volume(const VolumeScene& scene, const Painter* painter, Progress& progress) {
  const RenderOptions& options = scene.options;
  const auto width = static_cast<std::size_t>(options.width);
  Image image{.width = options.width, .height = options.height, .pixels = {}};
  image.pixels.resize(width * static_cast<std::size_t>(options.height));
  PixelRows rows(painter ? options.width : 0,
                 std::min(options.height, kPictureBandRows + 2 * kFilterRadius));
  std::vector<VolumePixel> pixels;
  int sampled = 0;
  for (int y0 = 0; y0 < options.height; y0 += kPictureBandRows) {
    const int y1 = std::min(y0 + kPictureBandRows, options.height);
    const int ahead = std::min(y1 + kFilterRadius, options.height);
    if (painter != nullptr) painter->sample_rows(rows, sampled, ahead, progress);
    sampled = ahead;
    pixels.resize(width * static_cast<std::size_t>(y1 - y0));
    trace_band(scene, y0, pixels, progress);
    if (progress.is_cancelled()) return cancelled_error();
    parallel_for(static_cast<std::size_t>(y1 - y0), options.threads, 4, [&](std::size_t i, int) {
      const int y = y0 + static_cast<int>(i);
      const Color backdrop = background_at(options, y);
      for (std::size_t x = 0; x < width; ++x) {
        const VolumePixel& pixel = pixels[i * width + x];
        const Vec3f surface = painter != nullptr && pixel.onto > 0
                                  ? painter->surface_light(rows, static_cast<int>(x), y,
                                                           std::max(0, y0 - kFilterRadius), ahead)
                                  : Vec3f{};
        image.pixels[static_cast<std::size_t>(y) * width + x] = compose(pixel, surface, backdrop);
      }
    });
    progress.report("rendering", static_cast<double>(y1) / options.height);
  }
  return image;
}

Box3d bounds_of(const MeshVolume& volume, const OpaqueSurface& opaque) {
  if (opaque.surface.is_empty()) return volume.bounds();
  const Box3d box = bounds_of(opaque.surface, volume.bounds());
  return volume.links().cells.empty() ? box : union_of(volume.bounds(), box);
}

}  // namespace

Result<Image> render_volume(const VolumePicture& picture, const RenderOptions& options,
                            Progress& progress) try {
  const auto& [volume, function, opaque, boundary_opacity] = picture;
  LODE_CHECK(check_render_options(options));
  LODE_CHECK(check_transfer_function(function));
  if (!(boundary_opacity >= 0 && boundary_opacity <= 1))
    return fail("boundary: expected an opacity from 0 to 1, got {}", boundary_opacity);
  const Box3d bounds = bounds_of(volume, opaque);
  LODE_CHECK(check_render_bounds(bounds));
  const Camera camera = options.camera
                            ? *options.camera
                            : default_camera(bounds, options.axes,
                                             static_cast<double>(options.width) / options.height);
  const Normalization normalization = normalization_of(bounds);
  const Lens lens(camera, normalization, options.width, options.height);
  const double line_radius = std::min(lens.pixel_size() * options.line_width_px / 2, 0.1);
  std::optional<RayScene> scene;
  if (!opaque.surface.is_empty()) {
    const SceneOptions scene_options{
        .normalization = normalization, .line_radius = line_radius, .threads = options.threads};
    LODE_TRY(scene, RayScene::build(opaque.surface, opaque.colors, scene_options, progress));
  }
  const double radius = 1.001 + line_radius;
  std::optional<Painter> painter;
  if (scene) painter.emplace(*scene, lens, radius, options);
  const LightRamps ramps(function);
  const VolumeView view(volume, ramps, lens, normalization, {options.width, options.height},
                        options.threads);
  const BoundaryFilm film{boundary_opacity, widened(to_linear(kFilmColor))};
  return paint_volume({view, ramps, lens, scene ? &*scene : nullptr, film, options, radius},
                      painter ? &*painter : nullptr, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("draw the picture");
}

}  // namespace lode
