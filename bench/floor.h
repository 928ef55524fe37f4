#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/volume.h"

namespace lode::bench {

/// What an isosurface of full resolution cannot do without: the samples of all blocks of 32^3 cells
/// that it crosses are read once, and its bytes written once.
class Floor {
 public:
  Floor(const Volume& volume, double isovalue, std::uint64_t surface_bytes);

  void run(Threads threads);
  [[nodiscard]] std::uint64_t bytes_read() const { return active_.size() * sizeof(std::uint64_t); }
  [[nodiscard]] std::uint64_t bytes_written() const {
    return written_.size() * sizeof(std::uint64_t);
  }

 private:
  std::vector<std::uint64_t> active_;
  std::vector<std::uint64_t> written_;
  std::uint64_t sum_ = 0;  ///< So that reading is not left out.
};

}  // namespace lode::bench
