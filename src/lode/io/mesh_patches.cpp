#include "lode/io/mesh_patches.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "lode/io/vtk_xml_output.h"

namespace lode::io {

namespace {

constexpr std::size_t kLongestName = 200;  // and a number behind it, where names are alike

}  // namespace

PatchBlocks::PatchBlocks(const SimplexMesh& mesh) : sides_(mesh.patch_sides.size()) {
  std::iota(sides_.begin(), sides_.end(), 0U);
  const auto patch_of = [&](std::uint32_t side) { return mesh.patch_sides[side].patch; };
  std::stable_sort(sides_.begin(), sides_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return patch_of(a) < patch_of(b); });
  const bool has_tags =
      std::all_of(mesh.patches.begin(), mesh.patches.end(), [](const BoundaryPatch& patch) {
        return patch.id > 0 && patch.id <= std::numeric_limits<std::int32_t>::max();
      });
  std::set<std::string> names;
  const std::span<const std::uint32_t> all = sides_;
  for (std::size_t first = 0; first < all.size();) {
    const std::uint32_t place = patch_of(all[first]);
    std::size_t end = first + 1;
    while (end < all.size() && patch_of(all[end]) == place) ++end;
    const BoundaryPatch& patch = mesh.patches[place];
    std::string name = to_one_line(name_of(patch)).substr(0, kLongestName);
    if (!names.insert(name).second) name += fmt::format(" ({})", patch.id);
    blocks_.push_back(
        {.tag = static_cast<std::int32_t>(has_tags ? patch.id : std::int64_t{place} + 1),
         .name = std::move(name),
         .sides = all.subspan(first, end - first)});
    first = end;
  }
}

std::string vtk_patch_names(std::span<const BoundaryPatch> patches) {
  if (patches.empty()) return {};
  std::string ids;
  std::string codes;
  for (const BoundaryPatch& patch : patches) {
    ids += fmt::format("{} ", patch.id);
    for (const char c : name_of(patch)) codes += fmt::format("{} ", static_cast<unsigned char>(c));
    codes += "0 ";
  }
  return fmt::format(
      "<DataArray type=\"Int64\" Name=\"PatchIds\" NumberOfTuples=\"{0}\" "
      "format=\"ascii\">{1}</DataArray>\n"
      "<Array type=\"String\" Name=\"PatchNames\" NumberOfTuples=\"{0}\" "
      "format=\"ascii\">{2}</Array>\n",
      patches.size(), ids, codes);
}

}  // namespace lode::io
