#include "lode/core/staged_file.h"

#include <fcntl.h>
#include <sys/stat.h>
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

/// Flushes the file system that a folder is on: many files at once.
bool flush_all(const std::string& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_flushed = ::syncfs(descriptor) == 0;
  ::close(descriptor);
  return is_flushed;
}

/// The directory that a path is in, when it outlasts a loss of power.
Result<void> flush_above(const std::string& path) {
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  if (!flush(parent.empty() ? "." : parent.string()))
    return system_error(path, "flush its directory");
  return {};
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
  return flush_above(path_);
}

Result<StagedFolder> StagedFolder::create(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  const std::string last = std::filesystem::path(path).filename().string();
  if (last.empty() || last == "." || last == "..")
    return fail("expected a folder by its own name, which it can be renamed to, got '{}'", path);
  std::error_code status;
  const auto kind = std::filesystem::symlink_status(path, status).type();
  if (kind == std::filesystem::file_type::symlink)
    return fail("{}: expected a folder that is empty or can be made, got a symbolic link", path);
  const bool is_free = kind == std::filesystem::file_type::not_found ||
                       (kind == std::filesystem::file_type::directory &&
                        std::filesystem::is_empty(path, status) && !status);
  if (!is_free)
    return fail("{}: expected a folder that is empty or can be made, got another", path);
  std::string folder = path + ".tmp-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr)
    return system_error(path, "make a temporary folder beside it");
  return StagedFolder(std::move(path), std::move(folder));
}

StagedFolder::~StagedFolder() {
  if (folder_.empty()) return;
  std::error_code status;
  std::filesystem::remove_all(folder_, status);
}

Result<void> StagedFolder::commit(const Progress& progress) {
  // A temporary folder is for its owner alone.
  const ::mode_t mask = ::umask(0);
  ::umask(mask);
  if (::chmod(folder_.c_str(), 0777 & ~mask) != 0) return system_error(path_, "set permissions");
  if (!flush_all(folder_)) return system_error(path_, "flush what was written");
  if (progress.is_cancelled()) return cancelled_error();
  if (::rename(folder_.c_str(), path_.c_str()) != 0)
    return system_error(path_, "rename into place");
  folder_.clear();
  return flush_above(path_);
}

}  // namespace lode
