#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "lode/core/result.h"
#include "lode/refine/budget.h"
#include "lode/refine/focus.h"
#include "lode/render/camera.h"

namespace lode {

/// A picture through a camera.
struct View {
  Camera camera;
  int width = 1920;  ///< Pixels.
  int height = 1080;

  friend bool operator==(const View&, const View&) = default;
};

/// Where accuracy matters, how much of it, and how large the answer may be. Values (isovalues,
/// intervals, opacity) are joined, and so are regions (box, ball, half-space, section); accuracy
/// matters where a value may occur in a region, in sight of the view. Without values all do,
/// without regions everywhere does.
struct Query {
  std::vector<double> isovalues;
  std::vector<Range> field_ranges;
  std::vector<OpacityFocus::Point> opacity;  ///< By ascending value.

  std::vector<Box3d> boxes;
  std::vector<Ball> balls;
  std::vector<HalfSpaceFocus> half_spaces;
  std::vector<SectionFocus> sections;
  std::optional<View> view;

  std::optional<double> max_error;     ///< Field units.
  std::optional<double> max_error_px;  ///< Of the world error, an estimate; needs a view.
  /// Of the world error itself, in world units: of meshes of tetrahedra that know it.
  std::optional<double> max_world_error;
  /// Where regions or the view exclude a value, in the unit of the tolerance, of several of the
  /// first there is; unset: anything.
  std::optional<double> max_error_outside;

  Budget budget;
};

/// Refuses what has no answer: numbers that are not finite or negative, empty boxes, no tolerance,
/// pixels without a view.
[[nodiscard]] Result<void> check_query(const Query& query);

/// The demand of a checked query.
[[nodiscard]] Demand to_demand(const Query& query);

/// Their largest error() says how large a node's world error appears in the query's view, as far as
/// it is in sight and focus.
[[nodiscard]] std::vector<FocusDemand> pixel_measures(const Query& query);

/// Whether candidates found for `a` serve `b`: they differ in view, tolerance or budget only.
[[nodiscard]] FocusChange focus_change(const Query& a, const Query& b);

/// What a camera shows in a picture of this size.
[[nodiscard]] ViewFocus to_view_focus(const View& view);

}  // namespace lode
