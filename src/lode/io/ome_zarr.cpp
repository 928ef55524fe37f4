#include "lode/io/ome_zarr.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "lode/io/text.h"
#include "lode/io/zarr_array.h"
#include "lode/io/zarr_json.h"

namespace lode::io {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxTransformations = 16;

bool is_within_its_group(std::string_view path) {
  // Neither absolute nor with a component that is empty or leads upwards.
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view part = path.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") return false;
    begin = end + 1;
  }
  return std::none_of(path.begin(), path.end(), [](char c) { return c >= 0 && c < ' '; });
}

/// A text that is shown to people, whatever the file has there.
std::string shown(const json& text) {
  const std::string quotes = in_quotes(text.get_ref<const std::string&>());
  return quotes.substr(1, quotes.size() - 2);
}

Result<OmeAxis> parse_axis(const std::string& path, const json& value) {
  // Version 0.3 had bare names.
  const json* name = value.is_string() ? &value : find_member(value, "name");
  if (name == nullptr || !name->is_string())
    return fail("{}: expected a name for each of the axes, got {}", path, quoted_json(value));
  OmeAxis axis;
  axis.name = shown(*name);
  const json* type = find_member(value, "type");
  const json* unit = find_member(value, "unit");
  const bool is_named_space = axis.name == "x" || axis.name == "y" || axis.name == "z";
  const bool is_named_time = axis.name == "t";
  axis.kind = OmeAxisKind::channel;
  if (type == nullptr ? is_named_space : json_is(*type, "space")) axis.kind = OmeAxisKind::space;
  if (type == nullptr ? is_named_time : json_is(*type, "time")) axis.kind = OmeAxisKind::time;
  if (unit != nullptr && unit->is_string()) axis.unit = shown(*unit);
  return axis;
}

Result<void> check_axes(const std::string& path, const std::vector<OmeAxis>& axes) {
  std::size_t n_space = 0;
  std::size_t n_time = 0;
  for (const OmeAxis& axis : axes) {
    if (axis.kind == OmeAxisKind::time) ++n_time;
    if (axis.kind == OmeAxisKind::space)
      ++n_space;
    else if (n_space > 0)
      return fail("{}: expected the axes of space behind all others, got {} there", path,
                  in_quotes(axis.name));
  }
  const std::size_t n_channels = axes.size() - n_space - n_time;
  if (n_space < 2 || n_space > 3 || n_time > 1 || n_channels > 1)
    return fail(
        "{}: expected two or three axes of space, one of time and one of channels at most, "
        "got {}, {} and {}",
        path, n_space, n_time, n_channels);
  return {};
}

Result<std::vector<OmeAxis>> parse_axes(const std::string& path, const json& multiscale) {
  // Before version 0.3 all images had these.
  static const json kImpliedAxes = {"t", "c", "z", "y", "x"};
  const json* list = find_member(multiscale, "axes");
  if (list == nullptr) list = &kImpliedAxes;
  if (!list->is_array() || list->size() > kMaxZarrRank)
    return fail("{}: expected at most {} axes, got {}", path, kMaxZarrRank, quoted_json(*list));
  std::vector<OmeAxis> axes;
  for (const json& each : *list) {
    LODE_TRY(OmeAxis axis, parse_axis(path, each));
    axes.push_back(std::move(axis));
  }
  LODE_CHECK(check_axes(path, axes));
  return axes;
}

Result<std::vector<double>> parse_axis_numbers(const std::string& path, const json& transformation,
                                               const std::string& key, std::size_t rank) {
  const json* list = find_member(transformation, key);
  bool is_good = list != nullptr && list->is_array() && list->size() == rank;
  if (is_good)
    for (const json& each : *list) is_good = is_good && each.is_number();
  if (is_good) return list->get<std::vector<double>>();
  return fail("{}: expected {} numbers for {}, got {}", path, rank, key,
              quoted_json(transformation));
}

/// Applies the coordinateTransformations of a dataset or a multiscale, if it has any, to an image.
Result<void> transform(const std::string& path, const json& object, OmeImage& image) {
  const json* list = find_member(object, "coordinateTransformations");
  if (list == nullptr) return {};
  if (!list->is_array() || list->size() > kMaxTransformations)
    return fail("{}: expected at most {} coordinateTransformations, got {}", path,
                kMaxTransformations, quoted_json(*list));
  const std::size_t rank = image.axes.size();
  for (const json& each : *list) {
    LODE_TRY(const std::string type, json_text(path, each, "type"));
    if (type == "identity") continue;
    if (type != "scale" && type != "translation")
      return fail("{}: expected a transformation scale, translation or identity, got {}", path,
                  in_quotes(type));
    LODE_TRY(const auto numbers, parse_axis_numbers(path, each, type, rank));
    for (std::size_t axis = 0; axis < rank; ++axis) {
      if (type == "translation") {
        image.translation[axis] += numbers[axis];
        continue;
      }
      image.scale[axis] *= numbers[axis];
      image.translation[axis] *= numbers[axis];
    }
  }
  return {};
}

