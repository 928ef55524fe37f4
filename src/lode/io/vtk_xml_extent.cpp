#include "lode/io/vtk_xml_extent.h"

#include "lode/io/image.h"
#include "lode/io/text.h"

namespace lode::io {

Result<VtkExtent> parse_vtk_extent(const std::string& path, const char* text) {
  const auto numbers = to_int64s(text);
  if (!numbers || numbers->size() != 6)
    return fail("{}: expected an extent of 6 whole numbers, got {}", path, in_quotes(text));
  VtkExtent extent;
  std::array<std::int64_t, 3> counts{};
  constexpr std::int64_t kLimit = std::int64_t{1} << 40;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int64_t first = (*numbers)[2 * i];
    const std::int64_t last = (*numbers)[2 * i + 1];
    if (first < -kLimit || first > kLimit || last < first || last > kLimit)
      return fail("{}: expected an extent of ordered pairs, got {}", path, in_quotes(text));
    extent.first[i] = first;
    counts[i] = last - first + 1;
  }
  LODE_TRY(extent.dims, checked_dims(path, counts));
  return extent;
}

}  // namespace lode::io
