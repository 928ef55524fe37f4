#include "lode/api/focused_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/models/surface_cells.h"
#include "tests/oracles/analytic_fields.h"

namespace lode {
namespace {

using Triangle = std::array<Vec3f, 3>;

class focused_surface : public ::testing::Test {
 protected:
  static Dataset make(oracles::Field field, const Index3& dims) {
    const Volume volume = oracles::sample(field, dims);
    const auto source = make_memory_source(volume);
    Progress progress;
    return Dataset::build(*source, {}, progress).value();
  }
  static Query isosurface(std::optional<double> max_error) {
    Query query;
    query.isovalues = {1.0};
    query.max_error = max_error;
    return query;
  }
  FocusedReport extract(const FocusedOptions& options, Surface& surface) {
    const auto report = extract_focused(dataset_, options, surface, progress_);
    EXPECT_TRUE(report) << report.error().message;
    return *report;
  }
  Surface extract_everywhere(double max_error) {
    Surface surface;
    EXPECT_TRUE(dataset_.extract({.isovalues = {1.0}, .max_error = max_error}, surface, progress_));
    return surface;
  }
  /// Each edge belongs to two triangles, once in each direction, but for edges in the border.
  void expect_consistent(const Surface& surface) {
    const Box3d bounds = dataset_.describe().volume.grid.world_bounds();
    std::map<std::array<std::uint32_t, 2>, int> edges;
    for (const auto& t : surface.triangles)
      for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
    for (const auto& [edge, n] : edges) {
      ASSERT_EQ(n, 1);
      if (edges.contains({edge[1], edge[0]})) continue;
      bool is_in_border = false;
      for (std::size_t i = 0; i < 3; ++i)
        for (const double plane : {bounds.lower[i], bounds.upper[i]}) {
          const auto lies_in = [&](std::uint32_t v) {
            return std::abs(surface.world_position(v)[i] - plane) < 1e-5;
          };
          is_in_border = is_in_border || (lies_in(edge[0]) && lies_in(edge[1]));
        }
      ASSERT_TRUE(is_in_border);
    }
  }
  /// Seconds that pass only when somebody looks.
  static std::function<double()> step_clock() {
    return [n = 0.0]() mutable { return n += 1e-3; };
  }

