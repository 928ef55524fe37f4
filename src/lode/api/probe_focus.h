#pragma once

#include <functional>
#include <span>

#include "lode/core/box.h"
#include "lode/refine/demand.h"

namespace lode {

/// Whether what is probed is in a box, or so near that rounding may say so. Safe from many threads.
using MeetsBox = std::function<bool(const Box3d&)>;

[[nodiscard]] MeetsBox meets_points(std::span<const Vec3d> points);
/// The line between two points.
[[nodiscard]] MeetsBox meets_segment(const Vec3d& a, const Vec3d& b);
[[nodiscard]] MeetsBox meets_box(const Box3d& box);
[[nodiscard]] MeetsBox meets_all();
/// The same of what is up to `reach` away along each axis.
[[nodiscard]] MeetsBox widened(MeetsBox where, double reach);

/// From the origin to the box's farthest corner.
[[nodiscard]] double farthest_corner(const Box3d& domain);
/// Of distances from cells in a domain, and what these are reckoned of.
[[nodiscard]] double distance_rounding(const Box3d& domain);

/// What rounding may do to the bounds of nodes in a domain, which are given as middles and halves.
[[nodiscard]] double bounds_slack(const Box3d& domain);
/// The box of a node's bounds, wider by the slack.
[[nodiscard]] Box3d box_of(const Bounds& bounds, double slack);

/// What is refined to probe: whatever may be where, above the tolerance; all of it for one of 0.
[[nodiscard]] Demand probe_demand(MeetsBox where, double max_error, double slack);

}  // namespace lode
