#include <fmt/ranges.h>

#include <atomic>

#include "lode/models/diamond/block_checks.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/persist.h"
#include "lode/models/diamond/read_region.h"

namespace lode::diamond {
namespace {

/// Loads one kind of block into arrays, in parallel; body(i, bytes) puts the points of region i.
template <int D, typename Body>
Result<void> load_blocks(const store::Reader& reader, std::span<const Region<D>> regions, Kind kind,
                         std::size_t element_size, Threads threads, Progress& progress,
                         const Body& body) {
  std::vector<Error> errors(regions.size());
  std::atomic<std::size_t> n_done{0};
  parallel_for(regions.size(), threads, 1, [&](std::size_t i, int) {
    if (progress.is_cancelled()) return;
    const auto bytes = read_region<D>(reader, regions[i], kind, element_size);
    if (!bytes) {
      errors[i] = bytes.error();
      return;
    }
    body(i, bytes->data());
    progress.report("loading", static_cast<double>(++n_done) / static_cast<double>(regions.size()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  for (const Error& error : errors)
    if (!error.message.empty()) return error;
  return {};
}

/// Compares the samples beyond the data that one block holds, as for_each_row comes to them, with
/// the nearest ones in `all`, the samples of the data: bit by bit, as a hole may be NaN.
template <typename T, int D>
Result<void> check_beyond(const store::Reader& reader, const Shape<D>& shape, const Region<D>& r,
                          const std::byte* all, std::span<const std::byte> beyond) {
  if (beyond.empty()) return {};
  const std::byte* from = beyond.data();
  Error error;
  for_each_row<D>(r, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
    for (std::int32_t i = count_inside(shape, r.level, q, n, stride); i < n; ++i) {
      Index<D> at = q;
      at[0] += i * stride;
      Index<D> nearest;
      for (std::size_t a = 0; a < as_size(D); ++a)
        nearest[a] = std::min(at[a] << r.level, shape.dims[a] - 1);
      const std::byte* inside = all + linear_index<D>(shape.dims, nearest) * sizeof(T);
      const std::byte* here = std::exchange(from, from + sizeof(T));
      if (std::equal(here, here + sizeof(T), inside) || !error.message.empty()) continue;
      T expected;
      T got;
      std::memcpy(&expected, inside, sizeof(T));
      std::memcpy(&got, here, sizeof(T));
      error = fail(
          "{}: {}: beyond the data at grid point {}: expected the nearest sample, {}, got {}",
          reader.path(), describe(key_of(Kind::samples, r)), fmt::join(at.v, " "), expected, got);
    }
  });
  if (!error.message.empty()) return error;
  return {};
}

/// Loads the samples of the data, x fastest, into `all`; those beyond it are only checked.
template <typename T, int D>
Result<void> load_samples_as(const Shape<D>& shape, const store::Reader& reader, Threads threads,
                             Progress& progress, std::byte* all) {
  const std::vector<Region<D>> regions = all_regions<D>(shape, Kind::samples);
  std::vector<std::vector<std::byte>> beyond(regions.size());
  const auto put_block = [&](std::size_t block, const std::byte* from) {
    const Region<D>& r = regions[block];
    for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
      const std::int32_t n_inside = count_inside(shape, r.level, q, n, stride);
      for (std::int32_t& x : q.v) x <<= r.level;
      std::byte* to = n_inside > 0 ? all + linear_index<D>(shape.dims, q) * sizeof(T) : nullptr;
      const std::size_t step = sizeof(T) * as_size(stride << r.level);
      for (std::size_t i = 0; i < as_size(n_inside); ++i, from += sizeof(T))
        std::memcpy(to + i * step, from, sizeof(T));
      const std::byte* end = from + as_size(n - n_inside) * sizeof(T);
      beyond[block].insert(beyond[block].end(), from, end);
      from = end;
    });
  };
  LODE_CHECK(
      load_blocks<D>(reader, regions, Kind::samples, sizeof(T), threads, progress, put_block));
  for (std::size_t i = 0; i < regions.size(); ++i)
    LODE_CHECK((check_beyond<T, D>(reader, shape, regions[i], all, beyond[i])));
  return {};
}

template <int D>
Result<void> load_samples(Model<D>& model, const store::Reader& reader, Threads threads,
                          Progress& progress) {
  const Index<D> dims = model.shape.dims;
  UninitializedArray<std::byte> all(n_points<D>(dims) * model.sample_size());
  LODE_CHECK(visit_storage_type(model.storage, [&]<typename T>() {
    return load_samples_as<T, D>(model.shape, reader, threads, progress, all.data());
  }));
  put_samples<D>(model, {{}, dims}, all.data(), threads);
  finish_samples<D>(model, threads);
  return {};
}

/// Loads one attribute, stored as T, into the arrays that array_of(level) gives.
template <typename T, int D, typename ArrayOf>
Result<void> load_attribute(const Shape<D>& shape, const store::Reader& reader, Kind kind,
                            Threads threads, Progress& progress, const ArrayOf& array_of) {
  const std::vector<Region<D>> regions = all_regions<D>(shape, kind);
  const auto put_block = [&](std::size_t block, const std::byte* from) {
    const Region<D>& r = regions[block];
    auto& to = array_of(r.level);
    const Index<D> dims = shape.grid_dims(r.level);
    for_each_row<D>(r, [&](const Index<D>& q, std::int32_t n, std::int32_t stride) {
      const std::size_t first = linear_index<D>(dims, q);
      for (std::size_t i = 0; i < as_size(n); ++i, from += sizeof(T)) {
        T value;
        std::memcpy(&value, from, sizeof(T));
        to[first + i * as_size(stride)] = value;
      }
    });
  };
  return load_blocks<D>(reader, regions, kind, sizeof(T), threads, progress, put_block);
}

template <int D>
Result<void> load_attributes(Model<D>& model, const store::Reader& reader, Threads threads,
                             Progress& progress) {
  for (int level = 1; level < model.shape.n_levels; ++level) {
    NodeLevel& nodes = model.levels[as_size(level)];
    const std::size_t n = n_points<D>(model.shape.grid_dims(level));
    nodes.error.assign(n, 0);
    nodes.low.assign(n, std::numeric_limits<float>::infinity());
    nodes.high.assign(n, -std::numeric_limits<float>::infinity());
  }
  const auto load_kind = [&]<typename T>(Kind kind, auto NodeLevel::*array) {
    return load_attribute<T>(
        model.shape, reader, kind, threads,
        progress, [&](int level) -> auto& { return model.levels[as_size(level)].*array; });
  };
  LODE_CHECK(load_kind.template operator()<ErrorCode>(Kind::errors, &NodeLevel::error));
  return visit_range_type(model.storage, [&]<typename R>() -> Result<void> {
    LODE_CHECK(load_kind.template operator()<R>(Kind::lows, &NodeLevel::low));
    LODE_CHECK(load_kind.template operator()<R>(Kind::highs, &NodeLevel::high));
    for (NodeLevel& nodes : model.levels) LODE_CHECK(check_nodes(nodes, reader));
    return {};
  });
}

Result<void> check_stats(const store::Reader& reader, const FieldStats& said,
                         const FieldStats& found) {
  LODE_CHECK(check_said(reader, "smallest sample", said.min, found.min));
  LODE_CHECK(check_said(reader, "largest sample", said.max, found.max));
  LODE_CHECK(check_said(reader, "number of holes", said.n_holes, found.n_holes));
  return check_said(reader, "number of removed cells", said.n_removed_cells, found.n_removed_cells);
}

/// Both have one maximum a level.
Result<void> check_errors(const store::Reader& reader, const Summary& said, const Summary& found) {
  LODE_CHECK(check_said(reader, "base error", said.base_error, found.base_error));
  for (std::size_t level = 0; level < found.max_errors.size(); ++level)
    LODE_CHECK(check_said(reader, fmt::format("largest error of level {}", level),
                          said.max_errors[level], found.max_errors[level]));
  return {};
}

}  // namespace

template <int D>
Result<Model<D>> load(const store::Reader& reader, Threads threads, Progress& progress) {
  LODE_TRY(const Metadata metadata, read_metadata(reader));
  Model<D> model = Model<D>::make(metadata.info);
  LODE_CHECK(load_samples<D>(model, reader, threads, progress));
  LODE_CHECK(check_stats(reader, metadata.summary.stats, model.stats));
  model.levels.resize(as_size(model.shape.n_levels));
  LODE_CHECK(load_attributes<D>(model, reader, threads, progress));
  compute_level_0<D>(model, threads);
  LODE_CHECK(check_errors(reader, metadata.summary, summarize<D>(model)));
  return model;
}

StoredBytes stored_bytes(const store::Reader& reader) {
  StoredBytes bytes;
  for (const store::BlockEntry& block : reader.blocks()) {
    if (block.key.level > 31) continue;
    if (bytes.by_level.size() <= block.key.level) bytes.by_level.resize(block.key.level + 1);
    bytes.by_level[block.key.level] += block.stored_size;
    if (block.key.kind == static_cast<std::uint32_t>(Kind::samples))
      bytes.samples += block.stored_size;
  }
  bytes.attributes = reader.file_size() - bytes.samples;
  return bytes;
}

template Result<Model<2>> load<2>(const store::Reader&, Threads, Progress&);
template Result<Model<3>> load<3>(const store::Reader&, Threads, Progress&);

}  // namespace lode::diamond
