#include "lode/render/image.h"

#include <gtest/gtest.h>
#include <png.h>

#include <filesystem>
#include <string>

namespace lode {
namespace {

Image make_gradient(int width, int height, std::uint8_t alpha) {
  Image image{.width = width, .height = height, .pixels = {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.pixels.push_back({static_cast<std::uint8_t>(x * 7), static_cast<std::uint8_t>(y * 5),
                              static_cast<std::uint8_t>(x ^ y), alpha});
    }
  }
  return image;
}

Image decode_png(const std::vector<std::byte>& bytes) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&header, bytes.data(), bytes.size()), 0)
      << static_cast<const char*>(header.message);
  header.format = PNG_FORMAT_RGBA;
  Image image{.width = static_cast<int>(header.width),
              .height = static_cast<int>(header.height),
              .pixels = std::vector<Color>(std::size_t{header.width} * header.height)};
  EXPECT_NE(png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr), 0)
      << static_cast<const char*>(header.message);
  return image;
}

int color_type_of(const std::vector<std::byte>& bytes) { return static_cast<int>(bytes.at(25)); }

TEST(png, reads_back_as_the_same_opaque_picture) {
  const Image image = make_gradient(37, 21, 255);
  const auto bytes = encode_png(image);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(decode_png(*bytes), image);
  EXPECT_EQ(color_type_of(*bytes), PNG_COLOR_TYPE_RGB);
}

TEST(png, keeps_transparency) {
  const Image image = make_gradient(5, 64, 100);
  const auto bytes = encode_png(image);
  ASSERT_TRUE(bytes) << bytes.error().message;
  EXPECT_EQ(decode_png(*bytes), image);
  EXPECT_EQ(color_type_of(*bytes), PNG_COLOR_TYPE_RGB_ALPHA);
}

TEST(png, holds_a_single_pixel) {
  const Image image = make_gradient(1, 1, 255);
  EXPECT_EQ(decode_png(*encode_png(image)), image);
}

TEST(png, is_written_whole_to_a_file) {
  const std::string path = testing::TempDir() + "lode_image_test.png";
  const Image image = make_gradient(30, 20, 255);
  ASSERT_TRUE(write_png(image, path));
  EXPECT_EQ(std::filesystem::file_size(path), encode_png(image)->size());
  std::filesystem::remove(path);
}

TEST(png, names_a_path_it_cannot_write) {
  const std::string path = testing::TempDir() + "no_such_directory/picture.png";
  const auto status = write_png(make_gradient(2, 2, 255), path);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("picture.png"), std::string::npos);
}

}  // namespace
}  // namespace lode
