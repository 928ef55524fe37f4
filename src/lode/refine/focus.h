#pragma once

// Where accuracy matters: the queries of Cignoni, De Floriani, Magillo, Puppo, Scopigno,
// "Selective Refinement Queries for Volume Visualization of Unstructured Tetrahedral Meshes"
// (2004), section 6, as small values. All touch more nodes as ranges and bounds widen.

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "lode/core/box.h"
#include "lode/refine/demand.h"

namespace lode {

/// Where an isosurface of one of the values may pass.
struct IsovalueFocus {
  std::vector<double> isovalues;
};
/// Where the field may have a value of one of the intervals.
struct IntervalFocus {
  std::vector<Range> intervals;
};
struct BoxFocus {
  Box3d box;
};
struct BallFocus {
  Ball ball;
};
/// Points x with dot(x - point, normal) >= 0.
struct HalfSpaceFocus {
  Vec3d point;
  Vec3d normal;  ///< Any length but zero.

  friend bool operator==(const HalfSpaceFocus&, const HalfSpaceFocus&) = default;
};
struct SectionFocus {
  Vec3d point;
  Vec3d normal;  ///< Any length but zero.

  friend bool operator==(const SectionFocus&, const SectionFocus&) = default;
};
/// Where an opacity function is above zero for some value of the range: piecewise linear between
/// control points, constant beyond them. Errors count as much as the range's largest opacity is of
/// all there is (the paper's transfer function error, in units of the tolerance): a tolerance holds
/// where the function is most opaque, and where it is half as opaque twice that.
struct OpacityFocus {
  struct Point {
    double value = 0;
    double opacity = 0;

    friend bool operator==(const Point&, const Point&) = default;
  };
  std::vector<Point> points;  ///< By ascending value.
};

/// What a perspective view shows and how large it shows it.
struct ViewFocus {
  struct Plane {
    Vec3d normal;  ///< Unit length; points out of the frustum.
    double offset = 0;
  };
  Vec3d eye;
  std::array<Plane, 5> planes;   ///< The four sides, and the one through the eye.
  double pixels_per_radian = 0;  ///< The picture's width over its angle of view.
  [[nodiscard]] bool shows(const Bounds& bounds) const;
  /// How large `length` appears at most, anywhere in the bounds; infinite if the eye may be there.
  [[nodiscard]] double pixels(double length, const Bounds& bounds) const;
};

using Focus = std::variant<IsovalueFocus, IntervalFocus, BoxFocus, BallFocus, HalfSpaceFocus,
                           SectionFocus, OpacityFocus, ViewFocus>;

[[nodiscard]] bool touches(const Focus& focus, const NodeFacts& node);

/// Which error a tolerance is about.
enum class ErrorUnit { field, world, pixels };

/// The built-in demand: the error above `inside` where all of the foci touch, above `outside`
/// elsewhere; an `outside` below `inside` holds inside, too. A tolerance of 0 refines whatever it
/// is about, even without error.
struct FocusDemand {
  std::vector<Focus> foci;  ///< Everywhere, if empty.
  double inside = 0;
  double outside = std::numeric_limits<double>::infinity();
  ErrorUnit unit = ErrorUnit::field;
  std::optional<ViewFocus> view{};  ///< For pixels: what they are measured in.
  /// Whatever the foci touch is refined where the data ends, last of all.
  bool ends_at_border = false;

  [[nodiscard]] double operator()(const NodeFacts& node) const;
  [[nodiscard]] bool touches(const NodeFacts& node) const;
  [[nodiscard]] Evaluation evaluate(const NodeFacts& node) const;
  [[nodiscard]] bool uses_bounds() const;
  /// The node's error in `unit`, as far as the foci touch it; 0 elsewhere.
  [[nodiscard]] double error(const NodeFacts& node) const;

 private:
  [[nodiscard]] double measure(const NodeFacts& node) const;
};

/// The same tolerance everywhere, in field units; 0 refines every node.
[[nodiscard]] Demand uniform_demand(double tolerance);
/// A tolerance where an isosurface may pass, nothing elsewhere; the surface ends exactly at the
/// border of the data.
[[nodiscard]] Demand isovalue_demand(double isovalue, double tolerance);

}  // namespace lode
