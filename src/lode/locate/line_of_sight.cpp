#include "lode/locate/line_of_sight.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lode/core/expects.h"

namespace lode {
namespace {

/// How far a surface stands above the ray over a piece of the way: linear between its ends, plus
/// the bulge of the earth between them.
struct Stand {
  double begin;
  double end;

  struct Highest {
    double value;
    double share;  ///< Of the piece.
  };
  /// `bulge`: length^2 curvature / 2. The largest of a parabola s -> begin + s (end - begin) +
  /// s (1 - s) bulge on [0, 1].
  [[nodiscard]] Highest highest(double bulge) const {
    const double rise = end - begin;
    if (std::abs(rise) >= bulge) return rise > 0 ? Highest{end, 1} : Highest{begin, 0};
    const double share = 0.5 + rise / (2 * bulge);
    return {begin + share * (rise + (1 - share) * bulge), share};
  }
};

class SightFinder {
 public:
  SightFinder(std::span<const SightPoint> points, const SightOptions& options)
      : points_(points),
        options_(options),
        length_(points.back().distance),
        first_error_(points.front().error),
        last_error_(points[points.size() - 2].error) {}

  [[nodiscard]] SightAnswer run() const {
    SightAnswer answer;
    std::optional<SightObstruction> worst;
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      if (points_[i].is_gap) {
        answer.has_gap = true;
        continue;
      }
      if (points_[i].is_step) continue;
      const SightObstruction here = obstruction(i);
      if (here.low > 0) return {SightVerdict::blocked, here, answer.has_gap};
      if (!worst || here.high > worst->high) worst = here;
    }
    if (worst) answer.worst = *worst;
    if (worst && worst->high <= 0 && !answer.has_gap) answer.verdict = SightVerdict::visible;
    return answer;
  }

 private:
  [[nodiscard]] double drop(double distance) const {
    return distance * distance * options_.curvature / 2;
  }
  /// sign 1: the highest that a surface of the piece may stand above the lowest ray; -1: the
  /// lowest above the highest. At the ends, where the ray starts on the surface, heights cancel.
  [[nodiscard]] double stand_at(std::size_t point, std::size_t piece, double sign) const {
    const double error = points_[piece].error;
    if (point == 0) return sign * (error + first_error_) - options_.observer_height;
    if (point + 1 == points_.size()) return sign * (error + last_error_) - options_.target_height;
    const SightPoint& at = points_[point];
    const double share = at.distance / length_;
    const double from = points_.front().height + options_.observer_height - sign * first_error_;
    const double to =
        points_.back().height - drop(length_) + options_.target_height - sign * last_error_;
    const double ray = from + share * (to - from);
    // Some ten roundings of terms that are no larger.
    const double size = std::abs(from) + std::abs(to) + std::abs(at.height) + drop(length_);
    const double rounding =
        at.rounding + points_.front().rounding + points_.back().rounding + 16 * 0x1p-53 * size;
    return at.height - drop(at.distance) + sign * error - ray + sign * rounding;
  }
  [[nodiscard]] SightObstruction obstruction(std::size_t piece) const {
    const double begin = points_[piece].distance;
    const double run = points_[piece + 1].distance - begin;
    const Stand high{stand_at(piece, piece, 1), stand_at(piece + 1, piece, 1)};
    const Stand low{stand_at(piece, piece, -1), stand_at(piece + 1, piece, -1)};
    const Stand::Highest highest = high.highest(drop(run));
    const Stand::Highest surest = low.highest(drop(run));
    const double share = surest.value > 0 ? surest.share : highest.share;
    return {piece, begin + share * run, surest.value, highest.value};
  }

  std::span<const SightPoint> points_;
  SightOptions options_;
  double length_;
  double first_error_;
  double last_error_;
};

}  // namespace

SightAnswer find_sight(std::span<const SightPoint> points, const SightOptions& options) {
  LODE_EXPECTS(points.size() >= 2 && points.back().distance > points.front().distance);
  return SightFinder(points, options).run();
}

}  // namespace lode
