#include "lode/io/vtk_legacy.h"

#include <cstdlib>
#include <optional>

#include "lode/io/image_grid.h"
#include "lode/io/text.h"
#include "lode/io/vtk_legacy_arrays.h"
#include "lode/io/vtk_legacy_skip.h"

namespace lode::io {
namespace {

/// What has been read so far.
struct LegacyData {
  bool is_rectilinear = false;
  std::optional<std::array<std::int64_t, 3>> counts;
  GridFrame frame;
  std::array<std::int64_t, 3> first{};  ///< Of an EXTENT.
  std::array<std::optional<LegacyArray>, 3> coordinates;
  std::optional<std::int64_t> n_points;
  std::vector<LegacyArray> arrays;  ///< At points.
  std::string skipped;              ///< The first one at points that is passed over.
  bool has_cell_arrays = false;
};

Result<bool> parse_preamble(LegacyFile& file) {
  LODE_TRY(const LegacyPreamble preamble, parse_legacy_preamble(file));
  const std::string kind = to_lower(preamble.dataset);
  if (kind != "structured_points" && kind != "rectilinear_grid")
    return fail("{}: expected DATASET STRUCTURED_POINTS or RECTILINEAR_GRID, got {}",
                file.cursor.path(), in_quotes(preamble.dataset));
  return kind == "rectilinear_grid";
}

template <typename T, typename Parse>
Result<std::vector<T>> legacy_numbers(const LegacyFile& file, const std::vector<std::string>& words,
                                      std::size_t n, Parse parse) {
  std::vector<T> numbers;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto number = parse(words[i]);
    if (!number) break;
    numbers.push_back(*number);
  }
  if (numbers.size() == n && words.size() == n + 1) return numbers;
  return fail("{}: expected {} numbers after {}, got {}", file.cursor.path(), n, words[0],
              in_quotes(words.size() > 1 ? words[1] : ""));
}

Result<void> parse_legacy_extent(const LegacyFile& file, const std::vector<std::string>& words,
                                 LegacyData& data) {
  LODE_TRY(const auto extent, legacy_numbers<std::int64_t>(file, words, 6, to_int64));
  std::array<std::int64_t, 3> counts{};
  constexpr std::int64_t kLimit = std::int64_t{1} << 40;
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(extent[2 * i] / 2) > kLimit || std::abs(extent[2 * i + 1] / 2) > kLimit)
      return fail("{}: expected a sensible EXTENT, got {}", file.cursor.path(), extent[2 * i]);
    data.first[i] = extent[2 * i];
    counts[i] = extent[2 * i + 1] - extent[2 * i] + 1;
  }
  data.counts = counts;
  return {};
}

/// DIMENSIONS, SPACING and so on; false when `words` is none of them.
Result<bool> parse_geometry(LegacyFile& file, const std::vector<std::string>& words,
                            LegacyData& data) {
  const std::string keyword = to_lower(words[0]);
  if (keyword == "dimensions") {
    LODE_TRY(const auto n, legacy_numbers<std::int64_t>(file, words, 3, to_int64));
    data.counts = {n[0], n[1], n[2]};
  } else if (keyword == "extent") {
    LODE_CHECK(parse_legacy_extent(file, words, data));
  } else if (keyword == "spacing" || keyword == "aspect_ratio") {
    LODE_TRY(const auto n, legacy_numbers<double>(file, words, 3, to_double));
    data.frame.spacing = {{n[0], n[1], n[2]}};
  } else if (keyword == "origin") {
    LODE_TRY(const auto n, legacy_numbers<double>(file, words, 3, to_double));
    data.frame.origin = {{n[0], n[1], n[2]}};
  } else if (keyword == "direction") {
    LODE_TRY(const auto n, legacy_numbers<double>(file, words, 9, to_double));
    for (std::size_t i = 0; i < 3; ++i)
      data.frame.direction.rows[i] = {{n[3 * i], n[3 * i + 1], n[3 * i + 2]}};
  } else if (keyword.size() == 13 && keyword.ends_with("_coordinates") && keyword[0] >= 'x' &&
             keyword[0] <= 'z') {
    const auto n = words.size() == 3 ? to_int64(words[1]) : std::nullopt;
    if (!n || *n < 1)
      return fail("{}: expected a count and a type after {}", file.cursor.path(), words[0]);
    LegacyArray array{.name = words[0], .n_tuples = *n};
    LODE_TRY(array.type, legacy_type(file.cursor.path(), words[2]));
    LODE_CHECK(skip_array(file, array));
    data.coordinates[static_cast<std::size_t>(keyword[0] - 'x')] = std::move(array);
  } else {
    return false;
  }
  return true;
}

enum class Section { geometry, points, cells };

/// What attribute lines are read into at the moment.
struct SectionState {
  Section section = Section::geometry;
  std::int64_t n_tuples = 0;
};

Result<void> start_section(LegacyFile& file, const std::vector<std::string>& words,
                           SectionState& state, LegacyData& data) {
  state.section = equals_ignoring_case(words[0], "POINT_DATA") ? Section::points : Section::cells;
  const auto n = words.size() == 2 ? to_int64(words[1]) : std::nullopt;
  if (!n || *n < 0) return fail("{}: expected a count after {}", file.cursor.path(), words[0]);
  state.n_tuples = *n;
  if (state.section == Section::points) data.n_points = *n;
  return {};
}

