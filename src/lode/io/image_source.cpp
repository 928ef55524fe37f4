#include "lode/io/image_source.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

#include "lode/core/label.h"
#include "lode/core/out_of_memory.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

/// What is read of each sample: `n_components` numbers from `first_component`, at one time.
struct Selection {
  std::int64_t first = 0;  ///< Offset of the first number, in numbers.
  std::int64_t n_components = 1;
  bool is_computed = false;
};

ScalarType computed_type(ScalarType stored) {
  return size_of(stored) <= 2 || stored == ScalarType::float32 ? ScalarType::float32
                                                               : ScalarType::float64;
}

class ImageSource final : public VolumeSource {
 public:
  ImageSource(const Image& image, VolumeInfo info, const ImageField& field, Selection selection,
              std::unique_ptr<SampleStore> store)
      : path_(image.path),
        info_(std::move(info)),
        layout_(field.layout),
        slope_(field.slope),
        intercept_(field.intercept),
        selection_(selection),
        store_(std::move(store)),
        tally_(image.tally) {}

  const VolumeInfo& info() const override { return info_; }

  Result<void> read(const IndexBox& box, std::span<std::byte> out) override try {
    LODE_EXPECTS(info_.grid.index_box().contains(box));
    LODE_EXPECTS(out.size() == static_cast<std::size_t>(box.n_samples()) * size_of(info_.type));
    if (box.is_empty()) return {};
    return is_plain() ? read_plain(box, out) : read_rows(box, out);
  } catch (const std::bad_alloc&) {
    return out_of_memory("read samples", path_);
  }

  IoCounts io() const override {
    return {.n_file_bytes_read = tally_->n_file_bytes_read,
            .n_spool_bytes_written = tally_->n_spool_bytes_written,
            .n_spool_bytes_read = tally_->n_spool_bytes_read};
  }

 private:
  /// Samples of a row lie side by side and go out as they are.
  bool is_plain() const { return !selection_.is_computed && layout_.strides[0] == 1; }

  std::int64_t position(std::int32_t x, std::int32_t y, std::int32_t z) const {
    return selection_.first + x * layout_.strides[0] + y * layout_.strides[1] +
           z * layout_.strides[2];
  }

  Result<void> read_plain(const IndexBox& box, std::span<std::byte> out) {
    const std::size_t size = size_of(layout_.type);
    const Index3 dims = box.dims();
    std::int64_t run = dims[0];
    // Whole rows that follow one another are read together, and so are whole slices.
    const bool joins_rows = layout_.strides[1] == run;
    if (joins_rows) run *= dims[1];
    const bool joins_slices = joins_rows && layout_.strides[2] == run;
    if (joins_slices) run *= dims[2];
    const std::size_t n_bytes = static_cast<std::size_t>(run) * size;
    for (std::int32_t z = box.lower[2]; z < box.upper[2]; z += joins_slices ? dims[2] : 1)
      for (std::int32_t y = box.lower[1]; y < box.upper[1]; y += joins_rows ? dims[1] : 1) {
        const auto first = static_cast<std::uint64_t>(position(box.lower[0], y, z));
        LODE_CHECK(store_->read(first * size, out.first(n_bytes)));
        to_native(out.first(n_bytes), layout_.type, layout_.byte_order);
        out = out.subspan(n_bytes);
      }
    return {};
  }

  Result<void> read_rows(const IndexBox& box, std::span<std::byte> out) {
    // Enough to make a read worth its call, few enough to stay in the processor's cache.
    constexpr std::int64_t kMaxRun = 1 << 16;
    const Index3 dims = box.dims();
    const std::int64_t row = dims[0] * layout_.strides[0];
    const bool joins_rows = layout_.strides[1] == row;
    const auto n_joined = static_cast<std::int32_t>(
        joins_rows ? std::clamp<std::int64_t>(kMaxRun / row, 1, dims[1]) : 1);
    for (std::int32_t z = box.lower[2]; z < box.upper[2]; ++z)
      for (std::int32_t y = box.lower[1]; y < box.upper[1]; y += n_joined) {
        const std::int32_t n_rows = std::min(n_joined, box.upper[1] - y);
        const std::size_t n = static_cast<std::size_t>(n_rows) * static_cast<std::size_t>(dims[0]);
        const std::span<std::byte> run = out.first(n * size_of(info_.type));
        LODE_CHECK(read_run(position(box.lower[0], y, z), run));
        out = out.subspan(run.size());
      }
    return {};
  }

