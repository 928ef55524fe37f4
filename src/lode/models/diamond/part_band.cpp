#include "lode/models/diamond/part_band.h"

#include <algorithm>

namespace lode::diamond {

std::unique_ptr<SurfaceBand> make_part_band(FilePart<3>& part, const RegularGrid& field_grid,
                                            double isovalue, double error, Threads threads) {
  constexpr int kLevel = FieldPart::kBlockLevel;
  static_assert(FilePart<3>::kMargin == 1 << kLevel);
  part.fill_beside();
  FieldPart known{
      .model = part.model(), .grid = field_grid, .origin = part.origin(), .is_known = {}};
  const Index<3> blocks = FieldPart::block_dims(part.model().shape.dims);
  known.is_known.assign(n_points<3>(blocks), 0);
  for (const Index<3>& brick : part.fine()) {
    Index<3> first = brick * (kBrickEdge<3> >> kLevel) - all_equal<3>(1);
    Index<3> end = (brick + all_equal<3>(1)) * (kBrickEdge<3> >> kLevel) + all_equal<3>(1);
    for (std::size_t i = 0; i < 3; ++i) {
      first[i] = std::max(first[i], 0);
      end[i] = std::min(end[i], blocks[i]);
    }
    for (std::int32_t z = first[2]; z < end[2]; ++z)
      for (std::int32_t y = first[1]; y < end[1]; ++y) {
        const auto row = known.is_known.begin() +
                         static_cast<std::ptrdiff_t>(linear_index<3>(blocks, {{0, y, z}}));
        std::fill(row + first[0], row + end[0], std::uint8_t{1});
      }
  }
  return make_field_band(std::move(known), isovalue, error, threads);
}

}  // namespace lode::diamond
