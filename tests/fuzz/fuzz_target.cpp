// One fuzzer: LODE_HARNESS is the function that it feeds.
#include "tests/fuzz/harnesses.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lode::fuzz::LODE_HARNESS(std::as_bytes(std::span(data, size)));
  return 0;
}