  /// Samples from number `first` on, one x stride apart.
  Result<void> read_run(std::int64_t first, std::span<std::byte> out) {
    const std::size_t n = out.size() / size_of(info_.type);
    const std::int64_t reach = (static_cast<std::int64_t>(n) - 1) * layout_.strides[0] + 1;
    if (!selection_.is_computed) {
      LODE_CHECK(fetch(first, reach));
      pick(0, out);
      return {};
    }
    values_.assign(n, 0.0);
    gathered_.resize(n * size_of(layout_.type));
    const std::int64_t components_reach = (selection_.n_components - 1) * layout_.component_stride;
    // Components side by side come in one read, those that lie apart in one each.
    const bool is_interleaved = components_reach < layout_.strides[0];
    if (is_interleaved) LODE_CHECK(fetch(first, reach + components_reach));
    for (std::int64_t c = 0; c < selection_.n_components; ++c) {
      const std::int64_t offset = c * layout_.component_stride;
      if (!is_interleaved) LODE_CHECK(fetch(first + offset, reach));
      pick(is_interleaved ? offset : 0, gathered_);
      visit_scalar_type(layout_.type, [&]<typename T>() { accumulate<T>(); });
    }
    if (info_.type == ScalarType::float32)
      write_values<float>(out);
    else
      write_values<double>(out);
    return {};
  }

  /// n numbers as they are stored.
  Result<void> fetch(std::int64_t first, std::int64_t n) {
    const std::size_t size = size_of(layout_.type);
    scratch_.resize(static_cast<std::size_t>(n) * size);
    return store_->read(static_cast<std::uint64_t>(first) * size, scratch_);
  }

  /// Fills `out` with what was fetched, from number `first` on, one x stride apart, in native byte
  /// order.
  void pick(std::int64_t first, std::span<std::byte> out) const {
    const std::size_t size = size_of(layout_.type);
    const std::size_t stride = static_cast<std::size_t>(layout_.strides[0]) * size;
    const std::byte* from = scratch_.data() + static_cast<std::size_t>(first) * size;
    for (std::size_t i = 0; i < out.size() / size; ++i)
      std::memcpy(out.data() + i * size, from + i * stride, size);
    to_native(out, layout_.type, layout_.byte_order);
  }

  template <typename T>
  void accumulate() {
    const bool is_magnitude = selection_.n_components > 1;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      T stored;
      std::memcpy(&stored, gathered_.data() + i * sizeof(T), sizeof(T));
      const double value = slope_ * static_cast<double>(stored) + intercept_;
      values_[i] = is_magnitude ? values_[i] + value * value : value;
    }
  }

  template <typename T>
  void write_values(std::span<std::byte> out) const {
    const bool is_magnitude = selection_.n_components > 1;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const auto value = static_cast<T>(is_magnitude ? std::sqrt(values_[i]) : values_[i]);
      std::memcpy(out.data() + i * sizeof(T), &value, sizeof(T));
    }
  }

  std::string path_;
  VolumeInfo info_;
  SampleLayout layout_;
  double slope_;
  double intercept_;
  Selection selection_;
  std::unique_ptr<SampleStore> store_;
  IoTallyPtr tally_;
  std::vector<std::byte> scratch_;
  std::vector<std::byte> gathered_;
  std::vector<double> values_;
};

std::string field_list(std::span<const std::string> names) {
  std::string list;
  for (const std::string& name : names) {
    if (!list.empty()) list += ", ";
    list += name.empty() ? "(unnamed)" : name;
  }
  return list;
}

