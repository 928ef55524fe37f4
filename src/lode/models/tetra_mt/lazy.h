#pragma once

#include <mutex>
#include <optional>

#include "lode/core/result.h"

namespace lode::tetra_mt {

/// What is made when it is first asked for, whoever asks; again where it could not be made.
template <typename T>
class Lazy {
 public:
  /// `make()`: a Result<T>. What comes stays as long as this.
  template <typename Make>
  [[nodiscard]] Result<const T*> get(const Make& make) {
    const std::scoped_lock lock(mutex_);
    if (!thing_) {
      LODE_TRY(thing_, make());
    }
    return &*thing_;
  }

 private:
  std::mutex mutex_;
  std::optional<T> thing_;
};

}  // namespace lode::tetra_mt
