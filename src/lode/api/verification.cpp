#include "lode/api/verification.h"

#include <atomic>

#include "lode/mappers/lattice_frame.h"
#include "lode/mappers/surface_checks.h"
#include "lode/models/diamond/boundary_check.h"
#include "lode/models/diamond/cube_plan.h"
#include "lode/models/diamond/level_set_check.h"
#include "lode/models/diamond/model_samples.h"

namespace lode {
namespace {

using diamond::as_size;
using diamond::Diamond;
using diamond::Index;
using diamond::Model;

void add(VerifyReport& report, std::string name, std::uint64_t count, std::uint64_t failures,
         std::string detail) {
  report.checks.push_back({std::move(name), count, failures == 0, std::move(detail)});
}

template <int D>
Result<void> check_same_samples(const Model<D>& model, VolumeSource& original,
                                VerifyReport& report) {
  const RegularGrid& grid = model.info.grid;
  if (original.info().grid.dims != grid.dims)
    return fail("expected an original of {} x {} x {} samples, got {} x {} x {}", grid.dims[0],
                grid.dims[1], grid.dims[2], original.info().grid.dims[0],
                original.info().grid.dims[1], original.info().grid.dims[2]);
  LODE_TRY(const Volume volume, read_all(original));
  const diamond::VolumeSamples theirs(volume);
  const diamond::ModelSamples<D> ours(model);
  std::uint64_t n_different = 0;
  Index3 p;
  for (p[2] = 0; p[2] < grid.dims[2]; ++p[2])
    for (p[1] = 0; p[1] < grid.dims[1]; ++p[1])
      for (p[0] = 0; p[0] < grid.dims[0]; ++p[0]) {
        const double a = theirs.sample(p);
        const double b = ours.sample(p);
        n_different += a == b || (!std::isfinite(a) && !std::isfinite(b)) ? 0 : 1;
      }
  add(report, "samples equal the original's", static_cast<std::uint64_t>(grid.n_samples()),
      n_different, fmt::format("{} differ", n_different));
  return {};
}

/// The largest |F - F'| over one node's domain, sample by sample; NaN samples do not count.
template <int D>
double own_error(const Model<D>& model, const Diamond<D>& d) {
  const std::int32_t side = 2 * d.h();
  double largest = 0;
  for (int code = 0; code < (1 << d.tier); ++code) {
    Index<D> lower;  // of one of the cubes that share the node
    for (int i = 0, bit = 0; i < D; ++i) {
      const std::int32_t c = d.centre[as_size(i)];
      lower[as_size(i)] = d.is_odd(i) ? c - d.h() : c - (((code >> bit++) & 1) != 0 ? 0 : side);
    }
    bool exists = true;
    for (std::size_t i = 0; i < as_size(D); ++i)
      exists = exists && lower[i] >= 0 && lower[i] < model.shape.dims[i] - 1;
    if (!exists) continue;
    Index<D> even;
    Index<D> sign;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      sign[i] = ((lower[i] / side) & 1) != 0 ? -1 : 1;
      even[i] = sign[i] < 0 ? lower[i] + side : lower[i];
    }
    Index<D> dims;
    for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = side + 1;
    for (std::size_t n = 0; n < diamond::n_points<D>(dims); ++n) {
      const Index<D> u = diamond::point_of<D>(dims, n);
      Index<D> p;
      for (std::size_t i = 0; i < as_size(D); ++i) p[i] = even[i] + sign[i] * u[i];
      if (!model.shape.is_sample(p)) continue;
      const auto nodes = diamond::nodes_containing<D>(u, side, d.tier);
      bool is_inside = false;
      for (Index<D> node : nodes) {
        for (std::size_t i = 0; i < as_size(D); ++i) node[i] = even[i] + sign[i] * node[i];
        is_inside = is_inside || node == d.centre;
      }
      if (!is_inside) continue;
      const double f = model.value(p);
      if (model.has_holes() && model.is_hole(f)) continue;
      const double g = diamond::interpolant_at<D>(u, side, d.tier, [&](const Index<D>& v) {
        Index<D> q;
        for (std::size_t i = 0; i < as_size(D); ++i) q[i] = even[i] + sign[i] * v[i];
        const double value = model.value(q);
        return model.has_holes() && model.is_hole(value) ? std::numeric_limits<double>::quiet_NaN()
                                                         : value;
      });
      const double e = std::abs(f - g);
      if (!std::isnan(e)) largest = std::max(largest, e);
    }
  }
  return largest;
}

template <int D>
void check_own_errors(const Model<D>& model, Threads threads, Progress& progress,
                      VerifyReport& report) {
  std::atomic<std::uint64_t> n_nodes{0};
  std::atomic<std::uint64_t> n_wrong{0};
  for (int level = 1; level < model.shape.n_levels; ++level) {
    const auto dims = model.shape.grid_dims(level);
    const diamond::NodeLevel& nodes = model.levels[as_size(level)];
    parallel_for(nodes.error.size(), threads, 64, [&](std::size_t i, int) {
      if (progress.is_cancelled()) return;
      const Index<D> q = diamond::point_of<D>(dims, i);
      std::int32_t odd = 0;
      for (std::size_t a = 0; a < as_size(D); ++a) odd |= q[a];
      if ((odd & 1) == 0) return;
      ++n_nodes;
      const double own =
          own_error<D>(model, diamond::diamond_at<D>(q * (std::int32_t{1} << level)));
      if (own > static_cast<double>(diamond::decode_error(nodes.error[i]))) ++n_wrong;
    });
    progress.report("errors", static_cast<double>(level) / model.shape.n_levels);
  }
  add(report, "own error <= stored error", n_nodes, n_wrong,
      fmt::format("{} nodes claim too little", n_wrong.load()));
}

template <int D>
void check_nesting(const Model<D>& model, VerifyReport& report) {
  std::uint64_t n_pairs = 0;
  std::uint64_t n_wrong = 0;
  for (int level = 1; level < model.shape.n_levels; ++level) {
    const auto dims = model.shape.grid_dims(level);
    const diamond::NodeLevel& nodes = model.levels[as_size(level)];
    for (std::size_t i = 0; i < nodes.error.size(); ++i) {
      const Index<D> q = diamond::point_of<D>(dims, i);
      std::int32_t odd = 0;
      for (std::size_t a = 0; a < as_size(D); ++a) odd |= q[a];
      if ((odd & 1) == 0) continue;
      const auto d = diamond::diamond_at<D>(q * (std::int32_t{1} << level));
      for (const Index<D>& child : diamond::children<D>(d)) {
        const auto c = diamond::diamond_at<D>(child);
        if (c.level == 0) continue;
        Index<D> at;
        const auto child_dims = model.shape.grid_dims(c.level);
        bool exists = true;
        for (std::size_t a = 0; a < as_size(D); ++a) {
          at[a] = child[a] >> c.level;
          exists = exists && at[a] >= 0 && at[a] < child_dims[a];
        }
        if (!exists) continue;
        const std::size_t j = diamond::linear_index<D>(child_dims, at);
        const diamond::NodeLevel& below = model.levels[as_size(c.level)];
        ++n_pairs;
        const bool is_nested = below.error[j] <= nodes.error[i] &&
                               (below.low[j] > below.high[j] ||
                                (below.low[j] >= nodes.low[i] && below.high[j] <= nodes.high[i]));
        n_wrong += is_nested ? 0 : 1;
      }
    }
  }
  add(report, "errors and ranges are nested", n_pairs, n_wrong,
      fmt::format("{} children exceed a parent", n_wrong));
}

void add_topology(const Surface& surface, Threads threads, VerifyReport& report) {
  const TopologyReport t = check_topology(surface, {.may_pinch = {}, .threads = threads});
  add(report, "manifold edges", t.n_edges, t.non_manifold_edges.count,
      fmt::format("{} bad", t.non_manifold_edges.count));
  add(report, "consistent orientation", t.n_edges, t.inconsistent_edges.count,
      fmt::format("{} bad", t.inconsistent_edges.count));
  add(report, "manifold vertices", t.n_used_vertices, t.non_manifold_vertices.count,
      fmt::format("{} bad", t.non_manifold_vertices.count));
  add(report, "no degenerate cell", t.n_simplices, t.degenerate_simplices.count,
      fmt::format("{} bad", t.degenerate_simplices.count));
  add(report, "no duplicate vertex", t.n_used_vertices, t.duplicate_vertices.count,
      fmt::format("{} duplicates, {} hole twins", t.duplicate_vertices.count, t.n_twins));
}

}  // namespace

