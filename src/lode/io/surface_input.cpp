#include "lode/io/surface_input.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "lode/io/input_file.h"
#include "lode/io/surface_output.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

constexpr std::string_view kWhiteSpace = " \t\r\n\v\f";

bool has_finite_coordinates(const Vec3d& p) {
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

bool fits_float(const Vec3d& p) {
  constexpr double kMax = std::numeric_limits<float>::max();
  return std::abs(p[0]) <= kMax && std::abs(p[1]) <= kMax && std::abs(p[2]) <= kMax;
}

Vec3f narrowed(const Vec3d& p) {
  return {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
}

Vec3d lower_corner(std::span<const Vec3d> world) {
  Vec3d lower = world.empty() ? Vec3d{} : world.front();
  for (const Vec3d& p : world)
    for (std::size_t k = 0; k < 3; ++k) lower[k] = std::min(lower[k], p[k]);
  return lower;
}

/// Whether float32 offsets from `origin` give back every coordinate exactly.
bool reproduces(const Vec3d& origin, std::span<const Vec3d> world) {
  return std::all_of(world.begin(), world.end(), [&](const Vec3d& p) {
    const Vec3d offset = p - origin;
    return fits_float(offset) && origin + widened(narrowed(offset)) == p;
  });
}

template <std::size_t N>
Result<void> check_indices(const std::string& path, const char* what,
                           const std::vector<std::array<std::uint32_t, N>>& cells,
                           std::size_t n_vertices) {
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (const std::uint32_t vertex : cells[i])
      if (vertex >= n_vertices)
        return fail("{}: {} {} names vertex {}, but there are {} vertices", path, what, i, vertex,
                    n_vertices);
  return {};
}

}  // namespace

Result<SurfaceBytes> SurfaceBytes::load(const std::string& path) {
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  const auto size = static_cast<std::size_t>(file->size());
  auto bytes = std::make_unique_for_overwrite<std::byte[]>(size);
  LODE_CHECK(file->read(0, {bytes.get(), size}));
  return SurfaceBytes(std::move(bytes), size);
}

std::string_view next_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::string_view next_word(std::string_view& rest) {
  const std::size_t first = rest.find_first_not_of(kWhiteSpace);
  if (first == std::string_view::npos) {
    rest = {};
    return {};
  }
  rest.remove_prefix(first);
  const std::size_t size = std::min(rest.find_first_of(kWhiteSpace), rest.size());
  const std::string_view word = rest.substr(0, size);
  rest.remove_prefix(size);
  return word;
}

std::optional<float> to_float(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  float value = 0;
  const auto [stop, code] = std::from_chars(word.data(), end, value);
  if (stop != end) return std::nullopt;
  if (code == std::errc{}) return value;
  // from_chars calls underflow out of range too; a double tells the two apart.
  const std::optional<double> wide = to_double(word);
  if (!wide || std::abs(*wide) > 1) return std::nullopt;
  return static_cast<float>(*wide);
}

std::optional<std::uint32_t> to_index(double value) {
  if (!(value >= 0) || value > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  if (value != std::floor(value)) return std::nullopt;
  return static_cast<std::uint32_t>(value);
}

float to_attribute(double value) {
  const bool fits = std::abs(value) <= std::numeric_limits<float>::max();
  return fits ? static_cast<float>(value) : std::numeric_limits<float>::quiet_NaN();
}

std::optional<Vec3d> parse_origin_note(std::string_view comment) {
  if (next_word(comment) != kOriginNote) return std::nullopt;
  Vec3d origin;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<double> value = to_double(next_word(comment));
    if (!value || !std::isfinite(*value)) return std::nullopt;
    origin[k] = *value;
  }
  return origin;
}

Result<std::vector<Vec3d>> place_positions(const std::string& path, std::vector<Vec3d> world,
                                           const std::optional<Vec3d>& note, Surface& surface) {
  for (std::size_t i = 0; i < world.size(); ++i)
    if (!has_finite_coordinates(world[i]))
      return fail("{}: vertex {} is at ({}, {}, {}), expected finite coordinates", path, i,
                  world[i][0], world[i][1], world[i][2]);
  surface.origin = {};
  bool is_exact = true;
  if (note && reproduces(*note, world)) {
    surface.origin = *note;
  } else if (!reproduces({}, world)) {
    surface.origin = lower_corner(world);
    is_exact = reproduces(surface.origin, world);
  }
  surface.positions.resize(world.size());
  for (std::size_t i = 0; i < world.size(); ++i) {
    const Vec3d offset = world[i] - surface.origin;
    if (!fits_float(offset))
      return fail("{}: coordinates span {} and more, which float32 cannot hold", path, offset[0]);
    surface.positions[i] = narrowed(offset);
  }
  if (is_exact) world.clear();
  return world;
}

Vec3f to_origin(const Vec3d& world, const Surface& surface) {
  const Vec3d offset = world - surface.origin;
  return {{to_attribute(offset[0]), to_attribute(offset[1]), to_attribute(offset[2])}};
}

Result<void> append_polygon(const std::string& path, std::span<const std::uint32_t> corners,
                            Surface& surface) {
  if (corners.size() < 3)
    return fail("{}: expected faces of three corners or more, got one of {}", path, corners.size());
  for (std::size_t i = 2; i < corners.size(); ++i)
    surface.triangles.push_back({corners[0], corners[i - 1], corners[i]});
  return {};
}

Result<void> check_surface(const std::string& path, const Surface& surface) {
  const std::size_t n = surface.positions.size();
  if (!surface.triangles.empty() && !surface.lines.empty())
    return fail("{}: expected triangles or lines, got {} triangles and {} lines", path,
                surface.triangles.size(), surface.lines.size());
  if (!surface.normals.empty() && surface.normals.size() != n)
    return fail("{}: expected {} normals, one per vertex, got {}", path, n, surface.normals.size());
  if (!surface.isovalues.empty() && surface.isovalues.size() != n)
    return fail("{}: expected {} isovalues, one per vertex, got {}", path, n,
                surface.isovalues.size());
  if (!surface.origins.empty() && surface.origins.size() != n)
    return fail("{}: expected {} origins, one per vertex, got {}", path, n, surface.origins.size());
  for (std::size_t i = 0; i < n; ++i)
    if (!has_finite_coordinates(widened(surface.positions[i])))
      return fail("{}: expected finite coordinates, got others at vertex {}", path, i);
  LODE_CHECK(check_indices(path, "triangle", surface.triangles, n));
  return check_indices(path, "line", surface.lines, n);
}

}  // namespace lode::io