  Dataset dataset_ = make(oracles::Field::gaussians40, {{65, 50, 41}});
  Progress progress_;
};

TEST_F(focused_surface, is_the_plain_one_without_a_focus) {
  Surface surface;
  const FocusedReport report = extract({.query = isosurface(0.02)}, surface);
  EXPECT_EQ(cells_of(surface), cells_of(extract_everywhere(0.02)));
  EXPECT_TRUE(report.standing.is_settled);
  EXPECT_LE(report.standing.error_bound, 0.02);
  EXPECT_EQ(surface.normals.size(), surface.positions.size());
}

TEST_F(focused_surface, is_consistent_at_any_deadline_and_gets_better) {
  dataset_ = make(oracles::Field::gyroid, {{40, 33, 29}});  // which meets the border everywhere
  double bound = std::numeric_limits<double>::infinity();
  std::size_t n_clipped = 0;
  for (double deadline = 0; deadline < 1.2; deadline = 2 * deadline + 0.004) {
    Surface surface;
    const FocusedReport report =
        extract({.query = isosurface(std::nullopt), .deadline_s = deadline, .clock = step_clock()},
                surface);
    EXPECT_LE(report.standing.error_bound, bound);
    bound = report.standing.error_bound;
    n_clipped += report.was_clipped ? 1 : 0;
    expect_consistent(surface);
  }
  EXPECT_GT(n_clipped, 0U);
}

TEST_F(focused_surface, repeats_an_answer_that_a_deadline_cut_short) {
  Surface first;
  Surface second;
  const FocusedOptions options{.query = isosurface(0.001), .deadline_s = 0.1};
  FocusedOptions with_clock = options;
  with_clock.clock = step_clock();
  const FocusedReport a = extract(with_clock, first);
  with_clock.clock = step_clock();
  const FocusedReport b = extract(with_clock, second);
  EXPECT_FALSE(a.standing.is_settled);
  EXPECT_EQ(a.standing.n_steps, b.standing.n_steps);
  EXPECT_EQ(cells_of(first), cells_of(second));
}

TEST_F(focused_surface, keeps_a_budget) {
  Query query = isosurface(std::nullopt);
  std::size_t n_last = 0;
  for (const std::uint64_t cells : {10U, 1000U, 20000U}) {
    query.budget.max_cells = cells;
    Surface surface;
    const FocusedReport report = extract({.query = query}, surface);
    EXPECT_EQ(report.standing.budget_met, report.standing.n_cells <= cells);
    EXPECT_GE(surface.triangles.size(), n_last);
    n_last = surface.triangles.size();
    expect_consistent(surface);
  }
}

TEST_F(focused_surface, is_exact_in_a_box_and_coarse_elsewhere) {
  Query query = isosurface(0.0);
  query.boxes = {{{{-0.4, -0.4, -0.4}}, {{0.2, 0.2, 0.2}}}};
  query.max_error_outside = 0.3;
  Surface surface;
  extract({.query = query}, surface);
  expect_consistent(surface);
  const Surface fine = extract_everywhere(0);
  EXPECT_LT(surface.triangles.size(), fine.triangles.size() / 2);
  const auto found = cells_of(surface);
  for (const Triangle& triangle : cells_of(fine)) {
    const bool is_inside = std::all_of(triangle.begin(), triangle.end(), [](const Vec3f& p) {
      return p[0] > -0.39F && p[0] < 0.19F && p[1] > -0.39F && p[1] < 0.19F && p[2] > -0.39F &&
             p[2] < 0.19F;
    });
    if (is_inside) ASSERT_TRUE(std::binary_search(found.begin(), found.end(), triangle));
  }
}

TEST_F(focused_surface, achieves_the_pixels_of_a_view) {
  Query query = isosurface(std::nullopt);
  query.view = View{{.eye = {{0, -5, 0}}, .target = {{0, 0, 0}}}, 640, 480};
  std::size_t n_last = static_cast<std::size_t>(-1);
  for (const double pixels : {0.5, 2.0, 10.0}) {
    query.max_error_px = pixels;
    Surface surface;
    const FocusedReport report = extract({.query = query}, surface);
    EXPECT_LE(report.achieved_px, pixels);
    EXPECT_LT(surface.triangles.size(), n_last);
    n_last = surface.triangles.size();
    expect_consistent(surface);
  }
}

TEST_F(focused_surface, has_nothing_to_refine_where_foci_exclude_each_other) {
  Query query = isosurface(0.0);
  query.boxes = {{{{50, 50, 50}}, {{60, 60, 60}}}};
  Surface surface;
  const FocusedReport report = extract({.query = query}, surface);
  EXPECT_EQ(report.standing.n_applied, 0U);
  EXPECT_TRUE(report.standing.is_settled);
}

TEST_F(focused_surface, refuses_what_it_cannot_answer) {
  Surface surface;
  EXPECT_FALSE(extract_focused(dataset_, {}, surface, progress_));
  FocusedOptions options{.query = isosurface(0.1), .deadline_s = -1};
  EXPECT_FALSE(extract_focused(dataset_, options, surface, progress_));
  options = {.query = isosurface(std::nullopt)};
  options.query.max_error_px = 1;
  EXPECT_FALSE(extract_focused(dataset_, options, surface, progress_));
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(extract_focused(dataset_, {.query = isosurface(0.1)}, surface, cancelled));
}

TEST_F(focused_surface, ends_where_oblique_data_ends) {
  Volume volume = oracles::sample(oracles::Field::gyroid, {{20, 19, 18}});
  RegularGrid& grid = volume.info.grid;
  const double c = std::sqrt(0.5);
  grid.direction = {{Vec3d{{c, -c, 0}}, Vec3d{{c, c, 0}}, Vec3d{{0, 0, -1}}}};  // and mirrored
  grid.origin = {{100, -50, 7}};
  const auto source = make_memory_source(volume);
  dataset_ = Dataset::build(*source, {}, progress_).value();
  for (const double deadline : {0.01, 0.05, 0.2}) {
    FocusedOptions options{
        .query = isosurface(std::nullopt), .deadline_s = deadline, .clock = step_clock()};
    options.query.isovalues = {oracles::usual_isovalue(oracles::Field::gyroid)};
    Surface surface;
    extract(options, surface);
    EXPECT_FALSE(surface.is_empty());
    for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
      const Vec3d index = grid.to_index(surface.world_position(v));
      for (std::size_t i = 0; i < 3; ++i) {
        ASSERT_GE(index[i], -1e-3);
        ASSERT_LE(index[i], grid.dims[i] - 1 + 1e-3);
      }
    }
  }
}

}  // namespace
}  // namespace lode
