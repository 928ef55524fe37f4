#include "lode/io/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace lode::io {

std::string system_message() { return std::generic_category().message(errno); }

Result<InputFilePtr> InputFile::open(const std::string& path, IoTallyPtr tally) {
  // O_NONBLOCK: opening a FIFO that nobody writes to must not wait.
  const std::shared_ptr<InputFile> file(new InputFile(path, std::move(tally)));
  file->descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file->descriptor_ < 0) return fail("{}: cannot be opened: {}", path, system_message());
  struct stat status {};
  if (::fstat(file->descriptor_, &status) != 0)
    return fail("{}: cannot be examined: {}", path, system_message());
  file->size_ = static_cast<std::uint64_t>(status.st_size);
  if (S_ISDIR(status.st_mode)) return fail("{}: expected a file, got a directory", path);
  if (!S_ISREG(status.st_mode)) return fail("{}: expected a regular file", path);
  if (file->size() == 0) return fail("{}: the file is empty (0 bytes)", path);
  return InputFilePtr(file);
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> InputFile::read(std::uint64_t offset, std::span<std::byte> out) const {
  if (size_from(offset) < out.size())
    return fail("{}: expected {} bytes from offset {}, but the file has only {} bytes", path_,
                out.size(), offset, size_);
  std::size_t done = 0;
  while (done < out.size()) {
    constexpr std::size_t kMaxRead = std::size_t{1} << 30;
    const ssize_t n = ::pread(descriptor_, out.data() + done, std::min(out.size() - done, kMaxRead),
                              static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail("{}: cannot be read: {}", path_, system_message());
    if (n == 0) return fail("{}: the file became shorter while it was read", path_);
    done += static_cast<std::size_t>(n);
    tally_->n_file_bytes_read += static_cast<std::uint64_t>(n);
  }
  return {};
}

std::string path_beside(const std::string& beside, const std::string& name) {
  return (std::filesystem::path(beside).parent_path() / name).string();
}

}  // namespace lode::io
