#include "lode/io/zarr_volume.h"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "lode/io/dicom.h"
#include "lode/io/image.h"
#include "lode/io/image_grid.h"
#include "lode/io/image_source.h"
#include "lode/io/layer_spool.h"
#include "lode/io/ome_zarr.h"
#include "lode/io/sample_storage.h"
#include "lode/io/text.h"
#include "lode/io/zarr_array.h"
#include "lode/io/zarr_source.h"

namespace lode::io {
namespace {

/// An image in a directory, before its array was read.
struct ZarrEntry {
  std::string array_path;  ///< Below the directory; empty for the directory itself.
  std::string field_name;
  std::optional<OmeImage> ome;
};

struct ZarrImage {
  ZarrArray array;
  std::string field_name;
  std::size_t n_leading = 0;  ///< Axes before those of space.
  std::optional<std::size_t> time_axis;
  std::optional<std::size_t> component_axis;
  RegularGrid grid;
  std::string format;
  std::string frame_note;
  std::string length_unit;

  [[nodiscard]] std::int64_t count_along(const std::optional<std::size_t>& axis) const {
    return axis ? array.shape[*axis] : 1;
  }
};

/// The names of arrays and groups right below a group, sorted.
struct ZarrChildren {
  std::vector<std::string> arrays;
  std::vector<std::string> groups;
};

Result<ZarrChildren> list_children(const std::string& path) {
  ZarrChildren children;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (!entry.is_directory()) continue;
    LODE_TRY(const ZarrNode node, zarr_node_at(entry.path().string()));
    const std::string name = entry.path().filename().string();
    if (node == ZarrNode::array) children.arrays.push_back(name);
    if (node == ZarrNode::group) children.groups.push_back(name);
  }
  std::sort(children.arrays.begin(), children.arrays.end());
  std::sort(children.groups.begin(), children.groups.end());
  return children;
}

/// The path of an array says nothing about the image, unless there are several to tell apart.
Result<std::vector<ZarrEntry>> list_ome_images(const std::string& path) {
  LODE_TRY(const std::vector<OmeImage> images, read_ome_images(path));
  std::vector<ZarrEntry> entries;
  entries.reserve(images.size());
  for (const OmeImage& image : images)
    entries.push_back({image.array_path, images.size() > 1 ? image.array_path : "", image});
  return entries;
}

Result<std::vector<ZarrEntry>> list_images(const std::string& path) {
  LODE_TRY(const ZarrNode node, zarr_node_at(path));
  if (node == ZarrNode::none) {
    if (auto dicom = refuse_dicom(path)) return *dicom;
    return fail(
        "{}: expected a file, or a directory with .zarray, .zgroup or zarr.json (Zarr), "
        "got another directory",
        path);
  }
  if (node == ZarrNode::array) return std::vector<ZarrEntry>(1);
  LODE_TRY(std::vector<ZarrEntry> entries, list_ome_images(path));
  if (!entries.empty()) return entries;
  LODE_TRY(const ZarrChildren children, list_children(path));
  for (const std::string& name : children.arrays) entries.push_back({name, name, {}});
  if (!entries.empty()) return entries;
  if (children.groups.empty())
    return fail("{}: expected a Zarr group with an array in it, got an empty one", path);
  return fail(
      "{}: expected a Zarr group with an array in it, got one of the groups {}; open one "
      "of them",
      path, fmt::join(children.groups, ", "));
}

/// The field that the options pick; any choice is good enough to describe the whole.
Result<ZarrEntry> choose_entry(const std::string& path, const std::vector<ZarrEntry>& entries,
                               const ReadOptions& options) {
  std::vector<std::string> names;
  names.reserve(entries.size());
  for (const ZarrEntry& entry : entries) names.push_back(entry.array_path);
  LODE_TRY(const std::size_t i, choose_field(path, names, options));
  return entries[i];
}

/// In front of y, x and a z: the axis right before is the component, the one before that time,
/// unless they have names that say otherwise.
void name_leading_axes(ZarrImage& image) {
  for (std::size_t axis = 0; axis < image.n_leading; ++axis) {
    const auto& names = image.array.dimension_names;
    if (axis < names.size() && (names[axis] == "t" || names[axis] == "time"))
      image.time_axis = axis;
  }
  for (std::size_t axis = image.n_leading; axis > 0; --axis) {
    if (image.time_axis == axis - 1) continue;
    (image.component_axis ? image.time_axis : image.component_axis) = axis - 1;
  }
}

Result<void> take_ome_axes(const std::string& path, const OmeImage& ome, ZarrImage& image) {
  if (ome.axes.size() != image.array.shape.size())
    return fail("{}: expected an array of {} axes in {}, as its image has, got {}", path,
                ome.axes.size(), in_quotes(ome.array_path), image.array.shape.size());
  image.n_leading = ome.n_leading();
  for (std::size_t axis = 0; axis < image.n_leading; ++axis)
    (ome.axes[axis].kind == OmeAxisKind::time ? image.time_axis : image.component_axis) = axis;
  return {};
}

Result<Index3> dims_of(const std::string& path, const ZarrImage& image) {
  std::array<std::int64_t, 3> counts = {1, 1, 1};
  const std::size_t rank = image.array.shape.size();
  for (std::size_t i = 0; i < rank - image.n_leading; ++i)
    counts[i] = image.array.shape[rank - 1 - i];
  return checked_dims(path, counts);
}

Result<ZarrImage> read_image(const std::string& path, const ZarrEntry& entry) {
  ZarrImage image;
  image.field_name = entry.field_name;
  LODE_TRY(image.array,
           read_zarr_array(entry.array_path.empty() ? path : path + '/' + entry.array_path));
  image.format =
      fmt::format("Zarr v{}, {}", image.array.version, describe_codecs(image.array.codecs));
  if (entry.ome) {
    LODE_CHECK(take_ome_axes(path, *entry.ome, image));
    LODE_TRY(const Index3 dims, dims_of(path, image));
    LODE_TRY(image.grid, make_grid(path, grid_steps(*entry.ome, dims)));
    const std::string& version = entry.ome->version;
    image.format =
        fmt::format("OME-Zarr{}{}, {}", version.empty() ? "" : " ", version, image.format);
    image.frame_note = describe_axes(*entry.ome);
    image.length_unit = length_unit_of(*entry.ome);
    return image;
  }
  image.n_leading = std::max<std::size_t>(image.array.shape.size(), 3) - 3;
  name_leading_axes(image);
  GridFrame frame;
  LODE_TRY(frame.dims, dims_of(path, image));
  LODE_TRY(image.grid, make_grid(path, frame));
  image.frame_note = "Zarr arrays name no frame and no spacing";
  return image;
}

Result<std::int64_t> choose_channel(const std::string& path, std::int64_t n,
                                    const ReadOptions& options) {
  if (!options.component) {
    if (n == 1) return std::int64_t{0};
    return fail("{}: holds {} components; choose one with --component N, 0 to {}", path, n, n - 1);
  }
  if (!std::holds_alternative<int>(*options.component))
    return fail(
        "{}: expected --component N, 0 to {}, got magnitude: the components of Zarr arrays are "
        "channels, not vectors",
        path, n - 1);
  const std::int64_t component = std::get<int>(*options.component);
  if (component < 0 || component >= n)
    return fail("{}: expected --component between 0 and {}, got {}", path, n - 1, component);
  return component;
}

Result<void> check_is_foreign_to_raw(const std::string& path, const ReadOptions& options) {
  if (!options.raw) return {};
  return fail("{}: a directory describes itself; --dims, --type and the like are for bare samples",
              path);
}

}  // namespace

