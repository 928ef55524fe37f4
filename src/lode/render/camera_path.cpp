#include "lode/render/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "lode/render/camera_file.h"

namespace lode {
namespace {

/// Round the middle of a volume.
class PathFrame {
 public:
  PathFrame(const Box3d& bounds, std::optional<double> aspect)
      : centre_((bounds.lower + bounds.upper) * 0.5),
        diagonal_(length(bounds.upper - bounds.lower)) {
    const double half = (bounds.upper[2] - bounds.lower[2]) / 2;
    const double height = half > 0 ? half : diagonal_ / 4;  // a flat one has no height
    distance_ = aspect ? distance_to_all((bounds.upper - bounds.lower) * 0.5, *aspect)
                       : height / half_slope() + height;
  }

  /// Looking at the middle from `distance`, a little above the horizon.
  [[nodiscard]] Camera at(double angle_deg, double distance) const {
    const double a = angle_deg * std::numbers::pi / 180;
    const Vec3d outward = normalized(Vec3d{{std::sin(a), -std::cos(a), kRise}});
    return {.eye = centre_ + outward * distance,
            .target = centre_,
            .field_of_view_deg = kFieldOfViewDeg};
  }
  [[nodiscard]] double diagonal() const { return diagonal_; }
  [[nodiscard]] double distance() const { return distance_; }

 private:
  static constexpr double kFieldOfViewDeg = 30;
  static constexpr double kRise = 0.2;

  [[nodiscard]] static double half_slope() {
    return std::tan(kFieldOfViewDeg / 2 * std::numbers::pi / 180);
  }
  /// From where a box is in sight with a small margin, wherever it is turned: with the rims of the
  /// cylinder round it. `half`: its sides'.
  [[nodiscard]] static double distance_to_all(const Vec3d& half, double aspect) {
    constexpr double kSlack = 1.05;
    const Vec3d back = normalized(Vec3d{{0, -1, kRise}});  // and up is {0, kRise, 1}, likewise
    const double radius = std::hypot(half[0], half[1]);
    double distance = 0;
    for (int degree = 0; degree < 360; ++degree) {
      const double a = degree * std::numbers::pi / 180;
      for (const double z : {-half[2], half[2]}) {
        const Vec3d rim{{radius * std::cos(a), radius * std::sin(a), z}};
        const double up = rim[1] * back[2] - rim[2] * back[1];
        const double slope = std::max(std::abs(rim[0]) / aspect, std::abs(up));
        distance = std::max(distance, slope / half_slope() + dot(rim, back));
      }
    }
    return distance > 0 ? kSlack * distance : 1;  // round a point
  }

  Vec3d centre_;
  double diagonal_;
  double distance_ = 0;
};

}  // namespace

std::vector<Camera> orbit_path(const Box3d& bounds, std::optional<double> aspect) {
  const PathFrame frame(bounds, aspect);
  std::vector<Camera> cameras;
  cameras.reserve(360);
  for (int i = 0; i < 360; ++i) cameras.push_back(frame.at(i, frame.distance()));
  return cameras;
}

std::vector<Camera> fly_in_path(const Box3d& bounds, std::optional<double> aspect) {
  constexpr int kFrames = 200;
  const PathFrame frame(bounds, aspect);
  std::vector<Camera> cameras;
  cameras.reserve(kFrames);
  for (int i = 0; i < kFrames; ++i) {
    const double t = static_cast<double>(i) / (kFrames - 1);
    cameras.push_back(frame.at(0, (1 - t) * frame.distance() + t * frame.diagonal() / 2));
  }
  return cameras;
}

std::vector<Camera> jump_path(const Box3d& bounds, std::optional<double> aspect) {
  const PathFrame frame(bounds, aspect);
  std::mt19937 random(1);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() % 100001) / 100000;
  };
  std::vector<Camera> cameras;
  cameras.reserve(100);
  for (int i = 0; i < 100; ++i) {
    const double angle = uniform(0, 360);
    cameras.push_back(frame.at(angle, uniform(frame.diagonal() / 4, 1.5 * frame.distance())));
  }
  return cameras;
}

Result<std::vector<Camera>> camera_path(const std::string& name_or_file, const Box3d& bounds,
                                        std::optional<double> aspect) {
  if (name_or_file == "orbit") return orbit_path(bounds, aspect);
  if (name_or_file == "fly-in") return fly_in_path(bounds, aspect);
  if (name_or_file == "jump") return jump_path(bounds, aspect);
  return read_cameras(name_or_file);
}

}  // namespace lode
