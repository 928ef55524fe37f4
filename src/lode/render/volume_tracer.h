#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/render/face_meeting.h"
#include "lode/render/light_integral.h"
#include "lode/render/ray_lanes.h"
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

/// The boundary of a mesh as a film: what passes straight through it is 1 - opacity, less where it
/// is met aslant, so that outlines show.
struct BoundaryFilm {
  double opacity = 0;  ///< 0 (none) .. 1.
  Vec3d color;         ///< Linear light.
};

/// Sends rays through a volume, many side by side. Has scratch memory: one for each
/// thread.
class VolumeTracer {
 public:
  /// `view` and `ramps` must outlive it.
  VolumeTracer(const VolumeView& view, const LightRamps& ramps, const BoundaryFilm& film = {})
      : view_(view), ramps_(ramps), film_(film) {}

  /// `rays`: at most RayLanes::kCapacity, all through one tile of the view or at most kTileMargin
  /// from it. Every ray has the same light whatever its company. `light` has as many elements.
  void trace(int tile_x, int tile_y, std::span<const VolumeRay> rays, std::span<RayLight> light);

 private:
  /// An outer face that a ray meets.
  struct Hit {
    double depth;
    std::uint32_t face;
  };
  /// What of a ray on its way is not in its lane.
  struct Traveller {
    std::size_t ray;  ///< Its place among those given.
    std::size_t next_hit;
    std::size_t end_hit;
    Vec3d light;
    const LightRamp* ramp;
  };
  void find_hits(int tile_x, int tile_y, const VolumeRay& ray, const SightLine& line);
  void start_ray(std::size_t lane, const VolumeRay& ray, const SightLine& line);
  bool start_walk(std::size_t lane);
  void mark_left(std::size_t lane, std::uint32_t face);
  void add_film(std::size_t lane, std::uint32_t face, double depth);
  void set_integral(std::size_t lane, const LightIntegral& integral);
  [[nodiscard]] LightIntegral integral_of(std::size_t lane) const;
  void add_segment(std::size_t lane);
  bool continue_ray(std::size_t lane);
  void move_lane(std::size_t from, std::size_t to);

  const VolumeView& view_;
  const LightRamps& ramps_;
  BoundaryFilm film_;
  std::vector<Hit> hits_;
  RayLanes lanes_{};
  std::array<Traveller, RayLanes::kCapacity> travellers_{};
};

}  // namespace lode
