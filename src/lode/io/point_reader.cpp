#include "lode/io/point_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <new>
#include <system_error>
#include <utility>

#include "lode/core/out_of_memory.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/height_transform.h"
#include "lode/io/point_las.h"
#include "lode/io/point_text.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

bool is_las_path(const std::string& path) {
  const std::string name = to_lower(path);
  return name.ends_with(".las") || name.ends_with(".laz");
}

/// Whether a file begins with bytes that no text has.
bool begins_as_binary(const std::string& path) {
  std::array<char, 64> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), bytes.size());
  return std::any_of(bytes.begin(), bytes.begin() + file.gcount(), [](char c) {
    return static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\n' && c != '\r';
  });
}

bool is_plot3d_grid(const std::string& path) {
  if (!to_lower(path).ends_with(".xyz")) return false;
  std::error_code status;
  return std::filesystem::exists(std::filesystem::path(path).replace_extension(".q"), status) ||
         begins_as_binary(path);
}

Result<void> check_left(const std::string& path, const PointFile& file) {
  if (!file.points.empty()) return {};
  const PointCounts& counts = file.counts;
  return fail(
      "{}: expected points, got none: of {} in the file {} are of other classes, {} withheld and "
      "{} without a height",
      path, counts.n_in_file, counts.n_other_class, counts.n_withheld, counts.n_missing);
}

/// Of text whose heading says longitude and latitude, and nothing what of: WGS 84. Returns what is
/// to be said of that.
std::string take_degrees(PointFile& file) {
  if (!file.has_degrees || !file.crs.empty()) return "";
  constexpr double kPole = 90;
  constexpr double kTurn = 360;
  const bool may_be = std::ranges::all_of(file.points, [](const Vec3d& p) {
    return std::abs(p[0]) <= kTurn && std::abs(p[1]) <= kPole;
  });
  if (!may_be)
    return "its heading says longitude and latitude, but there are some beyond 360 and 90 degrees: "
           "they are taken for x and y in a plane; --crs says what they are";
  auto degrees = to_horizontal_wkt("EPSG:4326");
  if (!degrees)
    return "its heading says longitude and latitude, which are taken for x and y in a plane: " +
           degrees.error().message;
  file.crs = std::move(degrees).value();
  return "its longitudes and latitudes are taken for those of WGS 84, as the file does not say: "
         "--crs says it";
}

}  // namespace

bool is_point_path(const std::string& path) {
  if (is_las_path(path)) return true;
  const std::string name = to_lower(path);
  constexpr std::array kExtensions{".xyz", ".txt", ".csv", ".xyz.gz", ".txt.gz", ".csv.gz"};
  return std::ranges::any_of(kExtensions,
                             [&](const char* extension) { return name.ends_with(extension); }) &&
         !is_plot3d_grid(path);
}

Result<PointFile> read_points(const std::string& path, const PointReadOptions& options,
                              Progress& progress) try {
  const bool is_las = is_las_path(path);
  if (!is_las && !options.classes.empty())
    return fail("{}: expected no classes to keep of a text file, whose points have none, got some",
                path);
  if (auto status = check_vertical(options.vertical); !status)
    return fail("{}: {}", path, status.error().message);
  std::string crs;
  if (!options.crs.empty()) {
    auto wkt = to_horizontal_wkt(options.crs);
    if (!wkt) return fail("{}: {}", path, wkt.error().message);
    crs = std::move(wkt).value();
  }
  LODE_TRY(PointFile file,
           is_las ? read_las(path, options, progress) : read_point_text(path, options, progress));
  LODE_CHECK(check_left(path, file));
  if (!crs.empty()) file.crs = std::move(crs);
  const std::string note = take_degrees(file);
  auto outcome = set_vertical(file, options.vertical, progress);
  if (!outcome && progress.is_cancelled()) return outcome.error();
  if (!outcome) return fail("{}: {}", path, outcome.error().message);
  file.vertical = std::move(outcome).value();
  if (!note.empty()) file.vertical.notes.push_back(note);
  return file;
} catch (const std::bad_alloc&) {
  return out_of_memory("read the points", path);
}

}  // namespace lode::io
