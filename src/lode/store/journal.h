#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "lode/core/result.h"

namespace lode::store {

/// A file of records for who may be killed: each is whole or not there. Compressed, checksummed,
/// and on disk when append() returns. One process at a time, and only on the machine that wrote it.
class Journal {
 public:
  /// An empty one; an earlier one of that name goes.
  [[nodiscard]] static Result<Journal> create(std::string path);
  /// Hands out the records of an earlier one, in order, up to the first that is not whole or for
  /// which take() says no; append() goes on behind the last one taken. Fails when take() does.
  using Take = std::function<Result<bool>(std::span<const std::byte>)>;
  [[nodiscard]] static Result<Journal> reopen(std::string path, const Take& take);

  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;
  ~Journal();

  [[nodiscard]] Result<void> append(std::span<const std::byte> record);
  /// Deletes the file.
  void remove();
  [[nodiscard]] std::uint64_t size() const { return size_; }

 private:
  Journal(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  [[nodiscard]] static Result<Journal> open(std::string path);
  [[nodiscard]] Result<void> replay(const Take& take);
  [[nodiscard]] Error system_error(const char* action) const;

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace lode::store
