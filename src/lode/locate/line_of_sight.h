#pragma once

#include <cstddef>
#include <span>

namespace lode {

/// A place of a profile that a line of sight runs over, in one unit of length.
struct SightPoint {
  double distance = 0;  ///< From the observer's place; rises, but at steps.
  double height = 0;
  double error = 0;     ///< Of the surface between here and the next point.
  double rounding = 0;  ///< Of the height.
  bool is_gap = false;  ///< No surface between here and the next point.
  /// The next point is at the same distance, on another surface: those that are meant keep the
  /// errors of both there.
  bool is_step = false;
};

struct SightOptions {
  double observer_height = 0;  ///< Above the surface at the first point; >= 0.
  double target_height = 0;    ///< At the last.
  double curvature = 0;        ///< Of the earth and the ray together, 1 / length: (1 - k) / R.
};

enum class SightVerdict : unsigned char { visible, blocked, undecided };

/// A place where the surface may stand above the ray: by at least `low`, at most `high`.
struct SightObstruction {
  std::size_t piece = 0;  ///< Between that point and the next.
  double distance = 0;
  double low = 0;
  double high = 0;
};

struct SightAnswer {
  SightVerdict verdict = SightVerdict::undecided;
  /// blocked: of the first piece where that is sure, where it is worst; else where the surface may
  /// come closest to the ray, or stand highest above it.
  SightObstruction worst;
  bool has_gap = false;  ///< Which alone keeps it from being visible.
};

/// Whether a surface lets two points see each other. The surface is any that is not farther from
/// the profile, linear between its points, than a piece's error (rounding included), also at the
/// ends, where both points stand on it. visible: no such surface is above the ray anywhere;
/// touching it is allowed. blocked: each one is above it somewhere. undecided: neither. The ray is
/// straight over an earth that falls by distance^2 curvature / 2. At least two points. O(points).
[[nodiscard]] SightAnswer find_sight(std::span<const SightPoint> points,
                                     const SightOptions& options);

}  // namespace lode
