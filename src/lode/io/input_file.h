#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "lode/core/result.h"

namespace lode::io {

/// Bytes moved so far on behalf of one volume, counted by the files and spools that move them.
struct IoTally {
  std::atomic<std::uint64_t> n_file_bytes_read{0};
  std::atomic<std::uint64_t> n_spool_bytes_written{0};
  std::atomic<std::uint64_t> n_spool_bytes_read{0};
};

using IoTallyPtr = std::shared_ptr<IoTally>;

/// A regular, non-empty file opened for reading at any offset. Shared by what reads from it.
class InputFile {
 public:
  /// Fails, naming `path`, when it is missing, unreadable, empty, or no regular file. What is read
  /// counts in `tally`, which the files of one volume share.
  [[nodiscard]] static Result<std::shared_ptr<const InputFile>> open(
      const std::string& path, IoTallyPtr tally = std::make_shared<IoTally>());

  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  ~InputFile();

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] const IoTallyPtr& tally() const { return tally_; }
  /// Bytes from `offset` to the end; 0 beyond it.
  [[nodiscard]] std::uint64_t size_from(std::uint64_t offset) const {
    return offset < size_ ? size_ - offset : 0;
  }
  /// Fills `out` from `offset`, or fails.
  [[nodiscard]] Result<void> read(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  InputFile(std::string path, IoTallyPtr tally)
      : path_(std::move(path)), tally_(std::move(tally)) {}

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  IoTallyPtr tally_;
};

using InputFilePtr = std::shared_ptr<const InputFile>;

/// What errno stands for.
[[nodiscard]] std::string system_message();

/// `name`, taken relative to the directory of the file `beside` unless it is absolute.
[[nodiscard]] std::string path_beside(const std::string& beside, const std::string& name);

}  // namespace lode::io
