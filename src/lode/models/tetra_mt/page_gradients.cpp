#include "lode/models/tetra_mt/page_gradients.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace lode::tetra_mt {
namespace {

/// One of a gradient's three numbers, along a page.
struct Course {
  int n_code_bits;
  std::uint32_t last;
  std::size_t n_bits = 0;  ///< Of the last difference, as many as codes have at most.
};

/// In place; wherever bytes lead.
template <typename Coder>
class GradientCoder {
 public:
  GradientCoder(Coder& coder, GradientModels& models) : coder_(coder), models_(models) {}

  std::uint32_t code(std::uint32_t given) {
    constexpr std::uint32_t kMost = (1U << kGradientBits) - 1;
    const std::uint32_t l =
        code_from(length_, models_.lengths[length_.n_bits], given >> (2 * kGradientBits));
    const std::uint32_t u = code_from(u_, models_.coordinates[0][u_.n_bits], given & kMost);
    const std::uint32_t v = code_from(v_, models_.coordinates[1][(u_.n_bits + v_.n_bits) / 2],
                                      given >> kGradientBits & kMost);
    is_valid_ =
        is_valid_ && l < 1U << kGradientLengthBits && u <= kGradientSteps && v <= kGradientSteps;
    return u | v << kGradientBits | l << (2 * kGradientBits);
  }
  [[nodiscard]] bool is_valid() const { return is_valid_; }

 private:
  std::uint32_t code_from(Course& course, NumberModel& model, std::uint32_t given) {
    if (!is_valid_) return 0;
    const std::int32_t step =
        unfolded(model.code(coder_, folded(static_cast<std::int32_t>(given - course.last))));
    course.last += static_cast<std::uint32_t>(step);
    const auto size = static_cast<std::uint32_t>(step < 0 ? -step : step);
    const auto n_bits = static_cast<int>(std::bit_width(size));
    course.n_bits = static_cast<std::size_t>(std::min(n_bits, course.n_code_bits));
    return course.last;
  }

  Coder& coder_;
  GradientModels& models_;
  Course length_{kGradientLengthBits, 1U << (kGradientLengthBits - 1)};
  Course u_{kGradientBits, kGradientSteps / 2};
  Course v_{kGradientBits, kGradientSteps / 2};
  bool is_valid_ = true;
};

}  // namespace

std::vector<std::byte> encode_gradients(std::span<const std::uint32_t> codes,
                                        GradientModels& models) {
  RangeWriter out;
  GradientCoder coder(out, models);
  for (const std::uint32_t code : codes) static_cast<void>(coder.code(code));
  LODE_EXPECTS(coder.is_valid());
  return std::move(out).take();
}

Result<std::vector<std::uint32_t>> decode_gradients(std::span<const std::byte> bytes, std::size_t n,
                                                    const std::string& what,
                                                    GradientModels& models) {
  RangeReader in(bytes);
  GradientCoder coder(in, models);
  std::vector<std::uint32_t> codes(n);
  for (std::uint32_t& code : codes) {
    code = coder.code(0);
    if (!coder.is_valid())
      return fail("{}: expected codes of directions up to {} and of lengths up to 255, got others",
                  what, kGradientSteps);
  }
  if (!in.is_at_end()) return fail("{}: expected as many bytes as were read", what);
  return codes;
}

}  // namespace lode::tetra_mt
