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

void write_corners(std::span<const Tetrahedron> tetrahedra, StreamWriter& out) {
  std::vector<std::uint32_t> column;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    column.clear();
    for (const Tetrahedron& t : tetrahedra) column.push_back(t[corner]);
    write_differences_of(column, out);
  }
}

Result<std::vector<Tetrahedron>> read_corners(StreamReader& in, std::size_t n,
                                              std::uint32_t n_vertices, std::uint32_t outside) {
  std::vector<Tetrahedron> tetrahedra(n);
  for (std::size_t corner = 0; corner < 4; ++corner) {
    LODE_TRY(const auto column, read_differences_of(in, n));
    for (std::size_t i = 0; i < n; ++i) {
      if (column[i] >= n_vertices && column[i] != outside)
        return fail("{}: expected vertices of the base, {}, or {}, got {}", in.what(), n_vertices,
                    outside, column[i]);
      tetrahedra[i][corner] = column[i];
    }
  }
  for (Tetrahedron t : tetrahedra) {
    std::ranges::sort(t);
    if (std::ranges::adjacent_find(t) != t.end())
      return fail("{}: expected tetrahedra of four vertices, got vertex {} twice", in.what(),
                  *std::ranges::adjacent_find(t));
  }
  return tetrahedra;
}

Result<std::vector<std::uint32_t>> read_marks(StreamReader& in,
                                              std::span<const Tetrahedron> tetrahedra,
                                              std::uint32_t outside, std::size_t n_regions,
                                              std::size_t n_patches) {
  LODE_TRY(auto marks, read_differences_of(in, tetrahedra.size()));
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const bool is_outer = std::ranges::find(tetrahedra[i], outside) != tetrahedra[i].end();
    const std::size_t limit = is_outer ? n_patches + 1 : std::max<std::size_t>(n_regions, 1);
    if (marks[i] >= limit)
      return fail("{}: expected one of {} {}, got {}", in.what(), limit,
                  is_outer ? "patches and none" : "regions", marks[i]);
  }
  return marks;
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
