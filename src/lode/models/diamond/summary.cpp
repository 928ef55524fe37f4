#include "lode/models/diamond/summary.h"

namespace lode::diamond {

template <int D>
Summary summarize(const Model<D>& model) {
  Summary summary{.stats = model.stats, .base_error = model.base_error(), .max_errors = {}};
  for (const NodeLevel& nodes : model.levels) {
    ErrorCode largest = 0;  // codes are ordered as the errors are
    for (const ErrorCode error : nodes.error) largest = std::max(largest, error);
    summary.max_errors.push_back(static_cast<double>(decode_error(largest)));
  }
  return summary;
}

template Summary summarize<2>(const Model<2>&);
template Summary summarize<3>(const Model<3>&);

}  // namespace lode::diamond
