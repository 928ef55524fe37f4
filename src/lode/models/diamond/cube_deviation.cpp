#include "lode/models/diamond/cube_deviation.h"

#include <bit>
#include <span>
#include <vector>

#include "lode/models/diamond/cell_rows.h"
#include "lode/models/diamond/model_samples.h"

namespace lode::diamond {

namespace {

/// Calls visit(cell, worker) in parallel for cells of full resolution that F = isovalue meets, in
/// the rows that takes(y, z) does. Of a model without holes.
template <typename Takes, typename Visit>
Result<void> for_each_met_cell(const Model<3>& model, double isovalue, Threads threads,
                               const Takes& takes, const Visit& visit, Progress& progress) {
  const Selection<3> selection(model, isovalue, 0);
  std::uint64_t n_read = 0;
  const SignField signs = sign_field(selection, threads, n_read);
  parallel_for(as_size(signs.dims[2] - 1), threads, 1, [&](std::size_t slice, int worker) {
    const auto z = static_cast<std::int32_t>(slice);
    RowGroups groups(signs);
    constexpr auto kRows = static_cast<std::int32_t>(SignField::kRows);
    for (std::int32_t y = 0; y + 1 < signs.dims[1] && !progress.is_cancelled(); ++y) {
      if (y % kRows == 0) find_words(signs, y, z, SurfaceStyle::cubes, groups);
      if (!takes(y, z)) continue;
      for (const WordGroup& group : groups.of_row(as_size(y % kRows)))
        for (std::size_t i = 0; i < WordGroup::kWords; ++i) {
          if ((group.met >> i & 1) == 0) continue;
          for (std::uint32_t cells = group.cells[i]; cells != 0; cells &= cells - 1) {
            const auto x = 32 * (group.first + i) + as_size(std::countr_zero(cells));
            visit(Index3{{static_cast<std::int32_t>(x), y, z}}, as_size(worker));
          }
        }
    }
  });
  if (progress.is_cancelled()) return cancelled_error();
  return {};
}

std::vector<CubeMeter> meters_of(const Model<3>& model, const IsosurfaceQuery& query) {
  return std::vector<CubeMeter>(as_size(n_workers(query.threads)),
                                CubeMeter(LatticeFrame::of(model.info.grid), query.isovalue));
}

}  // namespace

Result<CubeDeviation> measure_cubes(const Model<3>& model, const IsosurfaceQuery& query,
                                    Progress& progress) {
  const ModelSamples<3> samples(model);
  std::vector<CubeMeter> meters = meters_of(model, query);
  LODE_CHECK(for_each_met_cell(
      model, query.isovalue, query.threads, [](std::int32_t, std::int32_t) { return true; },
      [&](const Index3& cell, std::size_t worker) { meters[worker].add(samples, cell); },
      progress));
  CubeDeviation deviation;
  for (const CubeMeter& meter : meters) deviation.join(meter.deviation());
  return deviation;
}

Result<double> share_of_cubes(const Model<3>& model, const IsosurfaceQuery& query,
                              Progress& progress) {
  struct Count {
    std::uint64_t n_met = 0;
    std::uint64_t n_cubes = 0;
  };
  const ModelSamples<3> samples(model);
  std::vector<CubeMeter> meters = meters_of(model, query);
  std::vector<Count> counts(meters.size());
  LODE_CHECK(for_each_met_cell(
      model, query.isovalue, query.threads,
      [](std::int32_t y, std::int32_t z) { return y % 4 == 1 && z % 4 == 2; },
      [&](const Index3& cell, std::size_t worker) {
        ++counts[worker].n_met;
        if (!meters[worker].exceeds(samples, cell, query.style_limit())) ++counts[worker].n_cubes;
      },
      progress));
  Count all;
  for (const Count& count : counts) {
    all.n_met += count.n_met;
    all.n_cubes += count.n_cubes;
  }
  return all.n_met == 0 ? 1 : static_cast<double>(all.n_cubes) / static_cast<double>(all.n_met);
}

}  // namespace lode::diamond
