#include "lode/io/nrrd_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "lode/io/image_grid.h"
#include "lode/io/nrrd_units.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr std::size_t kMaxAxes = 16;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

enum class Role { space, component, time };

struct Axis {
  std::int64_t size = 0;
  Role role = Role::space;
  std::int64_t stride = 1;
  std::optional<Vec3d> step;  ///< From "space directions".
  double spacing = kUnknown;
  double min = kUnknown;
  double max = kUnknown;
  bool is_node_centred = false;
};

const std::string* find(const NrrdFields& fields, const char* key) {
  const auto it = fields.find(key);
  return it == fields.end() ? nullptr : &it->second;
}

/// "(1,0,0)" as up to three numbers (the rest zero), nothing for "none".
Result<std::optional<Vec3d>> parse_vector(const std::string& path, std::string_view text) {
  if (equals_ignoring_case(trimmed(text), "none")) return std::optional<Vec3d>();
  std::string inner(trimmed(text));
  if (inner.size() < 2 || inner.front() != '(' || inner.back() != ')')
    return fail("{}: expected a vector like (1,0,0), got {}", path, in_quotes(text));
  inner = inner.substr(1, inner.size() - 2);
  std::replace(inner.begin(), inner.end(), ',', ' ');
  const auto numbers = to_doubles(inner);
  if (!numbers || numbers->empty() || numbers->size() > 3)
    return fail("{}: expected a vector of up to 3 numbers, got {}", path, in_quotes(text));
  Vec3d vector;
  std::copy(numbers->begin(), numbers->end(), vector.v.begin());
  return std::optional<Vec3d>(vector);
}

/// Splits "none (1,0,0) (0, 1, 0)", which may hold blanks inside the parentheses.
std::vector<std::string> split_vectors(std::string_view text) {
  std::vector<std::string> parts;
  bool is_inside = false;
  bool is_open = false;
  for (const char c : text) {
    const bool is_blank = c == ' ' || c == '\t';
    if (c == '(') is_inside = true;
    if (is_blank && !is_inside) {
      is_open = false;
      continue;
    }
    if (!is_open || c == '(') parts.emplace_back();
    is_open = true;
    parts.back() += c;
    if (c == ')') is_inside = is_open = false;
  }
  return parts;
}

Result<std::vector<Axis>> parse_sizes(const std::string& path, const NrrdFields& fields) {
  const std::string* dimension = find(fields, "dimension");
  const std::string* sizes_text = find(fields, "sizes");
  if (dimension == nullptr || sizes_text == nullptr)
    return fail("{}: expected the fields 'dimension' and 'sizes' in the NRRD header", path);
  const auto n = to_int64(*dimension);
  const auto sizes = to_int64s(*sizes_text);
  if (!n || *n < 1 || *n > static_cast<std::int64_t>(kMaxAxes))
    return fail("{}: expected a dimension between 1 and {}, got {}", path, kMaxAxes,
                in_quotes(*dimension));
  if (!sizes || sizes->size() != static_cast<std::size_t>(*n))
    return fail("{}: expected {} sizes, got {}", path, *n, in_quotes(*sizes_text));
  std::vector<Axis> axes(sizes->size());
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i].size = (*sizes)[i];
  return axes;
}

/// Strides after the sizes are known not to overflow.
Result<std::uint64_t> set_strides(const std::string& path, std::vector<Axis>& axes,
                                  ScalarType type) {
  std::vector<std::int64_t> sizes;
  sizes.reserve(axes.size());
  for (const Axis& axis : axes) sizes.push_back(axis.size);
  LODE_TRY(const std::uint64_t n_bytes, checked_n_bytes(path, sizes, size_of(type)));
  for (std::size_t i = 1; i < axes.size(); ++i)
    axes[i].stride = axes[i - 1].stride * axes[i - 1].size;
  return n_bytes;
}

Result<void> parse_numbers(const std::string& path, const NrrdFields& fields, const char* key,
                           std::vector<Axis>& axes, double Axis::*member) {
  const std::string* text = find(fields, key);
  if (text == nullptr) return {};
  std::string cleaned = to_lower(*text);
  const auto numbers = to_doubles(cleaned);
  if (!numbers || numbers->size() != axes.size())
    return fail("{}: expected {} numbers in '{}', got {}", path, axes.size(), key,
                in_quotes(*text));
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i].*member = (*numbers)[i];
  return {};
}

Result<void> parse_directions(const std::string& path, const NrrdFields& fields,
                              std::vector<Axis>& axes) {
  const std::string* text = find(fields, "space directions");
  if (text == nullptr) return {};
  const std::vector<std::string> parts = split_vectors(*text);
  if (parts.size() != axes.size())
    return fail("{}: expected {} space directions, got {}", path, axes.size(), in_quotes(*text));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    LODE_TRY(axes[i].step, parse_vector(path, parts[i]));
    if (!axes[i].step) axes[i].role = Role::component;
  }
  return {};
}

Result<void> parse_kinds(const std::string& path, const NrrdFields& fields,
                         std::vector<Axis>& axes) {
  const std::string* text = find(fields, "kinds");
  if (text == nullptr) {
    const bool has_directions = find(fields, "space directions") != nullptr;
    if (axes.size() == 4 && !has_directions) axes[3].role = Role::time;
    return {};
  }
  const auto kinds = split_words(*text);
  if (kinds.size() != axes.size())
    return fail("{}: expected {} kinds, got {}", path, axes.size(), in_quotes(*text));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::string kind = to_lower(kinds[i]);
    const bool is_unknown = kind == "none" || kind == "???";
    if (kind == "domain" || kind == "space")
      axes[i].role = Role::space;
    else if (kind == "time")
      axes[i].role = Role::time;
    else if (!is_unknown)
      axes[i].role = Role::component;
  }
  return {};
}

