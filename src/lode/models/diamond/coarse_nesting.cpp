#include "lode/models/diamond/coarse_nesting.h"

#include "lode/models/diamond/block_checks.h"
#include "lode/models/diamond/encode_blocks.h"
#include "lode/models/diamond/nesting_pass.h"
#include "lode/models/diamond/world_pass.h"

namespace lode::diamond {
namespace {

template <int D>
void nest_coarse_worlds(CoarseField<D>& field, Threads threads) {
  const double slack = rounding_slack<D>(field);
  for (int level = kKeptLevel; level < field.shape.n_levels; ++level) {
    const auto& own = level == kKeptLevel ? field.finest_own : field.levels[as_size(level)].error;
    visit_held_type<D>(field, [&]<typename V>() {
      raise_to_own_worlds<D, typename SampleScale<D, V>::C>(field, level, own, slack, threads,
                                                            field.worlds[as_size(level)]);
    });
  }
  nest_worlds<D>(field.shape, kKeptLevel, field.shape.n_levels, threads, field.worlds);
}

}  // namespace

template <int D>
void nest_coarse(CoarseField<D>& field, Threads threads) {
  nest_coarse_worlds<D>(field, threads);
  NestingPass<D, CoarseField<D>>(field, kKeptLevel, field.shape.n_levels, threads).run();
  round_ranges<D, CoarseField<D>>(field, field.levels, kKeptLevel, threads);
}

template <int D>
Summary summarize(const CoarseField<D>& field, const PartBuilder<D>& builder) {
  Summary summary{.stats = field.stats, .base_error = 0, .max_errors = {}};
  for (const ErrorCode largest : builder.largest_errors())
    summary.max_errors.push_back(static_cast<double>(decode_error(largest)));
  for (int level = kKeptLevel; level < field.shape.n_levels; ++level)
    summary.max_errors.push_back(largest_error(field.levels[as_size(level)]));
  summary.base_error = field.is_needed() ? field.base_error() : builder.base_error();
  return summary;
}

template void nest_coarse<2>(CoarseField<2>&, Threads);
template void nest_coarse<3>(CoarseField<3>&, Threads);
template Summary summarize<2>(const CoarseField<2>&, const PartBuilder<2>&);
template Summary summarize<3>(const CoarseField<3>&, const PartBuilder<3>&);

}  // namespace lode::diamond
