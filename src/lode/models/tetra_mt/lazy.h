#pragma once

#include <mutex>
#include <optional>

#include "lode/core/result.h"

namespace lode::tetra_mt {

/// What is made when it is first asked for, whoever asks; also that it could not be made.
template <typename T>
class Lazy {
 public:
  /// `make()`: a Result<T>. What comes stays as long as this.
  template <typename Make>
  [[nodiscard]] Result<const T*> get(const Make& make) {
    const std::scoped_lock lock(mutex_);
    if (!thing_) thing_.emplace(make());
    if (!*thing_) return thing_->error();
    return &thing_->value();
  }

 private:
  std::mutex mutex_;
  std::optional<Result<T>> thing_;
};

}  // namespace lode::tetra_mt
