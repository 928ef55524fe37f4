#pragma once

#include <stdexcept>
#include <utility>

#include "lode/api/dataset.h"

namespace lode::test {

/// In memory; throws where it cannot be built.
inline Dataset built_dataset(const Volume& volume) {
  Progress progress;
  const auto source = make_memory_source(volume);
  auto dataset = Dataset::build(*source, {.threads = {2}}, progress);
  if (!dataset) throw std::runtime_error(dataset.error().message);
  return std::move(*dataset);
}

}  // namespace lode::test