Result<void> select_component(const Image& image, const SampleLayout& layout,
                              const ReadOptions& options, Selection& selection) {
  const std::int64_t n = layout.n_components;
  if (!options.component) {
    if (n == 1) return {};
    return fail(
        "{}: the samples have {} components; choose one with --component N, 0 to {}, or all with "
        "--component magnitude",
        image.path, n, n - 1);
  }
  if (std::holds_alternative<Magnitude>(*options.component)) {
    if (n == 1)
      return fail("{}: a magnitude needs vectors, but the samples have one component", image.path);
    selection.n_components = n;
    return {};
  }
  const std::int64_t component = std::get<int>(*options.component);
  if (component < 0 || component >= n)
    return fail("{}: expected --component between 0 and {}, got {}", image.path, n - 1, component);
  selection.first += component * layout.component_stride;
  return {};
}

}  // namespace

Result<std::size_t> choose_field(const std::string& path, std::span<const std::string> names,
                                 const ReadOptions& options) {
  LODE_EXPECTS(!names.empty());
  if (options.field) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == *options.field) return i;
    return fail("{}: has no field {}; it has {}", path, in_quotes(*options.field),
                field_list(names));
  }
  if (names.size() == 1) return std::size_t{0};
  return fail("{}: holds {} fields; choose one with --field: {}", path, names.size(),
              field_list(names));
}

Result<std::int64_t> choose_time(const std::string& path, std::int64_t n_times,
                                 const ReadOptions& options) {
  if (!options.time && n_times > 1)
    return fail("{}: holds {} times; choose one with --time N, 0 to {}", path, n_times,
                n_times - 1);
  const std::int64_t time = options.time.value_or(0);
  if (time < 0 || time >= n_times)
    return fail("{}: expected --time between 0 and {}, got {}", path, n_times - 1, time);
  return time;
}

Units chosen_units(const Units& of_file, const ReadOptions& options) {
  const Units& given = options.units;
  return {.length = to_label(given.length.empty() ? of_file.length : given.length),
          .value = to_label(given.value.empty() ? of_file.value : given.value)};
}

Result<void> check_nodata(const std::string& path, const ReadOptions& options) {
  if (options.nodata && !std::isfinite(*options.nodata))
    return fail(
        "{}: expected a finite --nodata value (non-finite samples are always holes), got {}", path,
        *options.nodata);
  return {};
}

Result<const ImageField*> choose_field(const Image& image, const ReadOptions& options) {
  std::vector<std::string> names;
  for (const ImageField& field : image.fields) names.push_back(field.name);
  LODE_TRY(const std::size_t i, choose_field(image.path, names, options));
  return &image.fields[i];
}

Result<std::unique_ptr<VolumeSource>> make_image_source(const Image& image,
                                                        const ReadOptions& options) {
  LODE_EXPECTS(image.tally != nullptr);
  LODE_CHECK(check_nodata(image.path, options));
  LODE_TRY(const ImageField* field, choose_field(image, options));
  const SampleLayout& layout = field->layout;
  Selection selection;
  LODE_TRY(const std::int64_t time, choose_time(image.path, layout.n_times, options));
  selection.first += time * layout.time_stride;
  LODE_CHECK(select_component(image, layout, options, selection));
  const bool has_scale = field->slope != 1 || field->intercept != 0;
  selection.is_computed = has_scale || selection.n_components > 1;
  VolumeInfo info{.grid = image.grid,
                  .type = selection.is_computed ? computed_type(layout.type) : layout.type,
                  .field_name = field->name,
                  .nodata = options.nodata,
                  .units = chosen_units({image.length_unit, field->value_unit}, options)};
  LODE_TRY(std::unique_ptr<SampleStore> store, field->load());
  return std::unique_ptr<VolumeSource>(
      std::make_unique<ImageSource>(image, std::move(info), *field, selection, std::move(store)));
}

}  // namespace lode::io
