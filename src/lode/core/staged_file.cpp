#include "lode/core/staged_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace lode {
namespace {

Error system_error(const std::string& path, const char* action) {
  const std::error_code reason(errno, std::generic_category());
  return fail("{}: cannot {}: {}", path, action, reason.message());
}

/// Flushes a file or directory.
bool flush(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_flushed = ::fsync(descriptor) == 0;
  ::close(descriptor);
  return is_flushed;
}

}  // namespace

Result<StagedFile> StagedFile::create(std::string path) {
  std::string folder = path + ".tmp-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr)
    return system_error(path, "make a temporary folder beside it");
  return StagedFile(std::move(path), std::move(folder));
}

StagedFile::~StagedFile() {
  if (folder_.empty()) return;
  std::error_code status;
  std::filesystem::remove_all(folder_, status);
}

std::string StagedFile::name() const {
  return (std::filesystem::path(folder_) / std::filesystem::path(path_).filename()).string();
}

Result<void> StagedFile::commit(const Progress& progress) {
  if (!flush(name())) return system_error(path_, "flush what was written");
  if (progress.is_cancelled()) return cancelled_error();
  if (::rename(name().c_str(), path_.c_str()) != 0) return system_error(path_, "rename into place");
  const std::filesystem::path parent = std::filesystem::path(path_).parent_path();
  if (!flush(parent.empty() ? "." : parent.string()))
    return system_error(path_, "flush its directory");
  return {};
}

}  // namespace lode
