#include "bench/floor.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

namespace lode::bench {
namespace {

constexpr std::int32_t kEdge = 32;

/// Appends the block's bytes to `bytes` where it has samples on both sides.
template <typename T>
void add_if_crossed(const Volume& volume, const Index3& block, double isovalue,
                    std::vector<std::byte>& bytes) {
  const Index3& dims = volume.info.grid.dims;
  Index3 lower;
  Index3 upper;
  for (std::size_t i = 0; i < 3; ++i) {
    lower[i] = block[i] * kEdge;
    upper[i] = std::min(lower[i] + kEdge + 1, dims[i]);
  }
  const T* const samples = reinterpret_cast<const T*>(volume.samples.data());
  const auto row = [&](std::int32_t y, std::int32_t z) {
    return samples + static_cast<std::ptrdiff_t>(
                         (static_cast<std::int64_t>(z) * dims[1] + y) * dims[0] + lower[0]);
  };
  const auto n = static_cast<std::size_t>(upper[0] - lower[0]);
  std::array<bool, 2> has{};
  for (std::int32_t z = lower[2]; z < upper[2]; ++z)
    for (std::int32_t y = lower[1]; y < upper[1]; ++y)
      for (std::size_t x = 0; x < n; ++x)
        has[static_cast<double>(row(y, z)[x]) >= isovalue ? 1 : 0] = true;
  if (!has[0] || !has[1]) return;
  for (std::int32_t z = lower[2]; z < upper[2]; ++z)
    for (std::int32_t y = lower[1]; y < upper[1]; ++y) {
      const auto* from = reinterpret_cast<const std::byte*>(row(y, z));
      bytes.insert(bytes.end(), from, from + n * sizeof(T));
    }
}

}  // namespace

Floor::Floor(const Volume& volume, double isovalue, std::uint64_t surface_bytes)
    : written_(surface_bytes / sizeof(std::uint64_t)) {
  const Index3& dims = volume.info.grid.dims;
  std::vector<std::byte> bytes;
  visit_scalar_type(volume.info.type, [&]<typename T>() {
    Index3 block;
    for (block[2] = 0; block[2] * kEdge + 1 < dims[2]; ++block[2])
      for (block[1] = 0; block[1] * kEdge + 1 < dims[1]; ++block[1])
        for (block[0] = 0; block[0] * kEdge + 1 < dims[0]; ++block[0])
          add_if_crossed<T>(volume, block, isovalue, bytes);
  });
  active_.resize(bytes.size() / sizeof(std::uint64_t));
  if (!active_.empty())
    std::memcpy(active_.data(), bytes.data(), active_.size() * sizeof(std::uint64_t));
}

void Floor::run(Threads threads) {
  constexpr std::size_t kPiece = 1 << 15;
  const auto n_pieces = [](std::size_t n) { return (n + kPiece - 1) / kPiece; };
  std::vector<std::uint64_t> sums(n_pieces(active_.size()));
  parallel_for(sums.size(), threads, 1, [&](std::size_t piece, int) {
    const std::size_t end = std::min(active_.size(), (piece + 1) * kPiece);
    std::uint64_t sum = 0;
    for (std::size_t i = piece * kPiece; i < end; ++i) sum += active_[i];
    sums[piece] = sum;
  });
  for (const std::uint64_t sum : sums) sum_ += sum;
  parallel_for(n_pieces(written_.size()), threads, 1, [&](std::size_t piece, int) {
    const std::size_t end = std::min(written_.size(), (piece + 1) * kPiece);
    std::fill(written_.begin() + static_cast<std::ptrdiff_t>(piece * kPiece),
              written_.begin() + static_cast<std::ptrdiff_t>(end), sum_);
  });
}

}  // namespace lode::bench
