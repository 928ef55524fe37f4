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

/// KINDIds and KINDNames of what has both.
template <typename Named>
std::string vtk_names(const char* kind, std::span<const Named> all) {
  if (all.empty()) return {};
  std::string ids;
  std::string codes;
  for (const Named& each : all) {
    ids += fmt::format("{} ", each.id);
    for (const char c : name_of(each)) codes += fmt::format("{} ", static_cast<unsigned char>(c));
    codes += "0 ";
  }
  return fmt::format(
      "<DataArray type=\"Int64\" Name=\"{0}Ids\" NumberOfTuples=\"{1}\" "
      "format=\"ascii\">{2}</DataArray>\n"
      "<Array type=\"String\" Name=\"{0}Names\" NumberOfTuples=\"{1}\" "
      "format=\"ascii\">{3}</Array>\n",
      kind, all.size(), ids, codes);
}

}  // namespace

std::string block_name(std::string_view name, std::int64_t id, std::set<std::string>& taken) {
  constexpr std::size_t kLongest = 200;
  std::string made = to_one_line(name);
  if (made.size() > kLongest) {
    std::size_t n = kLongest;
    while (n > 0 && (static_cast<unsigned char>(made[n]) & 0xC0U) == 0x80) --n;
    made.resize(n);
  }
  while (!taken.insert(made).second) made += fmt::format(" ({})", id);
  return made;
}

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
    std::string name = block_name(name_of(patch), patch.id, names);
    blocks_.push_back(
        {.tag = static_cast<std::int32_t>(has_tags ? patch.id : std::int64_t{place} + 1),
         .name = std::move(name),
         .sides = all.subspan(first, end - first)});
    first = end;
  }
}

std::string vtk_patch_names(std::span<const BoundaryPatch> patches) {
  return vtk_names("Patch", patches);
}

std::string vtk_region_names(std::span<const MeshRegion> regions) {
  return vtk_names("Region", regions);
}

}  // namespace lode::io