Result<LegacyData> parse_sections(LegacyFile& file, bool is_rectilinear) {
  LegacyData data;
  data.is_rectilinear = is_rectilinear;
  SectionState state;
  while (true) {
    LODE_TRY(const auto words, next_words(file));
    if (words.empty()) return data;
    const bool is_section =
        equals_ignoring_case(words[0], "POINT_DATA") || equals_ignoring_case(words[0], "CELL_DATA");
    if (is_section) {
      LODE_CHECK(start_section(file, words, state, data));
      continue;
    }
    if (state.section == Section::geometry) {
      LODE_TRY(const bool is_geometry, parse_geometry(file, words, data));
      if (is_geometry) continue;
    }
    LODE_TRY(auto attribute, parse_legacy_attribute(file, words, state.n_tuples));
    if (!attribute.is_known)
      return fail("{}: expected a legacy VTK keyword before byte {}, got {}", file.cursor.path(),
                  file.cursor.position(), in_quotes(words[0]));
    if (state.section == Section::cells && !attribute.arrays.empty()) data.has_cell_arrays = true;
    if (state.section == Section::points && data.skipped.empty() && !attribute.skipped.empty())
      data.skipped = attribute.skipped.front();
    if (state.section == Section::points)
      for (LegacyArray& array : attribute.arrays) data.arrays.push_back(std::move(array));
  }
}

Result<RegularGrid> make_rectilinear(const InputFilePtr& file, LegacyEncoding encoding,
                                     const LegacyData& data, const Index3& dims) {
  RectilinearAxes axes;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& array = data.coordinates[i];
    if (!array || array->n_tuples != dims[i])
      return fail("{}: expected {} positions along axis {}, got {}", file->path(), dims[i],
                  "xyz"[i], array ? array->n_tuples : 0);
    LODE_TRY(const auto store, load_legacy_array(file, encoding, *array, {}));
    LODE_TRY(axes.positions[i], read_doubles(*store, array->type, legacy_byte_order(encoding),
                                             static_cast<std::size_t>(dims[i])));
    axes.precisions[i] =
        array->type == ScalarType::float32 ? AxisPrecision::float32 : AxisPrecision::float64;
  }
  return make_grid(file->path(), axes);
}

Result<RegularGrid> make_legacy_grid(const InputFilePtr& file, LegacyEncoding encoding,
                                     LegacyData& data) {
  if (!data.counts) return fail("{}: expected DIMENSIONS in the header", file->path());
  LODE_TRY(const Index3 dims, checked_dims(file->path(), *data.counts));
  if (data.is_rectilinear) return make_rectilinear(file, encoding, data, dims);
  data.frame.dims = dims;
  Vec3d start;
  for (std::size_t i = 0; i < 3; ++i)
    start[i] = data.frame.spacing[i] * static_cast<double>(data.first[i]);
  data.frame.origin = data.frame.origin + data.frame.direction * start;
  return make_grid(file->path(), data.frame);
}

Result<std::vector<ImageField>> make_legacy_fields(const InputFilePtr& file,
                                                   LegacyEncoding encoding, const LegacyData& data,
                                                   const Index3& dims,
                                                   const SampleStorage& storage) {
  const std::string& path = file->path();
  if (data.arrays.empty() && data.has_cell_arrays)
    return fail("{}: expected values at points, got only cell data; convert them first", path);
  if (data.arrays.empty() && !data.skipped.empty())
    return fail("{}: expected an array of numbers under POINT_DATA, got texts or bits in {}", path,
                in_quotes(data.skipped));
  if (data.arrays.empty()) return fail("{}: expected an array under POINT_DATA, got none", path);
  std::vector<ImageField> fields;
  for (const LegacyArray& array : data.arrays) {
    ImageField field{.name = array.name, .layout = {}, .load = {}};
    LODE_TRY(field.layout, interleaved_layout(path, dims, array.type, array.n_components, 1));
    if (field.layout.n_bytes != array.n_bytes)
      return fail("{}: expected {} samples in {}, got {}", path,
                  std::int64_t{dims[0]} * dims[1] * dims[2], in_quotes(array.name), array.n_tuples);
    field.layout.byte_order = legacy_byte_order(encoding);
    field.load = [file, encoding, array, storage] {
      return load_legacy_array(file, encoding, array, storage);
    };
    fields.push_back(std::move(field));
  }
  return fields;
}

}  // namespace

Result<Image> read_vtk_legacy(const std::string& path, const SampleStorage& storage) {
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  const auto stream = make_file_stream(file, 0);
  LegacyFile legacy{.cursor = TextCursor(*stream, path)};
  LODE_TRY(const bool is_rectilinear, parse_preamble(legacy));
  LODE_TRY(LegacyData data, parse_sections(legacy, is_rectilinear));
  const bool is_binary = legacy.encoding == LegacyEncoding::binary;
  Image image{.path = path,
              .format = fmt::format("legacy VTK, {}", is_binary ? "binary" : "ascii"),
              .frame_note = "VTK files name no frame",
              .grid = {},
              .fields = {},
              .tally = file->tally()};
  LODE_TRY(image.grid, make_legacy_grid(file, legacy.encoding, data));
  LODE_TRY(image.fields, make_legacy_fields(file, legacy.encoding, data, image.grid.dims, storage));
  return image;
}

}  // namespace lode::io
