#include "lode/models/tetra_mt/base_blocks.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "lode/core/label.h"
#include "lode/core/mesh_region.h"
#include "lode/models/tetra_mt/interfaces.h"
#include "lode/models/tetra_mt/page_blocks.h"

namespace lode::tetra_mt {
namespace {

/// Numbers that ascend, with their names. `kind`: "regions"
template <typename Named>
Result<std::vector<Named>> read_named(store::ByteReader& in, const std::string& path,
                                      std::string_view kind) {
  LODE_TRY(const auto n, in.read<std::uint32_t>());
  constexpr std::size_t kFewestBytes = sizeof(std::int64_t) + sizeof(std::uint32_t);
  if (n > in.n_left() / kFewestBytes)
    return fail("{}: metadata: expected {} {} in {} bytes, got fewer", path, n, kind, in.n_left());
  std::vector<Named> all;
  for (std::uint32_t i = 0; i < n; ++i) {
    Named one;
    LODE_TRY(one.id, in.read<std::int64_t>());
    LODE_TRY(one.name, in.read_string());
    if (i > 0 && one.id <= all.back().id)
      return fail("{}: metadata: expected {} that ascend, got {} after {}", path, kind, one.id,
                  all.back().id);
    if (const auto fault = label_fault(one.name))
      return fail("{}: metadata: expected names of {} in one line of UTF-8, got {}", path, kind,
                  *fault);
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace

void write_labels(const HeadLabels& labels, store::ByteWriter& out) {
  out.write(static_cast<std::uint32_t>(labels.region_ids.size()));
  for (std::size_t i = 0; i < labels.region_ids.size(); ++i) {
    out.write(labels.region_ids[i]);
    out.write_string(labels.region_names.empty() ? std::string() : labels.region_names[i]);
  }
  out.write(static_cast<std::uint32_t>(labels.patches.size()));
  for (const BoundaryPatch& patch : labels.patches) {
    out.write(patch.id);
    out.write_string(patch.name);
  }
}

Result<HeadLabels> read_labels(store::ByteReader& in, const std::string& path) {
  HeadLabels labels;
  LODE_TRY(const auto regions, read_named<MeshRegion>(in, path, "regions"));
  const bool has_names =
      std::ranges::any_of(regions, [](const MeshRegion& each) { return !each.name.empty(); });
  for (const MeshRegion& region : regions) {
    labels.region_ids.push_back(region.id);
    if (has_names) labels.region_names.push_back(region.name);
  }
  LODE_TRY(labels.patches, read_named<BoundaryPatch>(in, path, "patches"));
  if (labels.patches.size() > kMaxPatches)
    return fail("{}: metadata: expected up to {} patches, got {}", path, kMaxPatches,
                labels.patches.size());
  return labels;
}

Result<void> read_box(store::ByteReader& in, const std::string& path, Vec3d& lower, Vec3d& upper) {
  for (Vec3d* corner : {&lower, &upper})
    for (double& x : corner->v) {
      LODE_TRY(x, in.read<double>());
    }
  for (std::size_t i = 0; i < 3; ++i)
    if (!(lower[i] <= upper[i]) || !std::isfinite(length(upper - lower)))
      return fail("{}: metadata: expected a finite box, got {} to {} along axis {}", path, lower[i],
                  upper[i], i);
  return {};
}

Result<double> read_deviation(store::ByteReader& in, const std::string& path) {
  LODE_TRY(const auto deviation, in.read<double>());
  if (deviation >= 0) return deviation;
  return fail("{}: metadata: expected a distance >= 0, got {}", path, deviation);
}

void write_world_error(const std::optional<double>& error, store::ByteWriter& out) {
  out.write(static_cast<std::uint8_t>(error ? 1 : 0));
  out.write(error.value_or(0));
}

Result<std::optional<double>> read_world_error(store::ByteReader& in, const std::string& path,
                                               const std::string& field) {
  LODE_TRY(const auto has_one, in.read<std::uint8_t>());
  LODE_TRY(const double error, in.read<double>());
  if (has_one > 1 || !(error >= 0) || (has_one == 0 && error != 0))
    return fail("{}: metadata: expected 1 and a world error >= 0 of {}, or 0 and 0, got {} and {}",
                path, field, has_one, error);
  return has_one == 1 ? std::optional(error) : std::nullopt;
}

Result<store::Writer> copy_blocks(const std::string& from, const std::string& to,
                                  std::string_view model, const Progress& progress) {
  LODE_TRY(const store::Reader reader, store::Reader::open(from));
  LODE_TRY(auto writer, store::Writer::create(to, model, {}));
  const auto blocks = reader.blocks();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (progress.is_cancelled()) return cancelled_error();
    LODE_TRY(const auto bytes, reader.read_block(i));
    LODE_CHECK(writer.append(blocks[i].key, as_block(bytes)));
  }
  return writer;
}

Result<std::vector<std::byte>> read_block(const store::Reader& reader, const store::BlockKey& key) {
  const auto at = reader.find(key);
  if (!at) return fail("{}: expected {}, found none", reader.path(), store::describe(key));
  return reader.read_block(*at);
}

Result<void> check_base_memory(const store::Reader& reader, std::uint64_t n_bytes) {
  constexpr std::uint64_t kPerByte = 64;
  constexpr std::uint64_t kAlways = std::uint64_t{64} << 20;
  if (n_bytes <= kPerByte * reader.file_size() + kAlways) return {};
  return fail("{}: expected a base that {} bytes may hold, got one of {} bytes", reader.path(),
              reader.file_size(), n_bytes);
}

}  // namespace lode::tetra_mt
