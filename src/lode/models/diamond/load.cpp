#include <atomic>

#include "lode/models/diamond/block_layout.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/persist.h"
#include "lode/store/bytes.h"

namespace lode::diamond {
namespace {

Result<VolumeInfo> decode_metadata(const store::Reader& reader) {
  store::ByteReader in(reader.metadata(), reader.path() + ": metadata");
  VolumeInfo info;
  for (std::int32_t& n : info.grid.dims.v) {
    LODE_TRY(n, in.read<std::int32_t>());
    if (n < 1 || n > kMaxSamplesPerAxis)
      return fail("{}: metadata: expected 1 to {} samples along an axis, got {}", reader.path(),
                  kMaxSamplesPerAxis, n);
  }
  for (double& x : info.grid.spacing.v) {
    LODE_TRY(x, in.read<double>());
    if (!(x > 0) || !std::isfinite(x))
      return fail("{}: metadata: expected a positive spacing, got {}", reader.path(), x);
  }
  for (double& x : info.grid.origin.v) {
    LODE_TRY(x, in.read<double>());
    if (!std::isfinite(x)) return fail("{}: metadata: expected a finite origin", reader.path());
  }
  for (Vec3d& row : info.grid.direction.rows)
    for (double& x : row.v) {
      LODE_TRY(x, in.read<double>());
    }
  // The readers of foreign files ask the same.
  if (!(std::abs(determinant(info.grid.direction)) >= 1e-6))
    return fail("{}: metadata: expected independent directions of the axes", reader.path());
  LODE_TRY(const auto frame, in.read<std::uint8_t>());
  LODE_TRY(const auto type, in.read<std::uint8_t>());
  LODE_TRY(const auto has_nodata, in.read<std::uint8_t>());
  LODE_TRY(const auto nodata, in.read<double>());
  LODE_TRY(info.field_name, in.read_string());
  info.type = static_cast<ScalarType>(type);
  if (!is_valid(info.type) || frame > static_cast<std::uint8_t>(Frame::lps))
    return fail("{}: metadata: expected a sample type 1..10 and a frame 0..2, got {} and {}",
                reader.path(), type, frame);
  info.grid.frame = static_cast<Frame>(frame);
  if (has_nodata != 0) info.nodata = nodata;
  return info;
}

/// Loads one kind of block into arrays, in parallel; body(region, bytes) puts the points.
template <int D, typename Body>
Result<void> load_blocks(const store::Reader& reader, const Shape<D>& shape, Kind kind,
                         std::size_t element_size, Threads threads, Progress& progress,
                         const Body& body) {
  const std::vector<Region<D>> regions = all_regions<D>(shape, kind);
  std::vector<Error> errors(regions.size());
  std::atomic<std::size_t> n_done{0};
  parallel_for(regions.size(), threads, 1, [&](std::size_t i, int) {
    if (progress.is_cancelled()) return;
    const std::size_t n = count_points(regions[i]);
    if (n == 0) return;
    const store::BlockKey key = key_of(kind, regions[i]);
    const auto at = reader.find(key);
    if (!at) {
      errors[i] = fail("{}: expected {}, but the file has none", reader.path(), describe(key));
      return;
    }
    if (reader.blocks()[*at].raw_size != n * element_size) {
      errors[i] = fail("{}: {}: expected {} bytes, got {}", reader.path(), describe(key),
                       n * element_size, reader.blocks()[*at].raw_size);
      return;
    }
    auto bytes = reader.read_block(*at);
    if (!bytes) {
      errors[i] = bytes.error();
      return;
    }
    body(regions[i], bytes->data());
    progress.report("loading", static_cast<double>(++n_done) / static_cast<double>(regions.size()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  for (const Error& error : errors)
    if (!error.message.empty()) return error;
  return {};
}

/// Refuses metadata that promises other samples than the directory holds, before memory is asked.
template <int D>
Result<void> check_size(const store::Reader& reader, const VolumeInfo& info) {
  const auto expected =
      static_cast<std::uint64_t>(info.grid.n_samples()) * size_of(storage_type(info.type));
  std::uint64_t present = 0;
  for (const store::BlockEntry& block : reader.blocks())
    if (block.key.kind == static_cast<std::uint32_t>(Kind::samples)) present += block.raw_size;
  if (expected == present) return {};
  return fail("{}: expected {} bytes of samples for {} x {} x {}, its blocks hold {}",
              reader.path(), expected, info.grid.dims[0], info.grid.dims[1], info.grid.dims[2],
              present);
}

template <int D>
Result<void> load_samples(Model<D>& model, const store::Reader& reader, Threads threads,
                          Progress& progress) {
  const std::size_t size = model.sample_size();
  const Index<D> dims = model.shape.dims;
  UninitializedArray<std::byte> all(n_points<D>(dims) * size);
  const auto put_block = [&]<typename T>(const Region<D>& r, const std::byte* from) {
    for_each_row<D>(r, [&](Index<D> q, std::int32_t n, std::int32_t stride) {
      for (std::size_t a = 0; a < as_size(D); ++a) q[a] <<= r.level;
      std::byte* to = all.data() + linear_index<D>(dims, q) * sizeof(T);
      const std::size_t step = sizeof(T) * as_size(stride << r.level);
      for (std::size_t i = 0; i < as_size(n); ++i, from += sizeof(T))
        std::memcpy(to + i * step, from, sizeof(T));
    });
  };
  LODE_CHECK(load_blocks<D>(reader, model.shape, Kind::samples, size, threads, progress,
                            [&](const Region<D>& r, const std::byte* from) {
                              visit_storage_type(model.storage, [&]<typename T>() {
                                put_block.template operator()<T>(r, from);
                              });
                            }));
  put_samples<D>(model, {{}, dims}, all.data(), threads);
  finish_samples<D>(model, threads);
  if (auto checked = check_magnitude(model.stats); !checked)
    return fail("{}: {}", reader.path(), checked.error().message);
  return {};
}

/// Loads one attribute, stored as T, into the arrays that array_of(level) gives.
template <typename T, int D, typename ArrayOf>
Result<void> load_attribute(const Shape<D>& shape, const store::Reader& reader, Kind kind,
                            Threads threads, Progress& progress, const ArrayOf& array_of) {
  const auto put_block = [&](const Region<D>& r, const std::byte* from) {
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
  return load_blocks<D>(reader, shape, kind, sizeof(T), threads, progress, put_block);
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
    for (NodeLevel& nodes : model.levels)
      for (std::size_t i = 0; i < nodes.low.size(); ++i) {
        if (nodes.error[i] > kInfiniteError || std::isnan(nodes.low[i]) ||
            std::isnan(nodes.high[i]))
          return fail("{}: attributes: expected an error and a range, got a code {} and {} to {}",
                      reader.path(), nodes.error[i], nodes.low[i], nodes.high[i]);
        if (nodes.low[i] > nodes.high[i]) {
          nodes.low[i] = std::numeric_limits<float>::infinity();
          nodes.high[i] = -std::numeric_limits<float>::infinity();
        }
      }
    return {};
  });
}

}  // namespace

template <int D>
Result<Model<D>> load(const store::Reader& reader, Threads threads, Progress& progress) {
  LODE_TRY(const VolumeInfo info, decode_metadata(reader));
  LODE_CHECK(check_size<D>(reader, info));
  Model<D> model = Model<D>::make(info);
  LODE_CHECK(load_samples<D>(model, reader, threads, progress));
  model.levels.resize(as_size(model.shape.n_levels));
  LODE_CHECK(load_attributes<D>(model, reader, threads, progress));
  compute_level_0<D>(model, threads);
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
