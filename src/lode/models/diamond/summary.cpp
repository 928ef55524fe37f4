#include "lode/models/diamond/summary.h"

#include "lode/models/diamond/block_checks.h"

namespace lode::diamond {

template <int D>
Summary summarize(const Model<D>& model) {
  Summary summary{.stats = model.stats, .base_error = model.base_error(), .max_errors = {}};
  for (const NodeLevel& nodes : model.levels) summary.max_errors.push_back(largest_error(nodes));
  return summary;
}

template Summary summarize<2>(const Model<2>&);
template Summary summarize<3>(const Model<3>&);

}  // namespace lode::diamond
