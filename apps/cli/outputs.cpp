#include "outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "lode/api/files.h"
#include "text.h"

namespace lode::cli {
namespace {

std::string extension_of(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

std::string path_for_isovalue(const std::string& path, double isovalue) {
  const std::filesystem::path whole(path);
  std::filesystem::path named = whole.parent_path() / whole.stem();
  named += fmt::format("-{}", isovalue);
  named += whole.extension();
  return named.string();
}

}  // namespace

Result<void> check_surface_extension(const std::string& path) {
  auto status = check_surface_path(path);
  if (status) return {};
  const std::string hint = closest_to(extension_of(path), {".ply", ".stl", ".obj", ".vtp", ".glb"});
  if (hint.empty()) return status.error();
  return fail("{}; did you mean {}?", status.error().message, hint);
}

Result<void> check_holds(const std::string& path, const VolumeInfo& volume) {
  const Index3& dims = volume.grid.dims;
  const bool is_flat = dims[0] == 1 || dims[1] == 1 || dims[2] == 1;
  if (!is_flat || can_hold_lines(path)) return {};
  return fail(
      "{}: expected a format that holds the contour lines of 2D data ({} x {} x {} samples), "
      "such as .vtp or .obj, got {}",
      path, dims[0], dims[1], dims[2], extension_of(path));
}

Result<void> check_extension(const std::string& path, const std::string& extension) {
  const std::string got = extension_of(path);
  if (got == extension) return {};
  return fail("{}: expected an output that ends in {}, got {}", path, extension,
              got.empty() ? "no extension" : got);
}

std::vector<std::string> paths_for_isovalues(const std::string& path,
                                             const std::vector<double>& isovalues) {
  if (isovalues.size() <= 1 || can_hold_isovalues(path)) return {path};
  std::vector<std::string> paths;
  paths.reserve(isovalues.size());
  for (const double isovalue : isovalues) paths.push_back(path_for_isovalue(path, isovalue));
  return paths;
}

OutputSet::OutputSet(const std::vector<std::string>& planned) {
  std::error_code status;
  for (const std::string& path : planned)
    if (std::filesystem::exists(path, status)) replaced_.push_back(path);
}

OutputSet::~OutputSet() {
  if (is_kept_) return;
  std::error_code status;
  for (const std::string& path : paths_)
    if (std::ranges::find(replaced_, path) == replaced_.end())
      std::filesystem::remove(path, status);
}

}  // namespace lode::cli
