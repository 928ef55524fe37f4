#include "lode/core/staged_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace lode {
namespace {

Error folder_error(const std::string& path, const char* action) {
  const std::error_code reason(errno, std::generic_category());
  return fail("{}: cannot {}: {}", path, action, reason.message());
}

std::string without_slash(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

/// Flushes the file system that a folder is on: many files at once.
bool flush_all(const std::string& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_flushed = ::syncfs(descriptor) == 0;
  ::close(descriptor);
  return is_flushed;
}

}  // namespace

Result<StagedFolder> StagedFolder::create(std::string path) {
  path = without_slash(std::move(path));
  std::error_code status;
  const auto kind = std::filesystem::status(path, status).type();
  const bool is_free = kind == std::filesystem::file_type::not_found ||
                       (kind == std::filesystem::file_type::directory &&
                        std::filesystem::is_empty(path, status) && !status);
  if (!is_free)
    return fail("{}: expected a folder that is empty or can be made, got another", path);
  std::string folder = path + ".tmp-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr)
    return folder_error(path, "make a temporary folder beside it");
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
  if (::chmod(folder_.c_str(), 0777 & ~mask) != 0) return folder_error(path_, "set permissions");
  if (!flush_all(folder_)) return folder_error(path_, "flush what was written");
  if (progress.is_cancelled()) return cancelled_error();
  if (::rename(folder_.c_str(), path_.c_str()) != 0)
    return folder_error(path_, "rename into place");
  folder_.clear();
  const std::string parent = std::filesystem::path(path_).parent_path().string();
  if (!flush_all(parent.empty() ? "." : parent)) return folder_error(path_, "flush its directory");
  return {};
}

}  // namespace lode