void parse_centerings(const NrrdFields& fields, std::vector<Axis>& axes) {
  for (const char* key : {"centerings", "centers"})
    if (const std::string* text = find(fields, key)) {
      const auto words = split_words(*text);
      for (std::size_t i = 0; i < std::min(words.size(), axes.size()); ++i)
        axes[i].is_node_centred = equals_ignoring_case(words[i], "node");
    }
}

/// The step of space axis number `k`, and where its first sample lies by the axis' own minimum.
Vec3d step_of(const Axis& axis, std::size_t k, double& first) {
  if (axis.step) return *axis.step;
  Vec3d step;
  const double n_gaps = static_cast<double>(axis.is_node_centred ? axis.size - 1 : axis.size);
  const bool has_extent = std::isfinite(axis.min) && std::isfinite(axis.max) && n_gaps > 0;
  step[k] = has_extent ? (axis.max - axis.min) / n_gaps : 1;
  if (!std::isnan(axis.spacing)) step[k] = axis.spacing;
  if (std::isfinite(axis.min)) first = axis.min + (axis.is_node_centred ? 0 : 0.5 * step[k]);
  return step;
}

std::string note_nrrd_frame(const NrrdFields& fields, Frame& frame) {
  const std::string* space = find(fields, "space");
  if (space == nullptr) return "the header names no space";
  std::string name = to_lower(*space);
  if (name.ends_with("-time")) name.resize(name.size() - 5);
  if (name.size() == 4 && name.ends_with("t")) name.resize(3);
  if (name == "right-anterior-superior" || name == "ras") frame = Frame::ras;
  if (name == "left-posterior-superior" || name == "lps") frame = Frame::lps;
  return fmt::format("space: {}", in_quotes(*space));
}

Result<RegularGrid> make_nrrd_grid(const std::string& path, const NrrdFields& fields,
                                   const std::vector<const Axis*>& space_axes, Frame frame) {
  std::array<std::int64_t, 3> counts = {1, 1, 1};
  GridSteps steps{.dims = {}, .steps = {}, .frame = frame};
  for (std::size_t k = 0; k < space_axes.size(); ++k) {
    counts[k] = space_axes[k]->size;
    steps.steps[k] = step_of(*space_axes[k], k, steps.origin[k]);
  }
  LODE_TRY(steps.dims, checked_dims(path, counts));
  if (const std::string* text = find(fields, "space origin")) {
    LODE_TRY(const auto origin, parse_vector(path, *text));
    if (origin) steps.origin = *origin;
  }
  return make_grid(path, steps);
}

}  // namespace

Result<NrrdAxes> parse_nrrd_axes(const std::string& path, const NrrdFields& fields,
                                 ScalarType type) {
  LODE_TRY(std::vector<Axis> axes, parse_sizes(path, fields));
  NrrdAxes result;
  LODE_TRY(result.layout.n_bytes, set_strides(path, axes, type));
  LODE_CHECK(parse_numbers(path, fields, "spacings", axes, &Axis::spacing));
  LODE_CHECK(parse_numbers(path, fields, "axis mins", axes, &Axis::min));
  LODE_CHECK(parse_numbers(path, fields, "axis maxs", axes, &Axis::max));
  LODE_CHECK(parse_directions(path, fields, axes));
  LODE_CHECK(parse_kinds(path, fields, axes));
  parse_centerings(fields, axes);

  result.layout.type = type;
  std::vector<const Axis*> space_axes;
  int n_other[2] = {0, 0};
  for (const Axis& axis : axes) {
    if (axis.role == Role::space) {
      if (space_axes.size() < 3) result.layout.strides[space_axes.size()] = axis.stride;
      space_axes.push_back(&axis);
      continue;
    }
    const bool is_time = axis.role == Role::time;
    ++n_other[is_time ? 1 : 0];
    (is_time ? result.layout.n_times : result.layout.n_components) = axis.size;
    (is_time ? result.layout.time_stride : result.layout.component_stride) = axis.stride;
  }
  if (space_axes.empty() || space_axes.size() > 3 || n_other[0] > 1 || n_other[1] > 1)
    return fail(
        "{}: expected 1 to 3 axes of space, at most one of components and one of time, got {}, {} "
        "and {}",
        path, space_axes.size(), n_other[0], n_other[1]);
  Frame frame = Frame::unknown;
  result.frame_note = note_nrrd_frame(fields, frame);
  std::vector<bool> is_spatial;
  is_spatial.reserve(axes.size());
  for (const Axis& axis : axes) is_spatial.push_back(axis.role == Role::space);
  result.length_unit = nrrd_length_unit(fields, is_spatial, result.frame_note);
  LODE_TRY(result.grid, make_nrrd_grid(path, fields, space_axes, frame));
  // The rows of missing axes follow one another, so that whole slices are read at once.
  for (std::size_t k = space_axes.size(); k < 3; ++k)
    result.layout.strides[k] = result.layout.strides[k - 1] * result.grid.dims[k - 1];
  return result;
}

}  // namespace lode::io