template <int D>
Result<VerifyReport> verify_model_against(const Model<D>& model, VolumeSource& original,
                                          Threads threads, Progress& progress) {
  VerifyReport report;
  LODE_CHECK(check_same_samples<D>(model, original, report));
  if (model.shape.has_cells()) {
    check_own_errors<D>(model, threads, progress, report);
    check_nesting<D>(model, report);
  }
  if (progress.is_cancelled()) return cancelled_error();
  return report;
}

template <int D>
Result<VerifyReport> verify_model_surface(const Model<D>& model, const Surface& surface,
                                          const ExtractOptions& options, double tolerance,
                                          Progress& progress) {
  VerifyReport report;
  LODE_CHECK(check_well_formed(surface));
  add_topology(surface, options.threads, report);
  LODE_TRY(const auto crossings, check_self_intersections(surface, options.threads, progress));
  add(report, "no self-intersection", crossings.n_candidates, crossings.n_intersections,
      fmt::format("{} pairs meet", crossings.n_intersections));
  const diamond::ModelSamples<D> samples(model);
  const LatticeFrame frame = LatticeFrame::of(model.info.grid);
  const double range = model.stats.max - model.stats.min;
  const double slack = (2 * frame.margin + 4 * frame.rounding) * range;
  LODE_TRY(const auto level_set, diamond::check_level_set(samples, surface,
                                                          {.isovalues = options.isovalues,
                                                           .tolerance = tolerance + slack,
                                                           .clip = options.clip,
                                                           .threads = options.threads},
                                                          progress));
  add(report, "|F - isovalue| <= tolerance + slack", level_set.n_pieces, level_set.holds() ? 0 : 1,
      fmt::format("largest {} of {} + {}", level_set.max_deviation, tolerance, slack));
  LODE_TRY(const auto boundary,
           diamond::check_boundary(samples, surface,
                                   {.clip = options.clip, .threads = options.threads}, progress));
  add(report, "ends only at the border, holes and clip planes", boundary.n_edges, boundary.n_stray,
      fmt::format("{} stray edges", boundary.n_stray));
  return report;
}

template Result<VerifyReport> verify_model_against<2>(const Model<2>&, VolumeSource&, Threads,
                                                      Progress&);
template Result<VerifyReport> verify_model_against<3>(const Model<3>&, VolumeSource&, Threads,
                                                      Progress&);
template Result<VerifyReport> verify_model_surface<2>(const Model<2>&, const Surface&,
                                                      const ExtractOptions&, double, Progress&);
template Result<VerifyReport> verify_model_surface<3>(const Model<3>&, const Surface&,
                                                      const ExtractOptions&, double, Progress&);

}  // namespace lode
