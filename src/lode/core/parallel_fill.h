#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/uninitialized_array.h"

namespace lode {

/// body(first, end) for pieces of 0 .. n, in parallel.
template <typename Body>
void for_each_piece(std::size_t n, Threads threads, const Body& body) {
  constexpr std::size_t kPiece = 1 << 16;
  parallel_for((n + kPiece - 1) / kPiece, threads, 1, [&](std::size_t piece, int) {
    body(piece * kPiece, std::min(n, (piece + 1) * kPiece));
  });
}

/// std::fill() by copying what has been filled, which needs no vectors to be fast.
template <typename T>
void fill_by_copies(T* first, std::size_t n, T value) {
  static_assert(sizeof(T) <= 64 && std::is_trivially_copyable_v<T>);
  constexpr std::size_t kBlock = 4096 / sizeof(T);
  std::size_t n_done = std::min<std::size_t>(n, 64 / sizeof(T));
  std::fill_n(first, n_done, value);
  while (n_done < n) {
    const std::size_t n_more = std::min({n_done, kBlock, n - n_done});
    std::memcpy(first + n_done, first, n_more * sizeof(T));
    n_done += n_more;
  }
}

/// Makes an array n elements long, all but the first n_kept of them `value`; large memory that is
/// new is slow to touch.
template <typename T>
void fill_anew(UninitializedArray<T>& array, std::size_t n_kept, std::size_t n, T value,
               Threads threads) {
  resize_anew(array, n);
  for_each_piece(n - n_kept, threads, [&](std::size_t first, std::size_t end) {
    fill_by_copies(array.data() + n_kept + first, end - first, value);
  });
}

template <typename T>
void fill_anew(UninitializedArray<T>& array, std::size_t n, T value, Threads threads) {
  fill_anew(array, 0, n, value, threads);
}

/// resize_large() whose new memory, of a vector that was empty, comes in with several threads:
/// setting what is there to zero takes a fraction of that.
template <typename T>
void resize_large(std::vector<T>& vector, std::size_t n, Threads threads) {
  constexpr std::size_t kPieceBytes = std::size_t{4} << 20;
  if (vector.empty() && n > vector.capacity()) {
    vector.reserve(n);
    auto* const memory = reinterpret_cast<std::byte*>(vector.data());
    const std::size_t n_bytes = n * sizeof(T);
    prefer_huge_pages(memory, n_bytes);
    parallel_for((n_bytes + kPieceBytes - 1) / kPieceBytes, threads, 1, [&](std::size_t i, int) {
      bring_in(memory + i * kPieceBytes, std::min(kPieceBytes, n_bytes - i * kPieceBytes));
    });
  }
  resize_large(vector, n);
}

}  // namespace lode
