#pragma once

#include <memory>
#include <string_view>

#include "lode/core/result.h"
#include "lode/render/image.h"

namespace lode {

/// Texts in pictures, by FreeType, in the font that Fontconfig has for "sans-serif".
class Lettering {
 public:
  /// `size`: of the font, pixels. Fails, saying what to install, where there is no font.
  [[nodiscard]] static Result<Lettering> open(int size);
  Lettering(Lettering&&) noexcept;
  Lettering& operator=(Lettering&&) noexcept;
  ~Lettering();

  /// Of UTF-8; what is none shows as a question mark.
  [[nodiscard]] int width(std::string_view text) const;
  /// How far digits and capitals reach above the line that they stand on.
  [[nodiscard]] int height() const;
  /// Writes from (x, y) on, where the line is that letters stand on; what is beyond the image is
  /// left out.
  void write(std::string_view text, int x, int y, Color color, Image& image) const;

 private:
  struct Impl;
  explicit Lettering(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Puts a colour over a pixel, which it covers so far, 0..1.
void blend(Color color, double coverage, Color& pixel);

}  // namespace lode
