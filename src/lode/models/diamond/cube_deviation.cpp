#include "lode/models/diamond/cube_deviation.h"

#include <bit>
#include <span>
#include <vector>

#include "lode/models/diamond/cell_rows.h"
#include "lode/models/diamond/model_samples.h"

namespace lode::diamond {

Result<CubeDeviation> measure_cubes(const Model<3>& model, const IsosurfaceQuery& query,
                                    Progress& progress) {
  const LatticeFrame frame = LatticeFrame::of(model.info.grid);
  const Selection<3> selection(model, query.isovalue, 0);
  std::uint64_t n_read = 0;
  const SignField signs = sign_field(selection, query.threads, n_read);
  const ModelSamples<3> samples(model);
  std::vector<CubeMeter> meters(as_size(n_workers(query.threads)),
                                CubeMeter(frame, query.isovalue));
  parallel_for(as_size(signs.dims[2] - 1), query.threads, 1, [&](std::size_t z, int worker) {
    std::vector<WordGroup> groups(signs.n_words() / WordGroup::kWords + 1);
    for (std::int32_t y = 0; y + 1 < signs.dims[1] && !progress.is_cancelled(); ++y) {
      if (!signs.may_cross(y, static_cast<std::int32_t>(z))) continue;
      const CellRow row(signs, y, static_cast<std::int32_t>(z));
      const std::size_t n = find_words(row, SurfaceStyle::cubes, groups.data());
      for (const WordGroup& group : std::span(groups).first(n))
        for (std::size_t i = 0; i < WordGroup::kWords; ++i) {
          if ((group.met >> i & 1) == 0) continue;
          for (std::uint32_t cells = group.cells[i]; cells != 0; cells &= cells - 1) {
            const auto x = 32 * (group.first + i) + as_size(std::countr_zero(cells));
            meters[as_size(worker)].add(
                samples, {{static_cast<std::int32_t>(x), y, static_cast<std::int32_t>(z)}});
          }
        }
    }
  });
  if (progress.is_cancelled()) return cancelled_error();
  CubeDeviation deviation;
  for (const CubeMeter& meter : meters) deviation.join(meter.deviation());
  return deviation;
}

}  // namespace lode::diamond
