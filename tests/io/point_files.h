#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace lode::io::test {

struct LasPoint {
  std::array<std::int32_t, 3> at{};
  std::uint8_t of_class = 0;
  bool is_synthetic = false;
  bool is_withheld = false;
};

/// A LAS file's bytes, put together field by field from the specification's tables.
struct LasFile {
  int minor = 2;
  std::uint8_t format = 0;
  std::uint16_t n_record_bytes = 0;  ///< 0: what the format needs.
  std::array<double, 3> scale{0.01, 0.01, 0.01};
  std::array<double, 3> offset{500000, 4000000, 0};
  std::vector<LasPoint> points{};
  std::string wkt{};
  std::vector<std::uint16_t> geo_keys{};
  std::string extended_wkt{};  ///< Of LAS 1.4, behind the points.

  [[nodiscard]] std::string bytes() const {
    const std::size_t n_header = minor >= 4 ? 375 : 227;
    std::string records;
    if (!wkt.empty()) records += record(2112, wkt);
    if (!geo_keys.empty())
      records += record(
          34735, std::string(reinterpret_cast<const char*>(geo_keys.data()), 2 * geo_keys.size()));
    constexpr std::array<std::uint16_t, 11> kBytes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
    const std::uint16_t n_bytes = n_record_bytes > 0 ? n_record_bytes
                                  : format < 11      ? kBytes.at(format)
                                                     : std::uint16_t{20};
    std::string file(n_header, '\0');
    put(file, 0, std::array<char, 4>{'L', 'A', 'S', 'F'});
    put(file, 24, std::uint8_t{1});
    put(file, 25, static_cast<std::uint8_t>(minor));
    put(file, 94, static_cast<std::uint16_t>(n_header));
    put(file, 96, static_cast<std::uint32_t>(n_header + records.size()));
    put(file, 100, std::uint32_t{!wkt.empty()} + std::uint32_t{!geo_keys.empty()});
    put(file, 104, format);
    put(file, 105, n_bytes);
    put(file, minor >= 4 ? 247 : 107, static_cast<std::uint32_t>(points.size()));
    put(file, 131, scale);
    put(file, 155, offset);
    std::string data;
    for (const LasPoint& point : points) data += point_bytes(point, n_bytes);
    if (minor >= 4 && !extended_wkt.empty()) {
      put(file, 235, static_cast<std::uint64_t>(n_header + records.size() + data.size()));
      put(file, 243, std::uint32_t{1});
      std::string header(60, '\0');
      header.replace(2, 15, "LASF_Projection");
      put(header, 18, std::uint16_t{2112});
      put(header, 20, static_cast<std::uint64_t>(extended_wkt.size()));
      data += header + extended_wkt;
    }
    return file + records + data;
  }

  template <typename T>
  static void put(std::string& bytes, std::size_t at, const T& value) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
  }

 private:
  static std::string record(std::uint16_t id, const std::string& content) {
    std::string bytes(54, '\0');
    bytes.replace(2, 15, "LASF_Projection");
    put(bytes, 18, id);
    put(bytes, 20, static_cast<std::uint16_t>(content.size()));
    return bytes + content;
  }
  [[nodiscard]] std::string point_bytes(const LasPoint& point, std::size_t n) const {
    std::string bytes(n, '\0');
    put(bytes, 0, point.at);
    const bool is_new = format >= 6;
    const auto bit = [](bool is_set, int at) { return static_cast<std::uint8_t>(is_set << at); };
    if (is_new) {
      put(bytes, 15,
          static_cast<std::uint8_t>(bit(point.is_synthetic, 0) | bit(point.is_withheld, 2)));
      put(bytes, 16, point.of_class);
    } else {
      put(bytes, 15,
          static_cast<std::uint8_t>(point.of_class | bit(point.is_synthetic, 5) |
                                    bit(point.is_withheld, 7)));
    }
    return bytes;
  }
};

}  // namespace lode::io::test
