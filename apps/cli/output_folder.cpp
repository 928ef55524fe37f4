#include "output_folder.h"

#include <filesystem>
#include <system_error>
#include <utility>

namespace lode::cli {

Result<OutputFolder> OutputFolder::make(const std::string& path) {
  if (path.empty()) return OutputFolder(path, false);
  std::error_code status;
  if (std::filesystem::create_directory(path, status)) return OutputFolder(path, true);
  if (std::error_code other; !std::filesystem::is_directory(path, other))
    return fail("{}: expected a directory that is empty or can be made, got: {}", path,
                status ? status.message() : "a file");
  const bool is_empty = std::filesystem::is_empty(path, status);
  if (status) return fail("{}: {}", path, status.message());
  if (!is_empty) return fail("{}: expected an empty directory or a new one, got files in it", path);
  return OutputFolder(path, false);
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : path_(std::move(other.path_)), is_made_(std::exchange(other.is_made_, false)) {}

OutputFolder::~OutputFolder() {
  std::error_code status;  // a directory with files in it stays
  if (is_made_) std::filesystem::remove(path_, status);
}

std::string OutputFolder::path_of(const std::string& name) const {
  return (std::filesystem::path(path_) / name).string();
}

}  // namespace lode::cli