Result<OmeImage> parse_multiscale(const std::string& path, const json& multiscale) {
  OmeImage image;
  LODE_TRY(image.axes, parse_axes(path, multiscale));
  image.scale.assign(image.axes.size(), 1);
  image.translation.assign(image.axes.size(), 0);
  const json* datasets = find_member(multiscale, "datasets");
  if (datasets == nullptr || !datasets->is_array() || datasets->empty())
    return fail("{}: expected a list of datasets in multiscales, got {}", path,
                quoted_json(datasets));
  LODE_TRY(image.array_path, json_text(path, datasets->front(), "path"));
  if (!is_within_its_group(image.array_path))
    return fail("{}: expected the path of a dataset below its group, got {}", path,
                in_quotes(image.array_path));
  LODE_CHECK(transform(path, datasets->front(), image));
  LODE_CHECK(transform(path, multiscale, image));
  const json* version = find_member(multiscale, "version");
  if (version != nullptr && version->is_string()) image.version = shown(*version);
  return image;
}

Result<std::vector<OmeImage>> parse_multiscales(const std::string& path, const json& attributes) {
  std::vector<OmeImage> images;
  const json* list = find_member(attributes, "multiscales");
  if (list == nullptr) return images;
  if (!list->is_array())
    return fail("{}: expected a list of multiscales, got {}", path, quoted_json(*list));
  for (const json& each : *list) {
    LODE_TRY(OmeImage image, parse_multiscale(path, each));
    images.push_back(std::move(image));
  }
  return images;
}

/// 0, 1 or 2 for x, y or z.
std::optional<std::size_t> world_axis_of(const OmeAxis& axis) {
  if (axis.name.size() != 1 || axis.name[0] < 'x' || axis.name[0] > 'z') return std::nullopt;
  return static_cast<std::size_t>(axis.name[0] - 'x');
}

}  // namespace

std::size_t OmeImage::n_leading() const {
  return static_cast<std::size_t>(std::count_if(
      axes.begin(), axes.end(), [](const auto& axis) { return axis.kind != OmeAxisKind::space; }));
}

Result<std::vector<OmeImage>> read_ome_images(const std::string& directory) {
  const std::string v3 = directory + "/zarr.json";
  if (std::filesystem::exists(v3)) {
    LODE_TRY(const json metadata, read_json_object(v3));
    const json* attributes = find_member(metadata, "attributes");
    const json* ome = attributes == nullptr ? nullptr : find_member(*attributes, "ome");
    if (ome == nullptr) return std::vector<OmeImage>{};
    LODE_TRY(std::vector<OmeImage> images, parse_multiscales(v3, *ome));
    const json* version = find_member(*ome, "version");
    if (version != nullptr && version->is_string())
      for (OmeImage& image : images) image.version = shown(*version);
    return images;
  }
  const std::string v2 = directory + "/.zattrs";
  if (!std::filesystem::exists(v2)) return std::vector<OmeImage>{};
  LODE_TRY(const json attributes, read_json_object(v2));
  return parse_multiscales(v2, attributes);
}

GridSteps grid_steps(const OmeImage& image, const Index3& dims) {
  GridSteps steps{.dims = dims, .steps = {}};
  const std::size_t n_space = image.axes.size() - image.n_leading();
  std::array<std::size_t, 3> world = {0, 1, 2};
  std::array<bool, 3> is_taken{};
  bool has_names = true;
  for (std::size_t i = 0; i < n_space; ++i) {
    const auto named = world_axis_of(image.axes[image.axes.size() - 1 - i]);
    has_names = has_names && named && *named < n_space && !is_taken[*named];
    if (!has_names) break;
    is_taken[*named] = true;
    world[i] = *named;
  }
  if (!has_names) world = {0, 1, 2};
  for (std::size_t i = 0; i < n_space; ++i) {
    const std::size_t axis = image.axes.size() - 1 - i;
    steps.steps[i][world[i]] = image.scale[axis];
    steps.origin[world[i]] = image.translation[axis];
  }
  return steps;
}

std::string length_unit_of(const OmeImage& image) {
  const std::string& unit = image.axes.back().unit;
  const auto differs = [&](const OmeAxis& axis) { return axis.unit != unit; };
  const auto first = image.axes.begin() + static_cast<std::ptrdiff_t>(image.n_leading());
  return std::any_of(first, image.axes.end(), differs) ? std::string() : unit;
}

std::string describe_axes(const OmeImage& image) {
  std::vector<std::string> names;
  std::vector<std::string> units;
  for (std::size_t axis = image.n_leading(); axis < image.axes.size(); ++axis) {
    names.push_back(image.axes[axis].name);
    const std::string& unit = image.axes[axis].unit;
    units.push_back(unit.empty() ? "unknown units" : unit);
  }
  const bool is_one_unit = std::equal(units.begin() + 1, units.end(), units.begin());
  if (is_one_unit) units.resize(1);
  return fmt::format("OME-Zarr axes {} in {}", fmt::join(names, ", "), fmt::join(units, ", "));
}

}  // namespace lode::io
