// libFuzzer's mutations of .lode files, checksums made right again.
#include <cstring>

#include "tests/fuzz/lode_file_mutation.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  std::minstd_rand random(seed);
  constexpr unsigned kPlainShare = 8;
  if (random() % kPlainShare != 0) {
    const auto file = lode::fuzz::mutate_lode_file(std::as_bytes(std::span(data, size)), random,
                                                   LLVMFuzzerMutate);
    if (file && file->size() <= max_size) {
      std::memcpy(data, file->data(), file->size());
      return file->size();
    }
  }
  return LLVMFuzzerMutate(data, size, max_size);
}
