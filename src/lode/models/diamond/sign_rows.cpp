#include "lode/models/diamond/sign_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/sign_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kSamples = 32;  ///< Of a row.
constexpr std::size_t kCacheLine = 64;

template <typename T>
void run_signs(const SignRows<T>& rows, T threshold) {
  const hn::CappedTag<T, kSamples> d;
  const std::size_t lanes = hn::Lanes(d);
  const std::uint64_t lane_bits = (std::uint64_t{1} << lanes) - 1;
  const auto limit = hn::Set(d, threshold);
  for (std::int32_t z = 0; z < rows.n_slices; ++z)
    for (std::int32_t y = 0; y < rows.n_rows; ++y) {
      const auto row = static_cast<std::size_t>(y);
      const auto slice = static_cast<std::size_t>(z);
      const T* samples = rows.samples + row * rows.row_step + slice * rows.slice_step;
      // Boxes are too short for the processor to see where this goes.
      const auto* next = reinterpret_cast<const std::byte*>(samples + rows.next);
      for (std::size_t byte = 0; rows.next != 0 && byte < kSamples * sizeof(T); byte += kCacheLine)
        __builtin_prefetch(next + byte);
      std::uint64_t inside = 0;
      for (std::size_t x = 0; x < kSamples; x += lanes) {
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(d, hn::Not(hn::Lt(hn::LoadU(d, samples + x), limit)), bytes);
        std::uint64_t bits;
        std::memcpy(&bits, bytes, sizeof(bits));
        inside |= (bits & lane_bits) << x;
      }
      rows.words[row * rows.word_row_step + slice * rows.word_slice_step] =
          static_cast<std::uint32_t>(inside);
    }
}

void signs_u8(const SignRows<std::uint8_t>& rows, std::uint8_t t) { run_signs(rows, t); }
void signs_u16(const SignRows<std::uint16_t>& rows, std::uint16_t t) { run_signs(rows, t); }
void signs_i16(const SignRows<std::int16_t>& rows, std::int16_t t) { run_signs(rows, t); }
void signs_f32(const SignRows<float>& rows, float t) { run_signs(rows, t); }
void signs_f64(const SignRows<double>& rows, double t) { run_signs(rows, t); }

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(signs_u8);
HWY_EXPORT(signs_u16);
HWY_EXPORT(signs_i16);
HWY_EXPORT(signs_f32);
HWY_EXPORT(signs_f64);

void find_signs(const SignRows<std::uint8_t>& rows, std::uint8_t threshold) {
  HWY_DYNAMIC_DISPATCH(signs_u8)(rows, threshold);
}
void find_signs(const SignRows<std::uint16_t>& rows, std::uint16_t threshold) {
  HWY_DYNAMIC_DISPATCH(signs_u16)(rows, threshold);
}
void find_signs(const SignRows<std::int16_t>& rows, std::int16_t threshold) {
  HWY_DYNAMIC_DISPATCH(signs_i16)(rows, threshold);
}
void find_signs(const SignRows<float>& rows, float threshold) {
  HWY_DYNAMIC_DISPATCH(signs_f32)(rows, threshold);
}
void find_signs(const SignRows<double>& rows, double threshold) {
  HWY_DYNAMIC_DISPATCH(signs_f64)(rows, threshold);
}

}  // namespace lode::diamond
#endif