Result<std::unique_ptr<VolumeSource>> open_zarr(const std::string& path,
                                                const ReadOptions& options) {
  LODE_CHECK(check_is_foreign_to_raw(path, options));
  LODE_CHECK(check_nodata(path, options));
  LODE_TRY(const std::vector<ZarrEntry> entries, list_images(path));
  LODE_TRY(const ZarrEntry entry, choose_entry(path, entries, options));
  LODE_TRY(ZarrImage image, read_image(path, entry));
  ZarrShape place(image.n_leading, 0);
  LODE_TRY(const std::int64_t time, choose_time(path, image.count_along(image.time_axis), options));
  LODE_TRY(const std::int64_t component,
           choose_channel(path, image.count_along(image.component_axis), options));
  if (image.time_axis) place[*image.time_axis] = time;
  if (image.component_axis) place[*image.component_axis] = component;
  VolumeInfo info{.grid = image.grid,
                  .type = image.array.type,
                  .field_name = image.field_name,
                  .nodata = options.nodata,
                  .units = chosen_units({image.length_unit, {}}, options)};
  auto source = make_zarr_source({std::move(image.array), std::move(place)}, std::move(info),
                                 options.threads, options.cache_limit);
  // Who sets a limit, as builds do, reads all of it in slices; others may want a box of it.
  if (options.cache_limit == std::numeric_limits<std::size_t>::max()) return source;
  return LayerSpool::wrap(std::move(source), spool_directory_of(storage_of(options)));
}

Result<FileDescription> describe_zarr(const std::string& path, const ReadOptions& options) {
  LODE_CHECK(check_is_foreign_to_raw(path, options));
  LODE_TRY(const std::vector<ZarrEntry> entries, list_images(path));
  ZarrEntry entry = entries.front();
  if (options.field) {
    LODE_TRY(entry, choose_entry(path, entries, options));
  }
  LODE_TRY(const ZarrImage image, read_image(path, entry));
  FileDescription description{.format = image.format,
                              .frame_note = image.frame_note,
                              .fields = {},
                              .grid = image.grid,
                              .type = image.array.type,
                              .units = chosen_units({image.length_unit, {}}, options)};
  for (const ZarrEntry& each : entries) description.fields.push_back(each.array_path);
  description.n_components = static_cast<int>(image.count_along(image.component_axis));
  description.n_times = static_cast<int>(image.count_along(image.time_axis));
  return description;
}

}  // namespace lode::io
