#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/render/cell_walk.h"
#include "lode/render/light_integral.h"
#include "lode/render/volume_view.h"

namespace lode {

/// A ray from the eye through a point of the picture (pixels), to where something opaque stands.
struct VolumeRay {
  double x = 0;
  double y = 0;
  double end_depth = 1e300;  ///< Normalised, along the camera's forward axis from the centre 0.
};

/// What comes along a ray.
struct RayLight {
  Vec3d light;               ///< Linear, what the volume adds.
  double transmittance = 1;  ///< How much of the light from behind passes.
};

/// Sends rays through a volume, many side by side so that they need not wait for memory. Has
/// scratch memory: one for each thread.
class VolumeTracer {
 public:
  /// Both must outlive it.
  VolumeTracer(const VolumeView& view, const LightRamps& ramps) : view_(view), ramps_(ramps) {}

  /// `rays`: all through one tile of the view or at most kTileMargin from it. Every ray has the
  /// same light whatever its company. `light` has as many elements.
  void trace(int tile_x, int tile_y, std::span<const VolumeRay> rays, std::span<RayLight> light);

 private:
  /// An outer face that a ray meets.
  struct Hit {
    double depth;
    std::uint32_t face;
  };
  struct Walker {
    CellWalk walk;
    LightIntegral integral;
    SightLine line;
    double world_per_depth;
    double begin;
    double end;
    double depth;  ///< The largest so far.
    double level;
    std::size_t ray;
    std::size_t next_hit;
    std::size_t end_hit;
  };
  void find_hits(int tile_x, int tile_y, const VolumeRay& ray, Walker& walker);
  [[gnu::noinline]] bool start_walk(Walker& walker);
  bool advance(Walker& walker);
  void advance_all(std::span<RayLight> light);
  void add_segment(Walker& walker);
  [[gnu::noinline]] void add_clipped(Walker& walker, double from, double level, double to,
                                     double to_level);
  [[gnu::noinline]] void leave(Walker& walker);

  const VolumeView& view_;
  const LightRamps& ramps_;
  std::vector<Hit> hits_;
  std::vector<Walker> walkers_;
};

}  // namespace lode
